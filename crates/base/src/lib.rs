//! What every crate above needs: files, progress of long work, numbers for people.

pub mod files;
pub mod numbers;
pub mod progress;
