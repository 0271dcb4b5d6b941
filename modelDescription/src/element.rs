//! XML documents, element by element.

use std::io;

use quick_xml::Writer;
use quick_xml::events::{BytesDecl, Event};

/// Writer of a document.
pub type Xml = Writer<Vec<u8>>;

/// Empty list of attributes.
pub const NONE: &[(&str, &str)] = &[];

/// Writes a document.
///
/// # Errors
/// Errors of `body` and of the writer.
pub fn document(body: impl FnOnce(&mut Xml) -> io::Result<()>) -> io::Result<Vec<u8>> {
    let mut xml = Writer::new_with_indent(Vec::new(), b' ', 2);
    xml.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    body(&mut xml)?;
    let mut bytes = xml.into_inner();
    bytes.push(b'\n');
    Ok(bytes)
}

/// Writes an element without content.
///
/// # Errors
/// Errors of the writer.
pub fn leaf(xml: &mut Xml, element: &str, attributes: &[(&str, impl AsRef<str>)]) -> io::Result<()> {
    let attributes = attributes.iter().map(|(name, value)| (*name, value.as_ref()));
    xml.create_element(element).with_attributes(attributes).write_empty().map(|_| ())
}

/// Writes an element with content.
///
/// # Errors
/// Errors of `content` and of the writer.
pub fn parent(
    xml: &mut Xml,
    element: &str,
    attributes: &[(&str, impl AsRef<str>)],
    content: impl FnOnce(&mut Xml) -> io::Result<()>,
) -> io::Result<()> {
    let attributes = attributes.iter().map(|(name, value)| (*name, value.as_ref()));
    xml.create_element(element).with_attributes(attributes).write_inner_content(content).map(|_| ())
}

/// Returns the shortest decimal that reads back to the same number.
pub(crate) fn number(value: f64) -> String {
    format!("{value:?}")
}
