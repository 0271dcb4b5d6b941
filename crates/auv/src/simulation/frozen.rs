//! LPV model frozen at one speed, in a workspace allocated once.

use crate::simulation::lpv_model::LpvModel;

/// A, B and trim at one operating speed.
#[derive(Clone, Debug)]
pub(crate) struct Frozen {
    a: [[f64; 4]; 4],
    b: Vec<[f64; 4]>,
    state: [f64; 4],
    actuators: Vec<f64>,
}

impl Frozen {
    /// Returns the workspace for a number of actuators.
    pub(crate) fn new(inputs: usize) -> Self {
        Self { a: [[0.0; 4]; 4], b: vec![[0.0; 4]; inputs], state: [0.0; 4], actuators: vec![0.0; inputs] }
    }

    /// Evaluates the model at a speed.
    pub(crate) fn evaluate(&mut self, model: &LpvModel, speed: f64) {
        let rho = model.rho(speed);
        let at = |terms: &[Vec<Vec<f64>>], i: usize, j: usize| {
            terms.iter().rev().fold(0.0, |sum, term| sum * rho + term[i][j])
        };
        for i in 0..4 {
            for j in 0..4 {
                self.a[i][j] = at(&model.a, i, j);
            }
            for (j, column) in self.b.iter_mut().enumerate() {
                column[i] = at(&model.b, i, j);
            }
        }
        let (below, above, weight) = model.bracket(speed);
        let between = |from: f64, to: f64| from + weight * (to - from);
        self.state = [
            between(below.forward_speed, above.forward_speed),
            between(below.heave, above.heave),
            0.0,
            between(below.pitch, above.pitch),
        ];
        for (output, (from, to)) in
            self.actuators.iter_mut().zip(below.actuators.iter().zip(&above.actuators))
        {
            *output = between(*from, *to);
        }
    }

    /// Returns `A (x - x_trim) + B (T - T_trim)`.
    pub(crate) fn derivative(&self, x: [f64; 4], outputs: impl Iterator<Item = f64>) -> [f64; 4] {
        let mut derivative = [0.0; 4];
        for (i, row) in self.a.iter().enumerate() {
            derivative[i] = row.iter().zip(x).zip(self.state).map(|((a, x), trim)| a * (x - trim)).sum();
        }
        for ((column, output), trim) in self.b.iter().zip(outputs).zip(&self.actuators) {
            for (i, b) in column.iter().enumerate() {
                derivative[i] += b * (output - trim);
            }
        }
        derivative
    }
}
