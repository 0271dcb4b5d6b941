//! The structured singular value mu: the size of a structured perturbation that a loop tolerates.
//!
//! ```text
//! mu(M) = 1 / min { |Delta| : det(I - M Delta) = 0, Delta of the structure }
//! ```
//!
//! J. C. Doyle, "Analysis of feedback systems with structured uncertainties", IEE Proc. D 129(6), 1982; with real
//! blocks M. K. H. Fan, A. L. Tits, J. C. Doyle, "Robustness in the presence of mixed parametric uncertainty and
//! unmodeled dynamics", IEEE Trans. Automatic Control 36(1), 1991.
//!
//! - [`structure`]: the structure of a perturbation;
//! - [`upper`]: the bound by D-G scalings, with the scalings that prove it;
//! - [`lower`], [`margin`]: destabilising perturbations;
//! - [`over_frequency`], [`sweep`], [`interval`]: bounds for all frequencies;
//! - [`worst_case`]: the largest gain at a given size of the perturbation;
//! - [`mod@synthesis`]: controllers by D-K iteration.

mod components;
mod coordinates;
pub mod interval;
pub mod lower;
pub mod margin;
pub mod over_frequency;
mod peaks;
mod perturbable;
pub mod structure;
pub mod sweep;
pub mod synthesis;
pub mod upper;
mod wide;
pub mod worst_case;
pub mod worst_perturbation;

pub use structure::{Block, Structure, StructureError};

use nalgebra::{Complex, DMatrix};

/// A complex matrix of any size.
pub type CMat = DMatrix<Complex<f64>>;
