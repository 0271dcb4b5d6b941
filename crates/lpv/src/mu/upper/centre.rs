//! The least lambda for which scalings exist, by the method of centres.
//!
//! Source: S. Boyd, L. El Ghaoui, "Method of centers for minimizing generalized eigenvalues", Linear Algebra and its
//! Applications 188, 1993, with a moving lambda = beta^2.

use super::product::product;
use super::scaling::{AtLambda, DgScalings, Family};
use crate::matrix::{Definite, hermitian_eigenvalues};
use crate::mu::CMat;
use crate::mu::structure::Structure;
use crate::stop;
use nalgebra::{Cholesky, Complex, DMatrix, DVector, Dyn};

/// A point with a lambda for which `Phi(lambda) > 0`.
pub(in crate::mu) struct Centre {
    /// The matrices for which the scalings must hold.
    all: Vec<CMat>,
    pub(in crate::mu) family: Family,
    pub(in crate::mu) p: Vec<f64>,
    lambda: f64,
    /// The shift u of `Phi(lambda) + u D_0`; its least value is the possible decrease of lambda.
    shift: f64,
    /// D_0: the value of D when lambda was set.
    base: CMat,
    /// An estimate of the relative excess of lambda over the least, at the start and at each new lambda.
    near: f64,
    /// The least lambda at the first point, if computed.
    known: Option<f64>,
    /// An intermediate point, for the start of a search for a similar matrix: at the end the margins are too small.
    pub(in crate::mu) start: Vec<f64>,
}

/// The fraction of the largest singular value below which a bound is taken as zero, as mu of real blocks often is.
pub(in crate::mu) const ZERO_MU: f64 = 1e-7;

/// The relative excess of the first lambda over the least: in general, and for scalings of a similar matrix.
const COLD_START: f64 = 0.5;
const WARM_START: f64 = 0.3;

/// The Newton decrement below which a point is taken as a centre.
const CENTRED_DECREMENT: f64 = 0.7;

/// The largest number of centres: a lambda of zero takes many.
const MOST_CENTRES: usize = 100;

/// The largest number of Newton steps per centre.
const MOST_STEPS: usize = 100;

/// The relative increase of the diagonal of the Hessian: always, and the largest, if a step fails because of directions
/// of little effect.
const HESSIAN_RAISE: (f64, f64) = (1e-13, 1e-4);

/// The relative accuracy of a step, whose result is checked.
const STEP_TOLERANCE: f64 = 1e-9;

/// The growth of the weight of lambda from one centre to the next, if the last weight explains the change of lambda.
const WEIGHT_GROWTH: f64 = 5.0;

/// Returns the least lambda with `Phi(lambda) >= 0` for all of the matrices, plus an allowance for rounding.
///
/// If D is nearly singular or G is large, large numbers cancel: lambda is then less accurate than its digits suggest.
pub(in crate::mu) fn least_lambda(all: &[CMat], s: &DgScalings) -> Option<f64> {
    let root = cholesky(s.dw.clone())?.unpack();
    let n = root.nrows();
    let inverse = root.solve_lower_triangular(&CMat::identity(n, n))?.map(|v| v.norm());
    let each = all.iter().map(|m| border(m, s, &root, &inverse));
    each.collect::<Option<Vec<f64>>>()?.into_iter().reduce(f64::max)
}

type Factor = Cholesky<Complex<f64>, Dyn>;

/// `Phi(lambda) + u D_0` of each matrix and the blocks of D, factorised.
struct Factors {
    phis: Vec<Factor>,
    blocks: Vec<Factor>,
}

impl Centre {
    /// Starts from matrices whose largest singular value is one, and from scalings that may be good for them.
    pub(in crate::mu) fn new(all: Vec<CMat>, structure: &Structure, from: Option<&DgScalings>) -> Self {
        let family = Family::new(structure);
        let nw = structure.rows();
        let p = family.identity();
        let base = CMat::identity(nw, nw);
        let (near, known) = (COLD_START, None);
        let mut cold = Self { all, family, p, lambda: 1.1, shift: 0.0, base, near, known, start: vec![] };
        let Some(from) = from else { return cold };
        let identity = std::mem::replace(&mut cold.p, cold.family.point(from));
        cold.known = cold.border();
        // The known scalings are not used if they give no better bound than the identity.
        if cold.known.is_some_and(|lambda| lambda < 1.0) {
            cold.near = WARM_START;
            cold.base = cold.family.values(&cold.p).dw;
        } else {
            (cold.p, cold.known) = (identity, None);
        }
        cold
    }

    /// Returns the least lambda, and an estimate of its excess, relatively at most twice `tight`; or, if `target` is
    /// above it, `target` at its centre.
    pub(in crate::mu) fn least(&mut self, target: f64, tight: f64) -> (f64, f64) {
        let first = self.known.or_else(|| self.border());
        let mut best = (first.unwrap_or(f64::INFINITY), f64::INFINITY);
        self.lambda = 1.1 * best.0;
        let mut kept = self.p.clone();
        let size = (self.base.nrows() * self.all.len()) as f64;
        let mut weight = size / (self.near * self.lambda);
        for _ in 0..MOST_CENTRES {
            if best.0 < target {
                (self.lambda, self.shift) = (target, 0.0);
                self.p.clone_from(&kept);
                self.centre(None);
                self.start.clone_from(&self.p);
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
            if self.start.is_empty() || size / weight >= WARM_START * border {
                self.start.clone_from(&self.p);
            }
            // Once the shift is zero, lambda is smaller by about as much.
            let before = self.lambda;
            self.lambda = (self.lambda + self.shift).max(border + 1e-2 * (self.lambda - border).abs());
            self.shift = 0.0;
            self.base = self.family.values(&self.p).dw;
            // If lambda moves by more than the weight explains, D has moved away from D_0, and the least is farther
            // away: a weight for a nearer one leads along the boundary, where steps are short.
            best.1 = (before - self.lambda).max(size / weight);
            weight = size / (best.1 / WEIGHT_GROWTH).min(self.near * self.lambda);
            if best.0 <= ZERO_MU * ZERO_MU || best.1 <= 2.0 * tight * best.0 || !arrived {
                break;
            }
        }
        self.p = kept;
        best
    }

    /// Returns the least lambda at a point.
    fn border(&self) -> Option<f64> {
        least_lambda(&self.all, &self.family.values(&self.p))
    }

    /// Factorises `Phi(lambda) + shift D_0` of each matrix and the blocks of D; `None` unless all are positive
    /// definite.
    fn factors(&self, p: &[f64], shift: f64) -> Option<Factors> {
        let s = self.family.values(p);
        let blocks = self.family.d_blocks(&s).into_iter().map(cholesky).collect::<Option<_>>()?;
        let scaled = &s.dw * Complex::new(self.lambda, 0.0) + &self.base * Complex::new(shift, 0.0);
        let phis = self.all.iter().map(|m| cholesky(&scaled - s.left(m))).collect::<Option<_>>()?;
        Some(Factors { phis, blocks })
    }

    /// Applies Newton's method to the minimum of `weight u - sum log det (Phi(lambda) + u D_0) - log det D`, with u = 0
    /// if there is no weight; returns `true` if it converges.
    fn centre(&mut self, weight: Option<f64>) -> bool {
        self.newton(weight).is_some()
    }

    fn newton(&mut self, weight: Option<f64>) -> Option<()> {
        let n = self.family.unknowns();
        let free = usize::from(weight.is_some());
        let mut trace = self.family.identity();
        trace.resize(n + free, 0.0);
        let trace = DVector::from_vec(trace);
        let at = self.family.at(self.lambda);
        let adjoints: Vec<CMat> = self.all.iter().map(CMat::adjoint).collect();
        let (mut gradient, mut hessian) = (vec![0.0; n + free], DMatrix::zeros(n + free, n + free));
        let mut factors = self.factors(&self.p, self.shift)?;
        let mut ridge = HESSIAN_RAISE.0;
        for _ in 0..MOST_STEPS {
            stop::check();
            let inners = factors.phis.iter().zip(&adjoints).map(|(phi, adjoint)| inner(phi, adjoint));
            let inners = inners.collect::<Option<Vec<CMat>>>()?;
            let inverses: Vec<CMat> = factors.blocks.iter().map(Cholesky::inverse).collect();
            self.family.derivatives(&at, &inners, &inverses, &mut gradient, &mut hessian);
            if let Some(weight) = weight {
                self.add_shift(&at, weight, &inners, &mut gradient, &mut hessian);
            }
            (0..n + free).for_each(|i| hessian[(i, i)] *= 1.0 + ridge);
            let step = step(&hessian, &gradient, &trace);
            match step.and_then(|step| self.advance(&step, &gradient, weight, &mut factors)) {
                Some(decrement) if decrement < CENTRED_DECREMENT => return Some(()),
                // There is no minimum: lambda is zero, or nearly.
                Some(_) if free == 1 && self.lambda + self.shift < 0.0 => return Some(()),
                Some(_) => {}
                None if ridge < HESSIAN_RAISE.1 => ridge *= 100.0,
                None => return None,
            }
        }
        None
    }

    /// Takes a step as far as it descends, and returns the Newton decrement; `None`, without a move, if it does not
    /// descend.
    fn advance(
        &mut self,
        step: &DVector<f64>,
        gradient: &[f64],
        weight: Option<f64>,
        factors: &mut Factors,
    ) -> Option<f64> {
        let last = self.family.unknowns();
        let weigh = |shift: f64| weight.map_or(0.0, |weight| weight * shift);
        let decrement = (-step.dot(&DVector::from_column_slice(gradient))).max(0.0).sqrt();
        let value = barrier(factors) + weigh(self.shift);
        let mut length = 1.0;
        while length >= 1e-6 {
            let next: Vec<f64> = self.p.iter().zip(step.iter()).map(|(p, d)| p + length * d).collect();
            let shift = self.shift + weight.map_or(0.0, |_| length * step[last]);
            if let Some(found) = self.factors(&next, shift) {
                let below = value - barrier(&found) - weigh(shift);
                if below >= 0.1 * length * decrement * decrement || decrement < CENTRED_DECREMENT {
                    (self.p, self.shift, *factors) = (next, shift, found);
                    return Some(decrement);
                }
            }
            length *= 0.5;
        }
        None
    }

    /// Adds the derivatives with respect to the shift, whose matrix is D_0.
    fn add_shift(
        &self,
        at: &AtLambda,
        weight: f64,
        inners: &[CMat],
        gradient: &mut [f64],
        hessian: &mut DMatrix<f64>,
    ) {
        let n = self.family.unknowns();
        gradient[n] = weight;
        (0..=n).for_each(|i| hessian[(i, n)] = 0.0);
        for inner in inners {
            // N = Phi^-1 D Phi^-1: the entries of W* N W that the products need.
            let rows = self.base.nrows();
            let inverse = inner.rows(0, rows).into_owned();
            let right = product(&self.base, &inverse);
            let product_at = |y: usize, x: usize| right.column(y).dotc(&inverse.column(x));
            let square = right.columns(0, rows);
            gradient[n] -= square.trace().re;
            hessian[(n, n)] +=
                square.iter().zip(square.transpose().iter()).map(|(a, b)| (a * b).re).sum::<f64>();
            at.along(product_at).enumerate().for_each(|(i, value)| hessian[(i, n)] += value);
        }
        (0..n).for_each(|i| hessian[(n, i)] = hessian[(i, n)]);
    }
}

/// Returns `W* Phi^-1 W`, W = [I, M*], from the factor of Phi and M*.
fn inner(phi: &Factor, adjoint: &CMat) -> Option<CMat> {
    let (rows, cols) = adjoint.shape();
    // L^-1 W.
    let mut half = CMat::zeros(rows, rows + cols);
    let inverse = phi.l_dirty().solve_lower_triangular(&CMat::identity(rows, rows))?;
    half.columns_mut(0, rows).copy_from(&inverse);
    half.columns_mut(rows, cols).copy_from(&product(&inverse, adjoint));
    Some(product(&half.adjoint(), &half))
}

/// Returns the least lambda with `Phi(lambda) >= 0` for a matrix, from the Cholesky factor of D and the magnitudes of
/// its inverse, plus an allowance for rounding.
fn border(m: &CMat, s: &DgScalings, root: &CMat, inverse: &DMatrix<f64>) -> Option<f64> {
    let half = root.solve_lower_triangular(&s.left(m))?;
    let whitened = root.solve_lower_triangular(&half.adjoint())?;
    let lambda = hermitian_eigenvalues(&whitened).last().copied().filter(|lambda| lambda.is_finite())?;
    let sizes = |m: &CMat| m.map(|v| v.norm());
    let (m, g, root) = (sizes(m), sizes(&s.g), sizes(root));
    let gm = &g * &m;
    let added = m.transpose() * sizes(&s.dz) * &m + &gm + gm.transpose();
    let rounded = added + &root * root.transpose() * lambda.abs();
    // A symmetric matrix is at most the diagonal matrix of its absolute row sums.
    let spread = inverse * rounded * inverse.transpose();
    let terms = (m.nrows() + m.ncols()) as f64;
    let mut raised = whitened;
    for (k, row) in spread.row_iter().enumerate() {
        raised[(k, k)] += Complex::new(terms * f64::EPSILON * row.sum(), 0.0);
    }
    // The error of an eigenvalue is the rounding of the largest one, which may be negative and far larger; a Cholesky
    // factorisation verifies that it is an upper bound.
    let largest = hermitian_eigenvalues(&raised).last().copied().filter(|lambda| lambda.is_finite())?;
    let n = raised.nrows();
    let is_above =
        |lambda: &f64| cholesky(CMat::identity(n, n) * Complex::new(*lambda, 0.0) - &raised).is_some();
    let size = largest.abs().max(ZERO_MU * ZERO_MU);
    let above = RAISES.iter().map(|raise| largest + raise * size).find(is_above);
    Some(above.unwrap_or(largest + terms * f64::EPSILON * raised.norm()))
}

/// Relative increases of an eigenvalue until it is verified.
const RAISES: [f64; 7] = [1e-13, 1e-11, 1e-9, 1e-7, 1e-6, 1e-5, 1e-4];

/// Returns Newton's step at constant trace of D.
fn step(hessian: &DMatrix<f64>, gradient: &[f64], trace: &DVector<f64>) -> Option<DVector<f64>> {
    let system = Definite::new(hessian.clone())?;
    let towards = DVector::from_vec(system.solve_to(gradient, STEP_TOLERANCE));
    let across = DVector::from_vec(system.solve_to(trace.as_slice(), STEP_TOLERANCE));
    Some(&across * (trace.dot(&towards) / trace.dot(&across)) - &towards)
}

/// Returns the Cholesky factor of a positive definite matrix. nalgebra takes the complex root of a negative pivot.
fn cholesky(m: CMat) -> Option<Factor> {
    let factor = Cholesky::new(m)?;
    let sound = factor.l_dirty().diagonal().iter().all(|d| d.re > 0.0 && d.im.abs() <= 1e-9 * d.re);
    sound.then_some(factor)
}

/// Returns `-sum log det Phi - log det D`.
fn barrier(Factors { phis, blocks }: &Factors) -> f64 {
    let half = |f: &Factor| f.l_dirty().diagonal().iter().map(|v| v.re.ln()).sum::<f64>();
    -2.0 * phis.iter().chain(blocks).map(half).sum::<f64>()
}
