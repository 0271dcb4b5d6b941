//! Complete state of a plant, which can be saved and restored.

use crate::motion::dynamics::{Dynamics, Motion};
use crate::simulation::current::Current;
use crate::simulation::error::{SimulationError, finite};
use crate::simulation::load::Load;
use crate::simulation::plant::{Fidelity, Plant, State};
use crate::simulation::slopes::Slopes;
use crate::vehicle::coefficients::{CoefficientError, Coefficients};

/// State of a [`Plant`], without the vehicle's actuators, its LPV model, its [`Water`](crate::Water) and whether level
/// flight is held.
#[derive(Clone, Debug, PartialEq)]
pub struct Snapshot {
    /// Coefficients in use.
    pub coefficients: Coefficients,
    /// Equations of motion in use.
    pub fidelity: Fidelity,
    /// Time \[s\].
    pub time: f64,
    /// Position and motion.
    pub state: State,
    /// Output of each actuator \[N or rad\].
    pub outputs: Vec<f64>,
    /// Command of each actuator \[N or rad\].
    pub commands: Vec<f64>,
    /// Current.
    pub current: Current,
    /// Speed at which the LPV model is evaluated \[m/s\].
    pub operating_speed: f64,
    /// Given speed \[m/s\]; unused by vehicles with free surge.
    pub given_speed: f64,
    /// External load.
    pub load: Load,
    /// Rates of change of the inputs.
    pub slopes: Slopes,
    /// Step size last proposed by the integrator \[s\].
    pub integrator_step: f64,
}

/// Reason why a snapshot does not fit a plant.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SnapshotError {
    /// A coefficient that is not allowed.
    #[error(transparent)]
    Coefficients(#[from] CoefficientError),
    /// A number that is not finite, missing actuators, or a missing LPV model.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
}

impl Plant {
    /// Returns the complete state; a plant restored from it continues identically, bit for bit.
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

    /// Restores a plant of the same vehicle to the state of a snapshot.
    ///
    /// # Errors
    /// [`SnapshotError`]; the plant is unchanged then.
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
        let position = [state.x, state.east, state.depth, state.heading];
        let numbers = [u, v, w, p, q, r, phi, theta].into_iter().chain(position).chain(current.in_earth());
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
