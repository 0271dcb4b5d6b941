//! Matrix inequalities as sums of matrices of rank two.
//!
//! In `F(x) = F_0 + sum x_i F_i` of control each F_i comes from an entry of a matrix unknown V in a term `L V R`: it
//! is `sum c (l r' + r l')` with few columns l of L' s image and r of R'. Kept so, a product like `tr(F_i M F_j N)`
//! takes a few entries of `W'MW` and `W'NW`, where W holds all columns, instead of products of matrices.
//!
//! A. Nemirovskii, P. Gahinet, "The projective method for solving linear matrix inequalities", Math. Programming 77,
//! 1997, section 5, for the use of that structure; K. Fujisawa, M. Kojima, K. Nakata, Math. Programming 79, 1997, for
//! the Schur complement.

use crate::lmi::program::{Affine, Program};
use crate::matrix::{Mat, symmetric_part};

/// `coefficient (w_a w_b' + w_b w_a')`, by the numbers of two columns of W.
#[derive(Debug, Clone, Copy)]
struct Pair {
    a: u32,
    b: u32,
    coefficient: f64,
}

/// A symmetric matrix that is affine in the unknowns of a program.
#[derive(Debug, Clone)]
pub(crate) struct LowRank {
    constant: Mat,
    columns: Mat,
    /// The unknowns that occur, ascending.
    unknowns: Vec<u32>,
    /// Where each unknown's pairs begin in `pairs`; one more entry at the end.
    starts: Vec<u32>,
    pairs: Vec<Pair>,
}

impl LowRank {
    pub(crate) fn new(program: &Program, expression: &Affine) -> Self {
        let terms = program.merged_terms(expression);
        let n = expression.shape().0;
        let mut columns: Vec<nalgebra::DVector<f64>> = vec![];
        let mut factors: Vec<(Mat, u32)> = vec![];
        let mut place = |m: &Mat| -> u32 {
            if let Some((_, at)) = factors.iter().find(|(known, _)| known == m) {
                return *at;
            }
            let at = columns.len() as u32;
            columns.extend(m.column_iter().map(|c| c.into_owned()));
            factors.push((m.clone(), at));
            at
        };
        let mut by_unknown: std::collections::BTreeMap<u32, Vec<Pair>> = std::collections::BTreeMap::new();
        for (variable, left, right) in &terms {
            let (left_at, right_at) = (place(left), place(&right.transpose()));
            for (unknown, entries) in program.entries(*variable) {
                let pairs = by_unknown.entry(unknown as u32).or_default();
                for &(i, j, coefficient) in entries {
                    let (one, two) = (left_at + i as u32, right_at + j as u32);
                    let (a, b) = (one.min(two), one.max(two));
                    match pairs.iter_mut().find(|p| (p.a, p.b) == (a, b)) {
                        Some(known) => known.coefficient += 0.5 * coefficient,
                        None => pairs.push(Pair { a, b, coefficient: 0.5 * coefficient }),
                    }
                }
            }
        }
        let mut out = Self {
            constant: symmetric_part(&expression.constant),
            columns: Mat::from_fn(n, columns.len(), |i, j| columns[j][i]),
            unknowns: vec![],
            starts: vec![0],
            pairs: vec![],
        };
        let empty = |at: u32| out.columns.column(at as usize).amax() == 0.0;
        for (unknown, pairs) in by_unknown {
            let kept: Vec<Pair> =
                pairs.into_iter().filter(|p| p.coefficient != 0.0 && !empty(p.a) && !empty(p.b)).collect();
            if !kept.is_empty() {
                out.unknowns.push(unknown);
                out.pairs.extend(kept);
                out.starts.push(out.pairs.len() as u32);
            }
        }
        out
    }

    /// Rows.
    pub(crate) fn size(&self) -> usize {
        self.constant.nrows()
    }

    /// F_0.
    pub(crate) fn constant(&self) -> &Mat {
        &self.constant
    }

    /// The same inequality after a congruence with a diagonal matrix that divides each row by its size to the power
    /// `evenness`.
    pub(crate) fn with_even_rows(&self, evenness: f64) -> Self {
        let mut out = self.clone();
        for (i, f) in self.factors(evenness).into_iter().enumerate() {
            out.columns.row_mut(i).scale_mut(f);
            out.constant.row_mut(i).scale_mut(f);
            out.constant.column_mut(i).scale_mut(f);
        }
        out
    }

    /// The multiplier of this inequality that one of [`Self::with_even_rows`] is.
    pub(crate) fn uneven(&self, multiplier: &Mat, evenness: f64) -> Mat {
        let factors = self.factors(evenness);
        Mat::from_fn(self.size(), self.size(), |i, j| multiplier[(i, j)] * factors[i] * factors[j])
    }

    fn factors(&self, evenness: f64) -> Vec<f64> {
        let norms = self.columns.row_iter().map(|row| row.norm());
        norms.map(|norm| if norm > 0.0 { norm.powf(-evenness) } else { 1.0 }).collect()
    }

    fn each(&self) -> impl Iterator<Item = (usize, &[Pair])> {
        self.unknowns
            .iter()
            .zip(self.starts.windows(2))
            .map(|(unknown, range)| (*unknown as usize, &self.pairs[range[0] as usize..range[1] as usize]))
    }

    /// The Frobenius norms of the first `unknowns` F_i.
    pub(crate) fn norms(&self, unknowns: usize) -> Vec<f64> {
        let gram = self.columns.transpose() * &self.columns;
        let mut out = vec![0.0; unknowns];
        for (unknown, pairs) in self.each() {
            let product = |p: &Pair, s: &Pair| {
                let (a, b, c, d) = (p.a as usize, p.b as usize, s.a as usize, s.b as usize);
                2.0 * p.coefficient
                    * s.coefficient
                    * (gram[(a, c)] * gram[(b, d)] + gram[(a, d)] * gram[(b, c)])
            };
            let square: f64 = pairs.iter().flat_map(|p| pairs.iter().map(move |s| product(p, s))).sum();
            out[unknown] = square.max(0.0).sqrt();
        }
        out
    }

    /// `sum x_i F_i`.
    pub(crate) fn linear(&self, x: &[f64]) -> Mat {
        let q = self.columns.ncols();
        let mut middle = Mat::zeros(q, q);
        for (unknown, pairs) in self.each() {
            for p in pairs {
                let value = p.coefficient * x[unknown];
                middle[(p.a as usize, p.b as usize)] += value;
                middle[(p.b as usize, p.a as usize)] += value;
            }
        }
        symmetric_part(&(&self.columns * middle * self.columns.transpose()))
    }

    /// `W' M W` of a symmetric M.
    pub(crate) fn projected(&self, m: &Mat) -> Mat {
        self.columns.transpose() * (m * &self.columns)
    }

    /// Adds `factor tr(F_i M)` to `out[i]` for each i; `projected` is `W'MW`.
    pub(crate) fn add_inner_products(&self, projected: &Mat, factor: f64, out: &mut [f64]) {
        for (unknown, pairs) in self.each() {
            let sum: f64 =
                pairs.iter().map(|p| p.coefficient * projected[(p.a as usize, p.b as usize)]).sum();
            out[unknown] += 2.0 * factor * sum;
        }
    }

    /// The rounding to expect of `tr(F(x) M)`, its terms summed one by one.
    pub(crate) fn rounding(&self, m: &Mat, x: &[f64]) -> f64 {
        let constant: f64 = self.constant.iter().zip(m.iter()).map(|(f, m)| (f * m).abs()).sum();
        let columns = self.columns.abs();
        let projected = columns.transpose() * (m.abs() * &columns);
        let size = |p: &Pair| (p.coefficient * projected[(p.a as usize, p.b as usize)]).abs();
        let linear: f64 =
            self.each().map(|(i, pairs)| 2.0 * x[i].abs() * pairs.iter().map(size).sum::<f64>()).sum();
        f64::EPSILON * (constant + linear)
    }

    /// Adds `tr(F_i M F_j N)` to the lower triangle of `out` for each i, j; `m` is `W'MW` and `n` is `W'NW`.
    pub(crate) fn add_schur_complement(&self, m: &Mat, n: &Mat, out: &mut Mat) {
        let q = self.columns.ncols();
        let (m, n) = (m.as_slice(), n.as_slice());
        let column = |of: &'_ [f64], k: u32| -> std::ops::Range<usize> {
            debug_assert_eq!(of.len(), q * q);
            k as usize * q..(k as usize + 1) * q
        };
        for (place, (j, outer)) in self.each().enumerate() {
            for p in outer {
                let (ma, mb) = (&m[column(m, p.a)], &m[column(m, p.b)]);
                let (na, nb) = (&n[column(n, p.a)], &n[column(n, p.b)]);
                let target = out.column_mut(j);
                let target = target.data.into_slice_mut();
                for i in place..self.unknowns.len() {
                    let mut sum = 0.0;
                    for s in &self.pairs[self.starts[i] as usize..self.starts[i + 1] as usize] {
                        let (a, b) = (s.a as usize, s.b as usize);
                        sum +=
                            s.coefficient * (mb[a] * na[b] + mb[b] * na[a] + ma[a] * nb[b] + ma[b] * nb[a]);
                    }
                    target[self.unknowns[i] as usize] += p.coefficient * sum;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lmi::program::symmetric;
    use nalgebra::dmatrix;

    /// Every product agrees with that of the dense matrices.
    #[test]
    fn products_agree_with_dense_ones() {
        let mut p = Program::new();
        let (x, s) = (p.symmetric(3), p.symmetric_commuting(&[0, 0, 1]));
        let (t, f, g) = (p.skew_commuting(&[0, 0, 1]), p.full(3, 2), p.scalar());
        let a = dmatrix![1.0, 2.0, 3.0; -1.0, 0.5, 2.0; 0.0, 1.0, 7.0];
        let b = dmatrix![1.0, 0.0; 0.0, -1.0; 2.0, 1.0];
        let lyapunov = x.times(&a);
        let e = symmetric(&[
            vec![lyapunov.t() + lyapunov + s.congruence(&a), x.times(&b) + f.clone(), t.times(&a)],
            vec![g.times_identity(2), Affine::zeros(2, 3)],
            vec![Affine::constant(Mat::identity(3, 3)) - s.clone()],
        ]);
        let data = LowRank::new(&p, &e);
        let (constant, dense) = p.coefficients(&e);
        assert_eq!(*data.constant(), constant);
        let random = |k: usize| Mat::from_fn(8, 8, |i, j| ((1 + i + 8 * j + k) as f64).sin());
        let (m, n) = (symmetric_part(&random(1)), symmetric_part(&random(7)));
        let (of_m, of_n) = (data.projected(&m), data.projected(&n));
        let mut found = vec![0.0; p.unknowns()];
        data.add_inner_products(&of_m, 2.0, &mut found);
        let mut schur = Mat::zeros(p.unknowns(), p.unknowns());
        data.add_schur_complement(&of_m, &of_n, &mut schur);
        let x: Vec<f64> = (0..p.unknowns()).map(|k| (k as f64 + 1.0).cos()).collect();
        assert!((data.linear(&x) + &constant - e.value(&p, &x)).amax() < 1e-12);
        assert_eq!(dense.len(), p.unknowns());
        let norms = data.norms(p.unknowns());
        for (i, fi) in &dense {
            assert!((norms[*i] - fi.norm()).abs() < 1e-12);
            assert!((found[*i] - 2.0 * (fi * &m).trace()).abs() < 1e-11);
            for (j, fj) in dense.iter().filter(|(j, _)| j <= i) {
                let expected = (fi * &m * fj * &n).trace();
                assert!((schur[(*i, *j)] - expected).abs() < 1e-10, "{i} {j}");
            }
        }
    }
}
