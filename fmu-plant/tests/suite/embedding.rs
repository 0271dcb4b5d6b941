//! The plant as a part of a larger model, and as a library.

use crate::common::{squid, vehicle};
use squid_auv::{Fidelity, LpvModel, SimulationError};
use squid_fmi2::model_description::DefaultExperiment;
use squid_fmi2::{About, Log, Model, Resources, SavedState, Silent, StateError, Table, Variable};
use squid_fmu_plant::{LPV_RESOURCE, PlantError, PlantModel, outputs, parameters};

/// A plant whose commands are computed inside the model.
#[derive(Clone)]
struct Tow {
    plant: PlantModel,
}

impl Model for Tow {
    type Error = PlantError;

    fn load(resources: &Resources) -> Result<Self, PlantError> {
        Ok(Self { plant: PlantModel::load(resources)? })
    }

    fn about(&self) -> About {
        About {
            identifier: "tow".into(),
            name: "tow".into(),
            description: "a plant within".into(),
            version: "1".into(),
            enumerations: self.plant.fidelities(),
            default_experiment: DefaultExperiment {
                start_time: 0.0,
                stop_time: 1.0,
                step_size: 0.1,
                tolerance: None,
            },
        }
    }

    fn variables(&self) -> Vec<Variable<Self>> {
        let of_plant = parameters(&self.plant).into_iter().chain(outputs(&self.plant));
        let of_plant = of_plant.map(|one| one.depends_only_where(|_| false));
        of_plant.map(|one| one.embedded(|tow: &Self| &tow.plant, |tow| &mut tow.plant)).collect()
    }

    fn initialise(&mut self, start: f64, log: &mut dyn Log) -> Result<(), PlantError> {
        self.plant.initialise(start, log)?;
        self.plant.inputs.commands.clone_from(&self.plant.trim().actuators.clone());
        Ok(())
    }

    fn step(&mut self, from: f64, to: f64, log: &mut dyn Log) -> Result<(), PlantError> {
        self.plant.step(from, to, log)
    }

    fn pass_state(&mut self, state: &mut dyn SavedState) -> Result<(), StateError> {
        self.plant.pass_state(state)
    }
}

#[test]
fn larger_model_reuses_parameters_and_outputs() {
    let described = squid_fmi2::describe::<Tow>(&squid()).unwrap();
    let mut tow = described.model.clone();
    let table = Table::of(&tow);
    let reference = |name: &str| table.reference(name).unwrap();
    table.set(&mut tow, reference("initial_speed"), 2.5).unwrap();
    table.set(&mut tow, reference("z_G"), 0.04).unwrap();
    table.set(&mut tow, reference("fidelity"), 2).unwrap();
    assert_eq!(tow.plant.settings.coefficients.z_G, 0.04);
    assert_eq!(tow.plant.settings.fidelity, Fidelity::Lpv);
    table.set(&mut tow, reference("fidelity"), 1).unwrap();
    tow.initialise(3.0, &mut Silent).unwrap();
    tow.step(3.0, 4.0, &mut Silent).unwrap();
    assert_eq!(table.get::<f64>(&tow, reference("depth")).unwrap(), tow.plant.state().depth);
    assert!((table.get::<f64>(&tow, reference("path_speed")).unwrap() - 2.5).abs() < 1e-10);
    assert!((table.get::<f64>(&tow, reference("distance")).unwrap() - 2.5).abs() < 1e-10);
}

#[test]
fn plant_works_as_a_library() {
    let vehicle = vehicle("squid");
    let model = LpvModel::from_json(squid().text(LPV_RESOURCE).unwrap(), LPV_RESOURCE).unwrap();
    let mut plant = PlantModel::new(vehicle, model).unwrap();
    plant.settings.initial_speed = 1.0;
    plant.start(10.0).unwrap();
    assert_eq!(plant.time(), 10.0);
    assert!((plant.path_speed() - 1.0).abs() < 1e-12);
    plant.inputs.commands.clone_from(&plant.trim().actuators.clone());
    plant.inputs.commands[0] += 5.0;
    plant.advance(12.0).unwrap();
    assert!(plant.state().motion.theta > plant.trim().pitch + 0.01);
    assert!((plant.actuator_outputs()[0] - plant.inputs.commands[0]).abs() < 1e-3);
    let before = plant.state();
    plant.inputs.commands[1] = f64::NAN;
    let refused = plant.advance(13.0).unwrap_err();
    assert!(
        matches!(refused, PlantError::Simulation(SimulationError::InputNotFinite { found, .. }) if found.is_nan()),
        "{refused}"
    );
    assert_eq!(plant.state(), before, "a refused input moves nothing");
}
