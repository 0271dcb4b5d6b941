//! The loop behind the interface of an FMU.

use fmi2::model_description::{DefaultExperiment, identifier};
use fmi2::{
    About, Continuous, Log, Model, Resources, StateError, StateReader, StateWriter, Tangents, Variable,
};
use fmu_controller::Controller;
use fmu_plant::{PlantModel, fidelities};

use crate::tangents::Own;
use crate::{ClosedLoop, ClosedLoopError};
use scheduled::{MANOEUVRE_RESOURCE, Manoeuvre};

impl Model for ClosedLoop {
    type Error = ClosedLoopError;

    fn load(resources: &Resources) -> Result<Self, ClosedLoopError> {
        let plant = PlantModel::load(resources)?;
        let controller = Controller::load(resources)?;
        let manoeuvre = Manoeuvre::from_json(resources.text(MANOEUVRE_RESOURCE)?)
            .map_err(ClosedLoopError::ManoeuvreFile)?;
        Self::new(plant, controller, manoeuvre)
    }

    fn about(&self) -> About {
        let (vehicle, design) = (self.plant.vehicle(), self.controller.design());
        let steered = design.steered();
        About {
            identifier: identifier(&vehicle.name),
            name: vehicle.name.clone(),
            description: format!(
                "{} ({} coefficients) with its LPV {steered} controller '{}' in one loop, flying a {steered} step on a \
                 ramp of speed",
                vehicle.name,
                vehicle.status.word(),
                design.design
            ),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            enumerations: vec![fidelities()],
            default_experiment: DefaultExperiment {
                start_time: 0.0,
                stop_time: self.manoeuvre.duration,
                step_size: design.sample_time,
                tolerance: None,
            },
        }
    }

    fn variables(&self) -> Vec<Variable<Self>> {
        crate::variables::table(self)
    }

    fn initialise(&mut self, start: f64, log: &mut dyn Log) -> Result<(), ClosedLoopError> {
        self.start(start, log)
    }

    fn step(&mut self, from: f64, to: f64, log: &mut dyn Log) -> Result<(), ClosedLoopError> {
        self.plant.stands_at(from)?;
        self.controller.keeps_up(from)?;
        self.advance(to, log)
    }

    fn save(&self, state: &mut StateWriter) {
        self.write(state);
    }

    fn restore(&mut self, state: &mut StateReader<'_>) -> Result<(), StateError> {
        self.read(state)
    }

    fn continuous() -> Option<Continuous<Self>> {
        Some(Continuous::of())
    }

    fn tangents() -> Option<Tangents<Self>> {
        Some(Self::carry)
    }

    fn quantities(&self) -> usize {
        Own::count(self.plant.vehicle().actuators.len())
    }
}
