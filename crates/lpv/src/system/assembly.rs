//! A plant that is being put together, of signals: linear functions of its states and inputs.

use crate::matrix::Mat;
use crate::system::weights::{ReferenceModel, ReferenceWeight, RisingWeight};

/// A linear function of `[x; wt; w; u]`, a row each.
pub(super) type Signal = Mat;

/// The states of a plant that is being put together: `[x; wt; w; u]` as signals, and x' as it becomes known.
pub(super) struct Assembly {
    /// The identity, by whose rows a signal is made.
    identity: Mat,
    pub derivatives: Mat,
    states: usize,
}

impl Assembly {
    pub fn new(states: usize, others: usize) -> Self {
        let total = states + others;
        Self { identity: Mat::identity(total, total), derivatives: Mat::zeros(states, total), states: 0 }
    }

    /// The next `count` states.
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

    /// `W(s)` of a signal of one row, for weights with one state: `x' = pole x + gain s, W s = sign gain x + direct s`.
    fn filtered(&mut self, [pole, gain, direct]: [f64; 3], sign: f64, input: &Signal) -> Signal {
        let (at, x) = self.state(1);
        self.derivative(at, &(&x * pole + input * gain));
        x * (sign * gain) + input * direct
    }

    /// T_ref of a reference.
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

    /// `R(s)` of a signal.
    pub fn slow_more(&mut self, weight: &ReferenceWeight, input: &Signal) -> Signal {
        match weight.follow > 1.0 {
            false => input.clone(),
            true => {
                let gain = ((weight.follow - 1.0) * weight.corner).sqrt();
                self.filtered([-weight.corner, gain, 1.0], 1.0, input)
            }
        }
    }

    /// `W(s)` of a signal.
    pub fn weighted(&mut self, weight: &RisingWeight, input: &Signal) -> Signal {
        match weight.rises() {
            false => input * weight.low,
            true => {
                let gain = ((weight.high - weight.low) * weight.corner).sqrt();
                self.filtered([-weight.corner, gain, weight.high], -1.0, input)
            }
        }
    }
}
