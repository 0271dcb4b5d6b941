//! Objects of problem files, parsed strictly: duplicate and unknown keys are errors.

use crate::error::Error;
use crate::source::Source;
use serde::Deserialize;
use squid_certificate::Rows;
use squid_lpv::matrix::Mat;
use squid_lpv::state_space::StateSpace;

/// Largest magnitude of a number: products of larger ones overflow in the matrix inequalities.
const LARGEST: f64 = 1e100;

/// Defines an object with optional keys: values, then matrices. In a `file` the keys may be inside `data`, and comments
/// are allowed and ignored.
macro_rules! object {
    (file $(#[$meta:meta])* $name:ident {
        $($key:literal $field:ident: $type:ty),*; $($matrix:literal $of:ident),*
    }) => {
        $crate::object::object!($(#[$meta])* $name {
            "data" data: Box<$name>, $($key $field: $type),*; $($matrix $of),* }
            "kind" _kind "name" _name "source" _source "tests" _tests "expected" _expected "note" _note
            "notes" _notes "right" _right "unit" _unit "convention" _convention "Bt_scale" _bt_scale "G" _g);

        impl $name {
            /// Reads a file, with its keys inside `data` if present.
            pub(crate) fn read(source: &Source) -> Result<Self, Error> {
                let mut read: Self = source.json()?;
                let Some(inner) = read.data.take() else { return Ok(read) };
                match read.keys().next() {
                    Some(key) => Err(source.misplaced(key, "in 'data'")),
                    None if inner.data.is_some() => Err(source.wrong("data", "is also given in 'data'; remove one of \
                        the two")),
                    None => Ok(*inner),
                }
            }
        }
    };
    ($(#[$meta:meta])* $name:ident { $($key:literal $field:ident: $type:ty),*; $($matrix:literal $of:ident),* }
        $($note:literal $ignored:ident)*) => {
        $(#[$meta])*
        #[derive(Debug, Default, serde::Deserialize)]
        #[serde(deny_unknown_fields, default, expecting = "an object")]
        pub struct $name {
            $(#[doc = concat!("The key `", $key, "`.")]
            #[serde(rename = $key, deserialize_with = "squid_certificate::given")]
            pub $field: Option<$type>,)*
            $(#[serde(rename = $matrix, deserialize_with = "squid_certificate::given")]
            $of: Option<$crate::object::Matrix>,)*
            $(#[serde(rename = $note)]
            $ignored: serde::de::IgnoredAny,)*
        }

        #[allow(dead_code, reason = "not every object is asked for its keys or has matrices")]
        impl $name {
            /// Returns the given keys, without comments.
            fn keys(&self) -> impl Iterator<Item = &'static str> {
                [$(($key, self.$field.is_some()),)* $(($matrix, self.$of.is_some())),*]
                    .into_iter().filter(|key| key.1).map(|key| key.0)
            }

            /// Takes the given matrices out of the object.
            fn take(&mut self) -> $crate::object::Given {
                let all: Vec<(&'static str, Option<$crate::object::Matrix>)> = vec![$(($matrix, self.$of.take())),*];
                all.into_iter().filter_map(|(key, matrix)| Some((key, matrix?))).collect()
            }
        }
    };
}
pub(crate) use object;

/// Entry of a matrix.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(try_from = "Option<f64>")]
pub struct Entry(pub f64);

impl TryFrom<Option<f64>> for Entry {
    type Error = String;

    fn try_from(found: Option<f64>) -> Result<Self, String> {
        match found {
            Some(entry) if entry.abs() <= LARGEST => Ok(Self(entry)),
            Some(entry) => Err(format!(
                "found {entry:e}; it must be at most 1e100 in magnitude, because products of larger numbers overflow"
            )),
            None => Err(
                "found null; it must be a finite number (some programs write null for infinity; a weight \
                         that is infinite at high frequency is improper)"
                    .into(),
            ),
        }
    }
}

/// Matrix as in the file; without rows its number of columns is undetermined.
#[derive(Debug, Clone, Deserialize)]
#[serde(try_from = "Vec<Vec<T>>", bound = "T: Deserialize<'de>")]
pub struct Matrix<T = Entry>(pub Vec<Vec<T>>);

impl<T> TryFrom<Vec<Vec<T>>> for Matrix<T> {
    type Error = String;

    fn try_from(rows: Vec<Vec<T>>) -> Result<Self, String> {
        let width = rows.first().map_or(0, Vec::len);
        if rows.iter().all(|row| row.len() == width) {
            return Ok(Self(rows));
        }
        Err(format!("the rows have different lengths; the length of the first is {width}"))
    }
}

impl From<&Rows> for Matrix {
    fn from(rows: &Rows) -> Self {
        Self(rows.iter().map(|row| row.iter().copied().map(Entry).collect()).collect())
    }
}

/// Key and matrix of each matrix that is given.
pub type Given = Vec<(&'static str, Matrix)>;

/// Matrices of a file.
#[derive(Debug)]
pub struct Matrices<'a> {
    /// The file, named in errors.
    pub source: &'a Source,
    /// The given matrices.
    pub given: Given,
}

impl Matrices<'_> {
    /// Returns the rows of a matrix, if it is given.
    pub fn rows(&self, key: &str) -> Option<&[Vec<Entry>]> {
        self.given.iter().find(|(name, _)| *name == key).map(|(_, matrix)| matrix.0.as_slice())
    }

    /// Returns a matrix of the given shape; zero if it is optional and omitted or without entries.
    ///
    /// # Errors
    /// [`Error::Problem`] if it is missing or has another shape.
    pub fn get(&self, key: &str, (rows, columns): (usize, usize), optional: bool) -> Result<Mat, Error> {
        let given = self.rows(key);
        if given.is_none() && !optional {
            return Err(self.source.wrong(key, "is missing"));
        }
        let given = given.unwrap_or_default();
        let found = (given.len(), given.first().map_or(columns, Vec::len));
        if optional && found.0 * found.1 == 0 {
            return Ok(Mat::zeros(rows, columns));
        }
        if found != (rows, columns) {
            let text = "to match the other matrices it must be";
            let text = format!("is {} x {}; {text} {rows} x {columns}", found.0, found.1);
            return Err(self.source.wrong(key, text));
        }
        Ok(Mat::from_fn(rows, columns, |i, j| given[i][j].0))
    }

    /// Returns the shape of the first of these matrices that has rows, `(0, 0)` if none has.
    pub fn shape(&self, keys: &[&str]) -> (usize, usize) {
        let found = keys.iter().find_map(|key| self.rows(key).filter(|rows| !rows.is_empty()));
        found.map_or((0, 0), |rows| (rows.len(), rows[0].len()))
    }

    /// Checks that the matrix `key`, if present, is the identity.
    ///
    /// # Errors
    /// [`Error::Problem`] with the first entry that differs; `text` describes the allowed value.
    pub fn only_identity(&self, key: &str, text: &str) -> Result<(), Error> {
        for (i, row) in self.rows(key).unwrap_or_default().iter().enumerate() {
            let differs = |(j, entry): &(usize, &Entry)| entry.0 != f64::from(u8::from(i == *j));
            if let Some((j, entry)) = row.iter().enumerate().find(differs) {
                let reason = format!("is {} in row {}, column {}; it must be {text}", entry.0, i + 1, j + 1);
                return Err(self.source.wrong(key, reason));
            }
        }
        Ok(())
    }
}

object! {
    /// System `x' = A x + B w, z = C x + D w`.
    System {; "A" a, "B" b, "C" c, "D" d }
}

impl System {
    /// Returns the system; errors name the file.
    ///
    /// # Errors
    /// [`Error::Problem`] if a matrix is missing or has another shape.
    pub fn state_space(mut self, source: &Source) -> Result<StateSpace, Error> {
        let m = Matrices { source, given: self.take() };
        let (n, (z, w)) = (m.shape(&["A"]).0, m.shape(&["D"]));
        let (d, a) = (m.get("D", (z, w), false), m.get("A", (n, n), false)?);
        Ok(StateSpace { a, d: d?, b: m.get("B", (n, w), n == 0)?, c: m.get("C", (z, n), n == 0)? })
    }
}

/// Checks that a number, if given, is in its range.
///
/// # Errors
/// [`Error::Problem`] with the key; `allowed` describes the range that `is_allowed` tests.
pub fn checked(
    source: &Source,
    key: &str,
    number: Option<f64>,
    allowed: &str,
    is_allowed: impl Fn(f64) -> bool,
) -> Result<Option<f64>, Error> {
    match number {
        Some(number) if !is_allowed(number) => {
            Err(source.wrong(key, format!("is the number {number:?}; it must be {allowed}")))
        }
        number => Ok(number),
    }
}
