//! The gain with which an autopilot follows other commands.

use crate::{ControllerDesign, DesignError, Matrix};

/// The gain F over rho.
#[derive(Debug)]
pub(crate) struct Following {
    /// F at values of rho from -1 to 1, evenly spaced, each n x m; none of a controller that cannot follow.
    gains: Vec<Matrix>,
}

impl Following {
    #[inline]
    pub(crate) fn new(design: &ControllerDesign) -> Result<Self, DesignError> {
        Ok(Self { gains: design.follow_gains()? })
    }

    /// F at values of rho from -1 to 1.
    pub(crate) fn gains(&self) -> &[Matrix] {
        &self.gains
    }

    /// `x - F(rho) error`; F is linear between its values.
    pub(crate) fn correct(&self, rho: f64, error: &[f64], state: &mut [f64]) {
        let Some(last) = self.gains.len().checked_sub(2) else {
            for gain in &self.gains {
                add(state, |i, j| gain.row(i)[j], error);
            }
            return;
        };
        let place = 0.5 * (rho + 1.0) * (last + 1) as f64;
        let index = (place as usize).min(last);
        let part = place - index as f64;
        let (low, high) = (&self.gains[index], &self.gains[index + 1]);
        add(state, |i, j| (1.0 - part) * low.row(i)[j] + part * high.row(i)[j], error);
    }
}

/// `x - F error`.
fn add(state: &mut [f64], gain: impl Fn(usize, usize) -> f64, error: &[f64]) {
    for (i, x) in state.iter_mut().enumerate() {
        *x -= error.iter().enumerate().map(|(j, error)| gain(i, j) * error).sum::<f64>();
    }
}
