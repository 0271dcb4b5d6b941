//! The scaled bounded-real inequality, in its printed and in its compact form.
//!
//! P. Apkarian, P. Gahinet, IEEE Trans. Automatic Control 40(5), 1995, lemma 3.1, with the skew scaling T of
//! G. Scorletti, L. El Ghaoui, Int. J. Robust Nonlinear Control 8, 1998.

use crate::lmi::{Affine, Program, symmetric};
use crate::matrix::{Mat, block};
use crate::plant::ClosedLoop;

/// Rows `[A Bt B1]`, `[Ct Dtt Dt1]`, `[C1 D1t D11]`.
pub(crate) type Rows<'a> = [[&'a Mat; 3]; 3];

/// The matrix that is negative definite when the gain from w to z is below gamma for every Theta, as printed:
///
/// ```text
/// [ A'X+XA   XBt+Ct'T'          XB1      Ct'S    C1'  ]
/// [   *     -S+TDtt+Dtt'T'      T Dt1    Dtt'S   D1t' ]
/// [   *        *               -gamma I  Dt1'S   D11' ]
/// [   *        *                 *       -S      0    ]
/// [   *        *                 *        *   -gamma I]
/// ```
pub(crate) fn bounded_real(rows: Rows<'_>, gamma: &Affine, x: &Affine, s: &Affine, t: &Affine) -> Affine {
    let [[_, _, _], [ct, dtt, dt1], [c1, d1t, d11]] = rows;
    let (r, z) = (dtt.nrows(), c1.nrows());
    let [mut first, mut second, mut third] = upper_left(rows, gamma, x, s, t);
    let constant = |m: &Mat| Affine::constant(m.transpose());
    first.extend([s.times(ct).t(), constant(c1)]);
    second.extend([s.times(dtt).t(), constant(d1t)]);
    third.extend([s.times(dt1).t(), constant(d11)]);
    let fourth = vec![-s.clone(), Affine::zeros(r, z)];
    symmetric(&[first, second, third, fourth, vec![-gamma.times_identity(z)]])
}

/// The same with the fourth row taken out by its Schur complement, which leaves an inequality that is still
/// linear in S and smaller by r: to the first three rows comes `[Ct Dtt Dt1]' S [Ct Dtt Dt1]`.
pub(crate) fn bounded_real_compact(
    rows: Rows<'_>,
    gamma: &Affine,
    x: &Affine,
    s: &Affine,
    t: &Affine,
) -> Affine {
    let [[_, _, _], [ct, dtt, dt1], [c1, d1t, d11]] = rows;
    let z = c1.nrows();
    let [mut first, mut second, mut third] = upper_left(rows, gamma, x, s, t);
    let constant = |m: &Mat| Affine::constant(m.transpose());
    first.push(constant(c1));
    second.push(constant(d1t));
    third.push(constant(d11));
    let channel = block(&[&[ct, dtt, dt1, &Mat::zeros(dtt.nrows(), z)]]);
    symmetric(&[first, second, third, vec![-gamma.times_identity(z)]]) + s.congruence(&channel)
}

/// The upper blocks of the first three rows and columns.
fn upper_left(rows: Rows<'_>, gamma: &Affine, x: &Affine, s: &Affine, t: &Affine) -> [Vec<Affine>; 3] {
    let [[a, bt, b1], [ct, dtt, dt1], _] = rows;
    let (lyapunov, inner) = (x.times(a), t.times(dtt));
    [
        vec![lyapunov.t() + lyapunov, x.times(bt) + t.times(ct).t(), x.times(b1)],
        vec![inner.t() + inner - s.clone(), t.times(dt1)],
        vec![-gamma.times_identity(b1.ncols())],
    ]
}

/// The rows of a closed loop.
pub(crate) fn rows(l: &ClosedLoop) -> Rows<'_> {
    [[&l.a, &l.bt, &l.b1], [&l.ct, &l.dtt, &l.dt1], [&l.c1, &l.d1t, &l.d11]]
}

/// The printed matrix of a closed loop at given X, S, T and gamma.
pub(crate) fn bounded_real_value(closed: &ClosedLoop, x: &Mat, s: &Mat, t: &Mat, gamma: f64) -> Mat {
    let constant = |m: &Mat| Affine::constant(m.clone());
    let level = Affine::constant(Mat::from_element(1, 1, gamma));
    bounded_real(rows(closed), &level, &constant(x), &constant(s), &constant(t)).value(&Program::new(), &[])
}
