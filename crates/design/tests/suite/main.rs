//! Designs of the shipped vehicles: what is read, proved, checked, stored and judged of them.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod ball;
mod design_file;
mod designs;
mod flown;
mod same_plant;
mod sampled;
mod stored;
mod uncertain;
mod verdict;
