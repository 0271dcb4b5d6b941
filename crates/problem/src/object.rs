//! The objects of problem files, read strictly: each key once, and none that is unknown.

use crate::error::Error;
use crate::source::Source;
use serde::Deserialize;
use squid_certificate::Rows;
use squid_lpv::error::ShapeError;
use squid_lpv::matrix::Mat;
use squid_lpv::state_space::StateSpace;

/// Numbers above this overflow in the products of the matrix inequalities.
const LARGEST: f64 = 1e100;

/// An object whose keys may all be missing; with `notes`, those of [`NOTES`](crate::source::NOTES) are allowed and have
/// no effect.
macro_rules! object {
    ($(#[$meta:meta])* $name:ident { $($key:literal $field:ident: $type:ty),* $(,)? }) => {
        $crate::object::object!($(#[$meta])* $name { $($key $field: $type),* } with);
    };
    ($(#[$meta:meta])* $name:ident { $($key:literal $field:ident: $type:ty),* $(,)? } with notes) => {
        $crate::object::object!($(#[$meta])* $name { $($key $field: $type),* } with
            "kind" _kind "name" _name "source" _source "tests" _tests "expected" _expected "note" _note
            "notes" _notes "right" _right "unit" _unit "convention" _convention "Bt_scale" _bt_scale "G" _g);
    };
    ($(#[$meta:meta])* $name:ident { $($key:literal $field:ident: $type:ty),* $(,)? }
        with $($note:literal $ignored:ident)*) => {
        $(#[$meta])*
        #[derive(Debug, Default, serde::Deserialize)]
        #[serde(deny_unknown_fields, default, expecting = "an object")]
        pub struct $name {
            $(#[doc = concat!("The key `", $key, "`.")]
            #[serde(rename = $key, deserialize_with = "squid_certificate::given")]
            pub $field: Option<$type>,)*
            $(#[serde(rename = $note)]
            $ignored: serde::de::IgnoredAny,)*
        }

        impl $name {
            /// The given keys without those of comments.
            pub fn keys(&self) -> impl Iterator<Item = &'static str> {
                [$(($key, self.$field.is_some())),*].into_iter().filter(|key| key.1).map(|key| key.0)
            }
        }
    };
}
pub(crate) use object;

/// An entry of a matrix.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(try_from = "Option<f64>")]
pub struct Entry(pub f64);

impl TryFrom<Option<f64>> for Entry {
    type Error = String;

    fn try_from(found: Option<f64>) -> Result<Self, String> {
        match found {
            Some(entry) if entry.abs() <= LARGEST => Ok(Self(entry)),
            Some(entry) => Err(format!(
                "found {entry:e}, must be at most 1e100 in magnitude, because products of larger numbers overflow"
            )),
            None => Err("found null, must be a finite number (programs write null for an infinite one; a weight that \
                         is infinite at high frequency is not proper)"
                .into()),
        }
    }
}

/// A matrix as in the file; one without rows does not determine the number of columns.
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
        Err(format!("rows of different lengths; the first has {width} numbers"))
    }
}

impl From<&Rows> for Matrix {
    fn from(rows: &Rows) -> Self {
        Self(rows.iter().map(|row| row.iter().copied().map(Entry).collect()).collect())
    }
}

impl Matrix {
    /// The matrix; without rows it has `columns` columns.
    fn of(&self, columns: usize) -> Mat {
        let width = self.0.first().map_or(columns, Vec::len);
        Mat::from_fn(self.0.len(), width, |i, j| self.0[i][j].0)
    }
}

/// The size of a matrix if its entries do not give it.
#[derive(Debug, Clone, Copy, Default)]
pub struct Size {
    /// Number of rows.
    pub rows: usize,
    /// Number of columns.
    pub columns: usize,
    /// Whether it may be left out, as it has no entries.
    pub optional: bool,
}

/// Given matrices, by key.
pub type Given = Vec<(&'static str, Matrix)>;

/// Matrices of a file.
#[derive(Debug)]
pub struct Matrices<'a> {
    /// Names the file in errors.
    pub source: &'a Source,
    /// Those that are given.
    pub given: Given,
}

impl Matrices<'_> {
    fn find(&self, key: &str, columns: usize) -> Option<Mat> {
        self.given.iter().find(|(name, _)| *name == key).map(|(_, matrix)| matrix.of(columns))
    }

    /// A matrix; if it has no entries and is optional, it may be omitted.
    ///
    /// # Errors
    /// [`Error::Problem`] if it is missing.
    pub fn get(&self, key: &str, size: Size) -> Result<Mat, Error> {
        match self.find(key, size.columns) {
            Some(matrix) if !(size.optional && matrix.is_empty()) => Ok(matrix),
            None if !size.optional => Err(self.source.wrong(key, "is missing")),
            _ => Ok(Mat::zeros(size.rows, size.columns)),
        }
    }

    /// A matrix; zero if omitted.
    ///
    /// # Errors
    /// [`Error::Problem`] when it has another shape.
    pub fn or_zero(&self, key: &'static str, rows: usize, columns: usize) -> Result<Mat, Error> {
        let expected = (rows, columns);
        match self.find(key, columns).filter(|matrix| matrix.shape() != (0, 0)) {
            Some(matrix) if matrix.shape() != expected => {
                Err(self.source.wrong("", ShapeError { name: key, found: matrix.shape(), expected }))
            }
            found => Ok(found.unwrap_or_else(|| Mat::zeros(rows, columns))),
        }
    }

    /// The shape of the first of these matrices that has rows, `(0, 0)` if none has.
    pub fn shape(&self, keys: &[&str]) -> (usize, usize) {
        let found = keys.iter().filter_map(|key| self.find(key, 0));
        found.map(|matrix| matrix.shape()).find(|shape| shape.0 > 0).unwrap_or_default()
    }

    /// Checks that the matrix `key`, if present, is the identity.
    ///
    /// # Errors
    /// [`Error::Problem`] with the first entry that differs, and what it must be.
    pub fn only_identity(&self, key: &str, words: &str) -> Result<(), Error> {
        let Some(matrix) = self.find(key, 0) else { return Ok(()) };
        for i in 0..matrix.nrows() {
            for j in 0..matrix.ncols() {
                let entry = matrix[(i, j)];
                if entry != f64::from(u8::from(i == j)) {
                    let reason = format!("is {entry} in row {}, column {}; it must be {words}", i + 1, j + 1);
                    return Err(self.source.wrong(key, reason));
                }
            }
        }
        Ok(())
    }
}

object! {
    /// A system `x' = A x + B w, z = C x + D w`.
    System { "A" a: Matrix, "B" b: Matrix, "C" c: Matrix, "D" d: Matrix }
}

impl System {
    /// The system; errors name the file.
    ///
    /// # Errors
    /// [`Error::Problem`] if a matrix is missing or has another shape.
    pub fn state_space(self, source: &Source) -> Result<StateSpace, Error> {
        let all = [("A", self.a), ("B", self.b), ("C", self.c), ("D", self.d)];
        let given = all.into_iter().filter_map(|(key, matrix)| Some((key, matrix?))).collect();
        let m = Matrices { source, given };
        let (a, d) = (m.get("A", Size::default())?, m.get("D", Size::default())?);
        let (n, (outputs, inputs)) = (a.nrows(), d.shape());
        let size = |rows, columns| Size { rows, columns, optional: n == 0 };
        let b = m.get("B", size(n, inputs))?;
        let c = m.get("C", size(outputs, n))?;
        for (key, matrix, (rows, columns)) in
            [("A", &a, (n, n)), ("B", &b, (n, inputs)), ("C", &c, (outputs, n))]
        {
            if matrix.shape() != (rows, columns) {
                let (found_rows, found_columns) = matrix.shape();
                let words = format!(
                    "is {found_rows} x {found_columns}; with the other matrices it must be {rows} x {columns}"
                );
                return Err(source.wrong(key, words));
            }
        }
        Ok(StateSpace { a, b, c, d })
    }
}

/// A number that must be in a range, if given.
///
/// # Errors
/// [`Error::Problem`] that names the key; `allowed` describes `is_allowed`.
pub fn checked(
    source: &Source,
    key: &str,
    number: Option<f64>,
    allowed: &str,
    is_allowed: impl Fn(f64) -> bool,
) -> Result<Option<f64>, Error> {
    match number {
        Some(number) if !is_allowed(number) => {
            Err(source.wrong(key, format!("is the number {number}; it must be {allowed}")))
        }
        number => Ok(number),
    }
}
