//! Packs a finished design: three FMUs, and plant and controller wired up as an SSP.
//!
//! ```text
//! stored design, report, shared libraries -> fmu::pack -> *.fmu -> ssp::pack -> *.ssp
//! *.fmu -> verify
//! ```

pub mod archive;
pub mod error;
pub mod fmu;
pub mod kind;
pub mod platform;
pub mod ssp;
mod terminals;
pub mod verify;
mod xml;
