//! Loop of one axis in every turn: its part of M as a function of speed and rate of turn.
//!
//! ```text
//! [x'; y] = (P(rho) + tau N) [x; T] + B d,   z = C [x; T],   T' = (u - T)/lag,   u = K(rho) y
//! ```
//!
//! rho is that of the design, P a polynomial, and tau in \[0, 1\] the rate of turn relative to its limit.

use crate::check::coupled::turn::Axis;
use crate::error::Error;
use squid_lpv::controller::Controller;
use squid_lpv::lft::Lft;
use squid_lpv::matrix::{Mat, block, largest_singular_value, rank_factors};
use squid_lpv::partition::Group::{T, U, W, X, Y, Z};
use squid_lpv::plant::GeneralisedPlant;
use squid_lpv::polynomial::MatrixPolynomial;

/// Order of P. Singular values below the fraction `DROP` of the largest are left out; the remainder counts as coupling
/// of the axis to itself (see [`super::gain`]).
const ORDER: usize = 2;
const DROP: f64 = 1e-3;

/// Matrix M in a turn, at the rho of an axis.
#[derive(Debug, Clone)]
pub struct Sample {
    /// Scheduling parameter of the axis.
    pub rho: f64,
    /// Rate of turn relative to its limit.
    pub tau: f64,
    /// Matrix M.
    pub m: Mat,
}

/// Part of M of one axis, with its indices in M.
#[derive(Debug, Clone)]
pub struct AxisPlant {
    /// Rows and columns of the axis in M.
    pub axis: Axis,
    /// P + tau N as an LFT in rho and 2 tau - 1.
    model: Lft,
}

impl AxisPlant {
    /// Fits the part of an axis to its samples: P to the straight ones, N to the others.
    ///
    /// # Errors
    /// [`ModelError::System`](crate::error::ModelError::System).
    pub fn fit(axis: Axis, samples: &[Sample]) -> Result<Self, Error> {
        let own = |m: &Mat| part(m, &axis.rows, &axis.columns);
        let straight: Vec<(f64, Mat)> =
            samples.iter().filter(|one| one.tau == 0.0).map(|one| (one.rho, own(&one.m))).collect();
        let polynomial = MatrixPolynomial::fit(&straight, ORDER.min(straight.len() - 1))?;
        let (mut slope, mut weight) = (Mat::zeros(axis.rows.len(), axis.columns.len()), 0.0);
        for Sample { rho, tau, m } in samples {
            slope += (own(m) - polynomial.evaluate(*rho)) * *tau;
            weight += tau * tau;
        }
        let half = slope / (2.0 * f64::max(weight, f64::MIN_POSITIVE));
        let (left, right) = rank_factors(&half, DROP * largest_singular_value(&polynomial.coefficients[0]));
        let r = left.ncols();
        let by_rate =
            Lft { constant: &left * &right, inner: Mat::zeros(r, r), left, right, channels: vec![1; r] };
        Ok(Self { model: Lft::from_polynomial(&polynomial, DROP).add(&by_rate), axis })
    }

    /// Returns the difference of a sample from the fit, rows \[x'; y\], columns \[x; T\].
    ///
    /// # Errors
    /// [`ModelError::System`](crate::error::ModelError::System).
    pub fn residual(&self, Sample { rho, tau, m }: &Sample) -> Result<Mat, Error> {
        let Axis { rows, columns, .. } = &self.axis;
        Ok(part(m, rows, columns) - self.model.evaluate(&[*rho, 2.0 * tau - 1.0])?)
    }

    /// Builds the plant with B (rows \[x'; y\]) and C (columns \[x; T\]).
    ///
    /// # Errors
    /// [`ModelError::System`](crate::error::ModelError), an internal error.
    pub fn plant(&self, b: &Mat, c: &Mat) -> Result<GeneralisedPlant, Error> {
        let Axis { states: n, actuators, columns, .. } = &self.axis;
        let (n, m) = (*n, actuators.len());
        let lagged: Vec<usize> = (0..m).filter(|j| actuators[*j].1 > 0.0).collect();
        let states = n + lagged.len();
        // [x; T] = from_state state + from_command u
        let mut from_state = Mat::zeros(columns.len(), states);
        from_state.view_mut((0, 0), (n, n)).fill_with_identity();
        let mut from_command = Mat::zeros(columns.len(), m);
        let (mut lag, mut by_command) = (Mat::zeros(lagged.len(), states), Mat::zeros(lagged.len(), m));
        for (j, (scale, time)) in actuators.iter().enumerate() {
            match lagged.iter().position(|one| *one == j) {
                Some(i) => {
                    from_state[(n + j, n + i)] = 1.0;
                    lag[(i, n + i)] = -1.0 / time;
                    by_command[(i, j)] = scale / time;
                }
                None => from_command[(n + j, j)] = *scale,
            }
        }
        let Lft { constant, left, inner, right, channels } = &self.model;
        let no_motion = |columns: usize| Mat::zeros(lagged.len(), columns);
        let (moved, measured) = (constant.rows(0, n).into_owned(), constant.rows_range(n..).into_owned());
        let rows = |m: &Mat| (m.rows(0, n).into_owned(), m.rows_range(n..).into_owned());
        let ((left_x, left_y), (b_x, b_y)) = (rows(left), rows(b));
        let count = |parameter: usize| channels.iter().filter(|one| **one == parameter).count();
        let parts = [
            (X, X, block(&[&[&(&moved * &from_state)], &[&lag]])),
            (X, T, block(&[&[&left_x], &[&no_motion(left.ncols())]])),
            (X, W, block(&[&[&b_x], &[&no_motion(b.ncols())]])),
            (X, U, block(&[&[&(&moved * &from_command)], &[&by_command]])),
            (T, X, right * &from_state),
            (T, T, inner.clone()),
            (T, U, right * &from_command),
            (Z, X, c * &from_state),
            (Z, U, c * &from_command),
            (Y, X, &measured * &from_state),
            (Y, T, left_y),
            (Y, W, b_y),
        ];
        // Without a channel, the rate of turn is no parameter.
        let blocks = if count(1) > 0 { vec![count(0), count(1)] } else { vec![count(0)] };
        Ok(GeneralisedPlant::new(blocks, &parts)?)
    }
}

/// Adds the parameters of the plant of an axis to its controller, which does not depend on the rate of turn.
pub fn in_parameters_of(plant: &GeneralisedPlant, controller: &Controller) -> Controller {
    let mut blocks = controller.blocks.clone();
    blocks.resize(plant.blocks.len().max(blocks.len()), 0);
    Controller { blocks, ..controller.clone() }
}

/// Selects entries by their rows and columns.
pub fn part(m: &Mat, rows: &[usize], columns: &[usize]) -> Mat {
    m.select_rows(rows).select_columns(columns)
}
