//! Multipliers of the synthesis inequalities that can be proved: brought clearly inside their own inequalities.
//!
//! With W and W2 the multipliers of the primal and the dual inequality, that of `[X I; I Y]` has the diagonal blocks
//! `Z11 = sum xd x' + x xd'` and Z22 (see the crate `certificate`, which proves the bound), and its best upper right block is known in closed
//! form: for `Z11 = L1 L1'`, `Z22 = L2 L2'` the trace of `L1 K L2'` is least over `|K| <= 1` where `-K` is the orthogonal factor of the
//! polar decomposition of `L1'L2`. At the optimum Z11 and Z22 are singular but for rounding, so W is mixed with a little of one whose Z11 is
//! clearly positive: for the gramian P of `(A_k - alpha I, B_k)`, `A_k P + P A_k' + 2 B_k B_k' = B_k B_k' + 2 alpha P`.

use crate::balance::Coordinates;
use crate::inequalities::DualMultipliers;
use crate::lyapunov::lyapunov;
use crate::matrix::{Mat, block, kernel, pseudo_inverse, scaled_least_eigenvalue, spectral_abscissa, svd, symmetric_part};
use crate::plant::GeneralisedPlant;

/// The most promising ways to repair multipliers, best first.
pub(crate) fn repaired(plant: &GeneralisedPlant, gamma: f64, found: &[DualMultipliers]) -> Vec<DualMultipliers> {
    let unit = plant.in_units_of(gamma);
    let coordinates = Coordinates::diagonal(&unit);
    let (primal, dual) = (coordinates.apply(&unit), coordinates.apply(&unit).dual());
    let (Some(clear_primal), Some(clear_dual)) = (clear(&primal), clear(&dual)) else { return vec![] };
    let mut out: Vec<(f64, DualMultipliers)> = vec![];
    for m in found.iter().map(|m| coordinates.redo_multipliers(gamma, m)) {
        for exponent in MIXED {
            let share = 10f64.powi(exponent);
            let mixed = DualMultipliers {
                primal: mixed(&m.primal, &clear_primal, share),
                dual: mixed(&m.dual, &clear_dual, share),
                coupling: Mat::zeros(0, 0),
            };
            out.extend(completed(&primal, &dual, mixed));
        }
    }
    out.sort_by(|one, other| other.0.total_cmp(&one.0));
    out.into_iter().take(TRIED).map(|(_, m)| coordinates.undo_multipliers(gamma, &m)).collect()
}

/// The shares of what is mixed in, as powers of ten.
const MIXED: std::ops::RangeInclusive<i32> = -13..=-2;

/// So many ways are worth proving.
const TRIED: usize = 8;

/// So many units of the last place are the rounding to expect in a sum that makes up Z11.
const PLACES: f64 = 64.0;

/// A K farther inside than this gives away too much of the bound.
const MOST_INSIDE: f64 = 0.1;

/// P with `P P'` near `W W' + share V V'`, in units of their sizes, and with as many columns as rows.
fn mixed(w: &Mat, v: &Mat, share: f64) -> Mat {
    let ratio = (share * w.norm_squared() / v.norm_squared()).sqrt();
    let factor = if ratio.is_finite() { ratio } else { 0.0 };
    block(&[&[w, &(v * factor)]]).transpose().qr().r().transpose()
}

/// The multipliers with their coupling and the bound that they give, in units of gamma; `None` when Z11 or Z22 is not clearly positive.
fn completed(primal: &GeneralisedPlant, dual: &GeneralisedPlant, m: DualMultipliers) -> Option<(f64, DualMultipliers)> {
    let (one, two) = (Moments::new(primal, &m.primal), Moments::new(dual, &m.dual));
    let ((l1, inside_one), (l2, inside_two)) = (one.factor()?, two.factor()?);
    // How far inside `|K| <= 1` K has to be for the rounding in Z11 and Z22 not to matter.
    let inside = inside_one.max(inside_two);
    if inside > MOST_INSIDE {
        return None;
    }
    let found = svd(&(l1.transpose() * &l2));
    let k = &found.u * found.v.transpose() * (inside - 1.0);
    let coupling = &l1 * k * l2.transpose();
    let bound = 2.0 * (one.gain + two.gain - coupling.trace()) / (one.size + two.size);
    bound.is_finite().then_some((bound, DualMultipliers { coupling, ..m }))
}

/// Sums over the columns of P, as in the crate `certificate`.
struct Moments {
    lyapunov: Mat,
    /// The rounding to expect in its entries.
    rounding: Mat,
    gain: f64,
    size: f64,
}

impl Moments {
    fn new(plant: &GeneralisedPlant, p: &Mat) -> Self {
        let s = plant.sizes();
        let inputs = p.rows(0, s.x + s.t + s.w);
        let rest = p.rows(s.x + s.t, s.w + s.z);
        let state = block(&[&[&plant.a, &plant.bt, &plant.b1]]);
        let half = &state * inputs * p.rows(0, s.x).transpose();
        let terms = state.abs() * inputs.abs() * p.rows(0, s.x).abs().transpose();
        let seen = block(&[&[&plant.c1, &plant.d1t, &plant.d11]]) * inputs;
        Self {
            lyapunov: symmetric_part(&half) * 2.0,
            rounding: symmetric_part(&terms) * (PLACES * f64::EPSILON),
            gain: seen.dot(&p.rows(s.x + s.t + s.w, s.z)),
            size: rest.norm_squared(),
        }
    }

    /// L with `Z11 = L L'`, and the rounding in Z11 over its least eigenvalue, once its diagonal is 1; `None` where Z11 is not positive.
    fn factor(&self) -> Option<(Mat, f64)> {
        let n = self.lyapunov.nrows();
        let reached: Vec<usize> = (0..n).filter(|i| self.lyapunov.row(*i).amax() > 0.0).collect();
        let part = self.lyapunov.select_rows(&reached).select_columns(&reached);
        let mut out = Mat::zeros(n, n);
        if reached.is_empty() {
            return Some((out, 0.0));
        }
        let least = scaled_least_eigenvalue(&part);
        let l = part.cholesky().filter(|_| least > 0.0)?.l();
        for (a, &i) in reached.iter().enumerate() {
            reached.iter().enumerate().for_each(|(b, &j)| out[(i, j)] = l[(a, b)]);
        }
        let size = |i: usize| self.lyapunov[(i, i)].sqrt();
        let pairs = reached.iter().flat_map(|&i| reached.iter().map(move |&j| (i, j)));
        let rounding = pairs.map(|(i, j)| self.rounding[(i, j)] / (size(i) * size(j))).fold(0.0, f64::max);
        Some((out, rounding / least))
    }
}

/// Vectors of the primal inequality with a clearly positive Z11; `None` where the noise does not reach all measurements, or w and wt
/// not all states.
fn clear(p: &GeneralisedPlant) -> Option<Mat> {
    let s = p.sizes();
    let (noise, b) = (block(&[&[&p.d2t, &p.d21]]), block(&[&[&p.bt, &p.b1]]));
    let (h, d) = (-pseudo_inverse(&noise, 1e-10) * &p.c2, kernel(&noise));
    if s.y > 0 && (&p.c2 + &noise * &h).norm() > 1e-9 * p.c2.norm() {
        return None;
    }
    let (a, b) = (&p.a + &b * &h, b * &d);
    // States that nothing reaches are left out by the proof.
    let reached: Vec<usize> = reached(p);
    let (n, part) = (reached.len(), a.select_rows(&reached).select_columns(&reached));
    let b = b.select_rows(&reached);
    let shift = spectral_abscissa(&part).max(0.0) + 1.0;
    let mut out = Mat::zeros(s.x + s.t + s.w + s.z, n);
    if n == 0 {
        return Some(out);
    }
    let slower = (&part - Mat::identity(n, n) * shift).transpose();
    let l = lyapunov(&slower, &(&b * b.transpose()))?.cholesky()?.l();
    let mut x = Mat::zeros(s.x, n);
    reached.iter().enumerate().for_each(|(k, &i)| x.set_row(i, &l.row(k)));
    // eta = B_k' L^-T
    let eta = l.solve_lower_triangular(&b)?.transpose();
    out.view_mut((0, 0), (s.x, n)).copy_from(&x);
    out.view_mut((s.x, 0), (s.t + s.w, n)).copy_from(&(h * &x + d * eta));
    Some(out)
}

/// The states that w or wt reaches.
fn reached(p: &GeneralisedPlant) -> Vec<usize> {
    let (n, b) = (p.a.nrows(), block(&[&[&p.bt, &p.b1]]));
    let mut reached: Vec<bool> = (0..n).map(|i| b.row(i).iter().any(|v| *v != 0.0)).collect();
    for _ in 0..n {
        for i in 0..n {
            reached[i] = reached[i] || (0..n).any(|j| reached[j] && p.a[(i, j)] != 0.0);
        }
    }
    (0..n).filter(|i| reached[*i]).collect()
}
