//! One tick of a discrete LFT controller, without allocation.

use std::sync::Arc;

use crate::lu::solve_in_place;
use crate::{Lft, TickError};

/// A discrete LFT with its state and workspace.
#[derive(Debug, Clone)]
pub struct LftController {
    lft: Arc<Lft>,
    state: Vec<f64>,
    next_state: Vec<f64>,
    /// Theta's inputs zk, turned into its outputs wk.
    channels: Vec<f64>,
    /// The diagonal of Theta.
    diagonal: Vec<f64>,
    /// `I - Dtt Theta`, row by row.
    loop_matrix: Vec<f64>,
}

impl LftController {
    /// A controller at rest; `lft` is in discrete time.
    pub fn new(lft: Lft) -> Self {
        let sizes = lft.sizes();
        Self {
            lft: Arc::new(lft),
            state: vec![0.0; sizes.states],
            next_state: vec![0.0; sizes.states],
            channels: vec![0.0; sizes.channels],
            diagonal: vec![0.0; sizes.channels],
            loop_matrix: vec![0.0; sizes.channels * sizes.channels],
        }
    }

    /// Brings the controller to rest.
    pub fn reset(&mut self) {
        self.state.fill(0.0);
    }

    /// The state xk.
    pub fn state(&self) -> &[f64] {
        &self.state
    }

    /// Sets the state xk, which has as many entries as before.
    pub(crate) fn set_state(&mut self, state: &[f64]) {
        self.state.copy_from_slice(state);
    }

    /// Computes `u` from the present state and `y`; the state stays.
    ///
    /// ```text
    /// (I - Dtt Theta) zk = Ct xk + Dty y,   wk = Theta zk,   u = Cu xk + Duy y + Dut wk
    /// ```
    ///
    /// Shapes: `y` p, `theta` one value a block, `u` m.
    ///
    /// # Errors
    /// [`TickError::SingularLoop`].
    pub fn output(&mut self, y: &[f64], theta: &[f64], u: &mut [f64]) -> Result<(), TickError> {
        let lft = &*self.lft;
        self.channels.fill(0.0);
        lft.ct.add_product(&self.state, &mut self.channels);
        lft.dty.add_product(y, &mut self.channels);
        self.close_loop(theta)?;
        u.fill(0.0);
        self.lft.cu.add_product(&self.state, u);
        self.lft.duy.add_product(y, u);
        self.lft.dut.add_product(&self.channels, u);
        Ok(())
    }

    /// Moves the state to the next tick: `xk+ = A xk + By y + Bt wk`, with wk of the last [`output`](Self::output).
    pub fn update(&mut self, y: &[f64]) {
        let lft = &*self.lft;
        self.next_state.fill(0.0);
        lft.a.add_product(&self.state, &mut self.next_state);
        lft.by.add_product(y, &mut self.next_state);
        lft.bt.add_product(&self.channels, &mut self.next_state);
        std::mem::swap(&mut self.state, &mut self.next_state);
    }

    /// Computes the derivative of `u` in one direction, `du` along `dy` and `dtheta`, the state held; nothing changes.
    ///
    /// ```text
    /// (I - Dtt Theta) zk  = Ct xk + Dty y
    /// (I - Dtt Theta) dzk = Dty dy + Dtt dTheta zk,   dwk = dTheta zk + Theta dzk,   du = Duy dy + Dut dwk
    /// ```
    ///
    /// Shapes: `y` and `dy` p, `theta` and `dtheta` one value a block, `du` m.
    ///
    /// # Errors
    /// [`TickError::SingularLoop`].
    pub fn tangent(
        &self,
        (y, dy): (&[f64], &[f64]),
        (theta, dtheta): (&[f64], &[f64]),
        du: &mut [f64],
    ) -> Result<(), TickError> {
        let lft = &*self.lft;
        let mut z = vec![0.0; self.channels.len()];
        lft.ct.add_product(&self.state, &mut z);
        lft.dty.add_product(y, &mut z);
        self.solve_loop(theta, &mut z)?;
        let moved: Vec<f64> =
            z.iter().zip(expand(&lft.blocks, dtheta)).map(|(z, dtheta)| z * dtheta).collect();
        let mut dz = vec![0.0; z.len()];
        lft.dty.add_product(dy, &mut dz);
        lft.dtt.add_product(&moved, &mut dz);
        self.solve_loop(theta, &mut dz)?;
        let through = dz.iter().zip(expand(&lft.blocks, theta)).zip(&moved);
        let dw: Vec<f64> = through.map(|((dz, theta), moved)| moved + theta * dz).collect();
        du.fill(0.0);
        lft.duy.add_product(dy, du);
        lft.dut.add_product(&dw, du);
        Ok(())
    }

    /// Computes what [`output`](Self::output) would; nothing changes.
    ///
    /// # Errors
    /// [`TickError::SingularLoop`].
    pub(crate) fn peek(&self, y: &[f64], theta: &[f64], u: &mut [f64]) -> Result<(), TickError> {
        self.clone().output(y, theta, u)
    }

    /// Replaces `b` by the solution of `(I - Dtt Theta) z = b`.
    fn solve_loop(&self, theta: &[f64], b: &mut [f64]) -> Result<(), TickError> {
        let mut matrix = vec![0.0; b.len() * b.len()];
        let diagonal: Vec<f64> = expand(&self.lft.blocks, theta).collect();
        fill_loop(&self.lft, &diagonal, &mut matrix);
        solve_in_place(&mut matrix, b).map_err(|pivot| singular(theta, pivot))
    }

    /// Turns `Ct xk + Dty y` in `channels` into wk.
    fn close_loop(&mut self, theta: &[f64]) -> Result<(), TickError> {
        for (entry, theta) in self.diagonal.iter_mut().zip(expand(&self.lft.blocks, theta)) {
            *entry = theta;
        }
        fill_loop(&self.lft, &self.diagonal, &mut self.loop_matrix);
        solve_in_place(&mut self.loop_matrix, &mut self.channels).map_err(|pivot| singular(theta, pivot))?;
        for (channel, theta) in self.channels.iter_mut().zip(&self.diagonal) {
            *channel *= theta;
        }
        Ok(())
    }
}

/// Fills in `I - Dtt Theta`, row by row.
fn fill_loop(lft: &Lft, diagonal: &[f64], matrix: &mut [f64]) {
    let r = lft.dtt.rows();
    for (index, row) in matrix.chunks_exact_mut(r.max(1)).enumerate() {
        for ((to, entry), theta) in row.iter_mut().zip(lft.dtt.row(index)).zip(diagonal) {
            *to = -entry * theta;
        }
        row[index] += 1.0;
    }
}

fn singular(theta: &[f64], pivot: f64) -> TickError {
    TickError::SingularLoop { parameter: theta.first().copied().unwrap_or(0.0), pivot }
}

/// The diagonal of Theta.
fn expand<'a>(blocks: &'a [usize], theta: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
    blocks.iter().zip(theta).flat_map(|(&repetitions, &theta)| std::iter::repeat_n(theta, repetitions))
}
