//! Closed-loop simulation in six degrees of freedom: one autopilot per axis.

use crate::error::Error;
use crate::flight::{Flight, Row, SeaRow, Signals, TemporaryDisturbance, Variations, applied_references};
use crate::surfacing::Surfacing;
use crate::ticks::{Tick, Ticks};
use squid_auv::longitudinal::SPEED;
use squid_auv::{
    LONGITUDINAL, PerReference, PerSignal, Pitch, Plant, Speed, State, VIEWS, Vehicle, trim_with,
};
use squid_scheduled::{Autopilot, ControllerDesign, Inputs, Manoeuvre, Outputs};

/// Flight in six degrees of freedom, from trim to the end of its manoeuvre, or to the surface.
#[derive(Debug, Clone, PartialEq)]
pub struct SixDofFlight {
    /// Position and motion at each tick, all below the surface; the heading is not wrapped.
    pub states: Vec<State>,
    /// Flight of each axis, in the order of the designs: its signals, and the commands of its actuators.
    pub axes: Vec<Flight>,
    /// Output of each actuator in the initial trim, kept by actuators that no axis commands.
    pub held: Vec<f64>,
}

impl SixDofFlight {
    /// Returns the surfacing of the vehicle, if it left the water.
    pub fn surfacing(&self) -> Option<Surfacing> {
        self.axes.first().and_then(|flight| flight.surfacing)
    }
}

/// Autopilot of an axis, and the indices of its actuators.
struct Axis {
    autopilot: Autopilot,
    inputs: Inputs,
    /// Index in [`VIEWS`].
    view: usize,
    actuators: Vec<usize>,
    flight: Flight,
}

impl Axis {
    fn new(vehicle: &Vehicle, design: &ControllerDesign, ticks: usize) -> Result<Self, Error> {
        let index = |name: &String| vehicle.actuators.iter().position(|one| one.name == *name);
        let index_of = |one: &squid_scheduled::Actuator| {
            index(&one.name).ok_or_else(|| Error::NoSuchActuator { name: one.name.clone() })
        };
        let names = || design.signals.iter().map(|port| port.name.as_str());
        let unknown = || Error::NoSuchView { signals: names().collect::<Vec<_>>().join(", ") };
        Ok(Self {
            autopilot: Autopilot::new(design)?,
            inputs: Inputs {
                measured: vec![0.0; design.signals.len()],
                references: vec![0.0; design.references().count()],
            },
            view: VIEWS.iter().position(|view| view.has_signals(names())).ok_or_else(unknown)?,
            actuators: design.actuators.iter().map(index_of).collect::<Result<_, _>>()?,
            flight: Flight { rows: Vec::with_capacity(ticks), surfacing: None, sea: Vec::new() },
        })
    }

    /// Returns the references of a manoeuvre relative to a start.
    fn references(&self, start: &State, manoeuvre: &Manoeuvre, time: f64) -> PerReference<f64> {
        let (view, trims) = (VIEWS[self.view], self.autopilot.trim());
        let forward = trims.forward_speed(manoeuvre.speed_reference(time));
        let origin = view.origin(start);
        let mut all = PerReference::default();
        for (index, (value, signal)) in all.iter_mut().zip(view.interface.signals).enumerate() {
            let above = if index == SPEED { 0.0 } else { manoeuvre.above_trim(time, signal.name) };
            *value = trims.signal(forward, index, origin) + above;
        }
        all
    }

    /// Runs a tick with the sensor readings.
    fn tick(
        &mut self,
        readings: &PerSignal<f64>,
        signals: Signals,
        (time, depth): (f64, f64),
    ) -> Result<(), Error> {
        let Self { autopilot, inputs, flight, .. } = self;
        inputs.measured.iter_mut().zip(readings).for_each(|(to, from)| *to = *from);
        inputs.references.iter_mut().zip(signals.references).for_each(|(to, from)| *to = from);
        if flight.rows.is_empty() {
            autopilot.initialise(0.0, inputs)?;
        }
        autopilot.tick(inputs)?;
        let Outputs { commands, scheduling_parameter: rho, out_of_range, .. } = autopilot.outputs().clone();
        let used = applied_references(autopilot);
        flight.rows.push(Row { time, signals, used, depth, rho, out_of_range, commands });
        Ok(())
    }
}

/// Simulates a vehicle in six degrees of freedom under the autopilots of its axes, from level trim through the water
/// with a pitch rule, at a depth \[m\] or that of the sea file. The variations are those of a single axis, with a gain
/// for each actuator of the vehicle, and longitudinal deviations from trim. The vehicle initially faces north. The
/// steps of the manoeuvre in all axes begin at the same time. The flight ends at the surface, since the equations of
/// motion hold in deep water only.
///
/// # Errors
/// [`Error::Trim`], [`Error::Simulation`], [`Error::Manoeuvre`]; those of the autopilots and of the sea;
/// [`Error::NoSuchActuator`]; [`Error::OtherSampleTime`]; [`Error::AtTheSurface`].
pub fn fly_six_dof(
    vehicle: &Vehicle,
    designs: &[&ControllerDesign],
    (depth, pitch): (f64, &Pitch),
    manoeuvre: &Manoeuvre,
    &Variations { sea, gains, off_trim, disturbances }: &Variations<'_>,
) -> Result<SixDofFlight, Error> {
    let sample_time = designs.first().map_or(f64::NAN, |design| design.sample_time);
    if let Some(design) = designs.iter().find(|design| design.sample_time != sample_time) {
        return Err(Error::OtherSampleTime { one: sample_time, other: design.sample_time });
    }
    manoeuvre.check_steps_of(designs)?;
    let conditions = sea.map(|sea| sea.draw(vehicle, sample_time)).transpose()?;
    let depth = sea.and_then(|sea| sea.depth).unwrap_or(depth);
    let speed = manoeuvre.speed_reference(0.0);
    let plane = vehicle.in_plane();
    let level = trim_with(&plane, Speed::Path(speed), depth, pitch)
        .map_err(|reason| Error::Trim { speed, reason })?;
    let duration = manoeuvre.duration;
    let ticks = (duration / sample_time).round() as usize + 1;
    let axes = designs.iter().map(|design| Axis::new(vehicle, design, ticks));
    let mut axes: Vec<Axis> = axes.collect::<Result<_, _>>()?;
    let trims = axes.first().map(|axis| axis.autopilot.trim().clone());
    let mut plant = Plant::new(vehicle)?;
    if let Some(sea) = &conditions {
        plant = plant.with_water(sea.water());
    }
    let actuators = vehicle.outputs_of_plane(&plane, &level.actuators);
    let first = TemporaryDisturbance::sum(disturbances, 0.0);
    plant.set_current(first.current)?;
    plant.start(0.0, &squid_auv::Trim { actuators: actuators.clone(), ..level })?;
    let start = plant.state();
    plant.set_state(&LONGITUDINAL.with_offset(start, off_trim));
    let mut states = Vec::with_capacity(ticks);
    let environment = |time: f64, plant: &mut Plant| {
        let present = TemporaryDisturbance::sum(disturbances, time);
        plant.set_load(present.load)?;
        if let Some(trims) = &trims {
            plant.set_given_speed(trims.forward_speed(manoeuvre.speed_reference(time)))?;
        }
        Ok((present.current, ()))
    };
    let tick = |Tick { time, state, plant, conditions }: Tick<'_>, ()| {
        let measured = VIEWS.map(|view| view.measured(&state));
        let mut readings = measured;
        if let Some(sea) = conditions {
            readings = sea.read_all(&measured);
            let elevation = sea.surroundings().elevation(time, [state.x, state.east]);
            for axis in &mut axes {
                axis.flight.sea.push(SeaRow { elevation, water: plant.flow(), read: readings[axis.view] });
            }
        }
        for axis in &mut axes {
            let references = axis.references(&start, manoeuvre, time);
            let signals = Signals { measured: measured[axis.view], references };
            axis.tick(&readings[axis.view], signals, (time, state.depth))?;
            let Some(Row { commands, .. }) = axis.flight.rows.last_mut() else { continue };
            for (index, command) in axis.actuators.iter().zip(commands) {
                let (actuator, gain) = (&vehicle.actuators[*index], gains.get(*index).copied());
                if let Some(gain) = gain {
                    *command = (*command * gain).clamp(actuator.min, actuator.max);
                }
                plant.set_command(*index, *command)?;
            }
        }
        states.push(state);
        Ok(())
    };
    let surfacing = Ticks { plant, conditions, sample_time, duration }.fly(environment, tick)?;
    let mut axes: Vec<Flight> = axes.into_iter().map(|axis| axis.flight).collect();
    axes.iter_mut().for_each(|flight| flight.surfacing = surfacing);
    if states.is_empty() {
        Err(Error::AtTheSurface { depth })
    } else {
        Ok(SixDofFlight { states, axes, held: actuators })
    }
}
