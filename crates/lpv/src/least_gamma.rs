//! The least gamma, and coordinates in which the inequalities are well conditioned.

use crate::back_off::contradiction;
use crate::balance::Coordinates;
use crate::error::SynthesisError;
use crate::inequalities::{Existence, Scalings, coupling, state};
use crate::lmi::Program;
use crate::matrix::{Mat, least_eigenvalue, symmetric_function, symmetric_part};
use crate::plant::{GeneralisedPlant, channels};
use crate::solver::{self, Search, numerical};

/// The least gamma that the synthesis inequalities allow, and the coordinates in which it was found.
///
/// The problem is solved in diagonally balanced coordinates. Where the solver gets stuck before it is sure of the optimum, the point
/// of least trace is sought a little above the gamma found: its X and Y are as small as they may be, and in the coordinates
/// that make them equal and diagonal the problem is solved again.
///
/// What comes back satisfies the inequalities strictly, by their eigenvalues: gamma is never below the infimum.
///
/// # Errors
/// [`SynthesisError::Infeasible`] with a certificate that no gamma will do; [`SynthesisError::Numerical`].
pub fn least_gamma(
    plant: &GeneralisedPlant,
    scalings: Scalings,
) -> Result<(Coordinates, Existence), SynthesisError> {
    let mut coordinates = Coordinates::diagonal(plant);
    let mut best = minimise(&coordinates.apply(plant), scalings)?;
    let mut seen = (coordinates.clone(), best.found.clone());
    for _ in 0..ROUNDS {
        if best.gap <= SETTLED && best.found.margin > 0.0 {
            break;
        }
        let balanced = seen.0.apply(plant);
        let Ok(small) = smallest(&balanced, seen.1.gamma * RELAXED, &seen.1, scalings) else { break };
        let Some(next) = equalised(&seen.0, &small, plant) else { break };
        let Ok(again) = minimise(&next.apply(plant), scalings) else { break };
        seen = (next.clone(), again.found.clone());
        if again.better_than(&best) {
            (coordinates, best) = (next, again);
        }
    }
    if best.found.margin > 0.0 {
        return Ok((coordinates, best.found));
    }
    let (gamma, missed) = (best.found.gamma, -best.found.margin);
    Err(numerical(
        STAGE,
        format!("at the gamma found, {gamma:.4}, the inequalities are missed by {missed:.1e}"),
    ))
}

/// How far above gamma the coordinates are sought.
const RELAXED: f64 = 1.1;

/// How often other coordinates are tried.
const ROUNDS: usize = 3;

/// A gap between gamma and its lower bound, relative to gamma plus 1, that settles the matter.
const SETTLED: f64 = 1e-5;

/// A solution and how far its gamma may be from the least.
struct Optimum {
    found: Existence,
    gap: f64,
}

impl Optimum {
    fn better_than(&self, other: &Self) -> bool {
        match (self.found.margin > 0.0, other.found.margin > 0.0) {
            (true, true) => self.found.gamma < other.found.gamma,
            (false, false) => self.found.margin > other.found.margin,
            (strict, _) => strict,
        }
    }
}

const STAGE: &str = "least gamma";

/// How closely the smallest matrices are sought: they only set a scale.
const ROUGH: f64 = 1e-3;

/// The point of least trace at a given gamma: the smallest X, Y, S and Sigma. `known` is a solution at this gamma or a lower one.
pub(crate) fn smallest(
    plant: &GeneralisedPlant,
    gamma: f64,
    known: &Existence,
    scalings: Scalings,
) -> Result<Existence, SynthesisError> {
    let mut program = Program::new();
    let unknowns = state(&mut program, plant, Some(gamma), scalings);
    if scalings == Scalings::SymmetricAndSkew {
        // Nothing else keeps S and Sigma from shrinking to nothing. The inequalities do not ask for this, so it asks for no more
        // than the known solution has.
        let size = least_product(&known.primal_scaling, &known.dual_scaling).min(1.0);
        program.positive("[S cI; cI Sigma]", coupling(&unknowns.s, &unknowns.sigma, 0.9 * size));
    }
    for e in [&unknowns.x, &unknowns.y, &unknowns.s, &unknowns.sigma] {
        program.minimise_trace(e, 1.0);
    }
    let solution = solver::solve(&program, SMALLEST, Search::within(ROUGH)).map_err(contradiction)?;
    Ok(unknowns.existence(&program, &solution))
}

/// The largest c with `[S cI; cI Sigma] >= 0` for the symmetric parts S and Sigma: `c^2` is the least eigenvalue of `S Sigma`.
fn least_product(primal: &Mat, dual: &Mat) -> f64 {
    let root = symmetric_function(&symmetric_part(primal), |v| v.max(0.0).sqrt());
    least_eigenvalue(&(&root * symmetric_part(dual) * &root)).max(0.0).sqrt()
}

/// The coordinates in which a solution's pairs (X, Y) and (S, Sigma) are equal and diagonal.
pub(crate) fn equalised(
    at: &Coordinates,
    found: &Existence,
    plant: &GeneralisedPlant,
) -> Option<Coordinates> {
    let s = symmetric_part(&found.primal_scaling);
    let sigma = symmetric_part(&found.dual_scaling);
    at.equalising(&found.x, &found.y, &s, &sigma, &channels(&plant.blocks))
}

/// The least gamma in the plant's own coordinates.
fn minimise(plant: &GeneralisedPlant, scalings: Scalings) -> Result<Optimum, SynthesisError> {
    let mut program = Program::new();
    let unknowns = state(&mut program, plant, None, scalings);
    program.minimise_trace(&unknowns.gamma, 1.0);
    let solution = solver::solve(&program, STAGE, Search::fine())?;
    Ok(Optimum { found: unknowns.existence(&program, &solution), gap: solution.gap })
}

const SMALLEST: &str = "smallest matrices";
