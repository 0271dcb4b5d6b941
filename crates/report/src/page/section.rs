//! A section of the report: words, figures, diagrams, tables and boxes, in the order in which they are read.

use crate::page::diagram::Diagram;
use crate::page::figure::Figure;

/// A table of words and numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// One a column.
    pub head: Vec<String>,
    /// As long as the head each.
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// An empty table.
    pub fn new<const N: usize>(head: [&str; N]) -> Self {
        Self { head: head.map(str::to_owned).to_vec(), rows: Vec::new() }
    }
}

/// Paragraphs in a box, whose colour says how something stands.
#[derive(Debug, Clone, PartialEq)]
pub struct Boxed {
    /// The CSS class of its colour: yes, partly, no; any other is grey.
    pub mark: &'static str,
    /// Of each the words in bold type with which it begins, if any, and the rest.
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
    /// Its anchor.
    pub id: &'static str,
    /// Its heading.
    pub title: &'static str,
    /// What it says.
    pub parts: Vec<Part>,
}

impl Section {
    /// The figures.
    pub fn figures(&self) -> impl Iterator<Item = &Figure> {
        self.parts.iter().filter_map(|part| if let Part::Figure(f) = part { Some(f) } else { None })
    }
}
