//! All tests in one binary, which exports the C functions once.
#![allow(unsafe_code, clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod c_abi;
mod call_order;
#[path = "../example/mod.rs"]
mod example;
#[path = "../example/importer.rs"]
mod importer;
mod legal_calls;
#[path = "../example/standard.rs"]
mod standard;
mod threads;
