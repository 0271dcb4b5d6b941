//! Lower bound on the gamma for which the synthesis inequalities of a plant are feasible, proved in exact arithmetic.
//!
//! The plant has no parameters. The inequalities (P. Gahinet, P. Apkarian, Int. J. Robust and Nonlinear Control 4,
//! 1994) have the symmetric unknowns X and Y:
//!
//! ```text
//! v' L(X) v <= 0  for all v = (x, w, z) with C2 x + D21 w = 0,     [X I; I Y] >= 0,
//! v' L(X) v = 2 x'X xd + 2 z'e - gamma (w'w + z'z),     xd = A x + B1 w,     e = C1 x + D11 w
//! ```
//!
//! and the same with Y for the transposed plant. For any such vectors v_k, any such vectors of the transposed plant
//! (subscript 2), and any Z12, the sum of their inequalities and of `tr(Z [X I; I Y]) >= 0` with
//! `Z = [Z11 Z12; Z12' Z22] >= 0` is
//!
//! ```text
//! 0 <= 2 tr Z12 - 2 sum z'e - 2 sum z2'e2 + gamma (sum w'w + z'z + w2'w2 + z2'z2)
//! ```
//!
//! where X and Y cancel for `Z11 = sum xd x' + x xd'` and the corresponding Z22. Z >= 0 is checked without rounding:
//! the components of v determined by `C2 x + D21 w = 0` are solved for in integers.
//!
//! Z12 has the form `-Z11 E F' Z22`: with Z11, Z22 positive and `E'Z11 E`, `F'Z22 F` below I, Z >= 0 even if they are
//! ill-conditioned. A state that no v reaches while y = 0, such as that of a weight on a measurement, makes Z11
//! singular. It is set to zero in v, which is allowed because v is arbitrary.
//!
//! The inequalities are necessary: no controller of any order achieves a gain below the bound.

use crate::exact::definite::positive_definite;
use crate::exact::dyadic::{Dyadic, approximate_ratio};
use crate::exact::matrix::Matrix;
use crate::exact::whole::{Reduced, reduce};
use crate::plant::{Plant, Rows};
use crate::shape::columns;

/// Approximately optimal multipliers; the proof is independent of their computation.
#[derive(Debug, Clone, PartialEq)]
pub struct Multipliers {
    /// Vectors v, one per column, with the rows x, w, z.
    pub primal: Rows,
    /// Vectors v of the transposed plant, one per column.
    pub dual: Rows,
    /// Matrices E and F, both n x k, of `Z12 = -Z11 E F' Z22`.
    pub coupling: (Rows, Rows),
}

/// Returns a gamma below which the synthesis inequalities of the plant have no solution.
///
/// Returns `None` if the multipliers prove no bound, the plant has parameters, or sizes do not agree.
pub fn lower_bound(plant: &Plant, multipliers: &Multipliers) -> Option<f64> {
    let primal = OpenPlant::new(plant)?;
    let dual = primal.transposed();
    let ((v1, unit1), (v2, unit2)) = (primal.vectors(&multipliers.primal)?, dual.vectors(&multipliers.dual)?);
    // Both sets of vectors are scaled to the same unit.
    let (one, two) = (primal.moments(&v1.scaled(&unit2)), dual.moments(&v2.scaled(&unit1)));
    let unit = &unit1 * &unit2;
    let unit = &unit * &unit;
    let (e, f) = (&multipliers.coupling.0, &multipliers.coupling.1);
    let (n, k) = (primal.sizes.x, columns(e));
    let (e, f) = (matrix(e, n, k)?, matrix(f, n, k)?);
    let (remaining, right) = (coupled(&one.lyapunov, &e, &unit)?, coupled(&two.lyapunov, &f, &unit)?);
    // The gain is -tr Z12, with a further factor of the unit.
    let gain = &remaining.dot(&right) + &(&(&one.gain + &two.gain) * &unit);
    round_down_ratio(&gain.shifted(1), &(&(&one.size + &two.size) * &unit))
}

/// Returns `Z11 E` if Z11 is positive definite in the states that occur and `E'Z11 E < unit I`.
fn coupled(z: &Matrix, e: &Matrix, unit: &Dyadic) -> Option<Matrix> {
    let occurring: Vec<usize> = (0..z.rows).filter(|&i| (0..z.rows).any(|j| !z[(i, j)].is_zero())).collect();
    let product = z.times(e);
    let slack = Matrix::scalar(e.cols, unit).plus(&e.transpose().times(&product).negated());
    (definite(&z.principal(&occurring)) && definite(&slack)).then_some(product)
}

fn definite(m: &Matrix) -> bool {
    positive_definite(m, &(0..m.rows).collect::<Vec<_>>()).is_ok()
}

/// Returns `a/b`, for b > 0, rounded down to a nearby f64; `None` unless it is positive.
fn round_down_ratio(a: &Dyadic, b: &Dyadic) -> Option<f64> {
    if !(a.is_positive() && b.is_positive()) {
        return None;
    }
    let unit = a.last_bit()?.min(b.last_bit()?);
    let mut bound = approximate_ratio(&a.in_units(unit), &b.in_units(unit), 0);
    while bound > 0.0 && bound.is_finite() {
        let remaining = a + &-&(b * &Dyadic::from_f64(bound));
        if remaining.is_positive() || remaining.is_zero() {
            return Some(bound);
        }
        bound = bound.next_down();
    }
    None
}

/// Returns a matrix of the given sizes; `None` if the rows have other sizes or a number is not finite.
fn matrix(rows: &Rows, height: usize, width: usize) -> Option<Matrix> {
    let fits =
        rows.len() == height && rows.iter().all(|r| r.len() == width && r.iter().all(|x| x.is_finite()));
    fits.then(|| Matrix::from_rows(rows, width))
}

/// Pivoting weight of a state: y = 0 is solved for components of w first, and for states only if no noise acts on y.
const STATE_WEIGHT: f64 = 1e-100;

#[derive(Clone, Copy)]
struct Sizes {
    x: usize,
    w: usize,
    z: usize,
}

/// Plant without its control, with the columns (x, w).
struct OpenPlant {
    sizes: Sizes,
    /// Rows xd and e.
    open: Matrix,
    /// Rows y.
    measured: Matrix,
    /// Columns of the control, with the rows of `open`.
    controlled: Matrix,
}

/// Sums over the vectors v.
struct Moments {
    /// `sum xd x' + x xd'`.
    lyapunov: Matrix,
    /// `sum z'e`.
    gain: Dyadic,
    /// `sum w'w + z'z`.
    size: Dyadic,
}

impl OpenPlant {
    fn new(p: &Plant) -> Option<Self> {
        if !p.ct.is_empty() {
            return None;
        }
        let s = Sizes { x: p.a.len(), w: columns(&p.d11), z: p.d11.len() };
        let (u, y) = (columns(&p.d12), p.c2.len());
        let mut open = Matrix::zeros(s.x + s.z, s.x + s.w);
        open.place(0, 0, &matrix(&p.a, s.x, s.x)?);
        open.place(0, s.x, &matrix(&p.b1, s.x, s.w)?);
        open.place(s.x, 0, &matrix(&p.c1, s.z, s.x)?);
        open.place(s.x, s.x, &matrix(&p.d11, s.z, s.w)?);
        let mut measured = Matrix::zeros(y, s.x + s.w);
        measured.place(0, 0, &matrix(&p.c2, y, s.x)?);
        measured.place(0, s.x, &matrix(&p.d21, y, s.w)?);
        let mut controlled = Matrix::zeros(s.x + s.z, u);
        controlled.place(0, 0, &matrix(&p.b2, s.x, u)?);
        controlled.place(s.x, 0, &matrix(&p.d12, s.z, u)?);
        Some(Self { sizes: s, open, measured, controlled })
    }

    fn transposed(&self) -> Self {
        Self {
            sizes: Sizes { w: self.sizes.z, z: self.sizes.w, ..self.sizes },
            open: self.open.transpose(),
            measured: self.controlled.transpose(),
            controlled: self.measured.transpose(),
        }
    }

    /// Returns the vectors v of a guess, one per column, with the components determined by y = 0 replaced; they are
    /// multiplied by the returned number.
    fn vectors(&self, guess: &Rows) -> Option<(Matrix, Dyadic)> {
        let Sizes { x, w, z } = self.sizes;
        let (columns, count) = (x + w, guess.first()?.len());
        let mut v = matrix(guess, columns + z, count)?;
        let size = |j: usize| guess[j].iter().map(|x| x * x).sum::<f64>().sqrt();
        let weight = |j: usize| if j < x { STATE_WEIGHT } else { size(j) };
        let reduced = reduce(&self.measured, &(0..columns).map(weight).collect::<Vec<_>>());
        for i in self.unreached(&reduced) {
            (0..count).for_each(|k| v[(i, k)] = Dyadic::default());
        }
        let mut out = v.scaled(&reduced.pivot);
        for (k, &at) in reduced.pivots.iter().enumerate() {
            for c in 0..count {
                let free = (0..columns).filter(|j| !reduced.pivots.contains(j));
                let sum = free.fold(Dyadic::default(), |sum, j| &sum + &(&reduced.rows[(k, j)] * &v[(j, c)]));
                out[(at, c)] = -&sum;
            }
        }
        Some((out, reduced.pivot))
    }

    /// Returns the free states that nothing else drives while y = 0.
    fn unreached(&self, reduced: &Reduced) -> Vec<usize> {
        let Sizes { x, .. } = self.sizes;
        let free: Vec<usize> = (0..self.measured.cols).filter(|j| !reduced.pivots.contains(j)).collect();
        // Checks for an effect of free component j on xd_i.
        let drives = |i: usize, j: usize| {
            let direct = &self.open[(i, j)] * &reduced.pivot;
            let solved = reduced.pivots.iter().enumerate();
            !solved
                .fold(direct, |sum, (k, &at)| &sum + &-&(&self.open[(i, at)] * &reduced.rows[(k, j)]))
                .is_zero()
        };
        let mut unreached: Vec<usize> = free.iter().copied().filter(|i| *i < x).collect();
        loop {
            let still = |i: &usize| free.iter().all(|j| unreached.contains(j) || !drives(*i, *j));
            let remaining: Vec<usize> = unreached.iter().copied().filter(still).collect();
            if remaining.len() == unreached.len() {
                return remaining;
            }
            unreached = remaining;
        }
    }

    /// Returns the sums over the vectors v.
    fn moments(&self, v: &Matrix) -> Moments {
        let Sizes { x, w, z } = self.sizes;
        let outputs = self.open.times(&v.row_range(0, x + w));
        let half = outputs.row_range(0, x).times(&v.row_range(0, x).transpose());
        let rest = v.row_range(x, x + w + z);
        Moments {
            lyapunov: half.plus(&half.transpose()),
            gain: v.row_range(x + w, x + w + z).dot(&outputs.row_range(x, x + z)),
            size: rest.dot(&rest),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// `x' = u + w1`, `z = (x, u)`, `y = x + w2`: both Riccati equations have the solution 1/sqrt(1 - 1/gamma^2), so
    /// the minimal gamma, at which their product is gamma^2, is sqrt 2.
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

    /// Returns multipliers with v = (x, w1, w2 = -x, z1, 0) and Z11 = 2 x w1 = Z22; the best coupling is E = F =
    /// 1/sqrt(Z11).
    fn guess(x: f64, w: f64, z: f64, coupling: f64) -> Multipliers {
        let column: Rows = [x, w, -x, z, 0.0].iter().map(|v| vec![*v]).collect();
        Multipliers {
            primal: column.clone(),
            dual: column,
            coupling: (vec![vec![coupling]], vec![vec![coupling]]),
        }
    }

    #[test]
    fn best_multipliers_prove_optimum() {
        let root = 0.5_f64.sqrt();
        let found =
            lower_bound(&integrator(), &guess(1.0, root, root, 1.0 / (2.0 * root).sqrt() - 1e-9)).unwrap();
        assert!((1.414..2f64.sqrt()).contains(&found), "{found}");
        // A coupling that is too large or has the wrong size proves nothing.
        assert_eq!(
            lower_bound(&integrator(), &guess(1.0, root, root, 1.0 / (2.0 * root).sqrt() + 1e-9)),
            None
        );
        let wrong = Multipliers { coupling: (vec![], vec![]), ..guess(1.0, root, root, 0.0) };
        assert_eq!(lower_bound(&integrator(), &wrong), None);
        assert_eq!(lower_bound(&integrator(), &guess(1.0, f64::NAN, root, 0.0)), None);
    }

    proptest! {
        /// Checks that no guess proves a bound above the optimum.
        #[test]
        fn no_guess_proves_more_than_optimum(primal in guessed(), dual in guessed(), coupling in 0.3..1.0f64) {
            let multipliers = Multipliers { primal, dual, coupling: (vec![vec![coupling]], vec![vec![coupling]]) };
            let found = lower_bound(&integrator(), &multipliers);
            prop_assert!(found.is_none_or(|bound| bound <= 2f64.sqrt()), "{found:?}");
        }
    }

    /// Returns two vectors, one near the best and a short one.
    fn guessed() -> impl Strategy<Value = Rows> {
        let best = [1.0, 0.5_f64.sqrt(), -1.0, 0.5_f64.sqrt(), 0.0];
        prop::collection::vec((-0.3..0.3f64, -0.1..0.1f64), 5)
            .prop_map(move |off| best.iter().zip(off).map(|(b, (one, two))| vec![b + one, two]).collect())
    }
}
