//! A frozen controller as C99, for the computer of a vehicle:
//!
//! ```text
//! frozen design -> export -> NAME.h, NAME.c        source and design -> compare
//! sources of several axes -> together -> NAME.h, NAME.c
//! ```
//!
//! The source has the numbers of [`squid_scheduled::Autopilot`] and performs its operations in the same order, so that
//! the results are identical to the last bit. The law is in `c/autopilot.c`, the same for every design; the tables of a
//! design replace its line `#include "tables.h"`, and the name of the autopilot replaces `autopilot`.

mod about;
mod compare;
mod error;
mod header;
mod inputs;
mod numbers;
mod real;
mod tables;
mod text;
mod whole;

pub use about::Standing;
pub use compare::compare;
pub use error::{ExportError, SourceError};
pub use real::Real;
pub use whole::together;

use crate::header::header;
use crate::numbers::Numbers;
use crate::tables::tables;
use crate::text::{library, named, title};
use squid_scheduled::{ControllerDesign, DEFAULT_DESIGN};

/// Header and source of an autopilot, in memory.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Source {
    /// Prefix of the file names and of all functions.
    pub name: String,
    /// `NAME.h`.
    pub header: String,
    /// `NAME.c`.
    pub source: String,
}

/// Writes a frozen design as C99 with numbers of a given type.
///
/// # Errors
/// Returns an [`ExportError`] if the design cannot be written as C.
pub fn export(design: &ControllerDesign, standing: &Standing, real: Real) -> Result<Source, ExportError> {
    let numbers = Numbers::of(design, real)?;
    // The sources of several designs can be linked together.
    let of_design = if design.design == DEFAULT_DESIGN { "" } else { design.design.as_str() };
    let name = squid_model_description::identifier(&format!("{} {of_design}", design.vehicle.name));
    let libraries = library(design, real).map_or("No library function is called.".to_owned(), |one| {
        format!("From the mathematical library it {one}")
    });
    let title = title(design);
    let (types, law) = LAW.split_once(TABLES).unwrap_or((LAW, ""));
    let source = [
        format!(
            "/* {title} {name}.h explains its use.\n * {libraries} Do not edit: `squid verify --c` compares it with \
             the certificate. */\n\n"
        ),
        named(types, &name),
        tables(design, &numbers, &name),
        named(law, &name),
    ];
    let header = header(design, &numbers, standing, &name)?;
    Ok(Source { header, source: source.concat(), name })
}

/// Control law in C, the same for every design.
const LAW: &str = include_str!("c/autopilot.c");

/// Line of the law that the tables of a design replace.
const TABLES: &str = "#include \"tables.h\"\n";

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
