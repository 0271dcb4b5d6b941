//! Problem files of `squid lpv mu`: a matrix or a system, and the structure of its perturbation.
//!
//! ```json
//! {"kind": "mu", "data": {"M": [[[re, im], ..], ..], "blocks": [[-r, 0], [r, 0], [p, q], ..]}}
//! {"kind": "mu", "data": {"P": {"A": [[..]], "B": .., "C": .., "D": ..}, "blocks": ..}}
//! {"kind": "mu", "data": {"P": .., "blocks": .., "performance": [p, q], "size": 1}}
//! ```
//!
//! With `performance` the last p inputs of P are w and its last q outputs z; robust performance and the worst-case gain
//! are from w to z. `size` is the size of the perturbations for the worst-case gain, 1 by default.
//!
//! `dt`, next to P, is the sample time (s) of a system in discrete time, with `x+` for `x'`; mu is over the unit
//! circle, `z = exp(j omega dt)`.
//!
//! An entry of M is a pair of numbers, or a plain number if it is real. No key may occur twice. Other keys are not
//! allowed, except for comments (see `problem_file`).

use crate::discrete::POLES_AT_BOTH_ENDS;
use crate::error::Error;
use crate::matrices::{Entries, Matrices, NOTES, Reader, Size, find};
use crate::problem_file::sample_time;
use crate::source::Source;
use certificate::Json;
use lpv::bilinear::Bilinear;
use lpv::mu::{CMat, Structure};
use lpv::state_space::StateSpace;
use nalgebra::Complex;

/// The perturbed matrix or system: `z = M w`, `w = Delta z`.
#[derive(Debug, Clone, PartialEq)]
pub enum Perturbed {
    /// A constant matrix.
    Matrix(CMat),
    /// A system, at all frequencies.
    System(StateSpace),
    /// A system whose last inputs and outputs are performance channels, and the size of the perturbations.
    WithPerformance(StateSpace, f64),
}

/// Largest number of rows, columns or repetitions; more are taken for a mistake.
const LARGEST_BLOCK: f64 = 1000.0;

/// The problem of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct MuProblem {
    /// The perturbed matrix or system, in continuous time.
    pub perturbed: Perturbed,
    /// The structure of the perturbation.
    pub structure: Structure,
    /// The bilinear transform of a discrete-time system.
    pub discrete: Option<Bilinear>,
}

/// Reads a problem file.
///
/// # Errors
/// [`Error::Problem`] with file and key, also if the blocks do not fit.
pub fn mu_problem(source: &Source) -> Result<MuProblem, Error> {
    const KEYS: [&str; 6] = ["M", "P", "blocks", "performance", "size", "dt"];
    let (reader, value) = Reader::open(source)?;
    let data = reader.data(&value)?;
    reader.only_notes_beside_data(&value, (&KEYS, "in 'data'"))?;
    reader.only(data, "in 'data'", &[&KEYS[..], &NOTES].concat(), (&[], ""))?;
    let mut perturbed = match (find(data, "M"), find(data, "P")) {
        (Some(_), Some(_)) => {
            return Err(reader.wrong("M", "and 'P' are both given; give a matrix M or a system P".into()));
        }
        (Some(m), None) => Perturbed::Matrix(complex_matrix(&reader, m)?),
        (None, Some(p)) => Perturbed::System(system(&reader, reader.object(p, "P")?, "P")?),
        (None, None) => {
            let words = "is missing; a problem has a matrix M, or a system P with A, B, C and D";
            return Err(reader.wrong("M", words.into()));
        }
    };
    let structure = structure(&reader, data)?;
    let performance = performance(&reader, data)?;
    let sample_time = sample_time(&reader, data)?;
    if matches!(perturbed, Perturbed::Matrix(_)) {
        let beside = [("performance", performance.is_some()), ("dt", sample_time.is_some())];
        if let Some((key, _)) = beside.into_iter().find(|(_, is_given)| *is_given) {
            return Err(reader.wrong(key, "goes with a system P, not with a matrix M".into()));
        }
    }
    let (w, z) = performance.map_or((0, 0), |(w, z, _)| (w, z));
    check_shape(&reader, &perturbed, &structure, w, z)?;
    let mut discrete = None;
    if let (Perturbed::System(system), Some(time)) = (&mut perturbed, sample_time) {
        let (transform, continuous) = in_continuous_time(&reader, system, time)?;
        (*system, discrete) = (continuous, Some(transform));
    }
    let perturbed = match (perturbed, performance) {
        (Perturbed::System(system), Some((_, _, size))) => Perturbed::WithPerformance(system, size),
        (perturbed, _) => perturbed,
    };
    Ok(MuProblem { perturbed, structure, discrete })
}

/// A discrete-time system in continuous time, with the same mu.
fn in_continuous_time(
    reader: &Reader,
    system: &StateSpace,
    sample_time: f64,
) -> Result<(Bilinear, StateSpace), Error> {
    let radius = system.poles().iter().map(|pole| pole.norm()).fold(0.0, f64::max);
    if radius >= 1.0 {
        let words = format!(
            "has an eigenvalue of modulus {radius}; in discrete time the loop is unstable without any perturbation"
        );
        return Err(reader.wrong("A", words));
    }
    let transform = Bilinear::of(&system.a, sample_time);
    let found = transform.and_then(|transform| Some((transform, transform.continuous(system)?)));
    found.ok_or_else(|| reader.wrong("A", POLES_AT_BOTH_ENDS.into()))
}

/// A pair of integers from `least` to [`LARGEST_BLOCK`].
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

/// The numbers of inputs w and outputs z, and the size of the perturbations.
fn performance(reader: &Reader, data: &Entries) -> Result<Option<(usize, usize, f64)>, Error> {
    const ALLOWED: &str =
        "it must be a pair of whole numbers from 1 to 1000: of the last inputs and of the last outputs of P";
    const SIZE: &str = "a number above 0, the size of the perturbation";
    let size = reader.optional_number(data, "size", SIZE, |v| v > 0.0)?.unwrap_or(1.0);
    let Some(value) = find(data, "performance") else {
        let alone =
            "is given without 'performance'; it is the size of the perturbation for the worst-case gain";
        return if find(data, "size").is_some() { Err(reader.wrong("size", alone.into())) } else { Ok(None) };
    };
    match pair(value, 1.0) {
        Some((w, z)) => Ok(Some((w as usize, z as usize, size))),
        None => Err(reader.wrong("performance", format!("is {}; {ALLOWED}", value.describe()))),
    }
}

/// The structure from `[[-r, 0], [r, 0], [p, q], ..]`.
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

/// The system with A, B, C and D under a key.
pub fn system(reader: &Reader, entries: &Entries, key: &str) -> Result<StateSpace, Error> {
    reader.only(entries, &format!("in '{key}'"), &["A", "B", "C", "D"], (&[], ""))?;
    let m = Matrices { reader, entries };
    let a = m.get("A", Size::of_entries())?;
    let n = a.nrows();
    let d = m.get("D", Size::of_entries())?;
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

/// Checks the shape of the matrix or of D for `w` performance inputs and `z` performance outputs.
fn check_shape(
    reader: &Reader,
    perturbed: &Perturbed,
    structure: &Structure,
    w: usize,
    z: usize,
) -> Result<(), Error> {
    let (key, found) = match perturbed {
        Perturbed::Matrix(m) => ("M", m.shape()),
        Perturbed::System(p) | Perturbed::WithPerformance(p, _) => ("D", p.d.shape()),
    };
    let (rows, columns) = (structure.cols() + z, structure.rows() + w);
    if found == (rows, columns) {
        return Ok(());
    }
    let words = format!("is {} x {}; for these blocks it must be {rows} x {columns}", found.0, found.1);
    Err(reader.wrong(key, words))
}
