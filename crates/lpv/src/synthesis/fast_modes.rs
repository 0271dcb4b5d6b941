//! Fast modes that spoil the arithmetic: slowed down for the search, restored for the proof.
//!
//! ```text
//! x' = (P r + I - P) (A x + Bt wt + B1 w + B2 u)
//! ```
//!
//! P projects on the plant's fast modes and r < 1 slows them; their response at the other modes' frequencies stays
//! nearly the same, their static gain exactly. A controller for the slowed plant is one for the given plant up to terms
//! of the ratio of the two time scales, and so is its bound, with the Lyapunov matrix of the fast modes scaled by r.
//! The result is not relied on: the loop of the given plant is analysed, starting from that bound.
//!
//! Two time scales: P. V. Kokotovic, H. K. Khalil, J. O'Reilly, "Singular Perturbation Methods in Control", 1986,
//! chapter 7, for the Lyapunov function. The projector: J. D. Roberts, Int. J. Control 32(4), 1980, by the matrix
//! sign function.

use crate::analysis::gain_bound::GainBound;
use crate::matrix::{Mat, eigenvalues, solve, symmetric_part};
use crate::system::GeneralisedPlant;
use crate::system::Group::X;

/// A plant with its fast modes slowed down.
pub(crate) struct Slowed {
    pub(crate) plant: GeneralisedPlant,
    /// The projector P.
    projector: Mat,
    /// The factor r.
    ratio: f64,
}

/// The ratio between the fast modes and all others, before and after they are slowed.
const MODE_GAP: f64 = 1e3;

/// The ratio between successive trials.
const SLOWING_STEP: f64 = 1e-3;

/// Returns the plant with its fast modes slowed more and more, as long as they stay separate from the others. Empty if
/// no stable modes above the median are separate.
pub(crate) fn slowed(plant: &GeneralisedPlant) -> Vec<Slowed> {
    let Some((slow, fast)) = gap(&plant.a()) else { return Vec::new() };
    let Some(projector) = projector(&plant.a(), (slow * fast).sqrt()) else { return Vec::new() };
    let n = plant.a().nrows();
    let ratios = std::iter::successors(Some(SLOWING_STEP), |r| Some(r * SLOWING_STEP));
    let apart = ratios.take_while(|r| fast * r > MODE_GAP * slow);
    apart
        .map(|ratio| {
            let slower = Mat::identity(n, n) + &projector * (ratio - 1.0);
            let plant = plant.changed(|parts| parts.transformed(&[(X, &slower)], &[]));
            Slowed { plant, projector: projector.clone(), ratio }
        })
        .collect()
}

impl Slowed {
    /// Estimates the given plant's bound from that of the slowed plant's loop.
    pub(crate) fn restored(&self, bound: &GainBound) -> GainBound {
        let (n, size) = (self.projector.nrows(), bound.x.nrows());
        let mut rest = Mat::identity(size, size);
        rest.view_mut((0, 0), (n, n)).zip_apply(&self.projector, |v, p| *v -= p);
        let slow = rest.transpose() * &bound.x * &rest;
        let x = symmetric_part(&(&slow + (&bound.x - &slow) * self.ratio));
        GainBound { x, factor: None, ..bound.clone() }
    }
}

/// Returns the fastest of the other modes and the slowest of the fast ones, rad/s; the fast ones must be well damped.
fn gap(a: &Mat) -> Option<(f64, f64)> {
    let mut modes = eigenvalues(a);
    modes.sort_by(|one, other| one.norm().total_cmp(&other.norm()));
    let above = modes.len().div_ceil(2).max(1)..modes.len();
    let (at, slow, fast) = above
        .filter_map(|k| Some((k, modes.get(k - 1)?.norm(), modes.get(k)?.norm())))
        .find(|(_, slow, fast)| *slow > 0.0 && *fast > MODE_GAP / SLOWING_STEP * slow)?;
    let decay = modes.iter().skip(at).all(|mode| mode.re < -0.5 * mode.norm());
    (decay && fast.is_finite()).then_some((slow, fast))
}

/// Returns the projector on the modes left of `-rate`, along the others.
pub(crate) fn projector(a: &Mat, rate: f64) -> Option<Mat> {
    let unit = Mat::identity(a.nrows(), a.nrows());
    let mut sign = a / rate + &unit;
    for _ in 0..MOST_ITERATIONS {
        let inverse = solve(&sign, &unit)?;
        let scale = (inverse.norm() / sign.norm()).sqrt();
        let next = (&sign * scale + inverse / scale) * 0.5;
        let change = (&next - &sign).norm();
        sign = next;
        if change <= SIGN_TOLERANCE * sign.norm() {
            return Some((unit - sign) * 0.5);
        }
    }
    None
}

/// The largest number of Newton steps: about the bits of the ratio of the modes, far fewer with scaling.
const MOST_ITERATIONS: usize = 100;

/// The relative change of the sign function at convergence.
const SIGN_TOLERANCE: f64 = 1e-10;

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dmatrix;

    #[test]
    fn only_the_fast_mode_is_slowed_and_the_static_gain_is_kept() {
        let a = dmatrix![-1.0, 2.0, 3.0; 0.0, -2.0, 0.0; -4e9, 0.0, -1e10];
        let rate = 1e5;
        let p = projector(&a, rate).unwrap();
        assert!((&p * &p - &p).amax() < 1e-9);
        assert!((p.trace() - 1.0).abs() < 1e-9);
        let slower = (Mat::identity(3, 3) + &p * (1e-3 - 1.0)) * &a;
        let mut modes: Vec<f64> = eigenvalues(&slower).iter().map(|m| m.re).collect();
        modes.sort_by(f64::total_cmp);
        assert!((modes[0] / -1e7 - 1.0).abs() < 1e-6, "{modes:?}");
        // x_3 = -0.4 x_1 at steady state, which leaves -2.2 in the first row.
        assert!(modes[1..].iter().zip([-2.2, -2.0]).all(|(m, e)| (m - e).abs() < 1e-6), "{modes:?}");
        let b = dmatrix![1.0; 0.5; 1e10];
        let gain = |a: &Mat, b: &Mat| solve(a, b).unwrap();
        let slowed_b = (Mat::identity(3, 3) + &p * (1e-3 - 1.0)) * &b;
        assert!((gain(&a, &b) - gain(&slower, &slowed_b)).amax() < 1e-6);
    }

    #[test]
    fn a_gap_is_found_only_above_the_median() {
        assert_eq!(gap(&dmatrix![-1.0, 0.0; 0.0, -1e8]), Some((1.0, 1e8)));
        // Neither a fast oscillation, nor an unstable mode, nor one slow mode makes a gap.
        assert_eq!(gap(&dmatrix![-1.0, 0.0; 0.0, 1e8]), None);
        assert_eq!(gap(&dmatrix![-1.0, 0.0, 0.0; 0.0, -1.0, 1e8; 0.0, -1e8, -1.0]), None);
        assert_eq!(gap(&dmatrix![-1e-8, 0.0, 0.0; 0.0, -1.0, 0.0; 0.0, 0.0, -2.0]), None);
        assert_eq!(gap(&Mat::zeros(0, 0)), None);
    }
}
