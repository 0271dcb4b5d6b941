//! Matrix expressions that are affine in the unknowns of a program, written like the matrices of the papers.
//!
//! An expression is built from variables by addition, multiplication by constant matrices and transposition, and
//! placed in a symmetric block matrix by [`symmetric`], which takes the upper blocks only.

use crate::matrix::{Mat, unit};

/// One term `left V right` or `left V' right`.
#[derive(Debug, Clone)]
pub(crate) struct Term {
    /// The index of V in its program.
    pub(crate) variable: usize,
    pub(crate) left: Mat,
    pub(crate) right: Mat,
    pub(crate) transposed: bool,
}

/// A matrix that is affine in the variables: a constant and a sum of `L V R`.
#[derive(Debug, Clone)]
pub struct Affine {
    pub(crate) constant: Mat,
    pub(crate) terms: Vec<Term>,
}

impl Affine {
    /// Returns a constant expression.
    pub fn constant(m: Mat) -> Self {
        Self { constant: m, terms: vec![] }
    }

    /// Returns a constant 1 x 1 expression.
    pub fn number(value: f64) -> Self {
        Self::constant(Mat::from_element(1, 1, value))
    }

    /// Returns `sum_k weight(k) family[k]` of square expressions of one size; terms of weight 0 are left out.
    pub(crate) fn weighted(family: &[Self], weight: impl Fn(usize) -> f64) -> Self {
        let n = family.first().map_or(0, |m| m.shape().0);
        let terms = family.iter().enumerate().map(|(k, m)| (weight(k), m));
        terms.filter(|(w, _)| *w != 0.0).fold(Self::zeros(n, n), |sum, (w, m)| sum + m.scaled(w))
    }

    /// Returns the zero expression of a given shape.
    pub fn zeros(rows: usize, cols: usize) -> Self {
        Self::constant(Mat::zeros(rows, cols))
    }

    /// Returns rows and columns.
    pub fn shape(&self) -> (usize, usize) {
        self.constant.shape()
    }

    /// Returns `left E right` for constant matrices. Shapes: E is p x q, `left` a x p, `right` q x b.
    pub fn between(&self, left: &Mat, right: &Mat) -> Self {
        Self {
            constant: left * &self.constant * right,
            terms: self
                .terms
                .iter()
                .map(|t| Term { left: left * &t.left, right: &t.right * right, ..*t })
                .collect(),
        }
    }

    /// Returns `left E`. Shapes: E is p x q, `left` a x p.
    pub fn after(&self, left: &Mat) -> Self {
        self.between(left, &Mat::identity(self.shape().1, self.shape().1))
    }

    /// Returns `E right`. Shapes: E is p x q, `right` q x b.
    pub fn times(&self, right: &Mat) -> Self {
        self.between(&Mat::identity(self.shape().0, self.shape().0), right)
    }

    /// Returns the transpose.
    pub fn t(&self) -> Self {
        Self {
            constant: self.constant.transpose(),
            terms: self
                .terms
                .iter()
                .map(|t| Term {
                    variable: t.variable,
                    left: t.right.transpose(),
                    right: t.left.transpose(),
                    transposed: !t.transposed,
                })
                .collect(),
        }
    }

    /// Returns `N' E N`, a congruence. Shapes: E is p x p, N p x q.
    pub fn congruence(&self, n: &Mat) -> Self {
        self.between(&n.transpose(), n)
    }

    /// Returns `factor E`.
    pub fn scaled(&self, factor: f64) -> Self {
        Self {
            constant: &self.constant * factor,
            terms: self.terms.iter().map(|t| Term { left: &t.left * factor, ..t.clone() }).collect(),
        }
    }

    /// Returns `e I_n` for a 1 x 1 expression e. n x n.
    pub fn times_identity(&self, n: usize) -> Self {
        let mut out = Self::zeros(n, n);
        for i in 0..n {
            out = out + self.between(&unit(n, i), &unit(n, i).transpose());
        }
        out
    }

    fn placed(&self, rows: usize, cols: usize, top: usize, left: usize) -> Self {
        let (m, n) = self.shape();
        let lift = Mat::from_fn(rows, m, |i, k| if i == top + k { 1.0 } else { 0.0 });
        let spread = Mat::from_fn(n, cols, |k, j| if j == left + k { 1.0 } else { 0.0 });
        self.between(&lift, &spread)
    }
}

impl std::ops::Add for Affine {
    type Output = Affine;
    fn add(mut self, other: Affine) -> Affine {
        self.constant += other.constant;
        self.terms.extend(other.terms);
        self
    }
}

impl std::ops::Sub for Affine {
    type Output = Affine;
    fn sub(self, other: Affine) -> Affine {
        self + other.scaled(-1.0)
    }
}

impl std::ops::Neg for Affine {
    type Output = Affine;
    fn neg(self) -> Affine {
        self.scaled(-1.0)
    }
}

/// Returns the symmetric block matrix with these upper blocks: row i holds the blocks (i, i), (i, i+1), ...
///
/// Diagonal blocks must be symmetric expressions.
pub fn symmetric(upper: &[Vec<Affine>]) -> Affine {
    let sizes: Vec<usize> = upper.iter().map(|row| row[0].shape().0).collect();
    let starts: Vec<usize> = sizes.iter().scan(0, |at, s| Some(std::mem::replace(at, *at + s))).collect();
    let total = sizes.iter().sum();
    let mut out = Affine::zeros(total, total);
    for (i, row) in upper.iter().enumerate() {
        for (offset, expression) in row.iter().enumerate() {
            let j = i + offset;
            debug_assert_eq!(expression.shape(), (sizes[i], sizes[j]), "block ({i}, {j})");
            let placed = expression.placed(total, total, starts[i], starts[j]);
            if i != j {
                out = out + placed.t();
            }
            out = out + placed;
        }
    }
    out
}
