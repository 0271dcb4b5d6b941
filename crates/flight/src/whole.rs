//! Closed-loop simulation in six degrees of freedom: one autopilot for each axis.

use crate::error::Error;
use crate::sea::Sea;
use crate::surfacing::Surfacing;
use crate::ticks::{Tick, Ticks};
use auv::longitudinal::{Each, SPEED};
use auv::{Current, LATERAL, LONGITUDINAL, Pitch, Plant, Speed, State, Vehicle, View, trim_with};
use scheduled::{Autopilot, ControllerDesign, Inputs, Manoeuvre};

/// A row of a flight, one a tick.
#[derive(Debug, Clone, PartialEq)]
pub struct WholeRow {
    /// Time, s.
    pub time: f64,
    /// Position and motion; the heading counts on.
    pub state: State,
    /// The references of each axis as its law used them, SI.
    pub used: Vec<Vec<f64>>,
    /// The command of each actuator of the vehicle, N or rad.
    pub commands: Vec<f64>,
    /// What the sensors of each axis read, of surge, heave and pitch first, SI.
    pub read: [Each<f64>; 2],
    /// Velocity of the water at the vehicle.
    pub water: Current,
    /// Elevation of the surface above still water at the vehicle, m.
    pub elevation: f64,
}

/// A flight from trim to the end of its manoeuvre, or to the surface.
#[derive(Debug, Clone, PartialEq)]
pub struct WholeFlight {
    /// One row a tick, all in the water.
    pub rows: Vec<WholeRow>,
    /// When the vehicle left the water, if it did.
    pub surfacing: Option<Surfacing>,
}

/// What the axes control, in the order of the readings of their sensors.
const VIEWS: [&View; 2] = [&LONGITUDINAL, &LATERAL];

/// The autopilot of an axis, and where its actuators are among those of the vehicle.
struct Axis {
    autopilot: Autopilot,
    inputs: Inputs,
    /// Its place among [`VIEWS`].
    view: usize,
    actuators: Vec<usize>,
}

impl Axis {
    fn new(vehicle: &Vehicle, design: &ControllerDesign) -> Result<Self, Error> {
        let place = |name: &String| vehicle.actuators.iter().position(|one| one.name == *name);
        let known = |one: &scheduled::Actuator| {
            place(&one.name).ok_or_else(|| Error::NoSuchActuator { name: one.name.clone() })
        };
        Ok(Self {
            autopilot: Autopilot::new(design)?,
            inputs: Inputs {
                measured: vec![0.0; design.signals.len()],
                references: vec![0.0; design.references().count()],
            },
            view: VIEWS.iter().position(|view| is_of(design, view)).unwrap_or_default(),
            actuators: design.actuators.iter().map(known).collect::<Result<_, _>>()?,
        })
    }

    /// Takes what the sensors of both axes read, and the demand of a manoeuvre above a start.
    fn look(&mut self, read: &[Each<f64>; 2], (start, manoeuvre, time): (&State, &Manoeuvre, f64)) {
        let Self { autopilot, inputs, view, .. } = self;
        inputs.measured.copy_from_slice(&read[*view]);
        let view = VIEWS[*view];
        let trims = autopilot.trim();
        let forward = trims.forward_speed(manoeuvre.speed_reference(time));
        let (origin, signals) = (view.origin(start), view.interface.signals);
        for (place, reference) in inputs.references.iter_mut().enumerate() {
            let above = if place == SPEED { 0.0 } else { manoeuvre.above_trim(time, signals[place].name) };
            *reference = trims.signal(forward, place, origin) + above;
        }
    }
}

/// Whether a design is of an axis of a view, by the names of its signals.
fn is_of(design: &ControllerDesign, view: &View) -> bool {
    design.signals.iter().map(|port| port.name.as_str()).eq(view.interface.signals.iter().map(|one| one.name))
}

/// Simulates a vehicle that leaves the vertical plane under an autopilot of surge, heave and pitch and one of heading,
/// in a steady current and, beside it, a sea, from level trim through the water at a depth \[m\], that of the sea if it
/// has one, with a rule for its pitch. The vehicle faces north at the start. The steps of the manoeuvre are those of
/// both axes, and begin at the same time. The flight ends at the surface, since the equations of motion hold in deep
/// water only.
///
/// # Errors
/// [`Error::Trim`], [`Error::Simulation`]; those of the autopilots and of the sea; [`Error::NoSuchActuator`];
/// [`Error::OtherSampleTime`]; [`Error::AtTheSurface`].
pub fn fly_whole(
    vehicle: &Vehicle,
    designs: [&ControllerDesign; 2],
    (depth, pitch): (f64, &Pitch),
    manoeuvre: &Manoeuvre,
    (current, sea): (Current, Option<&Sea>),
) -> Result<WholeFlight, Error> {
    let [sample_time, other] = designs.map(|design| design.sample_time);
    if sample_time != other {
        return Err(Error::OtherSampleTime { one: sample_time, other });
    }
    let conditions = sea.map(|sea| sea.draw(vehicle, sample_time)).transpose()?;
    let depth = sea.and_then(|sea| sea.depth).unwrap_or(depth);
    let speed = manoeuvre.speed_reference(0.0);
    let plane = vehicle.in_plane();
    let level = trim_with(&plane, Speed::Path(speed), depth, pitch)
        .map_err(|reason| Error::Trim { speed, reason })?;
    let mut axes = [Axis::new(vehicle, designs[0])?, Axis::new(vehicle, designs[1])?];
    let mut plant = Plant::new(vehicle)?;
    if let Some(sea) = &conditions {
        plant = plant.with_water(sea.water());
    }
    plant.set_current(current)?;
    let actuators = vehicle.outputs_of_plane(&plane, &level.actuators);
    plant.start(0.0, &auv::Trim { actuators, ..level })?;
    let start = plant.state();
    let duration = manoeuvre.duration;
    let steps = (duration / sample_time).round() as usize;
    let mut flight = WholeFlight { rows: Vec::with_capacity(steps + 1), surfacing: None };
    let tick = |Tick { time, state, plant, conditions }: Tick<'_>, ()| {
        let mut read = VIEWS.map(|view| (view.measured)(&state));
        let mut elevation = 0.0;
        if let Some(sea) = conditions {
            read = sea.read_both(&read);
            elevation = sea.surroundings().elevation(time, [state.x, state.east]);
        }
        let water = plant.flow();
        let mut commands = plant.outputs().to_vec();
        for axis in &mut axes {
            axis.look(&read, (&start, manoeuvre, time));
            if flight.rows.is_empty() {
                axis.autopilot.initialise(0.0, &axis.inputs)?;
            }
            axis.autopilot.tick(&axis.inputs)?;
            for (place, command) in axis.actuators.iter().zip(&axis.autopilot.outputs().commands) {
                commands[*place] = *command;
                plant.set_command(*place, *command)?;
            }
        }
        let used = axes.iter().map(|axis| axis.autopilot.references().to_vec()).collect();
        flight.rows.push(WholeRow { time, state, used, commands, read, water, elevation });
        Ok(())
    };
    flight.surfacing =
        Ticks { plant, conditions, sample_time, duration }.fly(|_, _| Ok((current, ())), tick)?;
    if flight.rows.is_empty() { Err(Error::AtTheSurface { depth }) } else { Ok(flight) }
}
