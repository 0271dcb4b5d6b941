//! The bound of the optimum by the multipliers, and their correction for rounding.

use super::State;
use crate::matrix::{Definite, Mat, symmetric_part};

impl State<'_> {
    /// Returns a lower bound of the objective for any point no farther from zero than the current one:
    /// `c'x >= -tr(F_0 X) + r'x` with the residual r of the multipliers' equations.
    pub(super) fn bound(&self) -> f64 {
        let bound: f64 = self.cones.iter().map(|c| -c.x.dot(c.data.constant())).sum();
        let residual = self.residual();
        let norm = |v: &[f64]| v.iter().map(|v| v * v).sum::<f64>().sqrt();
        let rounding: f64 = self.cones.iter().map(|c| c.data.rounding(&c.x, &self.x)).sum();
        bound - norm(&residual) * norm(&self.x) - rounding
    }

    /// Returns the residual of the multipliers' equations, `c_i - tr(F_i X)`.
    fn residual(&self) -> Vec<f64> {
        let mut residual = self.objective.to_vec();
        for cone in &self.cones {
            cone.data.add_inner_products(&cone.x, -1.0, &mut residual);
        }
        residual
    }

    /// Replaces the multipliers by `X + X F(y) X` with the y for which they satisfy their equations, if that gives a
    /// better bound: rounding may have made the present ones useless. Returns the bound; `None` if they would not
    /// remain positive.
    pub(super) fn correct(&mut self) -> Option<f64> {
        let m = self.objective.len();
        let mut gram = Mat::zeros(m, m);
        for cone in &self.cones {
            let projected = cone.data.projected(&cone.x);
            cone.data.add_schur_complement(&projected, &projected, &mut gram);
        }
        let y = Definite::new(gram)?.solve(&self.residual());
        let corrected = self.cones.iter().map(|c| {
            let x = symmetric_part(&(&c.x + &c.x * c.data.linear(&y) * &c.x));
            x.clone().cholesky().map(|_| x)
        });
        let mut corrected = corrected.collect::<Option<Vec<_>>>()?;
        let before = self.bound();
        self.exchange(&mut corrected);
        let after = self.bound();
        if after < before {
            self.exchange(&mut corrected);
        }
        Some(after)
    }

    fn exchange(&mut self, multipliers: &mut [Mat]) {
        for (cone, x) in self.cones.iter_mut().zip(multipliers) {
            std::mem::swap(&mut cone.x, x);
        }
    }
}
