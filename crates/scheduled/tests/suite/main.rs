//! All tests except those that count allocations, in one program, to compile and link only once.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod autopilot;
mod design;
mod discretisation;
mod envelope;
#[path = "../example/mod.rs"]
mod example;
mod failsafe;
mod follow;
mod governor;
mod law;
mod limits;
mod sensors;
mod supervised;
