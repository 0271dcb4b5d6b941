//! Gain with which an autopilot follows the commands of another source.

use crate::{ControllerDesign, DesignError, Matrix};

/// Gain F over rho.
#[derive(Debug)]
pub(crate) struct Following {
    /// F at values of rho from -1 to 1, evenly spaced, each n x m; empty for a controller that cannot follow.
    gains: Vec<Matrix>,
}

impl Following {
    #[inline]
    pub(crate) fn new(design: &ControllerDesign) -> Result<Self, DesignError> {
        Ok(Self { gains: design.follow_gains()? })
    }

    /// Returns F at values of rho from -1 to 1.
    pub(crate) fn gains(&self) -> &[Matrix] {
        &self.gains
    }

    /// Replaces the state x by `x - F(rho) error`; F is interpolated linearly.
    pub(crate) fn correct(&self, rho: f64, error: &[f64], state: &mut [f64]) {
        let Some(last) = self.gains.len().checked_sub(2) else {
            for gain in &self.gains {
                subtract(state, |i, j| gain.row(i)[j], error);
            }
            return;
        };
        let position = 0.5 * (rho + 1.0) * (last + 1) as f64;
        let index = (position as usize).min(last);
        let fraction = position - index as f64;
        let (low, high) = (&self.gains[index], &self.gains[index + 1]);
        subtract(state, |i, j| (1.0 - fraction) * low.row(i)[j] + fraction * high.row(i)[j], error);
    }
}

/// Replaces the state x by `x - F error`.
fn subtract(state: &mut [f64], gain: impl Fn(usize, usize) -> f64, error: &[f64]) {
    for (i, x) in state.iter_mut().enumerate() {
        *x -= error.iter().enumerate().map(|(j, error)| gain(i, j) * error).sum::<f64>();
    }
}
