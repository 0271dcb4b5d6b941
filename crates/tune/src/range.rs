//! The range of speed of a first design: the widest in which the vehicle flies level with ease, on one branch of its
//! trims, holds pitch, is not faster than its actuators, and has a similar authority everywhere.

use crate::error::Error;
use crate::knob::three_digits;
use auv::{Linearisation, Pitch, Speed, Vehicle, linearise, trim_with, trims};
use squid_design::fit::authority::holding_ratio;
use squid_design::fit::frequency::system;
use squid_design::linearise::stacked;

/// The depth of the trims, m.
pub(crate) const DEPTH: f64 = 50.0;
/// The part of an actuator that level flight may take.
pub(crate) const SHARE: f64 = 0.6;
/// The part of the pitch that the actuators hold that a step takes; the largest and the smallest step, deg.
const HELD: f64 = 0.35;
const LARGEST_PITCH: f64 = 10.0;
const SMALLEST_PITCH: f64 = 3.0;
/// Speeds that are tried, m/s.
const TO: f64 = 5.0;
const STEP: f64 = 0.05;
/// The largest incidence \[deg\].
const INCIDENCE: f64 = 10.0;
/// The largest speed of a range, relative to the smallest: forces grow as its square.
const WIDEST: f64 = 6.0;
/// The largest authority over pitch in a range, relative to the smallest.
const STRONGEST: f64 = 5.0;
/// The part of what the actuators accelerate that a step takes at its start.
pub(crate) const ACCELERATED: f64 = 0.5;
/// A model times the lag of the slowest actuator.
const OVER_LAG: f64 = 0.35;
/// The fastest model of the pitch, rad/s.
const FASTEST_PITCH: f64 = 1.75;
/// The largest growth rate of an unstable mode times the lag of the actuator that turns the vehicle.
const DEPARTS: f64 = 0.12;

/// What the actuators can do beyond level flight at a speed.
#[derive(Debug, Clone)]
pub(crate) struct Reach {
    /// Along the path, m/s.
    pub speed: f64,
    /// The pitch of a step, deg: [`HELD`] of what they hold.
    pub pitch: f64,
    /// Surge acceleration, m/s2; `None` where the speed is given.
    pub surge: Option<f64>,
    /// Pitch acceleration, rad/s2.
    pub turn: f64,
    /// The lag of the actuator that turns the vehicle most, s.
    pub lag: f64,
    /// What becomes of the pitch in level trim.
    rule: Pitch,
    linear: Linearisation,
    /// What level flight leaves of each actuator, N or rad.
    rooms: Vec<f64>,
}

/// Why a speed is not in a range, in words that follow "at ... m/s".
type Reason = String;

/// The widest range of speeds.
///
/// # Errors
/// [`Error::NoRange`], with the reasons at some speeds.
pub(crate) fn range(vehicle: &Vehicle) -> Result<Vec<Reach>, Error> {
    let count = (TO / STEP).round() as usize;
    let speeds = (0..=count).map(|i| three_digits(STEP * i as f64));
    let tried: Vec<(f64, Result<Reach, Reason>)> =
        speeds.map(|speed| (speed, Reach::of(vehicle, speed))).collect();
    let (mut best, mut run): (&[Reach], Vec<Reach>) = (&[], vec![]);
    let mut runs: Vec<Vec<Reach>> = vec![];
    for (_, reach) in &tried {
        let joins = |reach: &Reach| run.last().is_none_or(|last| last.joins(vehicle, reach));
        match reach {
            Ok(reach) if joins(reach) => run.push(reach.clone()),
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
    let refused = tried.iter().filter_map(|(speed, reach)| Some((*speed, reach.as_ref().err()?)));
    let reasons: Vec<String> = SHOWN
        .iter()
        .filter_map(|shown| refused.clone().find(|(speed, _)| speed >= shown))
        .map(|(speed, reason)| format!("at {speed} m/s {reason}"))
        .collect();
    Err(Error::NoRange { vehicle: vehicle.name.clone(), from: 0.0, to: TO, reasons: reasons.join("; ") })
}

/// Speeds whose reasons are given where there is no range, m/s.
const SHOWN: [f64; 3] = [0.5, 1.0, 2.0];

/// The least of the speeds.
pub(crate) fn least(range: &[Reach], of: impl Fn(&Reach) -> f64) -> f64 {
    range.iter().map(of).fold(f64::INFINITY, f64::min)
}

/// The fastest model that the lags of the actuators allow, rad/s.
pub(crate) fn fastest(vehicle: &Vehicle) -> f64 {
    OVER_LAG / vehicle.actuators.iter().map(|a| a.lag).fold(0.0, f64::max)
}

/// The frequency of the model of the pitch in a range, at most that which the lags allow, rad/s.
pub(crate) fn pitch_frequency(range: &[Reach], fastest: f64) -> f64 {
    let scale = least(range, |r| r.pitch).to_radians();
    (ACCELERATED * least(range, |r| r.turn) / scale).sqrt().min(fastest).min(FASTEST_PITCH)
}

/// The longest part of a run in which authority and speed are similar.
///
/// The authority at the start of a step is the acceleration of the pitch rate; at the frequency of the model it is
/// what becomes of the pitch, which heave may turn much more than the actuators do by themselves.
fn widest(run: &[Reach], fastest: f64) -> &[Reach] {
    let close = |part: &[Reach], of: &dyn Fn(&Reach) -> f64| {
        part.iter().map(of).fold(0.0, f64::max) <= STRONGEST * least(part, of)
    };
    let similar = |part: &[Reach]| {
        let [first, .., last] = part else { return true };
        // Level from rest on, the forces at rest are those of linear damping.
        let from_rest = matches!(first.rule, Pitch::Held(_));
        let frequency = pitch_frequency(part, fastest);
        (from_rest || last.speed <= WIDEST * first.speed)
            && close(part, &|r| r.turn)
            && close(part, &|r| r.turn_at(frequency))
    };
    let from = |start: usize| {
        (start + 1..=run.len()).rev().map(move |end| &run[start..end]).find(|part| similar(part))
    };
    (0..run.len()).filter_map(from).max_by_key(|part| part.len()).unwrap_or(&[])
}

impl Reach {
    /// Of a vehicle at a speed, or why it cannot be flown there.
    fn of(vehicle: &Vehicle, speed: f64) -> Result<Self, Reason> {
        let rule = Pitch::over(vehicle, DEPTH, &[speed], None);
        let trim = trim_with(vehicle, Speed::Path(speed), DEPTH, &rule)
            .map_err(|e| format!("it does not trim: {e}"))?;
        let l = linearise(vehicle, &trim).map_err(|e| e.to_string())?;
        is_easy(vehicle, &l)?;
        let rooms: Vec<f64> = vehicle
            .actuators
            .iter()
            .zip(&trim.actuators)
            .map(|(a, now)| (a.max - now).min(now - a.min))
            .collect();
        let row =
            |i: usize| l.b.row(i).iter().zip(&rooms).map(|(b, room)| (b * room).abs()).collect::<Vec<f64>>();
        let turns = row(l.pitching()[1]);
        let turner = (0..turns.len()).max_by(|i, j| turns[*i].total_cmp(&turns[*j])).unwrap_or(0);
        let (growth, lag) = (growth(&l), vehicle.actuators[turner].lag);
        if growth * lag > DEPARTS {
            return Err(format!(
                "it departs by exp({growth:.2} t), too fast for {} with a lag of {lag} s",
                vehicle.actuators[turner].name
            ));
        }
        let held = 1.0 / holding_ratio(&vehicle.actuators, ONE_DEGREE, &l);
        if HELD * held < SMALLEST_PITCH {
            return Err(format!("the actuators hold no more than {held:.1} deg of pitch"));
        }
        let pitch = (HELD * held).min(LARGEST_PITCH);
        let surge = (!vehicle.coefficients.surge.is_given()).then(|| row(SURGE).iter().sum());
        Ok(Self { speed, pitch, surge, turn: turns.iter().sum(), lag, rule, linear: l, rooms })
    }

    /// The pitch acceleration of a sine of all that is left of the actuators, through all that it moves, rad/s2: at
    /// high frequencies the turn.
    fn turn_at(&self, frequency: f64) -> f64 {
        let system = system(&stacked(&self.linear), self.linear.states);
        let pitch = |(j, room): (usize, &f64)| room * system.part(PITCH_OUTPUT, j).gain_at(frequency);
        frequency * frequency * self.rooms.iter().enumerate().map(pitch).sum::<f64>()
    }

    /// Whether its trim is on one branch with that of the next speed.
    fn joins(&self, vehicle: &Vehicle, next: &Self) -> bool {
        let same =
            matches!((&self.rule, &next.rule), (Pitch::Held(_), Pitch::Held(_)) | (Pitch::Free, Pitch::Free));
        same && trims(vehicle, DEPTH, &[self.speed, next.speed], &self.rule).is_ok()
    }
}

/// The place of u among the states that have it.
const SURGE: usize = 0;
/// The place of the pitch among the outputs of [`system`].
const PITCH_OUTPUT: usize = 1;
const ONE_DEGREE: f64 = std::f64::consts::PI / 180.0;

/// The largest real part of an eigenvalue, 1/s.
fn growth(l: &Linearisation) -> f64 {
    l.eigenvalues().iter().map(|v| v.re).fold(0.0, f64::max)
}

/// Whether level flight leaves enough.
fn is_easy(vehicle: &Vehicle, l: &Linearisation) -> Result<(), Reason> {
    let used = |(a, now): (&auv::Actuator, &f64)| {
        (if *now > 0.0 { now / a.max } else { now / a.min }, a.name.clone())
    };
    let uses = vehicle.actuators.iter().zip(&l.trim.actuators).map(used);
    let (share, name) = uses.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or_default();
    let incidence = l.trim.incidence.to_degrees();
    if share > SHARE {
        return Err(format!("level flight takes {:.0} % of {name}", 100.0 * share));
    }
    if incidence.abs() > INCIDENCE {
        return Err(format!("level flight takes {incidence:.1} deg of incidence"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    /// At high frequencies the authority is the acceleration of the pitch rate, of each shipped vehicle.
    ///
    /// The vertical thruster of Sparus II turns it the same at all speeds by itself, and by the heave that it drives
    /// seven times as much at 0.35 m/s as at 0.1 m/s: its range begins later.
    #[test]
    fn authority_is_that_at_the_frequency_of_the_model() {
        let vehicles = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../vehicles");
        let read = |name: &str| {
            let text = base::files::read(&vehicles.join(name).join("vehicle.toml")).unwrap();
            Vehicle::parse(&text, "vehicle.toml").unwrap()
        };
        for name in ["squid", "remus100", "lauv", "tethys", "bluerov2_heavy"] {
            for reach in range(&read(name)).unwrap() {
                assert!((reach.turn_at(1e3) / reach.turn - 1.0).abs() < 1e-3, "{name} {}", reach.speed);
            }
        }
        let sparus = read("sparus2");
        let [slow, fast] = [0.1, 0.35].map(|speed| Reach::of(&sparus, speed).unwrap());
        let frequency = pitch_frequency(&[slow.clone(), fast.clone()], fastest(&sparus));
        assert!((fast.turn / slow.turn - 1.0).abs() < 0.01);
        let ratio = fast.turn_at(frequency) / slow.turn_at(frequency);
        assert!((ratio - 7.3).abs() < 0.1, "{ratio}");
        let range = range(&sparus).unwrap();
        assert_eq!((range[0].speed, range[range.len() - 1].speed), (0.15, 0.35));
    }
}
