//! Speed range of a first design: the widest in which the vehicle has actuator margin in level flight, trims on one
//! branch, can hold a pitch angle, is not too unstable for its actuators, and has similar control authority.

use crate::error::Error;
use crate::knob::three_digits;
use squid_auv::longitudinal::turning;
use squid_auv::{Linearisation, Pitch, Speed, Vehicle, linearise, trim_with, trims};
use squid_design::axis::Linearisation as Linear;
use squid_design::fit::authority::holding_ratio;
use squid_design::fit::frequency::system;
use squid_design::linearise::stacked;

/// Depth of the trims, m.
pub(crate) const DEPTH: f64 = 50.0;
/// Largest fraction of an actuator's limit that level flight may use.
pub(crate) const TRIM_FRACTION: f64 = 0.6;
/// Pitch step as a fraction of the pitch that the actuators can hold.
const HELD_FRACTION: f64 = 0.35;
/// Largest pitch step, deg.
const LARGEST_PITCH: f64 = 10.0;
/// Smallest pitch step, deg.
const SMALLEST_PITCH: f64 = 3.0;
/// Highest speed tried, m/s.
const HIGHEST_SPEED: f64 = 5.0;
/// Spacing of the speeds tried, m/s.
const SPEED_STEP: f64 = 0.05;
/// Largest incidence, deg.
const MAX_INCIDENCE: f64 = 10.0;
/// Largest ratio of the speeds in a range: forces grow with the square of the speed.
const MAX_SPEED_RATIO: f64 = 6.0;
/// Largest ratio of the pitch authorities in a range.
const MAX_AUTHORITY_RATIO: f64 = 5.0;
/// Initial acceleration of a step as a fraction of the largest that the actuators can produce.
pub(crate) const ACCELERATION_FRACTION: f64 = 0.5;
/// Frequency of the fastest reference model times the lag of the slowest actuator.
pub(crate) const FREQUENCY_TIMES_LAG: f64 = 0.35;
/// Largest frequency of the pitch model, rad/s.
const FASTEST_PITCH: f64 = 1.75;
/// Largest growth rate of an unstable mode times the lag of the main pitch actuator.
const MAX_GROWTH_TIMES_LAG: f64 = 0.12;

/// Control authority at a speed that level flight leaves.
#[derive(Debug, Clone)]
pub(crate) struct Authority {
    /// Speed along the path, m/s.
    pub speed: f64,
    /// Pitch step, deg: [`HELD_FRACTION`] of the pitch that the actuators can hold.
    pub pitch: f64,
    /// Surge acceleration, m/s2; `None` if the speed is imposed.
    pub surge: Option<f64>,
    /// Pitch acceleration, rad/s2.
    pub turn: f64,
    /// Lag of the main pitch actuator, s.
    pub lag: f64,
    /// Growth rate of the least stable mode, 1/s; 0 if all decay.
    pub growth: f64,
    /// Rule for the pitch in level trim.
    rule: Pitch,
    linear: Linearisation,
    /// Remaining range of each actuator in level flight, N or rad.
    remaining: Vec<f64>,
}

/// Reason why a speed is unsuitable, as text that follows "at ... m/s".
type Reason = String;

/// Returns the control authority over the widest speed range.
///
/// # Errors
/// [`Error::NoRange`], with the reasons at some speeds.
pub(crate) fn range(vehicle: &Vehicle) -> Result<Vec<Authority>, Error> {
    let count = (HIGHEST_SPEED / SPEED_STEP).round() as usize;
    let speeds = (0..=count).map(|i| three_digits(SPEED_STEP * i as f64));
    let tried: Vec<(f64, Result<Authority, Reason>)> =
        speeds.map(|speed| (speed, Authority::of(vehicle, speed))).collect();
    let (mut best, mut run): (&[Authority], Vec<Authority>) = (&[], vec![]);
    let mut runs: Vec<Vec<Authority>> = vec![];
    for (_, authority) in &tried {
        let connects =
            |authority: &Authority| run.last().is_none_or(|last| last.connects_to(vehicle, authority));
        match authority {
            Ok(authority) if connects(authority) => run.push(authority.clone()),
            other => {
                runs.push(std::mem::take(&mut run));
                run.extend(other.iter().cloned());
            }
        }
    }
    runs.push(run);
    for window in runs.iter().map(|run| widest(run, fastest(vehicle))) {
        if window.len() >= best.len() {
            best = window;
        }
    }
    if best.len() > 1 {
        return Ok(best.to_vec());
    }
    let rejected = tried.iter().filter_map(|(speed, authority)| Some((*speed, authority.as_ref().err()?)));
    let reasons: Vec<String> = SPEEDS_WITH_REASONS
        .iter()
        .filter_map(|shown| rejected.clone().find(|(speed, _)| speed >= shown))
        .map(|(speed, reason)| format!("at {speed} m/s {reason}"))
        .collect();
    Err(Error::NoRange {
        vehicle: vehicle.name.clone(),
        from: 0.0,
        to: HIGHEST_SPEED,
        reasons: reasons.join("; "),
    })
}

/// Speeds whose reasons are reported if there is no range, m/s.
const SPEEDS_WITH_REASONS: [f64; 3] = [0.5, 1.0, 2.0];

/// Returns the minimum over the speeds.
pub(crate) fn least(range: &[Authority], of: impl Fn(&Authority) -> f64) -> f64 {
    range.iter().map(of).fold(f64::INFINITY, f64::min)
}

/// Returns the largest model frequency that the actuator lags allow, rad/s.
pub(crate) fn fastest(vehicle: &Vehicle) -> f64 {
    FREQUENCY_TIMES_LAG / vehicle.actuators.iter().map(|a| a.lag).fold(0.0, f64::max)
}

/// Returns the frequency of the pitch model in a range, rad/s; `fastest` is the limit from the lags.
pub(crate) fn pitch_frequency(range: &[Authority], fastest: f64) -> f64 {
    let scale = least(range, |r| r.pitch).to_radians();
    (ACCELERATION_FRACTION * least(range, |r| r.turn) / scale).sqrt().min(fastest).min(FASTEST_PITCH)
}

/// Returns the longest part of a run with similar authority and speed.
///
/// The authority at the start of a step is the pitch acceleration. At the model frequency it includes the effect of
/// heave on pitch, which may be much larger than the direct effect of the actuators.
fn widest(run: &[Authority], fastest: f64) -> &[Authority] {
    let close = |part: &[Authority], of: &dyn Fn(&Authority) -> f64| {
        part.iter().map(of).fold(0.0, f64::max) <= MAX_AUTHORITY_RATIO * least(part, of)
    };
    let similar = |part: &[Authority]| {
        let [first, .., last] = part else { return true };
        // Linear damping dominates near rest, so the speed ratio does not limit a range from rest.
        let from_rest = matches!(first.rule, Pitch::Held(_));
        let frequency = pitch_frequency(part, fastest);
        (from_rest || last.speed <= MAX_SPEED_RATIO * first.speed)
            && close(part, &|r| r.turn)
            && close(part, &|r| r.turn_at(frequency))
    };
    let from = |start: usize| {
        (start + 1..=run.len()).rev().map(move |end| &run[start..end]).find(|part| similar(part))
    };
    (0..run.len()).filter_map(from).max_by_key(|part| part.len()).unwrap_or(&[])
}

impl Authority {
    /// Computes the authority of a vehicle at a speed; the error is the reason why the speed is unsuitable.
    fn of(vehicle: &Vehicle, speed: f64) -> Result<Self, Reason> {
        let rule = Pitch::over(vehicle, DEPTH, &[speed], None);
        let trim = trim_with(vehicle, Speed::Path(speed), DEPTH, &rule)
            .map_err(|e| format!("there is no trim: {e}"))?;
        let l = linearise(vehicle, &trim).map_err(|e| e.to_string())?;
        check_level_flight(vehicle, &l)?;
        let remaining: Vec<f64> = vehicle
            .actuators
            .iter()
            .zip(&trim.actuators)
            .map(|(a, now)| (a.max - now).min(now - a.min))
            .collect();
        let row = |i: usize| {
            l.b.row(i)
                .iter()
                .zip(&remaining)
                .map(|(b, remaining)| (b * remaining).abs())
                .collect::<Vec<f64>>()
        };
        let turns = row(turning(l.states)[1]);
        let main = (0..turns.len()).max_by(|i, j| turns[*i].total_cmp(&turns[*j])).unwrap_or(0);
        let growth = l.eigenvalues().iter().map(|v| v.re).fold(0.0, f64::max);
        let lag = vehicle.actuators[main].lag;
        if growth * lag > MAX_GROWTH_TIMES_LAG {
            return Err(format!(
                "the unstable mode exp({growth:.2} t) is too fast for {} with a lag of {lag} s",
                vehicle.actuators[main].name
            ));
        }
        let held = 1.0 / holding_ratio(&vehicle.actuators, ONE_DEGREE, &Linear::of(&l, &vehicle.actuators));
        if HELD_FRACTION * held < SMALLEST_PITCH {
            return Err(format!("the actuators can hold at most {held:.1} deg of pitch"));
        }
        let pitch = (HELD_FRACTION * held).min(LARGEST_PITCH);
        let surge = (!vehicle.coefficients.surge.is_given()).then(|| row(SURGE).iter().sum());
        Ok(Self { speed, pitch, surge, turn: turns.iter().sum(), lag, growth, rule, linear: l, remaining })
    }

    /// Returns the pitch acceleration at a frequency for sinusoids of the remaining range of all actuators, with the
    /// motion of all states, rad/s2; it tends to `turn` at high frequencies.
    fn turn_at(&self, frequency: f64) -> f64 {
        let system = system(&stacked(&self.linear.a, &self.linear.b), self.linear.states);
        let pitch =
            |(j, remaining): (usize, &f64)| remaining * system.part(PITCH_OUTPUT, j).gain_at(frequency);
        frequency * frequency * self.remaining.iter().enumerate().map(pitch).sum::<f64>()
    }

    /// Returns `true` if the trims at this and the next speed are on the same branch.
    fn connects_to(&self, vehicle: &Vehicle, next: &Self) -> bool {
        let same =
            matches!((&self.rule, &next.rule), (Pitch::Held(_), Pitch::Held(_)) | (Pitch::Free, Pitch::Free));
        same && trims(vehicle, DEPTH, &[self.speed, next.speed], &self.rule).is_ok()
    }
}

/// Index of the state u, if the model has it.
const SURGE: usize = 0;
/// Index of the pitch among the outputs of [`system`].
const PITCH_OUTPUT: usize = 1;
const ONE_DEGREE: f64 = std::f64::consts::PI / 180.0;

/// Checks that level flight leaves enough actuator range and has a small incidence.
fn check_level_flight(vehicle: &Vehicle, l: &Linearisation) -> Result<(), Reason> {
    let used = |(a, now): (&squid_auv::Actuator, &f64)| {
        (if *now > 0.0 { now / a.max } else { now / a.min }, a.name.clone())
    };
    let uses = vehicle.actuators.iter().zip(&l.trim.actuators).map(used);
    let (fraction, name) = uses.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or_default();
    let incidence = l.trim.incidence.to_degrees();
    if fraction > TRIM_FRACTION {
        return Err(format!("level flight requires {:.0} % of {name}", 100.0 * fraction));
    }
    if incidence.abs() > MAX_INCIDENCE {
        return Err(format!("level flight requires {incidence:.1} deg of incidence"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    /// Authority of each shipped vehicle tends to its pitch acceleration at high frequencies.
    ///
    /// The direct pitch effect of the vertical thruster of Sparus II is the same at all speeds; through heave it is
    /// seven times as large at 0.35 m/s as at 0.1 m/s, so that its range starts at a higher speed.
    #[test]
    fn authority_is_evaluated_at_model_frequency() {
        let vehicles = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../vehicles");
        let read = |name: &str| {
            let text = squid_base::files::read(&vehicles.join(name).join("vehicle.toml")).unwrap();
            Vehicle::parse(&text, "vehicle.toml").unwrap().in_plane()
        };
        for name in ["squid", "remus100", "lauv", "tethys", "bluerov2_heavy"] {
            for authority in range(&read(name)).unwrap() {
                assert!(
                    (authority.turn_at(1e3) / authority.turn - 1.0).abs() < 1e-3,
                    "{name} {}",
                    authority.speed
                );
            }
        }
        let sparus = read("sparus2");
        let [slow, fast] = [0.1, 0.35].map(|speed| Authority::of(&sparus, speed).unwrap());
        let frequency = pitch_frequency(&[slow.clone(), fast.clone()], fastest(&sparus));
        assert!((fast.turn / slow.turn - 1.0).abs() < 0.01);
        let ratio = fast.turn_at(frequency) / slow.turn_at(frequency);
        assert!((ratio - 7.3).abs() < 0.1, "{ratio}");
        let range = range(&sparus).unwrap();
        assert_eq!((range[0].speed, range[range.len() - 1].speed), (0.15, 0.35));
    }
}
