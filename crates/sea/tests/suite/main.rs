//! The sea against published figures, other programs and the laws of linear theory.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod current;
mod sensor;
mod shaping;
mod spectrum;
mod spheroid;
mod waves;
