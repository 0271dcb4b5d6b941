//! Discrete LFT controller; a tick does not allocate.

use std::sync::Arc;

use crate::lft::lu::solve_in_place;
use crate::lft::panels::Panels;
use crate::lft::schur::solve_quasi_triangular;
use crate::{Lft, Matrix, TickError};

/// Constant part of a controller.
#[derive(Debug)]
struct Law {
    lft: Lft,
    /// `true` if `Dtt` is quasi-triangular and `Theta = theta I`.
    triangular: bool,
    /// `[Ct Dty]`.
    into_loop: Panels,
    /// `[Cu Duy Dut]`.
    output: Panels,
    /// `[A By Bt]`.
    update: Panels,
}

/// A discrete-time LFT with its state and workspace.
#[derive(Debug, Clone)]
pub struct LftController {
    law: Arc<Law>,
    /// `[xk; y; wk]`.
    signals: Vec<f64>,
    next_state: Vec<f64>,
    /// Inputs zk of Theta.
    channels: Vec<f64>,
    /// `I - Dtt Theta`, row by row.
    loop_matrix: Vec<f64>,
}

impl LftController {
    /// Creates a controller with zero state; `lft` is in discrete time.
    #[inline]
    pub fn new(lft: Lft) -> Self {
        let sizes = lft.sizes();
        let (lft, triangular) = match lft.in_schur_coordinates() {
            Some(lft) => (lft, true),
            None => (lft, false),
        };
        let law = Law {
            triangular,
            into_loop: Panels::concatenated(&[&lft.ct, &lft.dty]),
            output: Panels::concatenated(&[&lft.cu, &lft.duy, &lft.dut]),
            update: Panels::concatenated(&[&lft.a, &lft.by, &lft.bt]),
            lft,
        };
        Self {
            law: Arc::new(law),
            signals: vec![0.0; sizes.states + sizes.inputs + sizes.channels],
            next_state: vec![0.0; sizes.states],
            channels: vec![0.0; sizes.channels],
            loop_matrix: vec![0.0; sizes.channels * sizes.channels],
        }
    }

    /// Returns the LFT in the channel coordinates of the ticks, in which `Dtt` is quasi-triangular if
    /// [`is_triangular`](Self::is_triangular).
    pub fn lft(&self) -> &Lft {
        &self.law.lft
    }

    /// Returns `true` if the loop through Theta is solved by back substitution, without pivoting.
    pub fn is_triangular(&self) -> bool {
        self.law.triangular
    }

    /// Sets the state to zero.
    pub fn reset(&mut self) {
        self.signals.fill(0.0);
    }

    /// Returns the state xk.
    pub fn state(&self) -> &[f64] {
        &self.signals[..self.next_state.len()]
    }

    pub(crate) fn state_mut(&mut self) -> &mut [f64] {
        &mut self.signals[..self.next_state.len()]
    }

    /// Sets the state xk; the length must be the same.
    pub(crate) fn set_state(&mut self, state: &[f64]) {
        self.signals[..state.len()].copy_from_slice(state);
    }

    /// Computes `u` from the state and `y`; the state does not change.
    ///
    /// ```text
    /// (I - Dtt Theta) zk = Ct xk + Dty y,   wk = Theta zk,   u = Cu xk + Duy y + Dut wk
    /// ```
    ///
    /// Shapes: `y` p, `theta` one value per block, `u` m.
    ///
    /// # Errors
    /// [`TickError::SingularLoop`].
    pub fn output(&mut self, y: &[f64], theta: &[f64], u: &mut [f64]) -> Result<(), TickError> {
        let (outer, through) = self.signals.split_at_mut(self.next_state.len() + y.len());
        outer[self.next_state.len()..].copy_from_slice(y);
        self.law.into_loop.product(outer, &mut self.channels);
        self.law.close_loop(theta, &mut self.loop_matrix, &mut self.channels)?;
        let channels = through.iter_mut().zip(&self.channels);
        for ((w, z), theta) in channels.zip(expand(&self.law.lft.blocks, theta)) {
            *w = theta * z;
        }
        self.law.output.product(&self.signals, u);
        Ok(())
    }

    /// Updates the state to the next tick: `xk+ = A xk + By y + Bt wk`, with y and wk of the last
    /// [`output`](Self::output).
    pub fn update(&mut self) {
        self.law.update.product(&self.signals, &mut self.next_state);
        self.signals[..self.next_state.len()].copy_from_slice(&self.next_state);
    }

    /// Adds `gain excess` to the state. Shapes: `gain` n x m, `excess` m.
    pub(crate) fn add_to_state(&mut self, gain: &Matrix, excess: &[f64]) {
        if excess.iter().any(|part| *part != 0.0) {
            gain.add_product(excess, &mut self.signals[..self.next_state.len()]);
        }
    }

    /// Computes the derivative `du` of `u` along `dy` and `dtheta` at a constant state. The controller does not change.
    ///
    /// ```text
    /// (I - Dtt Theta) zk  = Ct xk + Dty y
    /// (I - Dtt Theta) dzk = Dty dy + Dtt dTheta zk,   dwk = dTheta zk + Theta dzk,   du = Duy dy + Dut dwk
    /// ```
    ///
    /// Shapes: `y` and `dy` p, `theta` and `dtheta` one value per block, `du` m.
    ///
    /// # Errors
    /// [`TickError::SingularLoop`].
    #[inline]
    pub fn tangent(
        &self,
        y: &[f64],
        theta: &[f64],
        dy: &[f64],
        dtheta: &[f64],
        du: &mut [f64],
    ) -> Result<(), TickError> {
        let lft = &self.law.lft;
        let mut z = vec![0.0; self.channels.len()];
        lft.ct.add_product(self.state(), &mut z);
        lft.dty.add_product(y, &mut z);
        let mut workspace = self.loop_matrix.clone();
        self.law.close_loop(theta, &mut workspace, &mut z)?;
        let dtheta_z: Vec<f64> =
            z.iter().zip(expand(&lft.blocks, dtheta)).map(|(z, dtheta)| z * dtheta).collect();
        let mut dz = vec![0.0; z.len()];
        lft.dty.add_product(dy, &mut dz);
        lft.dtt.add_product(&dtheta_z, &mut dz);
        self.law.close_loop(theta, &mut workspace, &mut dz)?;
        let through = dz.iter().zip(expand(&lft.blocks, theta)).zip(&dtheta_z);
        let dw: Vec<f64> = through.map(|((dz, theta), dtheta_z)| dtheta_z + theta * dz).collect();
        du.fill(0.0);
        lft.duy.add_product(dy, du);
        lft.dut.add_product(&dw, du);
        Ok(())
    }
}

impl Law {
    /// Solves `(I - Dtt Theta) z = b`; `z` contains b on entry, the solution on return. `matrix` is workspace, r x r.
    fn close_loop(&self, theta: &[f64], matrix: &mut [f64], z: &mut [f64]) -> Result<(), TickError> {
        let solved = match (self.triangular, theta) {
            (true, [theta]) => solve_quasi_triangular(&self.lft.dtt, *theta, z),
            _ => {
                self.fill_loop(theta, matrix);
                solve_in_place(matrix, z)
            }
        };
        let parameter = theta.first().copied().unwrap_or(0.0);
        solved.map_err(|pivot| TickError::SingularLoop { parameter, pivot })
    }

    /// Computes `I - Dtt Theta`, row by row.
    fn fill_loop(&self, theta: &[f64], matrix: &mut [f64]) {
        let dtt = &self.lft.dtt;
        for (index, row) in matrix.chunks_exact_mut(dtt.rows().max(1)).enumerate() {
            let entries = row.iter_mut().zip(dtt.row(index));
            for ((to, entry), theta) in entries.zip(expand(&self.lft.blocks, theta)) {
                *to = -entry * theta;
            }
            row[index] += 1.0;
        }
    }
}

/// Returns the diagonal of Theta.
fn expand<'a>(blocks: &'a [usize], theta: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
    blocks.iter().zip(theta).flat_map(|(&repetitions, &theta)| std::iter::repeat_n(theta, repetitions))
}
