//! Packs a finished design: three FMUs, plant and controller wired up as an SSP, and the controller as C.
//!
//! ```text
//! stored design, report, shared libraries -> fmu::pack -> *.fmu -> ssp::pack -> *.ssp
//! stored design                           -> c::pack   -> NAME.h, NAME.c
//! *.fmu, NAME.c -> verify
//! ```

pub mod archive;
pub mod axes;
pub mod c;
pub mod contents;
pub mod coupling;
pub mod error;
pub mod fmu;
pub mod kind;
pub mod page;
pub mod platform;
pub mod ssp;
mod terminals;
pub mod verify;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
