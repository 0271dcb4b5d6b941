//! A first design file of heading.
//!
//! As for pitch, with the acceleration of yaw that the actuators give in straight flight, `turn`:
//!
//! ```text
//! frequency   sqrt(f turn/scale) with f = ACCELERATION_FRACTION, at most FREQUENCY_TIMES_LAG/lag, and FASTEST
//! a           turn/(scale frequency^2)
//! weight      WEIGHT a^0.65,   disturbance  DISTURBANCE/a^0.5,   rate of turn  RATE frequency
//! ```

use crate::error::Error;
use crate::knob::three_digits;
use crate::range::{ACCELERATION_FRACTION, DEPTH, FREQUENCY_TIMES_LAG, range};
use crate::start::{DELAY_MARGIN_IF_UNSTABLE, ROLL_OFF, SHORT_LAG, UNSTABLE};
use auv::{Lateral, Pitch, Vehicle};
use squid_design::inputs::yawing;

/// The step and the scale of heading, deg.
const SCALE: f64 = 10.0;
/// The largest frequency of the model, rad/s.
const FASTEST: f64 = 1.0;
/// The weight on commands and the disturbance for a = 1.
const WEIGHT: f64 = 0.1;
const DISTURBANCE: f64 = 0.2;
/// The rate of turn over the frequency, deg.
const RATE: f64 = 9.0;
/// The least speed of the range over the largest: the force of a rudder grows with the square.
const LEAST_SPEED: f64 = 0.45;

/// The text of a first design file of heading, at the speeds \[m/s\] of the design of level flight, if there is one;
/// `files` are the names of vehicle and design in messages.
///
/// # Errors
/// A vehicle without sway, roll and yaw, or on which nothing yaws; [`Error::NoRange`], [`Error::NoAuthority`],
/// [`Error::NoStraightFlight`].
pub fn start_heading(vehicle: &Vehicle, files: [&str; 2], speeds: Option<[f64; 2]>) -> Result<String, Error> {
    let yawing = yawing(vehicle, files)?;
    let [low, high] = match speeds {
        Some(speeds) => speeds,
        None => {
            let all = range(&vehicle.in_plane())?;
            let (first, last) = (all[0].speed, all[all.len() - 1].speed);
            [first.max(three_digits(LEAST_SPEED * last)), last]
        }
    };
    let [slow, fast] = [low, high].map(|speed| Yaw::of(vehicle, &yawing, speed));
    let (slow, fast) = (slow?, fast?);
    let turn = slow.turn.min(fast.turn);
    if turn <= 0.0 {
        return Err(Error::NoAuthority { vehicle: vehicle.name.clone(), signal: "heading", speed: low });
    }
    let scale = SCALE.to_radians();
    let lag = slow.lag.max(SHORT_LAG);
    let frequency =
        (ACCELERATION_FRACTION * turn / scale).sqrt().min(FREQUENCY_TIMES_LAG / slow.lag).min(FASTEST);
    let strength = turn / (scale * frequency * frequency);
    let inside = 0.04 * (high - low);
    let settled = (20.0 / frequency).ceil();
    let numbers = [
        ("BANDWIDTH", 0.16 * frequency),
        ("FREQUENCY", frequency),
        ("FOLLOW_CORNER", 0.4 * frequency),
        ("RATE_SCALE", SCALE * frequency),
        ("RATE_NOISE", 0.6 * frequency),
        ("WEIGHT_CORNER", ROLL_OFF / lag),
        ("WEIGHT", WEIGHT * strength.powf(0.65)),
        ("DISTURBANCE", DISTURBANCE / strength.sqrt()),
        ("TURN_RATE", RATE * frequency),
        ("SCALE", SCALE),
        ("SPEED_MIN", low),
        ("SPEED_MAX", high),
        ("SPEED_FROM", low + inside),
        ("SPEED_TO", high - inside),
        ("DEPTH", DEPTH),
        ("DURATION", 5.0 + RAMP + settled),
        ("RAMP", RAMP),
    ];
    let mut text = include_str!("heading.toml").replace("NAME", &vehicle.name);
    for (name, value) in numbers {
        text = text.replace(name, &format!("{:?}", three_digits(value)));
    }
    let growth = slow.growth.max(fast.growth);
    if growth > UNSTABLE {
        text += &format!(
            "\n# Without a controller the heading departs as exp({growth:.2} t): more delay margin costs speed.\n\
             [require]\ndelay_margin = {DELAY_MARGIN_IF_UNSTABLE}    # s\n"
        );
    }
    Ok(text)
}

/// The duration of the ramp of speed, s.
const RAMP: f64 = 60.0;

/// What straight flight leaves to turn with.
struct Yaw {
    /// The acceleration of yaw, rad/s2.
    turn: f64,
    /// The lag of the main actuator of yaw, s.
    lag: f64,
    /// The growth rate of the least stable mode, 1/s; 0 if all decay.
    growth: f64,
}

impl Yaw {
    fn of(vehicle: &Vehicle, yawing: &Vehicle, speed: f64) -> Result<Self, Error> {
        let rule = Pitch::over(&vehicle.in_plane(), DEPTH, &[speed], None);
        let found = Lateral::at(vehicle, speed, DEPTH, &rule).map_err(|reason| Error::NoStraightFlight {
            vehicle: vehicle.name.clone(),
            speed,
            reason: reason.to_string(),
        })?;
        let of = |(place, one): (usize, &auv::Actuator)| {
            let yaws = yawing.actuators.iter().any(|other| other.name == one.name);
            let now = found.straight.actuators[place];
            let reach = (one.max - now).min(now - one.min).max(0.0);
            (if yaws { (found.b[(YAW, place)] * reach).abs() } else { 0.0 }, one.lag)
        };
        let all: Vec<(f64, f64)> = vehicle.actuators.iter().enumerate().map(of).collect();
        let main = all.iter().max_by(|a, b| a.0.total_cmp(&b.0));
        Ok(Self {
            turn: all.iter().map(|(turn, _)| turn).sum(),
            lag: main.map_or(0.0, |(_, lag)| *lag),
            growth: found.eigenvalues().iter().map(|value| value.re).fold(0.0, f64::max),
        })
    }
}

/// The row of r in the linear model of sway, roll and yaw.
const YAW: usize = 2;
