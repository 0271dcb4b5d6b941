//! Problem files of `squid lpv mu`: a matrix or a system, and the structure of its perturbation.
//!
//! ```json
//! {"kind": "mu", "data": {"M": [[[re, im], ..], ..], "blocks": [[-r, 0], [r, 0], [p, q], ..]}}
//! {"kind": "mu", "data": {"P": {"A": [[..]], "B": .., "C": .., "D": ..}, "blocks": ..}}
//! {"kind": "mu", "data": {"P": .., "blocks": .., "performance": [p, q], "size": 1}}
//! ```
//!
//! With `performance` the last p inputs of P are w and its last q outputs z: robust performance and the worst-case
//! gain are from w to z. `size` is that of the perturbation for the latter, 1 if not given.
//!
//! An entry of M is a pair of numbers, or a plain number where it is real. No key may occur twice; other keys are
//! ignored, but for those that are nearly one of these.

use crate::error::Error;
use crate::matrices::{Entries, Matrices, Reader, Size, find};
use crate::source::Source;
use certificate::Json;
use lpv::mu::{CMat, Structure};
use lpv::state_space::StateSpace;
use nalgebra::Complex;

/// What is perturbed: `z = M w`, `w = Delta z`.
#[derive(Debug, Clone, PartialEq)]
pub enum Perturbed {
    /// A constant matrix.
    Matrix(CMat),
    /// A system, at all frequencies.
    System(StateSpace),
    /// A system whose last inputs and outputs are those of performance, and the size of the perturbation.
    Performing(StateSpace, f64),
}

/// Largest number of rows, columns or repetitions; more are taken for a mistake.
const LARGEST_BLOCK: f64 = 1000.0;

/// Reads a problem file.
///
/// # Errors
/// [`Error::Problem`] with file and key,
/// also when the blocks do not fit.
pub fn mu_problem(source: &Source) -> Result<(Perturbed, Structure), Error> {
    let (reader, value) = Reader::open(source)?;
    let data = reader.data(&value)?;
    reader.meant(data, &["M", "P", "blocks", "performance", "size"], (&[], ""))?;
    let perturbed = match (find(data, "M"), find(data, "P")) {
        (Some(_), Some(_)) => {
            return Err(reader.wrong("M", "and 'P' are both given; give a matrix M or a system P".into()));
        }
        (Some(m), None) => Perturbed::Matrix(complex_matrix(&reader, m)?),
        (None, Some(p)) => Perturbed::System(system(&reader, reader.object(p, "P")?)?),
        (None, None) => {
            let words = "is missing; a problem has a matrix M, or a system P with A, B, C and D";
            return Err(reader.wrong("M", words.into()));
        }
    };
    let structure = structure(&reader, data)?;
    let performance = performance(&reader, data)?;
    let perturbed = match (perturbed, performance) {
        (Perturbed::System(system), Some((_, _, size))) => Perturbed::Performing(system, size),
        (Perturbed::Matrix(_), Some(_)) => {
            return Err(reader.wrong("performance", "goes with a system P, not with a matrix M".into()));
        }
        (perturbed, _) => perturbed,
    };
    fits(&reader, &perturbed, &structure, performance.map_or((0, 0), |(w, z, _)| (w, z)))?;
    Ok((perturbed, structure))
}

/// A pair of whole numbers, from `least` to [`LARGEST_BLOCK`].
fn pair(value: &Json, least: f64) -> Option<(i64, i64)> {
    let whole = |entry: &Json| match entry {
        Json::Number(v) if v.fract() == 0.0 && (least..=LARGEST_BLOCK).contains(v) => Some(*v as i64),
        _ => None,
    };
    match value {
        Json::List(pair) if pair.len() == 2 => whole(&pair[0]).zip(whole(&pair[1])),
        _ => None,
    }
}

/// The numbers of inputs w and outputs z, and the size of the perturbation.
fn performance(reader: &Reader, data: &Entries) -> Result<Option<(usize, usize, f64)>, Error> {
    const ALLOWED: &str =
        "it must be a pair of whole numbers from 1 to 1000: of the last inputs and of the last outputs of P";
    const SIZE: &str = "a number above 0, the size of the perturbation";
    let size = reader.optional_number(data, "size", SIZE, |v| v > 0.0)?.unwrap_or(1.0);
    let Some(value) = find(data, "performance") else { return Ok(None) };
    match pair(value, 1.0) {
        Some((w, z)) => Ok(Some((w as usize, z as usize, size))),
        None => Err(reader.wrong("performance", format!("is {}; {ALLOWED}", value.describe()))),
    }
}

/// `[[-r, 0], [r, 0], [p, q], ..]`.
fn structure(reader: &Reader, data: &Entries) -> Result<Structure, Error> {
    const ALLOWED: &str = "it must be a list of pairs of whole numbers: [-r, 0] for a real scalar repeated r \
        times, [r, 0] for a complex one, [p, q] for a full complex block, none larger than 1000";
    let value = find(data, "blocks").ok_or_else(|| reader.wrong("blocks", "is missing".into()))?;
    let Json::List(list) = value else {
        return Err(reader.wrong("blocks", format!("is {}; {ALLOWED}", value.describe())));
    };
    let mut notation = Vec::with_capacity(list.len());
    for (i, entry) in list.iter().enumerate() {
        notation.push(pair(entry, -LARGEST_BLOCK).ok_or_else(|| {
            let found = if matches!(entry, Json::List(_)) { "no such pair".into() } else { entry.describe() };
            reader.wrong("blocks", format!("has {found} in place {}; {ALLOWED}", i + 1))
        })?);
    }
    Structure::from_notation(&notation).map_err(|e| reader.wrong("blocks", format!("is wrong: {e}")))
}

fn complex_matrix(reader: &Reader, value: &Json) -> Result<CMat, Error> {
    const ENTRIES: &str = "[re, im] pairs or of numbers";
    let rows = reader.rows("M", value, ENTRIES, |entry, place| complex(reader, entry, place))?;
    let width = rows.first().map_or(0, Vec::len);
    if width == 0 {
        return Err(reader.wrong("M", format!("is empty; it must be a list of rows of {ENTRIES}")));
    }
    if rows.iter().any(|row| row.len() != width) {
        return Err(reader.ragged("M", width));
    }
    Ok(CMat::from_fn(rows.len(), width, |i, j| rows[i][j]))
}

fn complex(reader: &Reader, entry: &Json, place: (usize, usize)) -> Result<Complex<f64>, Error> {
    match entry {
        Json::List(pair) if pair.len() == 2 => {
            Ok(Complex::new(reader.number("M", &pair[0], place)?, reader.number("M", &pair[1], place)?))
        }
        Json::List(list) => {
            let (row, column) = place;
            let words = format!(
                "has a list of {} in row {row}, column {column}; an entry is a number or [re, im]",
                list.len()
            );
            Err(reader.wrong("M", words))
        }
        plain => Ok(Complex::new(reader.number("M", plain, place)?, 0.0)),
    }
}

/// A system of A, B, C and D.
pub fn system(reader: &Reader, entries: &Entries) -> Result<StateSpace, Error> {
    let m = Matrices { reader, entries };
    let a = m.get("A", Size::own())?;
    let n = a.nrows();
    let d = m.get("D", Size::own())?;
    let (outputs, inputs) = d.shape();
    let b = m.get("B", Size { rows: n, columns: inputs, required: n > 0 })?;
    let c = m.get("C", Size { rows: outputs, columns: n, required: n > 0 })?;
    let expected = [("A", &a, (n, n)), ("B", &b, (n, inputs)), ("C", &c, (outputs, n))];
    for (key, matrix, (rows, columns)) in expected {
        if matrix.shape() != (rows, columns) {
            let (found_rows, found_columns) = matrix.shape();
            let words = format!(
                "is {found_rows} x {found_columns}; with the other matrices it must be {rows} x {columns}"
            );
            return Err(reader.wrong(key, words));
        }
    }
    Ok(StateSpace { a, b, c, d })
}

fn fits(
    reader: &Reader,
    perturbed: &Perturbed,
    structure: &Structure,
    (w, z): (usize, usize),
) -> Result<(), Error> {
    let (key, found) = match perturbed {
        Perturbed::Matrix(m) => ("M", m.shape()),
        Perturbed::System(p) | Perturbed::Performing(p, _) => ("D", p.d.shape()),
    };
    let (rows, columns) = (structure.cols() + z, structure.rows() + w);
    if found == (rows, columns) {
        return Ok(());
    }
    let words = format!("is {} x {}; for these blocks it must be {rows} x {columns}", found.0, found.1);
    Err(reader.wrong(key, words))
}
