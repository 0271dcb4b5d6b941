//! Coordinates in which the matrix inequalities are well conditioned.
//!
//! A solver can report success with gamma wrong by a tenth on an unbalanced realisation. The problem is invariant under
//! the states' basis, the unit of time, the units of y and u, and a basis of the parameter channels that commutes with
//! Theta: these are chosen for the solver and undone afterwards.
//!
//! Source of the diagonal balancing: E. E. Osborne, J. ACM 7(4), 1960. The balanced pair (X, Y): B. C. Moore,
//! IEEE Trans. Automatic Control 26(1), 1981.

use crate::analysis::gain_bound::GainBound;
use crate::matrix::{Mat, Svd, diagonal, diagonal_blocks, eigenvalues, svd};
use crate::synthesis::inequalities::{DualMultipliers, LmiSolution};
use crate::system::Group::{T, U, X, Y};
use crate::system::{Controller, GeneralisedPlant};

/// A change of coordinates: `x = T_x x~`, `zt = T_t zt~`, `wt = T_t wt~`, `y = T_y y~`, `u = T_u u~`,
/// `t = t~/time_scale`.
#[derive(Debug, Clone, PartialEq)]
pub struct Coordinates {
    state: Mat,
    state_inverse: Mat,
    channel: Mat,
    channel_inverse: Mat,
    /// The unit of each measurement, in the user's units.
    pub(crate) measurement: Vec<f64>,
    /// The unit of each control, in the user's units.
    pub(crate) control: Vec<f64>,
    /// Unit of frequency, rad/s.
    time_scale: f64,
}

/// Returns the power of two nearest to a positive number, by its logarithm.
pub(crate) fn power_of_two(v: f64) -> f64 {
    v.log2().round().exp2()
}

impl Coordinates {
    /// Returns the unchanged coordinates.
    pub fn identity(plant: &GeneralisedPlant) -> Self {
        let s = plant.sizes();
        Self {
            state: Mat::identity(s.x, s.x),
            state_inverse: Mat::identity(s.x, s.x),
            channel: Mat::identity(s.t, s.t),
            channel_inverse: Mat::identity(s.t, s.t),
            measurement: vec![1.0; s.y],
            control: vec![1.0; s.u],
            time_scale: 1.0,
        }
    }

    /// Returns coordinates with time scaled to the median of the plant's modes, then states, channels, y and u scaled
    /// so that their rows and columns have equal norms.
    pub fn diagonal(plant: &GeneralisedPlant) -> Self {
        Self::with_time_scale(plant, median_time_scale(&plant.a()))
    }

    /// Returns diagonal coordinates with factors rounded to powers of two, in which no number of the plant is rounded.
    pub(crate) fn in_powers_of_two(&self) -> Self {
        let diagonals = |m: &Mat| {
            let rounded = m.diagonal().map(power_of_two);
            (Mat::from_diagonal(&rounded), Mat::from_diagonal(&rounded.map(f64::recip)))
        };
        let (state, state_inverse) = diagonals(&self.state);
        let (channel, channel_inverse) = diagonals(&self.channel);
        Self {
            state,
            state_inverse,
            channel,
            channel_inverse,
            measurement: self.measurement.iter().copied().map(power_of_two).collect(),
            control: self.control.iter().copied().map(power_of_two).collect(),
            time_scale: power_of_two(self.time_scale),
        }
    }

    /// Returns [`Coordinates::diagonal`] with a given time scale, rad/s.
    pub(crate) fn with_time_scale(plant: &GeneralisedPlant, time_scale: f64) -> Self {
        let mut coordinates = Self { time_scale, ..Self::identity(plant) };
        for _ in 0..20 {
            let s = plant.sizes();
            let scaled = coordinates.apply(plant);
            let m = scaled.parts.matrix();
            let states: Vec<f64> = (0..s.x).map(|i| osborne(m, i)).collect();
            let channels: Vec<f64> = (s.x..s.x + s.t).map(|i| osborne(m, i)).collect();
            scale(&mut coordinates.state, &mut coordinates.state_inverse, &states);
            scale(&mut coordinates.channel, &mut coordinates.channel_inverse, &channels);
            for j in 0..s.u {
                coordinates.control[j] /= norm_or_one(m.column(s.x + s.t + s.w + j).norm());
            }
            for i in 0..s.y {
                coordinates.measurement[i] *= norm_or_one(m.row(s.x + s.t + s.z + i).norm());
            }
        }
        coordinates
    }

    /// Returns these coordinates followed by those in which the pairs (X, Y) and (S, Sigma) become equal and diagonal.
    /// `None` if one of the matrices is not positive definite.
    pub fn equalising(&self, x: &Mat, y: &Mat, s: &Mat, sigma: &Mat, channels: &[usize]) -> Option<Self> {
        let mut out = self.clone();
        let (t, t_inverse) = equalise(x, y)?;
        out.state = &out.state * &t;
        out.state_inverse = t_inverse * &out.state_inverse;
        let parameters = channels.iter().copied().max().map_or(0, |c| c + 1);
        let (mut tau, mut tau_inverse) =
            (Mat::identity(channels.len(), channels.len()), Mat::identity(channels.len(), channels.len()));
        for parameter in 0..parameters {
            let indices: Vec<usize> = (0..channels.len()).filter(|&i| channels[i] == parameter).collect();
            let part =
                |m: &Mat| Mat::from_fn(indices.len(), indices.len(), |i, j| m[(indices[i], indices[j])]);
            let (t, t_inverse) = equalise(&part(s), &part(sigma))?;
            for (i, &row) in indices.iter().enumerate() {
                for (j, &col) in indices.iter().enumerate() {
                    tau[(row, col)] = t[(i, j)];
                    tau_inverse[(row, col)] = t_inverse[(i, j)];
                }
            }
        }
        out.channel = &out.channel * tau;
        out.channel_inverse = tau_inverse * &out.channel_inverse;
        Some(out)
    }

    /// Converts a rate (rad/s) to these coordinates' unit of time.
    pub fn scaled_rate(&self, rate: f64) -> f64 {
        rate / self.time_scale
    }

    /// Converts a solution of the synthesis inequalities from the coordinates `from` to these.
    pub(crate) fn carry(&self, from: &Self, found: &LmiSolution) -> LmiSolution {
        // Both have the same time scale.
        let (t, t_inverse) = (&from.state_inverse * &self.state, &self.state_inverse * &from.state);
        let (c, c_inverse) = (&from.channel_inverse * &self.channel, &self.channel_inverse * &from.channel);
        LmiSolution {
            x: t.transpose() * &found.x * &t,
            y: &t_inverse * &found.y * t_inverse.transpose(),
            primal_scaling: c.transpose() * &found.primal_scaling * &c,
            dual_scaling: &c_inverse * &found.dual_scaling * c_inverse.transpose(),
            ..found.clone()
        }
    }

    /// Returns the plant in these coordinates.
    pub fn apply(&self, p: &GeneralisedPlant) -> GeneralisedPlant {
        let (u, yi) =
            (diagonal(self.control.iter().copied()), diagonal(self.measurement.iter().map(|v| 1.0 / v)));
        let left = [(X, &self.state_inverse), (T, &self.channel_inverse), (Y, &yi)];
        let right = [(X, &self.state), (T, &self.channel), (U, &u)];
        let mut out = p.changed(|parts| parts.transformed(&left, &right));
        out.parts.rows_mut(X).scale_mut(1.0 / self.time_scale);
        out
    }

    /// Converts a Lyapunov matrix of the closed loop (plant's states, then controller's), or the inverse of one, to the
    /// user's coordinates.
    pub(crate) fn undo_lyapunov(&self, x: &Mat, inverse: bool) -> Mat {
        if inverse {
            let full = lifted(&self.state, x.nrows());
            &full * x * full.transpose() * self.time_scale
        } else {
            // In another unit of time A is larger by the time scale and X smaller.
            let full = lifted(&self.state_inverse, x.nrows());
            full.transpose() * x * full / self.time_scale
        }
    }

    /// Converts a bound of the closed loop's gain (plant's part, then controller's) to the user's coordinates.
    pub fn undo_bound(&self, bound: &GainBound) -> GainBound {
        let channel = lifted(&self.channel_inverse, bound.s.nrows());
        GainBound {
            x: self.undo_lyapunov(&bound.x, false),
            factor: None,
            s: channel.transpose() * &bound.s * &channel,
            t: channel.transpose() * &bound.t * &channel,
            ..*bound
        }
    }

    /// Converts multipliers in these coordinates, with w and z in units of `unit`, to the user's.
    pub(crate) fn undo_multipliers(&self, unit: f64, found: &DualMultipliers) -> DualMultipliers {
        let lift = |state: &Mat, channel: &Mat, m: &Mat| {
            let rest = m.nrows() - state.nrows() - channel.nrows();
            diagonal_blocks(&[state, channel, &(Mat::identity(rest, rest) / unit.sqrt())]) * m
        };
        let inverse = self.state_inverse.transpose();
        DualMultipliers {
            primal: lift(&self.state, &self.channel, &found.primal),
            dual: lift(&(&inverse / self.time_scale), &self.channel_inverse.transpose(), &found.dual),
            // Z11 is time_scale T Z11~ T', Z22 is T^-T Z22~ T^-1/time_scale.
            coupling: (
                &inverse * &found.coupling.0 / self.time_scale.sqrt(),
                &self.state * &found.coupling.1 * self.time_scale.sqrt(),
            ),
        }
    }

    /// Converts multipliers, except their coupling, from the user's coordinates to these with w and z in units of
    /// `unit`.
    pub(crate) fn redo_multipliers(&self, unit: f64, given: &DualMultipliers) -> DualMultipliers {
        let lift = |state: &Mat, channel: &Mat, m: &Mat| {
            let rest = m.nrows() - state.nrows() - channel.nrows();
            diagonal_blocks(&[state, channel, &(Mat::identity(rest, rest) * unit.sqrt())]) * m
        };
        DualMultipliers {
            primal: lift(&self.state_inverse, &self.channel_inverse, &given.primal),
            dual: lift(&(self.state.transpose() * self.time_scale), &self.channel.transpose(), &given.dual),
            coupling: given.coupling.clone(),
        }
    }

    /// Converts a controller from these coordinates to the user's. Its states and channels keep their basis.
    pub fn undo(&self, k: &Controller) -> Controller {
        let (u, yi) =
            (diagonal(self.control.iter().copied()), diagonal(self.measurement.iter().map(|v| 1.0 / v)));
        let mut parts = k.parts.transformed(&[(U, &u)], &[(Y, &yi)]);
        parts.rows_mut(X).scale_mut(self.time_scale);
        Controller { parts, blocks: k.blocks.clone() }
    }
}

/// Scales each basis vector by a factor, and updates the inverse.
fn scale(basis: &mut Mat, inverse: &mut Mat, factors: &[f64]) {
    for (i, f) in factors.iter().enumerate() {
        basis.column_mut(i).scale_mut(*f);
        inverse.row_mut(i).scale_mut(1.0 / f);
    }
}

/// Returns `blkdiag(part, I)` with `size` rows: the change of the plant's part of a loop.
fn lifted(part: &Mat, size: usize) -> Mat {
    let rest = size - part.nrows();
    diagonal_blocks(&[part, &Mat::identity(rest, rest)])
}

fn norm_or_one(norm: f64) -> f64 {
    if norm > 0.0 && norm.is_finite() { norm } else { 1.0 }
}

/// Returns the factor that gives row and column i equal norms, without the diagonal entry.
pub(crate) fn osborne(m: &Mat, i: usize) -> f64 {
    let without = |norm_squared: f64| (norm_squared - m[(i, i)].powi(2)).max(0.0).sqrt();
    let (row, column) = (without(m.row(i).norm_squared()), without(m.column(i).norm_squared()));
    if row > 0.0 && column > 0.0 { (row / column).sqrt().clamp(1e-6, 1e6) } else { 1.0 }
}

/// Returns the median of |lambda| over the modes, rad/s, so that one slow or fast weight does not set the unit of time.
/// Modes at zero, to rounding, are left out; 1 if there are no others.
pub(crate) fn median_time_scale(a: &Mat) -> f64 {
    let sizes: Vec<f64> = eigenvalues(a).iter().map(|v| v.norm()).filter(|v| v.is_finite()).collect();
    let fastest = sizes.iter().copied().fold(0.0, f64::max);
    let mut moving: Vec<f64> = sizes.into_iter().filter(|v| *v > 1e-12 * fastest).collect();
    moving.sort_by(f64::total_cmp);
    match (moving.get(moving.len().saturating_sub(1) / 2), moving.get(moving.len() / 2)) {
        (Some(low), Some(high)) => (low * high).sqrt(),
        _ => 1.0,
    }
}

/// Returns T and its inverse with `T' X T = T^-1 Y T^-T` diagonal.
pub(crate) fn equalise(x: &Mat, y: &Mat) -> Option<(Mat, Mat)> {
    if x.is_empty() {
        return Some((x.clone(), x.clone()));
    }
    let (lx, ly) = (x.clone().cholesky()?.l(), y.clone().cholesky()?.l());
    let Svd { u, s, v } = svd(&(lx.transpose() * &ly));
    let root_inverse = diagonal(s.iter().map(|s| 1.0 / s.sqrt()));
    let t = &ly * v * &root_inverse;
    // T^-1 = Sigma^-1/2 U' Lx', without inversion of T.
    let t_inverse = root_inverse * u.transpose() * lx.transpose();
    t.iter().chain(t_inverse.iter()).all(|v| v.is_finite()).then_some((t, t_inverse))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dmatrix;

    #[test]
    fn a_pair_becomes_equal_and_diagonal() {
        let x = dmatrix![4.0, 1.0; 1.0, 3.0];
        let y = dmatrix![9.0, -2.0; -2.0, 5.0];
        let (t, ti) = equalise(&x, &y).unwrap();
        assert!((&t * &ti - Mat::identity(2, 2)).amax() < 1e-12);
        let (a, b) = (t.transpose() * x * &t, &ti * y * ti.transpose());
        assert!((&a - b).amax() < 1e-12);
        assert!(a[(0, 1)].abs() < 1e-12);
    }
}
