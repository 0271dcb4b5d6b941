//! A first design file for a vehicle that has none.
//!
//! Range of speed: where level flight takes at most `SHARE` of each actuator. Scale of pitch: `HELD` of the pitch
//! that the rest of the actuators holds at the slow end. Frequencies: what the rest of the actuators accelerates, and
//! the lags.

use crate::error::Error;
use crate::knob::three_digits;
use auv::{Linearisation, Speed, Vehicle, linearise, trim};

/// Speeds that are tried, m/s.
const FROM: f64 = 0.2;
const TO: f64 = 5.0;
const STEP: f64 = 0.1;
/// The depth of the trims, m.
const DEPTH: f64 = 50.0;
/// The part of an actuator that level flight may take, and its largest incidence \[deg\].
const SHARE: f64 = 0.6;
const INCIDENCE: f64 = 10.0;
/// The largest speed of a range, relative to the smallest: forces grow as its square.
const WIDEST: f64 = 6.0;
/// The part of what the actuators hold that a pitch step takes; the largest and the smallest scale of pitch, deg.
const HELD: f64 = 0.35;
const LARGEST_PITCH: f64 = 10.0;
const SMALLEST_PITCH: f64 = 3.0;
/// The part of what the actuators accelerate that a step takes at its start.
const ACCELERATED: f64 = 0.5;
/// A model times the lag of the slowest actuator.
const OVER_LAG: f64 = 0.35;
/// The fastest models, rad/s.
const FASTEST_PITCH: f64 = 1.75;
const FASTEST_SPEED: f64 = 1.5;
/// The scale of the speed: of the range, and at most (m/s).
const SPEED_SHARE: f64 = 0.2;
const LARGEST_SPEED: f64 = 0.3;

/// What the actuators can do beyond level flight at a speed.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Reach {
    speed: f64,
    /// The pitch that they hold, rad.
    pitch: f64,
    /// Surge and pitch acceleration, m/s2 and rad/s2.
    surge: f64,
    turn: f64,
}

impl Reach {
    fn of(vehicle: &Vehicle, l: &Linearisation) -> Option<Self> {
        let trims = vehicle.actuators.iter().zip(&l.trim.actuators);
        let rooms: Vec<f64> = trims.map(|(a, now)| (a.max - now).min(now - a.min)).collect();
        let room = |row: &[f64]| row.iter().zip(&rooms).map(|(b, room)| (b * room).abs()).sum::<f64>();
        let row = |i: usize| l.b.row(i).iter().copied().collect::<Vec<f64>>();
        let a = l.a.clone_owned();
        let held = a.lu().solve(&l.b)?;
        let held: Vec<f64> = held.row(3).iter().copied().collect();
        Some(Self { speed: l.trim.speed, pitch: room(&held), surge: room(&row(0)), turn: room(&row(2)) })
    }
}

/// The linear model at a speed, if the vehicle trims there.
fn level(vehicle: &Vehicle, speed: f64) -> Option<Linearisation> {
    linearise(vehicle, &trim(vehicle, Speed::Path(speed), DEPTH).ok()?).ok()
}

/// Whether level flight leaves enough.
fn is_easy(vehicle: &Vehicle, l: &Linearisation) -> bool {
    let used = |(a, now): (&auv::Actuator, &f64)| if *now > 0.0 { now / a.max } else { now / a.min };
    let share = vehicle.actuators.iter().zip(&l.trim.actuators).map(used).fold(0.0, f64::max);
    share <= SHARE && l.trim.incidence.to_degrees().abs() <= INCIDENCE
}

/// The longest run of speeds at which the vehicle flies level with ease and holds enough pitch.
fn range(vehicle: &Vehicle) -> Result<Vec<Reach>, Error> {
    let count = ((TO - FROM) / STEP).round() as usize;
    let speeds = (0..=count).map(|i| three_digits(FROM + STEP * i as f64));
    let (mut best, mut run): (Vec<Reach>, Vec<Reach>) = (vec![], vec![]);
    for speed in speeds {
        let reach = level(vehicle, speed).filter(|l| is_easy(vehicle, l));
        let reach = reach.and_then(|l| Reach::of(vehicle, &l));
        match reach.filter(|r| HELD * r.pitch.to_degrees() >= SMALLEST_PITCH) {
            Some(reach) => run.push(reach),
            None => run.clear(),
        }
        if run.len() > best.len() {
            best.clone_from(&run);
        }
    }
    let fastest = best.last().map_or(0.0, |r| r.speed);
    best.retain(|r| r.speed * WIDEST >= fastest);
    match best.len() {
        0 | 1 => Err(Error::NoRange {
            vehicle: vehicle.name.clone(),
            from: FROM,
            to: TO,
            share: 100.0 * SHARE,
            incidence: INCIDENCE,
        }),
        _ => Ok(best),
    }
}

/// The text of a first design file.
///
/// # Errors
/// [`Error::NoRange`], [`Error::NoAuthority`].
pub fn start(vehicle: &Vehicle) -> Result<String, Error> {
    let range = range(vehicle)?;
    let least = |of: fn(&Reach) -> f64| range.iter().map(of).fold(f64::INFINITY, f64::min);
    let (low, high) = (range[0].speed, range[range.len() - 1].speed);
    let (held, turn, surge) = (least(|r| r.pitch), least(|r| r.turn), least(|r| r.surge));
    for (signal, authority) in [("pitch", turn), ("speed", surge)] {
        if authority <= 0.0 {
            return Err(Error::NoAuthority { vehicle: vehicle.name.clone(), signal, speed: low });
        }
    }
    let lag = vehicle.actuators.iter().map(|a| a.lag).fold(0.0, f64::max);
    let pitch = (HELD * held.to_degrees()).min(LARGEST_PITCH);
    let speed = (SPEED_SHARE * (high - low)).min(LARGEST_SPEED);
    let fastest = OVER_LAG / lag;
    let w_pitch = (ACCELERATED * turn / pitch.to_radians()).sqrt().min(fastest).min(FASTEST_PITCH);
    let w_speed = (ACCELERATED * surge / speed).min(fastest).min(FASTEST_SPEED);
    let inside = 0.04 * (high - low);
    let ramp = (10.0 * (high - low) / surge).clamp(20.0, 120.0).ceil();
    let duration = ramp + 40.0;
    let depth = DEPTH.max((1.2 * duration * high * pitch.to_radians().sin()).ceil());
    let numbers = [
        ("PITCH_BANDWIDTH", 0.3 * w_pitch),
        ("PITCH_FREQUENCY", w_pitch),
        ("PITCH_CORNER", 0.4 * w_pitch),
        ("PITCH_NOISE", 4e-4 * pitch),
        ("PITCH", pitch),
        ("SPEED_MIN", low),
        ("SPEED_MAX", high),
        ("SPEED_FROM", low + inside),
        ("SPEED_TO", high - inside),
        ("SPEED_BANDWIDTH", 0.25 * w_speed),
        ("SPEED_FREQUENCY", w_speed),
        ("SPEED_CORNER", 0.4 * w_speed),
        ("SPEED_NOISE", 8e-4 * speed),
        ("SPEED", speed),
        ("RATE_NOISE", 0.11 * pitch * w_pitch),
        ("DEPTH", depth),
        ("STEP", pitch),
        ("RAMP", ramp),
        ("DURATION", duration),
    ];
    let mut text = include_str!("start.toml").replace("NAME", &vehicle.name);
    text = text.replace("SHARE", &format!("{:.0}", 100.0 * SHARE));
    for (name, value) in numbers {
        text = text.replace(name, &format!("{:?}", three_digits(value)));
    }
    Ok(text)
}
