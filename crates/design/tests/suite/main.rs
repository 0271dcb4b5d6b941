//! Designs of the shipped vehicles: what is proved, checked, stored and judged of them.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod ball;
mod designs;
mod flown;
mod sampled;
mod stored;
mod uncertain;
mod verdict;
