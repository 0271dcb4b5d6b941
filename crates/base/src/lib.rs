//! Basics for all other crates: files, progress reports, formatted numbers.

pub mod files;
pub mod numbers;
pub mod progress;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
