//! The H-infinity norm and the modes of a closed loop at frozen parameters, with their slopes over the gains.
//!
//! ```text
//! sigma = u* G v,  d sigma/d g_i = Re(u* [C (sI - A)^-1, I] F_i [(sI - A)^-1 B; I] v),  s = i omega
//! lambda: d lambda/d g_i = l [I 0] F_i [I; 0] r,  l A = lambda l,  A r = lambda r,  l r = 1
//! F_i = [I, M_at D] M_i [I; D M_ta],  D = Theta (I - Dtt Theta)^-1:  the slope of [A B; C D] of the frozen loop
//! ```
//!
//! M_at, M_ta: the columns wt and the rows zt of the loop. Source: P. Apkarian, D. Noll, IEEE Trans. Automatic
//! Control 51(1), 2006; of the slope of an eigenvalue: T. Kato, Perturbation Theory for Linear Operators, 1966, ch. II.

use crate::matrix::{ComplexSvd, ComplexVector, Mat, Modes, complex_svd, eigenvalues, eigenvectors};
use crate::structured::minimax::{Function, Piece, Pieces};
use crate::structured::structure::Loop;
use crate::system::Group::{T, W, X, Z};
use crate::system::partition::closing;
use crate::system::{ClosedLoop, Partitioned, StateSpace};
use nalgebra::{Complex, DMatrix, DVector};

type Wide = DMatrix<Complex<f64>>;

/// A loop at some frozen parameters.
pub(crate) struct Frozen<'a> {
    pub(crate) of: &'a Loop,
    pub(crate) thetas: &'a [Vec<f64>],
}

/// A loop frozen at one parameter value.
pub(crate) struct FrozenLoop {
    /// The system in coordinates in which the row and the column of each state are of equal size.
    system: StateSpace,
    /// The unit of each of its states.
    units: Vec<f64>,
    /// The factors `[M_xt; M_zt] D` and `D [M_tx, M_tw]`.
    from_channels: Mat,
    to_channels: Mat,
    /// The H-infinity norm and its frequency, rad/s.
    norm: (f64, f64),
}

impl FrozenLoop {
    fn new(closed: &ClosedLoop, theta: &[f64]) -> Option<Self> {
        let inner = closing(&closed.channels, &closed.dtt(), theta).ok()?;
        let system = closed.frozen(theta).ok()?;
        let from_channels = closed.parts.join(&[X, Z], &[T]) * &inner;
        let to_channels = inner * closed.parts.join(&[T], &[X, W]);
        let (system, units) = balanced(&system);
        Some(Self { system, units, from_channels, to_channels, norm: (f64::INFINITY, 0.0) })
    }

    /// Returns `l* F_i r` for each direction, for l over x', z and r over x, w.
    fn slopes(
        &self,
        directions: &[Partitioned],
        mut left: ComplexVector,
        mut right: ComplexVector,
    ) -> DVector<Complex<f64>> {
        let n = self.system.a.nrows();
        for (i, unit) in self.units.iter().enumerate() {
            left[i] /= *unit;
            right[i] *= *unit;
        }
        let split = |all: &ComplexVector, inner: ComplexVector| {
            let (x, rest) = (all.rows(0, n), all.rows(n, all.len() - n));
            ComplexVector::from_iterator(
                all.len() + inner.len(),
                x.iter().chain(inner.iter()).chain(rest.iter()).copied(),
            )
        };
        let left = split(&left, complex(&self.from_channels.transpose()) * &left);
        let right = split(&right, complex(&self.to_channels) * &right);
        let slope = |m: &Partitioned| {
            let m = m.matrix();
            let through = |j: usize| (0..m.nrows()).map(|i| left[i].conj() * m[(i, j)]).sum::<Complex<f64>>();
            (0..m.ncols()).map(|j| through(j) * right[j]).sum()
        };
        DVector::from_iterator(directions.len(), directions.iter().map(slope))
    }

    /// Returns the largest singular values of the response at a frequency (rad/s), as pieces.
    fn at_frequency(
        &self,
        index: usize,
        omega: f64,
        directions: &[Partitioned],
        least: f64,
    ) -> Option<Vec<Piece>> {
        let StateSpace { a, b, c, d } = &self.system;
        let n = a.nrows();
        let (reach, see) = if omega.is_finite() {
            let s = Wide::from_diagonal_element(n, n, Complex::new(0.0, omega));
            let factor = (s - complex(a)).lu();
            let reach = factor.solve(&complex(b))?;
            (reach, factor.try_inverse().map(|inverse| complex(c) * inverse)?)
        } else {
            (Wide::zeros(n, b.ncols()), Wide::zeros(c.nrows(), n))
        };
        let response = complex(c) * &reach + complex(d);
        let ComplexSvd { u: left, s: values, v: right } = complex_svd(&response)?;
        let pieces = values.iter().enumerate().take_while(|(_, value)| **value >= least);
        let piece = |(k, value): (usize, &f64)| {
            let (u, v) = (left.column(k).into_owned(), right.column(k).into_owned());
            let slope = self.slopes(directions, stacked(see.adjoint() * &u, &u), stacked(&reach * &v, &v));
            Piece { value: *value, slope: slope.map(|v| v.re), place: (index, place(omega)) }
        };
        Some(pieces.map(piece).collect())
    }

    /// Returns frequencies of local peaks of the largest singular value, rad/s, with values of at least `least`.
    fn peaks(&self, least: f64) -> Vec<f64> {
        let (norm, at_norm) = self.norm;
        let poles: Vec<f64> = self.system.poles().iter().map(|pole| pole.norm()).collect();
        let moving = || poles.iter().copied().filter(|pole| *pole > 0.0);
        let low = GRID_BEYOND.recip() * moving().fold(f64::INFINITY, f64::min);
        let high = GRID_BEYOND * moving().fold(0.0, f64::max);
        let mut grid: Vec<f64> = poles;
        if low < high {
            let step = (high / low).ln() / (GRID_POINTS - 1) as f64;
            grid.extend((0..GRID_POINTS).map(|k| low * (k as f64 * step).exp()));
        }
        grid.push(0.0);
        grid.extend(Some(at_norm).filter(|omega| omega.is_finite()));
        grid.sort_by(f64::total_cmp);
        grid.dedup();
        let gains: Vec<f64> = grid.iter().map(|omega| self.system.gain_at(*omega)).collect();
        let mut out = vec![];
        for (k, gain) in gains.iter().enumerate() {
            let before = k.checked_sub(1).map_or(0.0, |j| gains[j]);
            let after = gains.get(k + 1).copied().unwrap_or(0.0);
            if *gain < before || *gain < after || *gain < PEAKS_FROM * norm {
                continue;
            }
            let (omega, value) = if grid[k] == at_norm || k == 0 || k + 1 == grid.len() {
                (grid[k], *gain)
            } else {
                self.refined(grid[k - 1], grid[k], grid[k + 1])
            };
            if value >= least {
                out.push(omega);
            }
        }
        if !at_norm.is_finite() && norm >= least {
            out.push(f64::INFINITY);
        }
        out
    }

    /// Returns the peak in an interval of frequencies around a point higher than its ends, by golden section.
    fn refined(&self, low: f64, middle: f64, high: f64) -> (f64, f64) {
        let (mut low, mut high) = (low.max(1e-3 * middle).ln(), high.ln());
        let gain = |log: f64| self.system.gain_at(log.exp());
        let golden = 0.5 * (5f64.sqrt() - 1.0);
        let (mut one, mut other) = (high - golden * (high - low), low + golden * (high - low));
        let (mut at_one, mut at_other) = (gain(one), gain(other));
        for _ in 0..GOLDEN_STEPS {
            if at_one >= at_other {
                (high, other, at_other) = (other, one, at_one);
                one = high - golden * (high - low);
                at_one = gain(one);
            } else {
                (low, one, at_one) = (one, other, at_other);
                other = low + golden * (high - low);
                at_other = gain(other);
            }
        }
        if at_one >= at_other { (one.exp(), at_one) } else { (other.exp(), at_other) }
    }

    /// Returns the slowest modes, as pieces of their real parts. `None` if the modes cannot be computed.
    fn modes(&self, index: usize, directions: &[Partitioned], most: usize) -> Option<Vec<Piece>> {
        let Modes { values, right, left } = eigenvectors(&self.system.a)?;
        let mut order: Vec<usize> = (0..values.len()).filter(|k| values[*k].im >= 0.0).collect();
        order.sort_by(|a, b| values[*b].re.total_cmp(&values[*a].re));
        let (w, z) = (self.system.b.ncols(), self.system.c.nrows());
        let piece = |k: &usize| {
            let value = values[*k];
            let l = left.row(*k).adjoint();
            let r = right.column(*k).into_owned();
            let none = |size| ComplexVector::zeros(size);
            let slope = self.slopes(directions, stacked(l, &none(z)), stacked(r, &none(w)));
            Piece { value: value.re, slope: slope.map(|v| v.re), place: (index, place(value.im)) }
        };
        Some(order.iter().take(most).map(piece).collect())
    }
}

/// Returns the system in coordinates in which the row and the column of each state have equal norms, and the units of
/// its states.
///
/// Source: E. E. Osborne, J. ACM 7(4), 1960.
fn balanced(system: &StateSpace) -> (StateSpace, Vec<f64>) {
    let (mut a, mut b, mut c) = (system.a.clone(), system.b.clone(), system.c.clone());
    let mut units = vec![1.0; a.nrows()];
    for _ in 0..BALANCING_ROUNDS {
        for (i, unit) in units.iter_mut().enumerate() {
            let own = a[(i, i)].powi(2);
            let row = a.row(i).norm_squared() - own + b.row(i).norm_squared();
            let column = a.column(i).norm_squared() - own + c.column(i).norm_squared();
            let step = (row / column).powf(0.25);
            if row > 0.0 && column > 0.0 && step.is_finite() && step > 0.0 {
                *unit *= step;
                a.row_mut(i).unscale_mut(step);
                b.row_mut(i).unscale_mut(step);
                a.column_mut(i).scale_mut(step);
                c.column_mut(i).scale_mut(step);
            }
        }
    }
    (StateSpace { a, b, c, d: system.d.clone() }, units)
}

const BALANCING_ROUNDS: usize = 10;

/// The number of frequencies in the search for local peaks, and the factor beyond the slowest and fastest mode.
const GRID_POINTS: usize = 40;
const GRID_BEYOND: f64 = 10.0;

/// The number of refinement steps of a peak.
const GOLDEN_STEPS: usize = 16;

/// The fraction of the largest below which local peaks and singular values are left out.
const PEAKS_FROM: f64 = 0.6;

/// The real part, relative to the typical mode, below which a loop is taken as stable.
const STABLE_BY: f64 = 0.03;

/// The number of slowest modes that limit a step, for each parameter value.
const SLOWEST_MODES: usize = 3;

/// Maps a frequency to a coordinate in which 0 and infinity are far from all others.
fn place(omega: f64) -> f64 {
    omega.clamp(1e-9, 1e9).ln()
}

fn complex(m: &Mat) -> Wide {
    m.map(|v| Complex::new(v, 0.0))
}

fn stacked(one: ComplexVector, other: &ComplexVector) -> ComplexVector {
    ComplexVector::from_iterator(one.len() + other.len(), one.iter().chain(other.iter()).copied())
}

/// The largest H-infinity norm over the frozen parameters.
pub(crate) struct LargestNorm<'a>(pub(crate) Frozen<'a>);

impl Function for LargestNorm<'_> {
    type At = Vec<FrozenLoop>;

    fn value(&self, gains: &[f64]) -> Option<(f64, Self::At)> {
        let closed = self.0.of.at(gains);
        let frozen = |theta: &Vec<f64>| {
            let mut frozen = FrozenLoop::new(&closed, theta)?;
            let norm = frozen.system.hinf_norm();
            frozen.norm = (norm.value, norm.frequency);
            Some(frozen).filter(|_| norm.value.is_finite())
        };
        let all: Vec<FrozenLoop> = self.0.thetas.iter().map(frozen).collect::<Option<_>>()?;
        Some((all.iter().map(|frozen| frozen.norm.0).fold(0.0, f64::max), all))
    }

    fn pieces(&self, at: &Self::At) -> Option<Pieces> {
        let least = PEAKS_FROM * at.iter().map(|frozen| frozen.norm.0).fold(0.0, f64::max);
        let directions = &self.0.of.directions;
        let (mut objective, mut limits) = (vec![], vec![]);
        for (index, frozen) in at.iter().enumerate() {
            for omega in frozen.peaks(least) {
                objective.extend(frozen.at_frequency(index, omega, directions, least)?);
            }
            let modes = frozen.modes(index, directions, SLOWEST_MODES)?;
            limits.extend(modes.into_iter().filter(|mode| mode.value < 0.0));
        }
        (!objective.is_empty()).then_some(Pieces { objective, limits })
    }

    fn seen_from(&self, at: &Self::At, other: &Self::At) -> Vec<Piece> {
        let most = at.iter().map(|frozen| frozen.norm.0).fold(0.0, f64::max);
        let large = other.iter().enumerate().filter(|(_, there)| there.norm.0 > most);
        let pieces = large.filter_map(|(index, there)| {
            at[index].at_frequency(index, there.norm.1, &self.0.of.directions, 0.0)?.into_iter().next()
        });
        pieces.collect()
    }
}

/// The largest real part of the modes over the frozen parameters.
pub(crate) struct LargestAbscissa<'a> {
    frozen: Frozen<'a>,
    /// The typical size of a mode, rad/s.
    size: f64,
    /// The change of each gain that changes the loop's A by its own size. Slopes of eigenvalues may be infinite.
    pub(crate) units: Vec<f64>,
}

impl<'a> LargestAbscissa<'a> {
    pub(crate) fn new(frozen: Frozen<'a>, start: &[f64]) -> Self {
        let closed = frozen.of.at(start);
        let (system, states) = balanced(&closed.parts.state_space(&[Z], &[W]));
        let modes = eigenvalues(&system.a);
        let moving = || modes.iter().map(|mode| mode.norm()).filter(|size| *size > 0.0);
        let size = (moving().map(f64::ln).sum::<f64>() / moving().count().max(1) as f64).exp();
        let norm = system.a.norm();
        let unit = |m: &Partitioned| {
            let m = m.matrix();
            let change = Mat::from_fn(states.len(), states.len(), |i, j| m[(i, j)] * states[j] / states[i]);
            Some(norm / change.norm()).filter(|unit| unit.is_finite() && *unit > 0.0).unwrap_or(1.0)
        };
        let units = frozen.of.directions.iter().map(unit).collect();
        Self { frozen, size, units }
    }
}

impl Function for LargestAbscissa<'_> {
    type At = Vec<FrozenLoop>;

    fn value(&self, gains: &[f64]) -> Option<(f64, Self::At)> {
        let closed = self.frozen.of.at(gains);
        let all: Vec<FrozenLoop> =
            self.frozen.thetas.iter().map(|theta| FrozenLoop::new(&closed, theta)).collect::<Option<_>>()?;
        let slowest = all.iter().map(|frozen| crate::matrix::spectral_abscissa(&frozen.system.a));
        let slowest = crate::matrix::largest(f64::NEG_INFINITY, slowest);
        slowest.is_finite().then_some((slowest, all))
    }

    fn pieces(&self, at: &Self::At) -> Option<Pieces> {
        let mut objective = vec![];
        for (index, frozen) in at.iter().enumerate() {
            objective.extend(frozen.modes(index, &self.frozen.of.directions, usize::MAX)?);
        }
        Some(Pieces { objective, limits: vec![] })
    }

    fn seen_from(&self, _: &Self::At, _: &Self::At) -> Vec<Piece> {
        vec![]
    }

    fn size(&self, value: f64) -> f64 {
        value.abs().max(self.size)
    }

    fn units(&self, _: f64, _: &Pieces) -> DVector<f64> {
        DVector::from_column_slice(&self.units)
    }

    fn suffices(&self, value: f64) -> bool {
        value < -STABLE_BY * self.size
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structured::cases::{differences, scheduled};

    #[test]
    fn the_slopes_agree_with_finite_differences() {
        let (plant, structure) = scheduled();
        let of = Loop::new(&plant, &structure);
        let gains = [0.2, -0.3, 0.1];
        for theta in [-0.7, 0.4] {
            let thetas = [vec![theta]];
            let frozen = || Frozen { of: &of, thetas: &thetas };
            let norm = LargestNorm(frozen());
            let (value, at) = norm.value(&gains).unwrap();
            let plain = plant.close(&structure.controller(&gains)).frozen(&[theta]).unwrap();
            assert!((value - plain.hinf_norm().value).abs() < 1e-8 * value);
            let pieces = norm.pieces(&at).unwrap();
            let largest = pieces.objective.iter().max_by(|a, b| a.value.total_cmp(&b.value)).unwrap();
            assert!((largest.value - value).abs() < 1e-8 * value);
            let expected = differences(|g| norm.value(g).unwrap().0, &gains);
            assert!(
                (&largest.slope - &expected).norm() < 1e-6 * expected.norm(),
                "{} {expected}",
                largest.slope
            );

            let abscissa = LargestAbscissa::new(frozen(), &gains);
            let (value, at) = abscissa.value(&gains).unwrap();
            let pieces = abscissa.pieces(&at).unwrap().objective;
            assert!((pieces[0].value - value).abs() < 1e-12);
            let expected = differences(|g| abscissa.value(g).unwrap().0, &gains);
            assert!((&pieces[0].slope - &expected).norm() < 1e-6 * expected.norm());
        }
    }
}
