//! Matrix inequalities as sums of rank-two matrices.
//!
//! In control problems each F_i of `F(x) = F_0 + sum x_i F_i` comes from an entry of a matrix unknown V in a term `L V
//! R`: it is `sum c (l r' + r l')` with few columns l of L' and r of R'. A product like `tr(F_i M F_j N)` then takes a
//! few entries of `W'MW` and `W'NW`, where W has all these columns, instead of products of matrices.
//!
//! Sources: A. Nemirovskii, P. Gahinet, "The projective method for solving linear matrix inequalities", Math.
//! Programming 77, 1997, section 5 (this structure); K. Fujisawa, M. Kojima, K. Nakata, Math. Programming 79, 1997 (the
//! Schur complement).

use crate::lmi::traces::{Factor, Scratch, Traces};
use crate::lmi::{Affine, Program};
use crate::matrix::{Mat, symmetric_part};
use rayon::prelude::*;
use std::sync::Arc;

/// The least number of columns of a Schur complement per processor, so that small programs use one.
const LEAST_COLUMNS: usize = 100;

/// `coefficient (w_a w_b' + w_b w_a')`, by the indices of two columns of W.
#[derive(Debug, Clone, Copy)]
struct Pair {
    a: u32,
    b: u32,
    coefficient: f64,
}

/// A symmetric matrix that is affine in the unknowns of a program.
///
/// A Hermitian one, `H = P + jK`, is the real matrix `[P, -K; K, P]`: it commutes with multiplication by j, the signed
/// permutation J. Of its `F_i = G_i + J G_i J'` only the pairs of G_i are stored, and only half of a product with
/// matrices that commute with J is computed.
#[derive(Debug, Clone)]
pub(crate) struct LowRank {
    constant: Mat,
    columns: Mat,
    /// The unknowns that occur, ascending.
    unknowns: Vec<u32>,
    /// The first index of each unknown's pairs in `pairs`, and the end.
    starts: Vec<u32>,
    pairs: Vec<Pair>,
    /// The computation of the traces of the Schur complement.
    traces: Arc<Traces>,
    /// The row of v and the sign for each row of `J v`; empty for a real matrix.
    rotation: Vec<(usize, f64)>,
}

/// `W'MW`, and `(JW)'MW` for a Hermitian matrix.
#[derive(Debug, Clone)]
pub(crate) struct Projected {
    plain: Mat,
    rotated: Option<Mat>,
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
        let mut terms_at: Vec<[std::ops::Range<u32>; 2]> = vec![];
        let mut by_unknown: std::collections::BTreeMap<u32, Vec<Pair>> = std::collections::BTreeMap::new();
        for (variable, left, right) in &terms {
            let (left_at, right_at) = (place(left), place(&right.transpose()));
            let (of_left, of_right) = (left.ncols() as u32, right.nrows() as u32);
            terms_at.push([left_at..left_at + of_left, right_at..right_at + of_right]);
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
            traces: Arc::default(),
            rotation: vec![],
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
        let of_unknowns = (0..out.unknowns.len())
            .flat_map(|position| out.pairs_of(position).iter().map(move |p| (position as u32, p.a, p.b)));
        out.traces = Arc::new(Traces::new(terms_at, &of_unknowns.collect::<Vec<_>>()));
        out
    }

    /// Returns the Hermitian inequality `constant + sum x_i (G_i + J G_i J')` with the G_i of `half`.
    pub(crate) fn hermitian(half: Self, constant: &Mat, rotation: Vec<(usize, f64)>) -> Self {
        debug_assert_eq!((half.size(), half.size()), (rotation.len(), constant.nrows()));
        Self { constant: symmetric_part(constant), rotation, ..half }
    }

    /// Returns the inequality `constant + sum x_i F_i` with the F_i of `linear`.
    pub(crate) fn real(linear: Self, constant: &Mat) -> Self {
        Self { constant: symmetric_part(constant), ..linear }
    }

    /// Returns the multiplicity of a sum over the stored pairs: 2 for a Hermitian matrix, else 1.
    fn times(&self) -> f64 {
        if self.rotation.is_empty() { 1.0 } else { 2.0 }
    }

    /// Returns `J m`.
    fn rotated(&self, m: &Mat) -> Mat {
        Mat::from_fn(m.nrows(), m.ncols(), |i, j| self.rotation[i].1 * m[(self.rotation[i].0, j)])
    }

    /// Returns the number of rows.
    pub(crate) fn size(&self) -> usize {
        self.constant.nrows()
    }

    /// Returns F_0.
    pub(crate) fn constant(&self) -> &Mat {
        &self.constant
    }

    /// Returns the inequality after a congruence with a diagonal matrix that divides each row by its size to the power
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

    /// Converts a multiplier of [`Self::with_even_rows`] to one of this inequality.
    pub(crate) fn uneven(&self, multiplier: &Mat, evenness: f64) -> Mat {
        let factors = self.factors(evenness);
        Mat::from_fn(self.size(), self.size(), |i, j| multiplier[(i, j)] * factors[i] * factors[j])
    }

    fn factors(&self, evenness: f64) -> Vec<f64> {
        let squares: Vec<f64> = self.columns.row_iter().map(|row| row.norm_squared()).collect();
        let rotated = |i: usize| self.rotation.get(i).map_or(0.0, |(from, _)| squares[*from]);
        let norms = (0..squares.len()).map(|i| (squares[i] + rotated(i)).sqrt());
        norms.map(|norm| if norm > 0.0 { norm.powf(-evenness) } else { 1.0 }).collect()
    }

    fn each(&self) -> impl Iterator<Item = (usize, &[Pair])> {
        self.unknowns
            .iter()
            .enumerate()
            .map(|(position, unknown)| (*unknown as usize, self.pairs_of(position)))
    }

    /// Returns the pairs of the unknown at index `position` of `unknowns`.
    fn pairs_of(&self, position: usize) -> &[Pair] {
        &self.pairs[self.starts[position] as usize..self.starts[position + 1] as usize]
    }

    /// Returns the Frobenius norms of the first `unknowns` F_i.
    pub(crate) fn norms(&self, unknowns: usize) -> Vec<f64> {
        let gram = self.projected(&Mat::identity(self.size(), self.size()));
        let mut out = vec![0.0; unknowns];
        for (unknown, pairs) in self.each() {
            let each = pairs.iter().flat_map(|p| pairs.iter().map(move |s| (p, s)));
            let square: f64 = each.map(|(p, s)| p.coefficient * s.coefficient * gram.trace(p, s)).sum();
            out[unknown] = (self.times() * square).max(0.0).sqrt();
        }
        out
    }

    /// Returns `sum x_i F_i`.
    pub(crate) fn linear(&self, x: &[f64]) -> Mat {
        // F = W B' + B W' with `B = W C'`, in which column b is the sum of `c x w_a`.
        let mut half = Mat::zeros(self.columns.nrows(), self.columns.ncols());
        for (unknown, pairs) in self.each() {
            for p in pairs {
                half.column_mut(p.b as usize).axpy(
                    p.coefficient * x[unknown],
                    &self.columns.column(p.a as usize),
                    1.0,
                );
            }
        }
        let product = half * self.columns.transpose();
        let sum = product.transpose() + product;
        if self.rotation.is_empty() {
            return sum;
        }
        // J M J' = (J (J M)')' for a symmetric M.
        let rotated = self.rotated(&self.rotated(&sum).transpose());
        sum + rotated
    }

    /// Returns `W' M W` of a symmetric M.
    pub(crate) fn projected(&self, m: &Mat) -> Projected {
        let image = m * &self.columns;
        let rotated = (!self.rotation.is_empty()).then(|| self.rotated(&self.columns).transpose() * &image);
        Projected { plain: self.columns.transpose() * image, rotated }
    }

    /// Adds `factor tr(F_i M)` to `out[i]` for each i, M symmetric.
    pub(crate) fn add_inner_products(&self, m: &Mat, factor: f64, out: &mut [f64]) {
        let image = m * &self.columns;
        let product =
            |p: &Pair| p.coefficient * self.columns.column(p.a as usize).dot(&image.column(p.b as usize));
        for (unknown, pairs) in self.each() {
            out[unknown] += 2.0 * self.times() * factor * pairs.iter().map(product).sum::<f64>();
        }
    }

    /// Returns an estimate of the rounding in `tr(F(x) M)`, summed term by term.
    pub(crate) fn rounding(&self, m: &Mat, x: &[f64]) -> f64 {
        let constant: f64 = self.constant.iter().zip(m.iter()).map(|(f, m)| (f * m).abs()).sum();
        let columns = self.columns.abs();
        let image = m.abs() * &columns;
        let size =
            |p: &Pair| (p.coefficient * columns.column(p.a as usize).dot(&image.column(p.b as usize))).abs();
        let linear: f64 =
            self.each().map(|(i, pairs)| 2.0 * x[i].abs() * pairs.iter().map(size).sum::<f64>()).sum();
        f64::EPSILON * (constant + self.times() * linear)
    }

    /// Adds `tr(F_i M F_j N)` to the lower triangle of `out` for each i, j; `m` and `n` are projections of M and N.
    /// Columns are computed in parallel.
    pub(crate) fn add_schur_complement(&self, m: &Projected, n: &Projected, out: &mut Mat) {
        let rows = out.nrows().max(1);
        let columns = out.as_mut_slice().par_chunks_mut(rows).enumerate().with_min_len(LEAST_COLUMNS);
        columns.for_each_init(Scratch::default, |scratch, (j, target)| {
            let Ok(position) = self.unknowns.binary_search(&(j as u32)) else { return };
            let rotated = m.rotated.as_ref().zip(n.rotated.as_ref());
            let products: Vec<_> = std::iter::once((&m.plain, &n.plain)).chain(rotated).collect();
            let of = |p: &Pair| {
                let (factor, columns) = (self.times() * p.coefficient, (p.a, p.b));
                products.iter().map(move |(m, n)| Factor::new(factor, m, n, columns)).collect::<Vec<_>>()
            };
            let factors: Vec<Factor<'_>> = self.pairs_of(position).iter().flat_map(of).collect();
            self.traces.fill(position, &factors, scratch);
            let traces = &scratch.traces;
            for (inner, unknown) in self.unknowns.iter().enumerate().skip(position) {
                let range = self.starts[inner] as usize..self.starts[inner + 1] as usize;
                let each = self.pairs[range.clone()].iter().zip(self.traces.positions(range));
                target[*unknown as usize] +=
                    each.map(|(s, at)| s.coefficient * traces[*at as usize]).sum::<f64>();
            }
        });
    }
}

impl Projected {
    /// Returns `tr(G M F M)` of two pairs.
    fn trace(&self, p: &Pair, s: &Pair) -> f64 {
        let of = |m: &Mat| Factor::new(1.0, m, m, (p.a, p.b)).trace((s.a, s.b));
        of(&self.plain) + self.rotated.as_ref().map_or(0.0, of)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lmi::program::symmetric;
    use crate::matrix::block;
    use nalgebra::dmatrix;

    /// The products of a Hermitian inequality are those of the equivalent real one.
    #[test]
    fn products_of_a_hermitian_inequality_equal_the_real_ones() {
        let mut p = Program::default();
        let (s, t) = (p.symmetric_commuting(&[0, 0, 1]), p.skew_commuting(&[0, 0, 1]));
        let re = dmatrix![1.0, 2.0; -1.0, 0.5; 0.0, 1.0];
        let im = dmatrix![0.3, -1.0; 2.0, 0.0; 1.0, -0.7];
        let halves = [block(&[&[&re, &-&im]]), block(&[&[&im, &re]])];
        let of = |u: &Mat| {
            let skew = t.between(&(u * 2.0).transpose(), &(u.map(|v| v * v)));
            s.congruence(u) + skew.t() + skew
        };
        // The squares of the second half are not J times those of the first: use its own product.
        let square = halves[0].map(|v| v * v);
        let rotation: Vec<(usize, f64)> = vec![(2, -1.0), (3, -1.0), (0, 1.0), (1, 1.0)];
        let rotated = |m: &Mat| Mat::from_fn(4, 3, |i, j| rotation[i].1 * m[(rotation[i].0, j)]);
        let (other, other_square) = (rotated(&halves[0].transpose()), rotated(&square.transpose()));
        assert_eq!(other, halves[1].transpose());
        let skew = t.between(&(&other * 2.0), &other_square.transpose());
        let full = of(&halves[0]) + s.congruence(&halves[1]) + skew.t() + skew;
        let (half, real) = (LowRank::new(&p, &of(&halves[0])), LowRank::new(&p, &full));
        let constant = halves.iter().fold(Mat::zeros(4, 4), |sum, u| sum + u.transpose() * u);
        let data = LowRank::hermitian(half, &constant, rotation.clone());
        let hermitian = |k: usize| {
            let m = Mat::from_fn(2, 2, |i, j| ((1 + i + 8 * j + k) as f64).sin());
            let skew = dmatrix![0.0, 1.0; -1.0, 0.0] * (k as f64).cos();
            block(&[&[&symmetric_part(&m), &-&skew], &[&skew, &symmetric_part(&m)]])
        };
        let (m, n) = (hermitian(1), hermitian(7));
        let x: Vec<f64> = (0..p.unknowns()).map(|k| (k as f64 + 1.0).cos()).collect();
        assert!((data.linear(&x) - real.linear(&x)).amax() < 1e-12);
        let all = |of: &LowRank| {
            let mut found = vec![0.0; p.unknowns()];
            of.add_inner_products(&m, 2.0, &mut found);
            found.extend(of.norms(p.unknowns()));
            let mut schur = Mat::zeros(p.unknowns(), p.unknowns());
            of.add_schur_complement(&of.projected(&m), &of.projected(&n), &mut schur);
            found.extend(schur.iter());
            found
        };
        for (one, other) in all(&data).into_iter().zip(all(&real)) {
            assert!((one - other).abs() < 1e-11, "{one} {other}");
        }
    }

    /// Every product agrees with the dense matrices.
    #[test]
    fn products_agree_with_dense_ones() {
        let mut p = Program::default();
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
        data.add_inner_products(&m, 2.0, &mut found);
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
