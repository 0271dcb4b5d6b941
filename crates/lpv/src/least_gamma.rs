//! The least gamma, and coordinates in which the inequalities are well conditioned.

use crate::back_off::{clearest, contradiction};
use crate::balance::Coordinates;
use crate::error::SynthesisError;
use crate::inequalities::{Existence, Scalings, coupling, state};
use crate::lmi::Program;
use crate::matrix::symmetric_part;
use crate::plant::{GeneralisedPlant, channels};
use crate::solver;

/// The least gamma that the synthesis inequalities allow, and the coordinates in which it was found.
///
/// The problem is solved in diagonally balanced coordinates. A little above the gamma found the point of least
/// trace is sought: its X and Y are as small as they may be, and in the coordinates that make them equal and
/// diagonal the problem is solved again, until gamma settles.
///
/// What comes back satisfies the inequalities strictly, by their eigenvalues: the solver's point is moved towards one
/// well inside them, by as little as it takes. So gamma is never below the infimum by more than rounding. Only where the
/// solver finds no such point its own comes back, and the margin is negative.
///
/// # Errors
/// [`SynthesisError::Infeasible`] with the solver's certificate that no gamma will do; [`SynthesisError::Numerical`].
pub fn least_gamma(
    plant: &GeneralisedPlant,
    scalings: Scalings,
) -> Result<(Coordinates, Existence), SynthesisError> {
    let mut coordinates = Coordinates::diagonal(plant);
    let mut best = minimise(&coordinates.apply(plant), scalings)?;
    for _ in 0..4 {
        let Ok(small) = smallest(&coordinates.apply(plant), best.gamma * RELAXED, scalings) else { break };
        let Some(next) = equalised(&coordinates, &small, plant) else { break };
        let Ok(again) = minimise(&next.apply(plant), scalings) else { break };
        let settled = (again.gamma - best.gamma).abs() < SETTLED * best.gamma;
        (coordinates, best) = (next, again);
        if settled {
            break;
        }
    }
    let strict = strictly(&coordinates.apply(plant), &best, scalings);
    // Where no point inside is found, the solver's own stands, with the margin by which it misses.
    Ok((coordinates, strict.unwrap_or(best)))
}

/// How far above gamma the coordinates, and a point well inside the inequalities, are sought.
const RELAXED: f64 = 1.1;

/// Two searches in different coordinates that agree so closely, relative to gamma, have found the least: the solver's
/// own noise is not far below.
const SETTLED: f64 = 1e-5;

/// The least mixture of an optimum with a point inside that satisfies the inequalities strictly.
fn strictly(
    plant: &GeneralisedPlant,
    optimum: &Existence,
    scalings: Scalings,
) -> Result<Existence, SynthesisError> {
    let gamma = optimum.gamma * RELAXED;
    let inside = clearest(plant, gamma, &smallest(plant, gamma, scalings)?, scalings)?;
    let parts = (-36..=0).map(|k| 10f64.powf(f64::from(k) / 4.0));
    let mixed = parts
        .map(|part| optimum.mixed(&inside, part, plant, scalings))
        .find(|mixed| mixed.margin > 0.0)
        .ok_or_else(|| SynthesisError::Numerical {
            stage: STAGE,
            diagnosis: format!("no point satisfies the inequalities strictly, up to gamma = {gamma:.4}"),
        })?;
    // Where the optimum was found badly much has to be mixed in; a search a little above it may do better.
    for excess in [1e-6, 1e-5, 1e-4].into_iter().filter(|e| optimum.gamma * (1.0 + 2.0 * e) < mixed.gamma) {
        let level = optimum.gamma * (1.0 + excess);
        let direct =
            smallest(plant, level, scalings).and_then(|small| clearest(plant, level, &small, scalings));
        if let Ok(found) = direct
            && found.margin > 0.0
        {
            return Ok(found);
        }
    }
    Ok(mixed)
}

const STAGE: &str = "least gamma";

/// The point of least trace at a given gamma: the smallest X, Y, S and Sigma.
pub(crate) fn smallest(
    plant: &GeneralisedPlant,
    gamma: f64,
    scalings: Scalings,
) -> Result<Existence, SynthesisError> {
    let mut program = Program::new();
    let unknowns = state(&mut program, plant, Some(gamma), scalings);
    if scalings == Scalings::SymmetricAndSkew {
        // Without a coupling S and Sigma would shrink against each other.
        program.positive("[S I; I Sigma]", coupling(&unknowns.s, &unknowns.sigma, 1.0));
    }
    for e in [&unknowns.x, &unknowns.y, &unknowns.s, &unknowns.sigma] {
        program.minimise_trace(e, 1.0);
    }
    let solution = solver::solve(&program, SMALLEST).map_err(contradiction)?;
    Ok(unknowns.existence(&program, &solution))
}

fn equalised(at: &Coordinates, found: &Existence, plant: &GeneralisedPlant) -> Option<Coordinates> {
    let s = symmetric_part(&found.primal_scaling);
    let sigma = symmetric_part(&found.dual_scaling);
    at.equalising(&found.x, &found.y, &s, &sigma, &channels(&plant.blocks))
}

/// The least gamma in the plant's own coordinates.
fn minimise(plant: &GeneralisedPlant, scalings: Scalings) -> Result<Existence, SynthesisError> {
    let mut program = Program::new();
    let unknowns = state(&mut program, plant, None, scalings);
    program.minimise_trace(&unknowns.gamma, 1.0);
    let solution = solver::solve(&program, STAGE)?;
    let found = unknowns.existence(&program, &solution);
    // At the optimum the inequalities are tight: they may be missed by rounding, not by more.
    let size = found.x.amax().max(found.y.amax()).max(found.gamma).max(1.0);
    if solution.margin < -1e-6 * size {
        return Err(SynthesisError::Numerical {
            stage: STAGE,
            diagnosis: format!(
                "the point that the solver returned misses '{}' by {:.1e} (matrices up to {size:.1e})",
                solution.tightest, -solution.margin
            ),
        });
    }
    Ok(found)
}

const SMALLEST: &str = "smallest matrices";
