//! Vehicles: their models, designs and simulations.

use crate::failure::{InputError, NumericalError, of_design};
use crate::job;
use pyo3::{Py, PyAny, PyErr, PyResult, Python, pyclass, pymethods};
use squid_design::inputs::Inputs;
use squid_design::linearise::to_json;
use squid_design::run::run_with;
use squid_design::store::{self, Stored};
use squid_flight::error::Error as FlightError;
use squid_flight::flight::{Variations, fly, fly_at_sea};
use squid_flight::record::Record;
use squid_flight::sea::Sea;
use squid_flight::whole::fly_six_dof;
use squid_scheduled::{ControllerDesign, Manoeuvre};
use std::fmt::Display;
use std::path::PathBuf;
use std::sync::Arc;

/// A vehicle with the requirements on its autopilot.
#[pyclass(frozen)]
pub struct Vehicle(Arc<Inputs>);

/// Record of a simulation: name, unit and values of each variable, and the reason if it ended early.
type Flown = (Vec<(String, String, Vec<f64>)>, Option<String>);

fn wrong(error: impl Display) -> PyErr {
    InputError::new_err(error.to_string())
}

#[pymethods]
impl Vehicle {
    /// Reads `vehicle.toml` and one axis of a design file of a directory.
    #[staticmethod]
    #[pyo3(signature = (directory, design, axis=None))]
    fn read(directory: PathBuf, design: &str, axis: Option<&str>) -> PyResult<Self> {
        Ok(Self(Arc::new(Inputs::read_axis(&directory, design, axis).map_err(wrong)?)))
    }

    /// Reads `vehicle.toml` and all axes of a design file of a directory.
    #[staticmethod]
    fn axes(directory: PathBuf, design: &str) -> PyResult<Vec<Self>> {
        let axes = Inputs::read_axes(&directory, design).map_err(wrong)?;
        Ok(axes.into_iter().map(|inputs| Self(Arc::new(inputs))).collect())
    }

    /// Reads a vehicle from the texts of both files.
    #[staticmethod]
    fn of(vehicle: &str, design: &str) -> PyResult<Self> {
        Ok(Self(Arc::new(Inputs::parse(vehicle, design).map_err(wrong)?)))
    }

    /// Returns the name of the vehicle.
    #[getter]
    fn name(&self) -> &str {
        &self.0.vehicle.name
    }

    /// Returns the quantity that the axis controls, which is also the name of the axis.
    #[getter]
    fn axis(&self) -> &str {
        self.0.design.steered_signal()
    }

    /// Returns the names of the actuators.
    #[getter]
    fn actuators(&self) -> Vec<&str> {
        self.0.vehicle.actuators.iter().map(|actuator| actuator.name.as_str()).collect()
    }

    /// Returns the range of speed along the path for which the design is made (m/s).
    #[getter]
    fn speeds(&self) -> (f64, f64) {
        (self.0.design.speed_min, self.0.design.speed_max)
    }

    /// Returns trim and linear model at a speed along the path, as `squid show --speed` does.
    fn at_speed(&self, speed: f64) -> PyResult<String> {
        let found = self.0.axis().at(speed);
        Ok(to_json(&self.0.vehicle, &found.map_err(|error| of_design(&error.into()))?).to_string())
    }

    /// Designs an autopilot, and writes its files to a directory.
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

    /// Simulates the design in a directory with a manoeuvre as in `manoeuvre.json`, by default that of the design, in
    /// still water or in a sea, given as the text of its file.
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
        let flight = flown.map_err(of_flight)?;
        let record = Record::of(&flight, &vehicle.actuators, &stored.controller);
        Ok((columns(&record), flight.surfacing.map(|surfacing| surfacing.to_string())))
    }

    /// Simulates the designs of all axes, each in its directory, in six degrees of freedom; see [`Vehicle::simulate`].
    #[staticmethod]
    fn simulate_all(
        python: Python<'_>,
        axes: Vec<Py<Self>>,
        directories: Vec<PathBuf>,
        manoeuvre: &str,
        sea: Option<&str>,
    ) -> PyResult<Flown> {
        let axes: Vec<Arc<Inputs>> = axes.iter().map(|axis| Arc::clone(&axis.get().0)).collect();
        let load = |(inputs, directory): (&Arc<Inputs>, &PathBuf)| store::load(directory, inputs);
        let stored: Vec<Stored> =
            axes.iter().zip(&directories).map(load).collect::<Result<_, _>>().map_err(|e| of_design(&e))?;
        let first = axes.first().ok_or_else(|| wrong("there is no axis"))?;
        let manoeuvre = Manoeuvre::from_json(manoeuvre).map_err(wrong)?;
        let sea = sea.map(|text| Sea::parse(text, "sea")).transpose().map_err(wrong)?;
        sea.iter().try_for_each(|sea| sea.check_geometry(&first.six_dof)).map_err(wrong)?;
        let designs: Vec<&ControllerDesign> = stored.iter().map(|stored| &stored.controller).collect();
        let varied = Variations { sea: sea.as_ref(), ..Variations::default() };
        let flown = python
            .detach(|| fly_six_dof(&first.six_dof, &designs, first.design.level(), &manoeuvre, &varied))
            .map_err(of_flight)?;
        let own = axes.iter().zip(&designs);
        let own: Vec<_> = own.map(|(inputs, design)| (&inputs.vehicle.actuators[..], *design)).collect();
        let record = Record::of_six_dof(&flown, &first.six_dof.actuators, &own);
        Ok((columns(&record), flown.surfacing().map(|surfacing| surfacing.to_string())))
    }
}

/// Returns the exception for a failed simulation: `InputError` for an invalid manoeuvre, otherwise `NumericalError`.
fn of_flight(error: FlightError) -> PyErr {
    match error {
        FlightError::Manoeuvre(_) => wrong(error),
        _ => NumericalError::new_err(error.to_string()),
    }
}

/// Returns the columns of a record.
fn columns(record: &Record) -> Vec<(String, String, Vec<f64>)> {
    let column =
        |(name, unit, values): (&str, &str, &[f64])| (name.to_owned(), unit.to_owned(), values.to_vec());
    record.columns().map(column).collect()
}
