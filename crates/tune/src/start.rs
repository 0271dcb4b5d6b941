//! First design file for a vehicle without one.
//!
//! The speed range, scales, frequencies and weights follow from the vehicle's level flight, the remaining control
//! authority, the actuator lags, and the growth rate of unstable modes:
//!
//! ```text
//! scale of pitch   a third of the pitch that the remaining actuator range can hold
//! frequency        sqrt(f turn/scale) for pitch and f surge/scale for speed with f = ACCELERATION_FRACTION,
//!                  at most FREQUENCY_TIMES_LAG/lag
//! a                turn/(scale frequency^2): available acceleration over demanded acceleration
//! weight           WEIGHT a^0.65,   disturbance  DISTURBANCE/a^0.5
//! ```
//!
//! The gain of an actuator in units of its reach is proportional to a. The exponents are fitted to the designs of the
//! shipped vehicles.

mod heading;
mod whole;

use crate::error::Error;
use crate::knob::three_digits;
use crate::range::{
    ACCELERATION_FRACTION, Authority, DEPTH, TRIM_FRACTION, fastest, least, pitch_frequency, range,
};
use squid_auv::Vehicle;
use squid_design::fit::Model;
use squid_design::fit::frequency::errors;
use squid_design::inputs::Inputs;
use squid_design::inputs::design_file::DesignFile;

pub use heading::{Beside, start_heading};
pub use whole::start_whole;

/// Largest frequency of the speed model, rad/s.
const FASTEST_SPEED: f64 = 1.5;
/// Scale of the speed as a fraction of the speed range.
const SPEED_FRACTION: f64 = 0.2;
/// Largest scale of the speed, m/s.
const LARGEST_SPEED: f64 = 0.3;
/// Weight on commands for a = 1.
const WEIGHT: f64 = 0.05;
/// Disturbance for a = 1.
const DISTURBANCE: f64 = 0.45;
/// Corner of the weight on commands times the lag of the main pitch actuator.
pub(crate) const ROLL_OFF: f64 = 2.0;
/// Lag (s) above which more damping is needed: less assumed noise of the pitch rate, and more of the pitch.
pub(crate) const SHORT_LAG: f64 = 0.2;
/// Growth rate (1/s) above which a vehicle is unstable, and the delay margin (s) that is then required: a larger one
/// would cost most of the speed of response.
pub(crate) const UNSTABLE: f64 = 0.01;
pub(crate) const DELAY_MARGIN_IF_UNSTABLE: f64 = 0.15;
/// Orders of the fit.
const ORDERS: [usize; 2] = [2, 3];
/// Error of the frequency response above which the higher order is considered.
const BAD_FIT: f64 = 0.05;

/// Returns the text of a first design file.
///
/// # Errors
/// [`Error::NoRange`], [`Error::NoAuthority`], and errors of the model.
pub fn start(vehicle: &Vehicle) -> Result<String, Error> {
    let vehicle = &vehicle.in_plane();
    let range = range(vehicle)?;
    let text = text(vehicle, &range, ORDERS[0])?;
    let design = DesignFile::parse(&text, "design.toml", "design")?;
    let inputs = Inputs::new(vehicle.clone(), design)?;
    let model = Model::new(&inputs.axis(), &inputs.design)?;
    let errors = errors(&vehicle.actuators, &inputs.design.tracked, &model);
    let of_order = |order: usize| errors.iter().find(|e| e.order == order).map_or(0.0, |e| e.scaled);
    if of_order(ORDERS[0]) > BAD_FIT && of_order(ORDERS[1]) < 0.5 * of_order(ORDERS[0]) {
        return self::text(vehicle, &range, ORDERS[1]);
    }
    Ok(text)
}

/// Returns the template, without the tables of the speed if the speed is imposed.
fn template(speed_is_given: bool) -> String {
    let template = include_str!("start.toml");
    if !speed_is_given {
        return template.to_owned();
    }
    let of_speed =
        |part: &&str| [r#"output = "speed""#, r#"signal = "speed""#].iter().any(|key| part.contains(key));
    let parts: Vec<&str> = template.split("\n\n").filter(|part| !of_speed(part)).collect();
    parts.join("\n\n").replace("pitch and speed; pitch, speed and pitch rate", "pitch; pitch and pitch rate")
}

fn text(vehicle: &Vehicle, range: &[Authority], order: usize) -> Result<String, Error> {
    let (low, high) = (range[0].speed, range[range.len() - 1].speed);
    // An imposed speed does not limit the surge acceleration.
    let (turn, surge) = (least(range, |r| r.turn), least(range, |r| r.surge.unwrap_or(f64::INFINITY)));
    for (signal, authority) in [("pitch", turn), ("speed", surge)] {
        if authority <= 0.0 {
            return Err(Error::NoAuthority { vehicle: vehicle.name.clone(), signal, speed: low });
        }
    }
    let pitch = least(range, |r| r.pitch);
    let speed = (SPEED_FRACTION * (high - low)).min(LARGEST_SPEED);
    let fastest = fastest(vehicle);
    let w_pitch = pitch_frequency(range, fastest);
    let w_speed = (ACCELERATION_FRACTION * surge / speed).min(fastest).min(FASTEST_SPEED);
    let turning_lag = range.iter().map(|r| r.lag).fold(SHORT_LAG, f64::max);
    let longer = turning_lag / SHORT_LAG;
    let strength = turn / (pitch.to_radians() * w_pitch * w_pitch);
    let inside = 0.04 * (high - low);
    let ramp = (10.0 * (high - low) / surge).clamp(20.0, 120.0).ceil();
    let duration = ramp + 40.0;
    let depth = DEPTH.max((1.2 * duration * high * pitch.to_radians().sin()).ceil());
    let numbers = [
        ("PITCH_BANDWIDTH", 0.3 * w_pitch),
        ("PITCH_FREQUENCY", w_pitch),
        ("PITCH_CORNER", 0.4 * w_pitch),
        ("PITCH_NOISE", 4e-4 * pitch * longer),
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
        ("RATE_NOISE", 0.11 * pitch * w_pitch / longer),
        ("WEIGHT_CORNER", ROLL_OFF / turning_lag),
        ("WEIGHT", WEIGHT * strength.powf(0.65)),
        ("DISTURBANCE", DISTURBANCE / strength.sqrt()),
        ("DEPTH", depth),
        ("STEP", pitch),
        ("RAMP", ramp),
        ("DURATION", duration),
    ];
    let mut text = template(vehicle.coefficients.surge.is_given()).replace("NAME", &vehicle.name);
    text =
        text.replace("SHARE", &format!("{:.0}", 100.0 * TRIM_FRACTION)).replace("ORDER", &order.to_string());
    for (name, value) in numbers {
        text = text.replace(name, &format!("{:?}", three_digits(value)));
    }
    let growth = range.iter().map(|r| r.growth).fold(0.0, f64::max);
    if growth > UNSTABLE {
        text += &format!(
            "\n\
             # Without a controller the pitch diverges as exp({growth:.2} t): a larger delay margin costs speed.\n\
             [require]\n\
             delay_margin = {DELAY_MARGIN_IF_UNSTABLE}    # s\n"
        );
    }
    Ok(text)
}
