//! Errors of the certification of a vehicle and its design.

use strum::IntoStaticStr;
use thiserror::Error;

/// Error of the certification of a vehicle and its design, other than a failed proof.
#[derive(Debug, Error, IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum CertifyError {
    /// The certificate claims less than the design.
    #[error(
        "the design is marked as certified for the vehicle, but its certificate covers no model error: the proof \
            applies to the fitted model only, not to the true linearisations"
    )]
    NoResidual,
    /// The controller has a mode at 2/T, where the trapezoidal rule has no solution.
    #[error(
        "the controller has a mode at 2/T rad/s, where T is the sample time, and cannot be discretised; choose \
             another sample_time in [autopilot]"
    )]
    ModeAtTwiceTheRate,
    /// An actuator has a rate limit, but the plant of the design has no state for it.
    #[error(
        "the rate limit of {actuator} acts on its lag, which the plant of this design does not include; set 'lags = \
            true' in [control]"
    )]
    RateWithoutLag { actuator: String },
    /// The fit's residual is too large for a bound because drag is quadratic in both directions.
    #[error(
        "no gain is proved for the ball of models around the fit: the speed range {from} to {to} m/s includes rest, \
            where the slope of the drag has a kink that no polynomial in speed fits; make two designs, one astern \
            with speed_max = 0 and one ahead with speed_min = 0"
    )]
    BendsAtRest { from: f64, to: f64 },
}
