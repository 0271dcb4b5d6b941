//! The command `squid`: one file for each verb, and the printed output.

pub mod cli;
pub mod design;
pub mod error;
pub mod lpv;
pub mod output;
pub mod package;
pub mod plot;
pub mod progress;
pub mod report;
pub mod show;
pub mod simulate;
pub mod verify;
