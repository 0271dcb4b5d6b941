//! The plant behind the FMU interface.

use squid_auv::{Fidelity, LpvModel, Slopes, State, Vehicle};
use squid_fmi2::model_description::{DefaultExperiment, identifier};
use squid_fmi2::{
    About, Log, Model, Resources, SavedState, StateError, Tangents, Variable, rounding_of_time,
};

use crate::resources::{LPV_RESOURCE, VEHICLE_RESOURCE};
use crate::variables::{inputs, outputs, parameters};
use crate::{PlantError, PlantModel, Quantity, states};

/// Default tolerance of the importer's integrator, relative to the nominal values of the states; in co-simulation the
/// integrator of the model uses a tighter one.
pub const TOLERANCE: f64 = 1e-6;

impl Model for PlantModel {
    type Error = PlantError;

    fn load(resources: &Resources) -> Result<Self, PlantError> {
        let named = |name: &str| format!("resources/{name}");
        let vehicle = Vehicle::from_json(resources.text(VEHICLE_RESOURCE)?, &named(VEHICLE_RESOURCE))?;
        let lpv = LpvModel::from_json(resources.text(LPV_RESOURCE)?, &named(LPV_RESOURCE))?;
        Self::new(vehicle, lpv)
    }

    fn about(&self) -> About {
        let Vehicle { name, status, description, .. } = self.vehicle();
        let motion =
            if self.has_six_dof() { "Motion in six degrees of freedom" } else { "Longitudinal motion" };
        About {
            identifier: format!("{}_plant", identifier(name)),
            name: format!("{name} plant"),
            description: format!("{motion} of {name} ({} coefficients). {description}", status.word()),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            enumerations: self.fidelities(),
            default_experiment: DefaultExperiment {
                start_time: 0.0,
                stop_time: 60.0,
                step_size: 0.01,
                tolerance: Some(TOLERANCE),
            },
        }
    }

    fn variables(&self) -> Vec<Variable<Self>> {
        [inputs(self), outputs(self), parameters(self), states(self)].into_iter().flatten().collect()
    }

    fn initialise(&mut self, start: f64, log: &mut dyn Log) -> Result<(), PlantError> {
        self.start(start)?;
        if self.settings.fidelity == Fidelity::Lpv && self.settings.coefficients != self.vehicle.coefficients
        {
            log.warn(
                "The LPV model contains the coefficients of the vehicle file; the changed ones affect the \
                 initial trim only.",
            );
        }
        Ok(())
    }

    fn step(&mut self, from: f64, to: f64, log: &mut dyn Log) -> Result<(), PlantError> {
        self.stands_at(from)?;
        self.advance(to)?;
        self.warn(log);
        Ok(())
    }

    fn pass_state(&mut self, state: &mut dyn SavedState) -> Result<(), StateError> {
        self.pass(state)
    }

    fn tangents() -> Option<Tangents<Self>> {
        Some(|plant, moment, tangents| {
            plant.carry(moment.initial, tangents);
            Ok(())
        })
    }

    fn quantities(&self) -> usize {
        Quantity::count(self.vehicle.actuators.len())
    }

    const MODEL_EXCHANGE: bool = true;

    fn states(&self, states: &mut [f64]) {
        let now = self.plant.instant();
        let motion = self.indices().iter().map(|state_index| now.state[*state_index]);
        let outputs = self.lagging().map(|index| self.plant.outputs()[index]);
        for (state, value) in states.iter_mut().zip(motion.chain(outputs)) {
            *state = value;
        }
    }

    fn set_states(&mut self, states: &[f64]) {
        let mut instant = self.plant.instant();
        for (state_index, value) in self.indices().iter().zip(states) {
            instant.state[*state_index] = *value;
        }
        self.plant.set_motion_over_ground(&instant);
        let mut outputs = states.iter().skip(self.indices().len());
        for index in 0..self.vehicle.actuators.len() {
            if self.vehicle.actuators[index].lag > 0.0
                && let Some(&output) = outputs.next()
            {
                self.plant.set_output(index, output);
            }
        }
    }

    fn set_time(&mut self, time: f64) {
        self.plant.set_time(time);
    }

    fn apply_inputs(&mut self) -> Result<(), PlantError> {
        self.apply_commands()?;
        self.plant.set_current(self.inputs.current)?;
        self.plant.set_given_speed(self.inputs.given_speed)?;
        self.plant.set_load(self.inputs.load)?;
        Ok(self.plant.set_operating_speed(self.inputs.operating_speed)?)
    }

    fn tune(&mut self) -> Result<(), PlantError> {
        self.take_on_ballast()
    }

    fn derivatives(&self, rates: &mut [f64]) {
        let all = self.rates();
        let motion = self.indices().iter().map(|state_index| all[*state_index]);
        let outputs = self.lagging().map(|index| self.output_rate(index));
        for (rate, value) in rates.iter_mut().zip(motion.chain(outputs)) {
            *rate = value;
        }
    }

    fn input_rates(&self, tangents: &mut [f64]) {
        let Slopes { commands, current, operating_speed, given_speed, load } = &self.slopes;
        for (index, &rate) in commands.iter().enumerate() {
            tangents[Quantity::command(index)] = rate;
        }
        for (axis, rate) in current.in_earth().into_iter().enumerate() {
            tangents[Quantity::Current(axis).number()] = rate;
        }
        tangents[Quantity::OperatingSpeed.number()] = *operating_speed;
        tangents[Quantity::GivenSpeed.number()] = *given_speed;
        for (axis, &rate) in load.iter().enumerate() {
            tangents[Quantity::External(axis).number()] = rate;
        }
        tangents[Quantity::Time.number()] = 1.0;
    }

    fn step_completed(&mut self, log: &mut dyn Log) {
        self.warn(log);
    }
}

impl PlantModel {
    /// Checks that the plant's time equals `time` \[s\], up to rounding.
    ///
    /// # Errors
    /// [`PlantError::OtherTime`].
    pub fn stands_at(&self, time: f64) -> Result<(), PlantError> {
        let clock = self.time();
        if (clock - time).abs() <= rounding_of_time(time) {
            Ok(())
        } else {
            Err(PlantError::OtherTime { clock, time })
        }
    }

    /// Warns of a motion that the equations do not cover.
    pub(crate) fn warn(&mut self, log: &mut dyn Log) {
        self.warn_of_range(log);
        self.warn_of_surface(log);
    }

    /// Warns each time the operating speed leaves the range of the LPV model.
    fn warn_of_range(&mut self, log: &mut dyn Log) {
        let (centre, half) = (self.lpv.speed_centre, self.lpv.speed_half_range);
        let speed = self.inputs.operating_speed;
        let out = self.settings.fidelity == Fidelity::Lpv && (speed - centre).abs() > half * (1.0 + 1e-9);
        if out && !self.out_of_range {
            let held = centre + half * self.lpv.rho(speed);
            log.warn(&format!(
                    "The operating speed {speed} m/s is outside the range of the LPV model, {} to {} m/s; the model \
                     is held at {held} m/s until it returns.",
                    centre - half,
                    centre + half
                ),
            );
        }
        self.out_of_range = out;
    }

    /// Warns each time the vehicle (in waves, its hull) emerges; the equations contain no surface. An error would end
    /// the simulation at an instant that depends on the step size, and holding the depth at 0 would be a discontinuity
    /// that the states of model exchange and their derivatives do not have.
    fn warn_of_surface(&mut self, log: &mut dyn Log) {
        let state @ State { depth, motion, .. } = self.plant.state();
        let clearance = match &self.surroundings {
            None => depth,
            Some(water) => water.clearance(self.time(), &state.pose()),
        };
        let above = clearance < 0.0;
        if above && !self.above_surface && self.surroundings.is_some() {
            log.warn(&format!(
                "At {:.2} s the hull is {:.2} m above the wave surface, at a depth of {depth:.4} m. Linear wave \
                    theory does not hold there: the computed loads grow without bound, and the following results are \
                    invalid.",
                self.time(),
                -clearance
            ));
        } else if above && !self.above_surface {
            log.warn(&format!(
                "At {:.2} s the vehicle is above the surface, at {:.2} m/s and a depth of {depth:.4} m. The \
                    equations hold in deep water and do not model the surface.",
                self.time(),
                motion.u
            ));
        }
        self.above_surface = above;
    }
}
