//! Random calls, resource files and states through the C ABI of each FMU.
#![allow(unsafe_code, clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

#[path = "../abi/mod.rs"]
mod abi;
mod calls;
#[path = "../example/mod.rs"]
mod example;
mod fuzz;
mod resources;
mod states;
