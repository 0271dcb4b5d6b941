//! Closed-loop simulation in six degrees of freedom: one autopilot for each axis.

use crate::error::Error;
use auv::longitudinal::{self, SPEED};
use auv::{Current, Pitch, Plant, Speed, State, Vehicle, lateral, trim_with};
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
}

/// The autopilot of an axis, and where its actuators are among those of the vehicle.
struct Axis {
    autopilot: Autopilot,
    inputs: Inputs,
    is_lateral: bool,
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
            is_lateral: design.place(lateral::SIGNALS[lateral::HEADING].name).is_some(),
            actuators: design.actuators.iter().map(known).collect::<Result<_, _>>()?,
        })
    }

    /// Takes the state, and the demand of a manoeuvre above a start.
    fn look(&mut self, state: &State, (start, manoeuvre, time): (&State, &Manoeuvre, f64)) {
        let Self { autopilot, inputs, is_lateral, .. } = self;
        let motion = &state.motion;
        let measured = if *is_lateral {
            lateral::measured(motion, state.heading)
        } else {
            // What is measured is the rate of pitch, and not that about the axis of the body.
            longitudinal::measured([motion.u, motion.w, motion.turning()[1], motion.theta, state.depth])
        };
        inputs.measured.copy_from_slice(&measured);
        let trims = autopilot.trim();
        let forward = trims.forward_speed(manoeuvre.speed_reference(time));
        let origin = if *is_lateral { start.heading } else { start.depth };
        let signals = if *is_lateral { &lateral::SIGNALS } else { &longitudinal::SIGNALS };
        for (place, reference) in inputs.references.iter_mut().enumerate() {
            let above = if place == SPEED { 0.0 } else { manoeuvre.above_trim(time, signals[place].name) };
            *reference = trims.signal(forward, place, origin) + above;
        }
    }
}

/// Simulates a vehicle that leaves the vertical plane under an autopilot of surge, heave and pitch and one of heading,
/// in a steady current, from level trim at a depth \[m\] with a rule for its pitch. The steps of the manoeuvre are
/// those of both axes, and begin at the same time.
///
/// # Errors
/// [`Error::Trim`], [`Error::Simulation`]; those of the autopilots; [`Error::NoSuchActuator`];
/// [`Error::OtherSampleTime`].
pub fn fly_whole(
    vehicle: &Vehicle,
    designs: [&ControllerDesign; 2],
    (depth, pitch): (f64, &Pitch),
    manoeuvre: &Manoeuvre,
    current: Current,
) -> Result<Vec<WholeRow>, Error> {
    let [sample_time, other] = designs.map(|design| design.sample_time);
    if sample_time != other {
        return Err(Error::OtherSampleTime { one: sample_time, other });
    }
    let speed = manoeuvre.speed_reference(0.0);
    let plane = vehicle.in_plane();
    let level = trim_with(&plane, Speed::Path(speed), depth, pitch)
        .map_err(|reason| Error::Trim { speed, reason })?;
    let mut axes = [Axis::new(vehicle, designs[0])?, Axis::new(vehicle, designs[1])?];
    let mut plant = Plant::new(vehicle)?;
    plant.set_current(current)?;
    let actuators = vehicle.outputs_of_plane(&plane, &level.actuators);
    plant.start(0.0, &auv::Trim { actuators, ..level })?;
    let start = plant.state();
    let steps = (manoeuvre.duration / sample_time).round() as u64;
    let mut rows = Vec::with_capacity(steps as usize + 1);
    for k in 0..=steps {
        let time = k as f64 * sample_time;
        let state = plant.state();
        let mut commands = plant.outputs().to_vec();
        for axis in &mut axes {
            axis.look(&state, (&start, manoeuvre, time));
            if k == 0 {
                axis.autopilot.initialise(0.0, &axis.inputs)?;
            }
            axis.autopilot.tick(&axis.inputs)?;
            for (place, command) in axis.actuators.iter().zip(&axis.autopilot.outputs().commands) {
                commands[*place] = *command;
                plant.set_command(*place, *command)?;
            }
        }
        let used = axes.iter().map(|axis| axis.autopilot.references().to_vec()).collect();
        rows.push(WholeRow { time, state, used, commands });
        plant.advance((k + 1) as f64 * sample_time)?;
    }
    Ok(rows)
}
