//! The sections of the report, a file each, and what several of them compute.

pub mod disturbances;
pub mod fit;
pub mod flown;
mod frozen_loop;
pub mod gammas;
pub mod loops;
pub mod manoeuvre;
pub mod mu;
pub mod paper;
pub mod robust;
pub mod sensitivity;
pub mod steps;
pub mod structure;
pub mod theorem;
pub mod verdict;
