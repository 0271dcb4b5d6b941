//! Runs a plan with the crate `fmi-rs`, after it has checked the model description: `fly-fmi-rs PLAN.json`.
#![allow(non_snake_case)]

use fly_plan::{Failure, Slave, run};
use fmi_rs::fmi2::builder::FMU2Builder;
use fmi_rs::fmi2::types::fmi2Status;
use fmi_rs::fmi2::{CS, FMU2};
use std::collections::HashMap;
use std::sync::Arc;

struct Flown {
    instance: Arc<FMU2<CS>>,
    references: HashMap<String, u32>,
    /// Owner of the unpacked files.
    _builder: FMU2Builder,
}

fn done(status: fmi2Status) -> Result<(), Failure> {
    if status == fmi2Status::Ok { Ok(()) } else { Err(format!("{status:?}").into()) }
}

impl Slave for Flown {
    fn new(name: &str, path: &str) -> Result<Self, Failure> {
        let builder = FMU2Builder::new(&path)?;
        let problems = builder.model_description.validate();
        if !problems.is_empty() {
            return Err(format!("{problems:?}").into());
        }
        let variables = builder.model_description.modelVariables.iter();
        let references = variables.map(|one| (one.name.clone(), one.valueReference)).collect();
        let instance = builder.instantiate_cs(name)?;
        done(instance.setupExperiment(None, 0.0, None))?;
        Ok(Self { instance, references, _builder: builder })
    }

    fn get(&mut self, name: &str) -> Result<f64, Failure> {
        let mut value = [0.0];
        done(self.instance.getReal(&[*self.references.get(name).ok_or("no such variable")?], &mut value))?;
        Ok(value[0])
    }

    fn set(&mut self, name: &str, value: f64) -> Result<(), Failure> {
        done(self.instance.setReal(&[*self.references.get(name).ok_or("no such variable")?], &[value]))
    }

    fn enter_initialization(&mut self) -> Result<(), Failure> {
        done(self.instance.enterInitializationMode())
    }

    fn exit_initialization(&mut self) -> Result<(), Failure> {
        done(self.instance.exitInitializationMode())
    }

    fn step(&mut self, at: f64, size: f64) -> Result<(), Failure> {
        done(self.instance.doStep(at, size, 1))
    }

    fn terminate(&mut self) -> Result<(), Failure> {
        done(self.instance.terminate())
    }
}

fn main() -> Result<(), Failure> {
    run::<Flown>()
}
