//! Closed-loop simulation of vehicle and autopilot in one process.

use crate::error::Error;
use crate::held_trim::HeldTrim;
use crate::sea::{Conditions, Sea};
pub use crate::surfacing::{Surfacing, out_of_water};
use crate::ticks::{Tick, Ticks};
use squid_auv::{
    Current, Load, PerReference, PerSignal, Pitch, Plant, Speed, State, TRACKED, VIEWS, Vehicle, View,
    trim_with,
};
use squid_scheduled::{Autopilot, ControllerDesign, Inputs, Manoeuvre, Outputs, Trim};
use std::array::from_fn;
use std::borrow::Cow;

/// Measurements and references, SI, in the order of the signals of the axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Signals {
    /// Measurement of each signal.
    pub measured: PerSignal<f64>,
    /// Absolute reference of each signal that can be tracked.
    pub references: PerReference<f64>,
}

/// Row of the record of a flight.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Time, s.
    pub time: f64,
    /// Measurements and requested references, SI.
    pub signals: Signals,
    /// References as applied by the control law, SI.
    pub used: PerReference<f64>,
    /// Depth, m.
    pub depth: f64,
    /// Scheduling parameter.
    pub rho: f64,
    /// `true` if the speed is outside the range of the design.
    pub out_of_range: bool,
    /// Commands, N or rad.
    pub commands: Vec<f64>,
}

impl Row {
    /// Returns the measurement of the signal at an index of the axis.
    pub fn measured(&self, index: usize) -> f64 {
        self.signals.measured[index]
    }

    /// Returns the reference of a signal that can be tracked.
    pub fn reference(&self, index: usize) -> f64 {
        self.signals.references[index]
    }

    /// Returns reference minus measurement.
    pub fn error(&self, index: usize) -> f64 {
        self.reference(index) - self.measured(index)
    }
}

/// Flight from trim to the end of its manoeuvre, or to the surface.
#[derive(Debug, Clone, PartialEq)]
pub struct Flight {
    /// Rows, one per tick, all below the surface.
    pub rows: Vec<Row>,
    /// Surfacing of the vehicle, if it left the water.
    pub surfacing: Option<Surfacing>,
    /// State of the sea at each tick; empty in still water.
    pub sea: Vec<SeaRow>,
}

/// State of the sea at one tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeaRow {
    /// Elevation of the surface above the still water level at the vehicle, m.
    pub elevation: f64,
    /// Velocity of the water at the vehicle.
    pub water: Current,
    /// Sensor readings, SI.
    pub read: PerSignal<f64>,
}

/// The output of a control law at a tick.
struct LawOutput {
    /// Commands, N or rad.
    commands: Vec<f64>,
    /// The references as the law used them.
    references: PerReference<f64>,
    /// The scheduling parameter.
    rho: f64,
    /// `true` if the speed is outside the range of the design.
    out_of_range: bool,
}

/// Simulates the vehicle under its autopilot in still water, from level trim at a depth \[m\] with a pitch rule.
///
/// For an axis with level flight held, surge, heave and pitch stay at the level trim for the reference speed, as under
/// a perfect longitudinal autopilot; sway, roll and yaw are free.
///
/// # Errors
/// [`Error::Trim`], [`Error::Coefficient`], [`Error::Simulation`]; [`Error::Manoeuvre`],
/// [`Error::ControllerDesign`], [`Error::Tick`].
pub fn fly(
    vehicle: &Vehicle,
    design: &ControllerDesign,
    level: (f64, &Pitch),
    manoeuvre: &Manoeuvre,
) -> Result<Flight, Error> {
    fly_varied(vehicle, design, level, manoeuvre, &Variations::default())
}

/// Simulates the vehicle under its autopilot in a sea. The autopilot receives the sensor readings; the rows of the
/// flight contain the true values. The flight starts in trim through the water, at the depth of the sea file if given,
/// and ends when the hull breaks the surface.
///
/// # Errors
/// Errors of [`fly`]; [`Error::Sea`], [`Error::NoGeometry`], [`Error::AtTheSurface`].
pub fn fly_at_sea(
    vehicle: &Vehicle,
    design: &ControllerDesign,
    level: (f64, &Pitch),
    manoeuvre: &Manoeuvre,
    sea: &Sea,
) -> Result<Flight, Error> {
    fly_varied(vehicle, design, level, manoeuvre, &Variations { sea: Some(sea), ..Variations::default() })
}

/// Returns the references as last applied by an autopilot; 0 for signals that its axis does not track.
pub fn applied_references(autopilot: &Autopilot) -> PerReference<f64> {
    from_fn(|index| autopilot.references().get(index).copied().unwrap_or_default())
}

/// Deviations of a flight from that of the nominal vehicle in still water.
#[derive(Debug, Clone, Copy, Default)]
pub struct Variations<'a> {
    /// Sea; `None` for still water.
    pub sea: Option<&'a Sea>,
    /// Gain from command to output of each actuator, up to its limits, in the order of the actuators; 1 if omitted. The
    /// rows of the flight contain the outputs.
    pub gains: &'a [f64],
    /// Initial deviation of each signal from trim, SI.
    pub off_trim: PerSignal<f64>,
    /// Disturbances, each for some time; they add.
    pub disturbances: &'a [TemporaryDisturbance],
}

/// Temporary disturbance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TemporaryDisturbance {
    /// Disturbance at full size.
    pub disturbance: Disturbance,
    /// Time at which it begins to rise, s.
    pub from: f64,
    /// Time at which it begins to fall, s.
    pub to: f64,
    /// Duration of the rise and of the fall, s; 0 for steps.
    pub rise: f64,
}

impl TemporaryDisturbance {
    /// A disturbance that begins as a step at a time, s, and stays.
    pub fn lasting(disturbance: Disturbance, from: f64) -> Self {
        Self { disturbance, from, to: f64::INFINITY, rise: 0.0 }
    }

    /// Returns a steady current.
    pub fn steady(current: Current) -> Self {
        Self::lasting(Disturbance { current, ..Disturbance::default() }, f64::NEG_INFINITY)
    }

    /// The sum of some disturbances at a time, s.
    pub(crate) fn sum(all: &[Self], time: f64) -> Disturbance {
        let mut sum = Disturbance::default();
        for Self { disturbance: Disturbance { current, load }, from, to, rise } in all {
            let way = |since: f64| match *rise {
                rise if rise > 0.0 => (since / rise).clamp(0.0, 1.0),
                _ => f64::from(since >= -ROUNDING_OF_TIME),
            };
            let part = way(time - from) - way(time - to);
            sum.current.horizontal += part * current.horizontal;
            sum.current.east += part * current.east;
            sum.current.vertical += part * current.vertical;
            sum.load.iter_mut().zip(load).for_each(|(to, one)| *to += part * one);
        }
        sum
    }
}

/// A disturbance begins and ends this much earlier \[s\], so that rounding of `k Ts` cannot delay it by a tick.
const ROUNDING_OF_TIME: f64 = 1e-9;

/// Disturbance of a flight.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Disturbance {
    /// Current. A step of the current is a step of the velocity through the water.
    pub current: Current,
    /// Force and moment on the hull, N and N m.
    pub load: Load,
}

/// Simulates the vehicle under its autopilot with deviations from the nominal flight.
///
/// # Errors
/// Errors of [`fly_at_sea`].
pub fn fly_varied(
    vehicle: &Vehicle,
    design: &ControllerDesign,
    level: (f64, &Pitch),
    manoeuvre: &Manoeuvre,
    variations: &Variations<'_>,
) -> Result<Flight, Error> {
    let own = |autopilot: &Autopilot, _: &Inputs, _: f64| autopilot.outputs().commands.clone();
    fly_with(vehicle, design, level, manoeuvre, variations, own)
}

/// Simulates the vehicle as [`fly_varied`] does, but with the commands of `law` at each tick. It gets the autopilot
/// after its tick, the values and references that this was given, and V_r \[m/s\], at which its trim is.
///
/// # Errors
/// As [`fly_varied`].
pub fn fly_with(
    vehicle: &Vehicle,
    design: &ControllerDesign,
    (depth, pitch): (f64, &Pitch),
    manoeuvre: &Manoeuvre,
    &Variations { sea, gains, off_trim, disturbances }: &Variations<'_>,
    mut law: impl FnMut(&Autopilot, &Inputs, f64) -> Vec<f64>,
) -> Result<Flight, Error> {
    manoeuvre.check_steps(design)?;
    if let Some(sea) = sea {
        sea.check(vehicle)?;
    }
    let sample_time = design.sample_time;
    let conditions = sea.map(|sea| sea.draw(vehicle, sample_time)).transpose()?;
    let level = (sea.and_then(|sea| sea.depth).unwrap_or(depth), pitch);
    let mut autopilot = Autopilot::new(design)?;
    let trims = autopilot.trim().clone();
    let mut started = false;
    let names = || design.signals.iter().map(|port| port.name.as_str());
    let has = |view: &&&'static View| view.has_signals(names());
    let unknown = || Error::NoSuchView { signals: names().collect::<Vec<_>>().join(", ") };
    let view = VIEWS.iter().find(has).ok_or_else(unknown)?;
    let start = Start::new(vehicle, view, level, manoeuvre.speed_reference(0.0), conditions, off_trim)?;
    start.fly((manoeuvre, disturbances), sample_time, &trims, |measured| {
        if !std::mem::replace(&mut started, true) {
            autopilot.initialise(0.0, measured)?;
        }
        let filtered = autopilot.filtered_speed();
        autopilot.tick(measured)?;
        let trimmed_at =
            if design.reference_filter.is_some() { filtered } else { autopilot.filtered_speed() };
        let mut commands = law(&autopilot, measured, trimmed_at);
        let Outputs { scheduling_parameter: rho, out_of_range, .. } = *autopilot.outputs();
        for ((command, gain), actuator) in commands.iter_mut().zip(gains).zip(&vehicle.actuators) {
            *command = (*command * gain).clamp(actuator.min, actuator.max);
        }
        let references = applied_references(&autopilot);
        Ok(LawOutput { commands, references, rho, out_of_range })
    })
}

/// Vehicle at the start of a flight.
struct Start {
    view: &'static View,
    plant: Plant,
    /// Origin of the depth or heading references.
    origin: f64,
    depth: f64,
    conditions: Option<Conditions>,
    /// Level flight that is held, for an axis of heading.
    level: Option<HeldTrim>,
}

impl Start {
    /// Returns a vehicle in trim at a depth, with a pitch rule and at a speed along the path, plus a deviation of each
    /// signal.
    fn new(
        vehicle: &Vehicle,
        view: &'static View,
        (depth, pitch): (f64, &Pitch),
        speed: f64,
        conditions: Option<Conditions>,
        off_trim: PerSignal<f64>,
    ) -> Result<Self, Error> {
        let plane = if view.is_level_held { Cow::Owned(vehicle.in_plane()) } else { Cow::Borrowed(vehicle) };
        let mut trim = trim_with(&plane, Speed::Path(speed), depth, pitch)
            .map_err(|reason| Error::Trim { speed, reason })?;
        let mut plant = Plant::new(vehicle)?;
        if let Some(sea) = &conditions {
            plant = plant.with_water(sea.water());
        }
        if view.is_level_held {
            trim.actuators = vec![0.0; vehicle.actuators.len()];
        }
        plant.start(0.0, &trim)?;
        let origin = view.origin(&plant.state());
        plant.set_state(&view.with_offset(plant.state(), off_trim));
        let level = view.is_level_held.then(|| HeldTrim::new(plane.into_owned(), pitch.clone(), trim));
        Ok(Self { view, plant, origin, depth, conditions, level })
    }

    fn fly(
        self,
        (manoeuvre, disturbances): (&Manoeuvre, &[TemporaryDisturbance]),
        sample_time: f64,
        trims: &Trim,
        mut law: impl FnMut(&Inputs) -> Result<LawOutput, Error>,
    ) -> Result<Flight, Error> {
        let Self { view, plant, origin, depth: initial_depth, conditions, mut level } = self;
        let duration = manoeuvre.duration;
        let steps = (duration / sample_time).round() as usize;
        let mut flight = Flight { rows: Vec::with_capacity(steps + 1), surfacing: None, sea: Vec::new() };
        let signals = trims.signals();
        let mut inputs = Inputs { measured: vec![0.0; signals], references: vec![0.0; signals.min(TRACKED)] };
        let environment = |time: f64, plant: &mut Plant| {
            let speed = manoeuvre.speed_reference(time);
            let Disturbance { current, load } = TemporaryDisturbance::sum(disturbances, time);
            let forward_speed = trims.forward_speed(speed);
            plant.set_load(load)?;
            plant.set_given_speed(forward_speed)?;
            if let Some(level) = &mut level {
                plant.hold_level(level.at(speed)?);
            }
            let mut references = PerReference::default();
            for (index, (value, signal)) in references.iter_mut().zip(view.interface.signals).enumerate() {
                *value = manoeuvre.above_trim(time, signal.name) + trims.signal(forward_speed, index, origin);
            }
            Ok((current, references))
        };
        let tick = |Tick { time, state, plant, conditions }: Tick<'_>, references| {
            let signals = Signals { measured: view.measured(&state), references };
            let mut read = signals.measured;
            if let Some(sea) = conditions {
                read = sea.read(&signals.measured);
                let elevation = sea.surroundings().elevation(time, [state.x, state.east]);
                flight.sea.push(SeaRow { elevation, water: plant.flow(), read });
            }
            inputs.measured.iter_mut().zip(read).for_each(|(to, from)| *to = from);
            inputs.references.iter_mut().zip(references).for_each(|(to, from)| *to = from);
            let LawOutput { commands, references, rho, out_of_range } = law(&inputs)?;
            for (i, command) in commands.iter().enumerate() {
                plant.set_command(i, *command)?;
            }
            let depth = state.depth;
            flight.rows.push(Row { time, signals, used: references, depth, rho, out_of_range, commands });
            Ok(())
        };
        flight.surfacing = Ticks { plant, conditions, sample_time, duration }.fly(environment, tick)?;
        if flight.rows.is_empty() { Err(Error::AtTheSurface { depth: initial_depth }) } else { Ok(flight) }
    }
}

/// Returns the flight, or `None` if the autopilot or the motion diverged.
///
/// # Errors
/// All other errors.
pub fn unless_lost(result: Result<Flight, Error>) -> Result<Option<Flight>, Error> {
    match result {
        Err(Error::Tick(_) | Error::Simulation(_)) => Ok(None),
        result => result.map(Some),
    }
}

/// Step of one actuator command.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ActuatorStep {
    /// Index of the actuator.
    pub actuator: usize,
    /// Height of the step, N or rad.
    pub height: f64,
}

/// Simulates the open-loop response to a step of one actuator from trim at a speed, up to the surface; returns time (s)
/// and the deviation from trim (rad) of the first signal of a view, an angle.
///
/// # Errors
/// [`Error::Trim`], [`Error::Simulation`].
pub fn fly_open_loop(
    vehicle: &Vehicle,
    view: &'static View,
    level: (f64, &Pitch),
    speed: f64,
    step: ActuatorStep,
    interval: f64,
    duration: f64,
) -> Result<Vec<(f64, f64)>, Error> {
    let Start { mut plant, level: held_trim, .. } =
        Start::new(vehicle, view, level, speed, None, PerSignal::default())?;
    if let Some(held_trim) = &held_trim {
        plant.hold_level(held_trim.trim());
    }
    let angle = |state: &State| (view.sensed[0].value)(state);
    let start = angle(&plant.state());
    let trimmed = plant.outputs()[step.actuator];
    plant.set_command(step.actuator, trimmed + step.height)?;
    let steps = (duration / interval).round() as u64;
    let mut rows = vec![(0.0, 0.0)];
    for k in 1..=steps {
        let time = k as f64 * interval;
        plant.advance(time)?;
        if out_of_water(plant.state().depth) {
            break;
        }
        rows.push((time, angle(&plant.state()) - start));
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use squid_design::inputs::Inputs;
    use std::path::Path;

    /// Pitching up 10 degrees from a metre below the surface, Squid with its committed design leaves the water, and all
    /// rows are below the surface.
    #[test]
    fn flight_ends_at_the_surface() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../vehicles/squid");
        let inputs = Inputs::read(&folder, "design").unwrap();
        let frozen = squid_base::files::read(&folder.join("frozen/controller.json")).unwrap();
        let design = ControllerDesign::from_json(&frozen).unwrap();
        let manoeuvre = &inputs.design.manoeuvre;
        let fly_from = |depth| fly(&inputs.vehicle, &design, (depth, &Pitch::Free), manoeuvre).unwrap();
        let deep = fly_from(50.0);
        assert_eq!((deep.surfacing, deep.rows.len()), (None, 3001));

        let flight = fly_from(1.0);
        let Surfacing { time, speed } = flight.surfacing.unwrap();
        let last = flight.rows.last().unwrap();
        assert!((last.time + design.sample_time - time).abs() < 1e-9, "{time}");
        assert!(last.depth.abs() < 0.05 && flight.rows.iter().all(|row| !out_of_water(row.depth)));
        // The step is at 10 s; rising a metre at 1 m/s and 10 degrees takes about 5 s.
        assert!((12.0..20.0).contains(&time) && (0.6..2.9).contains(&speed), "{time} s, {speed} m/s");
    }
}
