//! Linear parameter-varying control by linear matrix inequalities.
pub mod analysis;
pub mod balance;
mod bounded_real;
pub mod controller;
pub mod error;
pub mod lft;
pub mod lmi;
pub mod matrix;
pub mod modes;
pub mod plant;
pub mod polynomial;
pub mod reconstruct;
pub mod solver;
pub mod state_space;
pub mod synthesis;
pub mod tracking;
