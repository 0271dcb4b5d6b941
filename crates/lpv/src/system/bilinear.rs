//! The bilinear transform between discrete and continuous time.
//!
//! ```text
//! s = 2/T (z - 1)/(z + 1)
//! x+ = F x + G v,  e = H x + J v     <->     x' = A x + B v,  e = C x + D v
//! A = 2/T (F - I) (F + I)^-1,   B = r (F + I)^-1 G,   C = r H (F + I)^-1,   D = J - H (F + I)^-1 G,   r = 2/sqrt(T)
//! ```
//!
//! It maps the unit disc to the left half plane, so it keeps stability and gains, and with these B and C also the
//! Lyapunov matrices: with the state `m = (x + x+)/r`, `x+'X x+ - x'X x = 2 m'X m'`. The signals v and e include the
//! parameter channels and the controls, and a loop may be closed before or after the transform. If F has an eigenvalue
//! at or near -1, z is replaced by -z: each signal changes its sign at every other sample.
//!
//! Source: K. Zhou, J. C. Doyle, K. Glover, Robust and Optimal Control, 1996, section 21.5.

use crate::matrix::{Mat, solve, svd};
use crate::system::StateSpace;

/// The largest ratio of the least to the largest singular value of a matrix that is taken as singular.
const SINGULAR: f64 = 1e-10;

/// The bilinear transform for a given system matrix and sample time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bilinear {
    sample_time: f64,
    /// -1 if z is replaced by -z.
    sign: f64,
}

impl Bilinear {
    /// Returns the transform for systems with this F, n x n, at the sample time T > 0 (s); `None` if F has eigenvalues
    /// at both 1 and -1, to rounding.
    pub fn of(f: &Mat, sample_time: f64) -> Option<Self> {
        let one = Mat::identity(f.nrows(), f.nrows());
        let conditioning = |sign: f64| least_ratio(&(f * sign + &one), 1.0);
        let (plain, mirrored) = (conditioning(1.0), conditioning(-1.0));
        let sign = if plain >= mirrored { 1.0 } else { -1.0 };
        (plain.max(mirrored) > SINGULAR).then_some(Self { sample_time, sign })
    }

    /// Converts a discrete-time system, `(F, G, H, J)` for (A, B, C, D), to continuous time.
    ///
    /// `None` if F has an eigenvalue that the transform maps to infinity.
    pub fn continuous(&self, system: &StateSpace) -> Option<StateSpace> {
        let StateSpace { a: f, b: g, c: h, d: j } = system;
        let one = Mat::identity(f.nrows(), f.nrows());
        let back = solve(&(f * self.sign + &one), &one)?;
        let (rate, root) = (2.0 / self.sample_time, 2.0 / self.sample_time.sqrt());
        let g = &back * g * self.sign;
        Some(StateSpace { a: (one - &back * 2.0) * rate, b: &g * root, c: h * &back * root, d: j - h * g })
    }

    /// Converts a continuous-time system to discrete time, `(F, G, H, J)` for (A, B, C, D).
    ///
    /// `None` if A has an eigenvalue at 2/T, to rounding.
    pub fn discrete(&self, system: &StateSpace) -> Option<StateSpace> {
        let StateSpace { a, b, c, d } = system;
        let one = Mat::identity(a.nrows(), a.nrows());
        let (rate, root) = (2.0 / self.sample_time, 2.0 / self.sample_time.sqrt());
        let ahead = &one * rate - a;
        let back = (least_ratio(&ahead, rate) > SINGULAR).then(|| solve(&ahead, &one))??;
        let b = &back * b;
        Some(StateSpace {
            a: (&back * (2.0 * rate) - one) * self.sign,
            b: &b * (root * self.sign),
            c: c * &back * root,
            d: d + c * b,
        })
    }

    /// Returns the discrete-time frequency (rad/s) of a continuous-time one.
    pub fn frequency(&self, continuous: f64) -> f64 {
        let angle = 2.0 * (0.5 * continuous * self.sample_time).atan();
        (if self.sign > 0.0 { angle } else { std::f64::consts::PI - angle }) / self.sample_time
    }
}

/// Returns the least singular value over the larger of `unit` and the largest; 1 for an empty matrix.
fn least_ratio(m: &Mat, unit: f64) -> f64 {
    let values = svd(m).s;
    values.first().zip(values.last()).map_or(1.0, |(largest, least)| least / largest.max(unit))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Complex, dmatrix};
    use proptest::prelude::*;

    const TICK: f64 = 0.2;

    fn system(f: Mat) -> StateSpace {
        let g = dmatrix![0.3, -1.0; 2.0, 0.1];
        StateSpace { a: f, b: g, c: dmatrix![1.0, 0.4], d: dmatrix![0.2, -0.5] }
    }

    proptest! {
        /// The responses agree on the unit circle, with either sign, and the inverse restores the system.
        #[test]
        fn the_frequency_response_is_kept(entries in prop::collection::vec(-1.5..1.5, 4), angle in 0.01..3.1_f64) {
            let given = system(Mat::from_vec(2, 2, entries));
            let map = Bilinear::of(&given.a, TICK).unwrap();
            let continuous = map.continuous(&given).unwrap();
            let z = Complex::from_polar(1.0, angle);
            let s = (z * map.sign - 1.0) / (z * map.sign + 1.0) * (2.0 / TICK);
            let (near, far) =
                (continuous.response(s).unwrap(), given.response(z).unwrap());
            let size = far.iter().map(|v| v.norm()).fold(1.0, f64::max);
            prop_assert!((&near - &far).iter().all(|v| v.norm() < 1e-6 * size), "{near} {far}");
            prop_assert!((map.frequency(s.im.abs()) * TICK - angle).abs() < 1e-9);
            let back = map.discrete(&continuous).unwrap();
            prop_assert!((&back.a - &given.a).amax() < 1e-6 && (&back.b - &given.b).amax() < 1e-6);
        }
    }

    #[test]
    fn eigenvalues_at_both_1_and_minus_1_have_no_transform() {
        assert_eq!(Bilinear::of(&dmatrix![1.0, 0.0; 0.0, -1.0], TICK), None);
        assert_eq!(Bilinear::of(&dmatrix![-1.0, 0.1; 0.0, 0.9], TICK).unwrap().sign, -1.0);
        assert_eq!(Bilinear::of(&Mat::zeros(0, 0), TICK).unwrap().sign, 1.0);
        let map = Bilinear::of(&dmatrix![0.5], TICK).unwrap();
        assert_eq!(map.discrete(&StateSpace { a: dmatrix![2.0 / TICK], ..system(Mat::zeros(1, 1)) }), None);
    }
}
