//! Reads a vehicle file (TOML): every number with its unit and its source, every mistake with its line.

mod actuator_tables;
mod error;
mod published_model;
mod table;

use std::collections::BTreeMap;

pub use error::{FileProblem, VehicleFileError};

use crate::coefficients::{COEFFICIENTS, CoefficientError, CoefficientSpec, Coefficients};
use crate::vehicle::{Status, Vehicle, is_vehicle_name};
pub(crate) use table::nearest;
use table::{Document, Table};

const CONVENTION: &str = "convention";
const CONVENTIONS: [&str; 2] = ["viscous", "combined"];

/// Reads and validates the text of a vehicle file.
pub(crate) fn parse(text: &str, file: &str) -> Result<Vehicle, VehicleFileError> {
    let document = Document::new(text, file);
    let root = document.root()?;
    let mut sections: Vec<&str> = vec!["vehicle", "thruster", "control_surface", published_model::SECTION];
    sections.extend(COEFFICIENTS.iter().map(|spec| spec.section));
    root.allow_only(&sections)?;

    let mut sources = BTreeMap::new();
    let head = root.required_table("vehicle", "name, status and description of the vehicle")?;
    head.allow_only(&["name", "status", "description"])?;
    let name = head.text("name")?;
    if !is_vehicle_name(&name) {
        return Err(head.blame("name", FileProblem::VehicleName { name }));
    }
    let description = head.text("description")?;
    let word = head.one_of("status", &Status::ALL.map(Status::word))?;
    let status = Status::ALL.into_iter().find(|s| s.word() == word).unwrap_or(Status::Surrogate);

    let coefficients = coefficients(&root, &mut sources)?;
    let actuators = actuator_tables::read(&root, &mut sources)?;
    let published_linear_model = published_model::read(&root)?;
    Ok(Vehicle { name, status, description, coefficients, actuators, sources, published_linear_model })
}

/// Reads every coefficient of the table, splits combined lift, and checks the mass matrix.
fn coefficients(
    root: &Table<'_>,
    sources: &mut BTreeMap<String, String>,
) -> Result<Coefficients, VehicleFileError> {
    let mut coefficients = Coefficients::default();
    let mut names: Vec<&str> = COEFFICIENTS.iter().map(|spec| spec.section).collect();
    names.dedup();
    let mut combined = false;
    for name in names {
        let specs: Vec<&CoefficientSpec> = COEFFICIENTS.iter().filter(|s| s.section == name).collect();
        let Some(table) = root.table(name)? else {
            match specs.iter().find(|spec| spec.default.is_none()) {
                Some(spec) => return Err(root.missing(&format!("{name}.{}", spec.key), spec.meaning)),
                None => continue,
            }
        };
        let mut keys: Vec<&str> = specs.iter().map(|spec| spec.key).collect();
        if name == "lift" {
            combined = table.one_of(CONVENTION, &CONVENTIONS)? == "combined";
            keys.push(CONVENTION);
        }
        table.allow_only(&keys)?;
        section(&table, &specs, &mut coefficients, sources)?;
    }
    if combined {
        coefficients.split_combined_lift();
    }
    match coefficients.check() {
        Ok(()) => Ok(coefficients),
        Err(CoefficientError::MassMatrixNotPositiveDefinite { least_eigenvalue }) => {
            let problem = FileProblem::MassMatrixNotPositiveDefinite { least_eigenvalue };
            Err(root.table("added_mass")?.as_ref().unwrap_or(root).problem(problem))
        }
        Err(source @ CoefficientError::NotAllowed { .. }) => {
            Err(root.problem(FileProblem::Coefficient { source }))
        }
    }
}

/// Reads the coefficients of one section.
fn section(
    table: &Table<'_>,
    specs: &[&CoefficientSpec],
    coefficients: &mut Coefficients,
    sources: &mut BTreeMap<String, String>,
) -> Result<(), VehicleFileError> {
    for spec in specs {
        let Some(quantity) = table.quantity(spec.key, &[spec.unit])? else {
            match spec.default {
                Some(_) => continue,
                None => return Err(table.missing(spec.key, spec.meaning)),
            }
        };
        quantity.check(spec.allowed)?;
        (spec.set)(coefficients, quantity.value);
        sources.insert(spec.key.to_string(), quantity.source);
    }
    Ok(())
}
