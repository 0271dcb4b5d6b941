//! Simulation of a vehicle over time.

pub(crate) mod current;
pub(crate) mod error;
mod flow;
mod frozen;
pub(crate) mod integrator;
pub(crate) mod load;
pub(crate) mod lpv_model;
pub(crate) mod plant;
pub(crate) mod rates;
pub(crate) mod regular_waves;
pub(crate) mod slopes;
pub(crate) mod snapshot;
pub(crate) mod surroundings;
pub(crate) mod water;
mod whole;
