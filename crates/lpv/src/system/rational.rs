//! Matrices that are rational functions of one parameter, with one denominator for all entries, fitted to samples.
//!
//! Sources: E. C. Levy, IRE Trans. Automatic Control 4(1), 1959 (the equation multiplied by the denominator is linear
//! in all coefficients); C. K. Sanathanan, J. Koerner, IEEE Trans. Automatic Control 8(1), 1963 (weights by the
//! previous denominator undo the multiplication).

use crate::error::SystemError;
use crate::matrix::{Mat, pseudo_inverse};
use crate::system::MatrixPolynomial;

/// `M(rho) = N(rho)/d(rho)`, `d(rho) = 1 + d_1 rho + ... + d_q rho^q`.
#[derive(Debug, Clone, PartialEq)]
pub struct MatrixRational {
    /// The numerator N.
    pub numerator: MatrixPolynomial,
    /// `d_1, ..., d_q`; none for a polynomial.
    pub denominator: Vec<f64>,
}

/// Number of reweightings: far more than needed for convergence.
const ITERATIONS: usize = 20;

/// The fraction of the largest below which singular values of the equations are taken as zero.
const RANK_TOLERANCE: f64 = 1e-13;

impl MatrixRational {
    /// Fits the samples `(rho_i, M_i)` by least squares with a numerator of degree `order` and a denominator of degree
    /// `poles`, at most `order`: the coefficients minimise
    ///
    /// ```text
    /// sum_i |N(rho_i) - d(rho_i) M_i|^2 / e(rho_i)^2
    /// ```
    ///
    /// where e is the denominator of the previous iteration, initially 1. The parameter should be normalised to \[-1,
    /// 1\], and entries scaled to comparable size. The result is the iterate with the least error at the samples; the
    /// caller checks the location of its poles.
    ///
    /// # Errors
    /// Returns an error for fewer distinct samples than coefficients of an entry and the denominator, or samples of
    /// different shapes.
    pub fn fit(samples: &[(f64, Mat)], order: usize, poles: usize) -> Result<Self, SystemError> {
        debug_assert!(poles <= order);
        let polynomial = MatrixPolynomial::fit(samples, order)?;
        if poles == 0 {
            return Ok(Self { numerator: polynomial, denominator: vec![] });
        }
        MatrixPolynomial::determined(samples, order + poles)?;
        let shape = polynomial.coefficients[0].shape();
        let mut best = (f64::INFINITY, Self { numerator: polynomial, denominator: vec![] });
        let mut weights = vec![1.0; samples.len()];
        for _ in 0..ITERATIONS {
            let next = Self::weighted(samples, &weights, order, poles, shape);
            weights = samples.iter().map(|(rho, _)| 1.0 / next.divisor(*rho)).collect();
            let missed: f64 = samples.iter().map(|(rho, m)| (next.evaluate(*rho) - m).norm_squared()).sum();
            if !weights.iter().all(|w| w.is_finite()) {
                break;
            }
            if missed < best.0 {
                best = (missed, next);
            }
        }
        Ok(best.1)
    }

    /// Solves the linear least squares of one iteration; the unknowns are the entries of N, power by power, then d.
    fn weighted(
        samples: &[(f64, Mat)],
        weights: &[f64],
        order: usize,
        poles: usize,
        shape: (usize, usize),
    ) -> Self {
        let (rows, columns) = shape;
        let size = rows * columns;
        let first = size * (order + 1);
        let mut left = Mat::zeros(samples.len() * size, first + poles);
        let mut right = Mat::zeros(samples.len() * size, 1);
        for (i, ((rho, m), weight)) in samples.iter().zip(weights).enumerate() {
            for (e, value) in m.iter().enumerate() {
                let row = i * size + e;
                (0..=order).for_each(|k| left[(row, k * size + e)] = weight * rho.powi(k as i32));
                (1..=poles).for_each(|k| left[(row, first + k - 1)] = -weight * value * rho.powi(k as i32));
                right[(row, 0)] = weight * value;
            }
        }
        let solution = pseudo_inverse(&left, RANK_TOLERANCE) * right;
        let of_power =
            |k: usize| Mat::from_column_slice(rows, columns, &solution.as_slice()[k * size..][..size]);
        Self {
            numerator: MatrixPolynomial { coefficients: (0..=order).map(of_power).collect() },
            denominator: solution.as_slice()[first..].to_vec(),
        }
    }

    /// Returns `d(rho)`.
    pub fn divisor(&self, rho: f64) -> f64 {
        1.0 + self.denominator.iter().rev().fold(0.0, |sum, d| (sum + d) * rho)
    }

    /// Returns `M(rho)`. p x m.
    pub fn evaluate(&self, rho: f64) -> Mat {
        self.numerator.evaluate(rho) / self.divisor(rho)
    }

    /// Returns the first `count` coefficients of the series of M in rho.
    pub fn series(&self, count: usize) -> Vec<Mat> {
        let (rows, columns) = self.numerator.coefficients[0].shape();
        let mut all: Vec<Mat> = Vec::with_capacity(count);
        for k in 0..count {
            let constant = self.numerator.coefficients.get(k).cloned();
            let constant = constant.unwrap_or_else(|| Mat::zeros(rows, columns));
            let next =
                self.denominator.iter().zip(all.iter().rev()).fold(constant, |sum, (d, m)| sum - m * *d);
            all.push(next);
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::matrix::{eigenvalues, largest};
    use crate::system::lft::Lft;
    use nalgebra::dmatrix;

    fn sampled(truth: &MatrixRational, count: usize) -> Vec<(f64, Mat)> {
        let rho = |i: usize| 2.0 * i as f64 / (count - 1) as f64 - 1.0;
        (0..count).map(|i| (rho(i), truth.evaluate(rho(i)))).collect()
    }

    /// Returns `1/(rho + 1.6)` and a pair of poles at `+-1.5 j`, in two entries.
    fn truth() -> MatrixRational {
        let coefficients =
            vec![dmatrix![1.0; 0.3], dmatrix![0.5; -2.0], dmatrix![0.0; 1.0], dmatrix![0.1; 0.7]];
        // (1 + rho/1.6) (1 + rho^2/2.25)
        let (a, b) = (1.0 / 1.6, 1.0 / 2.25);
        MatrixRational { numerator: MatrixPolynomial { coefficients }, denominator: vec![a, b, a * b] }
    }

    #[test]
    fn an_exact_rational_function_is_recovered() {
        let truth = truth();
        let fit = MatrixRational::fit(&sampled(&truth, 15), 3, 3).unwrap();
        for (found, expected) in fit.denominator.iter().zip(&truth.denominator) {
            assert!((found - expected).abs() < 1e-9, "{:?}", fit.denominator);
        }
        for i in 0..=50 {
            let rho = f64::from(i) / 25.0 - 1.0;
            assert!((fit.evaluate(rho) - truth.evaluate(rho)).amax() < 1e-10);
        }
    }

    /// The weights of Sanathanan and Koerner improve on Levy's step for a function outside the class.
    #[test]
    fn reweighting_reduces_the_error() {
        let far = |m: &MatrixRational, samples: &[(f64, Mat)]| -> f64 {
            samples.iter().map(|(rho, v)| (m.evaluate(*rho) - v).norm_squared()).sum()
        };
        let cube = |rho: f64| (rho, dmatrix![1.0 / (rho + 1.3_f64).powi(3)]);
        let samples: Vec<(f64, Mat)> = (0..40).map(|i| cube(f64::from(i) / 19.5 - 1.0)).collect();
        let levy = MatrixRational::weighted(&samples, &[1.0; 40], 1, 1, (1, 1));
        let fit = MatrixRational::fit(&samples, 1, 1).unwrap();
        let polynomial = MatrixRational::fit(&samples, 1, 0).unwrap();
        assert!(far(&fit, &samples) < 0.1 * far(&levy, &samples));
        assert!(far(&fit, &samples) < 0.1 * far(&polynomial, &samples));
        assert!(polynomial.denominator.is_empty());
    }

    #[test]
    fn its_lft_has_as_many_channels_as_the_order() {
        let truth = truth();
        let lft = Lft::from_rational(&truth, 1e-12);
        assert_eq!(lft.size(), 3);
        for rho in [-1.0, -0.3, 0.0, 0.55, 1.0] {
            assert!((lft.evaluate(&[rho]).unwrap() - truth.evaluate(rho)).amax() < 1e-10);
        }
        // Poles are the inverse eigenvalues.
        let fastest = largest(0.0, eigenvalues(&lft.inner).iter().map(|v| v.norm()));
        assert!((1.0 / fastest - 1.5).abs() < 1e-8, "the nearest pole is {}", 1.0 / fastest);
    }

    #[test]
    fn too_few_samples_are_rejected() {
        let samples = sampled(&truth(), 6);
        let expected = SystemError::TooFewSamples { samples: 6, order: 6 };
        assert_eq!(MatrixRational::fit(&samples, 3, 3), Err(expected));
        assert!(MatrixRational::fit(&samples, 3, 2).is_ok());
        assert_eq!(MatrixRational::fit(&[], 1, 1), Err(SystemError::NoSamples));
    }
}
