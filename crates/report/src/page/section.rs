//! A section of the report: words, figures, diagrams, tables and claims, in the order in which they are read.

use crate::claims::Claim;
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
    /// A claim of the paper and what became of it.
    Claim(Claim),
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
    /// The claims.
    pub fn claims(&self) -> impl Iterator<Item = &Claim> {
        self.parts.iter().filter_map(|part| if let Part::Claim(v) = part { Some(v) } else { None })
    }

    /// Takes the claims out of it.
    pub fn take_claims(&mut self) -> Vec<Claim> {
        let claims = self.parts.extract_if(.., |part| matches!(part, Part::Claim(_)));
        claims.filter_map(|part| if let Part::Claim(claim) = part { Some(claim) } else { None }).collect()
    }

    /// The figures.
    pub fn figures(&self) -> impl Iterator<Item = &Figure> {
        self.parts.iter().filter_map(|part| if let Part::Figure(f) = part { Some(f) } else { None })
    }
}
