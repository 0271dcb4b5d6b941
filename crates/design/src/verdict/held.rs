//! A load that the actuators cannot hold.

use crate::error::Error;
use crate::inputs::Inputs;
use crate::inputs::design_file::Tracked;
use crate::verdict::flown::{AT_ONCE, STEP_TIME};
use rayon::prelude::*;
use serde::Serialize;
use squid_auv::Load;
use squid_auv::longitudinal::SPEED;
use squid_flight::flight::{Disturbance, Flight, Row, Spell, Variations, fly_varied, unless_lost};
use squid_scheduled::{Autopilot, ControllerDesign, Manoeuvre, OverSpeed, Trim};
use std::f64::consts::{PI, TAU};

/// The load, relative to what the actuators hold.
pub const FACTOR: f64 = 1.2;

/// The largest part of the load that is not held, relative to the righting moment of the hull: a hull that cannot right
/// itself is turned over by anything that its actuators do not hold.
const RIGHTED: f64 = 0.5;

/// Indices of moments in a load.
const M: usize = 4;

/// A force, or moment about an arm of a metre, of this part of the weight is none.
const NONE: f64 = 1e-9;

/// How long the load takes to rise, and to fall: a step of a moment turns the hull before any command can, s.
pub const RISE: f64 = 5.0;

/// How long the load acts, s.
pub const HELD: f64 = 60.0;

/// How long after its end, and after the time that the limit of the rate takes for the way back, the rest is judged, s.
pub const AFTER: f64 = 40.0;

/// The longest way back that is flown, s.
const LONGEST: f64 = 600.0;

/// How long it is watched then, s.
const WATCHED: f64 = 5.0;

/// A flight under a load that its actuators cannot hold.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Held {
    /// The tracked output besides the speed.
    pub output: &'static str,
    /// Speed along the path, m/s.
    pub speed: f64,
    /// The moment, N m.
    pub load: f64,
    /// The largest loss of speed until it ends, relative to the speed that is asked, or half the range of speed if that
    /// is more.
    pub lost_speed: f64,
    /// The largest error of the output after the way back, without the error before the load, relative to the step of
    /// the default flight.
    pub left: f64,
}

impl Held {
    /// The flights at a number of speeds, with loads either way; none without an output besides the speed.
    ///
    /// # Errors
    /// The errors of the flights.
    pub fn of(inputs: &Inputs, controller: &ControllerDesign, speeds: usize) -> Result<Vec<Self>, Error> {
        let Some(output) = inputs.design.tracked.iter().find(|one| one.place == inputs.design.stepped())
        else {
            return Ok(vec![]);
        };
        let trims = Autopilot::new(controller)?.trim().clone();
        let both = |speed: f64| [-1.0, 1.0].map(|sign| (speed, sign));
        let all: Vec<_> = inputs.design.spread(speeds).into_iter().flat_map(both).collect();
        let held =
            |(speed, sign): (f64, f64)| Self::flown(inputs, controller, (output, &trims), (speed, sign));
        let found: Result<Vec<Option<Self>>, Error> = all.into_par_iter().map(held).collect();
        Ok(found?.into_iter().flatten().collect())
    }

    fn flown(
        inputs: &Inputs,
        controller: &ControllerDesign,
        (output, trims): (&Tracked, &Trim),
        (speed, sign): (f64, f64),
    ) -> Result<Option<Self>, Error> {
        let Some((axis, load)) = load(inputs, trims, trims.forward_speed(speed), sign) else {
            return Ok(None);
        };
        let lost = Self {
            output: output.signal.name,
            speed,
            load: load[axis],
            lost_speed: f64::INFINITY,
            left: f64::INFINITY,
        };
        let back = Back::of(controller, output, trims, trims.forward_speed(speed));
        let duration = STEP_TIME + HELD + RISE + AFTER + back.longest() + WATCHED;
        let Some(flight) = fly(inputs, controller, (speed, duration), load)? else { return Ok(Some(lost)) };
        let rows = &flight.rows;
        let error = |row: &Row| {
            let error = row.error(output.place);
            if output.signal.circular { (error + PI).rem_euclid(TAU) - PI } else { error }
        };
        let at = |time: f64| rows.iter().rfind(|row| row.time < time);
        let (Some(before), Some(end)) = (at(STEP_TIME), at(STEP_TIME + HELD)) else { return Ok(Some(lost)) };
        let settled = STEP_TIME + HELD + RISE + AFTER + back.from(error(end));
        let late = || rows.iter().filter(|row| row.time >= settled);
        if late().next().is_none() {
            return Ok(Some(lost));
        }
        let (_, half_range) = inputs.design.scheduling();
        let slower = |row: &Row| {
            let asked = row.reference(SPEED);
            (asked - row.measured(SPEED)) * asked.signum() / asked.abs().max(half_range)
        };
        let step = Some(inputs.design.manoeuvre.step(output.signal.name).abs()).filter(|step| *step > 0.0);
        let left = late().map(|row| (error(row) - error(before)).abs()).fold(0.0, f64::max);
        Ok(Some(Self {
            lost_speed: rows.iter().filter(|row| row.time < STEP_TIME + HELD).map(slower).fold(0.0, f64::max),
            left: left / step.unwrap_or(output.scale),
            ..lost
        }))
    }
}

/// A flight at a speed (m/s) and of a duration (s) under a load that acts for [`HELD`]; `None` if it was lost.
///
/// # Errors
/// The errors of the flight.
pub fn fly(
    inputs: &Inputs,
    controller: &ControllerDesign,
    (speed, duration): (f64, f64),
    load: Load,
) -> Result<Option<Flight>, Error> {
    let manoeuvre = Manoeuvre {
        speed_from: speed,
        speed_to: speed,
        ramp_start: STEP_TIME,
        ramp_duration: AT_ONCE,
        duration,
        ..inputs.design.manoeuvre.without_steps()
    };
    let disturbance = Disturbance { load, ..Disturbance::default() };
    let spell = Spell { disturbance, from: STEP_TIME, to: STEP_TIME + HELD, rise: RISE };
    let variations = Variations { spells: &[spell], ..Variations::default() };
    // So deep that no climb reaches the surface.
    let depth = inputs.design.depth + 2.0 * speed.abs() * manoeuvre.duration;
    let level = (depth, &inputs.design.pitch);
    Ok(unless_lost(fly_varied(&inputs.vehicle, controller, level, &manoeuvre, &variations))?)
}

/// How fast a reference comes back: the limits of its rate, if it has any, SI per second.
struct Back {
    rate: Option<[f64; 2]>,
    circular: bool,
}

impl Back {
    fn of(controller: &ControllerDesign, output: &Tracked, trims: &Trim, forward: f64) -> Self {
        let limits = controller.envelope.get(output.signal.name).and_then(|limits| limits.rate.as_ref());
        let size = |end: &OverSpeed| trims.over(forward, end).abs();
        Self { rate: limits.map(|[least, most]| [size(least), size(most)]), circular: output.signal.circular }
    }

    /// The time for an error, the reference less the measured value, s.
    fn from(&self, error: f64) -> f64 {
        self.rate.map_or(0.0, |[down, up]| error.abs() / if error > 0.0 { up } else { down })
    }

    /// The time for the largest error that is expected: half a turn, or as far as the reference moves while the load
    /// acts; at most [`LONGEST`], where the reference hardly comes back.
    fn longest(&self) -> f64 {
        let Some([down, up]) = self.rate else { return 0.0 };
        let slower = down.min(up);
        (if self.circular { PI / slower } else { HELD * down.max(up) / slower }).min(LONGEST)
    }
}

/// The load for an axis at a forward speed (m/s), with its index: [`FACTOR`] times the largest moment that turns it
/// which the actuators hold from trim at an unchanged force along the hull. Of a pitching moment at most half of the
/// righting moment of the hull is not held; where the actuators have none, that is the load. `None` without either.
pub fn load(inputs: &Inputs, trims: &Trim, forward: f64, sign: f64) -> Option<(usize, Load)> {
    let axis = inputs.design.view().moment;
    let held = largest(inputs, trims, forward, (axis, -sign));
    let held = if held > NONE * inputs.vehicle.coefficients.weight { held } else { 0.0 };
    let mut load = Load::default();
    load[axis] = sign * (held + beyond(inputs, axis, held));
    (load[axis] != 0.0).then_some((axis, load))
}

/// What of the load is not held.
fn beyond(inputs: &Inputs, axis: usize, held: f64) -> f64 {
    let squid_auv::Coefficients { weight, buoyancy, z_G, z_B, .. } = inputs.vehicle.coefficients;
    let righting = RIGHTED * (weight * z_G - buoyancy * z_B);
    let more = (FACTOR - 1.0) * held;
    match axis {
        M if held == 0.0 => righting.max(0.0),
        M => more.min(righting.max(0.0)),
        _ => more,
    }
}

/// The largest moment of a sign from trim, at an unchanged force along the hull, that the actuators give.
fn largest(inputs: &Inputs, trims: &Trim, forward: f64, (axis, sign): (usize, f64)) -> f64 {
    /// What an actuator adds along the hull and to the moment, per output, and its way from trim to its ends.
    struct Share {
        along: f64,
        turns: f64,
        way: [f64; 2],
    }
    let actuators = inputs.vehicle.actuators.iter().enumerate();
    let shares: Vec<Share> = actuators
        .map(|(index, one)| {
            let trim = trims.command(forward, index);
            let of = |output: f64| {
                if axis == M { one.force(forward, output)[2] } else { one.lateral_force(forward, output)[2] }
            };
            let turns = sign * (of(one.max) - of(one.min)) / (one.max - one.min);
            Share { along: one.force_per_output()[0], turns, way: [one.min - trim, one.max - trim] }
        })
        .collect();
    let best = |share: &Share| {
        if share.turns > 0.0 {
            share.way[1]
        } else if share.turns < 0.0 {
            share.way[0]
        } else {
            0.0
        }
    };
    let mut outputs: Vec<f64> = shares.iter().map(best).collect();
    let mut along: f64 = shares.iter().zip(&outputs).map(|(share, output)| share.along * output).sum();
    let mut total: f64 = shares.iter().zip(&outputs).map(|(share, output)| share.turns * output).sum();
    // The force along the hull is brought back by those that lose the least for it.
    let mut order: Vec<usize> = (0..shares.len()).filter(|one| shares[*one].along != 0.0).collect();
    order.sort_by(|one, other| {
        let price = |index: usize| (shares[index].turns / shares[index].along).abs();
        price(*one).total_cmp(&price(*other))
    });
    for index in order {
        let Share { along: per, turns, way } = &shares[index];
        let next = (outputs[index] - along / *per).clamp(way[0], way[1]);
        let moved = next - outputs[index];
        (along, total) = (along + *per * moved, total + *turns * moved);
        outputs[index] = next;
    }
    total.max(0.0)
}
