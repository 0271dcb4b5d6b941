//! A section of the report: text, figures, diagrams, tables and boxes, in order.

use crate::page::{Diagram, Figure, capital};

/// A table of text and numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// One heading per column.
    pub head: Vec<String>,
    /// Rows of the same length as the head.
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// An empty table.
    pub fn new<const N: usize>(head: [&str; N]) -> Self {
        Self { head: head.map(str::to_owned).to_vec(), rows: Vec::new() }
    }
}

/// Paragraphs in a box with a colour for a status.
#[derive(Debug, Clone, PartialEq)]
pub struct Boxed {
    /// The CSS class of its colour: yes, partly or no; any other is grey.
    pub mark: &'static str,
    /// For each paragraph the bold text at its start, if any, and the rest.
    pub paragraphs: Vec<(String, String)>,
}

/// A part of a section.
#[derive(Debug, Clone, PartialEq)]
pub enum Part {
    /// A paragraph.
    Words(String),
    /// A figure.
    Figure(Figure),
    /// A block diagram.
    Diagram(Diagram),
    /// A table.
    Table(Table),
    /// A box.
    Boxed(Boxed),
}

/// A section.
#[derive(Debug, Clone, PartialEq)]
pub struct Section {
    /// Anchor.
    pub id: String,
    /// Heading.
    pub title: String,
    /// Content.
    pub parts: Vec<Part>,
}

impl Section {
    /// A section with an anchor and a heading.
    pub fn new(id: &str, title: &str, parts: Vec<Part>) -> Self {
        Self { id: id.into(), title: title.into(), parts }
    }

    /// The section on a page with those of other axes: its anchors begin with what its own axis steers, as its heading
    /// does.
    #[must_use]
    pub fn of_axis(mut self, axis: &str) -> Self {
        for part in &mut self.parts {
            match part {
                Part::Figure(figure) => figure.name = format!("{axis}-{}", figure.name),
                Part::Diagram(diagram) => diagram.name = format!("{axis}-{}", diagram.name),
                Part::Words(_) | Part::Table(_) | Part::Boxed(_) => {}
            }
        }
        Self {
            id: format!("{axis}-{}", self.id),
            title: format!("{}: {}", capital(axis), self.title),
            ..self
        }
    }
}
