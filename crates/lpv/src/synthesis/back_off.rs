//! A point in the interior of the synthesis inequalities, at a gamma above the least.

use crate::error::SynthesisError;
use crate::lmi::{Affine, Program, SolverOptions, solver, symmetric};
use crate::matrix::{Mat, symmetric_part};
use crate::synthesis::design::Options;
use crate::synthesis::inequalities::{COUPLING, DUAL, LmiSolution, PRIMAL, add_inequalities};
use crate::system::GeneralisedPlant;

/// Returns a well-centred solution of the synthesis inequalities at a given gamma above the least.
///
/// At the least gamma eigenvalues of X Y reach 1, X - Y^-1 is singular and the controller gets modes that no frozen
/// frequency response shows. The separation of X and Y^-1 (t in `[X tI; tI Y] >= 0`) is therefore maximised first,
/// under an upper bound on all unknowns. Half of it is then kept, and the margin of the inequalities maximised.
pub(crate) fn centre(
    plant: &GeneralisedPlant,
    gamma: f64,
    small: &LmiSolution,
    options: Options,
) -> Result<LmiSolution, SynthesisError> {
    let (separated, separation) = maximise(plant, gamma, small, options, Aim::Separation)?;
    let kept = 1.0 + 0.5 * (separation - 1.0).max(0.0);
    let clear = maximise(plant, gamma, small, options, Aim::Margin { separation: kept });
    let found = match clear {
        Ok((found, _)) if found.margin > 0.0 || separated.margin <= 0.0 => found,
        Err(error) if separated.margin <= 0.0 => return Err(error),
        // Badly conditioned but feasible.
        _ => separated,
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

/// The objective of [`maximise`].
#[derive(Clone, Copy)]
enum Aim {
    /// The separation t in `[X tI; tI Y] >= 0`.
    Separation,
    /// The margin c in `primal <= -c I`, `dual <= -c I`, `S >= c I`, `Sigma >= c I`, at a given t.
    Margin { separation: f64 },
}

/// Maximises `aim` under the synthesis inequalities at `gamma`; returns the point and the value of the aim.
fn maximise(
    plant: &GeneralisedPlant,
    gamma: f64,
    small: &LmiSolution,
    options: Options,
    aim: Aim,
) -> Result<(LmiSolution, f64), SynthesisError> {
    let Options { scalings, quick, .. } = options;
    let (n, r) = (plant.sizes().x, plant.sizes().t);
    let mut program = Program::default();
    let unknowns = add_inequalities(&mut program, plant, Some(gamma), scalings);
    for (e, least) in [
        (&unknowns.x, &small.x),
        (&unknowns.y, &small.y),
        (&unknowns.s, &small.primal_scaling),
        (&unknowns.sigma, &small.dual_scaling),
    ] {
        program.positive("upper bound", Affine::constant(symmetric_part(least) * LARGEST_GROWTH) - e.clone());
    }
    let value = program.scalar();
    let separation = match aim {
        Aim::Separation => value.times_identity(n),
        Aim::Margin { separation } => Affine::constant(Mat::identity(n, n) * separation),
    };
    program.without(COUPLING);
    program.positive(
        "[X tI; tI Y]",
        symmetric(&[vec![unknowns.x.clone(), separation], vec![unknowns.y.clone()]]),
    );
    if matches!(aim, Aim::Margin { .. }) {
        program.tighten(PRIMAL, &value);
        program.tighten(DUAL, &value);
        program.positive("floor of S", unknowns.s.clone() - value.times_identity(r));
        program.positive("floor of Sigma", unknowns.sigma.clone() - value.times_identity(r));
    }
    program.minimise_trace(&value, -1.0);
    let search = match aim {
        Aim::Separation => SolverOptions { quick, ..SolverOptions::within(SEPARATION_TOLERANCE) },
        // The margin may be small, and must be found to be positive.
        Aim::Margin { .. } => {
            SolverOptions { floor: 1e-9, patient: true, quick, ..SolverOptions::within(MARGIN_TOLERANCE) }
        }
    };
    let solution = solver::solve(&program, STAGE, search).map_err(contradiction)?;
    let reached = value.value(&program, &solution.x)[(0, 0)];
    let mut relaxed = unknowns.lmi_solution(&program, &solution);
    // The margin of the inequalities themselves, not of those tightened and bounded here.
    relaxed.margin = relaxed.true_margin(plant, scalings);
    Ok((relaxed, reached))
}

/// Converts a report of infeasibility to a failure: above the least gamma a solution exists.
pub(crate) fn contradiction(error: SynthesisError) -> SynthesisError {
    match error {
        SynthesisError::Infeasible { stage } => SynthesisError::numerical(
            stage,
            "the solver finds no point above the least gamma, although one exists; the problem is ill conditioned: \
                        check units and weights",
        ),
        other => other,
    }
}

/// Tolerance of the largest separation.
const SEPARATION_TOLERANCE: f64 = 1e-3;

/// Relative tolerance of the largest margin.
const MARGIN_TOLERANCE: f64 = 0.3;

/// The largest size of the unknowns, as a multiple of their least.
const LARGEST_GROWTH: f64 = 10.0;
