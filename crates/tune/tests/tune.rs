//! Advice holds when it is followed; a design is begun from the vehicle alone.
#![allow(clippy::unwrap_used, missing_docs)]

use squid_design::fit::Model;
use squid_design::inputs::Inputs;
use squid_design::inputs::design_file::DesignFile;
use squid_design::progress::Progress;
use squid_design::run::run;
use squid_design::verdict::row::Outcome;
use squid_tune::advise::{Turn, advise};
use squid_tune::error::Error;
use squid_tune::knob::Knob;
use squid_tune::start::start;
use std::path::{Path, PathBuf};

fn vehicles() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../vehicles")
}

/// The paper's tuning of Squid, which has three keys and misses mu: what is advised, followed in a design of its own,
/// lowers that.
#[test]
fn advice_holds_when_it_is_followed() {
    let inputs = Inputs::read(&vehicles().join("squid"), "paper").unwrap();
    let mu = |inputs: &Inputs| {
        let verdict = run(inputs, &Progress::default()).unwrap().verdict;
        let row = verdict.rows.iter().find(|row| row.key == "mu").unwrap().clone();
        (verdict, row)
    };
    let (verdict, before) = mu(&inputs);
    assert_eq!(before.outcome, Outcome::Missed, "{verdict}");
    let advice = advise(&inputs, &verdict, &Progress::default()).unwrap();
    assert_eq!(advice.len(), verdict.missed().count());
    let told = advice.iter().find(|advice| advice.what.starts_with("mu of")).unwrap();
    let Turn { knob, key, factor } = told.turn.clone().unwrap();
    let words = told.to_string();
    assert!(words.contains(if factor > 1.0 { "raise " } else { "lower " }), "{words}");
    assert!(words.contains(&key), "{words}");
    let mut turned = inputs.clone();
    knob.turn(&mut turned.design, factor);
    let (_, after) = mu(&turned);
    assert!(after.achieved.value < before.achieved.value, "{words}: {before:?} {after:?}");
}

/// From four of the shipped vehicles at least, and with a reason for any other, a file begins that can be read, whose
/// range the vehicle trims in, and that names its keys.
#[test]
fn a_design_begins_from_the_vehicle_alone() {
    let mut begun = 0;
    for folder in std::fs::read_dir(vehicles()).unwrap() {
        let file = folder.unwrap().path().join("vehicle.toml");
        if !file.is_file() {
            continue;
        }
        let vehicle = auv::Vehicle::parse(&auv::read_text(&file).unwrap(), "vehicle.toml").unwrap();
        let text = match start(&vehicle) {
            Ok(text) => text,
            Err(Error::NoRange { vehicle: named, .. } | Error::NoAuthority { vehicle: named, .. }) => {
                assert_eq!(named, vehicle.name);
                continue;
            }
            Err(reason) => panic!("{}: {reason}", file.display()),
        };
        let design = DesignFile::parse(&text, "design.toml", "design").unwrap();
        let inputs = Inputs::new(vehicle, design).unwrap();
        Model::new(&inputs.vehicle, &inputs.design).unwrap();
        assert_eq!(Knob::all(&inputs.design).len(), 9);
        begun += 1;
    }
    assert!(begun >= 4, "{begun}");
}
