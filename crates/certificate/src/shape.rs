//! Checks of sizes and numbers.

use crate::error::Failure;
use crate::plant::Rows;

/// Number of rows or columns, and the name of their signal.
pub(crate) type Size = (usize, &'static str);

/// Sizes of the partition of a loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Sizes {
    /// Number of states of the plant.
    pub(crate) x: usize,
    /// Number of states of the controller.
    pub(crate) xk: usize,
    /// Number of channels of the plant.
    pub(crate) t: usize,
    /// Number of channels of the controller.
    pub(crate) tk: usize,
    /// Number of inputs w.
    pub(crate) w: usize,
    /// Number of outputs z.
    pub(crate) z: usize,
    /// Number of controls u.
    pub(crate) u: usize,
    /// Number of measurements y.
    pub(crate) y: usize,
}

impl Sizes {
    /// Returns the number of states of plant and controller.
    pub(crate) fn states(self) -> Size {
        (self.x + self.xk, "states of plant and controller")
    }

    /// Returns the number of channels of plant and controller.
    pub(crate) fn channels(self) -> Size {
        (self.t + self.tk, "channels of plant and controller")
    }

    /// Returns the number of controls.
    pub(crate) fn controls(self) -> Size {
        (self.u, "controls u")
    }
}

/// Returns the number of columns; 0 without rows.
pub(crate) fn columns(rows: &Rows) -> usize {
    rows.first().map_or(0, Vec::len)
}

pub(crate) fn at_least_one(field: &str, part: &str, (found, meaning): Size) -> Result<(), Failure> {
    if found > 0 {
        return Ok(());
    }
    Err(Failure::malformed(field, format_args!("has no {part}; it must have at least one ({meaning})")))
}

pub(crate) fn check_number(field: &str, x: f64) -> Result<(), Failure> {
    if x.is_finite() { Ok(()) } else { Err(Failure::found(field, x, "a finite number")) }
}

pub(crate) fn check_length(
    field: &str,
    found: usize,
    is_allowed: bool,
    allowed: &str,
) -> Result<(), Failure> {
    if is_allowed {
        return Ok(());
    }
    Err(Failure::malformed(field, format_args!("number of entries is {found}; it must be {allowed}")))
}

pub(crate) fn check_list(field: &str, list: &[f64], (size, meaning): Size) -> Result<(), Failure> {
    check_length(field, list.len(), list.len() == size, &format!("{size} ({meaning})"))?;
    list.iter().enumerate().try_for_each(|(i, x)| check_number(&format!("{field}[{i}]"), *x))
}

pub(crate) fn check_matrix(field: &str, m: &Rows, rows: Size, cols: Size) -> Result<(), Failure> {
    let malformed = |found: String, (expected, meaning): Size| {
        Err(Failure::malformed(field, format_args!("{found}; it must be {expected} ({meaning})")))
    };
    if m.len() != rows.0 {
        return malformed(format!("number of rows is {}", m.len()), rows);
    }
    for (i, row) in m.iter().enumerate() {
        if row.len() != cols.0 {
            return malformed(format!("length of row {i} is {}", row.len()), cols);
        }
        row.iter().enumerate().try_for_each(|(j, &x)| check_number(&format!("{field}[{i}][{j}]"), x))?;
    }
    Ok(())
}
