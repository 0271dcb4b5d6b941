//! Flights of a vehicle and its autopilot in one loop, and their figures.

pub mod error;
pub mod flight;
pub mod metrics;
pub mod record;
pub mod sea;
mod sea_file;
