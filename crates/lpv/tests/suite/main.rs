//! Synthesis and analysis of plants with published or known answers.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod anti_windup;
mod bounded_rate;
mod common;
mod coordinates;
mod direct_path;
mod fast_modes;
mod ladder;
mod lft;
mod published;
mod rate;
mod reduce;
mod regularise;
mod sampled_gain;
mod structured;
