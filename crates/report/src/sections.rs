//! The sections of the report, a file each, and what several of them compute.

mod alternation;
pub mod effort;
pub mod fit;
pub mod flown;
pub mod frozen_loop;
pub mod gammas;
pub mod manoeuvre;
pub mod mu;
pub mod open_loop;
pub mod robust;
pub mod sensitivity;
mod switched;
pub mod switching;
pub mod theorem;
pub mod tuning;
