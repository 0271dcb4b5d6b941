//! The step of sequential quadratic programming for a maximum of smooth functions.

use crate::matrix::Mat;
use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettingsBuilder, DefaultSolver, IPSolver, SolverStatus, SupportedConeT::NonnegativeConeT,
};
use nalgebra::DVector;

/// A linear function `value + slope'd` of the step.
pub(crate) struct Line {
    pub(crate) value: f64,
    pub(crate) slope: DVector<f64>,
}

/// The step and the multipliers of the lines.
pub(crate) struct Step {
    pub(crate) step: DVector<f64>,
    /// The multiplier of each line of the objective; their sum is 1.
    pub(crate) multipliers: Vec<f64>,
}

/// Returns the d that minimises `max_j (v_j + a_j'd) + d'H d/2` with `v_k + a_k'd <= 0` for every limit and
/// `|d_i| <= radius`.
///
/// Shapes: H n x n, positive definite; each slope n. `None` if the solver fails.
pub(crate) fn minimax_step(objective: &[Line], limits: &[Line], hessian: &Mat, radius: f64) -> Option<Step> {
    let n = hessian.nrows();
    let (lines, bounds) = (objective.len(), limits.len());
    let rows = lines + bounds + 2 * n;
    let best = objective.iter().map(|line| line.value).fold(f64::NEG_INFINITY, f64::max);
    let mut dense = Mat::zeros(rows, n + 1);
    let mut rhs = vec![radius; rows];
    for (j, line) in objective.iter().chain(limits).enumerate() {
        dense.view_mut((j, 0), (1, n)).copy_from(&line.slope.transpose());
        rhs[j] = -line.value;
        if j < lines {
            dense[(j, n)] = -1.0;
            rhs[j] += best;
        }
    }
    for i in 0..n {
        dense[(lines + bounds + i, i)] = 1.0;
        dense[(lines + bounds + n + i, i)] = -1.0;
    }
    let mut curvature = hessian.clone().resize(n + 1, n + 1, 0.0);
    curvature.fill_lower_triangle(0.0, 1);
    let mut costs = vec![0.0; n + 1];
    costs[n] = 1.0;
    let settings = DefaultSettingsBuilder::default().verbose(false).max_threads(1).build().ok()?;
    let cones = [NonnegativeConeT(rows)];
    let mut solver =
        DefaultSolver::new(&sparse(&curvature), &costs, &sparse(&dense), &rhs, &cones, settings).ok()?;
    solver.solve();
    let found = &solver.solution;
    let usable = matches!(found.status, SolverStatus::Solved | SolverStatus::AlmostSolved)
        && found.x.iter().chain(&found.z).all(|v| v.is_finite());
    usable.then(|| Step {
        step: DVector::from_column_slice(&found.x[..n]),
        multipliers: found.z[..lines].to_vec(),
    })
}

fn sparse(m: &Mat) -> CscMatrix<f64> {
    let (mut starts, mut row_indices, mut values) = (vec![0], vec![], vec![]);
    for column in m.column_iter() {
        for (i, v) in column.iter().enumerate().filter(|(_, v)| **v != 0.0) {
            row_indices.push(i);
            values.push(*v);
        }
        starts.push(values.len());
    }
    CscMatrix::new(m.nrows(), m.ncols(), starts, row_indices, values)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dvector;

    /// max(d1, -d1, d2 - 1) + |d|^2/2 with d2 >= -0.5: both kinks and the limit are active.
    #[test]
    fn the_step_minimises_the_piecewise_quadratic_function() {
        let line = |value, slope| Line { value, slope };
        let objective =
            [line(1.0, dvector![1.0, 0.5]), line(1.0, dvector![-1.0, 0.5]), line(-5.0, dvector![0.0, 1.0])];
        let limits = [line(-0.2, dvector![0.0, -1.0])];
        let found = minimax_step(&objective, &limits, &Mat::identity(2, 2), 10.0).unwrap();
        assert!((found.step - dvector![0.0, -0.2]).amax() < 1e-6);
        assert!((found.multipliers[0] - 0.5).abs() < 1e-6 && (found.multipliers[1] - 0.5).abs() < 1e-6);
        let near = minimax_step(&objective, &[], &Mat::identity(2, 2), 0.1).unwrap();
        assert!((near.step - dvector![0.0, -0.1]).amax() < 1e-6);
    }
}
