//! All tests except those that count allocations, in one binary, to save link time.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod ballast;
#[path = "../common/mod.rs"]
mod common;
mod description;
mod embedding;
mod flight;
mod turning;
