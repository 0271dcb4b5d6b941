//! The command `squid`: one file for each verb, and the printed output.

pub mod cli;
pub mod error;
pub mod output;
pub mod progress;
pub mod verbs;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
