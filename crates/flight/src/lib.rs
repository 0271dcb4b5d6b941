//! Closed-loop simulation of a vehicle with its autopilot, and the metrics of a flight.

pub mod error;
pub mod flight;
mod held_trim;
pub mod metrics;
pub mod record;
pub mod sea;
mod sea_file;
mod surfacing;
mod ticks;
pub mod whole;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
