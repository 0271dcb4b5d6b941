//! Inputs and outputs of an autopilot.

use signals::{Each, EachTracked, SIGNALS, tracked};

use crate::TickError;

/// Measurements and references of the autopilot; SI units, radians.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inputs {
    /// The measured value of each signal.
    pub measured: Each<f64>,
    /// The reference of each signal that can be tracked, absolute.
    pub references: EachTracked<f64>,
}

/// Outputs of the autopilot, held between ticks.
#[derive(Debug, Clone, PartialEq)]
pub struct Outputs {
    /// Commands, in the order of the design's actuators.
    pub commands: Vec<f64>,
    /// The scheduling parameter rho in [-1, 1].
    pub scheduling_parameter: f64,
    /// The measured speed is outside the scheduled range, and rho was clamped.
    pub out_of_range: bool,
    /// Trim pitch at the speed V_r in rad.
    pub trim_pitch: f64,
}

impl Inputs {
    /// Rejects inputs that are not finite.
    pub(crate) fn check(&self) -> Result<(), TickError> {
        let measured = SIGNALS.iter().map(|signal| signal.name).zip(self.measured);
        let references = tracked().map(|(_, reference)| reference.name).zip(self.references);
        for (name, value) in measured.chain(references) {
            if !value.is_finite() {
                return Err(TickError::InputNotFinite { name, value });
            }
        }
        Ok(())
    }
}
