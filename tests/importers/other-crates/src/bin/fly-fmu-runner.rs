//! Runs a plan with the crate `fmu-runner`: `fly-fmu-runner PLAN.json`.

use fly_plan::{Failure, Slave, run};
use fmu_runner::model_description::ScalarVariable;
use fmu_runner::{Fmu, FmuInstance, FmuLibrary, fmi2Type};
use std::collections::HashMap;

struct Runner(FmuInstance<FmuLibrary>);

impl Runner {
    fn variable(&self, name: &str) -> Result<&ScalarVariable, Failure> {
        self.0.lib.variables().get(name).ok_or_else(|| format!("there is no variable {name}").into())
    }
}

impl Slave for Runner {
    fn new(_: &str, path: &str) -> Result<Self, Failure> {
        let library = Fmu::unpack(path)?.load(fmi2Type::fmi2CoSimulation)?;
        let instance = FmuInstance::instantiate(library, false)?;
        instance.setup_experiment(0.0, None, None)?;
        Ok(Self(instance))
    }

    fn get(&mut self, name: &str) -> Result<f64, Failure> {
        let values = self.0.get_reals(&[self.variable(name)?])?;
        values.into_values().next().ok_or_else(|| "no value".into())
    }

    fn set(&mut self, name: &str, value: f64) -> Result<(), Failure> {
        Ok(self.0.set_reals(&HashMap::from([(self.variable(name)?, value)]))?)
    }

    fn enter_initialization(&mut self) -> Result<(), Failure> {
        Ok(self.0.enter_initialization_mode()?)
    }

    fn exit_initialization(&mut self) -> Result<(), Failure> {
        Ok(self.0.exit_initialization_mode()?)
    }

    fn step(&mut self, at: f64, size: f64) -> Result<(), Failure> {
        Ok(self.0.do_step(at, size, true)?)
    }

    /// Does nothing: the crate frees the instance without terminating it.
    fn terminate(&mut self) -> Result<(), Failure> {
        Ok(())
    }
}

fn main() -> Result<(), Failure> {
    run::<Runner>()
}
