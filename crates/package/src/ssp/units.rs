//! Units in the files of an SSP: every file defines those that it refers to (element `Units`, SSP 1.0).

use model_description::element::{NONE, Xml, leaf, parent};
use model_description::{Causality, Kind, ModelDescription, ScalarVariable, Unit};
use std::collections::BTreeSet;
use std::io;

/// The Real inputs and outputs of a component, which are its connectors, in their order.
pub(crate) fn real(description: &ModelDescription) -> impl Iterator<Item = &ScalarVariable> {
    let is_connected = |one: &&ScalarVariable| matches!(one.causality, Causality::Input | Causality::Output);
    let variables = description.variables.iter();
    variables.filter(move |one| is_connected(one) && matches!(one.kind, Kind::Real { .. }))
}

/// The units of the connectors of a component.
pub(crate) fn of_connectors(description: &ModelDescription) -> impl Iterator<Item = &str> {
    real(description).filter_map(ScalarVariable::unit)
}

/// Defines units by powers of base units, those that are not coherent with a factor.
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
