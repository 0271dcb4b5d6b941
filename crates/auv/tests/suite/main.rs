//! All tests except those that count allocations, in one program: each program is compiled and linked separately.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

#[path = "../common/mod.rs"]
mod common;
mod descriptor;
mod dynamics;
mod given_speed;
mod hull;
mod load;
mod lpv_model;
mod non_dimensional;
mod properties;
mod published_figures;
mod rate_limit;
mod simulation;
mod six_dof;
mod trim;
mod vehicle_file;
mod vehicle_json;
mod water;
