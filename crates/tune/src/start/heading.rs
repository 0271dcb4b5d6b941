//! First design file for heading.
//!
//! Numbers follow as for pitch, from `turn`, the yaw acceleration that the actuators can produce in straight flight:
//!
//! ```text
//! frequency   sqrt(f turn/scale) with f = ACCELERATION_FRACTION, at most FREQUENCY_TIMES_LAG/lag, FASTEST, and
//!             e rate/scale: the model then turns by the scale no faster than the rate that the envelope allows
//! a           turn/(scale frequency^2)
//! weight      WEIGHT a^0.65,   disturbance  DISTURBANCE/a^0.5,   rate of turn  RATE frequency
//! settling    SETTLING/frequency,   gust  GUST_SHARE atan(gust/speed), at the least speed
//! ```

use crate::error::Error;
use crate::knob::three_digits;
use crate::range::{ACCELERATION_FRACTION, DEPTH, FREQUENCY_TIMES_LAG, range};
use crate::start::{DELAY_MARGIN_IF_UNSTABLE, ROLL_OFF, SHORT_LAG, UNSTABLE};
use squid_auv::{LATERAL, Lateral, Pitch, Vehicle};
use squid_design::axis::VehicleModel;
use squid_design::check::flown::GUST;
use squid_design::inputs::design_file::DesignFile;
use squid_design::inputs::{Inputs, of_view};
use squid_scheduled::OverSpeed;
use std::f64::consts::E;

/// Step and scale of heading, deg.
const SCALE: f64 = 10.0;
/// Largest frequency of the model, rad/s.
const FASTEST: f64 = 1.0;
/// Weight on commands and disturbance for a = 1.
const WEIGHT: f64 = 0.1;
const DISTURBANCE: f64 = 0.2;
/// Ratio of the rate of turn to the frequency, deg.
const RATE: f64 = 9.0;
/// Ratio of the least to the largest speed of the range: the force of a rudder grows with the square of the speed.
const LEAST_SPEED: f64 = 0.45;

/// Settling time of a turn within 2 %, times the frequency: 1.5 times that of the model.
const SETTLING: f64 = 9.0;
/// Change of heading in a gust, relative to the angle of the flow.
const GUST_SHARE: f64 = 0.3;

/// Settings that a heading autopilot shares with the design of level flight in the same vehicle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beside {
    /// Least and largest speed, m/s.
    pub speeds: [f64; 2],
    /// Depth of the trims, m.
    pub depth: f64,
    /// Sample time, s.
    pub sample_time: f64,
}

/// Returns the text of a first design file for heading, for use with a design of level flight if `beside` is given;
/// `files` are the names of vehicle and design in messages.
///
/// # Errors
/// [`Error::Design`] for a vehicle without sway, roll and yaw, or without a yaw actuator; [`Error::NoRange`],
/// [`Error::NoAuthority`], [`Error::NoStraightFlight`].
pub fn start_heading(vehicle: &Vehicle, files: [&str; 2], beside: Option<Beside>) -> Result<String, Error> {
    let yawing = of_view(vehicle, &LATERAL, files)?;
    let [low, high] = match beside {
        Some(beside) => beside.speeds,
        None => {
            let all = range(&vehicle.in_plane())?;
            let (first, last) = (all[0].speed, all[all.len() - 1].speed);
            [first.max(three_digits(LEAST_SPEED * last)), last]
        }
    };
    let depth = beside.map_or(DEPTH, |beside| beside.depth);
    let [slow, fast] = [low, high].map(|speed| Yaw::of(vehicle, &yawing, speed, depth));
    let (slow, fast) = (slow?, fast?);
    let turn = slow.turn.min(fast.turn);
    if turn <= 0.0 {
        return Err(Error::NoAuthority { vehicle: vehicle.name.clone(), signal: "heading", speed: low });
    }
    let scale = SCALE.to_radians();
    let lag = slow.lag.max(SHORT_LAG);
    let fill = |frequency: f64| {
        let strength = turn / (scale * frequency * frequency);
        let inside = 0.04 * (high - low);
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
            ("DEPTH", depth),
            ("SAMPLE_TIME", beside.map_or(SAMPLE_TIME, |beside| beside.sample_time)),
            ("DURATION", 5.0 + RAMP + (20.0 / frequency).ceil()),
            ("RAMP", RAMP),
            ("SETTLING", SETTLING / frequency),
            ("GUST", GUST_SHARE * (GUST / low).atan().to_degrees()),
        ];
        let text = include_str!("heading.toml").replace("NAME", &vehicle.name);
        numbers
            .iter()
            .fold(text, |text, (name, value)| text.replace(name, &format!("{:?}", three_digits(*value))))
    };
    let frequency =
        (ACCELERATION_FRACTION * turn / scale).sqrt().min(FREQUENCY_TIMES_LAG / slow.lag).min(FASTEST);
    let rate = allowed_rate(vehicle, &fill(frequency), files[1], [low, high])?;
    let mut text = fill(frequency.min(E * rate / scale));
    let growth = slow.growth.max(fast.growth);
    if growth > UNSTABLE {
        text += &format!(
            "\n\
             # Without a controller the heading diverges as exp({growth:.2} t): a larger delay margin costs speed.\n\
             delay_margin = {DELAY_MARGIN_IF_UNSTABLE}    # s\n"
        );
    }
    Ok(text)
}

/// Returns the rate of the reference that the envelope of a design allows at these speeds, rad/s.
fn allowed_rate(vehicle: &Vehicle, text: &str, file: &str, speeds: [f64; 2]) -> Result<f64, Error> {
    let inputs = Inputs::new(vehicle.clone(), DesignFile::parse(text, file, "heading")?)?;
    let limits = inputs.axis().envelope(&speeds)?;
    let ends = limits.values().filter_map(|one| one.rate.as_ref()).flatten();
    let least = ends.flat_map(|end| match end {
        OverSpeed::Constant(rate) => vec![rate.abs()],
        OverSpeed::Table(rates) => rates.iter().map(|rate| rate.abs()).collect(),
    });
    Ok(least.fold(f64::INFINITY, f64::min))
}

/// Sample time without a design of level flight, s.
const SAMPLE_TIME: f64 = 0.02;
/// Duration of the speed ramp, s.
const RAMP: f64 = 60.0;

/// Yaw authority that straight flight leaves.
struct Yaw {
    /// Yaw acceleration, rad/s2.
    turn: f64,
    /// Lag of the main yaw actuator, s.
    lag: f64,
    /// Growth rate of the least stable mode, 1/s; 0 if all decay.
    growth: f64,
}

impl Yaw {
    fn of(vehicle: &Vehicle, yawing: &Vehicle, speed: f64, depth: f64) -> Result<Self, Error> {
        let rule = Pitch::over(&vehicle.in_plane(), depth, &[speed], None);
        let found = Lateral::at(vehicle, speed, depth, &rule).map_err(|reason| Error::NoStraightFlight {
            vehicle: vehicle.name.clone(),
            speed,
            reason: reason.to_string(),
        })?;
        let of = |(index, one): (usize, &squid_auv::Actuator)| {
            let yaws = yawing.actuators.iter().any(|other| other.name == one.name);
            let now = found.straight.actuators[index];
            let reach = (one.max - now).min(now - one.min).max(0.0);
            (if yaws { (found.b[(YAW, index)] * reach).abs() } else { 0.0 }, one.lag)
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

/// Row of r in the linear model of sway, roll and yaw.
const YAW: usize = 2;
