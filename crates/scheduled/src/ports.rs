//! Inputs and outputs of an autopilot.

use crate::TickError;
use crate::design::{Port, Reference};

/// Measurements and references of the autopilot; SI units, radians.
#[derive(Debug, Clone, PartialEq)]
pub struct Inputs {
    /// Measured value of each signal of the design; those that it does not measure have no effect.
    pub measured: Vec<f64>,
    /// Reference of each signal that can be tracked, absolute.
    pub references: Vec<f64>,
}

/// Outputs of the autopilot, held between ticks.
#[derive(Debug, Clone, PartialEq)]
pub struct Outputs {
    /// Commands, in the order of the design's actuators.
    pub commands: Vec<f64>,
    /// Scheduling parameter rho in [-1, 1].
    pub scheduling_parameter: f64,
    /// `true` if the measured speed is outside the scheduled range and rho was clamped.
    pub out_of_range: bool,
    /// `true` if a reference differs from the requested one: it is limited by the envelope, moves towards the measured
    /// value, or is returning to the request.
    pub reference_limited: bool,
    /// Trim of each signal of [`ControllerDesign::trimmed`](crate::ControllerDesign::trimmed) at the speed V_r.
    pub trim: Vec<f64>,
}

impl Port {
    /// Rejects a value outside the range allowed at the first tick.
    pub(crate) fn check_first(&self, value: f64, reference: Option<&Reference>) -> Result<(), TickError> {
        let Some([least, most]) = self.first(reference.is_some()) else { return Ok(()) };
        if (least..=most).contains(&value) {
            return Ok(());
        }
        let unit = &self.unit;
        let hint = match unit.strip_prefix("rad") {
            Some(rest) => format!(" ({value} deg{rest} is {} {unit})", value.to_radians()),
            None => String::new(),
        };
        let (name, meaning) = reference
            .map_or((&self.name, &self.measured), |reference| (&reference.name, &reference.description));
        let allowed = format!("from {least} to {most} {unit}: {meaning}{hint}");
        Err(TickError::OtherUnit { name: name.clone(), found: format!("{value} {unit}"), allowed })
    }
}

impl Inputs {
    /// Rejects inputs that are not finite.
    pub(crate) fn check(&self, signals: &[Port]) -> Result<(), TickError> {
        for (signal, value) in signals.iter().zip(&self.measured) {
            finite(&signal.name, *value)?;
        }
        for (reference, value) in
            signals.iter().filter_map(|signal| signal.reference.as_ref()).zip(&self.references)
        {
            finite(&reference.name, *value)?;
        }
        Ok(())
    }
}

fn finite(name: &str, value: f64) -> Result<(), TickError> {
    if value.is_finite() { Ok(()) } else { Err(TickError::InputNotFinite { name: name.to_owned(), value }) }
}
