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
//! `dt`, next to P, is the sample time \[s\] of a discrete-time system, with `x+` for `x'`; mu is over the unit circle,
//! `z = exp(j omega dt)`.
//!
//! An entry of M is a pair of numbers, or a plain number if it is real. Duplicate and unknown keys are errors, except
//! for comments (see `problem_file`).

use crate::discrete::POLES_AT_BOTH_ENDS;
use crate::error::Error;
use crate::object::{Entry, Matrix, System, checked, object};
use crate::problem_file::sample_time;
use crate::source::Source;
use nalgebra::Complex;
use serde::Deserialize;
use squid_lpv::bilinear::Bilinear;
use squid_lpv::mu::{CMat, Structure};
use squid_lpv::state_space::StateSpace;

/// Perturbed matrix or system: `z = M w`, `w = Delta z`.
#[derive(Debug, Clone, PartialEq)]
pub enum Perturbed {
    /// A constant matrix.
    Matrix(CMat),
    /// A system, at all frequencies.
    System(StateSpace),
    /// A system whose last inputs and outputs are performance channels, and the size of the perturbations.
    WithPerformance(StateSpace, f64),
}

/// Largest number of rows, columns or repetitions; larger numbers are refused as mistakes.
const LARGEST_BLOCK: f64 = 1000.0;

/// Problem of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct MuProblem {
    /// Perturbed matrix or system, in continuous time.
    pub perturbed: Perturbed,
    /// Structure of the perturbation.
    pub structure: Structure,
    /// Bilinear transform of a discrete-time system.
    pub discrete: Option<Bilinear>,
}

object! {
    file
    /// Content of `data`, or of the file.
    Data {
        "M" m: Matrix<Number>, "P" p: System, "blocks" blocks: Vec<[f64; 2]>, "performance" performance: [f64; 2],
        "size" size: f64, "dt" dt: f64;
    }
}

/// Entry of M.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(
    untagged,
    expecting = "must be a finite number or a pair [re, im] of finite numbers, each of at most 1e100 in magnitude"
)]
pub enum Number {
    /// Real number.
    Real(Entry),
    /// Complex number `[re, im]`.
    Complex(Entry, Entry),
}

impl Number {
    fn value(self) -> Complex<f64> {
        match self {
            Self::Real(re) => Complex::new(re.0, 0.0),
            Self::Complex(re, im) => Complex::new(re.0, im.0),
        }
    }
}

/// Reads a problem file.
///
/// # Errors
/// [`Error::Problem`] with file and key, also if the blocks do not match the matrix or system.
pub fn mu_problem(source: &Source) -> Result<MuProblem, Error> {
    let mut data = Data::read(source)?;
    let perturbed = match (data.m.take(), data.p.take()) {
        (Some(_), Some(_)) => {
            return Err(source.wrong("M", "and 'P' are both given; give a matrix M or a system P"));
        }
        (Some(m), None) => Perturbed::Matrix(complex_matrix(source, &m.0)?),
        (None, Some(p)) => Perturbed::System(p.state_space(source)?),
        (None, None) => {
            let text = "is missing; a problem has a matrix M, or a system P with A, B, C and D";
            return Err(source.wrong("M", text));
        }
    };
    let structure = structure(source, &data)?;
    let performance = performance(source, &data)?;
    let sample_time = sample_time(source, data.dt)?;
    let (w, z) = performance.map_or((0, 0), |(w, z, _)| (w, z));
    let (rows, columns) = (structure.cols() + z, structure.rows() + w);
    let check = |key: &str, found: (usize, usize)| {
        let text = format!("is {} x {}; for these blocks it must be {rows} x {columns}", found.0, found.1);
        if found == (rows, columns) { Ok(()) } else { Err(source.wrong(key, text)) }
    };
    let mut discrete = None;
    let perturbed = match perturbed {
        Perturbed::System(mut system) => {
            check("D", system.d.shape())?;
            if let Some(time) = sample_time {
                let (transform, continuous) = in_continuous_time(source, &system, time)?;
                (system, discrete) = (continuous, Some(transform));
            }
            match performance {
                Some((_, _, size)) => Perturbed::WithPerformance(system, size),
                None => Perturbed::System(system),
            }
        }
        other => {
            let beside = [("performance", performance.is_some()), ("dt", sample_time.is_some())];
            if let Some((key, _)) = beside.into_iter().find(|(_, is_given)| *is_given) {
                return Err(source.wrong(key, "requires a system 'P'; it has no meaning for a matrix 'M'"));
            }
            if let Perturbed::Matrix(m) = &other {
                check("M", m.shape())?;
            }
            other
        }
    };
    Ok(MuProblem { perturbed, structure, discrete })
}

/// Transforms a discrete-time system to continuous time, with the same mu.
fn in_continuous_time(
    source: &Source,
    system: &StateSpace,
    sample_time: f64,
) -> Result<(Bilinear, StateSpace), Error> {
    let radius = system.poles().iter().map(|pole| pole.norm()).fold(0.0, f64::max);
    if radius >= 1.0 {
        let text = format!(
            "has an eigenvalue of modulus {radius}: the discrete-time loop is unstable without any perturbation"
        );
        return Err(source.wrong("A", text));
    }
    let transform = Bilinear::of(&system.a, sample_time);
    let found = transform.and_then(|transform| Some((transform, transform.continuous(system)?)));
    found.ok_or_else(|| source.wrong("A", POLES_AT_BOTH_ENDS))
}

/// Converts a pair of integers from `least` to [`LARGEST_BLOCK`]; `None` for other numbers.
fn pair(pair: [f64; 2], least: f64) -> Option<(i64, i64)> {
    let is_whole = |v: &f64| v.fract() == 0.0 && (least..=LARGEST_BLOCK).contains(v);
    pair.iter().all(is_whole).then_some((pair[0] as i64, pair[1] as i64))
}

/// Returns the numbers of inputs w and outputs z, and the size of the perturbations.
fn performance(source: &Source, data: &Data) -> Result<Option<(usize, usize, f64)>, Error> {
    const ALLOWED: &str =
        "it must be two integers from 1 to 1000, the numbers of inputs w and outputs z (last in P)";
    const SIZE: &str = "a number above 0, the size of the perturbation";
    let size = checked(source, "size", data.size, SIZE, |v| v > 0.0)?;
    let Some(given) = data.performance else {
        let alone =
            "requires 'performance', because it is the size of the perturbation for the worst-case gain";
        return if size.is_some() { Err(source.wrong("size", alone)) } else { Ok(None) };
    };
    match pair(given, 1.0) {
        Some((w, z)) => Ok(Some((w as usize, z as usize, size.unwrap_or(1.0)))),
        None => Err(source.wrong("performance", format!("is {given:?}; {ALLOWED}"))),
    }
}

/// Returns the structure from `[[-r, 0], [r, 0], [p, q], ..]`.
fn structure(source: &Source, data: &Data) -> Result<Structure, Error> {
    const ALLOWED: &str = "every entry must be a pair of integers of at most 1000: [-r, 0] for a real scalar \
        repeated r times, [r, 0] for a complex one, [p, q] for a full complex block";
    let list = data.blocks.as_ref().ok_or_else(|| source.wrong("blocks", "is missing"))?;
    let whole = |(i, found): (usize, &[f64; 2])| {
        let wrong =
            || source.wrong("blocks", format!("has the entry {found:?} (number {}); {ALLOWED}", i + 1));
        pair(*found, -LARGEST_BLOCK).ok_or_else(wrong)
    };
    let notation = list.iter().enumerate().map(whole).collect::<Result<Vec<_>, _>>()?;
    Structure::from_notation(&notation).map_err(|e| source.wrong("blocks", format!("is invalid: {e}")))
}

fn complex_matrix(source: &Source, rows: &[Vec<Number>]) -> Result<CMat, Error> {
    let width = rows.first().map_or(0, Vec::len);
    if width == 0 {
        return Err(source.wrong("M", "is empty; it must be a list of rows of [re, im] pairs or of numbers"));
    }
    Ok(CMat::from_fn(rows.len(), width, |i, j| rows[i][j].value()))
}
