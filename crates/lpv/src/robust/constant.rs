//! The gain of a closed loop with parameters of any trajectory or bounded rate, and constant parameters.
//!
//! ```text
//! x' = A x + Bt wt + B1 w + E w_D,   zt = Ct x + ...,   z_D = Fx x + ...,   z = C1 x + ...
//! wt = Theta zt,   w_D = Delta(t) z_D,  |Delta(t)| <= 1
//! ```
//!
//! A parameter with any trajectory has multipliers S > 0 and T, constant over frequency. A constant one has them on its
//! channels and on these filtered by `1/(s + a)`, for one or several poles -a: with `psi = [I; I/(s + a)]`, a constant
//! delta satisfies the integral quadratic constraint with
//!
//! ```text
//! (psi zt)'S (psi zt) - (psi wt)'S (psi wt) + 2 (psi wt)'T (psi zt),   S = S' > 0,  T = -T'
//! ```
//!
//! (By the KYP lemma `S > 0` loses nothing compared with `psi~ S psi > 0` on the imaginary axis.) A slowly varying
//! parameter has one more channel per filtered channel: with the filter states f of zt and g of wt, `v = theta' f`. The
//! loop is stable with a gain below gamma if one inequality with a symmetric, possibly indefinite X holds. Theorem and
//! proof are in the crate `certificate`, `constant/prove.rs`.
//!
//! X has most of the unknowns, and is eliminated: by the KYP lemma it exists if the inequality holds at every
//! frequency. The multipliers are computed for a few frequencies, to which those are added at which the inequality is
//! violated; X is finally that of a Riccati equation, and the inequality itself is checked. (Frequencies in place of X:
//! P. A. Parrilo, "On the numerical solution of LMIs derived from the KYP lemma", IEEE CDC 1999.)

mod constant_loop;
mod filtered;
mod frequencies;
mod storage;

pub use crate::robust::constant::constant_loop::{ConstantLoop, Filters};

use crate::error::SynthesisError;
use crate::lmi::{LowRank, Program, SolverOptions, minimise};
use crate::matrix::{Mat, scaled_least_eigenvalue, skew_part, spectral_abscissa, symmetric_part};
use crate::robust::bound::balanced;
use crate::robust::constant::filtered::Filtered;
use crate::robust::constant::frequencies::{Multipliers, Response, Unknowns};
use crate::robust::constant::storage::storage;
use crate::system::lyapunov;
use std::collections::BTreeSet;

const STAGE: &str = "analysis for constant parameters";

/// The number of frequencies below 1 rad/s at which the inequality is checked, equal to that above, and their decades.
const CANDIDATES: i32 = 60;
const DECADES: f64 = 3.5;

/// The stride of the candidates at which it is first imposed; the margin, in units in which gamma is about 1; and the
/// largest number of solutions with added frequencies.
const FIRST_STEP: usize = 10;
const CLEAR: f64 = 1e-7;
const MOST_ROUNDS: usize = 6;

/// The cost of the trace of S relative to gamma, in units in which S is about 1: gamma hardly depends on large parts of
/// S, but X would follow them until rounding decides whether the inequality holds.
const SIZE_COST: f64 = 1e-4;

/// The tolerance of gamma in the first round, and the distance of the neighbours added to the worst candidate.
const ROUGH_TOLERANCE: f64 = 0.1;
const NEIGHBOUR: usize = 2;

/// The increase of gamma above that of the imposed frequencies, and further increases until an X exists.
const RAISE: f64 = 1.005;
const MORE_RAISES: [f64; 4] = [1.0, 1.005, 1.02, 1.1];

/// A bound on the gain, with its proof.
///
/// Channels are those of the loop, then the filtered ones of each parameter with filters, in the order of the
/// parameters and of their poles, then those of the rates; states are those of the loop, then those of the filters of
/// zt, then of wt.
#[derive(Debug, Clone, PartialEq)]
pub struct ConstantBound {
    /// The bound.
    pub gamma: f64,
    /// Storage matrix, states square; in general indefinite.
    pub x: Mat,
    /// Symmetric scaling, channels square.
    pub s: Mat,
    /// Skew scaling, channels square.
    pub t: Mat,
    /// The multiplier of each model error.
    pub lambdas: Vec<f64>,
    /// A Lyapunov matrix of the loop's A.
    pub lyapunov: Mat,
    /// The largest eigenvalue of the inequality, scaled to a unit diagonal: negative.
    pub largest_eigenvalue: f64,
}

impl ConstantLoop {
    /// Returns a bound within a relative `tolerance` of the least that these multipliers prove; `guess` is the order of
    /// magnitude of gamma. Tighter bounds hold with a smaller margin. The search is abandoned once it shows that the
    /// bound will exceed `most`.
    ///
    /// # Errors
    /// Returns [`SynthesisError::Numerical`] if none was found: there may be none.
    pub fn bound(&self, guess: f64, tolerance: f64, most: f64) -> Result<ConstantBound, SynthesisError> {
        let failed = |why: &str| SynthesisError::numerical(STAGE, why.to_owned());
        if spectral_abscissa(&self.closed.a()) >= 0.0 {
            return Err(failed("the loop is unstable with all parameters at 0"));
        }
        let balancing = balanced(&self.closed, guess).map(|s| if s > 0.0 { 1.0 / s.sqrt() } else { 0.0 });
        let filtered = Filtered::new(self, guess, &balancing);
        let filtered = filtered.balanced().ok_or_else(|| failed("the loop could not be balanced"))?;
        let limit = if most.is_finite() { format!(" below {most:.4}") } else { String::new() };
        let none = || failed(&format!("no bound{limit} was found"));
        let inverse = filtered.scale.map(|s| if s > 0.0 { 1.0 / s } else { 0.0 });
        let rescaled = |m: &Mat| &inverse * m * &inverse;
        let search = |continues: bool| {
            let found = self.multipliers(&filtered, tolerance, most / guess, continues).ok_or_else(none)?;
            Ok::<_, SynthesisError>(MORE_RAISES.into_iter().find_map(|raise| {
                let raised = Multipliers { gamma: raise * found.gamma, ..found.clone() };
                let (x, largest_eigenvalue) = storage(&filtered.dynamics, &raised.form(&filtered))?;
                Some((raised, x, largest_eigenvalue))
            }))
        };
        let found = if let Some(found) = search(true)? { Some(found) } else { search(false)? };
        let (found, x, largest_eigenvalue) = found
            .ok_or_else(|| failed("the inequality holds at all tested frequencies, but no X was found"))?;
        Ok(ConstantBound {
            gamma: guess * found.gamma,
            x: symmetric_part(&(filtered.back.transpose() * x * &filtered.back)),
            s: symmetric_part(&rescaled(&found.s)),
            t: skew_part(&rescaled(&found.t)),
            lambdas: found.lambdas,
            lyapunov: self.lyapunov(&filtered).ok_or_else(|| failed("no Lyapunov matrix was found"))?,
            largest_eigenvalue,
        })
    }

    /// Returns multipliers and the least gamma for which the inequality holds at all candidate frequencies: it is
    /// imposed at a few of them, then also where it is violated. A search that `continues` starts from the previous
    /// multipliers if possible: it takes half as long, but sometimes ends where rounding prevents a proof by X.
    fn multipliers(
        &self,
        filtered: &Filtered,
        tolerance: f64,
        most: f64,
        continues: bool,
    ) -> Option<Multipliers> {
        let mut program = Program::default();
        let unknowns = Unknowns::new(&mut program, self, filtered);
        program.minimise_trace(&unknowns.gamma, 1.0);
        program.minimise_trace(&unknowns.s, SIZE_COST);
        unknowns.signs(self, filtered).into_iter().for_each(|e| program.positive("sign", e));
        let mut data: Vec<LowRank> =
            program.inequalities.iter().map(|i| LowRank::new(&program, &i.expression)).collect();
        let pose = |response: &Response| unknowns.at(&program, response, filtered, CLEAR);
        let responses = candidates(filtered);
        let mut posed: BTreeSet<usize> = (0..responses.len()).step_by(FIRST_STEP).collect();
        data.extend(posed.iter().map(|k| pose(&responses[*k])));
        let first = unknowns.first(&program, filtered);
        let mut before: Option<Vec<f64>> = None;
        let mut within = tolerance.max(ROUGH_TOLERANCE);
        for _ in 0..MOST_ROUNDS {
            let from = |point: &Vec<f64>| {
                let search = SolverOptions { near: Some((point, most)), ..SolverOptions::within(within) };
                minimise(&data, &program.costs(), search)
            };
            let point = before.as_ref().and_then(from).or_else(|| from(&first))?.x;
            let found = unknowns.values(&program, &point);
            before = continues.then_some(point);
            let raised = Multipliers { gamma: RAISE * found.gamma, ..found };
            let violated = worst_violated(&responses, &raised.form(filtered));
            if violated.is_empty() && within <= tolerance {
                return Some(raised);
            }
            let around =
                |k: usize| [k.saturating_sub(NEIGHBOUR), k, (k + NEIGHBOUR).min(responses.len() - 1)];
            let more = violated.into_iter().flat_map(around).filter(|k| posed.insert(*k));
            data.extend(more.map(|k| pose(&responses[k])));
            within = tolerance;
        }
        None
    }

    /// Returns Y of `A'Y + YA = -I` in coordinates in which the loop is balanced.
    fn lyapunov(&self, filtered: &Filtered) -> Option<Mat> {
        let n = self.closed.a().nrows();
        let back = filtered.back.view((0, 0), (n, n)).into_owned();
        let to = back.clone().try_inverse()?;
        let y = lyapunov(&(&back * self.closed.a() * to), &Mat::identity(n, n))?;
        Some(symmetric_part(&(back.transpose() * y * back)))
    }
}

/// Returns the responses at the frequencies of the check: 0, values denser near 1 rad/s, and infinity.
fn candidates(filtered: &Filtered) -> Vec<Response> {
    let inner = (-CANDIDATES..=CANDIDATES).map(|k| {
        let t = f64::from(k) / f64::from(CANDIDATES);
        10f64.powf(DECADES * t * t.abs().sqrt())
    });
    let all = std::iter::once(0.0).chain(inner).chain([f64::INFINITY]);
    all.filter_map(|omega| Response::new(filtered, omega)).collect()
}

/// Returns the indices of the local worst violations of the inequality with this form.
fn worst_violated(responses: &[Response], form: &Mat) -> Vec<usize> {
    let least = |r: &Response| {
        let value = r.value(form);
        if value.clone().cholesky().is_some() { 0.0 } else { scaled_least_eigenvalue(&value).min(0.0) }
    };
    let least: Vec<f64> = responses.iter().map(least).collect();
    let at = |k: usize| least.get(k).copied().unwrap_or(0.0);
    (0..least.len()).filter(|&k| at(k) < at(k.wrapping_sub(1)) && at(k) <= at(k + 1)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::system::partition::Group::{T, W, X, Z};
    use crate::system::partition::{LOOP, Partitioned};
    use crate::system::plant::ClosedLoop;
    use nalgebra::dmatrix;

    const DAMPING: f64 = 0.1;

    /// Returns `x'' + 2 zeta x' + (1 + size delta) x = w`, `z = x'`.
    fn oscillator(size: f64, rate: Option<f64>) -> ConstantLoop {
        behind(&[1.0], size, rate)
    }

    /// Returns the oscillator with filters of the given poles.
    fn behind(poles: &[f64], size: f64, rate: Option<f64>) -> ConstantLoop {
        let blocks = [
            (X, X, dmatrix![0.0, 1.0; -1.0, -2.0 * DAMPING]),
            (X, T, dmatrix![0.0; -1.0]),
            (X, W, dmatrix![0.0; 1.0]),
            (T, X, dmatrix![size, 0.0]),
            (Z, X, dmatrix![0.0, 1.0]),
        ];
        let parts = Partitioned::new(LOOP, &blocks).unwrap();
        let filters = rate.map(|rate| Filters { poles: poles.to_vec(), rate });
        ConstantLoop {
            closed: ClosedLoop { parts, channels: vec![0] },
            filters: vec![filters],
            errors: vec![],
        }
    }

    /// The gain from force to velocity is 1/(2 zeta) for any constant positive stiffness. A stiffness that may jump
    /// makes the loop unstable much earlier: with `zd = x` and `wd = delta size x`, the gain from wd to zd is
    /// `1/(2 zeta sqrt(1 - zeta^2))`, about 5.
    #[test]
    fn a_constant_stiffness_does_not_change_the_gain_from_force_to_velocity() {
        let exact = 1.0 / (2.0 * DAMPING);
        for (size, conservatism) in [(0.25, 1.1), (0.6, 1.2), (0.9, 1.3)] {
            let found = oscillator(size, Some(0.0)).bound(exact, 0.01, f64::INFINITY).unwrap();
            assert!(found.largest_eigenvalue < 0.0);
            assert!(found.gamma > exact && found.gamma < conservatism * exact, "{size}: {}", found.gamma);
            assert!(oscillator(size, None).bound(exact, 0.01, f64::INFINITY).is_err(), "{size}");
        }
        // Both have bounds below the limit of the small-gain theorem.
        let jumping = oscillator(0.15, None).bound(exact, 0.01, f64::INFINITY).unwrap().gamma;
        let constant = oscillator(0.15, Some(0.0)).bound(exact, 0.01, f64::INFINITY).unwrap().gamma;
        assert!(
            exact < constant && constant < 1.1 * exact && jumping > 1.2 * constant,
            "{constant} {jumping}"
        );
    }

    /// More poles give a tighter bound.
    #[test]
    fn more_filters_prove_a_lower_gain() {
        let exact = 1.0 / (2.0 * DAMPING);
        let gamma = |poles: &[f64]| {
            let found = behind(poles, 0.9, Some(0.0)).bound(exact, 1e-3, f64::INFINITY).unwrap();
            assert!(scaled_least_eigenvalue(&found.s) > 0.0, "{}", found.s);
            found.gamma
        };
        let (one, two) = (gamma(&[1.0]), gamma(&[0.4, 2.0]));
        assert!(exact < two && two < 0.95 * one, "{one} {two}");
    }

    /// A slowly varying stiffness costs little more than a constant one, and more the faster it may vary; at rates near
    /// the frequency of the oscillator it can make the loop unstable, like one that jumps.
    #[test]
    fn a_slow_stiffness_lies_between_a_constant_one_and_one_that_jumps() {
        let exact = 1.0 / (2.0 * DAMPING);
        let gamma = |rate| oscillator(0.25, Some(rate)).bound(exact, 0.01, f64::INFINITY).unwrap().gamma;
        let (constant, slow, faster) = (gamma(0.0), gamma(0.01), gamma(0.3));
        assert!(exact < slow && slow < 1.02 * constant, "{constant} {slow}");
        assert!(1.2 * slow < faster, "{slow} {faster}");
        assert!(oscillator(0.25, Some(3.0)).bound(exact, 0.01, f64::INFINITY).is_err());
    }

    #[test]
    fn an_unstable_loop_has_no_bound() {
        let mut loop_ = oscillator(0.1, Some(0.0));
        loop_.closed.parts.block_mut(X, X).copy_from(&dmatrix![0.0, 1.0; -1.0, 0.2]);
        let error = loop_.bound(5.0, 0.01, f64::INFINITY).unwrap_err();
        assert!(matches!(error, SynthesisError::Numerical { stage: STAGE, .. }), "{error}");
        insta::assert_snapshot!(error);
    }
}
