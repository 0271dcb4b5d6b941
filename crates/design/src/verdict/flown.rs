//! Flights of the nonlinear vehicle under its autopilot.

use crate::error::Error;
use crate::inputs::Inputs;
use crate::inputs::design_file::{DesignFile, Tracked};
use serde::Serialize;
use squid_auv::Actuator;
use squid_auv::longitudinal::SPEED;
use squid_flight::flight::{Flight, fly, unless_lost};
use squid_flight::metrics::{StepFigures, used_fraction};
use squid_scheduled::{Autopilot, ControllerDesign, Manoeuvre};

/// Time of the step, and time flown after it (s), as in the report.
pub(super) const STEP_TIME: f64 = 1.0;
const DURATION: f64 = 60.0;

/// Duration of a step of the speed reference (s), less than any sample time.
pub(super) const AT_ONCE: f64 = 1e-6;

/// Largest step of the speed, relative to half the range of speed; it is towards the middle, so it stays in the range.
const SPEED_STEP: f64 = 0.2;

/// Simulated step of a reference at a speed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StepAtSpeed {
    /// Name of the tracked output.
    pub output: &'static str,
    /// Speed along the path before the step, m/s.
    pub speed: f64,
    /// Height of the step, rad, m or m/s.
    pub height: f64,
    /// Excursion beyond the reference, relative to the step.
    pub overshoot: f64,
    /// Rise time from 10 to 90 %, s.
    pub rise_time: f64,
    /// Settling time to within 2 %, s.
    pub settling_time: f64,
    /// Mean error of the last six seconds, relative to the step.
    pub steady_error: f64,
    /// Largest use of an actuator, including the trim, relative to its limits.
    pub actuator_use: f64,
}

impl StepAtSpeed {
    /// Flies a step of each tracked output: for pitch and depth that of the default flight, for the speed at most its
    /// scale.
    pub(super) fn of(inputs: &Inputs, controller: &ControllerDesign, speed: f64) -> Result<Vec<Self>, Error> {
        let step = |tracked: &Tracked| {
            let flight = flight(inputs, controller, &step_at(inputs, tracked, speed))?;
            Ok(Self::flown(tracked.index, speed, flight.as_ref(), inputs))
        };
        inputs.design.tracked.iter().map(step).collect()
    }

    /// Computes the figures of a flight with one step of a signal; `flight` is `None` if it was lost.
    pub(super) fn flown(index: usize, speed: f64, flight: Option<&Flight>, inputs: &Inputs) -> Self {
        let rows = flight.map_or(&[][..], |f| &f.rows);
        let height = match rows {
            [first, .., last] => last.reference(index) - first.reference(index),
            _ => f64::NAN,
        };
        let (step, limits) = ((STEP_TIME, height), inputs.limits());
        let figures = match flight {
            Some(flight) => StepFigures::of_flight(flight, index, step, &limits),
            None => StepFigures::of(&[], index, step, &limits).cut_short(),
        };
        Self {
            output: inputs.design.interface.signals[index].name,
            speed,
            height,
            overshoot: figures.overshoot,
            rise_time: figures.rise_time,
            settling_time: figures.settling_time,
            steady_error: figures.steady_error,
            actuator_use: figures.actuator_use,
        }
    }
}

/// Returns the manoeuvre with one step of a tracked output at a speed.
pub(super) fn step_at(inputs: &Inputs, tracked: &Tracked, speed: f64) -> Manoeuvre {
    let level = Manoeuvre {
        speed_from: speed,
        speed_to: speed,
        step_time: STEP_TIME,
        step_end: f64::MAX,
        ramp_start: STEP_TIME - 2.0 * AT_ONCE,
        ramp_duration: AT_ONCE,
        duration: STEP_TIME + DURATION,
        ..inputs.design.manoeuvre.without_steps()
    };
    if tracked.index == SPEED {
        let (middle, half_range) = inputs.design.scheduling();
        let size = (SPEED_STEP * half_range).min(tracked.scale);
        return Manoeuvre { speed_to: if speed <= middle { speed + size } else { speed - size }, ..level };
    }
    let name = tracked.signal.name;
    level.with_step(name, inputs.design.manoeuvre.step(name))
}

/// Simulated flight; `None` if it was lost.
fn flight(
    inputs: &Inputs,
    controller: &ControllerDesign,
    manoeuvre: &Manoeuvre,
) -> Result<Option<Flight>, Error> {
    flight_from(inputs, controller, inputs.design.depth, manoeuvre)
}

/// Simulates a flight that begins at a depth, m; `None` if it was lost.
pub(super) fn flight_from(
    inputs: &Inputs,
    controller: &ControllerDesign,
    depth: f64,
    manoeuvre: &Manoeuvre,
) -> Result<Option<Flight>, Error> {
    let level = (depth, &inputs.design.pitch);
    Ok(unless_lost(fly(&inputs.vehicle, controller, level, manoeuvre))?)
}

/// Use of each actuator in the default flight, relative to its limits: 1 is at a limit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DefaultFlight {
    /// Uses in the order of the vehicle's actuators.
    pub uses: Vec<Use>,
    /// Reason for an early end of the flight, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lost: Option<String>,
}

/// Use of one actuator.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Use {
    /// Name of the actuator.
    pub actuator: String,
    /// Largest use in the flight, including the trim.
    pub most: f64,
    /// Largest use for level flight at the speeds of the flight.
    pub trim: f64,
    /// Largest unsaturated rate of its lag relative to the rate limit, if there is one; above 1 the rate is saturated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rate: Option<f64>,
}

/// Largest unsaturated rate of an actuator's lag under commands that are held between ticks, starting from the first
/// command \[N/s or rad/s\]; NaN without commands. The rate is largest right after a tick.
fn largest_rate(actuator: &Actuator, commands: impl Iterator<Item = f64>, design: &DesignFile) -> f64 {
    let mut output = None;
    let rates = commands.map(|command| {
        let from = output.unwrap_or(command);
        output = Some(actuator.output_after(design.sample_time, from, command));
        (actuator.saturate(command) - from).abs() / actuator.lag
    });
    rates.reduce(f64::max).unwrap_or(f64::NAN)
}

impl DefaultFlight {
    pub(super) fn of(inputs: &Inputs, controller: &ControllerDesign) -> Result<Self, Error> {
        let flown = flight(inputs, controller, &inputs.design.manoeuvre)?;
        let table = Autopilot::new(controller)?.trim().clone();
        let rows = flown.as_ref().map_or(&[][..], |f| &f.rows);
        let design = &inputs.design;
        let uses = inputs.vehicle.actuators.iter().enumerate().map(|(j, a)| {
            let used = |command: f64| used_fraction(command, a.min, a.max);
            let most = rows.iter().map(|row| used(row.commands[j])).reduce(f64::max);
            let trims = rows.iter().map(|row| used(table.command(row.reference(SPEED), j)));
            Use {
                actuator: a.name.clone(),
                most: most.unwrap_or(f64::NAN),
                trim: trims.reduce(f64::max).unwrap_or(f64::NAN),
                rate: a
                    .rate
                    .map(|limit| largest_rate(a, rows.iter().map(|row| row.commands[j]), design) / limit),
            }
        });
        let uses = uses.collect();
        let lost = match &flown {
            None => Some("the simulation cannot be continued to its end".to_owned()),
            Some(flight) => flight.surfacing.map(|surfacing| surfacing.to_string()),
        };
        Ok(Self { uses, lost })
    }
}
