//! The autopilot behind the interface of an FMU.

use fmi2::model_description::{DefaultExperiment, identifier};
use fmi2::{About, Log, Model, Resources, SavedState, StateError, Tangents, Variable};
use scheduled::ControllerDesign;

use crate::model::{Controller, ControllerError, RESOURCE};
use crate::tangents::Quantity;

impl Model for Controller {
    type Error = ControllerError;

    fn load(resources: &Resources) -> Result<Self, ControllerError> {
        let design = ControllerDesign::from_json(resources.text(RESOURCE)?)?;
        Ok(Self::new(design)?)
    }

    fn about(&self) -> About {
        let ControllerDesign { vehicle, design, sample_time, gamma, .. } = &*self.design;
        let proof = if gamma.certified { "certified" } else { "not certified" };
        About {
            identifier: format!("{}_controller", identifier(&vehicle.name)),
            name: format!("{} controller", vehicle.name),
            description: format!(
                "LPV {} controller of {} ({} coefficients), design '{design}', L2 gain below {}, {proof}",
                self.design.steered(),
                vehicle.name,
                vehicle.status.word(),
                gamma.bound
            ),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            enumerations: Vec::new(),
            default_experiment: DefaultExperiment {
                start_time: 0.0,
                stop_time: 60.0,
                step_size: *sample_time,
                tolerance: None,
            },
        }
    }

    fn variables(&self) -> Vec<Variable<Self>> {
        crate::variables::table(&self.design)
    }

    fn initialise(&mut self, start: f64, _: &mut dyn Log) -> Result<(), ControllerError> {
        Ok(self.autopilot.initialise(start, &self.inputs)?)
    }

    fn step(&mut self, from: f64, to: f64, log: &mut dyn Log) -> Result<(), ControllerError> {
        self.keeps_up(from)?;
        if self.autopilot.advance(to, &self.inputs)? {
            self.warn_of_range(log);
        }
        Ok(())
    }

    fn pass_state(&mut self, state: &mut dyn SavedState) -> Result<(), StateError> {
        state.reals(&mut self.inputs.measured)?;
        state.reals(&mut self.inputs.references)?;
        let mut snapshot = self.autopilot.snapshot();
        state.reals(&mut snapshot.state)?;
        state.real(&mut snapshot.filtered_speed)?;
        state.reals(&mut snapshot.origins)?;
        let outputs = &mut snapshot.outputs;
        state.reals(&mut outputs.commands)?;
        state.real(&mut outputs.scheduling_parameter)?;
        state.reals(&mut outputs.trim)?;
        state.boolean(&mut outputs.out_of_range)?;
        state.reals(&mut snapshot.delayed)?;
        state.real(&mut snapshot.start)?;
        state.integer(&mut snapshot.ticks)?;
        state.boolean(&mut snapshot.outside)?;
        if state.is_read() {
            self.autopilot.restore(&snapshot).map_err(StateError::inconsistent)
        } else {
            Ok(())
        }
    }

    fn tangents() -> Option<Tangents<Self>> {
        Some(Self::carry)
    }

    fn quantities(&self) -> usize {
        Quantity::count(&self.design)
    }
}
