//! The envelope of heading: how fast the vehicle can turn.
//!
//! ```text
//! psi':  the largest rate of a steady turn at constant depth that every actuator holds within its limits, and the
//!        slower ones with it, in steps of 0.02 rad/s, to port and to starboard; 70 % of that, at most turn_rate
//! ```
//!
//! It is the smaller of that of the vehicle and of that of a corner of the declared uncertainty, with gains of the
//! actuators at their least: each coefficient is at the end of its range at which the turn that the vehicle just holds
//! takes more of the actuators. Other corners are not looked at.
//!
//! The rudder of a turn is not found from the gain of the linear model: on a hull that is directionally unstable the
//! rudder of a slow turn has the other sign than that of a fast one.

use crate::error::ModelError;
use crate::inputs::design_file::{DesignFile, UncertainParameter};
use rayon::prelude::*;
use squid_auv::{Actuator, Trim, TrimError, Vehicle, lateral, turn};
use squid_scheduled::{OverSpeed, ReferenceLimits};
use std::collections::BTreeMap;

/// Part of the rate that the actuators sustain.
const SHARE: f64 = 0.7;

/// The step in the rate of turns, rad/s, and the number of times that it is halved at the end.
const STEP: f64 = 0.02;
const HALVINGS: usize = 6;

/// The limits of the reference of heading, at the speeds of these level trims.
///
/// # Errors
/// [`ModelError::Trim`]: no straight flight.
pub fn envelope(
    vehicle: &Vehicle,
    file: &DesignFile,
    uncertain: &[UncertainParameter],
    trims: &[Trim],
) -> Result<BTreeMap<String, ReferenceLimits>, ModelError> {
    // Every actuator takes part in a turn.
    let mut whole = vehicle.clone();
    let others = std::mem::take(&mut whole.others);
    whole.actuators.extend(others);
    let fastest = file.envelope.turn_rate / SHARE;
    let gain = 1.0 - file.uncertainty.as_ref().map_or(0.0, |all| all.actuator_gain);
    let ends = |trim: &Trim| -> Result<[f64; 2], TrimError> {
        let end = |side: f64| -> Result<f64, TrimError> {
            let nominal = sustained(&whole, trim, side, fastest, 1.0)?;
            let corner = weakest(&whole, trim, nominal, uncertain);
            sustained(&corner, trim, side, nominal.abs(), gain)
        };
        Ok([end(-1.0)?, end(1.0)?])
    };
    let rows: Vec<[f64; 2]> =
        trims.par_iter().map(ends).collect::<Result<_, _>>().map_err(ModelError::Trim)?;
    let column = |end: usize| rows.iter().map(|row| SHARE * row[end]).collect::<Vec<f64>>();
    let rate = [column(0), column(1)].map(OverSpeed::from);
    let name = lateral::SIGNALS[lateral::HEADING].name.to_owned();
    Ok(BTreeMap::from([(name, ReferenceLimits { range: None, rate: Some(rate) })]))
}

/// The fastest turn to a side, at most `fastest` \[rad/s\], with this gain of the actuators: no slower one that was
/// tried is beyond their limits.
fn sustained(vehicle: &Vehicle, trim: &Trim, side: f64, fastest: f64, gain: f64) -> Result<f64, TrimError> {
    let is_held = |rate: f64| use_of_actuators(vehicle, trim, side * rate).map(|most| most <= gain);
    if !is_held(0.0)? {
        return Ok(0.0);
    }
    let (mut held, mut step) = (0.0, STEP);
    for _ in 0..HALVINGS {
        while held < fastest && is_held((held + step).min(fastest)).unwrap_or(false) {
            held = (held + step).min(fastest);
        }
        step *= 0.5;
    }
    Ok(side * held)
}

/// The largest share of its limit that an actuator takes in a turn.
fn use_of_actuators(vehicle: &Vehicle, trim: &Trim, rate: f64) -> Result<f64, TrimError> {
    let turn = turn(vehicle, trim.speed, rate, trim.depth, &trim.rule)?;
    let share = |(one, output): (&Actuator, &f64)| output / if *output < 0.0 { one.min } else { one.max };
    Ok(vehicle.actuators.iter().zip(&turn.actuators).map(share).fold(0.0, f64::max))
}

/// The vehicle with each uncertain coefficient at the end of its range at which a turn takes more of the actuators.
fn weakest(vehicle: &Vehicle, trim: &Trim, rate: f64, uncertain: &[UncertainParameter]) -> Vehicle {
    let at_end = |of: &Vehicle, one: &UncertainParameter, sign: f64| {
        one.parameter.with_value(of, one.value + sign * one.half_range)
    };
    let takes = |one: &UncertainParameter, sign: f64| {
        use_of_actuators(&at_end(vehicle, one, sign), trim, rate).unwrap_or(f64::INFINITY)
    };
    uncertain.iter().fold(vehicle.clone(), |corner, one| {
        at_end(&corner, one, if takes(one, 1.0) >= takes(one, -1.0) { 1.0 } else { -1.0 })
    })
}
