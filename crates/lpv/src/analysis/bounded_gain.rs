//! The gain of a closed loop for every parameter trajectory in the unit box.
//!
//! Scaled bounded-real lemma with a constant Lyapunov matrix: P. Apkarian, P. Gahinet, IEEE Trans. Automatic
//! Control 40(5), 1995, lemma 3.1, with the skew scaling of G. Scorletti and L. El Ghaoui, 1998.

use crate::analysis::bounded_real::{Multipliers, bounded_real_compact, bounded_real_value};
use crate::analysis::gain_bound::GainBound;
use crate::error::SynthesisError;
use crate::lmi::{Affine, Program, SolverOptions, solver};
use crate::matrix::{Mat, block, roots, scaled_largest_eigenvalue, skew_part, symmetric_part};
use crate::system::{ClosedLoop, LoopError, StateSpace, middle_of_gramians};

/// The tolerance of the bound, relative to itself and the initial one. Tighter bounds hold with a smaller margin.
const GAMMA_TOLERANCE: f64 = 0.01;

/// The relative distance from the least that is accepted if tightening gets stuck.
const NEAR_ENOUGH: f64 = 0.05;

/// The number of restarts, each in the coordinates of the last point.
const MOST_RESTARTS: usize = 3;

const STAGE: &str = "analysis of the closed loop";

/// Tightens a bound of the gain of a closed loop, with or without model error.
///
/// The inequalities are solved in coordinates in which X and S of the given bound are the identity, until gamma is
/// within 1 % of the least: there the inequality still holds with a margin. The result is verified by its eigenvalues
/// in floating point; if no better bound is found, it is the given one.
///
/// ```text
/// x' = A x + Bt wt + B1 w,   wt = Theta zt,   |theta_i(t)| <= 1:   |z|_2 < gamma |w|_2
/// ```
///
/// Shapes: X is states square, S and T are channels square. Source: see the module.
///
/// # Errors
/// Returns [`SynthesisError::Numerical`] if neither a new bound nor the given one satisfies the inequality.
pub fn bounded_gain(
    closed: &ClosedLoop,
    error: &LoopError,
    shown: &GainBound,
) -> Result<GainBound, SynthesisError> {
    // Changes of coordinates leave rounding in matrices that must be exactly symmetric or skew.
    let mut given = GainBound {
        x: symmetric_part(&shown.x),
        factor: None,
        s: symmetric_part(&shown.s),
        t: skew_part(&shown.t),
        ..shown.clone()
    };
    given.largest_eigenvalue = worst_eigenvalue(closed, error, &given);
    let best = tightened(closed, error, &given).or_else(|| {
        // The search makes no progress in the coordinates of an almost singular X.
        let bound = tightened(closed, error, &balanced_start(closed, &given)?)?;
        (given.largest_eigenvalue >= 0.0 || bound.gamma < given.gamma).then_some(bound)
    });
    let best = best.or_else(|| {
        let larger = with_larger_gamma(closed, error, &given)
            .or_else(|| with_larger_gamma(closed, error, &with_margin(closed, &given)?))?;
        Some(tightened(closed, error, &larger).unwrap_or(larger))
    });
    let best = best.unwrap_or(given);
    if best.largest_eigenvalue < 0.0 {
        return Ok(best);
    }
    let slowest = crate::matrix::spectral_abscissa(&closed.a());
    let why = if slowest >= 0.0 {
        format!("; a mode has real part {slowest:.1e} at Theta = 0")
    } else {
        String::new()
    };
    Err(SynthesisError::numerical(
        STAGE,
        format!(
            "at gamma = {:.4e} an eigenvalue of the inequalities, {:.1e}, has the wrong sign{why}",
            best.gamma, best.largest_eigenvalue
        ),
    ))
}

/// Returns a bound whose Lyapunov matrix is the geometric mean of the gramians of the loop at Theta = 0, its channels
/// in units of S: a start for the search, not a proved bound. `None` if the loop is not stable there.
pub fn balanced_start(closed: &ClosedLoop, bound: &GainBound) -> Option<GainBound> {
    let (root, inverse) = roots(&bound.s);
    let unit = bound.gamma.sqrt();
    let b = block(&[&[&(closed.bt() * inverse), &(closed.b1() / unit)]]);
    let c = block(&[&[&(root * closed.ct())], &[&(closed.c1() / unit)]]);
    let (inputs, outputs) = (b.ncols(), c.nrows());
    let system = StateSpace { a: closed.a(), b, c, d: Mat::zeros(outputs, inputs) };
    let (x, _) = middle_of_gramians(&[&system])?;
    Some(GainBound { x, factor: None, ..bound.clone() })
}

/// Returns a larger bound with model error by the matrices of one without, if the search finds none by itself.
fn with_larger_gamma(closed: &ClosedLoop, error: &LoopError, given: &GainBound) -> Option<GainBound> {
    let mut tried =
        GAMMA_FACTORS.iter().flat_map(|factor| POWERS_OF_LAMBDA.map(move |power| (factor, power)));
    tried.find_map(|(factor, power)| {
        let mut at = GainBound { gamma: factor * given.gamma, lambda: 10f64.powi(power), ..given.clone() };
        at.largest_eigenvalue = worst_eigenvalue(closed, error, &at);
        (!error.is_none() && at.largest_eigenvalue < 0.0).then_some(at)
    })
}

/// Returns the matrices of largest margin at a larger gamma, without model error: those of a tight bound leave no
/// margin for one in directions that gamma does not affect, for any gamma.
fn with_margin(closed: &ClosedLoop, given: &GainBound) -> Option<GainBound> {
    let raised = GainBound { gamma: GAMMA_FACTORS[1] * given.gamma, ..given.clone() };
    largest_margin(Base { closed, error: &LoopError::none(closed), bound: &raised }).ok()
}

/// The factors of gamma and the powers of ten of lambda in the search for a first bound with model error.
const GAMMA_FACTORS: [f64; 4] = [1.02, 1.1, 1.5, 3.0];
const POWERS_OF_LAMBDA: std::ops::RangeInclusive<i32> = -8..=2;

/// Returns a bound close to the least; `None` if no search found a better one that holds.
fn tightened(closed: &ClosedLoop, error: &LoopError, given: &GainBound) -> Option<GainBound> {
    tightened_by(closed, error, given, false)
}

/// Returns a close bound of a loop without model error, from any start, by the interior-point method alone: the general
/// solver takes a minute if there is no bound.
pub(crate) fn quickly(closed: &ClosedLoop, start: &GainBound) -> Option<GainBound> {
    tightened_by(closed, &LoopError::none(closed), start, true)
}

fn tightened_by(closed: &ClosedLoop, error: &LoopError, given: &GainBound, quick: bool) -> Option<GainBound> {
    let mut best: Option<GainBound> = None;
    for _ in 0..MOST_RESTARTS {
        let base = best.as_ref().unwrap_or(given);
        let Ok((found, gap)) = search_by(Base { closed, error, bound: base }, GAMMA_TOLERANCE, quick) else {
            break;
        };
        if found.largest_eigenvalue >= 0.0 {
            break;
        }
        let better = base.largest_eigenvalue >= 0.0 || found.gamma < base.gamma;
        if better {
            best = Some(found);
        }
        if !better || gap <= NEAR_ENOUGH {
            break;
        }
    }
    best
}

/// A loop and a bound of it; the search is done in coordinates in which its X and S are the identity.
#[derive(Clone, Copy)]
pub(crate) struct Base<'a> {
    pub(crate) closed: &'a ClosedLoop,
    pub(crate) error: &'a LoopError,
    pub(crate) bound: &'a GainBound,
}

/// A base in these coordinates.
struct Whitened {
    scaled: ClosedLoop,
    error: LoopError,
    /// The bound of the base, with X, S and gamma equal to 1.
    bound: GainBound,
    state_inverse: Mat,
    channel_inverse: Mat,
}

impl Whitened {
    fn new(base: Base) -> Result<Self, SynthesisError> {
        let (state, state_inverse) = whitening(&base.bound.x, "X")?;
        let (channel, channel_inverse) = whitening(&base.bound.s, "S")?;
        let scaled = base.closed.in_coordinates((&state, &state_inverse), (&channel, &channel_inverse));
        let scaled = scaled.in_units_of(base.bound.gamma);
        let error = base.error.in_coordinates((&state, &state_inverse), &channel);
        let error = error.in_units_of(base.bound.gamma);
        let (n, r) = (scaled.a().nrows(), scaled.channels.len());
        let bound = GainBound {
            gamma: 1.0,
            x: Mat::identity(n, n),
            factor: None,
            s: Mat::identity(r, r),
            t: channel.transpose() * &base.bound.t * &channel,
            ..*base.bound
        };
        Ok(Self { scaled, error, bound, state_inverse, channel_inverse })
    }
}

/// The program of a base in its coordinates.
pub(crate) struct Posed {
    pub(crate) program: Program,
    pub(crate) unknowns: Multipliers<Affine>,
    /// The bounded-real matrix.
    pub(crate) inequality: Affine,
    /// The point of the base.
    pub(crate) start: Vec<f64>,
    /// The loop in the coordinates.
    pub(crate) scaled: ClosedLoop,
    state_inverse: Mat,
    channel_inverse: Mat,
}

impl Posed {
    /// Builds the program with gamma unknown, or fixed to that of the base.
    pub(crate) fn new(base: Base, fixed: bool) -> Result<Self, SynthesisError> {
        let Whitened { scaled, error, bound, state_inverse, channel_inverse } = Whitened::new(base)?;
        let n = scaled.a().nrows();
        let mut program = Program::default();
        let m = Multipliers {
            x: program.symmetric(n),
            s: program.symmetric_commuting(&scaled.channels),
            t: program.skew_commuting(&scaled.channels),
            gamma: if fixed { Affine::number(1.0) } else { program.scalar() },
            lambda: if error.is_none() { Affine::number(0.0) } else { program.scalar() },
        };
        let mut start = vec![0.0; program.unknowns()];
        program.set(&mut start, &m.x, &bound.x);
        program.set(&mut start, &m.s, &bound.s);
        program.set(&mut start, &m.t, &bound.t);
        program.set(&mut start, &m.gamma, &Mat::from_element(1, 1, bound.gamma));
        program.set(&mut start, &m.lambda, &Mat::from_element(1, 1, bound.lambda));
        let inequality = bounded_real_compact(&scaled, &error, &m);
        Ok(Self { program, unknowns: m, inequality, start, scaled, state_inverse, channel_inverse })
    }

    /// Returns the bound at a point, in the loop's original coordinates.
    pub(crate) fn bound(&self, base: Base, point: &[f64]) -> GainBound {
        let value = |e: &Affine| e.value(&self.program, point);
        let back = |m: Mat, inverse: &Mat| inverse.transpose() * m * inverse;
        let m = &self.unknowns;
        let mut bound = GainBound {
            gamma: base.bound.gamma * value(&m.gamma)[(0, 0)],
            x: symmetric_part(&back(value(&m.x), &self.state_inverse)),
            factor: None,
            s: symmetric_part(&back(value(&m.s), &self.channel_inverse)),
            t: skew_part(&back(value(&m.t), &self.channel_inverse)),
            lambda: value(&m.lambda)[(0, 0)],
            largest_eigenvalue: f64::NAN,
        };
        bound.largest_eigenvalue = worst_eigenvalue(base.closed, base.error, &bound);
        bound
    }
}

/// Returns a gamma close to the least, within `tolerance`, and the gap.
pub(crate) fn search(base: Base, tolerance: f64) -> Result<(GainBound, f64), SynthesisError> {
    search_by(base, tolerance, false)
}

fn search_by(base: Base, tolerance: f64, quick: bool) -> Result<(GainBound, f64), SynthesisError> {
    let mut posed = Posed::new(base, false)?;
    let m = &posed.unknowns;
    posed.program.positive("X", m.x.clone());
    posed.program.positive("S", m.s.clone());
    posed.program.negative("bounded real", posed.inequality.clone());
    posed.program.minimise_trace(&m.gamma, 1.0);
    let search = SolverOptions {
        start: Some(&posed.start),
        enough: NEAR_ENOUGH,
        settles: true,
        quick,
        ..SolverOptions::within(tolerance)
    };
    let solution = solver::solve(&posed.program, STAGE, search)?;
    Ok((posed.bound(base, &solution.x), solution.gap))
}

/// Returns the point of largest margin at the gamma of the base: the largest t with `-t I` above the bounded-real
/// matrix and X and S between `t I` and a few times the identity, in the coordinates of the base.
pub(crate) fn largest_margin(base: Base) -> Result<GainBound, SynthesisError> {
    let mut posed = Posed::new(base, true)?;
    let margin = posed.program.scalar();
    posed.start.push(0.0);
    let size = posed.inequality.shape().0;
    posed.program.negative("bounded real", posed.inequality.clone() + margin.times_identity(size));
    for e in [&posed.unknowns.x, &posed.unknowns.s] {
        let n = e.shape().0;
        posed.program.positive("floor", e.clone() - margin.times_identity(n));
        posed
            .program
            .positive("upper bound", Affine::constant(Mat::identity(n, n) * LARGEST_GROWTH) - e.clone());
    }
    posed.program.minimise_trace(&margin, -1.0);
    let search =
        SolverOptions { start: Some(&posed.start), floor: 1e-9, ..SolverOptions::within(MARGIN_TOLERANCE) };
    let solution = solver::solve(&posed.program, STAGE, search)?;
    Ok(posed.bound(base, &solution.x))
}

/// Returns a bound at a gamma 1 % larger with matrices of the largest margin: for a proof in which those of a tight
/// bound are lost in rounding. `None` if none is found.
pub fn with_raised_gamma(closed: &ClosedLoop, error: &LoopError, bound: &GainBound) -> Option<GainBound> {
    let raised = GainBound { gamma: (1.0 + GAMMA_SHARE) * bound.gamma, ..bound.clone() };
    with_largest_margin(closed, error, &raised)
}

/// Returns a bound with model error as one without: Delta = 0 is among the errors, so that the inequality without error
/// is a part of the one with error, and the same X, S and T prove it.
pub fn without_error(closed: &ClosedLoop, covered: &GainBound) -> GainBound {
    let mut alone = GainBound { factor: None, lambda: 0.0, ..covered.clone() };
    alone.largest_eigenvalue = worst_eigenvalue(closed, &LoopError::none(closed), &alone);
    alone
}

/// The fraction of gamma traded for a margin of the inequality.
pub const GAMMA_SHARE: f64 = 0.01;

/// Returns the point of largest margin at the gamma of a bound, searched repeatedly in the coordinates of each point.
/// `None` if no inequality holds.
pub(crate) fn with_largest_margin(
    closed: &ClosedLoop,
    error: &LoopError,
    given: &GainBound,
) -> Option<GainBound> {
    let mut best: Option<GainBound> = None;
    for _ in 0..MOST_RESTARTS {
        let from = best.as_ref().unwrap_or(given);
        let Ok(found) = largest_margin(Base { closed, error, bound: from }) else { break };
        if best.as_ref().is_some_and(|b| found.largest_eigenvalue >= b.largest_eigenvalue) {
            break;
        }
        best = Some(found);
    }
    best.filter(|best| best.largest_eigenvalue < 0.0)
}

/// The largest growth of X and S in the search for the margin.
const LARGEST_GROWTH: f64 = 4.0;

/// The relative tolerance of the largest margin.
const MARGIN_TOLERANCE: f64 = 0.3;

/// The fraction of the diagonal below which rounding may determine the sign of an eigenvalue.
const ROUNDING: f64 = 1e-9;

/// Returns the largest eigenvalue of the bounded-real matrix, -X and -S, each scaled to a unit diagonal: the sign does
/// not depend on the scaling, and rounding enters in proportion. If rounding may decide the sign, it is evaluated again
/// in the coordinates in which X and S are the identity: in others slow modes may be lost in the rounding of
/// `A'X + X A`.
pub(crate) fn worst_eigenvalue(closed: &ClosedLoop, error: &LoopError, bound: &GainBound) -> f64 {
    let scaled = eigenvalue_as_given(closed, error, bound);
    if scaled < -ROUNDING {
        return scaled;
    }
    Whitened::new(Base { closed, error, bound })
        .map_or(scaled, |w| eigenvalue_as_given(&w.scaled, &w.error, &w.bound))
}

fn eigenvalue_as_given(closed: &ClosedLoop, error: &LoopError, bound: &GainBound) -> f64 {
    let all = [bounded_real_value(closed, error, bound), -&bound.x, -&bound.s];
    all.iter().map(scaled_largest_eigenvalue).fold(f64::NEG_INFINITY, f64::max)
}

/// Returns T and its inverse with `T' M T = I`.
pub(crate) fn whitening(m: &Mat, name: &str) -> Result<(Mat, Mat), SynthesisError> {
    if m.is_empty() {
        return Ok((m.clone(), m.clone()));
    }
    let inverse = m.clone().cholesky().map(|c| c.l().transpose());
    inverse.and_then(|inverse| Some((inverse.clone().try_inverse()?, inverse))).ok_or_else(|| {
        SynthesisError::numerical(STAGE, format!("the initial {name} is not positive definite"))
    })
}
