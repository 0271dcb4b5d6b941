//! All tests except those that count allocations, in one binary, to save link time.
#![allow(unsafe_code, clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

#[path = "../abi/mod.rs"]
mod abi;
#[path = "../example/case.rs"]
mod case;
mod crowd;
mod derivatives;
mod description;
#[path = "../example/mod.rs"]
mod example;
mod flight;
mod interpolation;
mod manoeuvre;
mod output_derivatives;
mod random;
mod states;
mod steps;
mod structure;
