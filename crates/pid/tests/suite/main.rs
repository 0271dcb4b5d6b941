//! PID cascades: files, errors, and the resulting controller.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod autopilots;
mod refused;
mod structure;
mod vehicles;
