//! Flies a plan by the crate `fmi`: `fly-fmi PLAN.json`. All step, then all signals are exchanged.

use fmi::CS;
use fmi::fmi2::import::Fmi2Import;
use fmi::fmi2::instance::{CoSimulation, Common, Instance};
use fmi::traits::FmiImport;
use serde_json::Value;
use std::collections::{BTreeMap, HashMap};
use std::error::Error;
use std::fs::File;
use std::io::{BufWriter, Write};

type Failure = Box<dyn Error>;

/// An instance and its value references by name; the import is what keeps the unpacked files there.
struct Slave {
    instance: Instance<CS>,
    _import: Fmi2Import,
    references: HashMap<String, u32>,
}

impl Slave {
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

    fn reference(&self, name: &str) -> Result<u32, Failure> {
        self.references.get(name).copied().ok_or_else(|| format!("there is no variable {name}").into())
    }
}

/// The slaves of a plan, by name.
struct Slaves(BTreeMap<String, Slave>);

impl Slaves {
    /// The slave of `slave.variable`, and the variable's name.
    fn find<'p>(&mut self, path: &'p str) -> Result<(&mut Slave, &'p str), Failure> {
        let (slave, variable) = path.split_once('.').ok_or("a path is slave.variable")?;
        Ok((self.0.get_mut(slave).ok_or("there is no such slave")?, variable))
    }

    fn get(&mut self, path: &str) -> Result<f64, Failure> {
        let (slave, variable) = self.find(path)?;
        slave.get(variable)
    }

    fn set(&mut self, path: &str, value: f64) -> Result<(), Failure> {
        let (slave, variable) = self.find(path)?;
        slave.set(variable, value)
    }

    fn exchange(&mut self, connections: &[(String, String)]) -> Result<(), Failure> {
        let values = connections.iter().map(|(source, _)| self.get(source)).collect::<Result<Vec<_>, _>>()?;
        connections.iter().zip(values).try_for_each(|((_, sink), value)| self.set(sink, value))
    }
}

fn text(value: &Value) -> Result<String, Failure> {
    Ok(value.as_str().ok_or("a text is expected")?.to_owned())
}

fn list(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}

fn fly(plan: &Value) -> Result<(), Failure> {
    let mut slaves = Slaves(BTreeMap::new());
    for (name, path) in plan["fmus"].as_object().ok_or("a plan names fmus")? {
        slaves.0.insert(name.clone(), Slave::new(name, &text(path)?)?);
    }
    for (path, value) in plan["values"].as_object().into_iter().flatten() {
        slaves.set(path, value.as_f64().ok_or("a value is a number")?)?;
    }
    let connections = list(&plan["connections"])
        .iter()
        .map(|pair| Ok((text(&pair[0])?, text(&pair[1])?)))
        .collect::<Result<Vec<_>, Failure>>()?;
    let record = list(&plan["record"]).iter().map(text).collect::<Result<Vec<_>, _>>()?;
    let step = plan["step"].as_f64().ok_or("a plan has a step")?;
    let count = plan["count"].as_u64().ok_or("a plan has a count")?;
    let every = plan["every"].as_u64().ok_or("a plan says how often to record")?;
    for slave in slaves.0.values_mut() {
        slave.instance.enter_initialization_mode()?;
    }
    // A command at the start follows from a measurement at the start.
    for _ in 0..slaves.0.len() {
        slaves.exchange(&connections)?;
    }
    for slave in slaves.0.values_mut() {
        slave.instance.exit_initialization_mode()?;
    }
    let mut out = BufWriter::new(File::create(text(&plan["out"])?)?);
    writeln!(out, "time,{}", record.join(","))?;
    for k in 0..count {
        for slave in slaves.0.values_mut() {
            slave.instance.do_step(k as f64 * step, step, true)?;
        }
        slaves.exchange(&connections)?;
        if (k + 1) % every == 0 {
            write!(out, "{:?}", (k + 1) as f64 * step)?;
            for path in &record {
                write!(out, ",{:?}", slaves.get(path)?)?;
            }
            writeln!(out)?;
        }
    }
    for slave in slaves.0.values_mut() {
        slave.instance.terminate()?;
    }
    Ok(out.flush()?)
}

fn main() -> Result<(), Failure> {
    let path = std::env::args().nth(1).ok_or("usage: fly-fmi PLAN.json")?;
    fly(&serde_json::from_str(&std::fs::read_to_string(path)?)?)
}
