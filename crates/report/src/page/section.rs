//! Sections of a report: text, figures, diagrams, tables and boxes, in order.

use crate::page::{Diagram, Figure, capital};

/// Table of text and numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// One heading per column.
    pub head: Vec<String>,
    /// Rows of the same length as the head.
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// Creates an empty table.
    pub fn new<const N: usize>(head: [&str; N]) -> Self {
        Self { head: head.map(str::to_owned).to_vec(), rows: Vec::new() }
    }
}

/// Paragraphs in a box with a colour for a status.
#[derive(Debug, Clone, PartialEq)]
pub struct Boxed {
    /// CSS class of the colour: yes, partly or no; any other is grey.
    pub mark: &'static str,
    /// Bold text at the start of each paragraph, may be empty, and its remaining text.
    pub paragraphs: Vec<(String, String)>,
}

/// Part of a section.
#[derive(Debug, Clone, PartialEq)]
pub enum Part {
    /// Paragraph.
    Text(String),
    /// Figure.
    Figure(Figure),
    /// Block diagram.
    Diagram(Diagram),
    /// Table.
    Table(Table),
    /// Box.
    Boxed(Boxed),
}

/// Section of a report.
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
    /// Creates a section with an anchor and a heading.
    pub fn new(id: &str, title: &str, parts: Vec<Part>) -> Self {
        Self { id: id.into(), title: title.into(), parts }
    }

    /// Returns the section for a page with several axes: its anchors and heading begin with the quantity that its axis
    /// controls.
    #[must_use]
    pub fn of_axis(mut self, axis: &str) -> Self {
        for part in &mut self.parts {
            match part {
                Part::Figure(figure) => figure.name = format!("{axis}-{}", figure.name),
                Part::Diagram(diagram) => diagram.name = format!("{axis}-{}", diagram.name),
                Part::Text(_) | Part::Table(_) | Part::Boxed(_) => {}
            }
        }
        Self {
            id: format!("{axis}-{}", self.id),
            title: format!("{}: {}", capital(axis), self.title),
            ..self
        }
    }
}
