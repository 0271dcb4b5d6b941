//! PID gains for flights that the caller simulates and evaluates.
//!
//! Each gain is `g (1 + s rho)`. One descent (`descend`) from each of several first gains changes every g and the
//! reference weights; further descents from the best change the slopes s as well. The result does not depend on the
//! clock or the number of processors.

use crate::candidate::{Attempt, Candidate, FAILED_COST, REQUIRED_MARGIN, merit};
use crate::descent::descend;
use crate::direction::Direction;
use crate::error::Error;
use crate::gain::WEIGHTS;
use crate::pid::first;
use rayon::prelude::*;
use squid_design::axis::{Linearisation, VehicleModel};
use squid_design::inputs::Inputs;
use squid_design::synthesise::given::structure;
use squid_lpv::weights::ReferenceModel;
use squid_pid::{Given, Law, Pid};

/// Frequencies of the loops with the first gains, relative to those of the reference models.
const GUESSES: [f64; 3] = [0.7, 1.2, 2.0];
/// First step and number of attempts of a descent from first gains.
const FROM_GUESS: (f64, usize) = (0.4, 50);
/// First step and number of attempts of each descent from the best gains, in sequence.
const FROM_BEST: [(f64, usize); 6] = [(0.3, 80), (0.2, 60), (0.3, 80), (0.1, 60), (0.2, 80), (0.05, 60)];
/// Frequency of the pitch loop relative to the depth loop around it.
const INNER: f64 = 4.0;
/// Largest slope of a gain.
const STEEPEST: f64 = 0.95;

/// Evaluation of gains by a flight.
#[derive(Debug, Clone, PartialEq)]
pub struct Judged {
    /// Cost to be minimised.
    pub cost: f64,
    /// Margins that must not be negative.
    pub margins: Vec<f64>,
}

/// Searches for the PID of least cost for the signals of a design. Returns the cost and the PID; `None` if all PIDs
/// tried have a negative margin. `judge` simulates a flight and returns its cost and `margins` margins, or `None` if
/// the vehicle is lost.
///
/// # Errors
/// [`Error::NoPid`]; errors of trim and linearisation.
pub fn tune_in_flight(
    inputs: &Inputs,
    margins: usize,
    judge: &(dyn Fn(&Pid) -> Option<Judged> + Sync),
) -> Result<Option<(f64, Pid)>, Error> {
    let (pid, _) = first(inputs)?;
    let attempt = |from: &Pid, x: &[f64]| {
        let tried = judge(&moved(from, x)).map_or_else(
            || Candidate::failed(x, margins),
            |Judged { cost, margins }| Candidate {
                x: x.to_vec(),
                cost: cost.min(FAILED_COST),
                margins: margins.into_iter().map(|margin| margin + REQUIRED_MARGIN).collect(),
                ..Candidate::failed(x, 0)
            },
        );
        Attempt { tried, failed: None }
    };
    let descent = |from: &Pid, start: &Candidate, slopes: bool, (step, attempts): (f64, usize)| {
        let moves = directions(from, slopes);
        descend(start, &moves, step, attempts, &|x| attempt(from, x), &mut vec![])
    };
    let from_guess = |factor: &f64| -> Result<(Pid, Candidate), Error> {
        let from = guess(inputs, &pid, *factor)?;
        let start = attempt(&from, &vec![0.0; directions(&from, true).len()]).tried;
        let best = descent(&from, &start, false, FROM_GUESS);
        Ok((from, best))
    };
    let found = GUESSES.par_iter().map(from_guess).collect::<Result<Vec<_>, Error>>()?;
    let best = found.into_iter().min_by(|(_, a), (_, b)| merit(a).total_cmp(&merit(b)));
    let Some((from, mut best)) = best else { return Ok(None) };
    for round in FROM_BEST {
        best = descent(&from, &best, true, round);
    }
    Ok((merit(&best) < FAILED_COST).then(|| (best.cost, moved(&from, &best.x))))
}

/// Returns one direction per coordinate of a PID: for each gain the logarithm of a factor and, if it depends on speed
/// and `slopes` is set, the increment of its slope; then the increments of the reference weights.
fn directions(pid: &Pid, slopes: bool) -> Vec<Direction> {
    let mut is_slope = vec![];
    for gain in pid.clone().gains_mut().into_iter().flatten() {
        is_slope.push(false);
        is_slope.extend(scheduled(gain).then_some(true));
    }
    is_slope.extend([false].repeat(1 + usize::from(pid.speed.is_some())));
    let kept = is_slope.into_iter().enumerate().filter(|(_, slope)| slopes || !slope);
    kept.map(|(i, _)| Direction(vec![i])).collect()
}

fn scheduled(gain: &Given) -> bool {
    matches!(&gain.law, Law::Polynomial(all) if all.len() > 1)
}

/// Returns the PID at given coordinates.
fn moved(from: &Pid, x: &[f64]) -> Pid {
    let mut pid = from.clone();
    let mut x = x.iter().copied();
    let mut next = || x.next().unwrap_or_default();
    for gain in pid.gains_mut().into_iter().flatten() {
        if let Law::Polynomial(all) = &mut gain.law {
            let (constant, factor) = (all[0], next().exp());
            all[0] *= factor;
            if let Some(slope) = all.get_mut(1) {
                *slope = (*slope / constant + next()).clamp(-STEEPEST, STEEPEST) * constant * factor;
            }
        }
    }
    let of_speed = pid.speed.as_mut().map(|speed| &mut speed.reference_weight);
    for weight in std::iter::once(&mut pid.turn.reference_weight).chain(of_speed) {
        *weight = (*weight + next()).clamp(WEIGHTS[0], WEIGHTS[1]);
    }
    pid
}

/// Returns first gains: they place the poles near the frequencies of the reference models times a factor, with the
/// accelerations per unit command at both ends of the speed range.
fn guess(inputs: &Inputs, pid: &Pid, factor: f64) -> Result<Pid, Error> {
    let (actuators, design) = (&inputs.vehicle.actuators, &inputs.design);
    let allocations = structure(actuators, design, pid)?.allocations;
    let ends = [design.speed_min, design.speed_max].map(|speed| inputs.axis().linearise(speed));
    let [low, high] = ends;
    let ends = [low?, high?];
    let accelerations = |command: usize, signal: &str| {
        let signal = design.interface.signals.iter().find(|one| one.name == signal);
        ends.each_ref().map(|l: &Linearisation| {
            let row = l.states.iter().position(|state| signal.is_some_and(|one| one.output(state) != 0.0));
            let outputs = allocations.get(command).map_or(&[][..], |one| &one.outputs);
            row.map_or(1.0, |row| outputs.iter().enumerate().map(|(j, output)| l.b[(row, j)] * output).sum())
        })
    };
    let frequency = |name: &str| {
        let model = design.tracks(name).and_then(|index| design.tracked[index].model);
        factor * model.map_or(1.0, |ReferenceModel { frequency, .. }| frequency)
    };
    let mut pid = pid.clone();
    pid.turn.reference_weight = 0.7;
    let angle = pid.turn.angle.name();
    let deep = frequency("depth");
    let w = if pid.depth.is_some() { INNER * deep } else { frequency(angle) };
    let v = frequency("speed");
    let steep = deep / design.scheduling().0;
    let over_speed = |[low, high]: [f64; 2]| Law::Polynomial(vec![0.5 * (low + high), 0.5 * (high - low)]);
    let of_command = |gains: Vec<&mut Given>, accelerations: [f64; 2], targets: &[f64]| {
        for (gain, target) in gains.into_iter().zip(targets) {
            gain.law = over_speed(accelerations.map(|one| target / one));
        }
    };
    let [turn, speed, depth] = pid.gains_mut();
    of_command(turn, accelerations(0, &format!("{angle}_rate")), &[w * w, 0.3 * w * w * w, 2.0 * w]);
    of_command(speed, accelerations(1, "speed"), &[v, 0.2 * v * v]);
    for (gain, target) in depth.into_iter().zip([steep, 0.1 * deep * steep]) {
        gain.law = Law::Polynomial(vec![target]);
    }
    Ok(pid)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn read(vehicle: &str, name: &str, axis: Option<&str>) -> Inputs {
        let vehicles = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../vehicles");
        Inputs::read_axis(&vehicles.join(vehicle), name, axis).unwrap()
    }

    fn coefficients(gain: &Given) -> [f64; 2] {
        let Law::Polynomial(all) = &gain.law else { panic!("{gain:?}") };
        [all[0], all[1] / all[0]]
    }

    /// Gains for a cost whose known minimum is beyond a limit are found at that limit, with the slope of the minimum.
    #[test]
    fn finds_least_cost_within_limit() {
        let inputs = read("squid", "design", None);
        let first = guess(&inputs, &first(&inputs).unwrap().0, 1.2).unwrap();
        let known = coefficients(&first.turn.kp)[0];
        let judge = |pid: &Pid| {
            let [constant, slope] = coefficients(&pid.turn.kp);
            let (factor, slope) = ((constant / known).ln(), slope - 0.2);
            let weight = pid.turn.reference_weight - 0.5;
            let cost = (factor - 0.8).powi(2) + slope.powi(2) + weight.powi(2);
            Some(Judged { cost, margins: vec![0.5 - factor] })
        };
        let (cost, pid) = tune_in_flight(&inputs, 1, &judge).unwrap().unwrap();
        let [constant, slope] = coefficients(&pid.turn.kp);
        assert!(constant <= known * 0.5f64.exp() && constant > known * 0.4f64.exp(), "{constant} {known}");
        assert!((slope - 0.2).abs() < 0.1 && cost < 0.17, "{slope} {cost}");
        let missed = |_: &Pid| Some(Judged { cost: 1.0, margins: vec![-0.1] });
        assert_eq!(tune_in_flight(&inputs, 1, &missed).unwrap(), None);
    }

    /// First gains match the signals of each axis; those of planes fall with the square of the forward speed.
    #[test]
    fn first_gains_match_each_axis() {
        for (vehicle, name, axis) in [
            ("squid", "design", None),
            ("squid", "heading", Some("heading")),
            ("remus100", "pitch", None),
            ("remus100", "design", Some("depth")),
            ("remus100", "design", Some("heading")),
        ] {
            let inputs = read(vehicle, name, axis);
            let pid = guess(&inputs, &first(&inputs).unwrap().0, 1.0).unwrap();
            let cascade = structure(&inputs.vehicle.actuators, &inputs.design, &pid);
            assert!(cascade.is_ok(), "{vehicle} {name}: {cascade:?}");
        }
        let inputs = read("remus100", "pitch", None);
        let pid = guess(&inputs, &first(&inputs).unwrap().0, 1.0).unwrap();
        let [constant, slope] = coefficients(&pid.turn.kp);
        let [low, high] = [constant * (1.0 - slope), constant * (1.0 + slope)];
        let forward = |speed: f64| inputs.axis().at(speed).unwrap().trim.forward_speed;
        let squares = (forward(inputs.design.speed_max) / forward(inputs.design.speed_min)).powi(2);
        assert!((low / high / squares - 1.0).abs() < 1e-6, "{low} {high}");
    }
}
