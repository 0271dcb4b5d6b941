//! Dense matrices of 32-digit numbers, and the matrix sign function.
//!
//! With modes at 1e-6 and at 1e7 rad/s in coordinates of condition number 1e6, a Riccati equation loses all 16 digits
//! of an f64, but only half of 32.

use crate::matrix::Mat;
use crate::riccati::inverse::inverse;
use nalgebra::DMatrix;
pub(crate) use qd::Quad;

/// A matrix of 32-digit numbers.
pub(crate) type Wide = DMatrix<Quad>;

/// Returns a matrix converted to 32 digits.
pub(crate) fn wide(m: &Mat) -> Wide {
    m.map(Quad::from_f64)
}

/// Returns the numbers rounded to f64.
pub(crate) fn narrow(m: &Wide) -> Mat {
    m.map(|v| v.0)
}

/// Returns `x I`, n x n.
pub(crate) fn scalar(n: usize, x: Quad) -> Wide {
    Wide::from_diagonal_element(n, n, x)
}

/// Returns `[a b; c d]`.
pub(crate) fn four(a: &Wide, b: &Wide, c: &Wide, d: &Wide) -> Wide {
    let (top, left) = (a.nrows(), a.ncols());
    Wide::from_fn(top + c.nrows(), left + b.ncols(), |i, j| match (i < top, j < left) {
        (true, true) => a[(i, j)],
        (true, false) => b[(i, j - left)],
        (false, true) => c[(i - top, j)],
        (false, false) => d[(i - top, j - left)],
    })
}

/// Returns `[a b]`.
pub(crate) fn concatenated(a: &Wide, b: &Wide) -> Wide {
    four(a, b, &Wide::zeros(0, a.ncols()), &Wide::zeros(0, b.ncols()))
}

/// Returns `[a; b]`.
pub(crate) fn stacked(a: &Wide, b: &Wide) -> Wide {
    four(a, &Wide::zeros(a.nrows(), 0), b, &Wide::zeros(b.nrows(), 0))
}

/// Returns `(A + A')/2`.
pub(crate) fn symmetric(a: &Wide) -> Wide {
    (a + a.transpose()) * Quad::from_f64(0.5)
}

/// Returns the solution of `A X = B`; `None` for a singular A.
pub(crate) fn solve(a: &Wide, b: &Wide) -> Option<Wide> {
    Some(inverse(a)?.0 * b)
}

/// Returns L with `A = L L'`; `None` unless A is positive definite.
pub(crate) fn cholesky(a: &Wide) -> Option<Wide> {
    let n = a.nrows();
    let mut l = Wide::zeros(n, n);
    for j in 0..n {
        let mut pivot = a[(j, j)];
        for k in 0..j {
            pivot -= l[(j, k)] * l[(j, k)];
        }
        if pivot.0.is_nan() || pivot.0 <= 0.0 || !pivot.0.is_finite() {
            return None;
        }
        let root = pivot.sqrt();
        l[(j, j)] = root;
        for i in j + 1..n {
            let mut sum = a[(i, j)];
            for k in 0..j {
                sum -= l[(i, k)] * l[(j, k)];
            }
            l[(i, j)] = sum / root;
        }
    }
    Some(l)
}

/// Returns the X that minimises `|U X - V|`, by Householder reflections of U; `None` if the columns of U are dependent.
pub(crate) fn least_squares(u: &Wide, v: &Wide) -> Option<Wide> {
    let (rows, n) = u.shape();
    let mut m = concatenated(u, v);
    for k in 0..n {
        let mut square = Quad::ZERO;
        (k..rows).for_each(|i| square += m[(i, k)] * m[(i, k)]);
        let norm = square.sqrt();
        if norm.0 == 0.0 || !norm.0.is_finite() {
            return None;
        }
        let head = m[(k, k)];
        let alpha = if head.0 > 0.0 { -norm } else { norm };
        let mut reflector: Vec<Quad> = (k..rows).map(|i| m[(i, k)]).collect();
        reflector[0] -= alpha;
        // |v|^2/2
        let half = norm * norm - alpha * head;
        for j in k..m.ncols() {
            let mut product = Quad::ZERO;
            reflector.iter().enumerate().for_each(|(i, r)| product += *r * m[(k + i, j)]);
            let factor = product / half;
            reflector.iter().enumerate().for_each(|(i, r)| m[(k + i, j)] -= *r * factor);
        }
    }
    let mut x = Wide::zeros(n, v.ncols());
    for j in 0..v.ncols() {
        for i in (0..n).rev() {
            let mut sum = m[(i, n + j)];
            (i + 1..n).for_each(|k| sum -= m[(i, k)] * x[(k, j)]);
            x[(i, j)] = sum / m[(i, i)];
        }
    }
    x.iter().all(|v| v.0.is_finite()).then_some(x)
}

/// Returns the matrix sign function by Newton's iteration; `None` with an eigenvalue on the axis, to 32 digits.
///
/// ```text
/// S <- (c S + (c S)^-1)/2,   c = |det S|^(-1/n)
/// ```
///
/// A change is measured by products of mirrored entries, which do not depend on the units of the states. It does not
/// show nilpotent parts, for which the iteration continues by as many steps as halve their order to one. Source: R.
/// Byers, "Solving the algebraic Riccati equation with the matrix sign function", Linear Algebra and its Applications
/// 85, 1987.
pub(crate) fn sign(a: &Wide) -> Option<Wide> {
    iterate(a, |s| s, |_, _, _| {})
}

/// Returns the sign function of a Hamiltonian matrix `[A G; Q -A']`, G and Q symmetric. Each step is rounded to a
/// Hamiltonian matrix: an eigenvalue on the imaginary axis then stays on it, whereas rounding would move it off after
/// about a hundred steps and the iteration would end.
pub(crate) fn sign_of_hamiltonian(h: &Wide) -> Option<Wide> {
    iterate(h, |s| hamiltonian(&s), |_, _, _| {})
}

/// Returns the nearest Hamiltonian matrix.
fn hamiltonian(s: &Wide) -> Wide {
    let n = s.nrows() / 2;
    let part = |i: usize, j: usize| s.view((i * n, j * n), (n, n)).into_owned();
    let a = (part(0, 0) - part(1, 1).transpose()) * Quad::from_f64(0.5);
    four(&a, &symmetric(&part(0, 1)), &symmetric(&part(1, 0)), &-a.transpose())
}

/// Returns P of `A P + P A' + Q = 0` for a stable A: along with the sign iteration, `Q <- (c Q + S^-1 Q S'^-1/c)/2`
/// converges to `2 P`. `None` if A is not stable. Source: J. D. Roberts, Int. J. Control 32(4), 1980.
pub(crate) fn gramian(a: &Wide, q: &Wide) -> Option<Wide> {
    let half = Quad::from_f64(0.5);
    let mut q = q.clone();
    let each = |inverse: &Wide, up: Quad, down: Quad| {
        q = (&q * up + inverse * &q * inverse.transpose() * down) * half;
    };
    let s = iterate(a, |s| s, each)?;
    ((s.trace().0 + a.nrows() as f64).abs() < 0.5).then(|| symmetric(&q) * half)
}

/// Runs the sign iteration; `rounded` restores the structure of S, `each` receives `S^-1`, c and 1/c of each step.
fn iterate(
    a: &Wide,
    rounded: impl Fn(Wide) -> Wide,
    mut each: impl FnMut(&Wide, Quad, Quad),
) -> Option<Wide> {
    let n = a.nrows();
    let half = Quad::from_f64(0.5);
    let mut s = a.clone();
    let (mut scaled, mut left) = (true, None);
    let mut before = f64::INFINITY;
    for _ in 0..MOST_STEPS {
        let (inverse, log_det) = inverse(&s)?;
        // A power of two, which causes no rounding.
        let power =
            if scaled { (-log_det / (n.max(1) as f64 * std::f64::consts::LN_2)).round() } else { 0.0 };
        let (up, down) = (Quad::from_f64(2f64.powf(power)), Quad::from_f64(2f64.powf(-power)));
        each(&inverse, up, down);
        let next = rounded((&s * up + inverse * down) * half);
        let change = change(&s, &next);
        if !change.is_finite() {
            return None;
        }
        s = next;
        match &mut left {
            Some(0) => return Some(s),
            Some(steps) => *steps -= 1,
            None if !scaled && before < SETTLED => left = Some(n.max(1).ilog2() as usize + 1),
            None => {}
        }
        scaled = scaled && change >= NEAR;
        before = change;
    }
    None
}

/// Returns the change of a matrix in products of mirrored entries.
fn change(s: &Wide, next: &Wide) -> f64 {
    let mut most: f64 = 0.0;
    for i in 0..s.nrows() {
        for j in 0..=i {
            let difference = (next[(i, j)] - s[(i, j)]).0 * (next[(j, i)] - s[(j, i)]).0;
            most = most.max(difference.abs() / (1.0 + (next[(i, j)].0 * next[(j, i)].0).abs()));
        }
    }
    most.sqrt()
}

/// The change from which the iteration converges without scaling.
const NEAR: f64 = 0.3;

/// The change at which the next step reaches full accuracy.
const SETTLED: f64 = 1e-12;

/// The largest number of steps, ample for two per bit of the ratio of the fastest to the slowest mode.
const MOST_STEPS: usize = 150;

/// Returns `true` if all eigenvalues have negative real parts.
pub(crate) fn is_stable(a: &Wide) -> bool {
    let n = a.nrows();
    n == 0 || sign(a).is_some_and(|s| (s.trace().0 + n as f64).abs() < 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dmatrix;

    #[test]
    fn an_inverse_has_all_digits() {
        let a = wide(&dmatrix![0.0, 1e-8, 3.0; 2.0, 1.0, -1.0; 1e8, 4.0, 0.5]);
        let (i, log_det) = inverse(&a).unwrap();
        assert!((&a * &i - scalar(3, Quad::ONE)).iter().all(|v| v.0.abs() < 1e-22));
        // The determinant is 24 - 1 - 3e8 - 1e-8.
        assert!((log_det - (3e8f64 - 23.0).ln()).abs() < 1e-12, "{log_det}");
        assert!(inverse(&wide(&dmatrix![1.0, 2.0; 2.0, 4.0])).is_none());
    }

    /// The padding does not affect an inverse, whether or not its rows fill the vectors.
    #[test]
    fn padding_does_not_affect_the_inverse() {
        for n in 0..20 {
            let entry = |i: usize, j: usize| ((3 * i + 7 * j + i * j) as f64).sin() + f64::from(i == j);
            let a = wide(&Mat::from_fn(n, n, entry));
            let (i, _) = inverse(&a).unwrap();
            assert!((&a * &i - scalar(n, Quad::ONE)).iter().all(|v| v.0.abs() < 1e-26), "{n}");
        }
    }

    #[test]
    fn least_squares_satisfy_the_normal_equations() {
        let u = wide(&dmatrix![1.0, 2.0; 0.5, -1.0; 3.0, 1e-3]);
        let v = wide(&dmatrix![1.0; 2.0; 3.0]);
        let x = least_squares(&u, &v).unwrap();
        assert!((u.transpose() * (&u * x - v)).iter().all(|v| v.0.abs() < 1e-28));
    }

    #[test]
    fn modes_are_counted_across_thirteen_decades() {
        let t = dmatrix![1.0, 2e3, -1.0; 0.0, 1.0, 5e3; 1.0, 0.0, 1.0];
        let (inverse, _) = inverse(&wide(&t)).unwrap();
        let with =
            |slow: f64| wide(&t) * wide(&dmatrix![slow, 0.0, 0.0; 0.0, -3.0, 1.0; 0.0, 0.0, -1e7]) * &inverse;
        assert!(is_stable(&with(-1e-6)));
        assert!(!is_stable(&with(1e-6)));
        assert!(!is_stable(&wide(&dmatrix![0.0, 1.0; -1.0, 0.0])));
    }
}
