//! Lower bounds on mu of a matrix: perturbations that make `I - M Delta` singular, found and verified.
//!
//! A unit perturbation Q is improved by the first-order change of an eigenvalue lambda of `M Q`: with `M Q v = lambda
//! v` and `u* M Q = lambda u*`, `d lambda = (M* u)* dQ v / (u* v)`, and each block of Q is set where that is largest.
//! The fixed points are those of the power iteration of A. Packard, M. K. H. Fan, J. C. Doyle, "A power method for the
//! structured singular value", 27th CDC, 1988. With real scalars lambda must be real, too (`ascent`). Then
//! `Delta = Q / lambda`.
//!
//! One start is the perturbation of the upper bound: if D-G scalings are tight, the vector v that their inequality
//! nearly annihilates is that of `w = Delta z`, `z = M v` (M. K. H. Fan, A. L. Tits, J. C. Doyle, IEEE Trans. Automatic
//! Control 36(1), 1991). The others have random signs and angles.

mod annihilated;
mod ascent;
mod bound;
mod modes;
mod sequence;

pub use bound::{LowerBound, SINGULAR_RESIDUAL, checked};
pub(super) use sequence::Sequence;

use super::CMat;
use super::structure::{Block, Structure, StructureError};
use super::upper::UpperBound;
use crate::matrix::{ComplexVector, hermitian_eigenvectors, largest_singular_vectors};
use crate::stop;
use ascent::ascend;
use modes::{Mode, Modes};
use nalgebra::Complex;

/// The number of starts: for complex blocks only, and with real scalars.
const LOWER_STARTS: usize = 16;
const MIXED_STARTS: usize = 48;

/// The number of rows above which there are fewer starts with real scalars: their time grows with its third power.
const EASY_ROWS: usize = 8;

const LEAST_STARTS: usize = 4;

/// The largest number of steps from one start.
const LOWER_STEPS: usize = 300;

/// The number of steps without improvement after which a start is abandoned: with real scalars the steps may cycle.
const MOST_IDLE_STEPS: usize = 5;

/// Trial weights of the imaginary part in the choice of the initial eigenvalue.
const IMAGINARY_PRICES: [f64; 3] = [0.0, 1.0, 10.0];

/// The number of vectors of the upper bound that are tried.
const UPPER_VECTORS: usize = 3;

/// The relative gap to the upper bound at which the search ends.
const CLOSED: f64 = 1e-6;

/// Finds a small perturbation that makes `I - M Delta` singular. `None` if none is found.
///
/// # Errors
/// Returns [`StructureError`] if M does not fit the structure.
pub fn lower_bound(m: &CMat, structure: &Structure) -> Result<Option<LowerBound>, StructureError> {
    lower_bound_below(m, structure, None)
}

/// Computes [`lower_bound`] with a known upper bound.
///
/// # Errors
/// Errors of [`lower_bound`].
pub fn lower_bound_below(
    m: &CMat,
    structure: &Structure,
    upper: Option<&UpperBound>,
) -> Result<Option<LowerBound>, StructureError> {
    structure.check(m)?;
    let search = LowerSearch {
        modes: Modes::new(m, structure),
        is_mixed: structure.blocks().iter().any(|b| matches!(b, Block::Real(_))),
    };
    let enough = upper.map_or(f64::INFINITY, |upper| upper.value * (1.0 - CLOSED));
    let mut random = Sequence(0x9E37_79B9_7F4A_7C15);
    let mut best: Option<LowerBound> = None;
    let mut seen: Vec<CMat> = vec![];
    let hard = m.nrows().max(EASY_ROWS).pow(3) / EASY_ROWS.pow(3);
    let count = if search.is_mixed { (MIXED_STARTS / hard).max(LEAST_STARTS) } else { LOWER_STARTS };
    let known = upper.map_or_else(Vec::new, |upper| search.starts_of(upper));
    let plain_or_random = (0..count).map(|start| search.start(start, &mut random));
    for start in known.into_iter().chain(search.largest_start()).chain(plain_or_random) {
        for (q, mode) in search.candidates(start, &mut seen) {
            let found = ascend(&search.modes, q, mode);
            if let Some(found) = found.filter(|f| best.as_ref().is_none_or(|known| f.value > known.value)) {
                best = Some(found);
            }
        }
        if best.as_ref().is_some_and(|best| best.value >= enough) {
            break;
        }
    }
    Ok(best)
}

/// Returns the smallest perturbation near one that is known for a similar matrix.
pub(super) fn improved(m: &CMat, structure: &Structure, known: &LowerBound) -> Option<LowerBound> {
    let modes = Modes::new(m, structure);
    let q = &known.delta * Complex::new(known.value, 0.0);
    let mode = modes.nearest(&q, Complex::new(known.value, 0.0))?;
    ascend(&modes, q, mode)
}

struct LowerSearch<'a> {
    modes: Modes<'a>,
    is_mixed: bool,
}

impl LowerSearch<'_> {
    /// Returns a unit perturbation whose full blocks are the worst for each alone, by singular vectors: steps are slow
    /// if the two largest singular values are close. `None` without full blocks.
    fn largest_start(&self) -> Option<CMat> {
        let structure = self.modes.structure;
        let (mut any, mut all) = (false, true);
        let q = structure.replaced(structure.zeros(), |block, rows, cols| match block {
            Block::Full { .. } => {
                any = true;
                let part = self.modes.m.view((cols.start, rows.start), (cols.len(), rows.len())).into_owned();
                let vectors = largest_singular_vectors(&part);
                all &= vectors.is_some();
                vectors.map(|(u, v)| v * u.adjoint())
            }
            Block::Real(r) | Block::Complex(r) => Some(CMat::identity(r, r)),
        });
        (any && all).then_some(q)
    }

    /// Returns a unit perturbation: the first is the identity, the others are random, every other one with real scalars
    /// inside (-1, 1).
    fn start(&self, number: usize, random: &mut Sequence) -> CMat {
        let mut draw = || if number == 0 { 1.0 } else { random.next() };
        self.modes.structure.replaced(self.modes.structure.zeros(), |block, _, _| {
            Some(match block {
                Block::Real(r) => {
                    let drawn = draw();
                    let value = if number.is_multiple_of(2) { drawn.signum() } else { drawn };
                    CMat::identity(r, r) * Complex::new(value, 0.0)
                }
                Block::Complex(r) => {
                    CMat::identity(r, r) * Complex::from_polar(1.0, std::f64::consts::PI * (1.0 - draw()))
                }
                Block::Full { rows, cols } => {
                    let mut vector =
                        |n: usize| ComplexVector::from_fn(n, |_, _| Complex::new(draw(), draw())).normalize();
                    let (x, v) = (vector(rows), vector(cols));
                    x * v.adjoint()
                }
            })
        })
    }

    /// Returns the unit perturbations suggested by the upper bound.
    fn starts_of(&self, upper: &UpperBound) -> Vec<CMat> {
        let (m, s) = (self.modes.m, &upper.scalings);
        let phi = &s.dw * Complex::new(upper.value * upper.value, 0.0) - s.left(m);
        let Some(vectors) = hermitian_eigenvectors(&phi) else { return vec![] };
        vectors
            .column_iter()
            .take(UPPER_VECTORS)
            .map(|v| self.of_vector(&v.into_owned(), upper.value))
            .collect()
    }

    /// Returns the perturbation with `v = Delta M v`, in units of its expected size, if there is one.
    fn of_vector(&self, v: &ComplexVector, mu: f64) -> CMat {
        let z = self.modes.m * v;
        self.modes.structure.replaced(self.modes.structure.zeros(), |block, rows, cols| {
            let (w, z) = (v.rows(rows.start, rows.len()), z.rows(cols.start, cols.len()));
            let power = z.norm_squared();
            if power == 0.0 {
                return None;
            }
            Some(match block {
                Block::Real(r) => {
                    let delta = mu * z.dotc(&w).re / power;
                    CMat::identity(r, r) * Complex::new(delta.clamp(-1.0, 1.0), 0.0)
                }
                Block::Complex(r) => {
                    let delta = z.dotc(&w) * (mu / power);
                    CMat::identity(r, r) * (delta / delta.norm().max(1.0))
                }
                Block::Full { .. } => {
                    let delta = w * z.adjoint() * Complex::new(mu / power, 0.0);
                    let size = w.norm() * mu / power.sqrt();
                    delta / Complex::new(size.max(1.0), 0.0)
                }
            })
        })
    }

    /// Returns the starting points of an ascent: the start itself, and the result of [`Self::improved`], which allows a
    /// complex eigenvalue.
    fn candidates(&self, start: CMat, seen: &mut Vec<CMat>) -> Vec<(CMat, Mode)> {
        let improved = self.improved(start.clone());
        let points = if self.is_mixed { vec![start, improved] } else { vec![improved] };
        let mut out: Vec<(CMat, Mode)> = vec![];
        for q in points {
            // Many starts lead to the same point.
            if seen.contains(&q) {
                continue;
            }
            if !self.is_mixed {
                out.extend(self.rotated(&q));
            } else {
                for price in IMAGINARY_PRICES {
                    let Some(mode) = self.modes.best(&q, |v| v.re - price * v.im.abs()) else { continue };
                    if out.iter().all(|(_, other)| other.lambda != mode.lambda) {
                        out.push((q.clone(), mode));
                    }
                }
            }
            seen.push(q);
        }
        out
    }

    /// Rotates Q, complex blocks only, until the largest eigenvalue is real.
    fn rotated(&self, q: &CMat) -> Option<(CMat, Mode)> {
        let lambda = self.modes.best(q, |v| v.norm())?.lambda;
        if lambda.norm() == 0.0 {
            return None;
        }
        let rotated = q * (lambda.conj() / lambda.norm());
        let mode = self.modes.nearest(&rotated, Complex::new(lambda.norm(), 0.0))?;
        Some((rotated, mode))
    }

    /// Improves Q until its eigenvalue no longer grows; returns the best.
    fn improved(&self, mut q: CMat) -> CMat {
        let rank = |v: Complex<f64>| if self.is_mixed { v.re } else { v.norm() };
        let mut best = (f64::NEG_INFINITY, q.clone());
        let mut idle = 0;
        for _ in 0..LOWER_STEPS {
            stop::check();
            let Some(mode) = self.modes.best(&q, rank) else { break };
            let found = rank(mode.lambda);
            idle = if found > best.0 + 1e-10 * found.abs() { 0 } else { idle + 1 };
            if found > best.0 {
                best = (found, q.clone());
            }
            if idle > MOST_IDLE_STEPS {
                break;
            }
            let is_rotated = !self.is_mixed && mode.lambda.norm() > 0.0;
            let direction =
                if is_rotated { mode.lambda / mode.lambda.norm() } else { Complex::new(1.0, 0.0) };
            q = self.modes.aimed(&q, &mode, direction);
        }
        best.1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::matrix::{complex_eigenvalues, complex_singular_values};
    use crate::mu::structure::random::problem;
    use crate::mu::upper::upper_bound;
    use proptest::prelude::*;

    proptest! {
        /// The bound is never above the upper one, and the perturbation has the stated properties.
        #[test]
        #[ignore = "night: hundreds of random matrices"]
        fn the_lower_bound_is_below_the_upper_one((structure, m) in problem()) {
            let upper = upper_bound(&m, &structure).unwrap().value;
            if let Some(lower) = lower_bound(&m, &structure).unwrap() {
                prop_assert!(lower.value <= upper * (1.0 + 1e-6), "{} {upper}", lower.value);
                let n = m.nrows();
                let values = complex_singular_values(&(CMat::identity(n, n) - &m * &lower.delta));
                prop_assert!(values[n - 1] < 1e-10 * values[0].max(1.0), "{values:?}");
                prop_assert!(structure.holds(&lower.delta));
            }
        }

        /// One full block is found exactly.
        #[test]
        fn one_full_block_is_exact((_, m) in problem()) {
            let full = Structure::new(vec![Block::Full { rows: m.ncols(), cols: m.nrows() }]).unwrap();
            let largest = complex_singular_values(&m)[0];
            let found = lower_bound(&m, &full).unwrap().unwrap().value;
            prop_assert!((found / largest - 1.0).abs() < 1e-4, "{found} {largest}");
        }
    }

    /// The two largest singular values differ by 5e-4: plain steps would end between them.
    #[test]
    fn one_full_block_with_close_singular_values_is_exact() {
        let (re, im) = (
            [0.91168, -0.63015, -0.87552, 0.96397, 0.75490, -0.58537, 0.31636, 0.88796, 0.51656],
            [-0.03627, -0.95265, -0.40091, -0.83276, 0.35872, -0.41558, -0.15946, -0.94792, 0.64382],
        );
        let m = CMat::from_fn(3, 3, |i, j| Complex::new(re[i + 3 * j], im[i + 3 * j]));
        let full = Structure::new(vec![Block::Full { rows: 3, cols: 3 }]).unwrap();
        let values = complex_singular_values(&m);
        let found = lower_bound(&m, &full).unwrap().unwrap().value;
        assert!((found / values[0] - 1.0).abs() < 1e-12, "{found} {values:?}");
    }

    /// One repeated real scalar and a real matrix: mu is its largest real eigenvalue, with larger complex ones present.
    #[test]
    fn a_real_eigenvalue_below_complex_ones_is_found() {
        let m = nalgebra::dmatrix![0.0, 5.0, 0.3; -5.0, 0.0, -0.2; 0.1, 0.4, -1.5].map(Complex::from);
        let right = complex_eigenvalues(&m).into_iter().filter(|v| v.im == 0.0).map(|v| v.re.abs());
        let found = lower_bound(&m, &Structure::new(vec![Block::Real(3)]).unwrap()).unwrap().unwrap();
        assert!((found.value - right.fold(0.0, f64::max)).abs() < 1e-9, "{}", found.value);
    }

    /// The least singular value of `I - M Delta` with entries of 1e17 is only rounding.
    #[test]
    fn a_perturbation_singular_by_rounding_only_is_rejected() {
        let m = nalgebra::dmatrix![1.0, 1.0; -1.0, -1.0 - 1e-15].map(Complex::from);
        let structure = Structure::new(vec![Block::Real(2)]).unwrap();
        let size = Complex::new(1e17, 0.0);
        assert_eq!(checked(&m, &structure, CMat::identity(2, 2) * size), None);
    }
}
