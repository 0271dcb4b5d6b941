//! The whole state of a plant, which can be saved and restored.

use crate::motion::dynamics::{Dynamics, Motion};
use crate::simulation::current::Current;
use crate::simulation::error::{SimulationError, finite};
use crate::simulation::load::Load;
use crate::simulation::plant::{Fidelity, Plant, State};
use crate::simulation::slopes::Slopes;
use crate::vehicle::coefficients::{CoefficientError, Coefficients};

/// The state of a [`Plant`]: all but the vehicle's actuators, its LPV model, its [`Water`](crate::Water) and whether
/// level flight is held.
#[derive(Clone, Debug, PartialEq)]
pub struct Snapshot {
    /// Coefficients in use.
    pub coefficients: Coefficients,
    /// Which equations of motion are integrated.
    pub fidelity: Fidelity,
    /// The time reached \[s\].
    pub time: f64,
    /// Position and motion.
    pub state: State,
    /// The output of each actuator \[N or rad\].
    pub outputs: Vec<f64>,
    /// The command of each actuator \[N or rad\].
    pub commands: Vec<f64>,
    /// The current.
    pub current: Current,
    /// Speed at which the LPV model is evaluated \[m/s\].
    pub operating_speed: f64,
    /// The speed that is given to a vehicle that takes one \[m/s\].
    pub given_speed: f64,
    /// The load from outside.
    pub load: Load,
    /// The rates at which the inputs change.
    pub slopes: Slopes,
    /// The step size that the integrator last proposed \[s\].
    pub integrator_step: f64,
}

/// Why a snapshot does not fit this plant.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SnapshotError {
    /// A coefficient is not allowed.
    #[error(transparent)]
    Coefficients(#[from] CoefficientError),
    /// A number is not finite, actuators are missing, or there is no LPV model.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
}

impl Plant {
    /// Returns the whole state; a plant restored from it continues identically, bit for bit.
    pub fn snapshot(&self) -> Snapshot {
        Snapshot {
            coefficients: self.dynamics.coefficients().clone(),
            fidelity: self.fidelity,
            time: self.time,
            state: self.state(),
            outputs: self.outputs.clone(),
            commands: self.commands.clone(),
            current: self.current,
            operating_speed: self.operating_speed,
            given_speed: self.given_speed,
            load: self.load,
            slopes: self.slopes.clone(),
            integrator_step: self.integrator.step(),
        }
    }

    /// Puts a plant of the same vehicle into the state of a snapshot.
    ///
    /// # Errors
    /// [`SnapshotError`]; the plant is then as it was.
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<(), SnapshotError> {
        let Snapshot { coefficients, outputs, commands, state, current, .. } = snapshot;
        let dynamics = Dynamics::new(coefficients)?;
        let expected = self.actuators().len();
        for found in [outputs.len(), commands.len()] {
            if found != expected {
                return Err(SimulationError::TrimActuators { found, expected }.into());
            }
        }
        let Motion { u, v, w, p, q, r, phi, theta } = state.motion;
        let place = [state.x, state.east, state.depth, state.heading];
        let numbers = [u, v, w, p, q, r, phi, theta].into_iter().chain(place).chain(current.in_earth());
        let speeds = [snapshot.operating_speed, snapshot.given_speed];
        let others = [snapshot.time, speeds[0], speeds[1], snapshot.integrator_step];
        for number in numbers {
            finite("stored number", number)?;
        }
        for &number in others.iter().chain(&snapshot.load).chain(outputs).chain(commands) {
            finite("stored number", number)?;
        }
        self.set_fidelity(snapshot.fidelity)?;
        self.set_slopes(&snapshot.slopes)?;
        self.dynamics = dynamics;
        self.time = snapshot.time;
        self.set_state(&snapshot.state);
        self.outputs.copy_from_slice(&snapshot.outputs);
        self.commands.copy_from_slice(&snapshot.commands);
        self.current = snapshot.current;
        [self.operating_speed, self.given_speed] = speeds;
        self.load = snapshot.load;
        self.integrator.set_step(snapshot.integrator_step);
        Ok(())
    }
}
