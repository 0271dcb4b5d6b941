//! PID cascades: what is read, what is refused, and the controller that follows.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod autopilots;
mod refused;
mod structure;
mod vehicles;
