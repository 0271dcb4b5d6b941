//! Certificates by hand and golden ones: what proves, what is refused, and in which words.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod bounded_rate;
mod by_hand;
mod common;
mod constant;
mod discrete;
mod factor;
mod golden;
mod independent;
mod limits;
mod rate_alone;
mod reading;
mod tampering;
