//! Exact checks of numbers and matrices: positive, symmetric, skew, commuting with Theta, definite.

use crate::error::ClaimName;
use crate::error::Failure;
use crate::exact::definite::positive_definite;
use crate::exact::dyadic::Dyadic;
use crate::exact::matrix::Matrix;
use crate::inequality::Blocked;
use crate::plant::Rows;

/// Checks `found > 0`.
pub(crate) fn positive(claim: ClaimName, name: &str, found: f64) -> Result<(), Failure> {
    if found > 0.0 {
        return Ok(());
    }
    Err(Failure::condition(claim, name, format_args!("{name} is {found:e}; it must be above 0")))
}

/// Checks `m = m'`.
pub(crate) fn symmetric(claim: ClaimName, matrix: &str, m: &Rows) -> Result<(), Failure> {
    mirrored(claim, matrix, m, "symmetric", |entry, mirror| entry == mirror)
}

/// Checks `m = -m'`.
pub(crate) fn skew(claim: ClaimName, matrix: &str, m: &Rows) -> Result<(), Failure> {
    mirrored(claim, matrix, m, "skew", |entry, mirror| entry == -mirror)
}

fn mirrored(
    claim: ClaimName,
    matrix: &str,
    m: &Rows,
    property: &str,
    holds: impl Fn(f64, f64) -> bool,
) -> Result<(), Failure> {
    for (row, entries) in m.iter().enumerate() {
        for (column, &entry) in entries.iter().enumerate().take(row + 1) {
            let mirror = m[column][row];
            if !holds(entry, mirror) {
                let reason = format!(
                    "{matrix} is not {property}: entry [{row}][{column}] is {entry:e}, entry [{column}][{row}] is \
                     {mirror:e}"
                );
                return Err(Failure::Structure { claim, part: matrix.into(), reason });
            }
        }
    }
    Ok(())
}

/// Checks `m Theta = Theta m` for every Theta: entries whose row and column belong to different parameters are 0.
pub(crate) fn commuting(
    claim: ClaimName,
    matrix: &str,
    m: &Rows,
    parameters: &[usize],
) -> Result<(), Failure> {
    for (row, &of_row) in parameters.iter().enumerate() {
        for (column, &of_column) in parameters.iter().enumerate() {
            let entry = m[row][column];
            if of_row != of_column && entry != 0.0 {
                let reason = format!(
                    "{matrix} does not commute with Theta: entry [{row}][{column}] is {entry:e}; it must be 0, \
                     because channel {row} belongs to parameter {of_row} and channel {column} to parameter \
                     {of_column}"
                );
                return Err(Failure::Structure { claim, part: matrix.into(), reason });
            }
        }
    }
    Ok(())
}

/// Sign of a definite matrix.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Sign {
    Positive,
    Negative,
}

impl Sign {
    pub(crate) fn word(self) -> &'static str {
        if self == Self::Positive { "positive" } else { "negative" }
    }
}

/// Checks that a matrix is positive or negative definite.
///
/// The rows are eliminated upwards from the last block, -gamma I: its entries and those of S have few digits, which
/// keeps the minors short.
pub(crate) fn definite(claim: ClaimName, matrix: &str, sign: Sign, blocked: &Blocked) -> Result<(), Failure> {
    let negative = sign == Sign::Negative;
    let m = if negative { &blocked.matrix.negated() } else { &blocked.matrix };
    let order: Vec<usize> = (0..m.rows).rev().collect();
    positive_definite(m, &order).map_err(|wrong| {
        let (block, row_in_block) = blocked.locate(wrong.row);
        let value = wrong.value / blocked.scale.to_f64();
        let pivot = if negative { -value } else { value };
        let found = if wrong.exactly_zero { "exactly 0".into() } else { format!("about {pivot:+.3e}") };
        let reason = format!(
            "{matrix} is not {} definite: the pivot of row {} (row {row_in_block} of block {block}) in its \
             elimination is {found}; it must be {} 0",
            sign.word(),
            wrong.row,
            if negative { "below" } else { "above" }
        );
        Failure::NotDefinite { claim, part: matrix.into(), reason, pivot: Some(pivot) }
    })
}

/// Returns a matrix with a single block.
pub(crate) fn single_block(name: &'static str, m: &Matrix) -> Blocked {
    Blocked { matrix: m.clone(), blocks: vec![(name, m.rows)], scale: Dyadic::from_f64(1.0) }
}
