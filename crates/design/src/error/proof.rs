//! Why a certificate does not prove what is claimed of a design.

use thiserror::Error;

/// Why a certificate does not prove what is claimed of a design.
#[derive(Debug, Error)]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum ProofError {
    /// A certificate does not prove its claim.
    #[error(transparent)]
    Unproved(#[from] certificate::Failure),
    /// A certificate cannot be read.
    #[error("{file}: {reason}")]
    Certificate { file: String, reason: certificate::ReadError },
    /// A certificate claims less than the design does.
    #[error(
        "the certificate has no section 'residual', but the design is marked as certified for the vehicle: the rest \
            is about the fit alone, and proves nothing about the residual between the fit and the true \
            linearisations"
    )]
    NoResidual,
    /// A mode of the controller at 2/T, where the trapezoidal rule has no solution.
    #[error(
        "the controller has a mode at 2/T rad/s, T the sample time, where it cannot be advanced: choose another \
             sample_time in [autopilot]"
    )]
    ModeAtTwiceTheRate,
    /// A certificate is of another controller.
    #[error("the certificate is not of this controller: {what} differs")]
    Mismatch { what: String },
    /// A certificate is of another plant.
    #[error("the certificate is not of this plant: {what} differs")]
    WrongPlant { what: String },
    /// The rate of an actuator has a limit, and the plant of the design no state that it is the rate of.
    #[error(
        "the limit on the rate of {actuator} acts on its lag, which the plant of this design does not have: with \
            'lags = true' in [control] it has"
    )]
    RateWithoutLag { actuator: String },
    /// The drag of a vehicle that flies ahead and astern makes the fit's residual too large for a bound.
    #[error(
        "no gain is shown for every model as far from the fit as the vehicle is: from {from} to {to} m/s the slope \
            of its drag bends at rest, and no polynomial in speed follows that; make two designs, one astern \
            with speed_max = 0 and one ahead with speed_min = 0"
    )]
    BendsAtRest { from: f64, to: f64 },
    /// The ball of models of a certificate does not contain the vehicle.
    #[error(
        "the certificate's section 'residual' does not cover this vehicle: {}",
        .reach.map_or_else(
            || "E, F and Fu make no ball around the fit".to_owned(),
            |r| format!("the true linearisations reach {r:.4} times as far from the fit as the ball does")
        )
    )]
    Ball { reach: Option<f64> },
}
