//! Units in the files of an SSP: every file defines those that it refers to (element `Units`, SSP 1.0).

use crate::xml::{Xml, real};
use model_description::{BaseUnit, ModelDescription, ScalarVariable, Unit};
use std::collections::BTreeSet;
use std::io;

/// The units of the connectors of a component.
pub(crate) fn of_connectors(description: &ModelDescription) -> impl Iterator<Item = &str> {
    real(description).filter_map(ScalarVariable::unit)
}

/// Defines units by powers of base units, those that are not coherent with a factor.
pub(crate) fn units(xml: &mut Xml, element: &str, names: BTreeSet<&str>) -> io::Result<()> {
    if names.is_empty() {
        return Ok(());
    }
    xml.create_element(element)
        .write_inner_content(|xml| names.into_iter().try_for_each(|name| unit(xml, name)))?;
    Ok(())
}

fn unit(xml: &mut Xml, name: &str) -> io::Result<()> {
    let Unit { base, factor, .. } =
        Unit::parse(name).map_err(|error| io::Error::new(io::ErrorKind::InvalidData, error))?;
    let powers: Vec<_> =
        BaseUnit::SYMBOLS.into_iter().zip(base.exponents.map(|power| power.to_string())).collect();
    let factor = (factor != 1.0).then(|| format!("{factor:?}"));
    let powers =
        powers.iter().filter(|(_, power)| power != "0").map(|(symbol, power)| (*symbol, power.as_str()));
    let powers = powers.chain(factor.as_deref().map(|factor| ("factor", factor)));
    xml.create_element("ssc:Unit").with_attribute(("name", name)).write_inner_content(|xml| {
        xml.create_element("ssc:BaseUnit").with_attributes(powers).write_empty()?;
        Ok(())
    })?;
    Ok(())
}
