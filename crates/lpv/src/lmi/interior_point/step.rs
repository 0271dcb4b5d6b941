//! One step: predictor, corrector and step length. Inequalities are treated in parallel.

use super::{Cone, State};
use crate::matrix::{Definite, Mat, quick_least_eigenvalue, symmetric_part};
use rayon::prelude::*;

/// The least number of rows of a large inequality.
const LARGE: usize = 32;

/// The matrices of a cone that are constant within a step.
struct Factors {
    x_root: Mat,
    z_root: Mat,
    z_inverse: Mat,
    /// `F(x) - Z`.
    residual: Mat,
}

/// A search direction in one cone.
struct Direction {
    x: Mat,
    z: Mat,
}

impl State<'_> {
    /// Makes a predictor-corrector step; returns the shorter of both step lengths, `None` if a factorisation fails.
    pub(super) fn advance(&mut self) -> Option<f64> {
        let factors: Vec<Factors> = self.each().map(|c| self.factors(c)).collect::<Option<_>>()?;
        let m = self.objective.len();
        let mut schur = Mat::zeros(m, m);
        for (cone, f) in self.cones.iter().zip(&factors) {
            cone.data.add_schur_complement(
                &cone.data.projected(&cone.x),
                &cone.data.projected(&f.z_inverse),
                &mut schur,
            );
        }
        let schur = Definite::new(schur)?;
        let mu = self.mu();
        let (_, predicted) = self.direction(&factors, &schur, 0.0, None);
        let (reach_x, reach_z) = self.reach(&factors, &predicted);
        let (full_x, full_z) = (reach_x.min(1.0), reach_z.min(1.0));
        let ahead: f64 = self
            .cones
            .iter()
            .zip(&predicted)
            .map(|(c, d)| (&c.x + &d.x * full_x).dot(&(&c.z + &d.z * full_z)))
            .sum::<f64>()
            / self.rows();
        let shorter = full_x.min(full_z);
        let exponent = (3.0 * shorter * shorter).max(1.0);
        let sigma = (ahead / mu).max(0.0).powf(exponent).clamp(1e-6, 1.0);
        let (dx, direction) = self.direction(&factors, &schur, sigma * mu, Some(&predicted));
        let (reach_x, reach_z) = self.reach(&factors, &direction);
        let kept = 0.9 + 0.09 * shorter;
        let (step_x, step_z) = ((kept * reach_x).min(1.0), (kept * reach_z).min(1.0));
        if !(step_x.is_finite() && step_z.is_finite() && dx.iter().all(|v| v.is_finite())) {
            return None;
        }
        self.go(&dx, &direction, step_x, step_z);
        Some(step_x.min(step_z))
    }

    /// Returns the inequalities, in parallel if one is large: waking a thread takes longer than the step of a small
    /// one.
    fn each(&self) -> impl IndexedParallelIterator<Item = &Cone<'_>> {
        let is_large = self.cones.iter().any(|cone| cone.data.size() >= LARGE);
        self.cones.par_iter().with_min_len(if is_large { 1 } else { self.cones.len() })
    }

    fn factors(&self, cone: &Cone<'_>) -> Option<Factors> {
        let z_root = cone.z.clone().cholesky()?.unpack();
        let x_root = cone.x.clone().cholesky()?.unpack();
        let inverse = z_root.solve_lower_triangular(&Mat::identity(z_root.nrows(), z_root.nrows()))?;
        let n = cone.data.size();
        let residual = if self.feasible {
            Mat::zeros(n, n)
        } else {
            cone.data.constant() + cone.data.linear(&self.x) - &cone.z
        };
        Some(Factors {
            x_root,
            z_root,
            z_inverse: symmetric_part(&(inverse.transpose() * inverse)),
            residual,
        })
    }

    /// Returns the direction towards `X Z = mu I`, corrected by the product of the steps of `predicted`.
    fn direction(
        &self,
        factors: &[Factors],
        schur: &Definite,
        mu: f64,
        predicted: Option<&[Direction]>,
    ) -> (Vec<f64>, Vec<Direction>) {
        let mut rhs: Vec<f64> = self.objective.iter().map(|c| -c).collect();
        let centre = |(k, (cone, f)): (usize, (&Cone<'_>, &Factors))| {
            let mut pushed = &cone.x * &f.residual;
            if let Some(predicted) = predicted {
                pushed += &predicted[k].x * &predicted[k].z;
            }
            &f.z_inverse * mu - symmetric_part(&(pushed * &f.z_inverse))
        };
        let centres: Vec<Mat> = self.each().zip(factors).enumerate().map(centre).collect();
        for (cone, centre) in self.cones.iter().zip(&centres) {
            cone.data.add_inner_products(centre, 1.0, &mut rhs);
        }
        let dx = schur.solve(&rhs);
        let direction = |((cone, f), centre): ((&Cone<'_>, &Factors), Mat)| {
            let moved = cone.data.linear(&dx);
            let x = centre - &cone.x - symmetric_part(&(&cone.x * &moved * &f.z_inverse));
            Direction { x, z: moved + &f.residual }
        };
        let directions = self.each().zip(factors).zip(centres).map(direction).collect();
        (dx, directions)
    }

    /// Returns the step lengths up to which X and Z stay positive along a direction.
    fn reach(&self, factors: &[Factors], direction: &[Direction]) -> (f64, f64) {
        let along = |root: &Mat, d: &Mat| -> f64 {
            let Some(half) = root.solve_lower_triangular(d) else { return 0.0 };
            let Some(scaled) = root.solve_lower_triangular(&half.transpose()) else { return 0.0 };
            let least = quick_least_eigenvalue(symmetric_part(&scaled));
            if least.is_nan() {
                0.0
            } else if least < 0.0 {
                -1.0 / least
            } else {
                f64::INFINITY
            }
        };
        let both = self
            .each()
            .zip(factors)
            .zip(direction)
            .map(|((_, f), d)| (along(&f.x_root, &d.x), along(&f.z_root, &d.z)));
        both.reduce(|| (f64::INFINITY, f64::INFINITY), |one, other| (one.0.min(other.0), one.1.min(other.1)))
    }

    fn go(&mut self, dx: &[f64], direction: &[Direction], step_x: f64, step_z: f64) {
        for (x, d) in self.x.iter_mut().zip(dx) {
            *x += step_z * d;
        }
        for (cone, d) in self.cones.iter_mut().zip(direction) {
            cone.x += &d.x * step_x;
            cone.z += &d.z * step_z;
        }
        // Once the inequalities hold at x, with a margin over the residual of the slacks, their values replace the
        // slacks: this removes accumulated rounding.
        let values: Vec<Mat> = self.each().map(|c| c.data.constant() + c.data.linear(&self.x)).collect();
        let share = if self.feasible || step_z == 1.0 { 0.0 } else { 0.5 };
        let clear = |(c, v): (&Cone<'_>, &Mat)| (v - &c.z * share).cholesky().is_some();
        if self.cones.iter().zip(&values).all(clear) {
            self.feasible = true;
            for (cone, value) in self.cones.iter_mut().zip(values) {
                cone.z = value;
            }
        }
    }
}
