//! Matrices that are polynomials in one scheduling parameter, fitted to samples.

use crate::error::SystemError;
use crate::matrix::Mat;

/// `M(rho) = sum_k rho^k M_k`, coefficients in ascending order of power.
#[derive(Debug, Clone, PartialEq)]
pub struct MatrixPolynomial {
    /// `M_0, M_1, ...`, all of one shape, at least one.
    pub coefficients: Vec<Mat>,
}

/// The error of a fit at samples.
#[derive(Debug, Clone, PartialEq)]
pub struct FitResidual {
    /// The largest absolute difference of each entry over the samples.
    pub largest: Mat,
    /// `sqrt(sum |M(rho_i) - M_i|^2 / sum |M_i|^2)` over all entries and samples.
    pub relative_rms: f64,
    /// The largest singular value of `M(rho_i) - M_i` at each sample.
    pub norms: Vec<f64>,
}

impl MatrixPolynomial {
    /// Fits the samples `(rho_i, M_i)` by least squares, entry by entry.
    ///
    /// The Vandermonde matrix is solved by its SVD, not by the normal equations; the caller has normalised the
    /// parameter to [-1, 1].
    ///
    /// # Errors
    /// Returns an error for fewer distinct samples than coefficients, or samples of different shapes.
    pub fn fit(samples: &[(f64, Mat)], order: usize) -> Result<Self, SystemError> {
        let shape = Self::determined(samples, order)?;
        let vandermonde = Mat::from_fn(samples.len(), order + 1, |i, k| samples[i].0.powi(k as i32));
        let values = Mat::from_fn(samples.len(), shape.0 * shape.1, |i, e| samples[i].1[e]);
        let solution = crate::matrix::pseudo_inverse(&vandermonde, 1e-13) * values;
        let coefficients = solution
            .row_iter()
            .map(|row| Mat::from_iterator(shape.0, shape.1, row.iter().copied()))
            .collect();
        Ok(Self { coefficients })
    }

    /// Returns the shape of the samples, if there are enough for `order + 1` coefficients.
    pub(crate) fn determined(samples: &[(f64, Mat)], order: usize) -> Result<(usize, usize), SystemError> {
        let shape = samples.first().map(|(_, m)| m.shape()).ok_or(SystemError::NoSamples)?;
        if let Some((rho, other)) = samples.iter().find(|(_, m)| m.shape() != shape) {
            return Err(SystemError::UnlikeShapes { rho: *rho, expected: shape, found: other.shape() });
        }
        let mut distinct: Vec<f64> = samples.iter().map(|(rho, _)| *rho).collect();
        distinct.sort_by(f64::total_cmp);
        distinct.dedup();
        if distinct.len() <= order {
            return Err(SystemError::TooFewSamples { samples: distinct.len(), order });
        }
        Ok(shape)
    }

    /// Returns the order: one less than the number of coefficients.
    pub fn order(&self) -> usize {
        self.coefficients.len() - 1
    }

    /// Returns `M(rho)`, by Horner's rule. p x m.
    pub fn evaluate(&self, rho: f64) -> Mat {
        let mut terms = self.coefficients.iter().rev();
        let Some(highest) = terms.next() else { return Mat::zeros(0, 0) };
        terms.fold(highest.clone(), |sum, m| sum * rho + m)
    }

    /// Returns the residual against samples, not necessarily those of the fit.
    pub fn residual(&self, samples: &[(f64, Mat)]) -> FitResidual {
        let (rows, cols) = self.coefficients[0].shape();
        let mut largest = Mat::zeros(rows, cols);
        let (mut wrong, mut total) = (0.0, 0.0);
        let mut norms = Vec::with_capacity(samples.len());
        for (rho, sample) in samples {
            let difference = self.evaluate(*rho) - sample;
            wrong += difference.norm_squared();
            total += sample.norm_squared();
            norms.push(crate::matrix::largest_singular_value(&difference));
            largest.zip_apply(&difference, |most, d| *most = f64::max(*most, d.abs()));
        }
        let relative_rms = if total > 0.0 { (wrong / total).sqrt() } else { 0.0 };
        FitResidual { largest, relative_rms, norms }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dmatrix;

    #[test]
    fn an_exact_polynomial_is_recovered() {
        let truth = MatrixPolynomial {
            coefficients: vec![
                dmatrix![1.0, 2.0; 3.0, 4.0],
                dmatrix![0.0, -1.0; 0.5, 2.0],
                dmatrix![7.0, 0.0; 0.0, 1.0],
            ],
        };
        let samples: Vec<_> = (0..7).map(|i| i as f64 / 3.0 - 1.0).map(|r| (r, truth.evaluate(r))).collect();
        let fit = MatrixPolynomial::fit(&samples, 2).unwrap();
        for (found, expected) in fit.coefficients.iter().zip(&truth.coefficients) {
            assert!((found - expected).amax() < 1e-12);
        }
        assert!(fit.residual(&samples).relative_rms < 1e-13);
    }

    #[test]
    fn two_samples_do_not_determine_a_parabola() {
        let samples = vec![(0.0, dmatrix![1.0]), (1.0, dmatrix![2.0]), (1.0, dmatrix![2.0])];
        assert_eq!(
            MatrixPolynomial::fit(&samples, 2),
            Err(SystemError::TooFewSamples { samples: 2, order: 2 })
        );
    }
}
