//! What every crate above needs of the machine: files, and progress of long work.

pub mod files;
pub mod progress;
