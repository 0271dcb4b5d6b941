//! The scaled bounded-real inequality, as published and in compact form.
//!
//! P. Apkarian, P. Gahinet, IEEE Trans. Automatic Control 40(5), 1995, lemma 3.1, with the skew scaling T of
//! G. Scorletti, L. El Ghaoui, Int. J. Robust Nonlinear Control 8, 1998.

use crate::analysis::gain_bound::GainBound;
use crate::lmi::{Affine, Program, symmetric};
use crate::matrix::{Mat, block};
use crate::system::{ClosedLoop, LoopError};

/// Returns the matrix that is negative definite if the gain from w to z is below gamma for every Theta and every model
/// error, as published:
///
/// ```text
/// [ A'X+XA   XBt+Ct'T'          X E         XB1      Ct'S    lambda Fx'  C1'  ]
/// [   *     -S+TDtt+Dtt'T'      0           T Dt1    Dtt'S   lambda Ft'  D1t' ]
/// [   *        *               -lambda I    0        0       0           0    ]
/// [   *        *                *          -gamma I  Dt1'S   lambda Fw'  D11' ]
/// [   *        *                *           *       -S       0           0    ]
/// [   *        *                *           *        *      -lambda I    0    ]
/// [   *        *                *           *        *       *      -gamma I  ]
/// ```
///
/// Without model error the third and the sixth row are absent.
pub(crate) fn bounded_real(l: &ClosedLoop, error: &LoopError, m: &Multipliers<Affine>) -> Affine {
    let (r, w, z, ne, nf) =
        (l.dtt().nrows(), l.b1().ncols(), l.c1().nrows(), error.e.ncols(), error.fx.nrows());
    let Multipliers { gamma, s, lambda, .. } = m;
    let [mut first, mut second, mut third, mut fourth] = upper_left(l, error, m);
    let zero = Affine::zeros;
    let times_lambda = |f: &Mat| lambda.times_identity(nf).after(&f.transpose());
    let constant = |m: &Mat| Affine::constant(m.transpose());
    first.extend([s.times(&l.ct()).t(), times_lambda(&error.fx), constant(&l.c1())]);
    second.extend([s.times(&l.dtt()).t(), times_lambda(&error.ft), constant(&l.d1t())]);
    third.extend([zero(ne, r), zero(ne, nf), zero(ne, z)]);
    fourth.extend([s.times(&l.dt1()).t(), times_lambda(&error.fw), constant(&l.d11())]);
    debug_assert_eq!(fourth[0].shape(), (w, w));
    let fifth = vec![-s.clone(), zero(r, nf), zero(r, z)];
    let sixth = vec![-lambda.times_identity(nf), zero(nf, z)];
    symmetric(&[first, second, third, fourth, fifth, sixth, vec![-gamma.times_identity(z)]])
}

/// Returns the inequality of [`bounded_real`] with the rows of S and lambda eliminated by their Schur complements,
/// still linear in both and much smaller: the terms `[Ct Dtt 0 Dt1]' S [Ct Dtt 0 Dt1]` and
/// `[Fx Ft 0 Fw]' lambda [Fx Ft 0 Fw]` are added to the first four rows.
pub(crate) fn bounded_real_compact(l: &ClosedLoop, error: &LoopError, m: &Multipliers<Affine>) -> Affine {
    let (r, z, ne, nf) = (l.dtt().nrows(), l.c1().nrows(), error.e.ncols(), error.fx.nrows());
    let [mut first, mut second, mut third, mut fourth] = upper_left(l, error, m);
    let constant = |m: &Mat| Affine::constant(m.transpose());
    first.push(constant(&l.c1()));
    second.push(constant(&l.d1t()));
    third.push(Affine::zeros(ne, z));
    fourth.push(constant(&l.d11()));
    let zero = Mat::zeros;
    let channel = block(&[&[&l.ct(), &l.dtt(), &zero(r, ne), &l.dt1(), &zero(r, z)]]);
    let uncertain = block(&[&[&error.fx, &error.ft, &zero(nf, ne), &error.fw, &zero(nf, z)]]);
    symmetric(&[first, second, third, fourth, vec![-m.gamma.times_identity(z)]])
        + m.s.congruence(&channel)
        + m.lambda.times_identity(nf).congruence(&uncertain)
}

/// Returns the upper blocks of the first four rows and columns: x, wt, w_Delta, w.
fn upper_left(l: &ClosedLoop, error: &LoopError, m: &Multipliers<Affine>) -> [Vec<Affine>; 4] {
    let Multipliers { gamma, x, s, t, lambda } = m;
    let (r, w, ne) = (l.dtt().nrows(), l.b1().ncols(), error.e.ncols());
    let (lyapunov, inner) = (x.times(&l.a()), t.times(&l.dtt()));
    [
        vec![
            lyapunov.t() + lyapunov,
            x.times(&l.bt()) + t.times(&l.ct()).t(),
            x.times(&error.e),
            x.times(&l.b1()),
        ],
        vec![inner.t() + inner - s.clone(), Affine::zeros(r, ne), t.times(&l.dt1())],
        vec![-lambda.times_identity(ne), Affine::zeros(ne, w)],
        vec![-gamma.times_identity(w)],
    ]
}

/// The unknowns of the inequality, or their values.
#[derive(Debug, Clone)]
pub(crate) struct Multipliers<M> {
    /// Gain bound, 1 x 1.
    pub(crate) gamma: M,
    /// Lyapunov matrix, states square.
    pub(crate) x: M,
    /// Symmetric scaling, channels square.
    pub(crate) s: M,
    /// Skew scaling, channels square.
    pub(crate) t: M,
    /// Multiplier of the model error, 1 x 1.
    pub(crate) lambda: M,
}

impl Multipliers<Affine> {
    /// Returns the values of a bound as constants.
    pub(crate) fn constant(bound: &GainBound) -> Self {
        let of = |m: &Mat| Affine::constant(m.clone());
        Self {
            gamma: Affine::number(bound.gamma),
            x: of(&bound.x),
            s: of(&bound.s),
            t: of(&bound.t),
            lambda: Affine::number(bound.lambda),
        }
    }
}

/// Returns the matrix of [`bounded_real`] at the values of a bound.
pub(crate) fn bounded_real_value(closed: &ClosedLoop, error: &LoopError, bound: &GainBound) -> Mat {
    bounded_real(closed, error, &Multipliers::constant(bound)).value(&Program::default(), &[])
}
