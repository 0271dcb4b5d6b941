//! Eigenvalues of `M Q`, and their derivatives with respect to Q.

use super::annihilated::annihilated;
use crate::matrix::{ComplexVector, complex_eigenvalues};
use crate::mu::CMat;
use crate::mu::structure::{Block, Structure};
use crate::mu::upper::product::product;
use nalgebra::Complex;
use std::ops::Range;

/// An eigenvalue of `M Q`, and `M* u` and v, with `u* v = 1`: `d lambda = (M* u)* dQ v`.
#[derive(Clone)]
pub(super) struct Mode {
    pub(super) lambda: Complex<f64>,
    pub(super) x: ComplexVector,
    pub(super) v: ComplexVector,
}

/// A block with its entries of w and of z.
pub(super) type Conditioning = (Block, Range<usize>, Range<usize>);

/// A matrix M and the structure of Q.
pub(super) struct Modes<'a> {
    pub(super) m: &'a CMat,
    pub(super) structure: &'a Structure,
    pub(super) places: Vec<Conditioning>,
}

impl<'a> Modes<'a> {
    pub(super) fn new(m: &'a CMat, structure: &'a Structure) -> Self {
        Self { m, structure, places: structure.places() }
    }

    /// Returns the finite eigenvalues of `M Q`.
    pub(super) fn eigenvalues(&self, q: &CMat) -> Vec<Complex<f64>> {
        let all = complex_eigenvalues(&product(self.m, q));
        all.into_iter().filter(|v| v.re.is_finite() && v.im.is_finite()).collect()
    }

    /// Returns the eigenvalue of the highest rank.
    pub(super) fn best(&self, q: &CMat, rank: impl Fn(Complex<f64>) -> f64) -> Option<Mode> {
        let lambda = self.eigenvalues(q).into_iter().max_by(|a, b| rank(*a).total_cmp(&rank(*b)))?;
        self.mode(q, lambda)
    }

    /// Returns the eigenvalue closest to a number.
    pub(super) fn nearest(&self, q: &CMat, to: Complex<f64>) -> Option<Mode> {
        self.best(q, |v| -(v - to).norm())
    }

    fn mode(&self, q: &CMat, lambda: Complex<f64>) -> Option<Mode> {
        let n = self.m.nrows();
        let (u, v) = annihilated(product(self.m, q) - CMat::identity(n, n) * lambda)?;
        let product = u.dotc(&v);
        if product.norm() < 1e-12 {
            return None;
        }
        Some(Mode { lambda, x: self.m.adjoint() * u / product.conj(), v })
    }

    /// Returns Q with each block moved to the value at which the eigenvalue grows most in the direction `direction`.
    pub(super) fn aimed(&self, q: &CMat, mode: &Mode, direction: Complex<f64>) -> CMat {
        self.structure.replaced(q.clone(), |block, rows, cols| {
            let x = mode.x.rows(rows.start, rows.len());
            let v = mode.v.rows(cols.start, cols.len());
            let slope = || direction.conj() * x.dotc(&v);
            let unit = |r: usize, value: Complex<f64>| CMat::identity(r, r) * value;
            Some(match block {
                Block::Real(r) if slope().re != 0.0 => unit(r, Complex::new(slope().re.signum(), 0.0)),
                Block::Complex(r) if slope().norm() > 0.0 => unit(r, slope().conj() / slope().norm()),
                Block::Full { .. } if x.norm() > 0.0 && v.norm() > 0.0 => {
                    x.unscale(x.norm()) * v.unscale(v.norm()).adjoint() * direction
                }
                _ => return None,
            })
        })
    }

    /// Returns the first-order change of the eigenvalue for a change of Q.
    pub(super) fn change(&self, mode: &Mode, by: &CMat) -> Complex<f64> {
        mode.x.dotc(&(by * &mode.v))
    }
}
