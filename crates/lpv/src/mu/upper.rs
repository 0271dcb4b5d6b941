//! An upper bound on mu of a matrix, with the D-G scalings that show it.
//!
//! The least beta for which scalings exist is sought by the method of centres: S. Boyd, L. El Ghaoui, "Method of centers for
//! minimizing generalized eigenvalues", Linear Algebra and its Applications 188, 1993, with lambda = beta^2 moving along.

use super::CMat;
use super::scaling::Family;
pub use super::scaling::Scalings;
use super::structure::{Structure, StructureError};
use crate::matrix::{complex_singular_values, hermitian_eigenvalues};
use nalgebra::{Cholesky, Complex, DMatrix, DVector, Dyn};

/// A bound with the scalings that show it.
#[derive(Debug, Clone, PartialEq)]
pub struct UpperBound {
    /// mu is at most this.
    pub value: f64,
    /// `M* D M + j (G M - M* G) <= value^2 D`, by eigenvalues.
    pub scalings: Scalings,
    /// About how far the bound may be above the least that D-G scalings allow, relative to itself; infinite when that was not asked.
    pub gap: f64,
}

/// How close to the least bound, relatively, is close enough.
pub const TIGHT: f64 = 2e-5;

/// A bound below this fraction of the largest singular value counts as zero: real blocks often have a mu of zero.
pub const NOTHING: f64 = 1e-7;

/// Bounds mu of M.
///
/// # Errors
/// [`StructureError`] when M does not fit the structure.
pub fn upper_bound(m: &CMat, structure: &Structure) -> Result<UpperBound, StructureError> {
    structure.check(m)?;
    Ok(search(m, structure, 0.0))
}

/// Looks for scalings that show `mu <= level` and hold there as clearly as they can; where there are none, for the best.
///
/// # Errors
/// [`StructureError`] when M does not fit the structure.
pub fn bound_at_level(m: &CMat, structure: &Structure, level: f64) -> Result<UpperBound, StructureError> {
    structure.check(m)?;
    Ok(search(m, structure, level))
}

fn search(m: &CMat, structure: &Structure, level: f64) -> UpperBound {
    let balance = Balance::new(m, structure);
    let size = complex_singular_values(&balance.matrix).first().copied().unwrap_or(0.0);
    if size == 0.0 {
        let family = Family::new(structure);
        return UpperBound { value: 0.0, scalings: family.values(&family.identity()), gap: 0.0 };
    }
    let matrix = &balance.matrix / Complex::new(size, 0.0);
    let mut centre = Centre::new(&matrix, structure);
    let target = (level / size).powi(2);
    let (lambda, gap) = centre.least(target);
    let value = size * lambda.max(NOTHING * NOTHING).sqrt();
    // lambda = beta^2: half of its relative gap is that of beta.
    let gap = if lambda > NOTHING * NOTHING { 0.5 * gap / lambda } else { 0.0 };
    let scalings = centre.family.values(&centre.p).undone(&balance.tw, &balance.tz, size);
    UpperBound { value, scalings, gap }
}

/// `T_z M T_w^-1` with a scalar for each block, so that blocks that meet are of one size.
///
/// E. E. Osborne, J. ACM 7(4), 1960; as a bound on mu M. G. Safonov, IEE Proc. D 129(6), 1982.
struct Balance {
    matrix: CMat,
    tw: Vec<f64>,
    tz: Vec<f64>,
}

impl Balance {
    fn new(m: &CMat, structure: &Structure) -> Self {
        let places = structure.places();
        let size = |i: usize, j: usize| {
            let (rows, cols) = (&places[i].2, &places[j].1);
            m.view((rows.start, cols.start), (rows.len(), cols.len())).norm_squared()
        };
        let n = places.len();
        let squares = DMatrix::from_fn(n, n, size);
        let mut t = vec![1.0f64; n];
        for _ in 0..10 {
            for k in 0..n {
                let others = || (0..n).filter(|j| *j != k);
                let row: f64 = others().map(|j| squares[(k, j)] / (t[j] * t[j])).sum();
                let column: f64 = others().map(|i| squares[(i, k)] * t[i] * t[i]).sum();
                if row > 0.0 && column > 0.0 {
                    t[k] = (column / row).powf(0.25).clamp(1e-8, 1e8);
                }
            }
        }
        let mut tw = vec![1.0; structure.rows()];
        let mut tz = vec![1.0; structure.cols()];
        for ((_, w, z), t) in places.iter().zip(&t) {
            tw[w.clone()].fill(*t);
            tz[z.clone()].fill(*t);
        }
        let matrix = CMat::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)] * (tz[i] / tw[j]));
        Self { matrix, tw, tz }
    }
}

/// A point, and lambda for which `Phi(lambda) > 0` there.
struct Centre<'a> {
    m: &'a CMat,
    /// `[I, M*]`.
    columns: CMat,
    family: Family,
    p: Vec<f64>,
    lambda: f64,
    /// The shift u of `Phi(lambda) + u D_0`, whose least value says how much smaller lambda may be.
    shift: f64,
    /// D_0: D as it was when lambda was set.
    base: CMat,
}

/// The Newton decrement below which a point counts as a centre.
const CENTRED: f64 = 0.3;

/// Newton steps towards one centre, at most.
const MOST_STEPS: usize = 100;

/// By how much the weight of lambda grows from one centre to the next.
const GROWTH: f64 = 10.0;

/// How many times the distance that is left lambda may move before D_0 counts as out of date.
const FAR: f64 = 30.0;

type Factor = Cholesky<Complex<f64>, Dyn>;

impl<'a> Centre<'a> {
    fn new(m: &'a CMat, structure: &Structure) -> Self {
        let family = Family::new(structure);
        let (nz, nw) = m.shape();
        let mut columns = CMat::identity(nw, nw + nz);
        columns.columns_mut(nw, nz).copy_from(&m.adjoint());
        let p = family.identity();
        let base = CMat::identity(nw, nw);
        Self { m, columns, family, p, lambda: 1.1, shift: 0.0, base }
    }

    /// The least lambda, and about how far it may be above it: or `target`, where that is above, at the centre there.
    fn least(&mut self, target: f64) -> (f64, f64) {
        let mut best = (self.border().unwrap_or(f64::INFINITY), f64::INFINITY);
        self.lambda = 1.1 * best.0;
        let mut kept = self.p.clone();
        let mut weight = 2.0 * self.m.ncols() as f64 / self.lambda;
        for _ in 0..60 {
            if best.0 < target {
                (self.lambda, self.shift) = (target, 0.0);
                self.p.clone_from(&kept);
                self.centre(None);
                return (
                    self.border().map_or(best.0, |border| border.min(target)).max(best.0),
                    f64::INFINITY,
                );
            }
            let arrived = self.centre(Some(weight));
            let Some(border) = self.border() else { break };
            if border <= best.0 {
                (best.0, kept) = (border, self.p.clone());
            }
            // Where the shift is gone lambda is smaller by about as much.
            let moved = self.shift.abs();
            self.lambda = (self.lambda + self.shift).max(border + 1e-2 * (self.lambda - border).abs());
            self.shift = 0.0;
            self.base = self.family.values(&self.p).dw;
            let near = self.m.ncols() as f64 / weight;
            // D has moved on from D_0 when lambda moves by more than the weight explains: then once more with this weight.
            let settled = moved <= FAR * near;
            if settled {
                best.1 = near;
                weight *= GROWTH;
            }
            if best.0 <= NOTHING * NOTHING || best.1 <= 2.0 * TIGHT * best.0 || !arrived {
                break;
            }
        }
        self.p = kept;
        best
    }

    /// The least lambda with `Phi(lambda) >= 0` at a point.
    fn border(&self) -> Option<f64> {
        let s = self.family.values(&self.p);
        let root = cholesky(s.dw.clone())?.unpack();
        let half = root.solve_lower_triangular(&s.left(self.m))?;
        let seen = root.solve_lower_triangular(&half.adjoint())?;
        hermitian_eigenvalues(&seen).last().copied()
    }

    /// `Phi(lambda) + shift D_0` and D's blocks, factorised; `None` unless all are positive definite.
    fn factors(&self, p: &[f64], shift: f64) -> Option<(Factor, Vec<Factor>)> {
        let s = self.family.values(p);
        let blocks: Vec<Factor> =
            self.family.d_blocks(&s).into_iter().map(cholesky).collect::<Option<_>>()?;
        let phi =
            &s.dw * Complex::new(self.lambda, 0.0) - s.left(self.m) + &self.base * Complex::new(shift, 0.0);
        Some((cholesky(phi)?, blocks))
    }

    /// Newton's method for the least of `weight u - log det (Phi(lambda) + u D_0) - log det D`, with u = 0 when there is no weight; whether
    /// it arrives.
    fn centre(&mut self, weight: Option<f64>) -> bool {
        self.newton(weight).is_some()
    }

    fn newton(&mut self, weight: Option<f64>) -> Option<()> {
        let n = self.family.unknowns();
        let free = usize::from(weight.is_some());
        let mut trace = self.family.trace();
        trace.resize(n + free, 0.0);
        let trace = DVector::from_vec(trace);
        let (mut gradient, mut hessian) = (vec![0.0; n + free], DMatrix::zeros(n + free, n + free));
        let mut factors = self.factors(&self.p, self.shift)?;
        for _ in 0..MOST_STEPS {
            let (phi, blocks) = &factors;
            let half = phi.l_dirty().solve_lower_triangular(&self.columns)?;
            let inner = half.adjoint() * &half;
            let inverses: Vec<CMat> = blocks.iter().map(Cholesky::inverse).collect();
            self.family.derivatives(self.lambda, &inner, &inverses, &mut gradient, &mut hessian);
            if let Some(weight) = weight {
                self.add_shift(weight, &inner, &mut gradient, &mut hessian);
            }
            let system = crate::matrix::Definite::new(hessian.clone())?;
            // The trace of D stays as it is.
            let towards = DVector::from_vec(system.solve(&gradient));
            let across = DVector::from_vec(system.solve(trace.as_slice()));
            let step = &across * (trace.dot(&towards) / trace.dot(&across)) - &towards;
            let decrement = (-step.dot(&DVector::from_column_slice(&gradient))).max(0.0).sqrt();
            let mut length = 1.0;
            let value = barrier(&factors) + weight.unwrap_or(0.0) * self.shift;
            loop {
                let next: Vec<f64> = self.p.iter().zip(step.iter()).map(|(p, d)| p + length * d).collect();
                let shift = self.shift + if free == 1 { length * step[n] } else { 0.0 };
                if let Some(found) = self.factors(&next, shift) {
                    let below = value - barrier(&found) - weight.unwrap_or(0.0) * shift;
                    if below >= 0.1 * length * decrement * decrement || decrement < CENTRED {
                        (self.p, self.shift, factors) = (next, shift, found);
                        break;
                    }
                }
                length *= 0.5;
                if length < 1e-6 {
                    return None;
                }
            }
            if decrement < CENTRED {
                return Some(());
            }
        }
        None
    }

    /// The derivatives by the shift, whose matrix is D_0.
    fn add_shift(&self, weight: f64, inner: &CMat, gradient: &mut [f64], hessian: &mut DMatrix<f64>) {
        let n = self.family.unknowns();
        let d = &self.base;
        let rows = d.nrows();
        // W* Phi^-1 D Phi^-1 W
        let seen = inner.view((0, 0), (inner.nrows(), rows)) * d * inner.view((0, 0), (rows, inner.ncols()));
        gradient[n] = weight - (inner.view((0, 0), (rows, rows)) * d).trace().re;
        hessian[(n, n)] = (seen.view((0, 0), (rows, rows)) * d).trace().re;
        for (i, value) in self.family.products(self.lambda, &seen).enumerate() {
            hessian[(i, n)] = value;
            hessian[(n, i)] = value;
        }
    }
}

/// The Cholesky factor of a positive definite matrix. nalgebra takes the complex root of a negative pivot.
fn cholesky(m: CMat) -> Option<Factor> {
    let factor = Cholesky::new(m)?;
    let sound = factor.l_dirty().diagonal().iter().all(|d| d.re > 0.0 && d.im.abs() <= 1e-9 * d.re);
    sound.then_some(factor)
}

/// `-log det Phi - log det D`.
fn barrier((phi, blocks): &(Factor, Vec<Factor>)) -> f64 {
    let half = |f: &Factor| f.l_dirty().diagonal().iter().map(|v| v.re.ln()).sum::<f64>();
    -2.0 * (half(phi) + blocks.iter().map(half).sum::<f64>())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mu::Block;
    use crate::mu::structure::random::problem;
    use proptest::prelude::*;

    /// The least eigenvalue of `value^2 D - left`, its diagonal scaled to one.
    fn margin(bound: &UpperBound, value: f64, m: &CMat) -> f64 {
        let s = &bound.scalings;
        let phi = &s.dw * Complex::new(value * value, 0.0) - s.left(m);
        let scale: Vec<f64> = phi.diagonal().iter().map(|d| 1.0 / d.re.abs().sqrt()).collect();
        hermitian_eigenvalues(&CMat::from_fn(phi.nrows(), phi.ncols(), |i, j| {
            phi[(i, j)] * scale[i] * scale[j]
        }))[0]
    }

    fn largest_modulus(m: &CMat) -> f64 {
        m.clone().schur().eigenvalues().unwrap().iter().map(|v| v.norm()).fold(0.0, f64::max)
    }

    proptest! {
        /// The scalings returned show the bound, and it is no larger than the largest singular value.
        #[test]
        fn the_scalings_show_the_bound((structure, m) in problem()) {
            let bound = upper_bound(&m, &structure).unwrap();
            let size = complex_singular_values(&m)[0];
            prop_assert!(bound.value <= size * (1.0 + 1e-6));
            if bound.value > 1e-3 * size {
                let margin = margin(&bound, bound.value * (1.0 + 1e-6), &m);
                prop_assert!(margin > -1e-9, "{margin}");
            }
        }

        /// mu of one full block is the largest singular value, of one repeated complex scalar the spectral radius; the bounds are tight there.
        #[test]
        fn one_block_has_a_closed_form((structure, m) in problem()) {
            let n = m.nrows().min(m.ncols());
            let full = Structure::new(vec![Block::Full { rows: m.ncols(), cols: m.nrows() }]).unwrap();
            let largest = complex_singular_values(&m)[0];
            let found = upper_bound(&m, &full).unwrap().value;
            prop_assert!((found - largest).abs() < 1e-4 * largest, "{found} {largest}");
            let square = m.view((0, 0), (n, n)).into_owned();
            let repeated = Structure::new(vec![Block::Complex(n)]).unwrap();
            let radius = largest_modulus(&square);
            let found = upper_bound(&square, &repeated).unwrap().value;
            prop_assert!(found >= radius * (1.0 - 1e-9) && found <= radius + 1e-3 * largest, "{found} {radius}");
            drop(structure);
        }

        /// At a level above the bound scalings are found that hold there.
        #[test]
        fn a_level_above_is_met((structure, m) in problem(), above in 1.01..3.0f64) {
            let tight = upper_bound(&m, &structure).unwrap().value.max(1e-3);
            let bound = bound_at_level(&m, &structure, above * tight).unwrap();
            prop_assert!(bound.value <= above * tight);
            prop_assert!(margin(&bound, above * tight, &m) > 0.0);
        }
    }

    /// Three scalars with D scalings are tight (A. Packard, J. C. Doyle, Automatica 29(1), 1993): the bound is the spectral radius at the worst phases.
    #[test]
    fn three_complex_scalars_are_tight() {
        let m = CMat::from_fn(3, 3, |i, j| {
            Complex::new((1.3 * (i + 2 * j) as f64).sin(), (0.7 * (3 * i + j) as f64).cos())
        });
        let structure = Structure::new(vec![Block::Complex(1); 3]).unwrap();
        let bound = upper_bound(&m, &structure).unwrap().value;
        let mut worst = 0.0f64;
        for a in 0..400 {
            for b in 0..400 {
                let phase = |k: i32| Complex::from_polar(1.0, f64::from(k) * std::f64::consts::TAU / 400.0);
                let u = CMat::from_diagonal(&nalgebra::dvector![Complex::new(1.0, 0.0), phase(a), phase(b)]);
                worst = worst.max(largest_modulus(&(&m * u)));
            }
        }
        assert!(worst <= bound && bound < worst * (1.0 + 1e-3), "{worst} {bound}");
    }
}
