//! A file of an autopilot: its values with their places, so that numbers change and every other byte stays.

use crate::refusal::{not_allowed, refused};
use squid_auv::toml_file::{FileError, FileProblem};
use std::ops::Range;

/// A value of a file.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Entry {
    /// Its key.
    pub(crate) key: String,
    /// Its line.
    pub(crate) line: usize,
    /// Where its text is; in several pieces if it goes on after a line break.
    pub(crate) pieces: Vec<Range<usize>>,
}

/// A file with its values.
#[derive(Debug)]
pub(crate) struct Source<'a> {
    pub(crate) text: &'a str,
    pub(crate) file: &'a str,
    pub(crate) entries: Vec<Entry>,
}

/// The numbers of a key.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Numbers {
    pub(crate) key: String,
    pub(crate) line: usize,
    pub(crate) values: Vec<f64>,
    /// The places of each; more than one where the key stands again with the same value.
    places: Vec<Vec<Range<usize>>>,
}

/// A number that was written over another.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// Its line.
    pub line: usize,
    /// Its key.
    pub key: String,
    /// The text that was there.
    pub from: String,
    /// The text that is there now.
    pub to: String,
}

impl<'a> Source<'a> {
    /// A file without values so far.
    pub(crate) fn new(text: &'a str, file: &'a str) -> Self {
        Self { text, file, entries: vec![] }
    }

    /// The lines of the text, without what ends them, each with the place where it begins.
    pub(crate) fn lines(&self) -> impl Iterator<Item = (usize, usize, &'a str)> + use<'a> {
        let mut begin = 0;
        self.text.split('\n').enumerate().map(move |(at, line)| {
            let here = begin;
            begin += line.len() + 1;
            (at + 1, here, line.trim_end_matches('\r'))
        })
    }

    /// Adds a value; `begin` is where the text `whole` begins of which `value` is a part.
    pub(crate) fn push(&mut self, key: String, line: usize, begin: usize, whole: &str, value: &str) {
        self.entries.push(Entry { key, line, pieces: vec![piece(begin, whole, value)] });
    }

    /// Adds to the last value what stands after its line break.
    pub(crate) fn extend(&mut self, begin: usize, whole: &str, value: &str) {
        if let Some(last) = self.entries.last_mut() {
            last.pieces.push(piece(begin, whole, value));
        }
    }

    /// A refusal of a value.
    pub(crate) fn refuse<T>(
        &self,
        line: usize,
        key: &str,
        found: impl Into<String>,
        allowed: impl Into<String>,
    ) -> Result<T, FileError> {
        Err(not_allowed(self.file, line, key, found, allowed))
    }

    /// The text of a value.
    pub(crate) fn words(&self, entry: &Entry) -> String {
        entry.pieces.iter().map(|piece| &self.text[piece.clone()]).collect::<Vec<_>>().join(" ")
    }

    /// The values of a key, all of them the same.
    pub(crate) fn all(&self, key: &str) -> Result<Vec<&Entry>, FileError> {
        let all: Vec<&Entry> = self.entries.iter().filter(|entry| entry.key == key).collect();
        if let Some(other) = all.iter().find(|entry| self.words(entry) != self.words(all[0])) {
            let found = format!("{}, and {} on line {}", self.words(other), self.words(all[0]), all[0].line);
            return self.refuse(other.line, key, found, "one value: remove the one that is not flown");
        }
        Ok(all)
    }

    /// A value that may be there, with its line.
    pub(crate) fn value(&self, key: &str) -> Result<Option<(usize, String)>, FileError> {
        Ok(self.all(key)?.first().map(|entry| (entry.line, self.words(entry))))
    }

    /// The numbers of a key, if it is there: so many, each finite and not negative.
    pub(crate) fn optional(&self, key: &str, size: usize) -> Result<Option<Numbers>, FileError> {
        let all = self.all(key)?;
        let Some(first) = all.first() else { return Ok(None) };
        let (line, mut values, mut places) = (first.line, vec![], vec![vec![]; size]);
        for entry in &all {
            let tokens = self.tokens(entry);
            if tokens.len() != size {
                let allowed = if size == 1 { NUMBER.into() } else { format!("{size} numbers") };
                return self.refuse(entry.line, key, self.shown(entry), allowed);
            }
            for (token, places) in tokens.into_iter().zip(&mut places) {
                places.push(token);
            }
        }
        for token in &places {
            let words = &self.text[token[0].clone()];
            match words.parse::<f64>() {
                Ok(value) if value.is_finite() && value >= 0.0 => values.push(value),
                Ok(_) => return self.refuse(line, key, words, "a number, 0 or above"),
                Err(_) => return self.refuse(line, key, self.shown(first), NUMBER),
            }
        }
        Ok(Some(Numbers { key: key.to_owned(), line, values, places }))
    }

    /// The same for a key that must be there.
    pub(crate) fn required(&self, key: &str, size: usize, meaning: &str) -> Result<Numbers, FileError> {
        let missing = || FileProblem::MissingKey { key: key.to_owned(), meaning: meaning.to_owned() };
        self.optional(key, size)?.ok_or_else(|| refused(self.file, 1, missing()))
    }

    /// Refuses a number of 0 where a gain must be.
    pub(crate) fn above_zero(&self, numbers: &Numbers, at: usize) -> Result<(), FileError> {
        let Numbers { key, line, values, .. } = numbers;
        if values[at] > 0.0 {
            return Ok(());
        }
        let place = if values.len() > 1 { format!("0 as its number {}", at + 1) } else { "0".into() };
        self.refuse(*line, key, place, "above 0: without it there is no such loop")
    }

    fn shown(&self, entry: &Entry) -> String {
        let words = self.words(entry);
        if words.is_empty() { "empty".into() } else { format!("\"{words}\"") }
    }

    /// The places of the words of a value, apart by commas and spaces.
    fn tokens(&self, entry: &Entry) -> Vec<Range<usize>> {
        let words = |place: &Range<usize>| {
            let text = &self.text[place.clone()];
            let words = text.split([',', ' ', '\t']).filter(|word| !word.is_empty());
            words.map(|word| piece(place.start, text, word)).collect::<Vec<_>>()
        };
        entry.pieces.iter().flat_map(words).collect()
    }

    /// The text with new values of keys, and what changed. A number that has its value already stays as it is written.
    pub(crate) fn replaced(&self, new: &[(&Numbers, Vec<f64>)]) -> (String, Vec<Change>) {
        let mut changes = vec![];
        let mut edits: Vec<(Range<usize>, String)> = vec![];
        for (numbers, values) in new {
            for ((old, value), places) in numbers.values.iter().zip(values).zip(&numbers.places) {
                for place in places.iter().filter(|_| old != value) {
                    let (key, from, to) =
                        (numbers.key.clone(), self.text[place.clone()].to_owned(), decimal(*value));
                    let line = 1 + self.text[..place.start].matches('\n').count();
                    changes.push(Change { line, key, from, to: to.clone() });
                    edits.push((place.clone(), to));
                }
            }
        }
        edits.sort_by_key(|(place, _)| std::cmp::Reverse(place.start));
        let mut text = self.text.to_owned();
        edits.into_iter().for_each(|(place, to)| text.replace_range(place, &to));
        (text, changes)
    }
}

const NUMBER: &str = "a number: squid computes nothing here; write the number that it has";

/// A number in full, without an exponent, which not every reader of these files takes.
pub(crate) fn decimal(value: f64) -> String {
    let words = value.to_string();
    if words.contains('.') { words } else { words + ".0" }
}

/// The product of a gain and a conversion factor, to twelve digits: more would be rounding.
pub(crate) fn converted(value: f64, factor: f64) -> f64 {
    if factor == 1.0 { value } else { rounded(value * factor) }
}

/// A computed gain to twelve digits.
pub(crate) fn rounded(value: f64) -> f64 {
    format!("{value:.11e}").parse().unwrap_or(value)
}

/// The place of a part of a text that begins at `begin`.
fn piece(begin: usize, whole: &str, part: &str) -> Range<usize> {
    let at = begin + (part.as_ptr() as usize).saturating_sub(whole.as_ptr() as usize);
    at..at + part.len()
}
