//! Assembly of a plant from signals: linear functions of its states and inputs.

use crate::matrix::Mat;
use crate::system::{ReferenceModel, ReferenceWeight, RisingWeight};

/// A linear function of `[x; wt; w; u]`, one row per component.
pub(super) type Signal = Mat;

/// A plant under assembly: `[x; wt; w; u]` as signals, and x', filled in as it becomes known.
pub(super) struct Assembly {
    /// The identity; its rows are the signals x, wt, w and u.
    identity: Mat,
    pub derivatives: Mat,
    states: usize,
}

impl Assembly {
    pub fn new(states: usize, others: usize) -> Self {
        let total = states + others;
        Self { identity: Mat::identity(total, total), derivatives: Mat::zeros(states, total), states: 0 }
    }

    /// Adds `count` states; returns the index of the first and their signal.
    pub fn state(&mut self, count: usize) -> (usize, Signal) {
        let first = self.states;
        self.states += count;
        (first, self.signal(first, count))
    }

    pub fn signal(&self, first: usize, count: usize) -> Signal {
        self.identity.rows(first, count).into_owned()
    }

    pub fn derivative(&mut self, first: usize, rate: &Signal) {
        self.derivatives.rows_mut(first, rate.nrows()).copy_from(rate);
    }

    /// Returns `W(s)` of a scalar signal; W has one state: `x' = pole x + gain s, W s = sign gain x + direct s`.
    fn filtered(&mut self, [pole, gain, direct]: [f64; 3], sign: f64, input: &Signal) -> Signal {
        let (at, x) = self.state(1);
        self.derivative(at, &(&x * pole + input * gain));
        x * (sign * gain) + input * direct
    }

    /// Returns the output of a reference model T_ref.
    pub fn follow(&mut self, model: &ReferenceModel, reference: &Signal) -> Signal {
        let w = model.frequency;
        let (at, value) = self.state(1);
        match model.damping {
            None => self.derivative(at, &((reference - &value) * w)),
            Some(damping) => {
                let (next, rate) = self.state(1);
                self.derivative(at, &(&rate * w));
                self.derivative(next, &((reference - &value - &rate * (2.0 * damping)) * w));
            }
        }
        value
    }

    /// Returns `R(s)` of a signal.
    pub fn slow_emphasis(&mut self, weight: &ReferenceWeight, input: &Signal) -> Signal {
        if weight.follow <= 1.0 {
            return input.clone();
        }
        let gain = ((weight.follow - 1.0) * weight.corner).sqrt();
        self.filtered([-weight.corner, gain, 1.0], 1.0, input)
    }

    /// Returns `W(s)` of a signal.
    pub fn weighted(&mut self, weight: &RisingWeight, input: &Signal) -> Signal {
        if !weight.rises() {
            return input * weight.low;
        }
        let gain = ((weight.high - weight.low) * weight.corner).sqrt();
        self.filtered([-weight.corner, gain, weight.high], -1.0, input)
    }
}
