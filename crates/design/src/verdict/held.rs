//! Flights under a load that the actuators cannot hold.

use crate::error::Error;
use crate::inputs::Inputs;
use crate::inputs::design_file::Tracked;
use crate::verdict::flown::{AT_ONCE, STEP_TIME};
use rayon::prelude::*;
use serde::Serialize;
use squid_auv::Load;
use squid_auv::longitudinal::SPEED;
use squid_flight::flight::{
    Disturbance, Flight, Row, TemporaryDisturbance, Variations, fly_varied, unless_lost,
};
use squid_scheduled::{Autopilot, ControllerDesign, Manoeuvre, OverSpeed, Trim};
use std::f64::consts::{PI, TAU};

/// Load relative to the largest load that the actuators hold.
pub const FACTOR: f64 = 1.2;

/// Largest excess load relative to the righting moment of the hull: a hull without one is overturned by any excess.
const RIGHTED: f64 = 0.5;

/// Index of the pitching moment in a load.
const M: usize = 4;

/// Fraction of the weight below which a force, or a moment about an arm of a metre, counts as zero.
const NONE: f64 = 1e-9;

/// Time in which the load rises and falls, s: a step of the moment would turn the hull before any command could act.
pub const RISE: f64 = 5.0;

/// Time during which the load acts, s.
pub const HELD: f64 = 60.0;

/// Time from the end of the load, in addition to the return time of a rate-limited reference, to the assessment of the
/// remaining error, s.
pub const AFTER: f64 = 40.0;

/// Longest return time that is flown, s.
const LONGEST: f64 = 600.0;

/// Duration of that assessment, s.
const WATCHED: f64 = 5.0;

/// Flight under a load that the actuators cannot hold.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Held {
    /// Tracked output besides the speed.
    pub output: &'static str,
    /// Speed along the path, m/s.
    pub speed: f64,
    /// Moment of the load, N m.
    pub load: f64,
    /// Largest loss of speed until the load ends, relative to the speed reference, or half the range of speed if that
    /// is larger.
    pub lost_speed: f64,
    /// Largest error of the output after the return, less the error before the load, relative to the step of the
    /// default flight.
    pub remaining_error: f64,
}

impl Held {
    /// Flies at a number of speeds, with loads in both directions; none without an output besides the speed.
    ///
    /// # Errors
    /// The errors of the flights.
    pub fn of(inputs: &Inputs, controller: &ControllerDesign, speeds: usize) -> Result<Vec<Self>, Error> {
        let Some(output) = inputs.design.tracked.iter().find(|one| one.index == inputs.design.stepped())
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
            remaining_error: f64::INFINITY,
        };
        let reference_return = ReferenceReturn::of(controller, output, trims, trims.forward_speed(speed));
        let duration = STEP_TIME + HELD + RISE + AFTER + reference_return.longest() + WATCHED;
        let Some(flight) = fly(inputs, controller, (speed, duration), load)? else { return Ok(Some(lost)) };
        let rows = &flight.rows;
        let error = |row: &Row| {
            let error = row.error(output.index);
            if output.signal.circular { (error + PI).rem_euclid(TAU) - PI } else { error }
        };
        let at = |time: f64| rows.iter().rfind(|row| row.time < time);
        let (Some(before), Some(end)) = (at(STEP_TIME), at(STEP_TIME + HELD)) else { return Ok(Some(lost)) };
        let settled = STEP_TIME + HELD + RISE + AFTER + reference_return.from(error(end));
        let late = || rows.iter().filter(|row| row.time >= settled);
        if late().next().is_none() {
            return Ok(Some(lost));
        }
        let (_, half_range) = inputs.design.scheduling();
        let slower = |row: &Row| {
            let reference = row.reference(SPEED);
            (reference - row.measured(SPEED)) * reference.signum() / reference.abs().max(half_range)
        };
        let step = Some(inputs.design.manoeuvre.step(output.signal.name).abs()).filter(|step| *step > 0.0);
        let remaining_error = late().map(|row| (error(row) - error(before)).abs()).fold(0.0, f64::max);
        Ok(Some(Self {
            lost_speed: rows.iter().filter(|row| row.time < STEP_TIME + HELD).map(slower).fold(0.0, f64::max),
            remaining_error: remaining_error / step.unwrap_or(output.scale),
            ..lost
        }))
    }
}

/// Simulates a flight at a speed (m/s) and of a duration (s) under a load that acts for [`HELD`]; `None` if it was
/// lost.
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
    let spell = TemporaryDisturbance { disturbance, from: STEP_TIME, to: STEP_TIME + HELD, rise: RISE };
    let variations = Variations { disturbances: &[spell], ..Variations::default() };
    // The depth is such that no climb reaches the surface.
    let depth = inputs.design.depth + 2.0 * speed.abs() * manoeuvre.duration;
    let level = (depth, &inputs.design.pitch);
    Ok(unless_lost(fly_varied(&inputs.vehicle, controller, level, &manoeuvre, &variations))?)
}

/// Return of a reference: the limits of its rate, if it has any, SI per second.
struct ReferenceReturn {
    rate: Option<[f64; 2]>,
    circular: bool,
}

impl ReferenceReturn {
    fn of(controller: &ControllerDesign, output: &Tracked, trims: &Trim, forward: f64) -> Self {
        let limits = controller.envelope.get(output.signal.name).and_then(|limits| limits.rate.as_ref());
        let size = |end: &OverSpeed| trims.over(forward, end).abs();
        Self { rate: limits.map(|[least, most]| [size(least), size(most)]), circular: output.signal.circular }
    }

    /// Return time for an error, the reference less the measured value, s.
    fn from(&self, error: f64) -> f64 {
        self.rate.map_or(0.0, |[down, up]| error.abs() / if error > 0.0 { up } else { down })
    }

    /// Return time for the largest expected error: half a turn, or as far as the reference moves while the load acts;
    /// at most [`LONGEST`], because a slower reference hardly returns.
    fn longest(&self) -> f64 {
        let Some([down, up]) = self.rate else { return 0.0 };
        let slower = down.min(up);
        (if self.circular { PI / slower } else { HELD * down.max(up) / slower }).min(LONGEST)
    }
}

/// Returns the load for an axis at a forward speed (m/s), with its index: [`FACTOR`] times the largest moment about the
/// axis that the actuators hold from trim at an unchanged force along the hull. The excess of a pitching moment is at
/// most half of the righting moment of the hull; it is the entire load if the actuators hold none. `None` if the load
/// is zero.
pub fn load(inputs: &Inputs, trims: &Trim, forward: f64, sign: f64) -> Option<(usize, Load)> {
    let axis = inputs.design.view().moment;
    let held = largest(inputs, trims, forward, (axis, -sign));
    let held = if held > NONE * inputs.vehicle.coefficients.weight { held } else { 0.0 };
    let mut load = Load::default();
    load[axis] = sign * (held + beyond(inputs, axis, held));
    (load[axis] != 0.0).then_some((axis, load))
}

/// Excess of the load over the moment that is held.
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

/// Largest moment of a sign from trim, at an unchanged force along the hull, that the actuators can exert.
fn largest(inputs: &Inputs, trims: &Trim, forward: f64, (axis, sign): (usize, f64)) -> f64 {
    /// Axial force and moment of an actuator per output, and its travel from trim to its limits.
    struct Share {
        axial: f64,
        moment: f64,
        travel: [f64; 2],
    }
    let actuators = inputs.vehicle.actuators.iter().enumerate();
    let shares: Vec<Share> = actuators
        .map(|(index, one)| {
            let trim = trims.command(forward, index);
            let of = |output: f64| {
                if axis == M { one.force(forward, output)[2] } else { one.lateral_force(forward, output)[2] }
            };
            let moment = sign * (of(one.max) - of(one.min)) / (one.max - one.min);
            Share { axial: one.force_per_output()[0], moment, travel: [one.min - trim, one.max - trim] }
        })
        .collect();
    let best = |share: &Share| {
        if share.moment > 0.0 {
            share.travel[1]
        } else if share.moment < 0.0 {
            share.travel[0]
        } else {
            0.0
        }
    };
    let mut outputs: Vec<f64> = shares.iter().map(best).collect();
    let mut axial: f64 = shares.iter().zip(&outputs).map(|(share, output)| share.axial * output).sum();
    let mut total: f64 = shares.iter().zip(&outputs).map(|(share, output)| share.moment * output).sum();
    // The actuators that lose the least moment for it restore the force along the hull.
    let mut order: Vec<usize> = (0..shares.len()).filter(|one| shares[*one].axial != 0.0).collect();
    order.sort_by(|one, other| {
        let lost_moment = |index: usize| (shares[index].moment / shares[index].axial).abs();
        lost_moment(*one).total_cmp(&lost_moment(*other))
    });
    for index in order {
        let Share { axial: per, moment, travel } = &shares[index];
        let next = (outputs[index] - axial / *per).clamp(travel[0], travel[1]);
        let moved = next - outputs[index];
        (axial, total) = (axial + *per * moved, total + *moment * moved);
        outputs[index] = next;
    }
    total.max(0.0)
}
