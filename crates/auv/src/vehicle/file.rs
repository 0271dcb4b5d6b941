//! Reading of a vehicle file (TOML): every number with its unit and source, every mistake with its line.

mod actuator_tables;
mod curve_table;
mod geometry_table;
mod hull_table;
mod non_dimensional;
mod published_model;
mod surge_table;
mod units;

use std::collections::BTreeMap;
use std::ops::RangeInclusive;
use std::sync::Arc;

use crate::toml_file::{Document, FileError, FileProblem, Table, cited};
use crate::vehicle::actuator::Actuator;
use crate::vehicle::coefficients::{COEFFICIENTS, CoefficientError, CoefficientSpec, Coefficients};
use crate::vehicle::file::units::Units;
use crate::vehicle::surge::Surge;
use crate::vehicle::{Status, VEHICLE_NAMES, Vehicle, is_vehicle_name};

const CONVENTION: &str = "convention";
const CONVENTIONS: [&str; 2] = ["viscous", "combined"];

/// Standard gravity, to the digits with which published tables convert weight to mass \[m/s2\].
const GRAVITY: f64 = 9.81;

/// Largest relative difference between the weight and mass times gravity. Gravity varies by 0.5 % over the earth, and a
/// mass and a weight of two digits each are off by up to 5 %; the smallest error from a wrong unit, pounds for
/// kilograms, is a factor of 2.2.
const WEIGHT_TOLERANCE: f64 = 0.1;

/// Plausible densities of liquid water, with any dissolved matter \[kg/m3\]; others are in another unit.
const DENSITIES: RangeInclusive<f64> = 900.0..=1500.0;

impl Vehicle {
    /// Reads and validates the text of a vehicle file; `file` is its name in messages.
    ///
    /// # Errors
    /// [`FileError`]: every mistake with file, line, key, value and the allowed values.
    pub fn parse(text: &str, file: &str) -> Result<Self, FileError> {
        let document = Document::parse(text, file)?;
        let root = document.root();
        let mut sections = vec!["vehicle"];
        sections.extend(actuator_tables::kinds());
        sections.extend([published_model::SECTION, non_dimensional::SECTION, surge_table::SECTION]);
        sections.push(geometry_table::SECTION);
        sections.extend(COEFFICIENTS.iter().map(|spec| spec.section));
        root.allow_only(&sections);

        let mut sources = BTreeMap::new();
        let head = root.required_table("vehicle", "name, status and description of the vehicle");
        let head = head.and_then(|table| vehicle_table(&table));
        let units = Units::read(&root);
        let coefficients = coefficients(&root, &units, &mut sources);
        let actuators = actuator_tables::read(&root, &units, &mut sources);
        check_lateral(&root, &coefficients, &actuators, &sources);
        let geometry = geometry_table::read(&root, &mut sources);
        let published_linear_model = published_model::read(&root).map(Arc::new);
        document.check()?;
        check_matrix(&root, &coefficients);
        let (name, status, description) = document.finish(head)?;
        Ok(Vehicle {
            name,
            status,
            description,
            coefficients,
            others: vec![],
            actuators,
            geometry,
            sources,
            published_linear_model,
        })
    }
}

/// Reads name, status and description.
fn vehicle_table(table: &Table<'_>) -> Option<(String, Status, String)> {
    table.allow_only(&["name", "status", "description"]);
    let name = table.text("name");
    if let Some(name) = name.as_ref().filter(|name| !is_vehicle_name(name)) {
        table.not_allowed("name", cited(name), VEHICLE_NAMES);
    }
    let status = table.one_of("status", &Status::ALL.map(Status::word)).map(|index| Status::ALL[index]);
    let description = table.text("description");
    Some((name?, status?, description?))
}

/// Reads every coefficient of the table, and splits combined lift.
fn coefficients(root: &Table<'_>, units: &Units<'_>, sources: &mut BTreeMap<String, String>) -> Coefficients {
    let surge = surge_table::read(root, sources);
    let mut coefficients = Coefficients { surge, ..Coefficients::default() };
    let mut names: Vec<&str> = COEFFICIENTS.iter().map(|spec| spec.section).collect();
    names.dedup();
    let mut combined = false;
    for name in names {
        let specs: Vec<&CoefficientSpec> = COEFFICIENTS.iter().filter(|s| s.section == name).collect();
        let required: Vec<&str> = specs.iter().filter(|s| s.is_required()).map(|s| s.key).collect();
        let table = if required.is_empty() {
            root.table(name)
        } else {
            root.required_table(name, &format!("a table with {}", required.join(", ")))
        };
        let Some(table) = table else { continue };
        let mut keys: Vec<&str> = specs.iter().map(|spec| spec.key).collect();
        keys.extend((name == "lift").then_some(CONVENTION));
        keys.extend((name == hull_table::SECTION).then_some(hull_table::STATIONS));
        table.allow_only_or(&keys, &SYMMETRIC);
        if name == "lift" {
            combined = table.one_of(CONVENTION, &CONVENTIONS) == Some(1);
        }
        for spec in specs.into_iter().filter(|spec| !may_be_absent(spec, surge) || table.has(spec.key)) {
            section_entry(&table, spec, units, &mut coefficients, sources);
        }
        if name == hull_table::SECTION {
            coefficients.hull = hull_table::read(&table, sources).unwrap_or_default();
        }
        if name == "mass" {
            let mass_is_known = check_weight(&table, &coefficients);
            if mass_is_known {
                check_inertia(&table, &coefficients);
            }
        }
        if name == "water" {
            check_density(&table, &coefficients);
        }
    }
    // Axisymmetry of a hull is independent of the form of its lift.
    coefficients.complete(|key| sources.contains_key(key));
    if combined {
        coefficients.split_combined_lift();
    } else if let Some(table) = root.table("added_mass").filter(|_| surge.is_given()) {
        table.requires(SURGE_MASS, "surge force per surge acceleration, which enters the Munk moment");
    }
    coefficients
}

/// Reports missing data of a vehicle that moves out of the vertical plane: its inertia in roll, and roll damping.
fn check_lateral(
    root: &Table<'_>,
    coefficients: &Coefficients,
    actuators: &[Actuator],
    sources: &BTreeMap<String, String>,
) {
    let report_missing = |section: &str, key: &str, meaning: String| {
        let key = format!("{section}.{key}");
        root.table(section).as_ref().unwrap_or(root).problem(FileProblem::MissingKey { key, meaning });
    };
    if coefficients.leaves_plane() {
        let damping = ["K_up", "K_p", "K_pp"];
        if !damping.iter().any(|key| sources.contains_key(*key)) {
            let meaning =
                "roll moment per |u| p, or K_p or K_pp in [damping]: the motion in roll needs damping";
            report_missing("lift", "K_up", meaning.to_owned());
        }
        return;
    }
    let of_roll = |spec: &&CoefficientSpec| spec.acts_out_of_plane() && spec.key != INERTIA_IN_ROLL;
    let given = COEFFICIENTS.iter().filter(of_roll).find(|spec| sources.contains_key(spec.key));
    let given = given.map(|spec| spec.key);
    let lateral_actuator = actuators.iter().find(|one| one.acts_out_of_plane()).map(|one| one.name.as_str());
    let Some(of) = given.or(lateral_actuator) else { return };
    let mass = root.table("mass").filter(|mass| mass.has(INERTIA_IN_ROLL));
    match mass.map(|mass| (mass, sources.contains_key(INERTIA_IN_ROLL))) {
        Some((mass, true)) => {
            mass.not_allowed(
                INERTIA_IN_ROLL,
                "0",
                format!(
                    "above 0 (kg.m2), because '{of}' moves the vehicle out of \
                the vertical plane"
                ),
            );
        }
        // A value that could not be read is already reported.
        Some((_, false)) => {}
        None => {
            let meaning = format!("moment of inertia in roll about the origin, above 0, required by '{of}'");
            report_missing("mass", INERTIA_IN_ROLL, meaning);
        }
    }
}

/// Moment of inertia in roll; a vehicle with it moves out of the vertical plane.
const INERTIA_IN_ROLL: &str = "I_xx";

/// Added masses that are not read, each with the equal one that is: the matrix is symmetric.
const SYMMETRIC: [(&str, &str); 3] = [("K_v_dot", "Y_p_dot"), ("N_v_dot", "Y_r_dot"), ("N_p_dot", "K_r_dot")];

/// Added mass of surge.
const SURGE_MASS: &str = "X_u_dot";

/// Returns `true` if a coefficient may be absent: for a given speed, the added mass of surge cancels out of combined
/// lift.
fn may_be_absent(spec: &CoefficientSpec, surge: Surge) -> bool {
    surge.is_given() && spec.key == SURGE_MASS
}

/// Reads one coefficient of a section.
fn section_entry(
    table: &Table<'_>,
    spec: &CoefficientSpec,
    units: &Units<'_>,
    coefficients: &mut Coefficients,
    sources: &mut BTreeMap<String, String>,
) {
    if spec.is_required() && !table.requires(spec.key, spec.meaning) {
        return;
    }
    if let Some((value, source)) = units.quantity(table, spec.key, &[spec.unit], spec.allowed) {
        (spec.set)(coefficients, value);
        sources.insert(spec.key.to_string(), source);
    }
}

/// Reports a weight that does not match the mass, and returns `true` if the two agree; if either could not be read,
/// nothing is reported.
fn check_weight(table: &Table<'_>, coefficients: &Coefficients) -> bool {
    let (weight, expected) = (coefficients.weight, coefficients.mass * GRAVITY);
    let both_read = weight > 0.0 && expected > 0.0;
    let differs = (weight - expected).abs() > WEIGHT_TOLERANCE * expected;
    if both_read && differs {
        let (gravity, tolerance) = (GRAVITY, WEIGHT_TOLERANCE);
        table.blame("weight", FileProblem::MassAndWeight { weight, expected, gravity, tolerance });
    }
    both_read && !differs
}

/// Reports a physically impossible moment of inertia: about the origin it exceeds that of all the mass at the centre of
/// gravity.
fn check_inertia(table: &Table<'_>, coefficients: &Coefficients) {
    let c = coefficients;
    let (ahead, below) = (c.x_G * c.x_G, c.z_G * c.z_G);
    for (key, arm, inertia, square) in [
        ("I_yy", "(x_G^2 + z_G^2)", c.I_yy, ahead + below),
        ("I_xx", "z_G^2", c.I_xx, below),
        ("I_zz", "x_G^2", c.I_zz, ahead),
    ] {
        let of_a_point = c.mass * square;
        if c.mass > 0.0 && inertia > 0.0 && inertia <= of_a_point {
            table.blame(key, FileProblem::Inertia { key, arm, inertia, of_a_point });
        }
    }
}

/// Reports an implausible density of water.
fn check_density(table: &Table<'_>, coefficients: &Coefficients) {
    let density = coefficients.density;
    if density > 0.0 && !DENSITIES.contains(&density) {
        let (least, most) = (DENSITIES.start(), DENSITIES.end());
        let allowed = format!("a density of water, from {least} to {most} kg/m3");
        table.not_allowed("density", format!("{density} kg/m3"), allowed);
    }
}

/// Reports a mass matrix that is not positive definite.
fn check_matrix(root: &Table<'_>, coefficients: &Coefficients) {
    match coefficients.check() {
        Ok(()) => {}
        Err(CoefficientError::MassMatrixNotPositiveDefinite { numbers, least_eigenvalue }) => {
            let problem = FileProblem::MassMatrixNotPositiveDefinite { numbers, least_eigenvalue };
            root.table("added_mass").as_ref().unwrap_or(root).problem(problem);
        }
        Err(source @ CoefficientError::NotAllowed { .. }) => {
            root.problem(FileProblem::Coefficient { source })
        }
    }
}
