//! Closed-loop simulation of a vehicle with its autopilot, and the metrics of a flight.

pub mod error;
pub mod flight;
pub mod metrics;
pub mod record;
pub mod sea;
mod sea_file;
pub mod whole;
