//! Reads the matrices of a problem file; errors name the key.

use crate::error::Error;
use crate::source::Source;
use certificate::Json;
use lpv::error::ShapeError;
use lpv::matrix::{Mat, from_rows};

/// Numbers above this overflow in the products of the matrix inequalities.
const LARGEST: f64 = 1e100;

/// The keys and values of an object.
pub type Entries = [(String, Json)];

/// Keys of comments in a file, next to `data` or in it; they have no effect.
pub const NOTES: [&str; 12] = [
    "kind",
    "name",
    "source",
    "tests",
    "expected",
    "note",
    "notes",
    "right",
    "unit",
    "convention",
    "Bt_scale",
    "G",
];

/// The value of a key.
pub fn find<'a>(entries: &'a Entries, key: &str) -> Option<&'a Json> {
    entries.iter().find(|(k, _)| k == key).map(|(_, value)| value)
}

/// Whether two words differ only in case or, if long enough, in one letter.
fn is_near(found: &str, word: &str) -> bool {
    const LONG: usize = 4;
    found.eq_ignore_ascii_case(word) || (word.len() >= LONG && strsim::levenshtein(found, word) == 1)
}

/// The size of a matrix if its entries do not give it.
#[derive(Debug, Clone, Copy)]
pub struct Size {
    /// Number of rows.
    pub rows: usize,
    /// Number of columns.
    pub columns: usize,
    /// Whether it is required even without entries.
    pub required: bool,
}

impl Size {
    /// A required matrix with the size of its entries.
    pub fn of_entries() -> Self {
        Self { rows: 0, columns: 0, required: true }
    }
}

/// Reads parts of one file and names it in every error.
#[derive(Debug)]
pub struct Reader {
    file: String,
}

impl Reader {
    /// Reads a text as strictly as a certificate: no key may occur twice.
    ///
    /// # Errors
    /// [`Error::Problem`] with the line.
    pub fn open(source: &Source) -> Result<(Self, Json), Error> {
        let reader = Self { file: source.name.clone() };
        let value = serde_json::from_str(&source.text).map_err(|e| not_json(&reader, &e, &source.text))?;
        Ok((reader, value))
    }

    /// The entries of the object `data`, or of the top-level object if there is none.
    pub fn data<'a>(&self, value: &'a Json) -> Result<&'a Entries, Error> {
        let top = self.object(value, "")?;
        find(top, "data").map_or(Ok(top), |data| self.object(data, "data"))
    }

    /// Rejects a key at `place`, such as "in 'data'", that is not one of `here`; the keys `elsewhere` belong to another
    /// object.
    pub fn only(
        &self,
        entries: &Entries,
        place: &str,
        here: &[&str],
        elsewhere: (&[&str], &str),
    ) -> Result<(), Error> {
        let (others, right_place) = elsewhere;
        let Some((key, _)) = entries.iter().find(|(key, _)| !here.contains(&key.as_str())) else {
            return Ok(());
        };
        if others.contains(&key.as_str()) {
            return Err(self.wrong(key, format!("is out of place; it stands {right_place}")));
        }
        let near = here.iter().find(|word| is_near(key, word));
        let near = near.map_or_else(String::new, |word| format!("; did you mean '{word}'?"));
        let allowed: Vec<&str> = here.iter().filter(|key| !NOTES.contains(key)).copied().collect();
        let allowed = allowed.join(", ");
        Err(self.wrong(key, format!("is not known{near} (allowed {place}: {allowed})")))
    }

    /// Rejects an unknown key next to `data`, if there is one: only comments are allowed there.
    pub fn only_notes_beside_data(&self, value: &Json, elsewhere: (&[&str], &str)) -> Result<(), Error> {
        let top = self.object(value, "")?;
        if find(top, "data").is_none() {
            return Ok(());
        }
        self.only(top, "beside 'data'", &[&["data"], &NOTES[..]].concat(), elsewhere)
    }

    /// An error at a line.
    fn wrong_at(&self, line: usize, reason: String) -> Error {
        Error::Problem { file: format!("{}:{line}", self.file), reason }
    }

    /// An error in `key`; an empty key is not named.
    pub fn wrong(&self, key: &str, reason: String) -> Error {
        let key = if key.is_empty() { String::new() } else { format!("'{key}' ") };
        Error::Problem { file: self.file.clone(), reason: format!("{key}{reason}") }
    }

    /// The entries of an object.
    pub fn object<'a>(&self, value: &'a Json, key: &str) -> Result<&'a Entries, Error> {
        match value {
            Json::Object(entries) => Ok(entries),
            other => {
                Err(self
                    .wrong(key, format!("is {}; it must be an object with the matrices", other.describe())))
            }
        }
    }

    /// The repetitions of the parameters.
    pub fn blocks(&self, data: &Entries) -> Result<Vec<usize>, Error> {
        const ALLOWED: &str = "it must be a list of whole numbers from 1 to 1000";
        let value = find(data, "blocks").ok_or_else(|| self.wrong("blocks", "is missing".into()))?;
        let Json::List(list) = value else {
            return Err(self.wrong("blocks", format!("is {}; {ALLOWED}", value.describe())));
        };
        let repetitions = |(i, entry): (usize, &Json)| match entry {
            Json::Number(r) if (1.0..=1000.0).contains(r) && r.fract() == 0.0 => Ok(*r as usize),
            other => {
                let found = other.describe();
                Err(self.wrong("blocks", format!("has {found} in place {}; {ALLOWED}", i + 1)))
            }
        };
        list.iter().enumerate().map(repetitions).collect()
    }

    /// A matrix; without rows it has `columns` columns.
    fn matrix(&self, key: &str, value: &Json, columns: usize) -> Result<Mat, Error> {
        let rows = self.rows(key, value, "numbers", |entry, place| self.number(key, entry, place))?;
        let width = rows.first().map_or(columns, Vec::len);
        from_rows(&rows, width).ok_or_else(|| self.ragged(key, width))
    }

    /// The rows of a matrix of `what`; `read` reads an entry at a row and column.
    pub fn rows<T>(
        &self,
        key: &str,
        value: &Json,
        what: &str,
        read: impl Fn(&Json, (usize, usize)) -> Result<T, Error>,
    ) -> Result<Vec<Vec<T>>, Error> {
        let not_rows = |found: &Json, place: String| {
            self.wrong(key, format!("is {}{place}; it must be a list of rows of {what}", found.describe()))
        };
        let Json::List(list) = value else { return Err(not_rows(value, String::new())) };
        let row = |(i, row): (usize, &Json)| match row {
            Json::List(row) => row.iter().enumerate().map(|(j, entry)| read(entry, (i + 1, j + 1))).collect(),
            other => Err(not_rows(other, format!(" in row {}", i + 1))),
        };
        list.iter().enumerate().map(row).collect()
    }

    /// The error of a matrix with rows of different lengths.
    pub fn ragged(&self, key: &str, width: usize) -> Error {
        self.wrong(key, format!("has rows of different lengths; the first has {width} numbers"))
    }

    /// The number of a key, if present; `allowed` describes `is_allowed`.
    pub fn optional_number(
        &self,
        entries: &Entries,
        key: &str,
        allowed: &str,
        is_allowed: impl Fn(f64) -> bool,
    ) -> Result<Option<f64>, Error> {
        match find(entries, key) {
            None => Ok(None),
            Some(Json::Number(v)) if is_allowed(*v) => Ok(Some(*v)),
            Some(other) => Err(self.wrong(key, format!("is {}; it must be {allowed}", other.describe()))),
        }
    }

    /// A finite entry of a matrix.
    pub fn number(&self, key: &str, entry: &Json, (row, column): (usize, usize)) -> Result<f64, Error> {
        let wrong = |found: String, words: &str| {
            self.wrong(key, format!("is {found} in row {row}, column {column}; it must be {words}"))
        };
        match entry {
            Json::Number(v) if v.abs() > LARGEST => Err(wrong(
                format!("{v:e}"),
                "at most 1e100 in magnitude, because products of larger numbers overflow",
            )),
            Json::Number(v) => Ok(*v),
            Json::Null => Err(wrong(
                "null".into(),
                "a finite number (programs write null for an infinite one; a weight that is infinite at high \
                    frequency is not proper)",
            )),
            other => Err(wrong(other.describe(), "a finite number")),
        }
    }
}

/// The error of a text that cannot be read, with its line. JSON has no infinity, but some programs write one: Python
/// `Infinity`, others 1e999.
fn not_json(reader: &Reader, error: &serde_json::Error, text: &str) -> Error {
    let message = error.to_string();
    let at = format!(" at line {} column {}", error.line(), error.column());
    let (what, place) = match message.strip_suffix(&at) {
        Some(what) => (what, format!(" (column {})", error.column())),
        None => (message.as_str(), String::new()),
    };
    if error.is_data() {
        return reader.wrong_at(error.line(), format!("cannot be read: {what}{place}"));
    }
    let line = text.lines().nth(error.line().saturating_sub(1)).unwrap_or_default();
    let here: String = line.chars().skip(error.column().saturating_sub(4)).take(12).collect();
    let infinite = ["Infinity", "NaN", "nan", "inf"].iter().any(|word| here.contains(word))
        || message.starts_with("number out of range");
    let advice = if infinite {
        "; its numbers must be finite (a weight that is infinite at high frequency is not proper)"
    } else {
        ""
    };
    reader.wrong_at(error.line(), format!("this is not JSON: {what}{place}{advice}"))
}

/// The matrices of one plant.
#[derive(Debug)]
pub struct Matrices<'a> {
    /// Names the file in errors.
    pub reader: &'a Reader,
    /// The object with the matrices.
    pub entries: &'a Entries,
}

impl Matrices<'_> {
    fn find(&self, key: &str, columns: usize) -> Result<Option<Mat>, Error> {
        find(self.entries, key).map(|value| self.reader.matrix(key, value, columns)).transpose()
    }

    /// A matrix; if it has no entries and is not required, it may be omitted.
    pub fn get(&self, key: &str, size: Size) -> Result<Mat, Error> {
        let is_optional = (size.rows == 0 || size.columns == 0) && !size.required;
        match self.find(key, size.columns)? {
            Some(matrix) if !(is_optional && matrix.is_empty()) => Ok(matrix),
            None if !is_optional => Err(self.reader.wrong(key, "is missing".into())),
            _ => Ok(Mat::zeros(size.rows, size.columns)),
        }
    }

    /// A matrix; zero if omitted.
    ///
    /// # Errors
    /// [`Error::Problem`] when it cannot be read or has another shape.
    pub fn or_zero(&self, key: &'static str, rows: usize, columns: usize) -> Result<Mat, Error> {
        let expected = (rows, columns);
        match self.find(key, columns)? {
            Some(matrix) if matrix.shape() != expected && matrix.shape() != (0, 0) => {
                let shape = ShapeError { name: key, found: matrix.shape(), expected };
                Err(self.reader.wrong("", shape.to_string()))
            }
            Some(matrix) if matrix.shape() == expected => Ok(matrix),
            _ => Ok(Mat::zeros(rows, columns)),
        }
    }

    /// The shape of the first of these matrices that has rows, `(0, 0)` if none has.
    pub fn shape(&self, keys: &[&str]) -> Result<(usize, usize), Error> {
        for key in keys {
            if let Some(matrix) = self.find(key, 0)?.filter(|m| m.nrows() > 0) {
                return Ok(matrix.shape());
            }
        }
        Ok((0, 0))
    }

    /// Checks that the matrix `key`, if present, has the allowed entries.
    ///
    /// # Errors
    /// [`Error::Problem`] with the first entry that differs.
    pub fn only(&self, key: &str, allowed: impl Fn(usize, usize) -> f64, words: &str) -> Result<(), Error> {
        let Some(matrix) = self.find(key, 0)? else { return Ok(()) };
        for i in 0..matrix.nrows() {
            for j in 0..matrix.ncols() {
                let entry = matrix[(i, j)];
                if entry != allowed(i, j) {
                    let reason = format!("is {entry} in row {}, column {}; it must be {words}", i + 1, j + 1);
                    return Err(self.reader.wrong(key, reason));
                }
            }
        }
        Ok(())
    }
}
