//! Runs a plan with the crate `fmi`: `fly-fmi PLAN.json`.

use fly_plan::{Failure, Slave, run};
use fmi::CS;
use fmi::fmi2::import::Fmi2Import;
use fmi::fmi2::instance::{CoSimulation, Common, Instance};
use fmi::traits::FmiImport;
use std::collections::HashMap;

/// An instance and its value references by name; the import owns the unpacked files.
struct Flown {
    instance: Instance<CS>,
    _import: Fmi2Import,
    references: HashMap<String, u32>,
}

impl Flown {
    fn reference(&self, name: &str) -> Result<u32, Failure> {
        self.references.get(name).copied().ok_or_else(|| format!("there is no variable {name}").into())
    }
}

impl Slave for Flown {
    fn new(name: &str, path: &str) -> Result<Self, Failure> {
        let import: Fmi2Import = fmi::import::from_path(path)?;
        let variables = &import.model_description().model_variables.variables;
        let references = variables.iter().map(|v| (v.name.clone(), v.value_reference)).collect();
        let mut instance = import.instantiate_cs(name, false, false)?;
        instance.setup_experiment(None, 0.0, None)?;
        Ok(Self { instance, _import: import, references })
    }

    fn get(&mut self, name: &str) -> Result<f64, Failure> {
        let mut value = [0.0];
        self.instance.get_real(&[self.reference(name)?], &mut value)?;
        Ok(value[0])
    }

    fn set(&mut self, name: &str, value: f64) -> Result<(), Failure> {
        let reference = self.reference(name)?;
        self.instance.set_real(&[reference], &[value])?;
        Ok(())
    }

    fn enter_initialization(&mut self) -> Result<(), Failure> {
        self.instance.enter_initialization_mode()?;
        Ok(())
    }

    fn exit_initialization(&mut self) -> Result<(), Failure> {
        self.instance.exit_initialization_mode()?;
        Ok(())
    }

    fn step(&mut self, at: f64, size: f64) -> Result<(), Failure> {
        self.instance.do_step(at, size, true)?;
        Ok(())
    }

    fn terminate(&mut self) -> Result<(), Failure> {
        self.instance.terminate()?;
        Ok(())
    }
}

fn main() -> Result<(), Failure> {
    run::<Flown>()
}
