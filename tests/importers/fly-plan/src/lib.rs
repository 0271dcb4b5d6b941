//! Simulation of a plan with any importer: all slaves step, then all signals are exchanged.

use serde_json::Value;
use std::collections::BTreeMap;
use std::error::Error;
use std::fs::File;
use std::io::{BufWriter, Write};

pub type Failure = Box<dyn Error>;

/// An FMU instantiated by an importer, with the start time 0.
pub trait Slave: Sized {
    fn new(name: &str, path: &str) -> Result<Self, Failure>;
    fn get(&mut self, name: &str) -> Result<f64, Failure>;
    fn set(&mut self, name: &str, value: f64) -> Result<(), Failure>;
    fn enter_initialization(&mut self) -> Result<(), Failure>;
    fn exit_initialization(&mut self) -> Result<(), Failure>;
    fn step(&mut self, at: f64, size: f64) -> Result<(), Failure>;
    /// Terminates the FMU before it is freed, if the importer supports it.
    fn terminate(&mut self) -> Result<(), Failure>;
}

/// The slaves of a plan, by name.
struct Slaves<S>(BTreeMap<String, S>);

impl<S: Slave> Slaves<S> {
    /// Returns the slave of `slave.variable`, and the name of the variable.
    fn find<'p>(&mut self, path: &'p str) -> Result<(&mut S, &'p str), Failure> {
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

fn fly<S: Slave>(plan: &Value) -> Result<(), Failure> {
    let mut slaves = Slaves::<S>(BTreeMap::new());
    for (name, path) in plan["fmus"].as_object().ok_or("a plan names fmus")? {
        slaves.0.insert(name.clone(), S::new(name, &text(path)?)?);
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
    slaves.0.values_mut().try_for_each(S::enter_initialization)?;
    // Commands at the start depend on measurements at the start, hence one exchange per slave.
    (0..slaves.0.len()).try_for_each(|_| slaves.exchange(&connections))?;
    slaves.0.values_mut().try_for_each(S::exit_initialization)?;
    let mut out = BufWriter::new(File::create(text(&plan["out"])?)?);
    writeln!(out, "time,{}", record.join(","))?;
    for k in 0..count {
        slaves.0.values_mut().try_for_each(|slave| slave.step(k as f64 * step, step))?;
        slaves.exchange(&connections)?;
        if (k + 1) % every == 0 {
            write!(out, "{:?}", (k + 1) as f64 * step)?;
            for path in &record {
                write!(out, ",{:?}", slaves.get(path)?)?;
            }
            writeln!(out)?;
        }
    }
    slaves.0.values_mut().try_for_each(S::terminate)?;
    Ok(out.flush()?)
}

/// Runs the plan named on the command line.
pub fn run<S: Slave>() -> Result<(), Failure> {
    let path = std::env::args().nth(1).ok_or("the file of a plan is missing")?;
    fly::<S>(&serde_json::from_str(&std::fs::read_to_string(path)?)?)
}
