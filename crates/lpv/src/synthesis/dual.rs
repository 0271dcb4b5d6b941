//! Repair of multipliers of the synthesis inequalities: they are moved into the interior of their own inequalities so
//! that they can be proved.
//!
//! With W and W2 the multipliers of the primal and the dual inequality, the multiplier of `[X I; I Y]` has the diagonal
//! blocks `Z11 = sum xd x' + x xd'` and Z22 (see the crate `certificate`, which proves the bound). Its best upper right
//! block is known in closed form: for `Z11 = L1 L1'`, `Z22 = L2 L2'` the trace of `L1 K L2'` is least over `|K| <= 1`
//! if `-K` is the orthogonal factor of the polar decomposition `U V'` of `L1'L2 = U s V'`. That is `-Z11 E F' Z22` with
//! `E = L1^-T U`, `F = L2^-T V`, and the columns of the largest singular values dominate. At the optimum Z11 and Z22
//! are singular to rounding, so W is mixed with a small part of one whose Z11 is clearly positive: for the gramian P of
//! `(A_k - alpha I, B_k)`, `A_k P + P A_k' + 2 B_k B_k' = B_k B_k' + 2 alpha P`.

use crate::matrix::{
    Mat, block, kernel, pseudo_inverse, scaled_least_eigenvalue, spectral_abscissa, svd, symmetric_part,
};
use crate::synthesis::balance::Coordinates;
use crate::synthesis::inequalities::DualMultipliers;
use crate::system::Group::{T, W, X, Y, Z};
use crate::system::{GeneralisedPlant, lyapunov};

/// Returns the most promising repaired multipliers, best first.
pub(crate) fn repaired(
    plant: &GeneralisedPlant,
    gamma: f64,
    found: &[DualMultipliers],
) -> Vec<DualMultipliers> {
    let unit = plant.in_units_of(gamma);
    let coordinates = Coordinates::diagonal(&unit);
    let (primal, dual) = (coordinates.apply(&unit), coordinates.apply(&unit).dual());
    let (Some(one), Some(two)) = (Kernel::new(&primal), Kernel::new(&dual)) else { return vec![] };
    let (clear_primal, clear_dual) = (one.clear(), two.clear());
    let mut out: Vec<(f64, DualMultipliers)> = vec![];
    for m in found.iter().map(|m| coordinates.redo_multipliers(gamma, m)) {
        for exponent in MIXED_EXPONENTS {
            let share = 10f64.powi(exponent);
            let mixed = DualMultipliers {
                primal: mixed(&one.projected(&m.primal), &clear_primal, share),
                dual: mixed(&two.projected(&m.dual), &clear_dual, share),
                coupling: m.coupling.clone(),
            };
            out.extend(completed(&primal, &dual, mixed));
        }
    }
    out.sort_by(|one, other| other.0.total_cmp(&one.0));
    out.into_iter().take(MOST_REPAIRED).map(|(_, m)| coordinates.undo_multipliers(gamma, &m)).collect()
}

/// The mixed shares, as powers of ten.
const MIXED_EXPONENTS: std::ops::RangeInclusive<i32> = -13..=-2;

/// The largest number of repaired multipliers.
const MOST_REPAIRED: usize = 12;

/// The expected rounding in a sum of Z11, in units of the last place.
const ROUNDING_PLACES: f64 = 4.0;

/// Returns P with `P P'` close to `W W' + share V V'`, in units of their sizes, with as many columns as rows.
fn mixed(w: &Mat, v: &Mat, share: f64) -> Mat {
    let ratio = (share * w.norm_squared() / v.norm_squared()).sqrt();
    let factor = if ratio.is_finite() { ratio } else { 0.0 };
    block(&[&[w, &(v * factor)]]).transpose().qr().r().transpose()
}

/// Returns the multipliers with their coupling and the bound that they give, in units of gamma; `None` if Z11 or Z22 is
/// not clearly positive.
fn completed(
    primal: &GeneralisedPlant,
    dual: &GeneralisedPlant,
    m: DualMultipliers,
) -> Option<(f64, DualMultipliers)> {
    let (one, two) = (Moments::new(primal, &m.primal), Moments::new(dual, &m.dual));
    let (l1, l2) = (one.factor()?, two.factor()?);
    let decomposition = svd(&(one.spread(&l1).transpose() * two.spread(&l2)));
    let largest = decomposition.s.first().copied().unwrap_or(0.0);
    let kept = decomposition.s.iter().filter(|s| **s > SMALL_SINGULAR_VALUE * largest).count();
    let trace: f64 = decomposition.s.iter().take(kept).sum();
    let inverse =
        |l: &Mat, u: &Mat| Some(l.tr_solve_lower_triangular(&u.columns(0, kept))? * COUPLING_FACTOR);
    let coupling =
        (one.spread(&inverse(&l1, &decomposition.u)?), two.spread(&inverse(&l2, &decomposition.v)?));
    let bound =
        2.0 * (one.gain + two.gain + COUPLING_FACTOR * COUPLING_FACTOR * trace) / (one.size + two.size);
    bound.is_finite().then_some((bound, DualMultipliers { coupling, ..m }))
}

/// The bound used for `|K|`, below 1 so that rounding does not violate it.
const COUPLING_FACTOR: f64 = 1.0 - 1e-7;

/// The fraction of the largest below which singular values are dropped, as rounding exceeds them.
const SMALL_SINGULAR_VALUE: f64 = 1e-4;

/// Sums over the columns of P, as in the crate `certificate`.
struct Moments {
    lyapunov: Mat,
    /// The expected rounding of its entries.
    rounding: Mat,
    gain: f64,
    size: f64,
}

impl Moments {
    fn new(plant: &GeneralisedPlant, p: &Mat) -> Self {
        let s = plant.sizes();
        let inputs = p.rows(0, s.x + s.t + s.w);
        let rest = p.rows(s.x + s.t, s.w + s.z);
        let state = plant.parts.join(&[X], &[X, T, W]);
        let half = &state * inputs * p.rows(0, s.x).transpose();
        let terms = state.abs() * inputs.abs() * p.rows(0, s.x).abs().transpose();
        let output = plant.parts.join(&[Z], &[X, T, W]) * inputs;
        Self {
            lyapunov: symmetric_part(&half) * 2.0,
            rounding: symmetric_part(&terms) * (ROUNDING_PLACES * f64::EPSILON),
            gain: output.dot(&p.rows(s.x + s.t + s.w, s.z)),
            size: rest.norm_squared(),
        }
    }

    /// Returns the states with a nonzero entry.
    fn occurring(&self) -> Vec<usize> {
        (0..self.lyapunov.nrows()).filter(|i| self.lyapunov[(*i, *i)] != 0.0).collect()
    }

    /// Returns L with `Z11 = L L'` on the states that occur; `None` if Z11 is not positive beyond rounding.
    fn factor(&self) -> Option<Mat> {
        let all = self.occurring();
        let part = self.lyapunov.select_rows(&all).select_columns(&all);
        if all.is_empty() {
            return Some(part);
        }
        let size = |i: usize| self.lyapunov[(i, i)].sqrt();
        let pairs = all.iter().flat_map(|&i| all.iter().map(move |&j| (i, j)));
        let rounding = pairs.map(|(i, j)| self.rounding[(i, j)] / (size(i) * size(j))).fold(0.0, f64::max);
        let least = scaled_least_eigenvalue(&part);
        Some(part.cholesky().filter(|_| least > rounding)?.l())
    }

    /// Returns rows for all states from those of the states that occur.
    fn spread(&self, m: &Mat) -> Mat {
        let mut out = Mat::zeros(self.lyapunov.nrows(), m.ncols());
        self.occurring().iter().enumerate().for_each(|(k, &i)| out.set_row(i, &m.row(k)));
        out
    }
}

/// The plant with y = 0: `(wt, w) = H x + D eta`, `x' = A_k x + B_k eta`.
struct Kernel<'a> {
    plant: &'a GeneralisedPlant,
    noise: Mat,
    noise_inverse: Mat,
    h: Mat,
    d: Mat,
    a: Mat,
    b: Mat,
    /// The states reachable from eta.
    reached: Vec<usize>,
}

impl<'a> Kernel<'a> {
    /// Builds the kernel; `None` if the noise does not reach all measurements.
    fn new(p: &'a GeneralisedPlant) -> Option<Self> {
        let (noise, b) = (p.parts.join(&[Y], &[T, W]), p.parts.join(&[X], &[T, W]));
        let noise_inverse = pseudo_inverse(&noise, 1e-10);
        let (h, d) = (-&noise_inverse * &p.c2(), kernel(&noise));
        if (&p.c2() + &noise * &h).norm() > 1e-9 * p.c2().norm() {
            return None;
        }
        let rounded = |sum: &Mat, terms: Mat| {
            sum.zip_map(&terms, |v, size| if v.abs() <= 1e-14 * size { 0.0 } else { v })
        };
        let a = rounded(&(&p.a() + &b * &h), p.a().abs() + b.abs() * h.abs());
        let b = rounded(&(&b * &d), b.abs() * d.abs());
        let n = p.a().nrows();
        let mut reached: Vec<bool> = (0..n).map(|i| b.row(i).iter().any(|v| *v != 0.0)).collect();
        for _ in 0..n {
            for i in 0..n {
                reached[i] = reached[i] || (0..n).any(|j| reached[j] && a[(i, j)] != 0.0);
            }
        }
        let reached = (0..n).filter(|i| reached[*i]).collect();
        Some(Self { plant: p, noise, noise_inverse, h, d, a, b, reached })
    }

    /// Returns vectors projected on y = 0, with zeros for the unreachable states.
    fn projected(&self, p: &Mat) -> Mat {
        let s = self.plant.sizes();
        let mut out = p.clone();
        for i in (0..s.x).filter(|i| !self.reached.contains(i)) {
            out.row_mut(i).fill(0.0);
        }
        let y = &self.plant.c2() * out.rows(0, s.x) + &self.noise * out.rows(s.x, s.t + s.w);
        let mut inputs = out.rows_mut(s.x, s.t + s.w);
        inputs -= &self.noise_inverse * y;
        out
    }

    /// Returns vectors with a clearly positive Z11, if any.
    fn clear(&self) -> Mat {
        let rows = self.h.nrows() + self.plant.a().nrows() + self.plant.c1().nrows();
        self.gramian_root().unwrap_or_else(|| Mat::zeros(rows, 0))
    }

    fn gramian_root(&self) -> Option<Mat> {
        let (s, n) = (self.plant.sizes(), self.reached.len());
        let mut out = Mat::zeros(s.x + s.t + s.w + s.z, n);
        if n == 0 {
            return Some(out);
        }
        let part = self.a.select_rows(&self.reached).select_columns(&self.reached);
        let b = self.b.select_rows(&self.reached);
        let shift = spectral_abscissa(&part).max(0.0) + GRAMIAN_SHIFT;
        let slower = (&part - Mat::identity(n, n) * shift).transpose();
        let l = lyapunov(&slower, &(&b * b.transpose()))?.cholesky()?.l();
        let mut x = Mat::zeros(s.x, n);
        self.reached.iter().enumerate().for_each(|(k, &i)| x.set_row(i, &l.row(k)));
        // eta = B_k' L^-T
        let eta = l.solve_lower_triangular(&b)?.transpose();
        out.view_mut((0, 0), (s.x, n)).copy_from(&x);
        out.view_mut((s.x, 0), (s.t + s.w, n)).copy_from(&(&self.h * &x + &self.d * eta));
        Some(out)
    }
}

/// The excess of alpha over the fastest growth, in the unit of time of the balanced plant.
const GRAMIAN_SHIFT: f64 = 0.3;
