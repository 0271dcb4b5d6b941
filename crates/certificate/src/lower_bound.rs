//! A lower bound of the least gamma that the synthesis inequalities of a plant allow, proved in exact arithmetic.
//!
//! The inequalities (P. Apkarian, P. Gahinet, IEEE Trans. Automatic Control 40(5), 1995, with the skew scalings of G. Scorletti, L. El Ghaoui,
//! Int. J. Robust Nonlinear Control 8, 1998) have the unknowns X, Y, symmetric S, Sigma and skew T, Gamma that commute with Theta:
//!
//! ```text
//! v' L(X, S, T) v <= 0  for all v = (x, wt, w, z) with C2 x + D2t wt + D21 w = 0,     [X I; I Y] >= 0,     S, Sigma >= 0,
//! v' L(X, S, T) v = 2 x'X xd + zt'S zt - wt'S wt + 2 wt'T zt + 2 z'e - gamma (w'w + z'z)
//! xd = A x + Bt wt + B1 w,   zt = Ct x + Dtt wt + Dt1 w,   e = C1 x + D1t wt + D11 w
//! ```
//!
//! and the same with Y, Sigma, Gamma for the transposed plant. Take any vectors v_k of that kind and W = sum v_k v_k', any such W2 of the
//! transposed plant, and any Z12. What L gives, summed over them, with `tr(.)` of the coupling for `Z = [Z11 Z12; Z12' Z22]`, is
//!
//! ```text
//! 0 <= 2 tr Z12 - 2 sum z'e - 2 sum z2'e2 + gamma (sum w'w + z'z + w2'w2 + z2'z2)
//! ```
//!
//! once X, Y, S, Sigma, T and Gamma have dropped out, which they do for `Z11 = sum xd x' + x xd'`, the same for Z22, if Z >= 0; if the blocks of
//! `sum zt zt' - wt wt'` that commute with Theta are positive, for they then take S along; and if the skew part of those of
//! `sum zt wt'` is zero. All of that is checked, or brought about, without rounding: the components of v that y determines are solved
//! for in whole numbers, and the vectors are combined anew until the skew parts vanish.
//!
//! Z12 is sought as `-Z11 E F' Z22`: with Z11, Z22 positive and `E'Z11 E`, `F'Z22 F` below I, Z >= 0 whatever their conditions.
//! A state that no v reaches while y = 0, such as one of a weight on what is measured, only stands in the way of Z11 > 0: it is left out of v, as any
//! vector may be chosen.
//!
//! Without parameters the inequalities are necessary for a controller (P. Gahinet, P. Apkarian, Int. J. Robust and Nonlinear Control 4,
//! 1994): none, of any order, has a gain below the bound.

use crate::certificate::{Plant, Rows};
use crate::definite::positive_definite;
use crate::dyadic::{Dyadic, approximate_ratio};
use crate::matrix::Matrix;
use crate::whole::{Reduced, reduce, solve};

/// A guess at the best multipliers; what they prove does not depend on how they were found.
#[derive(Debug, Clone, PartialEq)]
pub struct Multipliers {
    /// A column for each v, rows x, wt, w, z.
    pub primal: Rows,
    /// The same of the transposed plant.
    pub dual: Rows,
    /// E and F, both n x k, of `Z12 = -Z11 E F' Z22`.
    pub coupling: (Rows, Rows),
}

/// A gamma below which the synthesis inequalities of the plant have no solution; `None` when the multipliers prove none.
///
/// `blocks` are the repetitions of the parameters in the plant's channels. Matrices that do not fit together prove nothing.
pub fn lower_bound(plant: &Plant, blocks: &[usize], multipliers: &Multipliers) -> Option<f64> {
    let primal = Open::new(plant, blocks)?;
    let dual = primal.transposed();
    let (one, two) = (primal.vectors(&multipliers.primal)?, dual.vectors(&multipliers.dual)?);
    // Both sets of vectors in multiples of the same number.
    let (one, two) = (one.scaled(&two.unit), two.scaled(&one.unit));
    let unit = &one.unit * &one.unit;
    let (one, two) = (primal.moments(&one, blocks)?, dual.moments(&two, blocks)?);
    // What made the skew parts vanish came with factors of its own.
    let unit = &unit * &(&one.factor * &two.factor);
    let (one, two) = (one.times(&two.factor), two.times(&one.factor));
    let (e, f) = (&multipliers.coupling.0, &multipliers.coupling.1);
    let (n, k) = (primal.sizes.x, e.first().map_or(0, Vec::len));
    let (e, f) = (matrix(e, n, k)?, matrix(f, n, k)?);
    let (left, right) = (coupled(&one.lyapunov, &e, &unit)?, coupled(&two.lyapunov, &f, &unit)?);
    // -tr Z12, the unit once more.
    let trace = (0..k).fold(Dyadic::default(), |sum, c| {
        (0..n).fold(sum, |sum, i| &sum + &(&left[(i, c)] * &right[(i, c)]))
    });
    let gain = &trace + &(&(&one.gain + &two.gain) * &unit);
    below(&gain.shifted(1), &(&(&one.size + &two.size) * &unit))
}

/// `Z11 E`, if Z11 is positive, definite in the states that occur, and `E'Z11 E < unit I`.
fn coupled(z: &Matrix, e: &Matrix, unit: &Dyadic) -> Option<Matrix> {
    let occurring: Vec<usize> = (0..z.rows).filter(|&i| (0..z.rows).any(|j| !z[(i, j)].is_zero())).collect();
    let mut part = Matrix::zeros(occurring.len(), occurring.len());
    for (a, &i) in occurring.iter().enumerate() {
        occurring.iter().enumerate().for_each(|(b, &j)| part[(a, b)] = z[(i, j)].clone());
    }
    let seen = z.times(e);
    let room = Matrix::scalar(e.cols, unit).plus(&e.transpose().times(&seen).negated());
    (definite(&part) && definite(&room)).then_some(seen)
}

fn definite(m: &Matrix) -> bool {
    positive_definite(m, &(0..m.rows).collect::<Vec<_>>()).is_ok()
}

/// The largest f64 near `a/b` that is not above it, for b > 0; `None` unless it is positive.
fn below(a: &Dyadic, b: &Dyadic) -> Option<f64> {
    if !(a.is_positive() && b.is_positive()) {
        return None;
    }
    let unit = a.last_bit()?.min(b.last_bit()?);
    let mut bound = approximate_ratio(&a.in_units(unit), &b.in_units(unit), 0);
    while bound > 0.0 && bound.is_finite() {
        let left = a + &-&(b * &Dyadic::from_f64(bound));
        if left.is_positive() || left.is_zero() {
            return Some(bound);
        }
        bound = bound.next_down();
    }
    None
}

/// A matrix of these sizes; `None` when the rows have others, or numbers that are not finite.
fn matrix(rows: &Rows, height: usize, width: usize) -> Option<Matrix> {
    let fits =
        rows.len() == height && rows.iter().all(|r| r.len() == width && r.iter().all(|x| x.is_finite()));
    fits.then(|| Matrix::from_rows(rows, width))
}

/// The weight of a state among what may be solved for.
const LAST: f64 = 1e-100;

#[derive(Clone, Copy)]
struct Sizes {
    x: usize,
    t: usize,
    w: usize,
    z: usize,
}

/// The plant without its control, the columns (x, wt, w).
struct Open {
    sizes: Sizes,
    /// xd, zt and e.
    whole: Matrix,
    /// y.
    measured: Matrix,
    /// What the control enters, rows as `whole`.
    controlled: Matrix,
}

/// Vectors v in multiples of `1/unit`, one a column.
struct Vectors {
    v: Matrix,
    unit: Dyadic,
}

/// Sums over the vectors.
struct Moments {
    /// `sum xd x' + x xd'`.
    lyapunov: Matrix,
    /// `sum z'e`.
    gain: Dyadic,
    /// `sum w'w + z'z`.
    size: Dyadic,
    /// All that is above is this many times too large.
    factor: Dyadic,
}

impl Open {
    fn new(p: &Plant, blocks: &[usize]) -> Option<Self> {
        let columns = |rows: &Rows| rows.first().map_or(0, Vec::len);
        let t = blocks.iter().try_fold(0_usize, |sum, r| sum.checked_add(*r))?;
        let s = Sizes { x: p.a.len(), t, w: columns(&p.d11), z: p.d11.len() };
        let (u, y) = (columns(&p.d12), p.c2.len());
        let stacked = |parts: &[(&Rows, usize, usize)]| -> Option<Matrix> {
            let mut out = Matrix::zeros(parts[0].1, parts.iter().map(|part| part.2).sum());
            let mut left = 0;
            for &(rows, height, width) in parts {
                out.place(0, left, &matrix(rows, height, width)?);
                left += width;
            }
            Some(out)
        };
        let row = |x: &Rows, t: &Rows, w: &Rows, height: usize| {
            stacked(&[(x, height, s.x), (t, height, s.t), (w, height, s.w)])
        };
        let mut whole = Matrix::zeros(s.x + s.t + s.z, s.x + s.t + s.w);
        whole.place(0, 0, &row(&p.a, &p.bt, &p.b1, s.x)?);
        whole.place(s.x, 0, &row(&p.ct, &p.dtt, &p.dt1, s.t)?);
        whole.place(s.x + s.t, 0, &row(&p.c1, &p.d1t, &p.d11, s.z)?);
        let mut controlled = Matrix::zeros(s.x + s.t + s.z, u);
        controlled.place(0, 0, &matrix(&p.b2, s.x, u)?);
        controlled.place(s.x, 0, &matrix(&p.dt2, s.t, u)?);
        controlled.place(s.x + s.t, 0, &matrix(&p.d12, s.z, u)?);
        Some(Self { sizes: s, whole, measured: row(&p.c2, &p.d2t, &p.d21, y)?, controlled })
    }

    fn transposed(&self) -> Self {
        Self {
            sizes: Sizes { w: self.sizes.z, z: self.sizes.w, ..self.sizes },
            whole: self.whole.transpose(),
            measured: self.controlled.transpose(),
            controlled: self.measured.transpose(),
        }
    }

    /// The vectors of a guess with the components that y = 0 determines solved for.
    fn vectors(&self, guess: &Rows) -> Option<Vectors> {
        let Sizes { x, t, w, z } = self.sizes;
        let (columns, count) = (x + t + w, guess.first()?.len());
        let mut v = matrix(guess, columns + z, count)?;
        // States are solved for where there is no noise to solve for.
        let size = |j: usize| guess[j].iter().map(|x| x * x).sum::<f64>().sqrt();
        let weight = |j: usize| if j < x { LAST } else { size(j) };
        let found = reduce(&self.measured, &(0..columns).map(weight).collect::<Vec<_>>());
        for i in self.unreached(&found) {
            (0..count).for_each(|k| v[(i, k)] = Dyadic::default());
        }
        let mut out = v.times(&Matrix::scalar(count, &found.pivot));
        for (k, &at) in found.pivots.iter().enumerate() {
            for c in 0..count {
                let free = (0..columns).filter(|j| !found.pivots.contains(j));
                let sum = free.fold(Dyadic::default(), |sum, j| &sum + &(&found.rows[(k, j)] * &v[(j, c)]));
                out[(at, c)] = -&sum;
            }
        }
        Some(Vectors { v: out, unit: found.pivot })
    }

    /// The states, not solved for, that nothing else moves while y = 0.
    fn unreached(&self, found: &Reduced) -> Vec<usize> {
        let Sizes { x, .. } = self.sizes;
        let free: Vec<usize> = (0..self.measured.cols).filter(|j| !found.pivots.contains(j)).collect();
        // xd in terms of the free components.
        let moves = |i: usize, j: usize| {
            let direct = &self.whole[(i, j)] * &found.pivot;
            let solved = found.pivots.iter().enumerate();
            !solved
                .fold(direct, |sum, (k, &at)| &sum + &-&(&self.whole[(i, at)] * &found.rows[(k, j)]))
                .is_zero()
        };
        let mut unreached: Vec<usize> = free.iter().copied().filter(|i| *i < x).collect();
        loop {
            let still = |i: &usize| free.iter().all(|j| unreached.contains(j) || !moves(*i, *j));
            let left: Vec<usize> = unreached.iter().copied().filter(still).collect();
            if left.len() == unreached.len() {
                return left;
            }
            unreached = left;
        }
    }

    /// The sums over the vectors; `None` where channels have the wrong sign.
    fn moments(&self, vectors: &Vectors, blocks: &[usize]) -> Option<Moments> {
        let Sizes { x, t, w, z } = self.sizes;
        let v = &vectors.v;
        let inputs = v.row_range(0, x + t + w);
        let seen = self.whole.times(&inputs);
        let (factor, combined) = without_skew(&seen.row_range(x, x + t), &v.row_range(x, x + t), blocks)?;
        let mixed = |m: &Matrix| combined.as_ref().map_or_else(|| m.clone(), |c| m.times(c));
        let (from, to) = (mixed(v), mixed(&seen));
        let half = to.row_range(0, x).times(&v.row_range(0, x).transpose());
        let channels = to.row_range(x, x + t).times(&seen.row_range(x, x + t).transpose());
        let inner = from.row_range(x, x + t).times(&v.row_range(x, x + t).transpose());
        let excess = channels.plus(&inner.negated());
        let mut start = 0;
        for &r in blocks {
            let block = excess.row_range(start, start + r).transpose().row_range(start, start + r);
            if !definite(&block) {
                return None;
            }
            start += r;
        }
        let dot = |a: &Matrix, b: &Matrix| -> Dyadic {
            let all = (0..a.rows).flat_map(|i| (0..a.cols).map(move |j| (i, j)));
            all.fold(Dyadic::default(), |sum, at| &sum + &(&a[at] * &b[at]))
        };
        let size = |first: usize, rows: usize| {
            dot(&from.row_range(first, first + rows), &v.row_range(first, first + rows))
        };
        Some(Moments {
            lyapunov: half.plus(&half.transpose()),
            gain: dot(&from.row_range(x + t + w, x + t + w + z), &seen.row_range(x + t, x + t + z)),
            size: &size(x + t, w) + &size(x + t + w, z),
            factor,
        })
    }
}

/// A positive definite Q, and the factor by which it is near the identity, for which `zt Q wt'` has no skew part in the blocks: `I + sum y_k C_k`
/// with as many C_k as there are conditions. No Q where there is no condition.
fn without_skew(zt: &Matrix, wt: &Matrix, blocks: &[usize]) -> Option<(Dyadic, Option<Matrix>)> {
    let one = Dyadic::from_f64(1.0);
    let count = zt.cols;
    let mut conditions = vec![];
    let mut start = 0;
    for &r in blocks {
        let pairs = (start..start + r).flat_map(|i| (i + 1..start + r).map(move |j| (i, j)));
        for (i, j) in pairs {
            // The form Q -> (zt Q wt')_ij - (zt Q wt')_ji.
            let outer =
                |i: usize, j: usize| zt.row_range(i, i + 1).transpose().times(&wt.row_range(j, j + 1));
            let form = outer(i, j).plus(&outer(j, i).negated());
            conditions.push(form.plus(&form.transpose()));
        }
        start += r;
    }
    if conditions.is_empty() {
        return Some((one, None));
    }
    // Rounded: any C_k will do.
    let steps: Vec<Matrix> = conditions.iter().map(rounded).collect();
    let dot = |a: &Matrix, b: &Matrix| -> Dyadic {
        let all = (0..count).flat_map(|i| (0..count).map(move |j| (i, j)));
        all.filter(|at| !a[*at].is_zero()).fold(Dyadic::default(), |sum, at| &sum + &(&a[at] * &b[at]))
    };
    let unit = Matrix::scalar(count, &one);
    let m = conditions.len();
    let mut system = Matrix::zeros(m, m + 1);
    for (k, form) in conditions.iter().enumerate() {
        steps.iter().enumerate().for_each(|(l, step)| system[(k, l)] = dot(form, step));
        system[(k, m)] = -&dot(form, &unit);
    }
    let (determinant, numerators) = solve(&system)?;
    let mut q = Matrix::scalar(count, &determinant);
    for (y, step) in numerators.iter().zip(&steps) {
        q = q.plus(&step.times(&Matrix::scalar(count, y)));
    }
    definite(&q).then_some((determinant, Some(q)))
}

/// The matrix with its entries rounded to f64, relative to the largest.
fn rounded(m: &Matrix) -> Matrix {
    let all = (0..m.rows).flat_map(|i| (0..m.cols).map(move |j| (i, j)));
    let top = all.clone().filter_map(|at| m[at].magnitude()).max().unwrap_or(0);
    let mut out = Matrix::zeros(m.rows, m.cols);
    all.for_each(|at| out[at] = Dyadic::from_f64(m[at].shifted(-top).to_f64()));
    out
}

impl Vectors {
    fn scaled(&self, factor: &Dyadic) -> Self {
        let v = self.v.times(&Matrix::scalar(self.v.cols, factor));
        Self { v, unit: &self.unit * factor }
    }
}

impl Moments {
    fn times(&self, factor: &Dyadic) -> Self {
        Self {
            lyapunov: self.lyapunov.times(&Matrix::scalar(self.lyapunov.rows, factor)),
            gain: &self.gain * factor,
            size: &self.size * factor,
            factor: &self.factor * factor,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// `x' = u + w1`, `z = (x, u)`, `y = x + w2`: both Riccati equations have the solution 1/sqrt(1 - 1/gamma^2), so the least gamma, at which
    /// their product is gamma^2, is sqrt 2.
    fn integrator() -> Plant {
        Plant {
            a: vec![vec![0.0]],
            bt: vec![vec![]],
            b1: vec![vec![1.0, 0.0]],
            b2: vec![vec![1.0]],
            c1: vec![vec![1.0], vec![0.0]],
            c2: vec![vec![1.0]],
            d1t: vec![vec![], vec![]],
            d11: vec![vec![0.0; 2]; 2],
            d12: vec![vec![0.0], vec![1.0]],
            d2t: vec![vec![]],
            d21: vec![vec![0.0, 1.0]],
            ..Plant::default()
        }
    }

    /// v = (x, w1, w2 = -x, z1, 0), and Z11 = 2 x w1 = Z22: E = F = 1/sqrt(Z11) couple best.
    fn guess(x: f64, w: f64, z: f64, coupling: f64) -> Multipliers {
        let column: Rows = [x, w, -x, z, 0.0].iter().map(|v| vec![*v]).collect();
        Multipliers {
            primal: column.clone(),
            dual: column,
            coupling: (vec![vec![coupling]], vec![vec![coupling]]),
        }
    }

    #[test]
    fn the_best_multipliers_prove_the_optimum() {
        let root = 0.5_f64.sqrt();
        let found =
            lower_bound(&integrator(), &[], &guess(1.0, root, root, 1.0 / (2.0 * root).sqrt() - 1e-9))
                .unwrap();
        assert!((1.414..2f64.sqrt()).contains(&found), "{found}");
        // A coupling too large, and one of the wrong size.
        assert_eq!(
            lower_bound(&integrator(), &[], &guess(1.0, root, root, 1.0 / (2.0 * root).sqrt() + 1e-9)),
            None
        );
        let wrong = Multipliers { coupling: (vec![], vec![]), ..guess(1.0, root, root, 0.0) };
        assert_eq!(lower_bound(&integrator(), &[], &wrong), None);
        assert_eq!(lower_bound(&integrator(), &[], &guess(1.0, f64::NAN, root, 0.0)), None);
    }

    proptest! {
        /// Whatever the guess, nothing above the optimum is proved.
        #[test]
        fn no_guess_proves_too_much(primal in guessed(), dual in guessed(), coupling in 0.3..1.0f64) {
            let multipliers = Multipliers { primal, dual, coupling: (vec![vec![coupling]], vec![vec![coupling]]) };
            let found = lower_bound(&integrator(), &[], &multipliers);
            prop_assert!(found.is_none_or(|bound| bound <= 2f64.sqrt()), "{found:?}");
        }
    }

    /// Two vectors near the best, the second of them short.
    fn guessed() -> impl Strategy<Value = Rows> {
        let best = [1.0, 0.5_f64.sqrt(), -1.0, 0.5_f64.sqrt(), 0.0];
        prop::collection::vec((-0.3..0.3f64, -0.1..0.1f64), 5)
            .prop_map(move |off| best.iter().zip(off).map(|(b, (one, two))| vec![b + one, two]).collect())
    }
}
