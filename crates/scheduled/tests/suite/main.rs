//! All tests but those that count allocations, in one program: each program is compiled and linked anew.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod autopilot;
mod design;
mod discretisation;
#[path = "../example/mod.rs"]
mod example;
mod law;
mod limits;
