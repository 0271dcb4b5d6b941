//! Problem files of `squid lpv`: a generalised plant as JSON.
//!
//! ```json
//! {"kind": "lpvsyn-lft", "data": {"P": {"A": [[..]], "Bt": .., "B1": .., "B2": .., "Ct": .., "C1": .., "C2": .., "Dtt": ..,
//!  "Dt1": .., "Dt2": .., "D1t": .., "D11": .., "D12": .., "D2t": .., "D21": ..}, "blocks": [r_1, ..]}}
//! {"kind": "hinfsyn", "data": {"A": .., "B1": .., "B2": .., "C1": .., "C2": .., "D11": .., "D12": .., "D21": ..}}
//! ```
//!
//! A certificate is a problem file, too: its plant is taken. Matrices are lists of rows; the partition is that of `lpv::plant`.
//!
//! Weights are part of the plant, so a weight that is not proper cannot be written down: it has no state-space form with finite
//! matrices. What would stand for one is refused by name: `E` of a descriptor system `E x' = A x + ..` unless it is the identity, and
//! numbers that are not finite. So is `D22` unless it is 0, for the synthesis would be of another plant. Other keys are passed
//! over.

use crate::error::Error;
use crate::output::read;
use lpv::matrix::{Mat, from_rows};
use lpv::plant::GeneralisedPlant;
use serde_json::{Map, Value};
use std::path::Path;

/// Reads a problem file.
///
/// # Errors
/// [`Error::Unreadable`]; [`Error::Problem`] with file and key; [`Error::Shape`] when matrices do not fit together.
pub fn plant(path: &Path) -> Result<GeneralisedPlant, Error> {
    let reader = Reader { file: path.display().to_string() };
    let text = read(path)?;
    let value: Value = serde_json::from_str(&text).map_err(|e| reader.wrong("", not_json(&e, &text)))?;
    let data = reader.object(value.get("data").unwrap_or(&value), "data")?;
    let nested = ["P", "plant"].into_iter().find(|key| data.contains_key(*key));
    let matrices = nested.map_or(Ok(data), |key| reader.object(&data[key], key))?;
    let blocks = if nested.is_some() { reader.blocks(data)? } else { vec![] };
    let r = blocks.iter().sum();
    let a = reader.matrix(matrices, "A", None)?;
    let n = a.nrows();
    reader.only(matrices, "E", |i, j| if i == j { 1.0 } else { 0.0 }, IMPROPER)?;
    reader.only(matrices, "D22", |_, _| 0.0, DIRECT_PATH)?;
    let b1 = reader.matrix(matrices, "B1", Some(0))?;
    let b2 = reader.matrix(matrices, "B2", Some(0))?;
    let c1 = reader.matrix(matrices, "C1", Some(n))?;
    let c2 = reader.matrix(matrices, "C2", Some(n))?;
    let (w, u, z, y) = (b1.ncols(), b2.ncols(), c1.nrows(), c2.nrows());
    // A problem without parameters has no channel matrices; zeros may also be left out of D11, D12, D21.
    let part = |key: &'static str, rows: usize, cols: usize| -> Result<Mat, Error> {
        if !matrices.contains_key(key) && (rows == 0 || cols == 0) {
            return Ok(Mat::zeros(rows, cols));
        }
        reader.matrix(matrices, key, Some(cols))
    };
    let plant = GeneralisedPlant {
        bt: part("Bt", n, r)?,
        ct: part("Ct", r, n)?,
        dtt: part("Dtt", r, r)?,
        dt1: part("Dt1", r, w)?,
        dt2: part("Dt2", r, u)?,
        d1t: part("D1t", z, r)?,
        d2t: part("D2t", y, r)?,
        d11: part("D11", z, w)?,
        d12: part("D12", z, u)?,
        d21: part("D21", y, w)?,
        a,
        b1,
        b2,
        c1,
        c2,
        blocks,
    };
    plant.check()?;
    Ok(plant)
}

/// JSON has no infinity, but programs write one: Python as `Infinity`, others as 1e999.
fn not_json(error: &serde_json::Error, text: &str) -> String {
    let infinite = ["Infinity", "NaN", "nan", "inf"].iter().any(|word| text.contains(word))
        || error.to_string().starts_with("number out of range");
    let advice = if infinite {
        "; its numbers must be finite (a weight that is infinite at high frequency is not proper)"
    } else {
        ""
    };
    format!("is not JSON: {error}{advice}")
}

const IMPROPER: &str = "the identity, or left out: with a singular E the plant, or a weight in it, is not proper (its gain grows without \
                        limit with frequency), and has no least gamma; make such a weight proper by a pole well above the bandwidth";

const DIRECT_PATH: &str = "0, or left out: take the direct path from u to y out of the plant, and put it around the controller again";

struct Reader {
    file: String,
}

impl Reader {
    fn wrong(&self, key: &str, reason: String) -> Error {
        let key = if key.is_empty() { String::new() } else { format!("'{key}' ") };
        Error::Problem { file: self.file.clone(), reason: format!("{key}{reason}") }
    }

    fn object<'a>(&self, value: &'a Value, key: &str) -> Result<&'a Map<String, Value>, Error> {
        value.as_object().ok_or_else(|| self.wrong(key, "must be an object with the matrices".into()))
    }

    fn blocks(&self, data: &Map<String, Value>) -> Result<Vec<usize>, Error> {
        let blocks = data.get("blocks").ok_or_else(|| self.wrong("blocks", "is missing".into()))?;
        let list: Option<Vec<usize>> =
            blocks.as_array().and_then(|l| l.iter().map(|v| v.as_u64().map(|v| v as usize)).collect());
        match list {
            Some(list) if list.iter().all(|r| (1..=1000).contains(r)) => Ok(list),
            _ => {
                Err(self.wrong("blocks", format!("is {blocks}; it must be a list of whole numbers above 0")))
            }
        }
    }

    /// Checks that the matrix `key`, if it is there, is the one allowed.
    fn only(
        &self,
        from: &Map<String, Value>,
        key: &'static str,
        allowed: impl Fn(usize, usize) -> f64,
        words: &str,
    ) -> Result<(), Error> {
        if !from.contains_key(key) {
            return Ok(());
        }
        let matrix = self.matrix(from, key, Some(0))?;
        for i in 0..matrix.nrows() {
            for j in 0..matrix.ncols() {
                if matrix[(i, j)] != allowed(i, j) {
                    let found = matrix[(i, j)];
                    return Err(self.wrong(
                        key,
                        format!("is {found} in row {}, column {}; it must be {words}", i + 1, j + 1),
                    ));
                }
            }
        }
        Ok(())
    }

    /// What is wrong with a matrix that is no list of rows of numbers.
    fn no_matrix(&self, key: &str, value: &Value) -> Error {
        for (i, row) in value.as_array().into_iter().flatten().enumerate() {
            for (j, entry) in row.as_array().into_iter().flatten().enumerate() {
                if entry.as_f64().is_none() {
                    return self.wrong(
                        key,
                        format!(
                            "is {entry} in row {}, column {}; it must be a finite number (a weight that is infinite at high \
                             frequency is not proper)",
                            i + 1,
                            j + 1
                        ),
                    );
                }
            }
        }
        self.wrong(key, "must be a list of rows of numbers".into())
    }

    /// The matrix `key`; a matrix without rows has as many columns as `columns` says.
    fn matrix(
        &self,
        from: &Map<String, Value>,
        key: &'static str,
        columns: Option<usize>,
    ) -> Result<Mat, Error> {
        let value = from.get(key).ok_or_else(|| self.wrong(key, "is missing".into()))?;
        let rows: Option<Vec<Vec<f64>>> = value.as_array().and_then(|rows| {
            let row =
                |row: &Value| -> Option<Vec<f64>> { row.as_array()?.iter().map(Value::as_f64).collect() };
            rows.iter().map(row).collect()
        });
        let rows = rows.ok_or_else(|| self.no_matrix(key, value))?;
        let width = rows.first().map_or(columns.unwrap_or(0), Vec::len);
        let matrix = from_rows(&rows, width);
        matrix.ok_or_else(|| {
            self.wrong(key, format!("has rows of unlike length; the first has {width} numbers"))
        })
    }
}
