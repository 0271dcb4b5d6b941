//! Checks exactly that X and S are symmetric, T is skew, and S and T commute with Theta.

use crate::certificate::Rows;
use crate::error::{Claim, Failure, Proved};

/// `m = m'`.
pub(crate) fn symmetric(claim: Claim, matrix: Proved, m: &Rows) -> Result<(), Failure> {
    mirrored(claim, matrix, m, "symmetric", |entry, mirror| entry == mirror)
}

/// `m = -m'`.
pub(crate) fn skew(claim: Claim, matrix: Proved, m: &Rows) -> Result<(), Failure> {
    mirrored(claim, matrix, m, "skew", |entry, mirror| entry == -mirror)
}

fn mirrored(
    claim: Claim,
    matrix: Proved,
    m: &Rows,
    property: &'static str,
    holds: impl Fn(f64, f64) -> bool,
) -> Result<(), Failure> {
    for (row, entries) in m.iter().enumerate() {
        for (column, &entry) in entries.iter().enumerate().take(row + 1) {
            let mirror = m[column][row];
            if !holds(entry, mirror) {
                return Err(Failure::NotMirrored { claim, matrix, property, row, column, entry, mirror });
            }
        }
    }
    Ok(())
}

/// `m Theta = Theta m` for every Theta: zero wherever row and column belong to different parameters.
pub(crate) fn commuting(claim: Claim, matrix: Proved, m: &Rows, parameters: &[usize]) -> Result<(), Failure> {
    for (row, &row_parameter) in parameters.iter().enumerate() {
        for (column, &column_parameter) in parameters.iter().enumerate() {
            let entry = m[row][column];
            if row_parameter != column_parameter && entry != 0.0 {
                return Err(Failure::NotCommuting {
                    claim,
                    matrix,
                    row,
                    column,
                    entry,
                    row_parameter,
                    column_parameter,
                });
            }
        }
    }
    Ok(())
}
