//! Linear matrix inequalities: as expressions ([`program`]), and solved ([`solver`]).

pub mod affine;
mod conic;
pub(crate) mod interior_point;
pub(crate) mod low_rank;
pub mod program;
pub mod solver;
pub mod solver_options;
