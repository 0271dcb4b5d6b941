//! Linear fractional transformations: a matrix that depends on normalised parameters.
//!
//! `M(theta) = M_0 + L Theta (I - D Theta)^-1 R`, `Theta = diag(theta_c)` with the parameter `c` of each channel. Sums
//! and products of LFTs are LFTs; a polynomial or rational function of one parameter has an LFT of minimal size.
//!
//! Sources: K. Zhou, J. C. Doyle, K. Glover, Robust and Optimal Control, 1996, ch. 10 (the algebra);
//! B. L. Ho, R. E. Kalman, Regelungstechnik 14, 1966 (minimal realisation from a Hankel matrix).

use crate::error::SystemError;
use crate::matrix::{Mat, block, diagonal, diagonal_blocks, rank_factors, solve};
use crate::system::{MatrixPolynomial, MatrixRational};

/// A matrix `M(theta) = M_0 + L Theta (I - D Theta)^-1 R`.
///
/// Shapes: `M_0` p x m, `L` p x r, `D` r x r, `R` r x m, with r channels.
#[derive(Debug, Clone, PartialEq)]
pub struct Lft {
    /// The value at theta = 0, p x m.
    pub constant: Mat,
    /// L, p x r.
    pub left: Mat,
    /// D, r x r.
    pub inner: Mat,
    /// R, r x m.
    pub right: Mat,
    /// The parameter of each channel: channel i carries `theta[channels[i]]`.
    pub channels: Vec<usize>,
}

impl Lft {
    /// Returns a matrix that depends on no parameter.
    pub fn constant(m: Mat) -> Self {
        let (p, n) = m.shape();
        Self {
            constant: m,
            left: Mat::zeros(p, 0),
            inner: Mat::zeros(0, 0),
            right: Mat::zeros(0, n),
            channels: vec![],
        }
    }

    /// Returns the scalar `nominal + half_range theta_parameter`.
    pub fn parameter(parameter: usize, nominal: f64, half_range: f64) -> Self {
        let scalar = |v| Mat::from_element(1, 1, v);
        Self {
            constant: scalar(nominal),
            left: scalar(1.0),
            inner: scalar(0.0),
            right: scalar(half_range),
            channels: vec![parameter],
        }
    }

    /// Returns the number of channels r.
    pub fn size(&self) -> usize {
        self.channels.len()
    }

    /// Returns `M(theta)`. p x m.
    ///
    /// # Errors
    /// Returns [`SystemError::NotWellPosed`] if `I - D Theta` is singular there.
    pub fn evaluate(&self, theta: &[f64]) -> Result<Mat, SystemError> {
        let delta = diagonal(self.channels.iter().map(|&c| theta[c]));
        let loop_matrix = Mat::identity(self.size(), self.size()) - &self.inner * &delta;
        let inner = solve(&loop_matrix, &self.right)
            .ok_or_else(|| SystemError::NotWellPosed { theta: theta.to_vec() })?;
        Ok(&self.constant + &self.left * delta * inner)
    }

    /// Returns `M_1 + M_2`. Shapes: both p x m.
    pub fn add(&self, other: &Self) -> Self {
        Self {
            constant: &self.constant + &other.constant,
            left: block(&[&[&self.left, &other.left]]),
            inner: diagonal_blocks(&[&self.inner, &other.inner]),
            right: block(&[&[&self.right], &[&other.right]]),
            channels: self.joined(other),
        }
    }

    /// Returns `M_1 M_2`. Shapes: p x m and m x k.
    pub fn multiply(&self, other: &Self) -> Self {
        let zero = Mat::zeros(other.size(), self.size());
        Self {
            constant: &self.constant * &other.constant,
            left: block(&[&[&self.left, &(&self.constant * &other.left)]]),
            inner: block(&[&[&self.inner, &(&self.right * &other.left)], &[&zero, &other.inner]]),
            right: block(&[&[&(&self.right * &other.constant)], &[&other.right]]),
            channels: self.joined(other),
        }
    }

    /// Returns `[M_1 M_2]`. Shapes: p x m and p x k.
    pub fn concatenated(&self, other: &Self) -> Self {
        Self {
            constant: block(&[&[&self.constant, &other.constant]]),
            left: block(&[&[&self.left, &other.left]]),
            inner: diagonal_blocks(&[&self.inner, &other.inner]),
            right: diagonal_blocks(&[&self.right, &other.right]),
            channels: self.joined(other),
        }
    }

    /// Returns `[M_1; M_2]`. Shapes: p x m and k x m.
    pub fn stacked(&self, other: &Self) -> Self {
        Self {
            constant: block(&[&[&self.constant], &[&other.constant]]),
            left: diagonal_blocks(&[&self.left, &other.left]),
            inner: diagonal_blocks(&[&self.inner, &other.inner]),
            right: block(&[&[&self.right], &[&other.right]]),
            channels: self.joined(other),
        }
    }

    /// Returns the LFT with its channels sorted by parameter.
    #[must_use]
    pub fn in_order(&self) -> Self {
        let mut order: Vec<usize> = (0..self.size()).collect();
        order.sort_by_key(|&i| self.channels[i]);
        Self {
            constant: self.constant.clone(),
            left: self.left.select_columns(&order),
            inner: self.inner.select_columns(&order).select_rows(&order),
            right: self.right.select_rows(&order),
            channels: order.iter().map(|&i| self.channels[i]).collect(),
        }
    }

    /// Returns `M_0 + L T Theta (I - F D T Theta)^-1 F R` with the Theta of other channels: the same matrix if
    /// `T Theta F` is the Theta of the present ones.
    ///
    /// Shapes, for s new channels: `from` F is s x r, `to` T is r x s.
    #[must_use]
    pub fn transformed(&self, from: &Mat, to: &Mat, channels: Vec<usize>) -> Self {
        Self {
            constant: self.constant.clone(),
            left: &self.left * to,
            inner: from * &self.inner * to,
            right: from * &self.right,
            channels,
        }
    }

    /// Returns the LFT of minimal size of a polynomial in one parameter; see [`Lft::from_rational`].
    pub fn from_polynomial(polynomial: &MatrixPolynomial, tolerance: f64) -> Self {
        Self::from_series(&polynomial.coefficients, polynomial.order(), tolerance)
    }

    /// Returns the LFT of minimal size of a rational function of one parameter.
    ///
    /// With the coefficients `M_1, M_2, ...` of its series the size is the rank of the Hankel matrix `[M_(i+j-1)]`, at
    /// most the order times the smaller dimension of M; its factors give a realisation, balanced for a polynomial (Ho
    /// and Kalman, 1966). Singular values up to `tolerance` times the largest are dropped: measure the error with
    /// [`Lft::evaluate`].
    pub fn from_rational(rational: &MatrixRational, tolerance: f64) -> Self {
        let order = rational.numerator.order().max(rational.denominator.len());
        Self::from_series(&rational.series(2 * order + 1), order, tolerance)
    }

    /// Returns the LFT of a series whose Hankel matrix of `order` blocks has full rank; coefficients not listed are
    /// zero.
    fn from_series(series: &[Mat], order: usize, tolerance: f64) -> Self {
        let (p, m) = series[0].shape();
        let hankel = |shift: usize| {
            let mut h = Mat::zeros(p * order, m * order);
            for i in 0..order {
                for j in 0..order {
                    if let Some(coefficient) = series.get(i + j + 1 + shift) {
                        h.view_mut((i * p, j * m), (p, m)).copy_from(coefficient);
                    }
                }
            }
            h
        };
        let full = hankel(0);
        let threshold = tolerance * crate::matrix::largest_singular_value(&full);
        let (observability, reachability) = rank_factors(&full, threshold);
        let r = observability.ncols();
        if r == 0 {
            return Self::constant(series[0].clone());
        }
        // Orthogonal columns and rows of squared norm sigma_i: the pseudo-inverses are scaled transposes.
        let sigma_inverse = diagonal(observability.column_iter().map(|column| 1.0 / column.norm_squared()));
        let inner = &sigma_inverse
            * observability.transpose()
            * hankel(1)
            * reachability.transpose()
            * &sigma_inverse;
        Self {
            constant: series[0].clone(),
            left: observability.rows(0, p).into_owned(),
            inner,
            right: reachability.columns(0, m).into_owned(),
            channels: vec![0; r],
        }
    }

    fn joined(&self, other: &Self) -> Vec<usize> {
        self.channels.iter().chain(&other.channels).copied().collect()
    }
}
