//! Designs of the shipped vehicles, each computed once.

use squid_auv::toml_file::{FileError, Mistake};
use squid_base::progress::Progress;
use squid_design::augment::augment;
use squid_design::certify::certify;
use squid_design::fit::Model;
use squid_design::inputs::Inputs;
use squid_design::inputs::design_file::WorkingSea;
use squid_design::store::{Stored, load};
use squid_design::synthesise::synthesise;
use squid_flight::sea::WaveParameters;
use squid_lpv::plant::GeneralisedPlant;
use squid_lpv::synthesis::Design;
use squid_proof::claim::Proof;
use squid_sea::{Spectrum, Waves};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Mutex, OnceLock};

/// Design up to its controller, with its inputs.
pub struct Made {
    pub inputs: Inputs,
    pub model: Model,
    pub plant: GeneralisedPlant,
    pub design: Design,
}

impl Made {
    pub fn of(inputs: Inputs) -> Self {
        let (actuators, design) = (&inputs.vehicle.actuators, &inputs.design);
        let model = Model::new(&inputs.axis(), design).unwrap();
        let plant = augment(actuators, design, model.linear()).unwrap();
        let design = synthesise(actuators, design, &plant, &Progress::default()).unwrap();
        Self { inputs, model, plant, design }
    }

    /// Computes the default design of a vehicle with a delay of its commands (s).
    pub fn with_delay(name: &str, delay: f64) -> Self {
        let mut inputs = inputs(name);
        inputs.design.delay = delay;
        Self::of(inputs)
    }

    /// Computes the default design without delay, in waves of 1 m at a depth of one metre, with weight 5.
    pub fn at_sea(name: &str) -> Self {
        let spectrum = Spectrum::jonswap(1.0, 6.0, 3.3).unwrap();
        let waves = WaveParameters { spectrum, heading: std::f64::consts::PI, components: Waves::USUAL };
        let mut inputs = inputs(name);
        inputs.design.sea = Some(WorkingSea { depth: 1.0, waves, weight: 5.0 });
        Self::of(inputs)
    }

    pub fn proof(&self) -> Proof {
        let Self { inputs, model, plant, design } = self;
        certify(&inputs.axis(), &inputs.design, model, plant, design).unwrap().0
    }
}

/// Reads the input files of a vehicle with a design of pitch.
pub fn inputs(name: &str) -> Inputs {
    let pitch =
        Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../vehicles")).join(name).join("pitch.toml");
    read(name, if pitch.exists() { "pitch" } else { "design" })
}

/// Reads the input files of one of its designs.
pub fn read(name: &str, design: &str) -> Inputs {
    let vehicles = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../vehicles"));
    Inputs::read(&vehicles.join(name), design).unwrap()
}

/// Reads the input files of an axis of a vehicle: of its default design, or of `heading.toml`.
pub fn read_axis(name: &str, axis: &str) -> Inputs {
    let vehicle = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../vehicles")).join(name);
    let all = ["design", "heading"].into_iter().filter(|name| vehicle.join(format!("{name}.toml")).exists());
    let mut all = all.flat_map(|name| Inputs::read_axes(&vehicle, name).unwrap());
    all.find(|inputs| inputs.design.steered_signal() == axis).unwrap()
}

/// Loads the committed design of Squid.
pub fn committed() -> (Inputs, Stored) {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../vehicles/squid/frozen"));
    let inputs = inputs("squid");
    let stored = load(folder, &inputs).unwrap();
    (inputs, stored)
}

/// Returns the default design of a vehicle, computed at first use.
pub fn made(name: &'static str) -> &'static Made {
    static MADE: Mutex<BTreeMap<&str, &OnceLock<Made>>> = Mutex::new(BTreeMap::new());
    let cell: &'static OnceLock<Made> =
        MADE.lock().unwrap().entry(name).or_insert_with(|| Box::leak(Box::default()));
    cell.get_or_init(|| Made::of(inputs(name)))
}

/// Checks line and key of the only mistake in a file, and returns its message below what caused it.
#[track_caller]
pub fn message(what: &str, error: &FileError, place: (usize, &str)) -> String {
    let [Mistake { line, problem }] = &error.mistakes[..] else { panic!("{error}") };
    assert_eq!((*line, problem.key().unwrap_or_default()), place, "{error}");
    format!("{what}:\n{problem}")
}
