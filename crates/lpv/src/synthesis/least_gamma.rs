//! The least gamma, and coordinates in which the inequalities are well conditioned.

use crate::error::SynthesisError;
use crate::lmi::program::Program;
use crate::lmi::solver;
use crate::lmi::solver_options::SolverOptions;
use crate::matrix::{Mat, eigenvalues, least_eigenvalue, symmetric_function, symmetric_part};
use crate::synthesis::back_off::contradiction;
use crate::synthesis::balance::{Coordinates, middle_speed};
use crate::synthesis::by_riccati;
use crate::synthesis::design::Options;
use crate::synthesis::dual::repaired;
use crate::synthesis::inequalities::{
    DualMultipliers, LmiSolution, ScalingClass, coupling, state, unmeasured,
};
use crate::system::plant::{GeneralisedPlant, channels};

/// The least gamma that the synthesis inequalities allow, and the coordinates in which it was found.
///
/// The problem is solved in diagonally balanced coordinates, w and z in units in which gamma is about 1. Where the
/// solver gets stuck before it is sure of the optimum, the point of least trace is sought a little above the gamma
/// found: its X and Y are as small as they may be, and in the coordinates that make them equal and diagonal the
/// problem is solved again.
///
/// What comes back satisfies the inequalities strictly, by their eigenvalues: gamma is never below the infimum, and
/// its `gap` says how far it may be above.
///
/// # Errors
/// [`SynthesisError::Infeasible`] when the solver holds a certificate that no gamma will do;
/// [`SynthesisError::Numerical`].
pub fn least_gamma(
    plant: &GeneralisedPlant,
    scalings: ScalingClass,
) -> Result<(Coordinates, LmiSolution), SynthesisError> {
    at_best_speed(plant, Options { scalings, accuracy: SETTLED_GAP, ..Options::default() })
}

/// The same, by scalings, accuracy and patience of `options`.
///
/// Where multipliers do not show that the gamma found is nearly the least, it is sought with time in the units of the
/// closed loop, too: far slower weights and modes of the plant make its own unit a bad one.
pub(crate) fn at_best_speed(
    plant: &GeneralisedPlant,
    options: Options,
) -> Result<(Coordinates, LmiSolution), SynthesisError> {
    let mut best = least_gamma_within(plant, options);
    let is_sure =
        |found: &(Coordinates, LmiSolution)| found.1.lower >= (1.0 - DOUBTFUL_SHARE) * found.1.gamma;
    // Where a rough value is enough, nothing shows that it is near the least.
    if options.quick || options.accuracy > DOUBTFUL_GAP || best.as_ref().is_ok_and(is_sure) {
        return best;
    }
    for speed in loop_speeds(plant) {
        let Ok(mut found) = sought(plant, options, Some(speed)) else { continue };
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

/// The same with time in units of the plant's own modes.
pub(crate) fn least_gamma_within(
    plant: &GeneralisedPlant,
    options: Options,
) -> Result<(Coordinates, LmiSolution), SynthesisError> {
    sought(plant, options, None)
}

/// The speeds, rad/s, of the loop that an H-infinity controller closes round the plant at Theta = 0: the median of its
/// modes, the fastest one, and the fastest of the plant; those near the middle of the plant's own modes are left out.
/// Empty where there is no such controller.
pub(crate) fn loop_speeds(plant: &GeneralisedPlant) -> Vec<f64> {
    let none = vec![0.0; plant.blocks.len()];
    let closed = plant.frozen(&none).ok().and_then(|nominal| {
        let (_, Ok(design)) = by_riccati::synthesise(&nominal, Options::default())? else { return None };
        Some(nominal.close(&design.controller).a())
    });
    let fastest = |a: &Mat| eigenvalues(a).iter().map(|v| v.norm()).fold(0.0, f64::max);
    let speeds = closed.map_or_else(Vec::new, |a| vec![middle_speed(&a), fastest(&a), fastest(&plant.a())]);
    let own = middle_speed(&plant.a());
    let is_other = |speed: &f64| !(own / OTHER_SPEED..own * OTHER_SPEED).contains(speed);
    speeds.into_iter().filter(|speed| *speed > 0.0 && speed.is_finite() && is_other(speed)).collect()
}

/// A unit of time that is another makes a difference from this ratio on.
const OTHER_SPEED: f64 = 10.0;

/// A lower bound as near as this to gamma, relative to it, settles the unit of time.
const DOUBTFUL_SHARE: f64 = 0.01;

/// A gamma counts as lower in another unit of time by more than this part of it.
const CLEARLY_LOWER: f64 = 1e-4;

/// The least gamma with time in units of a speed, or of the plant's own.
pub(crate) fn sought(
    plant: &GeneralisedPlant,
    options: Options,
    speed: Option<f64>,
) -> Result<(Coordinates, LmiSolution), SynthesisError> {
    let Options { scalings, accuracy, quick, .. } = options;
    let tolerance = (SEARCHED * accuracy).max(SolverOptions::fine().tolerance);
    // Where a rough value is enough, one that has settled is: its proof may be lost in rounding.
    let settles = accuracy > DOUBTFUL_GAP;
    let search = SolverOptions { quick, settles, ..SolverOptions::within(tolerance) };
    let doubtful = accuracy.max(DOUBTFUL_GAP);
    let (mut place, mut best) = first(plant, scalings, search, speed)?;
    let mut tried = (place.clone(), best.clone());
    // What no gamma goes below is the same in all coordinates.
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
        let next = Place { coordinates, unit: tried.1.gamma };
        let Ok(again) = minimise(plant, &next, scalings, search) else { break };
        (estimated, lower) = (estimated.max(estimate(&again)), lower.max(again.lower));
        multipliers.splice(0..0, again.multipliers.iter().cloned());
        let agree = again.margin > 0.0
            && best.margin > 0.0
            && (again.gamma / best.gamma - 1.0).abs() < AGREEMENT_TOLERANCE;
        tried = (next, again);
        if better(&tried.1, &best) {
            (place, best) = tried.clone();
        }
        best.gap = gap(best.gamma, estimated);
        if agree && best.gap < doubtful {
            break;
        }
    }
    if !quick
        && (best.gap > doubtful || best.margin <= 0.0)
        && let Ok(other) = minimise(plant, &place, scalings, SolverOptions { patient: true, ..search })
        && better(&other, &best)
    {
        (estimated, lower) = (estimated.max(estimate(&other)), lower.max(other.lower));
        best = LmiSolution { gap: gap(other.gamma, estimated), ..other };
    }
    if best.margin > 0.0 {
        // With parameters few can be repaired, and each try of a proof takes a tenth of the search's time.
        let plain = plant.blocks.is_empty();
        let multipliers = if plain { repaired(plant, best.gamma, &multipliers) } else { vec![] };
        return Ok((place.coordinates, LmiSolution { multipliers, lower, ..best }));
    }
    let (gamma, missed) = (best.gamma, -best.margin);
    let diagnosis = format!("at the gamma found, {gamma:.4e}, the inequalities are missed by {missed:.1e}");
    Err(SynthesisError::numerical(STAGE, diagnosis))
}

/// How far gamma may be above the least, relative to itself; infinite when there is no lower bound.
fn gap(gamma: f64, lower: f64) -> f64 {
    if lower > 0.0 { (1.0 - lower / gamma).max(0.0) } else { f64::INFINITY }
}

/// How close each search comes to its optimum, relative to the accuracy asked for.
const SEARCHED: f64 = 0.1;

/// How far above gamma the coordinates are sought.
const COORDINATES_GAMMA_FACTOR: f64 = 1.1;

/// How often other coordinates are tried.
const MOST_COORDINATES: usize = 3;

/// A gap between gamma and its lower bound, relative to gamma, that settles the matter.
const SETTLED_GAP: f64 = 1e-5;

/// Searches in two sets of coordinates that agree so well, relative to gamma, have found the same.
const AGREEMENT_TOLERANCE: f64 = 1e-6;

/// A gap that is worth asking the general solver.
const DOUBTFUL_GAP: f64 = 1e-3;

/// How far from 1 gamma may be in units that need no change.
const NEAR_UNIT: f64 = 10.0;

/// How often the units are changed.
const MOST_UNITS: usize = 5;

/// Coordinates in which a plant is well conditioned, and the gain that counts as 1.
#[derive(Clone)]
pub(crate) struct Place {
    pub(crate) coordinates: Coordinates,
    pub(crate) unit: f64,
}

impl Place {
    fn balanced(plant: &GeneralisedPlant, unit: f64, speed: Option<f64>) -> Self {
        let scaled = plant.in_units_of(unit);
        let speed = speed.unwrap_or_else(|| middle_speed(&plant.a()));
        Self { coordinates: Coordinates::at_speed(&scaled, speed), unit }
    }

    pub(crate) fn plant(&self, plant: &GeneralisedPlant) -> GeneralisedPlant {
        self.coordinates.apply(&plant.in_units_of(self.unit))
    }
}

/// A first solution, in units in which its gamma is about 1.
fn first(
    plant: &GeneralisedPlant,
    scalings: ScalingClass,
    search: SolverOptions<'_>,
    speed: Option<f64>,
) -> Result<(Place, LmiSolution), SynthesisError> {
    let mut place = Place::balanced(plant, first_unit(plant), speed);
    let mut best = minimise(plant, &place, scalings, search)?;
    for _ in 0..MOST_UNITS {
        let ratio = best.gamma / place.unit;
        if (1.0 / NEAR_UNIT..NEAR_UNIT).contains(&ratio) || ratio.is_nan() || ratio <= 0.0 {
            break;
        }
        let next = Place::balanced(plant, best.gamma, speed);
        let Ok(again) = minimise(plant, &next, scalings, search) else { break };
        (place, best) = (next, again);
    }
    Ok((place, best))
}

/// A guess at gamma, from sizes alone.
fn first_unit(plant: &GeneralisedPlant) -> f64 {
    let scaled = Coordinates::diagonal(plant).apply(plant);
    let guess = scaled.d11().norm() + scaled.b1().norm() * scaled.c1().norm();
    if guess.is_finite() && guess > 0.0 { guess } else { 1.0 }
}

fn better(one: &LmiSolution, other: &LmiSolution) -> bool {
    solver::is_better((one.margin, one.gamma), (other.margin, other.gamma))
}

const STAGE: &str = "least gamma";

/// How closely the smallest matrices are sought: they only set a scale.
const SCALE_TOLERANCE: f64 = 1e-3;

/// The point of least trace at a given gamma: the smallest X, Y, S and Sigma. `known` is a solution at this gamma or
/// a lower one.
pub(crate) fn smallest(
    plant: &GeneralisedPlant,
    gamma: f64,
    known: &LmiSolution,
    options: Options,
) -> Result<LmiSolution, SynthesisError> {
    let Options { scalings, quick, .. } = options;
    let mut program = Program::default();
    let unknowns = state(&mut program, plant, Some(gamma), scalings);
    if scalings == ScalingClass::SymmetricAndSkew {
        // Nothing else keeps S and Sigma from shrinking to nothing. The inequalities do not ask for this, so it asks
        // for no more than the known solution has.
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

/// The largest c with `[S cI; cI Sigma] >= 0` for the symmetric parts S and Sigma: `c^2` is the least eigenvalue of
/// `S Sigma`.
fn least_product(primal: &Mat, dual: &Mat) -> f64 {
    let root = symmetric_function(&symmetric_part(primal), |v| v.max(0.0).sqrt());
    least_eigenvalue(&(&root * symmetric_part(dual) * &root)).max(0.0).sqrt()
}

/// The coordinates in which a solution's pairs (X, Y) and (S, Sigma) are equal and diagonal.
pub(crate) fn equalised(
    at: &Coordinates,
    found: &LmiSolution,
    plant: &GeneralisedPlant,
) -> Option<Coordinates> {
    let s = symmetric_part(&found.primal_scaling);
    let sigma = symmetric_part(&found.dual_scaling);
    at.equalising(&found.x, &found.y, &s, &sigma, &channels(&plant.blocks))
}

/// The least gamma, sought at a place; gamma comes back in the plant's units.
fn minimise(
    plant: &GeneralisedPlant,
    place: &Place,
    scalings: ScalingClass,
    search: SolverOptions<'_>,
) -> Result<LmiSolution, SynthesisError> {
    let mut program = Program::default();
    let scaled = place.plant(plant);
    let unknowns = state(&mut program, &scaled, None, scalings);
    program.minimise_trace(&unknowns.gamma, 1.0);
    let solution = solver::solve(&program, STAGE, search)?;
    let found = unknowns.lmi_solution(&program, &solution);
    let gap = solution.gap * (1.0 + found.gamma.abs()) / found.gamma;
    let multipliers = dual_multipliers(place, &scaled, &solution.multipliers, scalings);
    let lower = place.unit * solution.lower.max(0.0);
    Ok(LmiSolution { gamma: place.unit * found.gamma, gap, lower, multipliers, ..found })
}

/// The multipliers of the last steps, the latest first, in the plant's own coordinates.
fn dual_multipliers(
    place: &Place,
    scaled: &GeneralisedPlant,
    steps: &[Vec<Mat>],
    scalings: ScalingClass,
) -> Vec<DualMultipliers> {
    // With symmetric scalings alone they are those of another problem.
    if scalings == ScalingClass::Symmetric {
        return vec![];
    }
    let n = scaled.sizes().x;
    let (primal, dual) = (unmeasured(scaled), unmeasured(&scaled.dual()));
    let found = steps.iter().rev().filter_map(|step| {
        // In the order in which the inequalities are stated.
        let [of_primal, of_dual, ..] = step.as_slice() else { return None };
        Some(DualMultipliers {
            primal: &primal * of_primal.clone().cholesky()?.l(),
            dual: &dual * of_dual.clone().cholesky()?.l(),
            coupling: (Mat::zeros(n, 0), Mat::zeros(n, 0)),
        })
    });
    found.map(|m| place.coordinates.undo_multipliers(place.unit, &m)).collect()
}

const SMALLEST_STAGE: &str = "smallest matrices";
