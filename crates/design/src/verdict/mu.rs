//! Structured singular value mu for robust stability at one speed.

use crate::error::{Error, UncertainError};
use crate::inputs::Inputs;
use crate::uncertain::closed_loop::uncertain_loop;
use crate::uncertain::frozen::at_speed;
use serde::Serialize;
use squid_lpv::controller::Controller;
use squid_lpv::mu::sweep::{FrequencyBound, bound_over_frequency};

/// Bound on mu of the frozen loop in continuous time, over all frequencies, for the declared uncertainty.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MuAtSpeed {
    /// Speed along the path, m/s.
    pub speed: f64,
    /// Upper bound on mu at every frequency; NaN if there is none.
    pub upper: f64,
    /// Frequency with the largest bound, rad/s.
    pub frequency: f64,
    /// Reason why there is no bound.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// `true` if any uncertainty is declared.
    #[serde(skip)]
    pub declared: bool,
    /// Bound with its scalings.
    #[serde(skip)]
    pub bound: Option<FrequencyBound>,
}

impl MuAtSpeed {
    pub(super) fn of(inputs: &Inputs, k: &Controller, speed: f64) -> Self {
        let none = |declared: bool, reason: String| Self {
            speed,
            upper: f64::NAN,
            frequency: f64::NAN,
            reason: Some(reason),
            declared,
            bound: None,
        };
        match bounded(inputs, k, speed) {
            Ok(bound) => Self {
                speed,
                upper: bound.upper,
                frequency: bound.frequency,
                reason: None,
                declared: true,
                bound: Some(bound),
            },
            Err(Error::Uncertain(UncertainError::NothingUncertain { .. })) => {
                none(false, "no uncertainty is declared".into())
            }
            Err(reason) => none(true, reason.to_string()),
        }
    }
}

/// Relative tolerance of the bounds: below their printed digits, in a third of the time of a tighter one.
const TOLERANCE: f64 = 5e-4;

fn bounded(inputs: &Inputs, k: &Controller, speed: f64) -> Result<FrequencyBound, Error> {
    let closed = uncertain_loop(inputs, &at_speed(inputs, speed)?, k)?;
    bound_over_frequency(&closed.stability(), &closed.structure, TOLERANCE)
        .map_err(|reason| Error::MuAtSpeed { speed, reason })
}
