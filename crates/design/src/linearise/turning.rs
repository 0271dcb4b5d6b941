//! Envelope of heading: the largest rates of turn of the vehicle.
//!
//! ```text
//! psi':  the largest rate of a steady turn at constant depth for which every actuator is within its limits, also in
//! all
//!        slower turns, in steps of 0.02 rad/s, to port and to starboard; 70 % of that, at most turn_rate
//! ```
//!
//! The rate is the smaller of those of the vehicle and of one corner of the declared uncertainty, with the least gains
//! of the actuators: each coefficient is at the end of its range at which the fastest turn of the vehicle uses more of
//! the actuators. Other corners are not examined.
//!
//! The rudder of a turn does not follow from the gain of the linear model: on a directionally unstable hull, slow and
//! fast turns need rudder of opposite signs.

use crate::error::ModelError;
use crate::inputs::design_file::{DesignFile, UncertainParameter};
use rayon::prelude::*;
use squid_auv::{Actuator, Trim, TrimError, Vehicle, lateral, turn};
use squid_scheduled::{OverSpeed, ReferenceLimits};
use std::collections::BTreeMap;

/// Fraction of the rate that the actuators sustain.
const SHARE: f64 = 0.7;

/// Step in the rate of turns, rad/s, and the number of times that it is halved at the end.
const STEP: f64 = 0.02;
const HALVINGS: usize = 6;

/// Returns the limits of the reference of heading, at the speeds of these level trims.
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
    let mut all_actuators = vehicle.clone();
    let others = std::mem::take(&mut all_actuators.others);
    all_actuators.actuators.extend(others);
    let fastest = file.envelope.turn_rate / SHARE;
    let gain = 1.0 - file.uncertainty.as_ref().map_or(0.0, |all| all.actuator_gain);
    let ends = |trim: &Trim| -> Result<[f64; 2], TrimError> {
        let end = |side: f64| -> Result<f64, TrimError> {
            let nominal = sustained(&all_actuators, trim, side, fastest, 1.0)?;
            let corner = weakest(&all_actuators, trim, nominal, uncertain);
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

/// Fastest turn to a side, at most `fastest` \[rad/s\], with this gain of the actuators, such that no slower turn that
/// was tried exceeds their limits.
fn sustained(vehicle: &Vehicle, trim: &Trim, side: f64, fastest: f64, gain: f64) -> Result<f64, TrimError> {
    let is_held = |rate: f64| actuator_use(vehicle, trim, side * rate).map(|most| most <= gain);
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

/// Largest use of an actuator in a turn, relative to its limit.
fn actuator_use(vehicle: &Vehicle, trim: &Trim, rate: f64) -> Result<f64, TrimError> {
    let turn = turn(vehicle, trim.speed, rate, trim.depth, &trim.rule)?;
    let share = |(one, output): (&Actuator, &f64)| output / if *output < 0.0 { one.min } else { one.max };
    Ok(vehicle.actuators.iter().zip(&turn.actuators).map(share).fold(0.0, f64::max))
}

/// Vehicle with each uncertain coefficient at the end of its range at which a turn uses more of the actuators.
fn weakest(vehicle: &Vehicle, trim: &Trim, rate: f64, uncertain: &[UncertainParameter]) -> Vehicle {
    let at_end = |of: &Vehicle, one: &UncertainParameter, sign: f64| {
        one.parameter.with_value(of, one.value + sign * one.half_range)
    };
    let use_at = |one: &UncertainParameter, sign: f64| {
        actuator_use(&at_end(vehicle, one, sign), trim, rate).unwrap_or(f64::INFINITY)
    };
    uncertain.iter().fold(vehicle.clone(), |corner, one| {
        at_end(&corner, one, if use_at(one, 1.0) >= use_at(one, -1.0) { 1.0 } else { -1.0 })
    })
}
