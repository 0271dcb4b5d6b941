//! The gain with which an autopilot follows other commands, and the way of its references after.

use crate::{ControllerDesign, DesignError, Matrix};

/// Time constant with which references go from where the vehicle is to what is asked, s.
const TRANSITION: f64 = 2.0;

/// A difference of this part of a signal's nominal size is none.
const NO_DIFFERENCE: f64 = 1e-4;

/// The gain F over rho, and how references come back to what is asked.
#[derive(Debug)]
pub(crate) struct Following {
    /// F at values of rho from -1 to 1, evenly spaced, each n x m; none of a controller that cannot follow.
    gains: Vec<Matrix>,
    /// Factor of the difference of each reference from what is asked, for a tick.
    decay: f64,
    /// The difference of each reference that is taken for none.
    negligible: Vec<f64>,
}

impl Following {
    #[inline]
    pub(crate) fn new(design: &ControllerDesign) -> Result<Self, DesignError> {
        Ok(Self {
            gains: design.follow_gains()?,
            decay: (-design.sample_time / TRANSITION).exp(),
            negligible: design.references().map(|(signal, _)| NO_DIFFERENCE * signal.nominal).collect(),
        })
    }

    /// F at values of rho from -1 to 1.
    pub(crate) fn gains(&self) -> &[Matrix] {
        &self.gains
    }

    /// Factor of the difference of a reference from what is asked for a tick, and the difference that is none.
    pub(crate) fn transition(&self, reference: usize) -> (f64, f64) {
        (self.decay, self.negligible[reference])
    }

    /// The difference of a reference from what is asked at the next tick.
    pub(crate) fn next(&self, reference: usize, difference: f64) -> f64 {
        let next = self.decay * difference;
        if next.abs() > self.negligible[reference] { next } else { 0.0 }
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
