//! Sections of the report, one file each, and shared computations.

pub(crate) mod disturbances;
pub(crate) mod envelope;
pub(crate) mod fit;
pub(crate) mod flown;
pub mod frozen_loop;
pub(crate) mod gammas;
pub(crate) mod loops;
pub(crate) mod manoeuvre;
pub(crate) mod mu;
pub(crate) mod robust;
pub mod sensitivity;
pub(crate) mod steps;
pub(crate) mod structure;
pub(crate) mod theorem;
pub(crate) mod verdict;
