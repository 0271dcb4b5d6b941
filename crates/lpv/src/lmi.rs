//! Linear matrix inequalities: expressions ([`program`]) and their solution ([`solver`]).

pub mod affine;
mod conic;
pub(crate) mod interior_point;
pub(crate) mod low_rank;
pub mod program;
pub mod solver;
pub mod solver_options;
pub(crate) mod traces;

pub(crate) use affine::Term;
pub(crate) use conic::{ConicProgram, Verdict, WAYS};
pub(crate) use interior_point::minimise;
pub(crate) use low_rank::LowRank;
pub use program::{Affine, Program, symmetric};
pub(crate) use solver::Candidate;
pub use solver::Solution;
pub use solver_options::SolverOptions;

/// Silences panics of Clarabel, which occur if a decomposition does not converge; they are caught and another method is
/// tried. All other panics are defects and are printed.
pub fn keep_caught_panics_quiet() {
    let print = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        if !info.location().is_some_and(|l| l.file().contains("clarabel")) {
            print(info);
        }
    }));
}
