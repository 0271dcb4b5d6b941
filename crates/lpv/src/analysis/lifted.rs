//! A continuous-time system over one sample, as a discrete-time system with the same worst-case input.
//!
//! ```text
//! x' = A x + B w,  z = C x + D w     over [0, T], at a level above ||D||; B and D in units in which the level is 1
//!
//! max over w of  int |z|^2 - |w|^2 dt  between x(0) and x(T)  is  x(0)'H x(0) - |v|^2,   x(T) = F x(0) + G^(1/2) v
//! ```
//!
//! F, G and H are the blocks of the scattering matrix of the Hamiltonian system of w, from (x(0), p(T)) to (x(T),
//! p(0)). They are computed by doubling the time and stay of the size of the system's response, while the exponential
//! of the Hamiltonian matrix over a sample grows with the fastest lag.
//!
//! Sources: B. Bamieh, J. B. Pearson, IEEE Trans. Automatic Control 37(4), 1992; R. Redheffer, J. Math. and Phys. 39,
//! 1960 (the star product).

use crate::error::SystemError;
use crate::matrix::{Mat, block, eigenvalues, solve, symmetric_function, symmetric_part};
use crate::system::StateSpace;

/// The matrices F, G and H of the module.
#[derive(Debug, Clone)]
pub(crate) struct Lifted {
    f: Mat,
    g: Mat,
    h: Mat,
}

/// The largest size of the Hamiltonian matrix times the first interval, at which its blocks are far from singular.
const SMALL: f64 = 0.25;

/// The largest number of doublings; each doubles the rounding, to about 1e-7 at this number.
const MOST_DOUBLINGS: f64 = 30.0;

impl Lifted {
    /// Returns the system over a time, at a level; `None` if the level is not above the gain over that time from rest.
    ///
    /// # Errors
    /// Returns [`SystemError::Stiff`].
    pub(crate) fn over(system: &StateSpace, time: f64, level: f64) -> Result<Option<Self>, SystemError> {
        let Some((hamiltonian, unit)) = hamiltonian(system, level) else { return Ok(None) };
        let size = hamiltonian.row_iter().map(|row| row.lp_norm(1)).fold(0.0, f64::max) * time;
        let doublings = (size / SMALL).log2().ceil().max(0.0);
        if doublings.is_nan() || doublings > MOST_DOUBLINGS {
            return Err(SystemError::Stiff { size });
        }
        let n = system.a.nrows();
        let e = (hamiltonian * (time * (-doublings).exp2())).exp();
        let part = |i: usize, j: usize| e.view((i * n, j * n), (n, n)).into_owned();
        let Some(f) = solve(&part(1, 1), &Mat::identity(n, n)) else {
            return Err(SystemError::Stiff { size });
        };
        let (g, h) = (symmetric_part(&(part(0, 1) * &f)), symmetric_part(&-(&f * part(1, 0))));
        let first = Self { f: f.transpose(), g, h };
        let total = (0..doublings as usize).try_fold(first, |all, _| all.twice());
        Ok(total.map(|all| Self { g: all.g * unit, h: all.h / unit, ..all }))
    }

    /// Returns the system over twice the time. It exists if `G H` has no eigenvalue of 1 or more.
    fn twice(&self) -> Option<Self> {
        let Self { f, g, h } = self;
        let n = f.nrows();
        let gh = g * h;
        let norm = g.norm() * h.norm();
        if norm.is_nan() || (norm >= 1.0 && eigenvalues(&gh).iter().any(|v| v.re.is_nan() || v.re >= 1.0)) {
            return None;
        }
        // (I - G H)^-1 [F, G F'].
        let both = solve(&(Mat::identity(n, n) - gh), &block(&[&[f, &(g * f.transpose())]]))?;
        let (through, back) = (both.columns(0, n), both.columns(n, n));
        Some(Self {
            f: f * through,
            g: g + symmetric_part(&(f * back)),
            h: h + symmetric_part(&(f.transpose() * h * through)),
        })
    }

    /// Returns the discrete-time system `x+ = F x + G^(1/2) v` with the outputs `H^(1/2) x`.
    pub(crate) fn system(&self) -> StateSpace {
        let root = |m: &Mat| symmetric_function(m, |v| v.max(0.0).sqrt());
        let n = self.f.nrows();
        StateSpace { a: self.f.clone(), b: root(&self.g), c: root(&self.h), d: Mat::zeros(n, n) }
    }
}

/// Returns `[A + B R D'C, B R B'; -C'(I + D R D')C, -(A + B R D'C)']`, `R = (I - D'D)^-1`, with B and D in units of the
/// level, and the unit of energy that equalises its upper and lower block; `None` if D reaches the level.
fn hamiltonian(system: &StateSpace, level: f64) -> Option<(Mat, f64)> {
    let (a, c) = (&system.a, &system.c);
    let (b, d) = (&system.b / level, &system.d / level);
    let (m, p) = (b.ncols(), c.nrows());
    let r = (Mat::identity(m, m) - d.transpose() * &d).cholesky()?.inverse();
    let a = a + &b * &r * d.transpose() * c;
    let inner = symmetric_part(&(Mat::identity(p, p) + &d * &r * d.transpose()));
    let (upper, lower) = (&b * &r * b.transpose(), c.transpose() * inner * c);
    let size = |m: &Mat| m.norm().max(f64::MIN_POSITIVE);
    let unit = (size(&upper) / size(&lower)).sqrt().clamp(1e-30, 1e30);
    Some((block(&[&[&a, &(upper / unit)], &[&(lower * -unit), &-a.transpose()]]), unit))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dmatrix;

    /// The Hamiltonian system of x' = w, z = x is an oscillator of frequency 1/level, so F = 1/cos, G = tan/level and H
    /// = level tan of T/level, up to a quarter of its period.
    #[test]
    fn an_integrator_has_its_closed_form() {
        let integrator =
            StateSpace { a: dmatrix![0.0], b: dmatrix![1.0], c: dmatrix![1.0], d: dmatrix![0.0] };
        for (time, level) in [(0.75, 0.5), (0.02, 3.0), (1.5, 1.0)] {
            let lifted = Lifted::over(&integrator, time, level).unwrap().unwrap();
            let angle: f64 = time / level;
            let expected = [1.0 / angle.cos(), angle.tan() / level, angle.tan() * level];
            for (found, expected) in [lifted.f[0], lifted.g[0], lifted.h[0]].iter().zip(expected) {
                assert!((found - expected).abs() < 1e-10 * expected, "{found} {expected}");
            }
        }
        assert!(Lifted::over(&integrator, 1.6, 1.0).unwrap().is_none());
    }

    /// F, G and H are at their limits for a lag much shorter than the sample: e^(T/lag) is 1e434. For one lag of gain 1
    /// at the level sqrt 2 the worst-case input has the mode `a = 1/(sqrt 2 lag)`, F is 0, and both G and H solve their
    /// Riccati equations: `G^2 - 2 G + 1/2 = 0` in units of the lag, and H = 2 G.
    #[test]
    fn a_lag_much_shorter_than_the_sample_has_its_limits() {
        let lag = 1e-3;
        let system = StateSpace {
            a: dmatrix![-1.0 / lag],
            b: dmatrix![1.0 / lag],
            c: dmatrix![1.0],
            d: dmatrix![0.0],
        };
        let lifted = Lifted::over(&system, 1.0, 2f64.sqrt()).unwrap().unwrap();
        let root = 1.0 - 0.5f64.sqrt();
        assert!(lifted.f[0].abs() < 1e-100);
        assert!((lifted.h[0] - 2.0 * root * lag).abs() < 1e-12 * lag, "{lifted:?}");
        assert!((lifted.g[0] * lag - root).abs() < 1e-12, "{lifted:?}");
    }
}
