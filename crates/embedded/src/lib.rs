//! A frozen controller as C99, for the computer of a vehicle:
//!
//! ```text
//! frozen design -> export -> NAME.h, NAME.c        source and design -> compare
//! those of several axes -> together -> NAME.h, NAME.c
//! ```
//!
//! The source has the numbers of [`squid_scheduled::Autopilot`] and does its operations in its order, so that the results are
//! the same to the last bit. `template/` has what is the same for every design.

mod compare;
mod error;
mod failsafe;
mod follow;
mod governor;
mod header;
mod inputs;
mod library;
mod real;
mod references;
mod source;
mod tables;
mod template;
mod whole;

pub use compare::compare;
pub use error::{ExportError, SourceError};
pub use header::Standing;
pub use real::Real;
pub use whole::together;

use crate::header::header;
use crate::source::source;
use crate::tables::Tables;
use squid_scheduled::{ControllerDesign, DEFAULT_DESIGN};

/// The two files, in memory.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Source {
    /// What their names and those of all their functions begin with.
    pub name: String,
    /// `NAME.h`.
    pub header: String,
    /// `NAME.c`.
    pub source: String,
}

/// Writes a frozen design as C99 with numbers of a type.
///
/// # Errors
/// [`ExportError`].
pub fn export(design: &ControllerDesign, standing: &Standing, real: Real) -> Result<Source, ExportError> {
    let tables = Tables::of(design, real)?;
    // Those of several designs can be linked together.
    let of_design = if design.design == DEFAULT_DESIGN { "" } else { design.design.as_str() };
    let name = squid_model_description::identifier(&format!("{} {of_design}", design.vehicle.name));
    let fields = template::fields(&name, design, real);
    Ok(Source {
        header: header(design, &tables, standing, &fields)?,
        source: source(design, &tables, &fields),
        name,
    })
}
