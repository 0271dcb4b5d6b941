//! Lower bounds on mu of a matrix: perturbations that make `I - M Delta` singular, found and then checked.
//!
//! A unit perturbation Q is improved by the first-order change of an eigenvalue lambda of `M Q`: with `M Q v = lambda
//! v` and `u* M Q = lambda u*`, `d lambda = (M* u)* dQ v / (u* v)`, and each block of Q is put where that is largest.
//! Its fixed points are those of the power iteration of A. Packard, M. K. H. Fan, J. C. Doyle, "A power method for
//! the structured singular value", 27th CDC, 1988, and for real scalars of P. M. Young, J. C. Doyle, "Computation of
//! mu with real and complex uncertainties", 29th CDC, 1990. What it settles on is made exact by turning the complex
//! blocks, or moving one real scalar, until lambda is real: then `Delta = Q / lambda`.

use super::CMat;
use super::annihilated::annihilated;
use super::balance::Balance;
use super::centre::ZERO_MU;
use super::product::product;
use super::structure::{Block, Structure, StructureError};
use crate::matrix::{
    ComplexVector, complex_eigenvalues, complex_singular_values, largest_complex_singular_value,
    largest_singular_vectors,
};
use crate::stop;
use nalgebra::Complex;

/// A perturbation that makes `I - M Delta` singular.
#[derive(Debug, Clone, PartialEq)]
pub struct LowerBound {
    /// mu is at least this: one over the size of Delta.
    pub value: f64,
    /// The perturbation.
    pub delta: CMat,
    /// The frequency, rad/s, where M is a frequency response.
    pub frequency: Option<f64>,
    /// The least singular value of `I - M Delta`, relative to the largest, at least 1.
    pub residual: f64,
}

/// A residual below this counts as zero.
pub const SINGULAR_RESIDUAL: f64 = 1e-12;

/// How many perturbations the search starts from.
const LOWER_STARTS: usize = 16;

/// Steps from one start.
const LOWER_STEPS: usize = 300;

/// Steps without improvement after which a start is given up: with real scalars the steps may go round.
const MOST_IDLE_STEPS: usize = 5;

/// Newton steps that make an eigenvalue real.
const MOST_CORRECTIONS: usize = 12;

/// Looks for the smallest perturbation that makes `I - M Delta` singular. `None` when none is found.
///
/// # Errors
/// [`StructureError`] when M does not fit the structure.
pub fn lower_bound(m: &CMat, structure: &Structure) -> Result<Option<LowerBound>, StructureError> {
    structure.check(m)?;
    let search = LowerSearch {
        m,
        structure,
        is_mixed: structure.blocks().iter().any(|b| matches!(b, Block::Real(_))),
    };
    let mut random = Sequence(0x9E37_79B9_7F4A_7C15);
    let mut best: Option<LowerBound> = None;
    let mut tops: Vec<CMat> = vec![];
    let plain_or_random = (0..LOWER_STARTS).map(|start| search.start(start, &mut random));
    for start in search.largest_start().into_iter().chain(plain_or_random) {
        let q = search.climb(start);
        // Many starts lead to the same.
        if tops.contains(&q) {
            continue;
        }
        for found in search.exact(&q) {
            if best.as_ref().is_none_or(|known| found.value > known.value) {
                best = Some(found);
            }
        }
        tops.push(q);
    }
    Ok(best)
}

/// A perturbation that was evaluated and makes `I - M Delta` singular; `None` when it does not, or is so large that
/// rounding alone would make it so.
pub fn checked(m: &CMat, structure: &Structure, delta: CMat) -> Option<LowerBound> {
    let n = m.nrows();
    let values = complex_singular_values(&(CMat::identity(n, n) - m * &delta));
    let residual = values.last()? / values.first()?.max(1.0);
    let size = complex_singular_values(&delta).first().copied()?;
    let own = Balance::new(std::slice::from_ref(m), structure).matrices;
    // Of a larger perturbation nothing but the rounding of M would be seen.
    let largest = own.iter().map(largest_complex_singular_value).fold(0.0, f64::max);
    let is_seen = size > 0.0 && size * largest * ZERO_MU <= 1.0;
    let sound = residual <= SINGULAR_RESIDUAL && structure.holds(&delta) && is_seen;
    sound.then(|| LowerBound { value: 1.0 / size, delta, frequency: None, residual })
}

/// Numbers that look random and are the same in every run.
pub(super) struct Sequence(pub(super) u64);

impl Sequence {
    fn bits(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    /// In [-1, 1].
    fn next(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// 1 or -1.
    pub(super) fn sign(&mut self) -> f64 {
        if self.bits() & (1 << 30) == 0 { 1.0 } else { -1.0 }
    }
}

/// An eigenvalue of `M Q`, and `M* u` and v, with `u* v = 1`.
#[derive(Clone)]
struct Mode {
    lambda: Complex<f64>,
    x: ComplexVector,
    v: ComplexVector,
}

struct LowerSearch<'a> {
    m: &'a CMat,
    structure: &'a Structure,
    is_mixed: bool,
}

impl LowerSearch<'_> {
    /// A unit perturbation with the full blocks that are the worst each by itself, by singular vectors: steps go slowly
    /// where the two largest singular values are close. `None` without full blocks.
    fn largest_start(&self) -> Option<CMat> {
        let mut q = CMat::zeros(self.structure.rows(), self.structure.cols());
        let mut any = false;
        for (block, rows, cols) in self.structure.places() {
            let part = match block {
                Block::Full { .. } => {
                    any = true;
                    let own = self.m.view((cols.start, rows.start), (cols.len(), rows.len())).into_owned();
                    let (u, v) = largest_singular_vectors(&own)?;
                    v * u.adjoint()
                }
                Block::Real(r) | Block::Complex(r) => CMat::identity(r, r),
            };
            q.view_mut((rows.start, cols.start), part.shape()).copy_from(&part);
        }
        any.then_some(q)
    }

    /// A unit perturbation: the first ones plain, the others at random.
    fn start(&self, number: usize, random: &mut Sequence) -> CMat {
        let mut q = CMat::zeros(self.structure.rows(), self.structure.cols());
        for (block, rows, cols) in self.structure.places() {
            let mut draw = || if number == 0 { 1.0 } else { random.next() };
            let part = match block {
                Block::Real(r) => CMat::identity(r, r) * Complex::new(draw().signum(), 0.0),
                Block::Complex(r) => {
                    CMat::identity(r, r) * Complex::from_polar(1.0, std::f64::consts::PI * (1.0 - draw()))
                }
                Block::Full { rows, cols } => {
                    let mut vector =
                        |n: usize| ComplexVector::from_fn(n, |_, _| Complex::new(draw(), draw())).normalize();
                    let (x, v) = (vector(rows), vector(cols));
                    x * v.adjoint()
                }
            };
            q.view_mut((rows.start, cols.start), part.shape()).copy_from(&part);
        }
        q
    }

    /// Improves Q until it gets no better; returns the best.
    fn climb(&self, mut q: CMat) -> CMat {
        let mut best = (f64::NEG_INFINITY, q.clone());
        let mut idle = 0;
        for _ in 0..LOWER_STEPS {
            stop::check();
            let Some(mode) = self.best_mode(&q) else { break };
            let height = if self.is_mixed { mode.lambda.re } else { mode.lambda.norm() };
            idle = if height > best.0 + 1e-10 * height.abs() { 0 } else { idle + 1 };
            if height > best.0 {
                best = (height, q.clone());
            }
            if idle > MOST_IDLE_STEPS {
                break;
            }
            q = self.improved(&q, &mode);
        }
        best.1
    }

    /// The eigenvalue farthest to the right, or of the largest modulus where all blocks can be turned.
    fn best_mode(&self, q: &CMat) -> Option<Mode> {
        let rank = |v: &Complex<f64>| if self.is_mixed { v.re } else { v.norm() };
        let values = complex_eigenvalues(&product(self.m, q));
        let lambda =
            values.into_iter().filter(|v| v.re.is_finite()).max_by(|a, b| rank(a).total_cmp(&rank(b)))?;
        self.mode(q, lambda)
    }

    fn mode(&self, q: &CMat, lambda: Complex<f64>) -> Option<Mode> {
        let n = self.m.nrows();
        let (u, v) = annihilated(product(self.m, q) - CMat::identity(n, n) * lambda)?;
        let product = u.dotc(&v);
        if product.norm() < 1e-12 {
            return None;
        }
        // u* v = 1
        Some(Mode { lambda, x: self.m.adjoint() * u / product.conj(), v })
    }

    /// The eigenvalue of `M Q` next to one that is known.
    fn followed(&self, q: &CMat, near: Complex<f64>) -> Option<Mode> {
        let values = complex_eigenvalues(&product(self.m, q));
        let lambda = values.into_iter().min_by(|a, b| (a - near).norm().total_cmp(&(b - near).norm()))?;
        self.mode(q, lambda)
    }

    /// Each block where the eigenvalue grows most.
    fn improved(&self, q: &CMat, mode: &Mode) -> CMat {
        let turn = if self.is_mixed || mode.lambda.norm() == 0.0 {
            Complex::new(1.0, 0.0)
        } else {
            mode.lambda.conj() / mode.lambda.norm()
        };
        let mut out = q.clone();
        for (block, rows, cols) in self.structure.places() {
            let x = mode.x.rows(rows.start, rows.len());
            let v = mode.v.rows(cols.start, cols.len());
            let slope = || turn * x.dotc(&v);
            let part = match block {
                Block::Real(r) if slope().re != 0.0 => {
                    CMat::identity(r, r) * Complex::new(slope().re.signum(), 0.0)
                }
                Block::Complex(r) if slope().norm() > 0.0 => {
                    CMat::identity(r, r) * (slope().conj() / slope().norm())
                }
                Block::Full { .. } if x.norm() > 0.0 && v.norm() > 0.0 => {
                    x.unscale(x.norm()) * v.unscale(v.norm()).adjoint() * turn.conj()
                }
                _ => continue,
            };
            out.view_mut((rows.start, cols.start), part.shape()).copy_from(&part);
        }
        out
    }

    /// Perturbations near Q for which an eigenvalue of `M Q` is real and positive.
    fn exact(&self, q: &CMat) -> Vec<LowerBound> {
        let Some(mode) = self.best_mode(q) else { return vec![] };
        if !self.is_mixed {
            let turned = q * (mode.lambda.conj() / mode.lambda.norm());
            let delta = turned / Complex::new(mode.lambda.norm(), 0.0);
            return checked(self.m, self.structure, delta).into_iter().collect();
        }
        let knobs = self.structure.places();
        let turns = std::iter::once(None)
            .chain((0..knobs.len()).filter(|k| matches!(knobs[*k].0, Block::Real(_))).map(Some));
        turns.filter_map(|knob| self.made_real(q, mode.clone(), knob)).collect()
    }

    /// Turns all complex blocks, or moves one real scalar, until the eigenvalue followed is real.
    fn made_real(&self, q: &CMat, mut mode: Mode, knob: Option<usize>) -> Option<LowerBound> {
        let places = self.structure.places();
        let mut q = q.clone();
        for _ in 0..MOST_CORRECTIONS {
            let near = mode.lambda;
            if near.im.abs() <= 1e-13 * near.norm() {
                break;
            }
            // d lambda by the angle of all complex blocks, or by the scalar.
            let slope: Complex<f64> = match knob {
                None => {
                    let of = places.iter().filter(|(block, ..)| !matches!(block, Block::Real(_)));
                    let part = |rows: &std::ops::Range<usize>, cols: &std::ops::Range<usize>| {
                        let inner = q.view((rows.start, cols.start), (rows.len(), cols.len()));
                        mode.x
                            .rows(rows.start, rows.len())
                            .dotc(&(inner * mode.v.rows(cols.start, cols.len())))
                    };
                    Complex::new(0.0, 1.0) * of.map(|(_, rows, cols)| part(rows, cols)).sum::<Complex<f64>>()
                }
                Some(k) => {
                    let (_, rows, cols) = &places[k];
                    mode.x.rows(rows.start, rows.len()).dotc(&mode.v.rows(cols.start, cols.len()))
                }
            };
            if slope.im == 0.0 {
                return None;
            }
            let step = -near.im / slope.im;
            self.turn(&mut q, knob, step)?;
            mode = self.followed(&q, near)?;
        }
        let near = mode.lambda;
        if near.re <= 0.0 {
            return None;
        }
        checked(self.m, self.structure, q / Complex::new(near.re, 0.0))
    }

    fn turn(&self, q: &mut CMat, knob: Option<usize>, step: f64) -> Option<()> {
        for (k, (block, rows, cols)) in self.structure.places().into_iter().enumerate() {
            let mut part = q.view_mut((rows.start, cols.start), (rows.len(), cols.len()));
            match knob {
                None if !matches!(block, Block::Real(_)) => {
                    part *= Complex::from_polar(1.0, step.clamp(-0.5, 0.5))
                }
                Some(chosen) if chosen == k => {
                    let next = part[(0, 0)].re + step;
                    if !(-1.0..=1.0).contains(&next) {
                        return None;
                    }
                    let r = rows.len();
                    part.copy_from(&(CMat::identity(r, r) * Complex::new(next, 0.0)));
                }
                _ => {}
            }
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mu::structure::random::problem;
    use crate::mu::upper::upper_bound;
    use proptest::prelude::*;

    proptest! {
        /// Never above the bound from above; and what is returned is what it says.
        #[test]
        fn below_the_upper_bound((structure, m) in problem()) {
            let upper = upper_bound(&m, &structure).unwrap().value;
            if let Some(lower) = lower_bound(&m, &structure).unwrap() {
                prop_assert!(lower.value <= upper * (1.0 + 1e-6), "{} {upper}", lower.value);
                let n = m.nrows();
                let values = complex_singular_values(&(CMat::identity(n, n) - &m * &lower.delta));
                prop_assert!(values[n - 1] < 1e-10 * values[0].max(1.0), "{values:?}");
                prop_assert!(structure.holds(&lower.delta));
            }
        }

        /// One full block, and one repeated complex scalar, are found exactly.
        #[test]
        fn one_block_is_exact((_, m) in problem()) {
            let full = Structure::new(vec![Block::Full { rows: m.ncols(), cols: m.nrows() }]).unwrap();
            let largest = complex_singular_values(&m)[0];
            let found = lower_bound(&m, &full).unwrap().unwrap().value;
            prop_assert!((found / largest - 1.0).abs() < 1e-4, "{found} {largest}");
        }
    }

    /// The two largest singular values differ by 5e-4: steps alone end between them.
    #[test]
    fn one_full_block_with_singular_values_that_are_close() {
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
}
