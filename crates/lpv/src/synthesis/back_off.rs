//! A point well inside the synthesis inequalities, at a gamma above the least.

use crate::error::SynthesisError;
use crate::lmi::program::{Affine, Program, symmetric};
use crate::lmi::solver;
use crate::lmi::solver_options::SolverOptions;
use crate::matrix::{Mat, symmetric_part};
use crate::synthesis::design::Options;
use crate::synthesis::inequalities::{COUPLING, DUAL, LmiSolution, PRIMAL, state};
use crate::system::plant::GeneralisedPlant;

/// A solution at a given gamma, above the least, that lies well inside the inequalities.
///
/// At the least gamma eigenvalues of X Y reach 1, X - Y^-1 is singular and the controller gets modes that no
/// frozen frequency response shows. So the room between X and Y^-1 is maximised first (t in
/// `[X tI; tI Y] >= 0`), under an upper bound on all unknowns. Half of that room is then kept, and the
/// inequalities made as clear as they can be.
pub(crate) fn centre(
    plant: &GeneralisedPlant,
    gamma: f64,
    small: &LmiSolution,
    options: Options,
) -> Result<LmiSolution, SynthesisError> {
    let (roomy, room) = push(plant, gamma, small, options, Aim::Room)?;
    let kept = 1.0 + 0.5 * (room - 1.0).max(0.0);
    let clear = push(plant, gamma, small, options, Aim::Clearance { room: kept });
    let found = match clear {
        Ok((found, _)) if found.margin > 0.0 || roomy.margin <= 0.0 => found,
        Err(error) if roomy.margin <= 0.0 => return Err(error),
        // Badly conditioned, but inside.
        _ => roomy,
    };
    if found.margin <= 0.0 {
        return Err(SynthesisError::numerical(
            STAGE,
            format!(
                "the inequalities do not hold strictly at the gamma of the design (margin {:.1e})",
                found.margin
            ),
        ));
    }
    Ok(found)
}

const STAGE: &str = "back-off";

/// What [`push`] maximises.
#[derive(Clone, Copy)]
enum Aim {
    /// t in `[X tI; tI Y] >= 0`.
    Room,
    /// c in `primal <= -c I`, `dual <= -c I`, `S >= c I`, `Sigma >= c I`, at a given t.
    Clearance { room: f64 },
}

/// Maximises `aim` under the synthesis inequalities at `gamma`; returns the point and the value of the aim.
fn push(
    plant: &GeneralisedPlant,
    gamma: f64,
    small: &LmiSolution,
    options: Options,
    aim: Aim,
) -> Result<(LmiSolution, f64), SynthesisError> {
    let Options { scalings, quick, .. } = options;
    let (n, r) = (plant.sizes().x, plant.sizes().t);
    let mut program = Program::default();
    let unknowns = state(&mut program, plant, Some(gamma), scalings);
    for (e, least) in [
        (&unknowns.x, &small.x),
        (&unknowns.y, &small.y),
        (&unknowns.s, &small.primal_scaling),
        (&unknowns.sigma, &small.dual_scaling),
    ] {
        program.positive("upper bound", Affine::constant(symmetric_part(least) * LARGEST_GROWTH) - e.clone());
    }
    let value = program.scalar();
    let room = match aim {
        Aim::Room => value.times_identity(n),
        Aim::Clearance { room } => Affine::constant(Mat::identity(n, n) * room),
    };
    program.without(COUPLING);
    program.positive("[X tI; tI Y]", symmetric(&[vec![unknowns.x.clone(), room], vec![unknowns.y.clone()]]));
    if matches!(aim, Aim::Clearance { .. }) {
        program.tighten(PRIMAL, &value);
        program.tighten(DUAL, &value);
        program.positive("floor of S", unknowns.s.clone() - value.times_identity(r));
        program.positive("floor of Sigma", unknowns.sigma.clone() - value.times_identity(r));
    }
    program.minimise_trace(&value, -1.0);
    let search = match aim {
        Aim::Room => SolverOptions { quick, ..SolverOptions::within(ROOM_TOLERANCE) },
        // A clearance may be small, and has to be found above zero.
        Aim::Clearance { .. } => {
            SolverOptions { floor: 1e-9, patient: true, quick, ..SolverOptions::within(CLEARANCE_TOLERANCE) }
        }
    };
    let solution = solver::solve(&program, STAGE, search).map_err(contradiction)?;
    let reached = value.value(&program, &solution.x)[(0, 0)];
    let mut relaxed = unknowns.lmi_solution(&program, &solution);
    // What counts are the inequalities themselves, not those tightened and bounded here.
    relaxed.margin = relaxed.true_margin(plant, scalings);
    Ok((relaxed, reached))
}

/// Above the least gamma there is a solution: a solver that denies it has failed.
pub(crate) fn contradiction(error: SynthesisError) -> SynthesisError {
    match error {
        SynthesisError::Infeasible { stage } => SynthesisError::numerical(
            stage,
            "the solver finds no point above the least gamma, where one exists; the problem is badly \
                        conditioned: check units and weights",
        ),
        other => other,
    }
}

/// How closely the most room is sought.
const ROOM_TOLERANCE: f64 = 1e-3;

/// How closely the clearest point is sought, relative to its clearance.
const CLEARANCE_TOLERANCE: f64 = 0.3;

/// How many times their least size the unknowns may reach.
const LARGEST_GROWTH: f64 = 10.0;
