//! Connectors, and the units in the files of an SSP: every file defines the units to which it refers (element `Units`,
//! SSP 1.0).

use squid_model_description::element::{NONE, Xml, leaf, parent};
use squid_model_description::{Causality, Kind, ModelDescription, ScalarVariable, Unit};
use std::collections::BTreeSet;
use std::io;

/// Returns the kind of a variable's connector (section 5.3.1); `None` if it has none. Enumerations have none, because
/// libcosim (libcosimpy 0.0.6) ends the process on reading one.
fn kind(of: &ScalarVariable) -> Option<&'static str> {
    match of.causality {
        _ if matches!(of.kind, Kind::Enumeration { .. }) => None,
        Causality::Input => Some("input"),
        Causality::Output => Some("output"),
        Causality::Parameter => Some("parameter"),
        _ => None,
    }
}

/// Returns the variables of a component with a connector: inputs, outputs and parameters except enumerations, in their
/// order.
pub(crate) fn connected(description: &ModelDescription) -> impl Iterator<Item = &ScalarVariable> {
    description.variables.iter().filter(|one| kind(one).is_some())
}

/// Writes a connector for each of these variables, with its type.
pub(crate) fn connectors(xml: &mut Xml, description: &ModelDescription) -> io::Result<()> {
    connected(description).try_for_each(|one| {
        let attributes = [("name", one.name.as_str()), ("kind", kind(one).unwrap_or_default())];
        parent(xml, "ssd:Connector", &attributes, |xml| match &one.kind {
            Kind::Real { .. } => leaf(xml, "ssc:Real", one.unit().map(|unit| ("unit", unit)).as_slice()),
            Kind::Integer { .. } => leaf(xml, "ssc:Integer", NONE),
            Kind::Boolean { .. } => leaf(xml, "ssc:Boolean", NONE),
            Kind::String { .. } => leaf(xml, "ssc:String", NONE),
            Kind::Enumeration { .. } => Ok(()),
        })
    })
}

/// Returns the units of a component's connectors.
pub(crate) fn of_connectors(description: &ModelDescription) -> impl Iterator<Item = &str> {
    connected(description).filter_map(ScalarVariable::unit)
}

/// Defines units as powers of base units, with a factor for those that are not coherent.
pub(crate) fn units(xml: &mut Xml, element: &str, names: BTreeSet<&str>) -> io::Result<()> {
    if names.is_empty() {
        return Ok(());
    }
    parent(xml, element, NONE, |xml| names.into_iter().try_for_each(|name| unit(xml, name)))
}

fn unit(xml: &mut Xml, name: &str) -> io::Result<()> {
    let unit = Unit::parse(name).map_err(|error| io::Error::new(io::ErrorKind::InvalidData, error))?;
    parent(xml, "ssc:Unit", &[("name", name)], |xml| leaf(xml, "ssc:BaseUnit", &unit.in_base_units()))
}
