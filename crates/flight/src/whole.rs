//! Closed-loop simulation in six degrees of freedom: one autopilot for each axis.

use crate::error::Error;
use crate::flight::{Flight, Row, SeaRow, Signals, Spell, Variations, used};
use crate::surfacing::Surfacing;
use crate::ticks::{Tick, Ticks};
use squid_auv::longitudinal::SPEED;
use squid_auv::{Each, EachTracked, LONGITUDINAL, Pitch, Plant, Speed, State, VIEWS, Vehicle, trim_with};
use squid_scheduled::{Autopilot, ControllerDesign, Inputs, Manoeuvre, Outputs};

/// A flight from trim to the end of its manoeuvre, or to the surface.
#[derive(Debug, Clone, PartialEq)]
pub struct WholeFlight {
    /// Position and motion at each tick, all in the water; the heading counts on.
    pub states: Vec<State>,
    /// The flight as each axis has it, in the order of the designs: its signals, and its actuators' commands.
    pub axes: Vec<Flight>,
    /// The output of each actuator in the trim at the start, where those stay that no axis commands.
    pub held: Vec<f64>,
}

impl WholeFlight {
    /// When the vehicle left the water, if it did.
    pub fn surfacing(&self) -> Option<Surfacing> {
        self.axes.first().and_then(|flight| flight.surfacing)
    }
}

/// The autopilot of an axis, and where its actuators are among those of the vehicle.
struct Axis {
    autopilot: Autopilot,
    inputs: Inputs,
    /// Its place among [`VIEWS`].
    view: usize,
    actuators: Vec<usize>,
    flight: Flight,
}

impl Axis {
    fn new(vehicle: &Vehicle, design: &ControllerDesign, ticks: usize) -> Result<Self, Error> {
        let place = |name: &String| vehicle.actuators.iter().position(|one| one.name == *name);
        let known = |one: &squid_scheduled::Actuator| {
            place(&one.name).ok_or_else(|| Error::NoSuchActuator { name: one.name.clone() })
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
            actuators: design.actuators.iter().map(known).collect::<Result<_, _>>()?,
            flight: Flight { rows: Vec::with_capacity(ticks), surfacing: None, sea: Vec::new() },
        })
    }

    /// The references of a manoeuvre above a start.
    fn references(&self, start: &State, manoeuvre: &Manoeuvre, time: f64) -> EachTracked<f64> {
        let (view, trims) = (VIEWS[self.view], self.autopilot.trim());
        let forward = trims.forward_speed(manoeuvre.speed_reference(time));
        let origin = view.origin(start);
        let mut all = EachTracked::default();
        for (place, (value, signal)) in all.iter_mut().zip(view.interface.signals).enumerate() {
            let above = if place == SPEED { 0.0 } else { manoeuvre.above_trim(time, signal.name) };
            *value = trims.signal(forward, place, origin) + above;
        }
        all
    }

    /// Runs a tick on what the sensors of the vehicle read.
    fn tick(&mut self, read: &Each<f64>, signals: Signals, (time, depth): (f64, f64)) -> Result<(), Error> {
        let Self { autopilot, inputs, flight, .. } = self;
        inputs.measured.iter_mut().zip(read).for_each(|(to, from)| *to = *from);
        inputs.references.iter_mut().zip(signals.references).for_each(|(to, from)| *to = from);
        if flight.rows.is_empty() {
            autopilot.initialise(0.0, inputs)?;
        }
        autopilot.tick(inputs)?;
        let Outputs { commands, scheduling_parameter: rho, out_of_range, .. } = autopilot.outputs().clone();
        let used = used(autopilot);
        flight.rows.push(Row { time, signals, used, depth, rho, out_of_range, commands });
        Ok(())
    }
}

/// Simulates a vehicle in six degrees of freedom under the autopilots of its axes, from level trim through the water at
/// a depth \[m\], that of the sea if it has one, with a rule for its pitch; what varies is as for an axis alone, with a
/// gain for each actuator of the vehicle, and deviations from trim of surge, heave and pitch. The vehicle faces north
/// at the start. The steps of the manoeuvre are those of all axes, and begin at the same time. The flight ends at the
/// surface, since the equations of motion hold in deep water only.
///
/// # Errors
/// [`Error::Trim`], [`Error::Simulation`], [`Error::Manoeuvre`]; those of the autopilots and of the sea;
/// [`Error::NoSuchActuator`]; [`Error::OtherSampleTime`]; [`Error::AtTheSurface`].
pub fn fly_whole(
    vehicle: &Vehicle,
    designs: &[&ControllerDesign],
    (depth, pitch): (f64, &Pitch),
    manoeuvre: &Manoeuvre,
    &Variations { sea, gains, off_trim, spells }: &Variations<'_>,
) -> Result<WholeFlight, Error> {
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
    let first = Spell::sum(spells, 0.0);
    plant.set_current(first.current)?;
    plant.start(0.0, &squid_auv::Trim { actuators: actuators.clone(), ..level })?;
    let start = plant.state();
    plant.set_state(&LONGITUDINAL.displaced(start, off_trim));
    let mut states = Vec::with_capacity(ticks);
    let outside = |time: f64, plant: &mut Plant| {
        let now = Spell::sum(spells, time);
        plant.set_load(now.load)?;
        if let Some(trims) = &trims {
            plant.set_given_speed(trims.forward_speed(manoeuvre.speed_reference(time)))?;
        }
        Ok((now.current, ()))
    };
    let tick = |Tick { time, state, plant, conditions }: Tick<'_>, ()| {
        let measured = VIEWS.map(|view| view.measured(&state));
        let mut read = measured;
        if let Some(sea) = conditions {
            read = sea.read_all(&measured);
            let elevation = sea.surroundings().elevation(time, [state.x, state.east]);
            for axis in &mut axes {
                axis.flight.sea.push(SeaRow { elevation, water: plant.flow(), read: read[axis.view] });
            }
        }
        for axis in &mut axes {
            let references = axis.references(&start, manoeuvre, time);
            let signals = Signals { measured: measured[axis.view], references };
            axis.tick(&read[axis.view], signals, (time, state.depth))?;
            let Some(Row { commands, .. }) = axis.flight.rows.last_mut() else { continue };
            for (place, command) in axis.actuators.iter().zip(commands) {
                let (actuator, gain) = (&vehicle.actuators[*place], gains.get(*place).copied());
                if let Some(gain) = gain {
                    *command = (*command * gain).clamp(actuator.min, actuator.max);
                }
                plant.set_command(*place, *command)?;
            }
        }
        states.push(state);
        Ok(())
    };
    let surfacing = Ticks { plant, conditions, sample_time, duration }.fly(outside, tick)?;
    let mut axes: Vec<Flight> = axes.into_iter().map(|axis| axis.flight).collect();
    axes.iter_mut().for_each(|flight| flight.surfacing = surfacing);
    if states.is_empty() {
        Err(Error::AtTheSurface { depth })
    } else {
        Ok(WholeFlight { states, axes, held: actuators })
    }
}
