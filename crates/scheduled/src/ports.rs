//! What goes into an autopilot, and what comes out.

use signals::{Each, SIGNALS};

use crate::TickError;

/// What the autopilot measures and follows; SI units, radians.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inputs {
    /// What each signal measures.
    pub measured: Each<f64>,
    /// What each signal is to follow, absolute.
    pub references: Each<f64>,
}

/// What the autopilot puts out; held between ticks.
#[derive(Debug, Clone, PartialEq)]
pub struct Outputs {
    /// Commands, in the order of the design's actuators.
    pub commands: Vec<f64>,
    /// The scheduling parameter rho in [-1, 1].
    pub scheduling_parameter: f64,
    /// The measured speed lies outside the scheduled range, and rho was clamped.
    pub out_of_range: bool,
    /// Trim pitch at the reference speed in rad.
    pub trim_pitch: f64,
}

impl Inputs {
    /// Refuses what is not finite.
    pub(crate) fn check(&self) -> Result<(), TickError> {
        let measured = SIGNALS.iter().map(|signal| signal.name).zip(self.measured);
        let references = SIGNALS.iter().map(|signal| signal.reference).zip(self.references);
        for (name, value) in measured.chain(references) {
            if !value.is_finite() {
                return Err(TickError::InputNotFinite { name, value });
            }
        }
        Ok(())
    }
}
