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

    /// Turns `Ct xk + Dty y` in `channels` into wk.
    fn close_loop(&mut self, theta: &[f64]) -> Result<(), TickError> {
        let lft = &*self.lft;
        debug_assert_eq!(theta.len(), lft.blocks.len());
        let r = self.channels.len();
        for row in 0..r {
            for (column, (entry, theta)) in
                lft.dtt.row(row).iter().zip(expand(&lft.blocks, theta)).enumerate()
            {
                let unit = if row == column { 1.0 } else { 0.0 };
                self.loop_matrix[row * r + column] = unit - entry * theta;
            }
        }
        solve_in_place(&mut self.loop_matrix, &mut self.channels).map_err(|pivot| {
            TickError::SingularLoop { parameter: theta.first().copied().unwrap_or(0.0), pivot }
        })?;
        for (channel, theta) in self.channels.iter_mut().zip(expand(&lft.blocks, theta)) {
            *channel *= theta;
        }
        Ok(())
    }
}

/// The diagonal of Theta.
fn expand<'a>(blocks: &'a [usize], theta: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
    blocks.iter().zip(theta).flat_map(|(&repetitions, &theta)| std::iter::repeat_n(theta, repetitions))
}
