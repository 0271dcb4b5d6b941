//! TOML files that people write: tables with their names and line numbers. Every mistake is recorded and all are
//! reported together.

mod error;

use std::cell::RefCell;
use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue, Error};

pub use error::{FileError, FileProblem, Mistake};

use crate::vehicle::allowed::Allowed;
use crate::words::{nearest, number};

/// Larger numbers than this overflow in the products of coefficients. The moments of the largest ships are some 1e13
/// kg m2.
const LARGEST: f64 = 1e18;
const TOO_LARGE: &str = "at most 1e18 in size, for the products of larger numbers overflow";

/// The most tables, and the most numbers or pairs, in one list: many times those of any vehicle.
const MOST_TABLES: usize = 100;
const MOST_NUMBERS: usize = 1000;

/// The longest text that a message quotes in full, in characters.
const LONGEST_SHOWN: usize = 60;

/// A file with the mistakes recorded so far.
#[derive(Debug)]
pub struct Document<'a> {
    text: &'a str,
    file: &'a str,
    /// The byte offset at which mistakes of the root table are reported.
    start: usize,
    entries: DeTable<'a>,
    /// Place in the text, and what is wrong there.
    mistakes: RefCell<Vec<(usize, FileProblem)>>,
}

impl<'a> Document<'a> {
    /// Parses a text; `file` is its name in messages.
    ///
    /// # Errors
    /// [`FileError`]: the text is not TOML. A second value of a key is recorded as a mistake, and the
    /// first is used.
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
                document.blame(at, FileProblem::Twice { key });
            } else {
                // What follows may be a consequence.
                let message = error.message().to_owned();
                let comma = document.decimal_comma(at).map(|found| FileProblem::DecimalComma { found });
                document.blame(at, comma.unwrap_or(FileProblem::NotToml { message }));
                document.check()?;
            }
        }
        Ok(document)
    }

    /// Parses a text with a list of tables `[[list]]` as one document for each of them: its entries, and those of the
    /// text outside the list. A text without the list is one document.
    ///
    /// # Errors
    /// As [`Document::parse`]; a list that is none. An entry that stands in a table of the list and outside it is
    /// recorded as a mistake.
    pub fn parse_each(text: &'a str, file: &'a str, list: &str) -> Result<Vec<Self>, FileError> {
        let first = Self::parse(text, file)?;
        let count = first.root().tables(list).len();
        if !first.root().has(list) {
            return Ok(vec![first]);
        }
        first.check()?;
        let mut documents = Vec::with_capacity(count);
        for place in 0..count {
            let mut document = Self::parse(text, file)?;
            let tables = document.entries.remove(list).map(Spanned::into_inner);
            let Some(DeValue::Array(tables)) = tables else { continue };
            let Some(table) = tables.into_iter().nth(place) else { continue };
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

    /// The root table.
    pub fn root(&self) -> Table<'_> {
        self.table(String::new(), self.start..self.start, &self.entries)
    }

    fn table<'d>(&'d self, path: String, span: Range<usize>, entries: &'d DeTable<'d>) -> Table<'d> {
        Table { document: self, path, span, entries, meant: RefCell::new(Vec::new()) }
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

    /// Returns what was read, if no mistake was recorded.
    ///
    /// # Errors
    /// As [`Document::check`]; a value that cannot be read leaves a mistake.
    pub fn finish<T>(&self, read: Option<T>) -> Result<T, FileError> {
        self.check()?;
        read.ok_or_else(|| FileError { file: self.file.to_owned(), mistakes: Vec::new() })
    }

    /// A number with a decimal comma after an equals sign in the line of a byte offset.
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

    /// The line, counted from 1, of a byte offset.
    pub fn line(&self, at: usize) -> usize {
        self.text.bytes().take(at).filter(|&byte| byte == b'\n').count() + 1
    }
}

/// A table of a file. A value that cannot be read is recorded as a mistake of its [`Document`], and `None` is
/// returned.
#[derive(Debug, Clone)]
pub struct Table<'d> {
    document: &'d Document<'d>,
    path: String,
    span: Range<usize>,
    entries: &'d DeTable<'d>,
    /// Keys that are probably meant by misspelt ones; they are not reported as missing, too.
    meant: RefCell<Vec<String>>,
}

/// A number with its unit and source.
#[derive(Debug, Clone)]
pub struct Quantity {
    /// The number, in its unit.
    pub value: f64,
    /// The unit.
    pub unit: String,
    /// Where the number comes from.
    pub source: String,
}

impl Quantity {
    /// Returns the number in SI: degrees become radians, those a second too, everything else is SI already.
    pub fn si(&self) -> f64 {
        if matches!(self.unit.as_str(), "deg" | "deg/s") { self.value.to_radians() } else { self.value }
    }
}

impl<'d> Table<'d> {
    /// The line on which the table begins.
    pub fn line(&self) -> usize {
        self.document.line(self.span.start)
    }

    /// Its name with those of the tables around it.
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
        self.blame(key, FileProblem::NotAllowed { key: self.full(key), found, allowed });
    }

    /// The keys of the table with their byte offsets, in the order of the file.
    pub fn keys(&self) -> Vec<(usize, &'d str)> {
        let mut keys: Vec<_> =
            self.entries.iter().map(|(key, _)| (key.span().start, key.get_ref().as_ref())).collect();
        keys.sort_unstable();
        keys
    }

    /// Whether a key is there.
    pub fn has(&self, key: &str) -> bool {
        self.entries.contains_key(key)
    }

    /// What is read at a key, or a default where it is not there.
    pub fn or<T>(&self, key: &str, default: T, read: impl FnOnce(&Self, &str) -> Option<T>) -> Option<T> {
        if self.has(key) { read(self, key) } else { Some(default) }
    }

    /// Whether a key is there; records a mistake if it is not.
    pub fn requires(&self, key: &str, meaning: &str) -> bool {
        let there = self.has(key);
        if !there && !self.meant.borrow().iter().any(|meant| meant == key) {
            self.problem(FileProblem::MissingKey { key: self.full(key), meaning: meaning.to_owned() });
        }
        there
    }

    /// The name of a key with the tables around it.
    fn full(&self, key: &str) -> String {
        if self.path.is_empty() { key.to_string() } else { format!("{}.{key}", self.path) }
    }

    /// Records a mistake for every key that is not listed; a key that a misspelt one probably means is then not
    /// reported as missing.
    pub fn allow_only(&self, keys: &[&str]) {
        self.allow_only_or(keys, &[]);
    }

    /// Does the same, and suggests the listed name of a key that is `renamed`, from its name to the listed one.
    pub fn allow_only_or(&self, keys: &[&str], renamed: &[(&str, &str)]) {
        for (at, key) in self.keys().into_iter().filter(|(_, key)| !keys.contains(key)) {
            let mut allowed = keys.to_vec();
            allowed.dedup();
            let renamed = renamed.iter().find(|(other, _)| *other == key).map(|(_, own)| (*own).to_owned());
            let suggestion = renamed.or_else(|| nearest(key, &allowed));
            self.meant.borrow_mut().extend(suggestion.clone());
            let (key, allowed) = (self.full(key), allowed.join(", "));
            self.document.blame(at, FileProblem::UnknownKey { key, suggestion, allowed });
        }
    }

    /// Records that the value of a key is of the wrong type.
    fn wrong_type<T>(&self, key: &str, value: &Spanned<DeValue<'_>>, expected: &str) -> Option<T> {
        let (found, allowed) = (describe(value.get_ref()), expected.to_owned());
        let problem = FileProblem::NotAllowed { key: self.full(key), found, allowed };
        self.document.blame(value.span().start, problem);
        None
    }

    /// Returns a table, if it is there.
    pub fn table(&self, key: &str) -> Option<Table<'d>> {
        let (name, value) = self.entries.get_key_value(key)?;
        match value.get_ref() {
            DeValue::Table(entries) => Some(self.child(self.full(key), name.span(), entries)),
            _ => self.wrong_type(key, value, "a table"),
        }
    }

    /// Returns whether a key is the first part of a name with a dot, which TOML reads as a table.
    pub fn is_dotted(&self, key: &str) -> bool {
        let name = self.entries.get_key_value(key).map(|(name, _)| name.span());
        let after = name.and_then(|span| self.document.text.get(span.end..));
        after.is_some_and(|rest| rest.trim_start().starts_with('.'))
    }

    /// Returns a table that must be there.
    pub fn required_table(&self, key: &str, meaning: &str) -> Option<Table<'d>> {
        self.requires(key, meaning).then(|| self.table(key)).flatten()
    }

    /// Returns an array of tables `[[key]]`, empty if it is not there.
    pub fn tables(&self, key: &str) -> Vec<Table<'d>> {
        let Some(value) = self.entries.get(key) else { return Vec::new() };
        let expected = "a list of tables, each under its own [[...]]";
        let DeValue::Array(items) = value.get_ref() else {
            return self.wrong_type(key, value, expected).unwrap_or_default();
        };
        let table = |item: &'d Spanned<DeValue<'d>>| match item.get_ref() {
            DeValue::Table(entries) => Some(self.child(self.full(key), item.span(), entries)),
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

    /// The value of a key, if it is not a list that is too long.
    fn short(&self, key: &str) -> Option<&'d Spanned<DeValue<'d>>> {
        let value = self.entries.get(key)?;
        let found = value.get_ref().as_array().map_or(0, |list| list.len());
        (!self.is_too_long(key, found, MOST_NUMBERS)).then_some(value)
    }

    /// Returns whether a list is too long, and records that as a mistake.
    fn is_too_long(&self, key: &str, found: usize, most: usize) -> bool {
        if found > most {
            self.blame(key, FileProblem::TooLong { key: self.full(key), found, most });
        }
        found > most
    }

    fn child(&self, path: String, span: Range<usize>, entries: &'d DeTable<'d>) -> Table<'d> {
        self.document.table(path, span, entries)
    }

    /// Returns a text that must be there and not be empty.
    pub fn text(&self, key: &str) -> Option<String> {
        self.requires(key, "a text in quotes").then(|| self.words(key, "a text in quotes")).flatten()
    }

    /// Returns whether a key has this text.
    pub fn is_text(&self, key: &str, text: &str) -> bool {
        self.entries.get(key).is_some_and(|value| value.get_ref().as_str() == Some(text))
    }

    /// Returns whether a key has this text in a table of a list; records no mistake.
    pub fn has_among(&self, list: &str, key: &str, text: &str) -> bool {
        let tables = self.entries.get(list).and_then(|value| value.get_ref().as_array());
        let found = |table: &Spanned<DeValue<'_>>| {
            let value = table.get_ref().as_table().and_then(|entries| entries.get(key));
            value.is_some_and(|value| value.get_ref().as_str() == Some(text))
        };
        tables.is_some_and(|tables| tables.iter().any(found))
    }

    fn words(&self, key: &str, expected: &str) -> Option<String> {
        let value = self.entries.get(key)?;
        let Some(text) = value.get_ref().as_str() else { return self.wrong_type(key, value, expected) };
        let problem = if text.trim().is_empty() {
            FileProblem::EmptyText { key: self.full(key) }
        } else if let Some(found) = text.chars().find(|&c| !stands_in_xml(c)) {
            FileProblem::Character { key: self.full(key), found }
        } else {
            return Some(text.to_string());
        };
        self.blame(key, problem);
        None
    }

    /// Returns the index in a list of the word under a key, which must be there.
    pub fn one_of(&self, key: &str, words: &[&str]) -> Option<usize> {
        let allowed = quoted(words);
        if !self.requires(key, &format!("it must be {allowed}")) {
            return None;
        }
        let found = self.words(key, &allowed)?;
        let place = words.iter().position(|word| *word == found);
        if place.is_none() {
            let suggestion = nearest(&found, words).map(|word| format!(" (did you mean \"{word}\"?)"));
            self.not_allowed(key, cited(&found) + &suggestion.unwrap_or_default(), allowed);
        }
        place
    }

    /// Returns `{ value, unit, source }` if the key is there; the unit must be one of `units`, and the number
    /// allowed.
    pub fn quantity(&self, key: &str, units: &[&str], allowed: Allowed) -> Option<Quantity> {
        let value = self.entries.get(key)?;
        let DeValue::Table(entries) = value.get_ref() else {
            return self.wrong_type(key, value, "a table { value = ..., unit = \"...\", source = \"...\" }");
        };
        let table = self.child(self.full(key), value.span(), entries);
        table.allow_only(&["value", "unit", "source"]);
        let found = table.requires("value", "the number").then(|| table.float("value", "a decimal number"));
        let unit_there = table.requires("unit", &format!("the unit, {}", quoted(units)));
        let unit = unit_there.then(|| table.words("unit", "a text in quotes"));
        let source_there = table.requires("source", "where the number comes from");
        let source = source_there.then(|| table.words("source", "a text in quotes"));
        let (value, unit, source) = (found.flatten(), unit.flatten(), source.flatten());
        if let Some(found) = unit.clone().filter(|unit| !units.contains(&unit.as_str())) {
            let (key, expected) = (self.full(key), quoted(units));
            table.blame("unit", FileProblem::WrongUnit { key, found, expected });
            return None;
        }
        let (value, unit, source) = (value?, unit?, source?);
        if !allowed.contains(value) || value.abs() > LARGEST {
            let words = if allowed.contains(value) { TOO_LARGE } else { allowed.describe() };
            self.not_allowed(key, format!("{} {unit}", number(value)), words);
            return None;
        }
        Some(Quantity { value, unit, source })
    }

    /// Whether a quantity is given in this unit.
    pub fn is_in(&self, key: &str, unit: &str) -> bool {
        let entries = self.entries.get(key).and_then(|value| value.get_ref().as_table());
        entries
            .and_then(|entries| entries.get("unit"))
            .is_some_and(|found| found.get_ref().as_str() == Some(unit))
    }

    /// Returns a number that must be there and be allowed; `words` describes that.
    pub fn number(&self, key: &str, allowed: impl Fn(f64) -> bool, words: &str) -> Option<f64> {
        if !self.requires(key, words) {
            return None;
        }
        let found = self.float(key, &format!("a number, {words}"))?;
        let possible = found.is_finite() && allowed(found);
        if possible && found.abs() <= LARGEST {
            return Some(found);
        }
        self.not_allowed(key, number(found), if possible { TOO_LARGE } else { words });
        None
    }

    /// Returns a whole number that must be there and be allowed; `words` describes that.
    pub fn whole(&self, key: &str, allowed: impl Fn(usize) -> bool, words: &str) -> Option<usize> {
        if !self.requires(key, words) {
            return None;
        }
        let value = self.entries.get(key)?;
        let found = match value.get_ref() {
            DeValue::Integer(integer) if integer.radix() == 10 => integer.as_str().parse().ok(),
            _ => None,
        };
        match found {
            Some(found) if allowed(found) => Some(found),
            _ => self.wrong_type(key, value, &format!("a whole number, {words}")),
        }
    }

    /// Returns the truth value under a key that is there.
    pub fn truth(&self, key: &str) -> Option<bool> {
        let value = self.entries.get(key)?;
        value.get_ref().as_bool().or_else(|| self.wrong_type(key, value, "true or false"))
    }

    /// Returns the number under a key that is there.
    pub fn float(&self, key: &str, expected: &str) -> Option<f64> {
        let value = self.entries.get(key)?;
        decimal(value).or_else(|| self.wrong_type(key, value, expected))
    }

    /// Returns a finite number, or a list of them, that must be there; `words` describes it.
    pub fn numbers(&self, key: &str, words: &str) -> Option<Vec<f64>> {
        if !self.requires(key, words) {
            return None;
        }
        let value = self.short(key)?;
        let sane =
            |value: &Spanned<DeValue<'_>>| decimal(value).filter(|number: &f64| number.abs() <= LARGEST);
        let all = match value.get_ref() {
            DeValue::Array(list) => list.iter().map(sane).collect(),
            _ => sane(value).map(|number| vec![number]),
        };
        all.or_else(|| self.wrong_type(key, value, words))
    }

    /// Returns a list of pairs of finite numbers that must be there, with one pair or more; `words` describes it.
    pub fn pairs(&self, key: &str, words: &str) -> Option<Vec<[f64; 2]>> {
        if !self.requires(key, words) {
            return None;
        }
        let value = self.short(key)?;
        let finite = |value: &Spanned<DeValue<'_>>| decimal(value).filter(|number: &f64| number.is_finite());
        let pair = |pair: &Spanned<DeValue<'_>>| match pair.get_ref().as_array()?.as_ref() {
            [one, two] => Some([finite(one)?, finite(two)?]),
            _ => None,
        };
        let pairs =
            value.get_ref().as_array().and_then(|list| list.iter().map(pair).collect::<Option<Vec<_>>>());
        pairs.filter(|list| !list.is_empty()).or_else(|| self.wrong_type(key, value, words))
    }

    /// Whether the value of a key is a table.
    pub fn holds_table(&self, key: &str) -> bool {
        self.entries.get(key).is_some_and(|value| value.get_ref().is_table())
    }
}

/// Adds entries to a table, and to the tables in it; returns place and name of those that it has already.
fn merge<'a>(into: &mut DeTable<'a>, own: DeTable<'a>) -> Vec<(usize, String)> {
    let mut twice = Vec::new();
    for (key, value) in own {
        match into.get_mut(key.get_ref().as_ref()).map(Spanned::get_mut) {
            None => _ = into.insert(key, value),
            Some(DeValue::Table(shared)) if value.get_ref().is_table() => {
                if let DeValue::Table(own) = value.into_inner() {
                    let within = |(at, inner)| (at, format!("{}.{inner}", key.get_ref()));
                    twice.extend(merge(shared, own).into_iter().map(within));
                }
            }
            Some(_) => twice.push((key.span().start, key.get_ref().to_string())),
        }
    }
    twice
}

/// A decimal number, if it is one.
fn decimal(value: &Spanned<DeValue<'_>>) -> Option<f64> {
    match value.get_ref() {
        DeValue::Float(float) => float.as_str().parse().ok(),
        DeValue::Integer(integer) if integer.radix() == 10 => integer.as_str().parse().ok(),
        _ => None,
    }
}

/// A value in plain words.
fn describe(value: &DeValue<'_>) -> String {
    match value {
        DeValue::String(text) => format!("the text {}", cited(text)),
        DeValue::Integer(integer) => format!("the number {}", shortened(integer.as_str())),
        DeValue::Float(float) => format!("the number {}", shortened(float.as_str())),
        DeValue::Boolean(truth) => truth.to_string(),
        DeValue::Datetime(date) => format!("the date or time {date}"),
        DeValue::Array(_) => "a list".into(),
        DeValue::Table(_) => "a table".into(),
    }
}

/// A text in quotes, on one line.
pub fn cited(text: &str) -> String {
    format!("\"{}\"", shortened(text))
}

/// The beginning of a long text.
fn shortened(text: &str) -> String {
    let rest = if text.chars().count() > LONGEST_SHOWN { "..." } else { "" };
    let visible = text.chars().map(|c| if c.is_control() { ' ' } else { c });
    visible.take(LONGEST_SHOWN).chain(rest.chars()).collect()
}

/// Whether a character is allowed in XML 1.0: texts of a vehicle appear in model descriptions.
fn stands_in_xml(c: char) -> bool {
    !matches!(c, '\0'..='\u{8}' | '\u{b}' | '\u{c}' | '\u{e}'..='\u{1f}' | '\u{fffe}' | '\u{ffff}')
}

fn quoted(words: &[&str]) -> String {
    words.iter().map(|word| format!("\"{word}\"")).collect::<Vec<_>>().join(" or ")
}
