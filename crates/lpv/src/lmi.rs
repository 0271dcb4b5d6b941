//! Linear matrix inequalities: as expressions ([`program`]), and solved ([`solver`]).

pub mod affine;
mod conic;
pub(crate) mod interior_point;
pub(crate) mod low_rank;
pub mod program;
pub mod solver;
pub mod solver_options;

/// Clarabel panics where a decomposition does not converge; the panic is caught and another method is tried, so its
/// message is not printed. All other panics are defects and print theirs.
pub fn keep_caught_panics_quiet() {
    let print = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        if !info.location().is_some_and(|l| l.file().contains("clarabel")) {
            print(info);
        }
    }));
}
