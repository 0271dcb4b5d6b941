//! Checks of numbers in a design.

use std::fmt;

use crate::DesignError;

#[inline]
pub(crate) fn finite(key: fmt::Arguments<'_>, value: f64) -> Result<(), DesignError> {
    if value.is_finite() {
        return Ok(());
    }
    Err(DesignError::BadNumber { key: key.to_string(), value, allowed: "finite" })
}

#[inline]
pub(crate) fn positive(key: fmt::Arguments<'_>, value: f64) -> Result<(), DesignError> {
    if value.is_finite() && value > 0.0 {
        return Ok(());
    }
    Err(DesignError::BadNumber { key: key.to_string(), value, allowed: "finite and above 0" })
}

#[inline]
pub(crate) fn not_negative(key: fmt::Arguments<'_>, value: f64) -> Result<(), DesignError> {
    if value.is_finite() && value >= 0.0 {
        return Ok(());
    }
    Err(DesignError::BadNumber { key: key.to_string(), value, allowed: "finite and at least 0" })
}

#[inline]
pub(crate) fn range(key: fmt::Arguments<'_>, minimum: f64, maximum: f64) -> Result<(), DesignError> {
    finite(format_args!("{key}.minimum"), minimum)?;
    finite(format_args!("{key}.maximum"), maximum)?;
    if minimum < maximum {
        return Ok(());
    }
    Err(DesignError::EmptyRange { key: key.to_string(), minimum, maximum })
}
