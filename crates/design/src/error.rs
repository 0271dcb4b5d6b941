//! Errors of a design, by stage.
//!
//! A stage returns its own error if no other can occur, and [`Error`] if it calls other stages.

mod certify;
mod input;
mod model;
mod refusal;
mod store;
mod uncertain;

pub use certify::CertifyError;
pub use input::InputError;
pub use model::ModelError;
pub use refusal::Refusal;
use squid_base::files;
use squid_finding::Finding;
use squid_proof::error::ProofError;
pub use store::StoreError;
use strum::IntoStaticStr;
use thiserror::Error as ThisError;
pub use uncertain::{ConstantError, RobustError, UncertainError};

/// Error of any stage of a design.
#[derive(Debug, ThisError, IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum Error {
    /// A vehicle file or a design file is wrong.
    #[error(transparent)]
    #[strum(transparent)]
    Input(#[from] InputError),
    /// The model of the vehicle or the generalised plant could not be computed.
    #[error(transparent)]
    #[strum(transparent)]
    Model(#[from] ModelError),
    /// There is no uncertain model.
    #[error(transparent)]
    #[strum(transparent)]
    Uncertain(#[from] UncertainError),
    /// No controller was found.
    #[error(transparent)]
    Synthesis(#[from] squid_lpv::error::SynthesisError),
    /// No controller was found for a vehicle; with findings on possible causes.
    #[error("{reason}{}", causes.iter().map(|cause| format!("\n  possible cause: {cause}")).collect::<String>())]
    NoController { reason: squid_lpv::error::SynthesisError, causes: Vec<Finding> },
    /// There is no robust controller.
    #[error(transparent)]
    #[strum(transparent)]
    Robust(#[from] RobustError),
    /// No gain was proved for constant coefficients.
    #[error(transparent)]
    #[strum(transparent)]
    Constant(#[from] ConstantError),
    /// mu could not be bounded at a speed.
    #[error("mu at {speed} m/s: {reason}")]
    MuAtSpeed {
        /// Speed along the path, m/s.
        speed: f64,
        reason: squid_lpv::mu::sweep::SweepError,
    },
    /// The finished controller failed a check.
    #[error("the controller is rejected: {0}")]
    Refused(#[from] Refusal),
    /// A certificate does not prove its claim.
    #[error(transparent)]
    #[strum(transparent)]
    Proof(#[from] ProofError),
    /// The vehicle could not be certified.
    #[error(transparent)]
    #[strum(transparent)]
    Certify(#[from] CertifyError),
    /// A simulated flight of the verdict cannot start.
    #[error(transparent)]
    #[strum(transparent)]
    Flight(#[from] squid_flight::error::Error),
    /// The files of a design do not fit the inputs.
    #[error(transparent)]
    #[strum(transparent)]
    Store(#[from] StoreError),
    /// A file cannot be read or written.
    #[error(transparent)]
    #[strum(transparent)]
    File(#[from] files::Error),
}

/// Converts errors of lower crates to [`Error`] through the error of a stage.
macro_rules! from_stage_errors {
    ($($stage:ident: $($from:ty),+;)+) => { $($(
        impl From<$from> for Error {
            fn from(reason: $from) -> Self {
                $stage::from(reason).into()
            }
        }
    )+)+ };
}

from_stage_errors! {
    InputError: squid_auv::FileError;
    ModelError: squid_auv::CoefficientError, squid_lpv::error::SystemError;
    ProofError: squid_certificate::Failure;
    StoreError: squid_auv::LpvModelError, squid_auv::VehicleJsonError, squid_scheduled::DesignError,
        squid_scheduled::ManoeuvreError;
}

/// `From` for errors that become the variant `Design` of an upper crate's error.
#[macro_export]
macro_rules! from_design_errors {
    ($error:ident: $($from:ty),+ $(,)?) => { $(
        impl From<$from> for $error {
            fn from(reason: $from) -> Self {
                Self::Design(reason.into())
            }
        }
    )+ };
}
