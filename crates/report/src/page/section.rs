//! A section of the report: words, figures, tables and verdicts, in the order in which they are read.

use crate::page::figure::Figure;
use crate::verdict::Verdict;

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
    /// A table.
    Table(Table),
    /// A claim of the paper and what became of it.
    Verdict(Verdict),
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
    /// The verdicts.
    pub fn verdicts(&self) -> impl Iterator<Item = &Verdict> {
        self.parts.iter().filter_map(|part| if let Part::Verdict(v) = part { Some(v) } else { None })
    }

    /// The figures.
    pub fn figures(&self) -> impl Iterator<Item = &Figure> {
        self.parts.iter().filter_map(|part| if let Part::Figure(f) = part { Some(f) } else { None })
    }
}
