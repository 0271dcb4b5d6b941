//! D-G scalings as real unknowns, and the matrix that proves a bound, as a sum of low-rank matrices.
//!
//! ```text
//! Phi(lambda) = lambda D_w - M* D_z M - j (G M - M* G)
//! ```
//!
//! D commutes with the structure and is positive definite (D_w on the side of w, D_z on that of z, of different size
//! for a full block that is not square); G is Hermitian on the real blocks and zero elsewhere. `Phi(beta^2) > 0` proves
//! that mu < beta.

use super::product::product;
use crate::mu::CMat;
use crate::mu::structure::{Block, Structure};
use nalgebra::Complex;
use std::ops::Range;

/// A term `coefficient w_x w_y*`, by the indices of columns of `W = [I, M*]`.
#[derive(Debug, Clone, Copy)]
struct Product {
    x: usize,
    y: usize,
    coefficient: Complex<f64>,
    /// `true` if it is multiplied by lambda.
    scaled: bool,
}

/// The contributions of one unknown.
#[derive(Debug, Clone)]
struct Unknown {
    /// Contributions to Phi.
    products: Vec<Product>,
    /// Contribution to D: the block, and the entries `(i, j, value)` of its matrix. Empty for an unknown of G.
    block: usize,
    entries: Vec<(usize, usize, Complex<f64>)>,
    is_g: bool,
}

/// The unknowns of a structure.
#[derive(Debug, Clone)]
pub(in crate::mu) struct Family {
    places: Vec<(Block, Range<usize>, Range<usize>)>,
    rows: usize,
    cols: usize,
    unknowns: Vec<Unknown>,
}

/// Values of D and G.
#[derive(Debug, Clone, PartialEq)]
pub struct DgScalings {
    /// D on the side of w.
    pub dw: CMat,
    /// D on the side of z.
    pub dz: CMat,
    /// G, from z to w.
    pub g: CMat,
}

const J: Complex<f64> = Complex::new(0.0, 1.0);
const ONE: Complex<f64> = Complex::new(1.0, 0.0);

/// Returns a basis of the Hermitian r x r matrices over the reals, each as a list of entries.
fn hermitian_basis(r: usize) -> Vec<Vec<(usize, usize, Complex<f64>)>> {
    let mut out = vec![];
    for k in 0..r {
        out.push(vec![(k, k, ONE)]);
        for l in k + 1..r {
            out.push(vec![(k, l, ONE), (l, k, ONE)]);
            out.push(vec![(k, l, J), (l, k, -J)]);
        }
    }
    out
}

/// A product with its weight at one lambda.
#[derive(Debug, Clone, Copy)]
struct Weighted {
    x: usize,
    y: usize,
    weight: Complex<f64>,
}

/// All products of all unknowns at one lambda.
pub(in crate::mu) struct AtLambda {
    /// The products; those of unknown i are `products[starts[i]..starts[i + 1]]`.
    products: Vec<Weighted>,
    starts: Vec<usize>,
    /// The products without those that are the adjoint of another one, which is doubled instead.
    halves: Vec<Weighted>,
    half_starts: Vec<usize>,
}

impl AtLambda {
    fn products(&self, i: usize) -> &[Weighted] {
        &self.products[self.starts[i]..self.starts[i + 1]]
    }

    /// Returns `tr(F_i N)` for every unknown, where `product(y, x)` gives the entries of `W* N W`.
    pub(in crate::mu) fn along(
        &self,
        product: impl Fn(usize, usize) -> Complex<f64>,
    ) -> impl Iterator<Item = f64> {
        (1..self.starts.len())
            .map(move |i| self.products(i - 1).iter().map(|p| (p.weight * product(p.y, p.x)).re).sum())
    }

    /// Adds `tr(F_i K F_j K)` for every j from i on, for a Hermitian K given by its columns of n entries; `sums` is
    /// work space with one entry per product.
    fn curvatures(&self, i: usize, k: &[Complex<f64>], n: usize, sums: &mut [Complex<f64>], out: &mut [f64]) {
        let first = self.starts[i];
        let others = &self.products[first..];
        let sums = &mut sums[first..];
        sums.fill(Complex::new(0.0, 0.0));
        let mut column_weighted = vec![Complex::new(0.0, 0.0); n];
        for p in &self.halves[self.half_starts[i]..self.half_starts[i + 1]] {
            let (column, row) = (&k[p.x * n..(p.x + 1) * n], &k[p.y * n..(p.y + 1) * n]);
            column_weighted.iter_mut().zip(column).for_each(|(w, v)| *w = p.weight * v);
            for (sum, q) in sums.iter_mut().zip(others) {
                *sum += column_weighted[q.y] * row[q.x].conj();
            }
        }
        for (j, out) in out.iter_mut().enumerate().skip(i) {
            let range = self.starts[j] - first..self.starts[j + 1] - first;
            let terms = others[range.clone()].iter().zip(&sums[range]);
            *out += terms.map(|(q, sum)| (q.weight * sum).re).sum::<f64>();
        }
    }

    /// Returns a bound of the sum of the absolute terms of the curvature along an unknown.
    fn curvature_terms(&self, i: usize, inner: &CMat) -> f64 {
        let pairs = self.products(i).iter().flat_map(|p| self.products(i).iter().map(move |q| (p, q)));
        pairs.map(|(p, q)| (p.weight * q.weight * inner[(q.y, p.x)] * inner[(p.y, q.x)]).l1_norm()).sum()
    }
}

impl Family {
    pub(in crate::mu) fn new(structure: &Structure) -> Self {
        let (rows, cols, places) = (structure.rows(), structure.cols(), structure.places());
        let mut unknowns = vec![];
        for (block, (kind, w, z)) in places.iter().enumerate() {
            let plus = |a: usize, b: usize, coefficient, scaled| Product { x: a, y: b, coefficient, scaled };
            match kind {
                Block::Full { .. } => {
                    let of_w = w.clone().map(|a| plus(a, a, ONE, true));
                    let of_z = z.clone().map(|c| plus(rows + c, rows + c, -ONE, false));
                    let products = of_w.chain(of_z).collect();
                    unknowns.push(Unknown { products, block, entries: vec![(0, 0, ONE)], is_g: false });
                }
                Block::Real(r) | Block::Complex(r) => {
                    for entries in hermitian_basis(*r) {
                        let products = entries.iter().flat_map(|&(k, l, v)| {
                            let (a, b) = (rows + z.start + k, rows + z.start + l);
                            [plus(w.start + k, w.start + l, v, true), plus(a, b, -v, false)]
                        });
                        let products = products.collect();
                        unknowns.push(Unknown { products, block, entries, is_g: false });
                    }
                }
            }
            if let Block::Real(r) = kind {
                for entries in hermitian_basis(*r) {
                    // -j (G M - M* G)
                    let products = entries.iter().flat_map(|&(k, l, v)| {
                        let (a, b) = (rows + z.start + k, rows + z.start + l);
                        [plus(w.start + k, b, -J * v, false), plus(a, w.start + l, J * v, false)]
                    });
                    let products = products.collect();
                    unknowns.push(Unknown { products, block, entries, is_g: true });
                }
            }
        }
        Self { places, rows, cols, unknowns }
    }

    pub(in crate::mu) fn unknowns(&self) -> usize {
        self.unknowns.len()
    }

    /// Returns D = I and G = 0; also the gradient of the trace of D, in which a full block has weight one.
    pub(in crate::mu) fn identity(&self) -> Vec<f64> {
        let on_diagonal = |u: &Unknown| !u.is_g && u.entries.len() == 1;
        self.unknowns.iter().map(|u| if on_diagonal(u) { 1.0 } else { 0.0 }).collect()
    }

    pub(in crate::mu) fn values(&self, p: &[f64]) -> DgScalings {
        let mut dw = CMat::zeros(self.rows, self.rows);
        let mut dz = CMat::zeros(self.cols, self.cols);
        let mut g = CMat::zeros(self.rows, self.cols);
        for (u, value) in self.unknowns.iter().zip(p) {
            let (kind, w, z) = &self.places[u.block];
            if matches!(kind, Block::Full { .. }) {
                w.clone().for_each(|a| dw[(a, a)] += ONE * *value);
                z.clone().for_each(|c| dz[(c, c)] += ONE * *value);
                continue;
            }
            for &(k, l, v) in &u.entries {
                if u.is_g {
                    g[(w.start + k, z.start + l)] += v * *value;
                } else {
                    dw[(w.start + k, w.start + l)] += v * *value;
                    dz[(z.start + k, z.start + l)] += v * *value;
                }
            }
        }
        DgScalings { dw, dz, g }
    }

    /// Returns the blocks of D, a full one as 1 x 1.
    pub(in crate::mu) fn d_blocks(&self, s: &DgScalings) -> Vec<CMat> {
        let part = |(kind, w, _): &(Block, Range<usize>, Range<usize>)| {
            let n = if matches!(kind, Block::Full { .. }) { 1 } else { w.len() };
            s.dw.view((w.start, w.start), (n, n)).into_owned()
        };
        self.places.iter().map(part).collect()
    }

    /// Returns the products at one lambda.
    pub(in crate::mu) fn at(&self, lambda: f64) -> AtLambda {
        let mut at = AtLambda { products: vec![], starts: vec![0], halves: vec![], half_starts: vec![0] };
        for unknown in &self.unknowns {
            for p in &unknown.products {
                let weight = if p.scaled { p.coefficient * lambda } else { p.coefficient };
                at.products.push(Weighted { x: p.x, y: p.y, weight });
                // F_i is Hermitian: the product of y and x is the adjoint of that of x and y.
                if p.x <= p.y {
                    let weight = if p.x < p.y { weight * 2.0 } else { weight };
                    at.halves.push(Weighted { x: p.x, y: p.y, weight });
                }
            }
            at.starts.push(at.products.len());
            at.half_starts.push(at.halves.len());
        }
        at
    }

    /// Computes gradient and Hessian of `-sum log det Phi(lambda) - log det D`, with `W* Phi^-1 W` of each matrix and
    /// the inverses of D's blocks.
    ///
    /// Unknowns of G without effect, because they meet zeros of M, are fixed: one on the diagonal, zero in the rest of
    /// the row.
    pub(in crate::mu) fn derivatives(
        &self,
        at: &AtLambda,
        inners: &[CMat],
        d_inverses: &[CMat],
        gradient: &mut [f64],
        hessian: &mut nalgebra::DMatrix<f64>,
    ) {
        let count = self.unknowns.len();
        let (mut row, mut sums) = (vec![0.0; count], vec![Complex::new(0.0, 0.0); at.products.len()]);
        let mut idle = vec![];
        for (i, one) in self.unknowns.iter().enumerate() {
            row.fill(0.0);
            for inner in inners {
                at.curvatures(i, inner.as_slice(), inner.nrows(), &mut sums, &mut row);
            }
            let terms = || inners.iter().map(|inner| at.curvature_terms(i, inner)).sum::<f64>();
            if one.is_g && row[i] <= CANCELLED * terms() {
                idle.push(i);
            }
            let each = inners.iter().flat_map(|inner| at.products(i).iter().map(move |p| (p, inner)));
            let mut slope = -each.map(|(p, inner)| (p.weight * inner[(p.y, p.x)]).re).sum::<f64>();
            if !one.is_g {
                let d = &d_inverses[one.block];
                slope -= one.entries.iter().map(|&(a, b, v)| (v * d[(b, a)]).re).sum::<f64>();
                let others = self.unknowns.iter().enumerate().skip(i);
                for (j, other) in others.take_while(|(_, o)| o.block == one.block).filter(|(_, o)| !o.is_g) {
                    for &(a, b, v) in &one.entries {
                        let each = other.entries.iter().map(|&(k, l, u)| (v * u * d[(l, a)] * d[(b, k)]).re);
                        row[j] += each.sum::<f64>();
                    }
                }
            }
            gradient[i] = slope;
            for j in i..count {
                hessian[(i, j)] = row[j];
                hessian[(j, i)] = row[j];
            }
        }
        for i in idle {
            gradient[i] = 0.0;
            hessian.row_mut(i).fill(0.0);
            hessian.column_mut(i).fill(0.0);
            hessian[(i, i)] = 1.0;
        }
    }

    /// Returns the point of scalings, scaled to the trace of D of the identity: the inverse of [`Self::values`] up to a
    /// factor.
    pub(in crate::mu) fn point(&self, s: &DgScalings) -> Vec<f64> {
        let value = |u: &Unknown| {
            let (_, w, z) = &self.places[u.block];
            let (k, l, v) = u.entries[0];
            let entry =
                if u.is_g { s.g[(w.start + k, z.start + l)] } else { s.dw[(w.start + k, w.start + l)] };
            (v.conj() * entry).re
        };
        let p: Vec<f64> = self.unknowns.iter().map(value).collect();
        let along = |p: &[f64]| self.identity().iter().zip(p).map(|(t, v)| t * v).sum::<f64>();
        let factor = along(&self.identity()) / along(&p);
        p.into_iter().map(|v| v * factor).collect()
    }
}

/// The relative size below which a sum is taken as zero.
const CANCELLED: f64 = 1e-12;

impl DgScalings {
    /// Returns `M* D_z M + j (G M - M* G)`, which must be below `lambda D_w`.
    pub fn left(&self, m: &CMat) -> CMat {
        // (M* D_z/2 + j G) M and its adjoint.
        let half = product(&(product(&m.adjoint(), &self.dz) * Complex::new(0.5, 0.0) + &self.g * J), m);
        &half + half.adjoint()
    }

    /// Returns the scalings of some entries of z and of w.
    pub(in crate::mu) fn cut(&self, z: &[usize], w: &[usize]) -> Self {
        let part = |m: &CMat, rows: &[usize], cols: &[usize]| m.select_rows(rows).select_columns(cols);
        Self { dw: part(&self.dw, w, w), dz: part(&self.dz, z, z), g: part(&self.g, w, z) }
    }

    /// Sets the scalings of some entries of z and of w to those given, times a weight.
    pub(in crate::mu) fn set(&mut self, z: &[usize], w: &[usize], given: &Self, weight: f64) {
        let copy = |to: &mut CMat, rows: &[usize], cols: &[usize], from: &CMat| {
            for (i, row) in rows.iter().enumerate() {
                for (j, col) in cols.iter().enumerate() {
                    to[(*row, *col)] = from[(i, j)] * weight;
                }
            }
        };
        copy(&mut self.dw, w, w, &given.dw);
        copy(&mut self.dz, z, z, &given.dz);
        copy(&mut self.g, w, z, &given.g);
    }

    /// Returns the scalings of `M` from those of `T_z M T_w^-1 / size` with diagonal T, the coordinates `w = T_w w~`,
    /// `z = T_z z~`.
    pub(in crate::mu) fn undone(&self, tw: &[f64], tz: &[f64], size: f64) -> Self {
        let scaled = |m: &CMat, left: &[f64], right: &[f64], by: f64| {
            CMat::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)] * (left[i] * right[j] * by))
        };
        Self {
            dw: scaled(&self.dw, tw, tw, 1.0),
            dz: scaled(&self.dz, tz, tz, 1.0),
            g: scaled(&self.g, tw, tz, size),
        }
    }

    /// Returns the inverse of [`Self::undone`].
    pub(in crate::mu) fn redone(&self, tw: &[f64], tz: &[f64], size: f64) -> Self {
        let inverse = |t: &[f64]| t.iter().map(|v| 1.0 / v).collect::<Vec<f64>>();
        self.undone(&inverse(tw), &inverse(tz), 1.0 / size)
    }
}
