//! The state of a flight as bytes.

use auv::{COEFFICIENTS, Coefficients, Current, Fidelity, Motion, Slopes, Snapshot, State};
use fmi2::{StateError, StateReader, StateWriter};

use crate::PlantModel;

impl PlantModel {
    /// Writes settings, inputs, trim and the whole motion.
    pub(crate) fn write(&self, to: &mut StateWriter) {
        write_coefficients(&self.settings.coefficients, to);
        to.reals(&[self.settings.initial_speed, self.settings.initial_depth]);
        to.boolean(self.settings.fidelity == Fidelity::Lpv);
        self.settings.waves.write(to);
        to.boolean(self.surroundings.is_some());
        to.reals(&self.inputs.commands);
        to.reals(&[
            self.inputs.current.horizontal,
            self.inputs.current.vertical,
            self.inputs.operating_speed,
        ]);
        let Slopes { commands, current, operating_speed, given_speed } = &self.slopes;
        to.reals(commands);
        to.reals(&[current.horizontal, current.vertical, *operating_speed]);
        let trim = &self.trim;
        to.reals(&[trim.speed, trim.forward_speed, trim.heave, trim.incidence, trim.pitch, trim.depth]);
        to.real(trim.residual);
        to.reals(&trim.actuators);
        to.boolean(self.above_surface);
        to.boolean(self.out_of_range);
        let snapshot = self.plant.snapshot();
        write_memory(&snapshot, to);
        if self.takes_a_speed() {
            to.reals(&[self.inputs.given_speed, *given_speed, snapshot.given_speed]);
        }
    }

    /// Reads what [`PlantModel::write`] wrote, into a plant of the same vehicle.
    pub(crate) fn read(&mut self, from: &mut StateReader<'_>) -> Result<(), StateError> {
        read_coefficients(&mut self.settings.coefficients, from)?;
        self.settings.initial_speed = from.finite()?;
        self.settings.initial_depth = from.finite()?;
        self.settings.fidelity = read_fidelity(from)?;
        self.settings.waves.read(from)?;
        let in_waves = from.boolean()?;
        from.reals(&mut self.inputs.commands)?;
        self.inputs.current = read_current(from)?;
        self.inputs.operating_speed = from.finite()?;
        from.reals(&mut self.slopes.commands)?;
        self.slopes.current = read_current(from)?;
        self.slopes.operating_speed = from.finite()?;
        let trim = &mut self.trim;
        for number in [
            &mut trim.speed,
            &mut trim.forward_speed,
            &mut trim.heave,
            &mut trim.incidence,
            &mut trim.pitch,
            &mut trim.depth,
            &mut trim.residual,
        ] {
            *number = from.finite()?;
        }
        from.reals(&mut trim.actuators)?;
        self.above_surface = from.boolean()?;
        self.out_of_range = from.boolean()?;
        let mut snapshot = self.plant.snapshot();
        read_memory(&mut snapshot, from)?;
        if self.takes_a_speed() {
            let mut speeds = [0.0; 3];
            from.reals(&mut speeds)?;
            [self.inputs.given_speed, self.slopes.given_speed, snapshot.given_speed] = speeds;
        }
        self.surroundings = match in_waves {
            false => None,
            true => self
                .settings
                .waves
                .about(&self.with(&snapshot.coefficients))
                .map_err(StateError::inconsistent)?,
        };
        self.plant.set_water(self.surroundings.clone());
        self.plant.restore(&snapshot).map_err(StateError::inconsistent)
    }
}

fn write_memory(snapshot: &Snapshot, to: &mut StateWriter) {
    write_coefficients(&snapshot.coefficients, to);
    to.boolean(snapshot.fidelity == Fidelity::Lpv);
    let State { motion: Motion { u, w, q, theta }, x, depth } = snapshot.state;
    to.reals(&[snapshot.time, u, w, q, theta, x, depth]);
    to.reals(&snapshot.outputs);
    to.reals(&snapshot.commands);
    to.reals(&[snapshot.current.horizontal, snapshot.current.vertical]);
    to.reals(&[snapshot.operating_speed, snapshot.integrator_step]);
}

fn read_memory(snapshot: &mut Snapshot, from: &mut StateReader<'_>) -> Result<(), StateError> {
    read_coefficients(&mut snapshot.coefficients, from)?;
    snapshot.fidelity = read_fidelity(from)?;
    let mut motion = [0.0; 7];
    from.reals(&mut motion)?;
    let [time, u, w, q, theta, x, depth] = motion;
    snapshot.time = time;
    snapshot.state = State { motion: Motion { u, w, q, theta }, x, depth };
    from.reals(&mut snapshot.outputs)?;
    from.reals(&mut snapshot.commands)?;
    snapshot.current = read_current(from)?;
    snapshot.operating_speed = from.finite()?;
    snapshot.integrator_step = from.finite()?;
    Ok(())
}

fn read_current(from: &mut StateReader<'_>) -> Result<Current, StateError> {
    Ok(Current { horizontal: from.finite()?, vertical: from.finite()? })
}

fn read_fidelity(from: &mut StateReader<'_>) -> Result<Fidelity, StateError> {
    Ok(if from.boolean()? { Fidelity::Lpv } else { Fidelity::Nonlinear })
}

fn write_coefficients(coefficients: &Coefficients, to: &mut StateWriter) {
    COEFFICIENTS.iter().for_each(|spec| to.real((spec.get)(coefficients)));
}

fn read_coefficients(coefficients: &mut Coefficients, from: &mut StateReader<'_>) -> Result<(), StateError> {
    for spec in COEFFICIENTS {
        (spec.set)(coefficients, from.finite()?);
    }
    Ok(())
}
