//! The frequency interval on which scalings found at one frequency prove the bound.
//!
//! `Phi(omega) = b^2 D_w - M* D_z M - j (G M - M* G)` with `M = M(j omega)` is Hermitian and continuous in omega: if it
//! is positive definite at one frequency, it stays so up to the nearest frequency at which it is singular, and those
//! are imaginary eigenvalues of a Hamiltonian matrix: S. Boyd, V. Balakrishnan, P. Kabamba, Math. Control Signals
//! Systems 2, 1989; for mu P. M. Young, J. C. Doyle, M. P. Newlin, and G. Ferreres, J.-F. Magni, J.-M. Biannic, Int. J.
//! Robust Nonlinear Control 13, 2003.
//!
//! The Hamiltonian is formed in the variable `p = 1/(s - j omega_0)`, which maps the given frequency to infinity: the
//! matrix to be inverted is then Phi there, which is positive definite, and a singular `Phi(infinity)` is admissible.

use super::CMat;
use super::upper::DgScalings;
use crate::matrix::{Mat, complex_eigenvalues, hermitian_eigenvalues};
use crate::system::StateSpace;
use nalgebra::Complex;

/// The frequencies between which scalings prove a bound, rad/s; `to` may be infinite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// Lower end, at least 0.
    pub from: f64,
    /// Upper end.
    pub to: f64,
}

/// The length of a short interval, relative to a frequency.
const SHORT_RATIO: f64 = 0.2;

impl Interval {
    pub(super) fn is_short(&self, omega: f64) -> bool {
        self.to - self.from < SHORT_RATIO * omega
    }
}

/// The real part below which an eigenvalue is taken as imaginary, relative to the Hamiltonian: an error only shortens
/// intervals.
const AXIS_TOLERANCE: f64 = 1e-7;

/// The fraction of its length by which an interval is shortened at each end, so that Phi is not singular there.
const CUT_SHARE: f64 = 1e-6;

const J: Complex<f64> = Complex::new(0.0, 1.0);

/// Returns the frequency response of a system. p x m, at omega in rad/s; `D` at infinity.
pub fn response(system: &StateSpace, omega: f64) -> Option<CMat> {
    if omega.is_infinite() {
        Some(system.d.map(|v| v.into()))
    } else {
        system.response(Complex::new(0.0, omega))
    }
}

/// Returns the largest interval around `omega` (infinity included) on which `scalings` prove that mu is below `level`;
/// `None` if they do not at `omega`.
pub fn good_interval(system: &StateSpace, scalings: &DgScalings, level: f64, omega: f64) -> Option<Interval> {
    let here = AtFrequency::at(system, omega)?;
    let phi = here.form(scalings, level);
    if hermitian_eigenvalues(&phi).first().is_none_or(|least| *least <= 0.0) {
        return None;
    }
    if here.a.is_empty() {
        return Some(Interval { from: 0.0, to: f64::INFINITY });
    }
    let hamiltonian = here.hamiltonian(scalings, &phi)?;
    let axis = AXIS_TOLERANCE * hamiltonian.norm();
    let crossings = complex_eigenvalues(&hamiltonian)
        .into_iter()
        .filter(|p| p.re.is_nan() || p.re.abs() <= axis)
        .map(|p| p.im);
    let (mut from, mut to) = (f64::NEG_INFINITY, f64::INFINITY);
    if omega.is_infinite() {
        // p = s: the crossing farthest from zero decides.
        from = crossings.map(f64::abs).fold(0.0, f64::max) * (1.0 + CUT_SHARE);
    } else {
        // p = 1/(j (w - omega)): w = omega - 1/Im p.
        for q in crossings {
            if q > 0.0 {
                from = from.max(omega - 1.0 / q);
            } else if q < 0.0 {
                to = to.min(omega - 1.0 / q);
            } else if q.is_nan() {
                return None;
            } else {
                // The crossing is at least as far away as the inverse of the tolerance, on either side.
                from = from.max(omega - 1.0 / axis);
                to = to.min(omega + 1.0 / axis);
            }
        }
        from += CUT_SHARE * (omega - from);
        to -= CUT_SHARE * (to - omega);
        if from.is_infinite() || from.is_nan() {
            from = 0.0;
        }
        if to.is_nan() {
            to = f64::INFINITY;
        }
    }
    Some(Interval { from: from.max(0.0), to })
}

/// Returns a frequency inside a gap.
pub(super) fn middle(from: f64, to: f64) -> f64 {
    if from == 0.0 && to.is_infinite() {
        1.0
    } else if to.is_infinite() {
        // Infinity was tried before: approach it in steps.
        10.0 * from
    } else if from > 0.0 && to > 4.0 * from {
        (from * to).sqrt()
    } else {
        0.5 * (from + to)
    }
}

/// The covered intervals, ascending.
#[derive(Debug, Clone, Default)]
pub(super) struct Covered(Vec<Interval>);

impl Covered {
    /// Adds the interval around a frequency, unless it is too short; returns `true` if it was added.
    pub(super) fn add(&mut self, omega: f64, interval: Interval) -> bool {
        if omega.is_finite() && interval.to - interval.from < LEAST_INTERVAL * omega {
            return false;
        }
        self.0.push(interval);
        self.0.sort_by(|a, b| a.from.total_cmp(&b.from));
        true
    }

    /// Returns the number of intervals.
    pub(super) fn count(&self) -> usize {
        self.0.len()
    }

    /// Returns `true` if a frequency is covered; no interval covers infinity itself.
    pub(super) fn holds(&self, omega: f64) -> bool {
        omega.is_finite() && self.0.iter().any(|i| i.from <= omega && omega < i.to)
    }

    /// Returns the gap around an uncovered frequency.
    pub(super) fn around(&self, omega: f64) -> (f64, f64) {
        let below = self.0.iter().map(|i| i.to).filter(|to| *to <= omega).fold(0.0, f64::max);
        (below, self.0.iter().map(|i| i.from).filter(|from| *from > omega).fold(f64::INFINITY, f64::min))
    }

    /// Returns the lowest gap.
    pub(super) fn gap(&self) -> Option<(f64, f64)> {
        let mut reached = 0.0;
        for interval in &self.0 {
            if interval.from > reached {
                return Some((reached, interval.from));
            }
            reached = interval.to.max(reached);
        }
        (reached < f64::INFINITY).then_some((reached, f64::INFINITY))
    }
}

/// The length, relative to the frequency, below which intervals are ignored.
const LEAST_INTERVAL: f64 = 1e-12;

/// The system in the variable p.
struct AtFrequency {
    a: CMat,
    b: CMat,
    c: CMat,
    /// `M(j omega)`.
    d: CMat,
}

impl AtFrequency {
    fn at(system: &StateSpace, omega: f64) -> Option<Self> {
        let complex = |m: &Mat| m.map(|v| Complex::new(v, 0.0));
        let (a, b, c, d) = (complex(&system.a), complex(&system.b), complex(&system.c), complex(&system.d));
        if omega.is_infinite() || a.is_empty() {
            return Some(Self { a, b, c, d });
        }
        let n = a.nrows();
        let inverse = (a - CMat::identity(n, n) * (J * omega)).try_inverse()?;
        let (eb, ce) = (&inverse * &b, &c * &inverse);
        Some(Self { d: d - &c * &eb, a: inverse, b: eb, c: -ce })
    }

    /// Returns Phi at the frequency.
    fn form(&self, s: &DgScalings, level: f64) -> CMat {
        &s.dw * Complex::new(level * level, 0.0) - s.left(&self.d)
    }

    fn hamiltonian(&self, s: &DgScalings, phi: &CMat) -> Option<CMat> {
        let n = self.a.nrows();
        let q11 = -&s.dz;
        let q21 = &s.g * -J;
        let cross = (self.d.adjoint() * &q11 + q21) * &self.c;
        // Scaled to one before inversion: the determinant of a small matrix underflows.
        let size = phi.camax();
        let inverse = phi.unscale(size).try_inverse()?.unscale(size);
        let feedback = &inverse * &cross;
        let first = &self.a - &self.b * &feedback;
        let upper = -(&self.b * inverse * self.b.adjoint());
        let lower = cross.adjoint() * feedback - self.c.adjoint() * q11 * &self.c;
        // The unit of the costate is free: equalise both corners.
        let ratio = (lower.norm() / upper.norm()).sqrt();
        let ratio = Complex::new(if ratio > 0.0 && ratio.is_finite() { ratio } else { 1.0 }, 0.0);
        let mut out = CMat::zeros(2 * n, 2 * n);
        out.view_mut((0, 0), (n, n)).copy_from(&first);
        out.view_mut((0, n), (n, n)).copy_from(&(upper * ratio));
        out.view_mut((n, 0), (n, n)).copy_from(&(lower / ratio));
        out.view_mut((n, n), (n, n)).copy_from(&-first.adjoint());
        Some(out)
    }
}
