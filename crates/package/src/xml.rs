//! What the XML files of SSP and terminals share.

use model_description::{Causality, ModelDescription, ScalarVariable};
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, Event};
use std::io;

/// A document under way.
pub(crate) type Xml = Writer<Vec<u8>>;

/// A whole document.
pub(crate) fn document(body: impl FnOnce(&mut Xml) -> io::Result<()>) -> io::Result<Vec<u8>> {
    let mut xml = Writer::new_with_indent(Vec::new(), b' ', 2);
    xml.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    body(&mut xml)?;
    let mut bytes = xml.into_inner();
    bytes.push(b'\n');
    Ok(bytes)
}

/// Real inputs and outputs in their order.
pub(crate) fn real(description: &ModelDescription) -> impl Iterator<Item = &ScalarVariable> {
    let of_interest = |causality| causality == Causality::Input || causality == Causality::Output;
    let variables = description.variables.iter();
    variables
        .filter(move |v| of_interest(v.causality) && matches!(v.kind, model_description::Kind::Real { .. }))
}
