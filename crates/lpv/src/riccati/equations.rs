//! The two Riccati equations of H-infinity control, and the central controller.
//!
//! K. Zhou, J. C. Doyle, K. Glover, "Robust and Optimal Control", 1996, theorem 17.1, written without the rotations
//! that make `D12 = [0; I]` and `D21 = [0 I]`: with `P = I - D12 D12^+`, `N = I - D21^+ D21`,
//!
//! ```text
//! R = [D11 D12]'[D11 D12] - blkdiag(g^2 I, 0),   H = [A 0; -C1'C1 -A'] - [B; -C1'[D11 D12]] R^-1 [[D11 D12]'C1  B']
//! X = Ric(H),   F = -R^-1 ([D11 D12]'C1 + B'X),   likewise Y and L of the dual
//! ```
//!
//! a controller with a gain below g exists if and only if `|P D11| < g`, `|D11 N| < g`, X and Y exist and are
//! positive semidefinite, and the eigenvalues of X Y are below g^2. D12 has full column rank and D21 full row rank, and
//! neither of the paths from u to z and from w to y has a zero on the imaginary axis.
//!
//! Every decision counts eigenvalues in a half plane by the matrix sign function: X is positive semidefinite if
//! `A + B2 (F2 + D12^+ D11 F1)` is stable, and `X Y < g^2 I` if `X Y/g^2 - I` is. None depends on units or coordinates.

use crate::matrix::Mat;
use crate::riccati::inverse::inverse;
use crate::riccati::wide::{
    Quad, Wide, cholesky, concatenated, four, is_stable, least_squares, narrow, scalar, sign_of_hamiltonian,
    solve, stacked, symmetric, wide,
};
use crate::system::{Controller, GeneralisedPlant};

/// A plant without parameters.
#[derive(Debug, Clone)]
#[allow(missing_docs, reason = "the names of the partition")]
pub(crate) struct WidePlant {
    pub(crate) a: Wide,
    pub(crate) b1: Wide,
    pub(crate) b2: Wide,
    pub(crate) c1: Wide,
    pub(crate) c2: Wide,
    pub(crate) d11: Wide,
    pub(crate) d12: Wide,
    pub(crate) d21: Wide,
}

/// The solution of the equations at a gain for which a controller exists.
pub(crate) struct Solution {
    gain: Quad,
    x: Wide,
    y: Wide,
    f: Wide,
    l: Wide,
}

impl WidePlant {
    pub(crate) fn new(plant: &GeneralisedPlant) -> Self {
        Self {
            a: wide(&plant.a()),
            b1: wide(&plant.b1()),
            b2: wide(&plant.b2()),
            c1: wide(&plant.c1()),
            c2: wide(&plant.c2()),
            d11: wide(&plant.d11()),
            d12: wide(&plant.d12()),
            d21: wide(&plant.d21()),
        }
    }

    /// Returns the transposed plant, whose first equation is the second one here.
    pub(crate) fn dual(&self) -> Self {
        Self {
            a: self.a.transpose(),
            b1: self.c1.transpose(),
            b2: self.c2.transpose(),
            c1: self.b1.transpose(),
            c2: self.b2.transpose(),
            d11: self.d11.transpose(),
            d12: self.d21.transpose(),
            d21: self.d12.transpose(),
        }
    }

    /// Returns `true` if every control has a weight and every measurement noise: D12 and D21' of full column rank.
    pub(crate) fn is_regular(&self) -> bool {
        pseudo_inverse(&self.d12).is_some() && pseudo_inverse(&self.d21.transpose()).is_some()
    }

    /// Returns X and `F = [F1; F2]` of the first equation, if it has a positive semidefinite solution.
    pub(crate) fn first(&self, gain: Quad) -> Option<(Wide, Wide)> {
        let (n, w) = (self.a.nrows(), self.b1.ncols());
        let weights = pseudo_inverse(&self.d12)?;
        let rest = &self.d11 - &self.d12 * (&weights * &self.d11);
        let square = gain * gain;
        cholesky(&(scalar(w, square) - rest.transpose() * &rest))?;
        let (b, d) = (concatenated(&self.b1, &self.b2), concatenated(&self.d11, &self.d12));
        let mut r = d.transpose() * &d;
        (0..w).for_each(|i| r[(i, i)] -= square);
        let r = inverse(&r)?.0;
        let of_state = d.transpose() * &self.c1;
        let zeros = Wide::zeros(n, n);
        let diagonal = four(&self.a, &zeros, &-(self.c1.transpose() * &self.c1), &-self.a.transpose());
        let into = stacked(&b, &-of_state.transpose());
        let h = diagonal - into * (&r * concatenated(&of_state, &b.transpose()));
        let x = stabilising(&h)?;
        let f = -(r * (of_state + b.transpose() * &x));
        let (f1, f2) = (f.rows(0, w).into_owned(), f.rows(w, self.b2.ncols()).into_owned());
        let loops = &self.a + &self.b2 * (f2 + weights * (&self.d11 * f1));
        is_stable(&loops).then_some((x, f))
    }

    /// Returns the solution at a gain; `None` if no controller has a smaller gain.
    pub(crate) fn solve(&self, gain: f64) -> Option<Solution> {
        let gain = Quad::from_f64(gain);
        let dual = self.dual();
        let (one, two) = rayon::join(|| self.first(gain), || dual.first(gain));
        let ((x, f), (y, l)) = (one?, two?);
        let product = &x * &y * (gain * gain).recip() - scalar(x.nrows(), Quad::ONE);
        is_stable(&product).then(|| Solution { gain, x, y, f, l: l.transpose() })
    }

    /// Returns the central controller; theorem 17.1 with `Q = 0`.
    pub(crate) fn central(&self, solution: &Solution) -> Option<WideController> {
        let Solution { gain, x, y, f, l } = solution;
        let (n, w, z) = (self.a.nrows(), self.b1.ncols(), self.c1.nrows());
        let (u, m) = (self.b2.ncols(), self.c2.nrows());
        let square = *gain * *gain;
        let (f1, f2) = (f.rows(0, w).into_owned(), f.rows(w, u).into_owned());
        let (l1, l2) = (l.columns(0, z).into_owned(), l.columns(z, m).into_owned());
        let (weights, noises) =
            (pseudo_inverse(&self.d12)?, pseudo_inverse(&self.d21.transpose())?.transpose());
        let unweighted = &self.d11 - &self.d12 * (&weights * &self.d11);
        let noiseless = &self.d11 - (&self.d11 * &noises) * &self.d21;
        let both = &unweighted - (&unweighted * &noises) * &self.d21;
        let middle = solve(&(scalar(z, square) - &both * both.transpose()), &(unweighted * &noises))?;
        let d = -(&weights * (noiseless * (both.transpose() * middle))) - weights * (&self.d11 * noises);
        let seen = &self.c2 + &self.d21 * &f1;
        let b = solve(
            &(scalar(n, Quad::ONE) - y * x * square.recip()),
            &((&self.b2 + l1 * &self.d12) * &d - l2),
        )?;
        let c = &f2 - &d * &seen;
        let a = &self.a + &self.b1 * f1 + &self.b2 * f2 - &b * seen;
        Some(WideController { a, b, c, d })
    }
}

/// A controller without parameters, from y to u.
pub(crate) struct WideController {
    pub(crate) a: Wide,
    pub(crate) b: Wide,
    pub(crate) c: Wide,
    pub(crate) d: Wide,
}

impl WideController {
    pub(crate) fn new(k: &Controller) -> Self {
        Self { a: wide(&k.a()), b: wide(&k.by()), c: wide(&k.cu()), d: wide(&k.duy()) }
    }

    /// Returns the controller with its numbers rounded to f64.
    pub(crate) fn rounded(&self) -> Option<Controller> {
        let matrix = narrow(&four(&self.a, &self.b, &self.c, &self.d));
        let (n, y, u) = (self.a.nrows(), self.b.ncols(), self.c.nrows());
        matrix.iter().all(|v| v.is_finite()).then(|| Controller::from_matrix(&matrix, n, y, u, vec![]))
    }

    /// Returns the controller with the states `x~ = T x`.
    pub(crate) fn in_coordinates(&self, t: &Wide) -> Option<Self> {
        let (inverse, _) = inverse(t)?;
        Some(Self { a: t * &self.a * &inverse, b: t * &self.b, c: &self.c * inverse, d: self.d.clone() })
    }
}

/// Returns X of the stable subspace `[I; X]` of a Hamiltonian matrix. With an eigenvalue on the imaginary axis the
/// iteration may converge to a wrong matrix: the sign must commute with H, and `H11 + H12 X` must be stable.
pub(crate) fn stabilising(h: &Wide) -> Option<Wide> {
    let n = h.nrows() / 2;
    if n == 0 {
        return Some(Wide::zeros(0, 0));
    }
    let s = sign_of_hamiltonian(h)?;
    if s.trace().0.abs() > 0.5 || !commutes(&s, h) {
        return None;
    }
    let part = |i: usize, j: usize| s.view((i * n, j * n), (n, n)).into_owned();
    let unit = scalar(n, Quad::ONE);
    let x = least_squares(
        &stacked(&part(0, 1), &(part(1, 1) + &unit)),
        &-stacked(&(part(0, 0) + unit), &part(1, 0)),
    )?;
    let x = symmetric(&x);
    let block = |j: usize| h.view((0, j * n), (n, n)).into_owned();
    is_stable(&(block(0) + block(1) * &x)).then_some(x)
}

/// Returns `true` if a matrix S commutes with H, as its sign function does: by products of mirrored entries of `S H - H
/// S`, relative to the terms on the diagonal; the units of the states do not matter.
fn commutes(s: &Wide, h: &Wide) -> bool {
    let n = h.nrows();
    let rest = narrow(&(s * h - h * s));
    let sizes = |i: usize| {
        (0..n).map(|k| (s[(i, k)].0 * h[(k, i)].0).abs() + (h[(i, k)].0 * s[(k, i)].0).abs()).sum()
    };
    let terms: Vec<f64> = (0..n).map(sizes).collect();
    let small =
        |i: usize, j: usize| (rest[(i, j)] * rest[(j, i)]).abs() <= RESIDUAL.powi(2) * terms[i] * terms[j];
    (0..n).all(|i| (0..=i).all(|j| small(i, j)))
}

/// The largest remainder relative to its terms; that of a commuting matrix is far smaller.
const RESIDUAL: f64 = 1e-8;

/// Returns `true` if a feedback `u = -B'X x` makes `A + B u` stable, checked for the X of `A'X + XA - XBB'X + I = 0`. B
/// in units of A.
pub(crate) fn is_stabilisable(a: &Mat, b: &Mat) -> bool {
    let (n, b) = (a.nrows(), wide(b));
    let h = four(&wide(a), &-(&b * b.transpose()), &-scalar(n, Quad::ONE), &-wide(&a.transpose()));
    stabilising(&h).is_some()
}

/// Returns A restricted to the states unreachable from B, in an orthonormal basis of the complement of the others.
///
/// The basis is that of `B, AB, ...`, by orthogonalisation. A vector with a remainder at the rounding of 32 digits is
/// dropped; a vector dependent only to f64 rounding leaves far more.
pub(crate) fn unreached(a: &Mat, b: &Mat) -> Wide {
    let (n, a) = (a.nrows(), wide(a));
    let mut basis: Vec<Wide> = vec![];
    let independent = |basis: &[Wide], v: Wide| {
        let size = |v: &Wide| v.iter().fold(Quad::ZERO, |sum, x| sum + *x * *x).sqrt();
        let full = size(&v);
        let mut left = v;
        for _ in 0..2 {
            for q in basis {
                let along = (q.transpose() * &left)[(0, 0)];
                left -= q * along;
            }
        }
        let rest = size(&left);
        (rest.0 > NOTHING_LEFT * full.0).then(|| left * rest.recip())
    };
    let add = |basis: &mut Vec<Wide>, v: Wide| {
        if let Some(v) = independent(basis, v) {
            basis.push(v);
        }
    };
    wide(b).column_iter().for_each(|v| add(&mut basis, Wide::from_columns(&[v])));
    let mut next = 0;
    while next < basis.len() {
        let moved = &a * &basis[next];
        add(&mut basis, moved);
        next += 1;
    }
    let reached = basis.len();
    for i in 0..n {
        add(&mut basis, Wide::from_fn(n, 1, |k, _| if k == i { Quad::ONE } else { Quad::ZERO }));
    }
    let rest = Wide::from_fn(n, basis.len().saturating_sub(reached), |i, j| basis[reached + j][(i, 0)]);
    rest.transpose() * a * &rest
}

/// The relative remainder of a vector that is dependent on others to rounding.
const NOTHING_LEFT: f64 = 1e-24;

/// Returns the pseudo-inverse `(D'D)^-1 D'` of a matrix with independent columns, each in its own unit; `None` if they
/// are dependent to rounding.
fn pseudo_inverse(d: &Wide) -> Option<Wide> {
    let units = d.column_iter().map(|c| {
        let size = c.iter().map(|v| v.0 * v.0).sum::<f64>().sqrt();
        (size > 0.0 && size.is_finite()).then(|| Quad::from_f64(1.0 / size))
    });
    let units: Vec<Quad> = units.collect::<Option<_>>()?;
    let scaled = Wide::from_fn(d.nrows(), d.ncols(), |i, j| d[(i, j)] * units[j]);
    let gram = scaled.transpose() * &scaled;
    let smallest = cholesky(&gram)?.diagonal().iter().map(|v| v.0).fold(1.0, f64::min);
    let inverse = solve(&gram, &scaled.transpose()).filter(|_| smallest > INDEPENDENT)?;
    Some(Wide::from_fn(d.ncols(), d.nrows(), |i, j| inverse[(i, j)] * units[i]))
}

/// The least relative remainder of independent columns, after elimination of the others.
const INDEPENDENT: f64 = 1e-14;
