//! The least gamma, and well-conditioned coordinates for the inequalities.

use crate::error::SynthesisError;
use crate::lmi::{Candidate, Program, SolverOptions, solver};
use crate::matrix::{Mat, eigenvalues, least_eigenvalue, symmetric_function, symmetric_part};
use crate::synthesis::back_off::contradiction;
use crate::synthesis::balance::{Coordinates, median_time_scale};
use crate::synthesis::by_riccati;
use crate::synthesis::design::{Options, repetitions};
use crate::synthesis::dual::repaired;
use crate::synthesis::inequalities::{
    DualMultipliers, LmiSolution, ScalingClass, add_inequalities, coupling, unmeasured,
};
use crate::system::{GeneralisedPlant, channels};

/// Returns the least gamma that the synthesis inequalities allow, and the coordinates in which it was found.
///
/// The problem is solved in diagonally balanced coordinates, with w and z in units in which gamma is about 1. If the
/// solver gets stuck before the optimum is certain, the point of least trace a little above the gamma found is
/// computed: its X and Y are as small as possible, and the problem is solved again in the coordinates that make them
/// equal and diagonal.
///
/// The result satisfies the inequalities strictly, by their eigenvalues: gamma is never below the infimum, and its
/// `gap` bounds the excess.
///
/// # Errors
/// Returns [`SynthesisError::Infeasible`] if the solver has a certificate that no gamma is feasible, or
/// [`SynthesisError::Numerical`].
pub fn least_gamma(
    plant: &GeneralisedPlant,
    scalings: ScalingClass,
) -> Result<(Coordinates, LmiSolution), SynthesisError> {
    at_best_time_scale(plant, Options { scalings, accuracy: SETTLED_GAP, ..Options::default() })
}

/// Returns [`least_gamma`] with the scalings, accuracy and patience of `options`.
///
/// If multipliers do not show that the gamma found is nearly the least, it is also computed with time in units of the
/// closed loop: slow weights and modes make the plant's own unit unsuitable.
pub(crate) fn at_best_time_scale(
    plant: &GeneralisedPlant,
    options: Options,
) -> Result<(Coordinates, LmiSolution), SynthesisError> {
    let mut best = least_gamma_at(plant, options, None);
    let is_sure =
        |found: &(Coordinates, LmiSolution)| found.1.lower >= (1.0 - DOUBTFUL_SHARE) * found.1.gamma;
    // If a rough value is enough, there is no lower bound to show that it is near the least.
    if options.quick || options.accuracy > DOUBTFUL_GAP || best.as_ref().is_ok_and(is_sure) {
        return best;
    }
    for time_scale in loop_time_scales(plant).into_iter().take(repetitions(plant)) {
        let Ok(mut found) = least_gamma_at(plant, options, Some(time_scale)) else { continue };
        if let Ok(known) = &mut best {
            let lower = known.1.lower.max(found.1.lower);
            (known.1.lower, found.1.lower) = (lower, lower);
        }
        if best.as_ref().map_or(true, |known| found.1.gamma < (1.0 - CLEARLY_LOWER) * known.1.gamma) {
            best = Ok(found);
        }
        if best.as_ref().is_ok_and(is_sure) {
            break;
        }
    }
    best
}

/// Returns the time scales, rad/s, of the loop that an H-infinity controller closes at Theta = 0: the median of its
/// modes, the fastest one, and the plant's fastest; those near the median of the plant's modes are left out. Empty if
/// there is no such controller.
pub(crate) fn loop_time_scales(plant: &GeneralisedPlant) -> Vec<f64> {
    let none = vec![0.0; plant.blocks.len()];
    let closed = plant.frozen(&none).ok().and_then(|nominal| {
        let (_, Ok(design)) = by_riccati::synthesise(&nominal, Options::default())? else { return None };
        Some(nominal.close(&design.controller).a())
    });
    let fastest = |a: &Mat| eigenvalues(a).iter().map(|v| v.norm()).fold(0.0, f64::max);
    let time_scales =
        closed.map_or_else(Vec::new, |a| vec![median_time_scale(&a), fastest(&a), fastest(&plant.a())]);
    let plants = median_time_scale(&plant.a());
    let is_other =
        |time_scale: &f64| !(plants / OTHER_TIME_SCALE..plants * OTHER_TIME_SCALE).contains(time_scale);
    time_scales
        .into_iter()
        .filter(|time_scale| *time_scale > 0.0 && time_scale.is_finite() && is_other(time_scale))
        .collect()
}

/// The ratio of time scales from which another unit of time makes a difference.
const OTHER_TIME_SCALE: f64 = 10.0;

/// The relative gap to the lower bound at which the unit of time is accepted.
const DOUBTFUL_SHARE: f64 = 0.01;

/// The relative decrease of gamma from which another unit of time is preferred.
const CLEARLY_LOWER: f64 = 1e-4;

/// Returns the least gamma with a given time scale, or that of the plant.
pub(crate) fn least_gamma_at(
    plant: &GeneralisedPlant,
    options: Options,
    time_scale: Option<f64>,
) -> Result<(Coordinates, LmiSolution), SynthesisError> {
    let Options { scalings, accuracy, quick, .. } = options;
    let tolerance = (SEARCHED * accuracy).max(SolverOptions::fine().tolerance);
    // A converged value is accepted if a rough one is enough: rounding may hide its proof.
    let settles = accuracy > DOUBTFUL_GAP;
    let search = SolverOptions { quick, settles, ..SolverOptions::within(tolerance) };
    let doubtful = accuracy.max(DOUBTFUL_GAP);
    let (mut conditioning, mut best) = first(plant, scalings, search, time_scale)?;
    let mut tried = (conditioning.clone(), best.clone());
    // A lower bound of gamma is the same in all coordinates.
    let estimate = |found: &LmiSolution| (found.gamma * (1.0 - found.gap)).max(0.0);
    let (mut estimated, mut lower) = (estimate(&best), best.lower);
    let mut multipliers = std::mem::take(&mut best.multipliers);
    for _ in 0..MOST_COORDINATES {
        if best.gap <= accuracy && best.margin > 0.0 {
            break;
        }
        let here = tried.0.plant(plant);
        let level = COORDINATES_GAMMA_FACTOR * tried.1.gamma / tried.0.unit;
        let Ok(small) = smallest(&here, level, &tried.1, options) else { break };
        let Some(coordinates) = equalised(&tried.0.coordinates, &small, plant) else { break };
        let next = Conditioning { coordinates, unit: tried.1.gamma };
        let Ok(again) = minimise(plant, &next, scalings, search) else { break };
        (estimated, lower) = (estimated.max(estimate(&again)), lower.max(again.lower));
        multipliers.splice(0..0, again.multipliers.iter().cloned());
        let agree = again.margin > 0.0
            && best.margin > 0.0
            && (again.gamma / best.gamma - 1.0).abs() < AGREEMENT_TOLERANCE;
        tried = (next, again);
        if better(&tried.1, &best) {
            (conditioning, best) = tried.clone();
        }
        best.gap = gap(best.gamma, estimated);
        if agree && best.gap < doubtful {
            break;
        }
    }
    if !quick
        && (best.gap > doubtful || best.margin <= 0.0)
        && let Ok(other) = minimise(plant, &conditioning, scalings, SolverOptions { patient: true, ..search })
        && better(&other, &best)
    {
        (estimated, lower) = (estimated.max(estimate(&other)), lower.max(other.lower));
        best = LmiSolution { gap: gap(other.gamma, estimated), ..other };
    }
    if best.margin > 0.0 {
        // Few can be repaired for a plant with parameters, and each trial proof takes a tenth of the search's time.
        let plain = plant.blocks.is_empty();
        let multipliers = if plain { repaired(plant, best.gamma, &multipliers) } else { vec![] };
        return Ok((conditioning.coordinates, LmiSolution { multipliers, lower, ..best }));
    }
    let (gamma, missed) = (best.gamma, -best.margin);
    let diagnosis = format!("at the gamma found, {gamma:.4e}, the inequalities are violated by {missed:.1e}");
    Err(SynthesisError::numerical(STAGE, diagnosis))
}

/// Returns the relative excess of gamma over the least; infinite without a lower bound.
fn gap(gamma: f64, lower: f64) -> f64 {
    if lower > 0.0 { (1.0 - lower / gamma).max(0.0) } else { f64::INFINITY }
}

/// The tolerance of each search, relative to the required accuracy.
const SEARCHED: f64 = 0.1;

/// The gamma at which the coordinates are computed, as a factor.
const COORDINATES_GAMMA_FACTOR: f64 = 1.1;

/// The largest number of other coordinates.
const MOST_COORDINATES: usize = 3;

/// The relative gap between gamma and its lower bound at which the search ends.
const SETTLED_GAP: f64 = 1e-5;

/// The relative agreement of gamma in two sets of coordinates at which the search ends.
const AGREEMENT_TOLERANCE: f64 = 1e-6;

/// The relative gap above which the general solver is tried.
const DOUBTFUL_GAP: f64 = 1e-3;

/// The ratio of gamma to its unit up to which the unit is kept.
const NEAR_UNIT: f64 = 10.0;

/// The largest number of changes of units.
const MOST_UNITS: usize = 5;

/// Coordinates in which a plant is well conditioned, and the unit of gain.
#[derive(Clone)]
pub(crate) struct Conditioning {
    pub(crate) coordinates: Coordinates,
    pub(crate) unit: f64,
}

impl Conditioning {
    fn balanced(plant: &GeneralisedPlant, unit: f64, time_scale: Option<f64>) -> Self {
        let scaled = plant.in_units_of(unit);
        let time_scale = time_scale.unwrap_or_else(|| median_time_scale(&plant.a()));
        Self { coordinates: Coordinates::with_time_scale(&scaled, time_scale), unit }
    }

    pub(crate) fn plant(&self, plant: &GeneralisedPlant) -> GeneralisedPlant {
        self.coordinates.apply(&plant.in_units_of(self.unit))
    }
}

/// Returns a first solution, in units in which its gamma is about 1.
fn first(
    plant: &GeneralisedPlant,
    scalings: ScalingClass,
    search: SolverOptions<'_>,
    time_scale: Option<f64>,
) -> Result<(Conditioning, LmiSolution), SynthesisError> {
    let mut conditioning = Conditioning::balanced(plant, first_unit(plant), time_scale);
    let mut best = minimise(plant, &conditioning, scalings, search)?;
    for _ in 0..MOST_UNITS {
        let ratio = best.gamma / conditioning.unit;
        if (1.0 / NEAR_UNIT..NEAR_UNIT).contains(&ratio) || ratio.is_nan() || ratio <= 0.0 {
            break;
        }
        let next = Conditioning::balanced(plant, best.gamma, time_scale);
        let Ok(again) = minimise(plant, &next, scalings, search) else { break };
        (conditioning, best) = (next, again);
    }
    Ok((conditioning, best))
}

/// Estimates gamma from norms only.
fn first_unit(plant: &GeneralisedPlant) -> f64 {
    let scaled = Coordinates::diagonal(plant).apply(plant);
    let guess = scaled.d11().norm() + scaled.b1().norm() * scaled.c1().norm();
    if guess.is_finite() && guess > 0.0 { guess } else { 1.0 }
}

fn better(one: &LmiSolution, other: &LmiSolution) -> bool {
    let candidate = |found: &LmiSolution| Candidate { margin: found.margin, cost: found.gamma };
    solver::is_better(candidate(one), candidate(other))
}

const STAGE: &str = "least gamma";

/// Tolerance of the smallest matrices, which only set a scale.
const SCALE_TOLERANCE: f64 = 1e-3;

/// Returns the point of least trace at a given gamma: the smallest X, Y, S and Sigma. `known` is a solution at this
/// gamma or a lower one.
pub(crate) fn smallest(
    plant: &GeneralisedPlant,
    gamma: f64,
    known: &LmiSolution,
    options: Options,
) -> Result<LmiSolution, SynthesisError> {
    let Options { scalings, quick, .. } = options;
    let mut program = Program::default();
    let unknowns = add_inequalities(&mut program, plant, Some(gamma), scalings);
    if scalings == ScalingClass::SymmetricAndSkew {
        // No other term keeps S and Sigma away from zero. The inequalities do not require this, so the known solution
        // must satisfy it.
        let size = least_product(&known.primal_scaling, &known.dual_scaling).min(1.0);
        program.positive("[S cI; cI Sigma]", coupling(&unknowns.s, &unknowns.sigma, 0.9 * size));
    }
    for e in [&unknowns.x, &unknowns.y, &unknowns.s, &unknowns.sigma] {
        program.minimise_trace(e, 1.0);
    }
    let search = SolverOptions { quick, ..SolverOptions::within(SCALE_TOLERANCE) };
    let solution = solver::solve(&program, SMALLEST_STAGE, search).map_err(contradiction)?;
    Ok(unknowns.lmi_solution(&program, &solution))
}

/// Returns the largest c with `[S cI; cI Sigma] >= 0` for the symmetric parts S and Sigma: `c^2` is the least
/// eigenvalue of `S Sigma`.
fn least_product(primal: &Mat, dual: &Mat) -> f64 {
    let root = symmetric_function(&symmetric_part(primal), |v| v.max(0.0).sqrt());
    least_eigenvalue(&(&root * symmetric_part(dual) * &root)).max(0.0).sqrt()
}

/// Returns the coordinates in which a solution's pairs (X, Y) and (S, Sigma) are equal and diagonal.
pub(crate) fn equalised(
    at: &Coordinates,
    found: &LmiSolution,
    plant: &GeneralisedPlant,
) -> Option<Coordinates> {
    let s = symmetric_part(&found.primal_scaling);
    let sigma = symmetric_part(&found.dual_scaling);
    at.equalising(&found.x, &found.y, &s, &sigma, &channels(&plant.blocks))
}

/// Returns the least gamma in the coordinates of `conditioning`, in the plant's units.
fn minimise(
    plant: &GeneralisedPlant,
    conditioning: &Conditioning,
    scalings: ScalingClass,
    search: SolverOptions<'_>,
) -> Result<LmiSolution, SynthesisError> {
    let mut program = Program::default();
    let scaled = conditioning.plant(plant);
    let unknowns = add_inequalities(&mut program, &scaled, None, scalings);
    program.minimise_trace(&unknowns.gamma, 1.0);
    let solution = solver::solve(&program, STAGE, search)?;
    let found = unknowns.lmi_solution(&program, &solution);
    let gap = solution.gap * (1.0 + found.gamma.abs()) / found.gamma;
    let multipliers = dual_multipliers(conditioning, &scaled, &solution.multipliers, scalings);
    let lower = conditioning.unit * solution.lower.max(0.0);
    Ok(LmiSolution { gamma: conditioning.unit * found.gamma, gap, lower, multipliers, ..found })
}

/// Returns the multipliers of the last steps, the latest first, in the plant's coordinates.
fn dual_multipliers(
    conditioning: &Conditioning,
    scaled: &GeneralisedPlant,
    steps: &[Vec<Mat>],
    scalings: ScalingClass,
) -> Vec<DualMultipliers> {
    // The multipliers with symmetric scalings only belong to another problem.
    if scalings == ScalingClass::Symmetric {
        return vec![];
    }
    let n = scaled.sizes().x;
    let (primal, dual) = (unmeasured(scaled), unmeasured(&scaled.dual()));
    let found = steps.iter().rev().filter_map(|step| {
        // The steps are in the order in which the inequalities are stated.
        let [of_primal, of_dual, ..] = step.as_slice() else { return None };
        Some(DualMultipliers {
            primal: &primal * of_primal.clone().cholesky()?.l(),
            dual: &dual * of_dual.clone().cholesky()?.l(),
            coupling: (Mat::zeros(n, 0), Mat::zeros(n, 0)),
        })
    });
    found.map(|m| conditioning.coordinates.undo_multipliers(conditioning.unit, &m)).collect()
}

const SMALLEST_STAGE: &str = "smallest matrices";
