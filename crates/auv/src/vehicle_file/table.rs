//! A TOML table that knows its name, its line, and how to complain.

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::error::{FileProblem, VehicleFileError};
use crate::coefficients::Allowed;

/// The text of a vehicle file, for turning positions into lines.
pub(crate) struct Document<'a> {
    text: &'a str,
    file: &'a str,
}

impl<'a> Document<'a> {
    pub(crate) fn new(text: &'a str, file: &'a str) -> Self {
        Self { text, file }
    }

    /// Parses the text.
    pub(crate) fn root(&'a self) -> Result<Table<'a>, VehicleFileError> {
        match DeTable::parse(self.text) {
            Ok(root) => {
                Ok(Table { document: self, path: String::new(), span: 0..0, entries: root.into_inner() })
            }
            Err(error) => {
                let message = error.message().to_string();
                Err(self.error(&error.span().unwrap_or(0..0), FileProblem::NotToml { message }))
            }
        }
    }

    fn line(&self, span: &Range<usize>) -> usize {
        self.text.bytes().take(span.start).filter(|&byte| byte == b'\n').count() + 1
    }

    fn error(&self, span: &Range<usize>, problem: FileProblem) -> VehicleFileError {
        VehicleFileError { file: self.file.to_string(), line: self.line(span), problem: Box::new(problem) }
    }
}

/// A table of the file.
pub(crate) struct Table<'a> {
    document: &'a Document<'a>,
    path: String,
    span: Range<usize>,
    entries: DeTable<'a>,
}

/// A number with its unit and source.
pub(crate) struct Quantity<'a> {
    document: &'a Document<'a>,
    key: String,
    span: Range<usize>,
    pub(crate) value: f64,
    pub(crate) unit: String,
    pub(crate) source: String,
}

impl Quantity<'_> {
    /// Checks the sign and the finiteness of the number.
    pub(crate) fn check(&self, allowed: Allowed) -> Result<(), VehicleFileError> {
        if allowed.contains(self.value) {
            return Ok(());
        }
        let (key, found, unit) = (self.key.clone(), self.value, self.unit.clone());
        let problem = FileProblem::NotAllowed { key, found, unit, allowed: allowed.describe() };
        Err(self.document.error(&self.span, problem))
    }

    /// Returns the number in SI: degrees become radians, everything else is SI already.
    pub(crate) fn si(&self) -> f64 {
        if self.unit == "deg" { self.value.to_radians() } else { self.value }
    }
}

impl<'a> Table<'a> {
    /// The line on which the table begins.
    pub(crate) fn line(&self) -> usize {
        self.document.line(&self.span)
    }

    /// Blames the table.
    pub(crate) fn problem(&self, problem: FileProblem) -> VehicleFileError {
        self.document.error(&self.span, problem)
    }

    /// Complains of a missing key.
    pub(crate) fn missing(&self, key: &str, meaning: &str) -> VehicleFileError {
        self.problem(FileProblem::MissingKey { key: self.full(key), meaning: meaning.to_string() })
    }

    /// The name of a key with the tables around it.
    pub(crate) fn full(&self, key: &str) -> String {
        if self.path.is_empty() { key.to_string() } else { format!("{}.{key}", self.path) }
    }

    /// Refuses every key that is not listed.
    pub(crate) fn allow_only(&self, keys: &[&str]) -> Result<(), VehicleFileError> {
        let unknown =
            self.entries.iter().map(|(key, _)| key).filter(|key| !keys.contains(&key.get_ref().as_ref()));
        let Some(key) = unknown.min_by_key(|key| key.span().start) else { return Ok(()) };
        let mut allowed = keys.to_vec();
        allowed.dedup();
        let problem = FileProblem::UnknownKey {
            key: self.full(key.get_ref()),
            suggestion: nearest(key.get_ref(), &allowed),
            allowed: allowed.join(", "),
        };
        Err(self.document.error(&key.span(), problem))
    }

    fn wrong_type(
        &self,
        key: &str,
        value: &Spanned<DeValue<'_>>,
        expected: &'static str,
    ) -> VehicleFileError {
        let problem =
            FileProblem::WrongType { key: self.full(key), found: value.get_ref().type_str(), expected };
        self.document.error(&value.span(), problem)
    }

    /// Returns a table, if it is there.
    pub(crate) fn table(&self, key: &str) -> Result<Option<Table<'a>>, VehicleFileError> {
        let Some((name, value)) = self.entries.get_key_value(key) else { return Ok(None) };
        match value.get_ref() {
            DeValue::Table(entries) => Ok(Some(self.child(self.full(key), name.span(), entries))),
            _ => Err(self.wrong_type(key, value, "a table")),
        }
    }

    /// Returns a table that must be there.
    pub(crate) fn required_table(&self, key: &str, meaning: &str) -> Result<Table<'a>, VehicleFileError> {
        self.table(key)?.ok_or_else(|| self.missing(key, meaning))
    }

    /// Returns an array of tables `[[key]]`, empty if it is not there.
    pub(crate) fn tables(&self, key: &str) -> Result<Vec<Table<'a>>, VehicleFileError> {
        let Some(value) = self.entries.get(key) else { return Ok(Vec::new()) };
        let expected = "an array of tables, each under its own [[...]]";
        let DeValue::Array(items) = value.get_ref() else {
            return Err(self.wrong_type(key, value, expected));
        };
        items
            .iter()
            .map(|item| match item.get_ref() {
                DeValue::Table(entries) => Ok(self.child(self.full(key), item.span(), entries)),
                _ => Err(self.wrong_type(key, item, expected)),
            })
            .collect()
    }

    fn child(&self, path: String, span: Range<usize>, entries: &DeTable<'a>) -> Table<'a> {
        Table { document: self.document, path, span, entries: entries.clone() }
    }

    /// Returns a text that must be there and not be empty.
    pub(crate) fn text(&self, key: &str) -> Result<String, VehicleFileError> {
        let Some(value) = self.entries.get(key) else { return Err(self.missing(key, "a text in quotes")) };
        let Some(text) = value.get_ref().as_str() else {
            return Err(self.wrong_type(key, value, "a text in quotes"));
        };
        if text.trim().is_empty() {
            return Err(self.document.error(&value.span(), FileProblem::EmptyText { key: self.full(key) }));
        }
        if let Some(found) = text.chars().find(|&c| !stands_in_xml(c)) {
            let problem = FileProblem::Character { key: self.full(key), found };
            return Err(self.document.error(&value.span(), problem));
        }
        Ok(text.to_string())
    }

    /// Returns one word of a list, which must be there.
    pub(crate) fn one_of(&self, key: &str, words: &[&str]) -> Result<String, VehicleFileError> {
        let allowed = words.iter().map(|word| format!("\"{word}\"")).collect::<Vec<_>>().join(" or ");
        if !self.entries.contains_key(key) {
            return Err(self.missing(key, &format!("must be {allowed}")));
        }
        let found = self.text(key)?;
        if words.contains(&found.as_str()) {
            return Ok(found);
        }
        let suggestion = nearest(&found, words);
        Err(self.blame(key, FileProblem::WrongWord { key: self.full(key), found, suggestion, allowed }))
    }

    /// Blames the value of a key, or the table if the key is not there.
    pub(crate) fn blame(&self, key: &str, problem: FileProblem) -> VehicleFileError {
        let span = self.entries.get(key).map(Spanned::span);
        self.document.error(span.as_ref().unwrap_or(&self.span), problem)
    }

    /// Returns `{ value, unit, source }` if the key is there; the unit must be one of `units`.
    pub(crate) fn quantity(
        &self,
        key: &str,
        units: &[&str],
    ) -> Result<Option<Quantity<'a>>, VehicleFileError> {
        let Some(value) = self.entries.get(key) else { return Ok(None) };
        let DeValue::Table(entries) = value.get_ref() else {
            return Err(self.wrong_type(
                key,
                value,
                "a table { value = ..., unit = \"...\", source = \"...\" }",
            ));
        };
        let table = self.child(self.full(key), value.span(), entries);
        table.allow_only(&["value", "unit", "source"])?;
        let number = table.number()?;
        if !table.entries.contains_key("unit") {
            return Err(table.missing("unit", &format!("the unit, {}", quoted(units))));
        }
        let unit = table.text("unit")?;
        if !units.contains(&unit.as_str()) {
            let (key, expected) = (self.full(key), quoted(units));
            return Err(table.blame("unit", FileProblem::WrongUnit { key, found: unit, expected }));
        }
        if !table.entries.contains_key("source") {
            return Err(table.missing("source", "where the number comes from"));
        }
        let source = table.text("source")?;
        let (document, key, span) = (self.document, self.full(key), table.span.clone());
        Ok(Some(Quantity { document, key, span, value: number, unit, source }))
    }

    fn number(&self) -> Result<f64, VehicleFileError> {
        let Some(value) = self.entries.get("value") else { return Err(self.missing("value", "the number")) };
        decimal(value).ok_or_else(|| self.wrong_type("value", value, "a decimal number"))
    }

    /// Returns a list of pairs of numbers that must be there, with one pair or more.
    pub(crate) fn pairs(&self, key: &str, expected: &'static str) -> Result<Vec<[f64; 2]>, VehicleFileError> {
        let Some(value) = self.entries.get(key) else { return Err(self.missing(key, expected)) };
        let pair = |pair: &Spanned<DeValue<'_>>| match pair.get_ref().as_array()?.as_ref() {
            [one, two] => Some([decimal(one)?, decimal(two)?]),
            _ => None,
        };
        let pairs =
            value.get_ref().as_array().and_then(|list| list.iter().map(pair).collect::<Option<Vec<_>>>());
        pairs.filter(|list| !list.is_empty()).ok_or_else(|| self.wrong_type(key, value, expected))
    }
}

/// A decimal number, if it is one.
fn decimal(value: &Spanned<DeValue<'_>>) -> Option<f64> {
    match value.get_ref() {
        DeValue::Float(float) => float.as_str().parse().ok(),
        DeValue::Integer(integer) if integer.radix() == 10 => integer.as_str().parse().ok(),
        _ => None,
    }
}

/// Whether a character may stand in XML 1.0, where the texts of a vehicle end up.
fn stands_in_xml(c: char) -> bool {
    !matches!(c, '\0'..='\u{8}' | '\u{b}' | '\u{c}' | '\u{e}'..='\u{1f}' | '\u{fffe}' | '\u{ffff}')
}

fn quoted(units: &[&str]) -> String {
    units.iter().map(|unit| format!("\"{unit}\"")).collect::<Vec<_>>().join(" or ")
}

/// Returns the candidate that is most like the word, if one is like it.
pub(crate) fn nearest(word: &str, candidates: &[&str]) -> Option<String> {
    let likeness = |candidate: &str| strsim::jaro_winkler(&word.to_lowercase(), &candidate.to_lowercase());
    let scored = candidates.iter().map(|candidate| (likeness(candidate), candidate));
    let (score, candidate) = scored.max_by(|a, b| a.0.total_cmp(&b.0))?;
    (score > 0.8).then(|| candidate.to_string())
}
