//! Contents of the saved state of a simulation.

use squid_auv::{COEFFICIENTS, Coefficients, Current, Fidelity, Motion, Snapshot, State};
use squid_fmi2::{SavedState, StateError};

use crate::PlantModel;
use crate::model::Launch;

impl PlantModel {
    /// Writes settings, inputs, trim and the complete motion, or reads them into a plant of the same vehicle.
    pub(crate) fn pass(&mut self, state: &mut dyn SavedState) -> Result<(), StateError> {
        let mut in_waves = self.surroundings.is_some();
        let settings = &mut self.settings;
        pass_coefficients(&mut settings.coefficients, state)?;
        state.each(&mut [
            &mut settings.initial_speed,
            &mut settings.initial_depth,
            &mut settings.initial_heading,
        ])?;
        pass_fidelity(&mut settings.fidelity, state)?;
        settings.waves.pass(state)?;
        state.boolean(&mut in_waves)?;
        let inputs = &mut self.inputs;
        state.reals(&mut inputs.commands)?;
        pass_current(&mut inputs.current, state)?;
        state.real(&mut inputs.operating_speed)?;
        state.reals(&mut inputs.load)?;
        let slopes = &mut self.slopes;
        state.reals(&mut slopes.commands)?;
        pass_current(&mut slopes.current, state)?;
        state.real(&mut slopes.operating_speed)?;
        state.reals(&mut slopes.load)?;
        let trim = &mut self.trim;
        state.each(&mut [
            &mut trim.speed,
            &mut trim.forward_speed,
            &mut trim.heave,
            &mut trim.incidence,
            &mut trim.pitch,
            &mut trim.depth,
            &mut trim.residual,
        ])?;
        state.reals(&mut trim.actuators)?;
        state.each(&mut [&mut self.launch.weight, &mut self.launch.buoyancy])?;
        state.boolean(&mut self.above_surface)?;
        state.boolean(&mut self.out_of_range)?;
        let mut snapshot = self.plant.snapshot();
        pass_motion(&mut snapshot, state)?;
        if self.has_given_speed() {
            let (input, slope) = (&mut self.inputs.given_speed, &mut self.slopes.given_speed);
            state.each(&mut [input, slope, &mut snapshot.given_speed])?;
        }
        if state.is_read() { self.restore(&snapshot, in_waves) } else { Ok(()) }
    }

    fn restore(&mut self, snapshot: &Snapshot, in_waves: bool) -> Result<(), StateError> {
        let Launch { weight, buoyancy } = self.launch;
        if !(weight.is_finite() && weight > 0.0) {
            return Err(StateError::inconsistent(format_args!("an initial weight of {weight} N")));
        }
        let vehicle = self.with(&Coefficients { buoyancy, ..snapshot.coefficients.clone() });
        self.surroundings = if in_waves {
            self.settings.waves.about(&vehicle).map_err(StateError::inconsistent)?
        } else {
            None
        };
        self.plant.set_water(self.surroundings.clone());
        self.plant.restore(snapshot).map_err(StateError::inconsistent)
    }
}

fn pass_motion(snapshot: &mut Snapshot, state: &mut dyn SavedState) -> Result<(), StateError> {
    pass_coefficients(&mut snapshot.coefficients, state)?;
    pass_fidelity(&mut snapshot.fidelity, state)?;
    state.real(&mut snapshot.time)?;
    let State { motion, x, depth, heading, east, .. } = &mut snapshot.state;
    let Motion { u, v, w, p, q, r, phi, theta } = motion;
    state.each(&mut [u, v, w, p, q, r, phi, theta, x, depth, heading, east])?;
    state.reals(&mut snapshot.outputs)?;
    state.reals(&mut snapshot.commands)?;
    pass_current(&mut snapshot.current, state)?;
    state.reals(&mut snapshot.load)?;
    state.each(&mut [&mut snapshot.operating_speed, &mut snapshot.integrator_step])
}

fn pass_current(current: &mut Current, state: &mut dyn SavedState) -> Result<(), StateError> {
    let Current { horizontal, east, vertical } = current;
    state.each(&mut [horizontal, east, vertical])
}

fn pass_fidelity(fidelity: &mut Fidelity, state: &mut dyn SavedState) -> Result<(), StateError> {
    let mut is_lpv = *fidelity == Fidelity::Lpv;
    state.boolean(&mut is_lpv)?;
    *fidelity = if is_lpv { Fidelity::Lpv } else { Fidelity::Nonlinear };
    Ok(())
}

fn pass_coefficients(coefficients: &mut Coefficients, state: &mut dyn SavedState) -> Result<(), StateError> {
    for spec in COEFFICIENTS {
        let mut value = (spec.get)(coefficients);
        state.real(&mut value)?;
        (spec.set)(coefficients, value);
    }
    Ok(())
}
