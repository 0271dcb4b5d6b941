//! Programs: linear matrix inequalities between [`Affine`] expressions, and an objective.

use crate::lmi::Term;
pub use crate::lmi::affine::{Affine, symmetric};
use crate::matrix::{Mat, symmetric_part};

/// A matrix unknown of a program; an entry `(i, j)` is the sum of `coefficient x[unknown]`.
#[derive(Debug, Clone)]
pub struct Variable {
    rows: usize,
    cols: usize,
    /// Index of the first unknown.
    first: usize,
    /// 1 if it equals its transpose, -1 if its negative, none otherwise.
    sign: Option<f64>,
    /// The entries of each unknown.
    basis: Vec<Vec<(usize, usize, f64)>>,
}

impl Affine {
    /// Returns the value at `x`, the unknowns of `program`.
    pub fn value(&self, program: &Program, x: &[f64]) -> Mat {
        let mut out = self.constant.clone();
        for t in &self.terms {
            let v = program.variables[t.variable].value(x);
            out += &t.left * if t.transposed { v.transpose() } else { v } * &t.right;
        }
        out
    }
}

impl Variable {
    /// Returns the variable's value at the unknowns `x`.
    pub fn value(&self, x: &[f64]) -> Mat {
        let mut out = Mat::zeros(self.rows, self.cols);
        for (k, entries) in self.basis.iter().enumerate() {
            for &(i, j, coefficient) in entries {
                out[(i, j)] += coefficient * x[self.first + k];
            }
        }
        out
    }
}

/// An inequality `expression > 0`, in the sense of symmetric matrices, with a name for diagnostics.
#[derive(Debug, Clone)]
pub(crate) struct Inequality {
    pub(crate) name: &'static str,
    pub(crate) expression: Affine,
}

/// A semidefinite program: minimise a linear objective under linear matrix inequalities.
#[derive(Debug, Clone, Default)]
pub struct Program {
    variables: Vec<Variable>,
    unknowns: usize,
    pub(crate) inequalities: Vec<Inequality>,
    objective: Vec<(usize, f64)>,
}

impl Program {
    /// Returns the number of scalar unknowns.
    pub fn unknowns(&self) -> usize {
        self.unknowns
    }

    fn add(
        &mut self,
        rows: usize,
        cols: usize,
        sign: Option<f64>,
        basis: Vec<Vec<(usize, usize, f64)>>,
    ) -> Affine {
        let variable = self.variables.len();
        let first = self.unknowns;
        self.unknowns += basis.len();
        self.variables.push(Variable { rows, cols, first, sign, basis });
        Affine {
            constant: Mat::zeros(rows, cols),
            terms: vec![Term {
                variable,
                left: Mat::identity(rows, rows),
                right: Mat::identity(cols, cols),
                transposed: false,
            }],
        }
    }

    /// Adds a scalar unknown and returns it as a 1 x 1 expression.
    pub fn scalar(&mut self) -> Affine {
        self.add(1, 1, Some(1.0), vec![vec![(0, 0, 1.0)]])
    }

    /// Adds a symmetric n x n unknown.
    pub fn symmetric(&mut self, n: usize) -> Affine {
        self.symmetric_commuting(&vec![0; n])
    }

    /// Adds a symmetric unknown that commutes with `Theta = diag(theta[channels[i]])`: entry (i, j) is free if the
    /// channels i and j have the same parameter, and zero otherwise.
    pub fn symmetric_commuting(&mut self, channels: &[usize]) -> Affine {
        let n = channels.len();
        let basis = pairs(channels, 0)
            .map(|(i, j)| if i == j { vec![(i, i, 1.0)] } else { vec![(i, j, 1.0), (j, i, 1.0)] })
            .collect();
        self.add(n, n, Some(1.0), basis)
    }

    /// Adds a skew-symmetric unknown that commutes with Theta, as [`Program::symmetric_commuting`].
    pub fn skew_commuting(&mut self, channels: &[usize]) -> Affine {
        let n = channels.len();
        let basis = pairs(channels, 1).map(|(i, j)| vec![(i, j, 1.0), (j, i, -1.0)]).collect();
        self.add(n, n, Some(-1.0), basis)
    }

    /// Adds a full unknown.
    pub fn full(&mut self, rows: usize, cols: usize) -> Affine {
        let basis = (0..cols).flat_map(|j| (0..rows).map(move |i| vec![(i, j, 1.0)])).collect();
        self.add(rows, cols, None, basis)
    }

    /// Adds the inequality `expression > 0`. The expression is square and symmetric.
    pub fn positive(&mut self, name: &'static str, expression: Affine) {
        if expression.shape().0 > 0 {
            self.inequalities.push(Inequality { name, expression });
        }
    }

    /// Adds the inequality `expression < 0`. The expression is square and symmetric.
    pub fn negative(&mut self, name: &'static str, expression: Affine) {
        self.positive(name, -expression);
    }

    /// Replaces `E > 0` by `E > by I` in the inequalities named `name`, for a 1 x 1 expression `by`. Shapes: E square,
    /// of any size.
    pub fn tighten(&mut self, name: &'static str, by: &Affine) {
        for inequality in self.inequalities.iter_mut().filter(|i| i.name == name) {
            let n = inequality.expression.shape().0;
            inequality.expression = inequality.expression.clone() - by.times_identity(n);
        }
    }

    /// Removes the inequalities named `name`.
    pub fn without(&mut self, name: &'static str) {
        self.inequalities.retain(|i| i.name != name);
    }

    /// Adds `weight trace(E)` of an expression without constant part to the objective to be minimised.
    pub fn minimise_trace(&mut self, expression: &Affine, weight: f64) {
        for term in &expression.terms {
            let variable = &self.variables[term.variable];
            for (k, entries) in variable.basis.iter().enumerate() {
                // trace(L V R) = trace(R L V)
                let product = &term.right * &term.left;
                let sum: f64 = entries
                    .iter()
                    .map(|&(i, j, c)| c * if term.transposed { product[(i, j)] } else { product[(j, i)] })
                    .sum();
                if sum != 0.0 {
                    self.objective.push((variable.first + k, weight * sum));
                }
            }
        }
    }

    /// Returns the symmetric part of an expression without its constant, as the symmetric part of a sum of `L V R`:
    /// terms of one variable with the same L or the same R are merged.
    pub(crate) fn merged_terms(&self, expression: &Affine) -> Vec<(usize, Mat, Mat)> {
        let mut out: Vec<(usize, Mat, Mat)> = vec![];
        for term in &expression.terms {
            let (mut left, mut right) = (term.left.clone(), term.right.clone());
            if term.transposed {
                // The symmetric part of L V' R is that of R' V L'.
                (left, right) = (right.transpose(), left.transpose());
            }
            let sign = self.variables[term.variable].sign;
            let known =
                out.iter_mut().filter(|(variable, ..)| *variable == term.variable).find_map(|(_, l, r)| {
                    if *l == left {
                        *r += &right;
                    } else if *r == right {
                        *l += &left;
                    } else {
                        // If V' = sign V, it is also that of sign R' V L'.
                        let sign = sign?;
                        if *l == right.transpose() {
                            *r += left.transpose() * sign;
                        } else if r.transpose() == left {
                            *l += right.transpose() * sign;
                        } else {
                            return None;
                        }
                    }
                    Some(())
                });
            if known.is_none() {
                out.push((term.variable, left, right));
            }
        }
        out
    }

    /// Returns the unknowns of a variable, each with its entries.
    pub(crate) fn entries(&self, variable: usize) -> impl Iterator<Item = (usize, &[(usize, usize, f64)])> {
        let variable = &self.variables[variable];
        variable.basis.iter().enumerate().map(|(k, entries)| (variable.first + k, entries.as_slice()))
    }

    /// Returns the objective's coefficient of each unknown.
    pub(crate) fn costs(&self) -> Vec<f64> {
        let mut out = vec![0.0; self.unknowns];
        for &(k, c) in &self.objective {
            out[k] += c;
        }
        out
    }

    /// Sets the unknowns in `x` so that `variable`, an expression that is a single variable, has the value `value`.
    pub fn set(&self, x: &mut [f64], variable: &Affine, value: &Mat) {
        for term in &variable.terms {
            for (unknown, entries) in self.entries(term.variable) {
                if let Some(&(i, j, coefficient)) = entries.first() {
                    x[unknown] = value[(i, j)] / coefficient;
                }
            }
        }
    }

    /// Returns the constant part of an expression, and the coefficient matrix of each unknown that occurs.
    pub(crate) fn coefficients(&self, expression: &Affine) -> (Mat, Vec<(usize, Mat)>) {
        let n = expression.shape().0;
        let mut by_unknown: Vec<Option<Mat>> = vec![None; self.unknowns];
        for term in &expression.terms {
            let variable = &self.variables[term.variable];
            for (k, entries) in variable.basis.iter().enumerate() {
                let target = by_unknown[variable.first + k].get_or_insert_with(|| Mat::zeros(n, n));
                for &(i, j, coefficient) in entries {
                    let (row, col) = if term.transposed { (j, i) } else { (i, j) };
                    target.ger(coefficient, &term.left.column(row), &term.right.row(col).transpose(), 1.0);
                }
            }
        }
        let coefficients = by_unknown
            .into_iter()
            .enumerate()
            .filter_map(|(k, m)| m.map(|m| (k, symmetric_part(&m))))
            .filter(|(_, m)| m.amax() > 0.0)
            .collect();
        (symmetric_part(&expression.constant), coefficients)
    }
}

/// Returns the pairs `i <= j` (or `i < j` with `gap` 1) of channels with the same parameter.
fn pairs(channels: &[usize], gap: usize) -> impl Iterator<Item = (usize, usize)> + '_ {
    (0..channels.len())
        .flat_map(move |i| (i + gap..channels.len()).map(move |j| (i, j)))
        .filter(|&(i, j)| channels[i] == channels[j])
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dmatrix;

    #[test]
    fn coefficients_agree_with_the_value() {
        let mut p = Program::default();
        let x = p.symmetric(3);
        let t = p.skew_commuting(&[0, 0, 1]);
        let f = p.full(3, 2);
        let a = dmatrix![1.0, 2.0, 3.0; -1.0, 0.5, 2.0; 0.0, 1.0, 7.0];
        let b = dmatrix![1.0, 0.0, 2.0; 0.0, -1.0, 1.0];
        let e = symmetric(&[
            vec![x.after(&a.transpose()) + x.times(&a), t.times(&a) + f.times(&b)],
            vec![Affine::constant(Mat::identity(3, 3) * 2.0) - x.clone()],
        ]);
        assert_eq!(p.unknowns(), 6 + 1 + 6);
        let x: Vec<f64> = (0..p.unknowns()).map(|k| (k as f64 + 1.0).sin()).collect();
        let (mut sum, parts) = p.coefficients(&e);
        for (k, m) in parts {
            sum += m * x[k];
        }
        assert!((sum - e.value(&p, &x)).amax() < 1e-12);
    }

    #[test]
    fn trace_objective_counts_each_entry() {
        let mut p = Program::default();
        let x = p.symmetric(2);
        let a = dmatrix![1.0, 2.0; 3.0, 4.0];
        let e = x.after(&a);
        p.minimise_trace(&e, 2.0);
        let at = [5.0, 6.0, 7.0];
        let found: f64 = p.objective.iter().map(|&(k, c)| c * at[k]).sum();
        assert!((found - 2.0 * e.value(&p, &at).trace()).abs() < 1e-12);
    }
}
