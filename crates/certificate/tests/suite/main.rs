//! Certificates checked by hand and golden ones: proofs, rejections and messages.
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
