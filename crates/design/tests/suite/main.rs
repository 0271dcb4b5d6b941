//! Designs of the shipped vehicles: reading, proof, checks, storage and verdict.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod ball;
mod design_file;
mod designs;
mod envelope;
mod flown;
mod heading;
mod pid;
mod reduced;
mod same_plant;
mod sampled;
mod stored;
mod uncertain;
mod verdict;
