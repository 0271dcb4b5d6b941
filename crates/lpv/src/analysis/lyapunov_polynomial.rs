//! Lyapunov matrices that are polynomials in the parameter.

use crate::matrix::Mat;

/// A symmetric matrix that is a polynomial: `X(theta) = sum_k s^k X_k`, `s = (theta - centre)/half_range`.
#[derive(Debug, Clone, PartialEq)]
pub struct LyapunovPolynomial {
    /// The middle of the samples.
    pub centre: f64,
    /// Distance from the middle to the last sample (1 if there is only one).
    pub half_range: f64,
    /// Coefficients `X_0, ..., X_d`, n x n.
    pub coefficients: Vec<Mat>,
}

impl LyapunovPolynomial {
    /// Returns X(theta). n x n.
    pub fn value(&self, theta: f64) -> Mat {
        self.weighted(|k| self.power(theta, k))
    }

    /// Returns dX/dtheta.
    pub fn slope(&self, theta: f64) -> Mat {
        self.weighted(|k| self.power_slope(theta, k))
    }

    pub(crate) fn power(&self, theta: f64, k: usize) -> f64 {
        ((theta - self.centre) / self.half_range).powi(k as i32)
    }

    pub(crate) fn power_slope(&self, theta: f64, k: usize) -> f64 {
        if k == 0 { 0.0 } else { k as f64 * self.power(theta, k - 1) / self.half_range }
    }

    /// Returns `sum_k weight(k) X_k`.
    pub(crate) fn weighted(&self, weight: impl Fn(usize) -> f64) -> Mat {
        let n = self.coefficients.first().map_or(0, Mat::nrows);
        self.coefficients.iter().enumerate().fold(Mat::zeros(n, n), |sum, (k, x)| sum + x * weight(k))
    }
}
