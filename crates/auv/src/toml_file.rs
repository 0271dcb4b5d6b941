//! TOML files written by people: tables with names and line numbers. All mistakes are collected and reported together.

mod error;

use std::cell::RefCell;
use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue, Error};

pub use error::{FileError, FileProblem, Mistake};

use crate::text::{nearest, number};
use crate::vehicle::allowed::Allowed;

/// Limit of the size of numbers: products of larger coefficients overflow. The moments of inertia of the largest ships
/// are some 1e13 kg m2.
const LARGEST: f64 = 1e18;
const TOO_LARGE: &str = "at most 1e18 in magnitude, because products of larger numbers overflow";

/// Limits of the number of tables, and of numbers or pairs, in one list: many times those of any vehicle.
const MOST_TABLES: usize = 100;
const MOST_NUMBERS: usize = 1000;

/// Longest text that a message quotes in full, in characters.
const LONGEST_SHOWN: usize = 60;

/// File with the mistakes recorded so far.
#[derive(Debug)]
pub struct Document<'a> {
    text: &'a str,
    file: &'a str,
    /// Byte offset at which mistakes of the root table are reported.
    start: usize,
    entries: DeTable<'a>,
    /// Byte offset and description of each mistake.
    mistakes: RefCell<Vec<(usize, FileProblem)>>,
}

impl<'a> Document<'a> {
    /// Parses a text; `file` is its name in messages.
    ///
    /// # Errors
    /// [`FileError`]: the text is not TOML. A second value of a key is recorded as a mistake, and the first is used.
    pub fn parse(text: &'a str, file: &'a str) -> Result<Self, FileError> {
        let (root, errors) = DeTable::parse_recoverable(text);
        let (entries, mistakes) = (root.into_inner(), RefCell::new(Vec::new()));
        let document = Self { text, file, start: 0, entries, mistakes };
        let mut errors: Vec<(usize, &Error)> =
            errors.iter().map(|error| (error.span().map_or(0, |span| span.start), error)).collect();
        errors.sort_by_key(|(at, _)| *at);
        for (at, error) in errors {
            if error.message() == "duplicate key" {
                let key = error.span().and_then(|span| text.get(span)).unwrap_or_default().to_owned();
                document.blame(at, FileProblem::DuplicateKey { key });
            } else {
                // Further errors may be consequences of this one.
                let message = error.message().to_owned();
                let comma = document.decimal_comma(at).map(|found| FileProblem::DecimalComma { found });
                document.blame(at, comma.unwrap_or(FileProblem::NotToml { message }));
                document.check()?;
            }
        }
        Ok(document)
    }

    /// Parses a text with a list of tables `[[list]]` as one document per table: its entries, and those of the text
    /// outside the list. A text without the list is one document.
    ///
    /// # Errors
    /// Errors of [`Document::parse`]; an invalid list. An entry both in a table of the list and outside is recorded as
    /// a mistake.
    pub fn parse_each(text: &'a str, file: &'a str, list: &str) -> Result<Vec<Self>, FileError> {
        let first = Self::parse(text, file)?;
        let count = first.root().tables(list).len();
        if !first.root().has(list) {
            return Ok(vec![first]);
        }
        first.check()?;
        let mut documents = Vec::with_capacity(count);
        for index in 0..count {
            let mut document = Self::parse(text, file)?;
            let tables = document.entries.remove(list).map(Spanned::into_inner);
            let Some(DeValue::Array(tables)) = tables else { continue };
            let Some(table) = tables.into_iter().nth(index) else { continue };
            document.start = table.span().start;
            if let DeValue::Table(own) = table.into_inner() {
                for (at, key) in merge(&mut document.entries, own) {
                    document.blame(at, FileProblem::InAndOutside { key, list: list.to_owned() });
                }
            }
            documents.push(document);
        }
        Ok(documents)
    }

    /// Returns the root table.
    pub fn root(&self) -> Table<'_> {
        self.table(String::new(), self.start..self.start, &self.entries)
    }

    fn table<'d>(&'d self, path: String, span: Range<usize>, entries: &'d DeTable<'d>) -> Table<'d> {
        Table { document: self, path, span, entries, suspected: RefCell::new(Vec::new()) }
    }

    /// Records a mistake at a byte offset of the text.
    pub fn blame(&self, at: usize, problem: FileProblem) {
        self.mistakes.borrow_mut().push((at, problem));
    }

    /// Checks that no mistake has been recorded.
    ///
    /// # Errors
    /// [`FileError`] with all mistakes in the order of the file.
    pub fn check(&self) -> Result<(), FileError> {
        let mut mistakes = self.mistakes.take();
        if mistakes.is_empty() {
            return Ok(());
        }
        mistakes.sort_by_key(|(at, _)| *at);
        let mistake = |(at, problem)| Mistake { line: self.line(at), problem };
        Err(FileError { file: self.file.to_owned(), mistakes: mistakes.into_iter().map(mistake).collect() })
    }

    /// Returns the value read, if no mistake was recorded.
    ///
    /// # Errors
    /// Errors of [`Document::check`]; a value that cannot be read leaves a mistake.
    pub fn finish<T>(&self, read: Option<T>) -> Result<T, FileError> {
        self.check()?;
        read.ok_or_else(|| FileError { file: self.file.to_owned(), mistakes: Vec::new() })
    }

    /// Returns a number with a decimal comma after an equals sign in the line of a byte offset.
    fn decimal_comma(&self, at: usize) -> Option<String> {
        let line = self.text.lines().nth(self.line(at) - 1)?;
        let outside_of_quotes = line.split('"').step_by(2).flat_map(|part| part.split('=').skip(1));
        let number = |value: &str| {
            let (whole, rest) = value.trim_start().split_once(',')?;
            let decimals: String = rest.chars().take_while(char::is_ascii_digit).collect();
            (whole.parse::<i64>().is_ok() && !decimals.is_empty()).then(|| format!("{whole},{decimals}"))
        };
        outside_of_quotes.into_iter().find_map(number)
    }

    /// Returns the line of a byte offset, counted from 1.
    pub fn line(&self, at: usize) -> usize {
        self.text.bytes().take(at).filter(|&byte| byte == b'\n').count() + 1
    }
}

/// Table of a file. A value that cannot be read is recorded as a mistake of its [`Document`], and `None` is returned.
#[derive(Debug, Clone)]
pub struct Table<'d> {
    document: &'d Document<'d>,
    path: String,
    span: Range<usize>,
    entries: &'d DeTable<'d>,
    /// Keys probably meant by misspelt ones; they are not also reported as missing.
    suspected: RefCell<Vec<String>>,
}

/// Number with its unit and source.
#[derive(Debug, Clone)]
pub struct Quantity {
    /// Number, in its unit.
    pub value: f64,
    /// Unit.
    pub unit: String,
    /// Source of the number.
    pub source: String,
}

impl Quantity {
    /// Returns the number in SI: deg and deg/s are converted to rad and rad/s, everything else is SI already.
    pub fn si(&self) -> f64 {
        if matches!(self.unit.as_str(), "deg" | "deg/s") { self.value.to_radians() } else { self.value }
    }
}

impl<'d> Table<'d> {
    /// Returns the line on which the table begins.
    pub fn line(&self) -> usize {
        self.document.line(self.span.start)
    }

    /// Returns the name, including those of the enclosing tables.
    pub fn name(&self) -> &str {
        &self.path
    }

    /// Records a mistake at the table.
    pub fn problem(&self, problem: FileProblem) {
        self.document.blame(self.span.start, problem);
    }

    /// Records a mistake at the value of a key, or at the table if the key is missing.
    pub fn blame(&self, key: &str, problem: FileProblem) {
        let at = self.entries.get(key).map_or(self.span.start, |value| value.span().start);
        self.document.blame(at, problem);
    }

    /// Records that the value of a key is not allowed.
    pub fn not_allowed(&self, key: &str, found: impl Into<String>, allowed: impl Into<String>) {
        let (found, allowed) = (found.into(), allowed.into());
        self.blame(key, FileProblem::NotAllowed { key: self.full_key(key), found, allowed });
    }

    /// Returns the keys of the table with their byte offsets, in the order of the file.
    pub fn keys(&self) -> Vec<(usize, &'d str)> {
        let mut keys: Vec<_> =
            self.entries.iter().map(|(key, _)| (key.span().start, key.get_ref().as_ref())).collect();
        keys.sort_unstable();
        keys
    }

    /// Returns `true` if a key is present.
    pub fn has(&self, key: &str) -> bool {
        self.entries.contains_key(key)
    }

    /// Returns the value read at a key, or a default if the key is absent.
    pub fn or<T>(&self, key: &str, default: T, read: impl FnOnce(&Self, &str) -> Option<T>) -> Option<T> {
        if self.has(key) { read(self, key) } else { Some(default) }
    }

    /// Returns `true` if a key is present; otherwise records a mistake.
    pub fn requires(&self, key: &str, meaning: &str) -> bool {
        let there = self.has(key);
        if !there && !self.suspected.borrow().iter().any(|suspected| suspected == key) {
            self.problem(FileProblem::MissingKey { key: self.full_key(key), meaning: meaning.to_owned() });
        }
        there
    }

    /// Returns the name of a key, including those of the enclosing tables.
    fn full_key(&self, key: &str) -> String {
        if self.path.is_empty() { key.to_string() } else { format!("{}.{key}", self.path) }
    }

    /// Records a mistake for every key that is not listed; a listed key that a misspelt one probably means is then not
    /// reported as missing.
    pub fn allow_only(&self, keys: &[&str]) {
        self.allow_only_or(keys, &[]);
    }

    /// Does the same, and suggests the listed name for a `renamed` key: pairs of old and listed name.
    pub fn allow_only_or(&self, keys: &[&str], renamed: &[(&str, &str)]) {
        for (at, key) in self.keys().into_iter().filter(|(_, key)| !keys.contains(key)) {
            let mut allowed = keys.to_vec();
            allowed.dedup();
            let renamed = renamed.iter().find(|(other, _)| *other == key).map(|(_, own)| (*own).to_owned());
            let suggestion = renamed.or_else(|| nearest(key, &allowed));
            self.suspected.borrow_mut().extend(suggestion.clone());
            let (key, allowed) = (self.full_key(key), allowed.join(", "));
            self.document.blame(at, FileProblem::UnknownKey { key, suggestion, allowed });
        }
    }

    /// Records that the value of a key is of the wrong type.
    fn wrong_type<T>(&self, key: &str, value: &Spanned<DeValue<'_>>, expected: &str) -> Option<T> {
        let (found, allowed) = (describe(value.get_ref()), expected.to_owned());
        let problem = FileProblem::NotAllowed { key: self.full_key(key), found, allowed };
        self.document.blame(value.span().start, problem);
        None
    }

    /// Returns a table, if present.
    pub fn table(&self, key: &str) -> Option<Table<'d>> {
        let (name, value) = self.entries.get_key_value(key)?;
        match value.get_ref() {
            DeValue::Table(entries) => Some(self.child(self.full_key(key), name.span(), entries)),
            _ => self.wrong_type(key, value, "a table"),
        }
    }

    /// Returns `true` if a key is the first part of a dotted name, which TOML reads as a table.
    pub fn is_dotted(&self, key: &str) -> bool {
        let name = self.entries.get_key_value(key).map(|(name, _)| name.span());
        let after = name.and_then(|span| self.document.text.get(span.end..));
        after.is_some_and(|rest| rest.trim_start().starts_with('.'))
    }

    /// Returns a required table.
    pub fn required_table(&self, key: &str, meaning: &str) -> Option<Table<'d>> {
        self.requires(key, meaning).then(|| self.table(key)).flatten()
    }

    /// Returns an array of tables `[[key]]`, empty if absent.
    pub fn tables(&self, key: &str) -> Vec<Table<'d>> {
        let Some(value) = self.entries.get(key) else { return Vec::new() };
        let expected = "a list of tables, each with its own [[...]] header";
        let DeValue::Array(items) = value.get_ref() else {
            return self.wrong_type(key, value, expected).unwrap_or_default();
        };
        let table = |item: &'d Spanned<DeValue<'d>>| match item.get_ref() {
            DeValue::Table(entries) => Some(self.child(self.full_key(key), item.span(), entries)),
            _ => self.wrong_type(key, item, expected),
        };
        if items.is_empty() {
            self.not_allowed(key, "an empty list", expected);
        }
        if self.is_too_long(key, items.len(), MOST_TABLES) {
            return Vec::new();
        }
        items.iter().filter_map(table).collect()
    }

    /// Returns the value of a key, unless it is a list that is too long.
    fn list_within_limit(&self, key: &str) -> Option<&'d Spanned<DeValue<'d>>> {
        let value = self.entries.get(key)?;
        let found = value.get_ref().as_array().map_or(0, |list| list.len());
        (!self.is_too_long(key, found, MOST_NUMBERS)).then_some(value)
    }

    /// Returns `true` if a list is too long, and records that as a mistake.
    fn is_too_long(&self, key: &str, found: usize, most: usize) -> bool {
        if found > most {
            self.blame(key, FileProblem::TooLong { key: self.full_key(key), found, most });
        }
        found > most
    }

    fn child(&self, path: String, span: Range<usize>, entries: &'d DeTable<'d>) -> Table<'d> {
        self.document.table(path, span, entries)
    }

    /// Returns a required, non-empty text.
    pub fn text(&self, key: &str) -> Option<String> {
        self.requires(key, "a string in quotes").then(|| self.string(key, "a string in quotes")).flatten()
    }

    /// Returns `true` if a key has this text.
    pub fn is_text(&self, key: &str, text: &str) -> bool {
        self.entries.get(key).is_some_and(|value| value.get_ref().as_str() == Some(text))
    }

    /// Returns `true` if a key has this text in a table of a list; records no mistake.
    pub fn has_among(&self, list: &str, key: &str, text: &str) -> bool {
        let tables = self.entries.get(list).and_then(|value| value.get_ref().as_array());
        let found = |table: &Spanned<DeValue<'_>>| {
            let value = table.get_ref().as_table().and_then(|entries| entries.get(key));
            value.is_some_and(|value| value.get_ref().as_str() == Some(text))
        };
        tables.is_some_and(|tables| tables.iter().any(found))
    }

    fn string(&self, key: &str, expected: &str) -> Option<String> {
        let value = self.entries.get(key)?;
        let Some(text) = value.get_ref().as_str() else { return self.wrong_type(key, value, expected) };
        let problem = if text.trim().is_empty() {
            FileProblem::EmptyText { key: self.full_key(key) }
        } else if let Some(found) = text.chars().find(|&c| !is_xml_character(c)) {
            FileProblem::Character { key: self.full_key(key), found }
        } else {
            return Some(text.to_string());
        };
        self.blame(key, problem);
        None
    }

    /// Returns the index in a list of the text of a required key.
    pub fn one_of(&self, key: &str, options: &[&str]) -> Option<usize> {
        let allowed = quoted(options);
        if !self.requires(key, &format!("it must be {allowed}")) {
            return None;
        }
        let found = self.string(key, &allowed)?;
        let index = options.iter().position(|word| *word == found);
        if index.is_none() {
            let suggestion = nearest(&found, options).map(|word| format!(" (did you mean \"{word}\"?)"));
            self.not_allowed(key, cited(&found) + &suggestion.unwrap_or_default(), allowed);
        }
        index
    }

    /// Returns `{ value, unit, source }` if the key is present; the unit must be one of `units`, and the number must be
    /// allowed.
    pub fn quantity(&self, key: &str, units: &[&str], allowed: Allowed) -> Option<Quantity> {
        let value = self.entries.get(key)?;
        let DeValue::Table(entries) = value.get_ref() else {
            return self.wrong_type(key, value, "a table { value = ..., unit = \"...\", source = \"...\" }");
        };
        let table = self.child(self.full_key(key), value.span(), entries);
        table.allow_only(&["value", "unit", "source"]);
        let found = table.requires("value", "the number").then(|| table.float("value", "a decimal number"));
        let unit_there = table.requires("unit", &format!("the unit, {}", quoted(units)));
        let unit = unit_there.then(|| table.string("unit", "a string in quotes"));
        let source_there = table.requires("source", "the origin of the number");
        let source = source_there.then(|| table.string("source", "a string in quotes"));
        let (value, unit, source) = (found.flatten(), unit.flatten(), source.flatten());
        if let Some(found) = unit.clone().filter(|unit| !units.contains(&unit.as_str())) {
            let (key, expected) = (self.full_key(key), quoted(units));
            table.blame("unit", FileProblem::WrongUnit { key, found, expected });
            return None;
        }
        let (value, unit, source) = (value?, unit?, source?);
        if !allowed.contains(value) || value.abs() > LARGEST {
            let description = if allowed.contains(value) { TOO_LARGE } else { allowed.describe() };
            self.not_allowed(key, format!("{} {unit}", number(value)), description);
            return None;
        }
        Some(Quantity { value, unit, source })
    }

    /// Returns `true` if a quantity is given in this unit.
    pub fn is_in(&self, key: &str, unit: &str) -> bool {
        let entries = self.entries.get(key).and_then(|value| value.get_ref().as_table());
        entries
            .and_then(|entries| entries.get("unit"))
            .is_some_and(|found| found.get_ref().as_str() == Some(unit))
    }

    /// Returns the number of a required key; `expected` describes the allowed values.
    pub fn number(&self, key: &str, allowed: impl Fn(f64) -> bool, expected: &str) -> Option<f64> {
        if !self.requires(key, expected) {
            return None;
        }
        let found = self.float(key, &format!("a number, {expected}"))?;
        let possible = found.is_finite() && allowed(found);
        if possible && found.abs() <= LARGEST {
            return Some(found);
        }
        self.not_allowed(key, number(found), if possible { TOO_LARGE } else { expected });
        None
    }

    /// Returns the integer of a required key; `expected` describes the allowed values.
    pub fn whole(&self, key: &str, allowed: impl Fn(usize) -> bool, expected: &str) -> Option<usize> {
        if !self.requires(key, expected) {
            return None;
        }
        let value = self.entries.get(key)?;
        let found = match value.get_ref() {
            DeValue::Integer(integer) if integer.radix() == 10 => integer.as_str().parse().ok(),
            _ => None,
        };
        match found {
            Some(found) if allowed(found) => Some(found),
            _ => self.wrong_type(key, value, &format!("an integer, {expected}")),
        }
    }

    /// Returns the boolean of a key, if present.
    pub fn truth(&self, key: &str) -> Option<bool> {
        let value = self.entries.get(key)?;
        value.get_ref().as_bool().or_else(|| self.wrong_type(key, value, "true or false"))
    }

    /// Returns the number of a key, if present.
    pub fn float(&self, key: &str, expected: &str) -> Option<f64> {
        let value = self.entries.get(key)?;
        decimal(value).or_else(|| self.wrong_type(key, value, expected))
    }

    /// Returns a finite number, or a list of them, of a required key; `expected` describes the value.
    pub fn numbers(&self, key: &str, expected: &str) -> Option<Vec<f64>> {
        if !self.requires(key, expected) {
            return None;
        }
        let value = self.list_within_limit(key)?;
        let sane =
            |value: &Spanned<DeValue<'_>>| decimal(value).filter(|number: &f64| number.abs() <= LARGEST);
        let all = match value.get_ref() {
            DeValue::Array(list) => list.iter().map(sane).collect(),
            _ => sane(value).map(|number| vec![number]),
        };
        all.or_else(|| self.wrong_type(key, value, expected))
    }

    /// Returns a non-empty list of pairs of finite numbers of a required key; `expected` describes the value.
    pub fn pairs(&self, key: &str, expected: &str) -> Option<Vec<[f64; 2]>> {
        if !self.requires(key, expected) {
            return None;
        }
        let value = self.list_within_limit(key)?;
        let finite = |value: &Spanned<DeValue<'_>>| decimal(value).filter(|number: &f64| number.is_finite());
        let pair = |pair: &Spanned<DeValue<'_>>| match pair.get_ref().as_array()?.as_ref() {
            [one, two] => Some([finite(one)?, finite(two)?]),
            _ => None,
        };
        let pairs =
            value.get_ref().as_array().and_then(|list| list.iter().map(pair).collect::<Option<Vec<_>>>());
        pairs.filter(|list| !list.is_empty()).or_else(|| self.wrong_type(key, value, expected))
    }

    /// Returns `true` if the value of a key is a table.
    pub fn holds_table(&self, key: &str) -> bool {
        self.entries.get(key).is_some_and(|value| value.get_ref().is_table())
    }
}

/// Adds entries to a table and to its subtables; returns offset and name of those that it already has.
fn merge<'a>(into: &mut DeTable<'a>, own: DeTable<'a>) -> Vec<(usize, String)> {
    let mut duplicates = Vec::new();
    for (key, value) in own {
        match into.get_mut(key.get_ref().as_ref()).map(Spanned::get_mut) {
            None => _ = into.insert(key, value),
            Some(DeValue::Table(shared)) if value.get_ref().is_table() => {
                if let DeValue::Table(own) = value.into_inner() {
                    let within = |(at, inner)| (at, format!("{}.{inner}", key.get_ref()));
                    duplicates.extend(merge(shared, own).into_iter().map(within));
                }
            }
            Some(_) => duplicates.push((key.span().start, key.get_ref().to_string())),
        }
    }
    duplicates
}

/// Returns a decimal number, if the value is one.
fn decimal(value: &Spanned<DeValue<'_>>) -> Option<f64> {
    match value.get_ref() {
        DeValue::Float(float) => float.as_str().parse().ok(),
        DeValue::Integer(integer) if integer.radix() == 10 => integer.as_str().parse().ok(),
        _ => None,
    }
}

/// Describes a value for messages.
fn describe(value: &DeValue<'_>) -> String {
    match value {
        DeValue::String(text) => format!("the string {}", cited(text)),
        DeValue::Integer(integer) => format!("the number {}", shorten(integer.as_str())),
        DeValue::Float(float) => format!("the number {}", shorten(float.as_str())),
        DeValue::Boolean(truth) => truth.to_string(),
        DeValue::Datetime(date) => format!("the date or time {date}"),
        DeValue::Array(_) => "a list".into(),
        DeValue::Table(_) => "a table".into(),
    }
}

/// Quotes a text on one line.
pub fn cited(text: &str) -> String {
    format!("\"{}\"", shorten(text))
}

/// Returns the beginning of a long text.
fn shorten(text: &str) -> String {
    let rest = if text.chars().count() > LONGEST_SHOWN { "..." } else { "" };
    let visible = text.chars().map(|c| if c.is_control() { ' ' } else { c });
    visible.take(LONGEST_SHOWN).chain(rest.chars()).collect()
}

/// Returns `true` if XML 1.0 allows a character: texts of a vehicle appear in model descriptions.
fn is_xml_character(c: char) -> bool {
    !matches!(c, '\0'..='\u{8}' | '\u{b}' | '\u{c}' | '\u{e}'..='\u{1f}' | '\u{fffe}' | '\u{ffff}')
}

fn quoted(options: &[&str]) -> String {
    options.iter().map(|option| format!("\"{option}\"")).collect::<Vec<_>>().join(" or ")
}
