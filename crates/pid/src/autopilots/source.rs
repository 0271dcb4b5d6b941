//! A file of an autopilot and the byte ranges of its values, so that numbers can be replaced and every other byte
//! stays.

use crate::refusal::{not_allowed, refused};
use squid_auv::toml_file::{FileError, FileProblem};
use std::ops::Range;

/// A value of a file.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Entry {
    /// Key.
    pub(crate) key: String,
    /// Line.
    pub(crate) line: usize,
    /// Byte ranges of the text; several if it continues after a line break.
    pub(crate) pieces: Vec<Range<usize>>,
}

/// A file and its values.
#[derive(Debug)]
pub(crate) struct Source<'a> {
    pub(crate) text: &'a str,
    pub(crate) file: &'a str,
    pub(crate) entries: Vec<Entry>,
}

/// Numbers of a key.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Numbers {
    pub(crate) key: String,
    pub(crate) line: usize,
    pub(crate) values: Vec<f64>,
    /// Byte ranges of each number; several if the key is repeated with the same value.
    ranges: Vec<Vec<Range<usize>>>,
}

/// A number replaced by another.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// Line in the file.
    pub line: usize,
    /// Key in the file.
    pub key: String,
    /// Text before.
    pub from: String,
    /// Text after.
    pub to: String,
}

impl<'a> Source<'a> {
    /// Creates a source without values.
    pub(crate) fn new(text: &'a str, file: &'a str) -> Self {
        Self { text, file, entries: vec![] }
    }

    /// Returns the number, start byte and text, without line ending, of each line.
    pub(crate) fn lines(&self) -> impl Iterator<Item = (usize, usize, &'a str)> + use<'a> {
        let mut begin = 0;
        self.text.split('\n').enumerate().map(move |(index, line)| {
            let start = begin;
            begin += line.len() + 1;
            (index + 1, start, line.trim_end_matches('\r'))
        })
    }

    /// Adds a value, a part of the text `whole` that starts at byte `begin`.
    pub(crate) fn push(&mut self, key: String, line: usize, begin: usize, whole: &str, value: &str) {
        self.entries.push(Entry { key, line, pieces: vec![piece(begin, whole, value)] });
    }

    /// Adds the continuation after a line break to the last value.
    pub(crate) fn extend(&mut self, begin: usize, whole: &str, value: &str) {
        if let Some(last) = self.entries.last_mut() {
            last.pieces.push(piece(begin, whole, value));
        }
    }

    /// Returns an error that refuses a value.
    pub(crate) fn refuse<T>(
        &self,
        line: usize,
        key: &str,
        found: impl Into<String>,
        allowed: impl Into<String>,
    ) -> Result<T, FileError> {
        Err(not_allowed(self.file, line, key, found, allowed))
    }

    /// Returns the text of a value.
    pub(crate) fn value_text(&self, entry: &Entry) -> String {
        entry.pieces.iter().map(|piece| &self.text[piece.clone()]).collect::<Vec<_>>().join(" ")
    }

    /// Returns all occurrences of a key.
    ///
    /// # Errors
    /// [`FileError`] if their values differ.
    pub(crate) fn all(&self, key: &str) -> Result<Vec<&Entry>, FileError> {
        let all: Vec<&Entry> = self.entries.iter().filter(|entry| entry.key == key).collect();
        if let Some(other) = all.iter().find(|entry| self.value_text(entry) != self.value_text(all[0])) {
            let found = format!(
                "{}, and {} on line {}",
                self.value_text(other),
                self.value_text(all[0]),
                all[0].line
            );
            return self.refuse(other.line, key, found, "one value: remove the unused one");
        }
        Ok(all)
    }

    /// Returns line and text of a key's value, if present.
    pub(crate) fn value(&self, key: &str) -> Result<Option<(usize, String)>, FileError> {
        Ok(self.all(key)?.first().map(|entry| (entry.line, self.value_text(entry))))
    }

    /// Reads `size` finite, non-negative numbers of a key, if present.
    pub(crate) fn optional(&self, key: &str, size: usize) -> Result<Option<Numbers>, FileError> {
        let all = self.all(key)?;
        let Some(first) = all.first() else { return Ok(None) };
        let (line, mut values, mut ranges) = (first.line, vec![], vec![vec![]; size]);
        for entry in &all {
            let tokens = self.tokens(entry);
            if tokens.len() != size {
                let allowed = if size == 1 { NUMBER.into() } else { format!("{size} numbers") };
                return self.refuse(entry.line, key, self.quoted(entry), allowed);
            }
            for (token, ranges) in tokens.into_iter().zip(&mut ranges) {
                ranges.push(token);
            }
        }
        for token in &ranges {
            let number = &self.text[token[0].clone()];
            match number.parse::<f64>() {
                Ok(value) if value.is_finite() && value >= 0.0 => values.push(value),
                Ok(_) => return self.refuse(line, key, number, "a non-negative number"),
                Err(_) => return self.refuse(line, key, self.quoted(first), NUMBER),
            }
        }
        Ok(Some(Numbers { key: key.to_owned(), line, values, ranges }))
    }

    /// Reads `size` finite, non-negative numbers of a required key.
    pub(crate) fn required(&self, key: &str, size: usize, meaning: &str) -> Result<Numbers, FileError> {
        let missing = || FileProblem::MissingKey { key: key.to_owned(), meaning: meaning.to_owned() };
        self.optional(key, size)?.ok_or_else(|| refused(self.file, 1, missing()))
    }

    /// Refuses a gain of 0 that must be positive.
    pub(crate) fn require_positive(&self, numbers: &Numbers, index: usize) -> Result<(), FileError> {
        let Numbers { key, line, values, .. } = numbers;
        if values[index] > 0.0 {
            return Ok(());
        }
        let found = if values.len() > 1 { format!("0 in entry {}", index + 1) } else { "0".into() };
        self.refuse(*line, key, found, "above 0, because the loop requires this gain")
    }

    fn quoted(&self, entry: &Entry) -> String {
        let text = self.value_text(entry);
        if text.is_empty() { "empty".into() } else { format!("\"{text}\"") }
    }

    /// Returns the byte ranges of the tokens of a value, separated by commas and blanks.
    fn tokens(&self, entry: &Entry) -> Vec<Range<usize>> {
        let split = |range: &Range<usize>| {
            let text = &self.text[range.clone()];
            let tokens = text.split([',', ' ', '\t']).filter(|token| !token.is_empty());
            tokens.map(|token| piece(range.start, text, token)).collect::<Vec<_>>()
        };
        entry.pieces.iter().flat_map(split).collect()
    }

    /// Returns the text with new values of keys, and the changes. A number that already has its value is left as
    /// written.
    pub(crate) fn replaced(&self, new: &[(&Numbers, Vec<f64>)]) -> (String, Vec<Change>) {
        let mut changes = vec![];
        let mut edits: Vec<(Range<usize>, String)> = vec![];
        for (numbers, values) in new {
            for ((old, value), ranges) in numbers.values.iter().zip(values).zip(&numbers.ranges) {
                for range in ranges.iter().filter(|_| old != value) {
                    let (key, from, to) =
                        (numbers.key.clone(), self.text[range.clone()].to_owned(), decimal(*value));
                    let line = 1 + self.text[..range.start].matches('\n').count();
                    changes.push(Change { line, key, from, to: to.clone() });
                    edits.push((range.clone(), to));
                }
            }
        }
        edits.sort_by_key(|(range, _)| std::cmp::Reverse(range.start));
        let mut text = self.text.to_owned();
        edits.into_iter().for_each(|(range, to)| text.replace_range(range, &to));
        (text, changes)
    }
}

const NUMBER: &str = "a number, because expressions are not evaluated; write its value";

/// Returns a number without exponent, which some readers of these files do not accept.
pub(crate) fn decimal(value: f64) -> String {
    let text = value.to_string();
    if text.contains('.') { text } else { text + ".0" }
}

/// Returns the product of a gain and a conversion factor, rounded to twelve digits.
pub(crate) fn converted(value: f64, factor: f64) -> f64 {
    if factor == 1.0 { value } else { rounded(value * factor) }
}

/// Rounds a computed gain to twelve digits.
pub(crate) fn rounded(value: f64) -> f64 {
    format!("{value:.11e}").parse().unwrap_or(value)
}

/// Returns the byte range of a part of a text that starts at byte `begin`.
fn piece(begin: usize, whole: &str, part: &str) -> Range<usize> {
    let start = begin + (part.as_ptr() as usize).saturating_sub(whole.as_ptr() as usize);
    start..start + part.len()
}
