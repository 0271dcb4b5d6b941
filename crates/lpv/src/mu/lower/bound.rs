//! A perturbation that makes `I - M Delta` singular, verified.

use crate::matrix::{complex_singular_values, largest_complex_singular_value};
use crate::mu::CMat;
use crate::mu::structure::Structure;
use crate::mu::upper::balance::Balance;
use crate::mu::upper::centre::ZERO_MU;

/// A perturbation that makes `I - M Delta` singular.
#[derive(Debug, Clone, PartialEq)]
pub struct LowerBound {
    /// Lower bound of mu: one over the size of Delta.
    pub value: f64,
    /// The perturbation.
    pub delta: CMat,
    /// The frequency, rad/s, if M is a frequency response.
    pub frequency: Option<f64>,
    /// The least singular value of `I - M Delta`, relative to the largest, at least 1.
    pub residual: f64,
}

/// The residual below which the matrix is taken as singular.
pub const SINGULAR_RESIDUAL: f64 = 1e-12;

/// Verifies a perturbation that makes `I - M Delta` singular; `None` if it does not, or is so large that the rounding
/// of M alone would.
pub fn checked(m: &CMat, structure: &Structure, delta: CMat) -> Option<LowerBound> {
    let n = m.nrows();
    let values = complex_singular_values(&(CMat::identity(n, n) - m * &delta));
    let residual = values.last()? / values.first()?.max(1.0);
    let size = complex_singular_values(&delta).first().copied()?;
    let balanced = Balance::new(std::slice::from_ref(m), structure).matrices;
    let largest = balanced.iter().map(largest_complex_singular_value).fold(0.0, f64::max);
    let is_seen = size > 0.0 && size * largest * ZERO_MU <= 1.0;
    let sound = residual <= SINGULAR_RESIDUAL && structure.holds(&delta) && is_seen;
    sound.then(|| LowerBound { value: 1.0 / size, delta, frequency: None, residual })
}
