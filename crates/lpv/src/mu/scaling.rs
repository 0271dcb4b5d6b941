//! D-G scalings as real unknowns, and the matrix that shows a bound, as a sum of matrices of low rank.
//!
//! ```text
//! Phi(lambda) = lambda D_w - M* D_z M - j (G M - M* G)
//! ```
//!
//! D commutes with the structure and is positive definite (D_w on the side of w, D_z on that of z, which differ in size where a full block is not
//! square); G is Hermitian on the real blocks and zero elsewhere. `Phi(beta^2) > 0` shows that mu < beta.

use super::CMat;
use super::structure::{Block, Structure};
use nalgebra::Complex;
use std::ops::Range;

/// `coefficient w_x w_y*`, by the numbers of columns of `W = [I, M*]`.
#[derive(Debug, Clone, Copy)]
struct Product {
    x: usize,
    y: usize,
    coefficient: Complex<f64>,
    /// Whether lambda multiplies it.
    scaled: bool,
}

/// What one unknown adds.
#[derive(Debug, Clone)]
struct Unknown {
    /// To Phi.
    products: Vec<Product>,
    /// To D: the block, and the entries `(i, j, value)` of its matrix. Empty for an unknown of G.
    block: usize,
    entries: Vec<(usize, usize, Complex<f64>)>,
    is_g: bool,
}

/// The unknowns of a structure.
#[derive(Debug, Clone)]
pub(super) struct Family {
    places: Vec<(Block, Range<usize>, Range<usize>)>,
    rows: usize,
    cols: usize,
    unknowns: Vec<Unknown>,
}

/// Values of D and G.
#[derive(Debug, Clone, PartialEq)]
pub struct Scalings {
    /// D on the side of w.
    pub dw: CMat,
    /// D on the side of z.
    pub dz: CMat,
    /// G, from z to w.
    pub g: CMat,
}

const J: Complex<f64> = Complex::new(0.0, 1.0);
const ONE: Complex<f64> = Complex::new(1.0, 0.0);

/// A basis of the Hermitian r x r matrices over the reals, each by its entries.
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

impl Unknown {
    /// The sum of the sizes of what the curvature along an unknown of G is a sum of.
    fn curvature_terms(&self, inner: &CMat) -> f64 {
        let pairs = self.products.iter().flat_map(|p| self.products.iter().map(move |q| (p, q)));
        pairs
            .map(|(p, q)| (p.coefficient * q.coefficient * inner[(q.y, p.x)] * inner[(p.y, q.x)]).norm())
            .sum()
    }
}

impl Family {
    pub(super) fn new(structure: &Structure) -> Self {
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

    pub(super) fn unknowns(&self) -> usize {
        self.unknowns.len()
    }

    /// D = I and G = 0.
    pub(super) fn identity(&self) -> Vec<f64> {
        let on_diagonal = |u: &Unknown| !u.is_g && u.entries.len() == 1;
        self.unknowns.iter().map(|u| if on_diagonal(u) { 1.0 } else { 0.0 }).collect()
    }

    /// The gradient of the trace of D, a full block counted once.
    pub(super) fn trace(&self) -> Vec<f64> {
        self.identity()
    }

    pub(super) fn values(&self, p: &[f64]) -> Scalings {
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
        Scalings { dw, dz, g }
    }

    /// Each block of D, a full one as 1 x 1.
    pub(super) fn d_blocks(&self, s: &Scalings) -> Vec<CMat> {
        let part = |(kind, w, _): &(Block, Range<usize>, Range<usize>)| {
            let n = order(*kind, w);
            s.dw.view((w.start, w.start), (n, n)).into_owned()
        };
        self.places.iter().map(part).collect()
    }

    /// `tr(F_i N)` for every unknown, `seen` being `W* N W`.
    pub(super) fn products<'a>(&'a self, lambda: f64, seen: &'a CMat) -> impl Iterator<Item = f64> + 'a {
        let weight = move |p: &Product| if p.scaled { p.coefficient * lambda } else { p.coefficient };
        self.unknowns.iter().map(move |u| u.products.iter().map(|p| (weight(p) * seen[(p.y, p.x)]).re).sum())
    }

    /// Gradient and Hessian of `-log det Phi(lambda) - log det D`, with `inner = W* Phi^-1 W` and the inverses of D's blocks.
    ///
    /// Unknowns of G that change nothing, because they meet zeros of M, are held: one on the diagonal, zero beside it.
    pub(super) fn derivatives(
        &self,
        lambda: f64,
        inner: &CMat,
        d_inverses: &[CMat],
        gradient: &mut [f64],
        hessian: &mut nalgebra::DMatrix<f64>,
    ) {
        let weight = |p: &Product| if p.scaled { p.coefficient * lambda } else { p.coefficient };
        let mut idle = vec![];
        for (i, one) in self.unknowns.iter().enumerate() {
            let mut slope: f64 =
                -one.products.iter().map(|p| (weight(p) * inner[(p.y, p.x)]).re).sum::<f64>();
            for (j, other) in self.unknowns.iter().enumerate().skip(i) {
                let mut curvature = 0.0;
                for p in &one.products {
                    let sum: Complex<f64> = other
                        .products
                        .iter()
                        .map(|q| weight(q) * inner[(q.y, p.x)] * inner[(p.y, q.x)])
                        .sum();
                    curvature += (weight(p) * sum).re;
                }
                if i == j && one.is_g && curvature <= CANCELLED * one.curvature_terms(inner) {
                    idle.push(i);
                }
                if one.block == other.block && !one.is_g && !other.is_g {
                    let d = &d_inverses[one.block];
                    for &(a, b, v) in &one.entries {
                        for &(k, l, u) in &other.entries {
                            curvature += (v * u * d[(l, a)] * d[(b, k)]).re;
                        }
                    }
                }
                hessian[(i, j)] = curvature;
                hessian[(j, i)] = curvature;
            }
            if !one.is_g {
                let d = &d_inverses[one.block];
                slope -= one.entries.iter().map(|&(a, b, v)| (v * d[(b, a)]).re).sum::<f64>();
            }
            gradient[i] = slope;
        }
        for i in idle {
            gradient[i] = 0.0;
            hessian.row_mut(i).fill(0.0);
            hessian.column_mut(i).fill(0.0);
            hessian[(i, i)] = 1.0;
        }
    }
}

/// A sum this small, relative to its terms, is zero but for rounding.
const CANCELLED: f64 = 1e-12;

fn order(block: Block, w: &Range<usize>) -> usize {
    if matches!(block, Block::Full { .. }) { 1 } else { w.len() }
}

impl Scalings {
    /// `M* D_z M + j (G M - M* G)`, of which `lambda D_w` must be larger.
    pub fn left(&self, m: &CMat) -> CMat {
        let gm = &self.g * m;
        let whole = m.adjoint() * &self.dz * m + (&gm - gm.adjoint()) * J;
        (&whole + whole.adjoint()) * Complex::new(0.5, 0.0)
    }

    /// The scalings in the coordinates `w = T_w w~`, `z = T_z z~` undone, for a matrix divided by `size`:
    /// those of `M` from those of `T_z M T_w^-1 / size`, T diagonal.
    pub(super) fn undone(&self, tw: &[f64], tz: &[f64], size: f64) -> Self {
        let scaled = |m: &CMat, left: &[f64], right: &[f64], by: f64| {
            CMat::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)] * (left[i] * right[j] * by))
        };
        Self {
            dw: scaled(&self.dw, tw, tw, 1.0),
            dz: scaled(&self.dz, tz, tz, 1.0),
            g: scaled(&self.g, tw, tz, size),
        }
    }
}
