//! Linear parameter-varying control by linear matrix inequalities.
pub mod controller;
pub mod error;
pub mod lft;
pub mod lmi;
pub mod matrix;
pub mod plant;
pub mod polynomial;
pub mod solver;
pub mod state_space;
