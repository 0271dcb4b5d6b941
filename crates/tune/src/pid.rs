//! PID gains for the weights of a design.
//!
//! The gains of [`squid_pid::Affine`] are tuned by [`squid_lpv::structured`]: for the smallest loop gain over frozen
//! speeds, then for the smallest proved loop gain for any trajectory of the speed. The reference weights in the
//! proportional terms are tuned too, as long as no gain depends on speed.

pub mod in_flight;

use crate::error::Error;
use crate::gain::{TunedGain, WEIGHTS, with_gains};
use crate::required::meeting;
use squid_base::numbers::decimals;
use squid_base::progress::Progress;
use squid_design::augment::augment;
use squid_design::error::{Error as DesignError, InputError};
use squid_design::fit::Model;
use squid_design::inputs::Inputs;
use squid_design::run::{Finished, run};
use squid_design::synthesise::given::structure;
use squid_lpv::analysis::given_loop;
use squid_lpv::controller::Controller;
use squid_lpv::matrix::Mat;
use squid_lpv::plant::GeneralisedPlant;
use squid_lpv::structured::{Structure, TunedDesign, tune};
use squid_pid::{Affine, Given, Law, Pid};
use toml_edit::{DocumentMut, Item};

/// Tuned PID.
#[derive(Debug)]
pub struct TunedPid {
    /// Text of the design file with the gains.
    pub text: String,
    /// Tuned gains.
    pub gains: Vec<TunedGain>,
    /// Largest loop gain over frozen speeds, for the gains of smallest proved loop gain, before the search for gains
    /// that meet the requirements.
    pub frozen_gain: f64,
    /// Loop gain of the same gains for any trajectory of speed.
    pub least_gain: f64,
    /// Duration of the search, s.
    pub seconds: f64,
    /// Finished design of that text.
    pub finished: Finished,
}

/// Number of starts of the search over gains.
const STARTS: usize = 8;

/// Size of the first gains: fraction of an actuator's reach commanded by a unit of y, of its integral or of its rate.
const FIRST: f64 = 0.3;

/// Tunes the gains of the PID of a design file, or of a first one, as polynomials in rho of a `degree` of 0 or 1.
///
/// # Errors
/// Errors of the stages; [`Error::NoPid`] if the file has no PID and a first one does not match the design.
pub fn tune_pid(inputs: &Inputs, text: &str, degree: usize, progress: &Progress) -> Result<TunedPid, Error> {
    let (pid, text) = begin(inputs, text)?;
    let model = Model::new(&inputs.axis(), &inputs.design)?;
    let plant = augment(&inputs.vehicle.actuators, &inputs.design, model.linear())?;
    let tuning = Tuning { inputs, pid: &pid, plant: &plant };
    let what = "gains of the PID at frozen speeds, then proved";
    let (found, seconds) = progress.timed("tune", what, || tuning.run(degree));
    let (gains, found) = found?;
    let line = format!(
        "gain {} at frozen speeds, {} for any trajectory of speed ({} s)",
        decimals(found.frozen_gain, 4),
        decimals(found.design.certified.gamma, 4),
        decimals(seconds, 0)
    );
    progress.done("tune", &line);
    let what = "gains that meet [require], evaluated at a few speeds";
    let (met, more) =
        progress.timed("tune", what, || meeting(inputs, &text, &gains, &|with| tuning.bound(with), progress));
    let mut sets = met?;
    sets.truncate(FINALISTS);
    if sets.is_empty() {
        sets.push(gains);
    }
    let judge = || finalist(inputs, &text, sets);
    let (text, gains, finished) = progress.timed("prove", "evaluating in full, and proving", judge).0?;
    let least_gain = found.design.certified.gamma;
    let seconds = seconds + more;
    Ok(TunedPid { text, gains, frozen_gain: found.frozen_gain, least_gain, seconds, finished })
}

/// Number of sets of gains that are fully evaluated.
const FINALISTS: usize = 3;

/// Returns the first set of gains that is proved and meets all requirements when fully evaluated, or else the set that
/// misses the fewest.
fn finalist(
    inputs: &Inputs,
    text: &str,
    sets: Vec<Vec<TunedGain>>,
) -> Result<(String, Vec<TunedGain>, Finished), Error> {
    let (mut best, mut failed) = (None, None);
    for gains in sets {
        let (text, changed) = with_gains(inputs, text, &gains)?;
        let finished = match run(&changed, &Progress::default()) {
            Ok(finished) => finished,
            Err(reason) => {
                failed = Some(reason);
                continue;
            }
        };
        let missed = finished.verdict.missed().count() + usize::from(finished.proof.is_err());
        if best.as_ref().is_none_or(|(least, _)| missed < *least) {
            best = Some((missed, (text, gains, finished)));
        }
        if missed == 0 {
            break;
        }
    }
    match (best, failed) {
        (Some((_, best)), _) => Ok(best),
        (None, Some(reason)) => Err(reason.into()),
        (None, None) => Err(Error::NoDesign { tried: 0, reason: String::new() }),
    }
}

/// Returns the PID to start from, and the text of the design file with it.
fn begin(inputs: &Inputs, text: &str) -> Result<(Pid, String), Error> {
    if let Some(pid) = &inputs.design.controller {
        return Ok((pid.clone(), text.to_owned()));
    }
    let refused = |reason: String| Error::NoPid { file: inputs.design.file.clone(), reason };
    if inputs.design.has_depth() {
        return Err(refused("a design that tracks depth requires [controller.depth]".into()));
    }
    let (pid, table) = first(inputs)?;
    let text = with_section(text, &table, inputs.design.axis);
    text.map(|text| (pid, text)).ok_or_else(|| refused("this is not a list of tables".into()))
}

/// Returns a first PID with gains of 1, and its table in a design file.
fn first(inputs: &Inputs) -> Result<(Pid, String), Error> {
    let refused = |reason: String| Error::NoPid { file: inputs.design.file.clone(), reason };
    let mut reason = String::new();
    for units in [["N.m/rad", "N.m/(rad.s)", "N.m.s/rad"], ["rad/rad", "rad/(rad.s)", "rad.s/rad"]] {
        let table = gains_of_one(inputs, units);
        let pid =
            squid_pid::read_file(&table, &inputs.design.file).map_err(|error| refused(error.to_string()))?;
        match structure(&inputs.vehicle.actuators, &inputs.design, &pid) {
            Ok(_) => return Ok((pid, table)),
            Err(error) => reason = error.to_string(),
        }
    }
    Err(refused(reason))
}

/// Returns the text of a design file with a table appended to it, or to one of its axes.
fn with_section(text: &str, table: &str, axis: Option<usize>) -> Option<String> {
    let Some(index) = axis else { return Some(format!("{}\n{table}", text.trim_end())) };
    let mut document: DocumentMut = text.parse().ok()?;
    let added: DocumentMut = table.parse().ok()?;
    let own = document.get_mut("axis")?.as_array_of_tables_mut()?.get_mut(index)?;
    for (key, item) in added.iter() {
        let mut item = item.clone();
        clear_positions(&mut item);
        own.insert(key, item);
    }
    Some(document.to_string())
}

/// Clears the positions that tables had in another text, so that they are written where they are inserted.
fn clear_positions(item: &mut Item) {
    let Some(table) = item.as_table_mut() else { return };
    table.set_position(None);
    table.iter_mut().for_each(|(_, item)| clear_positions(item));
}

/// Returns a table of gains of 1.
fn gains_of_one(inputs: &Inputs, [kp, ki, kd]: [&str; 3]) -> String {
    let design = &inputs.design;
    let gain = |key: &str, unit: &str| format!("{key} = {{ value = 1.0, unit = \"{unit}\" }}\n");
    let mut out =
        "\n# The gains were tuned by `squid tune --controller pid`.\n[controller]\nkind = \"pid\"\n"
            .to_owned();
    let angle = ["pitch", "heading", "roll"].into_iter().find(|angle| design.tracks(angle).is_some());
    let angle = angle.unwrap_or("pitch");
    out += &format!("\n[controller.{angle}]\n{}{}", gain("kp", kp), gain("ki", ki));
    if design.measured.iter().any(|measure| measure.signal.name == format!("{angle}_rate")) {
        out += &gain("kd", kd);
    }
    if design.tracks("depth").is_some() {
        out += &format!("\n[controller.depth]\n{}{}", gain("kp", "rad/m"), gain("ki", "rad/(m.s)"));
    }
    if design.tracks("speed").is_some() {
        out += &format!("\n[controller.speed]\n{}{}", gain("kp", "N.s/m"), gain("ki", "N/m"));
    }
    out
}

/// Gains and their design.
type Found = (Vec<TunedGain>, TunedDesign);

/// Reference weights of the angle and of the speed; `None` where they are fixed.
type Weights = [Option<f64>; 2];

struct Tuning<'a> {
    inputs: &'a Inputs,
    pid: &'a Pid,
    plant: &'a GeneralisedPlant,
}

impl Tuning<'_> {
    fn run(&self, degree: usize) -> Result<Found, Error> {
        let (mut weights, (mut gains, mut found)) = self.constant()?;
        let inside = weights.map(|weight| weight.map(|w| w.clamp(WEIGHTS[0], WEIGHTS[1])));
        if degree > 0 || inside != weights {
            weights = inside;
            (gains, found) = self.fixed(weights, degree, &gains)?;
        }
        for (of, weight) in [self.pid.turn.angle.name(), "speed"].into_iter().zip(weights) {
            let name = format!("{of}.reference_weight");
            let one = |w| TunedGain { name: name.clone(), unit: "1".into(), coefficients: vec![w] };
            gains.extend(weight.map(one));
        }
        Ok((gains, found))
    }

    /// Returns the cascade with the given reference weights and degree of the gains; only its matrices are used, not
    /// its gains.
    fn affine(&self, weights: [f64; 2], degree: usize) -> Result<Affine, InputError> {
        let mut pid = self.pid.clone();
        if pid.turn.model.is_none() {
            pid.turn.reference_weight = weights[0];
        }
        pid.speed.iter_mut().for_each(|speed| speed.reference_weight = weights[1]);
        let signs = structure(&self.inputs.vehicle.actuators, &self.inputs.design, self.pid)?;
        let sign = |axis: usize| signs.allocations.get(axis).map_or(1.0, |allocation| allocation.sign);
        for (axis, gains) in pid.gains_mut().into_iter().take(2).enumerate() {
            gains.into_iter().for_each(|gain| constant(gain, sign(axis), degree));
        }
        Ok(structure(&self.inputs.vehicle.actuators, &self.inputs.design, &pid)?.affine())
    }

    /// Tunes constant gains, and the reference weights of the angle and of the speed where they are free.
    fn constant(&self) -> Result<(Weights, Found), Error> {
        let (without, with) = (self.affine([0.0; 2], 0)?, self.affine([1.0; 2], 0)?);
        let mut directions: Vec<Mat> = without.directions.iter().map(|one| one.matrix.clone()).collect();
        let mut start = self.start(&without, &[]);
        let mut weighted = vec![];
        for (i, (one, other)) in without.directions.iter().zip(&with.directions).enumerate() {
            let difference = &other.matrix - &one.matrix;
            if difference.amax() > 0.0 {
                weighted.push((i, directions.len()));
                start.push(start[i] * FIRST);
                directions.push(difference);
            }
        }
        let (values, found) = self.tuned(&without, directions, &start)?;
        let weight = |axis: &str| {
            let of_axis = |(i, _): &&(usize, usize)| without.directions[*i].name.starts_with(axis);
            weighted.iter().find(of_axis).map(|(i, j)| values[*j] / values[*i])
        };
        Ok(([weight(self.pid.turn.angle.name()), weight("speed")], (gains(&without, &values), found)))
    }

    /// Tunes gains of a degree with given reference weights, from known gains.
    fn fixed(&self, weights: Weights, degree: usize, known: &[TunedGain]) -> Result<Found, Error> {
        let affine = self.affine(weights.map(|weight| weight.unwrap_or(0.0)), degree)?;
        let directions = affine.directions.iter().map(|one| one.matrix.clone()).collect();
        let (values, found) = self.tuned(&affine, directions, &self.start(&affine, known))?;
        Ok((gains(&affine, &values), found))
    }

    /// Returns the loop gain of a given PID for any trajectory of speed.
    fn bound(&self, with: &Inputs) -> Option<f64> {
        let pid = with.design.controller.as_ref()?;
        let controller = structure(&with.vehicle.actuators, &with.design, pid).ok()?.controller();
        Some(given_loop(&self.plant.close(&controller)).ok()?.gamma)
    }

    fn tuned(
        &self,
        affine: &Affine,
        directions: Vec<Mat>,
        start: &[f64],
    ) -> Result<(Vec<f64>, TunedDesign), Error> {
        let [states, y, u] = affine.sizes;
        let base = Controller::from_matrix(&affine.base, states, y, u, affine.blocks.clone());
        let of_design = |error| Error::Design(DesignError::Synthesis(error));
        let structure = Structure::new(base, directions).map_err(|error| of_design(error.into()))?;
        let found = tune(self.plant, &structure, start, STARTS).map_err(of_design)?;
        Ok((found.gains.clone(), found))
    }

    /// Returns the first values of the coefficients: known ones, those of the file, or defaults.
    fn start(&self, affine: &Affine, known: &[TunedGain]) -> Vec<f64> {
        let given = self.inputs.design.controller.as_ref();
        let given = given.and_then(|pid| {
            structure(&self.inputs.vehicle.actuators, &self.inputs.design, pid).ok().map(|found| found.gains)
        });
        let of_file = |name: &str, power: usize| {
            let gain = given.as_ref()?.iter().find(|gain| gain.name == name)?;
            Some(gain.coefficients.get(power).copied().unwrap_or(0.0))
        };
        let of_known = |name: &str, power: usize| {
            let gain = known.iter().find(|gain| gain.name == name)?;
            Some(gain.coefficients.get(power).copied().unwrap_or(0.0))
        };
        let first = |one: &squid_pid::Direction| {
            if one.power > 0 { 0.0 } else { one.value.signum() * FIRST / one.matrix.amax() }
        };
        let value = |one: &squid_pid::Direction| {
            of_known(&one.name, one.power)
                .or_else(|| of_file(&one.name, one.power))
                .unwrap_or_else(|| first(one))
        };
        affine.directions.iter().map(value).collect()
    }
}

/// Replaces a gain by one of the given sign with all powers of rho up to a degree.
fn constant(gain: &mut Given, sign: f64, degree: usize) {
    gain.law = Law::Polynomial([1.0, 0.5][..=degree].iter().map(|one| sign * one).collect());
}

/// Returns the gains with their coefficients.
fn gains(affine: &Affine, values: &[f64]) -> Vec<TunedGain> {
    let mut all: Vec<TunedGain> = vec![];
    for (one, value) in affine.directions.iter().zip(values) {
        if one.power == 0 {
            let (name, unit) = (one.name.clone(), one.unit.clone());
            all.push(TunedGain { name, unit, coefficients: vec![] });
        }
        if let Some(gain) = all.iter_mut().find(|gain| gain.name == one.name) {
            gain.coefficients.push(*value);
        }
    }
    all
}
