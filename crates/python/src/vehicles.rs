//! Vehicles: their models, designs and flights.

use crate::failure::{InputError, NumericalError, of_design};
use crate::job;
use pyo3::{Py, PyAny, PyErr, PyResult, Python, pyclass, pymethods};
use scheduled::Manoeuvre;
use squid_design::inputs::Inputs;
use squid_design::linearise::to_json;
use squid_design::run::run_with;
use squid_design::store;
use squid_flight::error::Error as FlightError;
use squid_flight::flight::{fly, fly_at_sea};
use squid_flight::record::Record;
use squid_flight::sea::Sea;
use std::fmt::Display;
use std::path::PathBuf;
use std::sync::Arc;

/// A vehicle, and what is asked of its autopilot.
#[pyclass(frozen)]
pub struct Vehicle(Arc<Inputs>);

/// A record of a flight: name, unit and values of each variable, and where the flight ended early.
type Flown = (Vec<(String, String, Vec<f64>)>, Option<String>);

fn wrong(error: impl Display) -> PyErr {
    InputError::new_err(error.to_string())
}

#[pymethods]
impl Vehicle {
    /// Reads `vehicle.toml` and a design file of a directory, one axis of it.
    #[staticmethod]
    #[pyo3(signature = (directory, design, axis=None))]
    fn read(directory: PathBuf, design: &str, axis: Option<&str>) -> PyResult<Self> {
        Ok(Self(Arc::new(Inputs::read_axis(&directory, design, axis).map_err(wrong)?)))
    }

    /// The same from the texts of both files.
    #[staticmethod]
    fn of(vehicle: &str, design: &str) -> PyResult<Self> {
        Ok(Self(Arc::new(Inputs::parse(vehicle, design).map_err(wrong)?)))
    }

    /// Its name.
    #[getter]
    fn name(&self) -> &str {
        &self.0.vehicle.name
    }

    /// Names of its actuators.
    #[getter]
    fn actuators(&self) -> Vec<&str> {
        self.0.vehicle.actuators.iter().map(|actuator| actuator.name.as_str()).collect()
    }

    /// The range of speed along the path that the design is for, m/s.
    #[getter]
    fn speeds(&self) -> (f64, f64) {
        (self.0.design.speed_min, self.0.design.speed_max)
    }

    /// Trim and linear model at a speed along the path, as `squid show --speed` has them.
    fn at_speed(&self, speed: f64) -> PyResult<String> {
        let found = self.0.axis().at(speed);
        Ok(to_json(&self.0.vehicle, &found.map_err(|error| of_design(&error.into()))?).to_string())
    }

    /// Designs, and writes the files of the design to a directory.
    fn design(
        &self,
        python: Python<'_>,
        directory: PathBuf,
        robust: bool,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<()> {
        let inputs = Arc::clone(&self.0);
        let done = job::run(python, progress, move |progress| {
            let finished = run_with(&inputs, progress, robust)?;
            store::save(&directory, &inputs, &finished)
        })?;
        done.map_err(|error| of_design(&error))
    }

    /// Flies the design in a directory: a manoeuvre as in `manoeuvre.json`, the default one if there is none; in the
    /// sea of a text, if one is given.
    fn simulate(
        &self,
        python: Python<'_>,
        directory: PathBuf,
        manoeuvre: Option<&str>,
        sea: Option<&str>,
    ) -> PyResult<Flown> {
        let inputs = Arc::clone(&self.0);
        let stored = store::load(&directory, &inputs).map_err(|error| of_design(&error))?;
        let manoeuvre = match manoeuvre {
            Some(text) => Manoeuvre::from_json(text).map_err(wrong)?,
            None => stored.manoeuvre.clone(),
        };
        let sea = sea.map(|text| Sea::parse(text, "sea")).transpose().map_err(wrong)?;
        let (vehicle, level) = (&inputs.vehicle, inputs.design.level());
        sea.iter().try_for_each(|sea| sea.check(vehicle)).map_err(wrong)?;
        let flown = python.detach(|| match &sea {
            Some(sea) => fly_at_sea(vehicle, &stored.controller, level, &manoeuvre, sea),
            None => fly(vehicle, &stored.controller, level, &manoeuvre),
        });
        let flight = flown.map_err(|error| match error {
            FlightError::Manoeuvre(_) => wrong(error),
            _ => NumericalError::new_err(error.to_string()),
        })?;
        let record = Record::of(&flight, &vehicle.actuators, &stored.controller);
        let column =
            |(name, unit, values): (&str, &str, &[f64])| (name.to_owned(), unit.to_owned(), values.to_vec());
        Ok((record.columns().map(column).collect(), flight.surfacing.map(|surfacing| surfacing.to_string())))
    }
}
