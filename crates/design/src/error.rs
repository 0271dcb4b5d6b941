//! The errors of a design, by stage.
//!
//! A stage returns its own error where nothing else can go wrong there, and [`Error`] where it calls other stages.

mod certify;
mod input;
mod model;
mod refusal;
mod store;
mod uncertain;

use base::files;
pub use certify::CertifyError;
pub use input::InputError;
pub use model::ModelError;
use proof::error::ProofError;
pub use refusal::Refusal;
pub use store::StoreError;
use thiserror::Error as ThisError;
pub use uncertain::{ConstantError, RobustError, UncertainError};

/// The error of a design.
#[derive(Debug, ThisError)]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum Error {
    /// A vehicle file or a design file is wrong.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The model of the vehicle or the generalised plant failed.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// There is no uncertain model.
    #[error(transparent)]
    Uncertain(#[from] UncertainError),
    /// No controller.
    #[error(transparent)]
    Synthesis(#[from] lpv::error::SynthesisError),
    /// No controller for a vehicle, with remarks on possible causes in the problem.
    #[error("{reason}{}", remarks.iter().map(|r| format!("\n  remark: {r}")).collect::<String>())]
    NoController { reason: lpv::error::SynthesisError, remarks: Vec<String> },
    /// There is no robust controller.
    #[error(transparent)]
    Robust(#[from] RobustError),
    /// No gain is proved for constant coefficients.
    #[error(transparent)]
    Constant(#[from] ConstantError),
    /// The gammas under other assumptions about the speed could not be computed.
    #[error(transparent)]
    Ladder(#[from] lpv::ladder::LadderError),
    /// mu at a speed has no bound.
    #[error("mu at {speed} m/s: {reason}")]
    MuAtSpeed {
        /// Speed along the path, m/s.
        speed: f64,
        reason: lpv::mu::sweep::SweepError,
    },
    /// The finished controller failed a check.
    #[error("the controller is refused: {0}")]
    Refused(#[from] Refusal),
    /// A certificate does not prove what is claimed.
    #[error(transparent)]
    Proof(#[from] ProofError),
    /// Nothing is certified of the vehicle.
    #[error(transparent)]
    Certify(#[from] CertifyError),
    /// A flight of the verdict cannot begin.
    #[error(transparent)]
    Flight(#[from] squid_flight::error::Error),
    /// The files of a design are not what is asked for.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// A file cannot be read or written.
    #[error(transparent)]
    File(#[from] files::Error),
}

/// Wraps errors of lower crates in the error of the stage that calls them.
macro_rules! by_way_of {
    ($($stage:ident: $($from:ty),+;)+) => { $($(
        impl From<$from> for Error {
            fn from(reason: $from) -> Self {
                $stage::from(reason).into()
            }
        }
    )+)+ };
}

by_way_of! {
    InputError: auv::FileError;
    ModelError: auv::CoefficientError, lpv::error::FitError, lpv::error::LftError, lpv::error::ShapeError,
        lpv::error::AugmentError;
    ProofError: certificate::Failure;
    StoreError: auv::LpvModelError, auv::VehicleJsonError, scheduled::DesignError, scheduled::ManoeuvreError;
}

/// `From` for errors that reach the `Error` of a crate above by way of its variant `Design`.
#[macro_export]
macro_rules! by_way_of_the_design {
    ($error:ident: $($from:ty),+ $(,)?) => { $(
        impl From<$from> for $error {
            fn from(reason: $from) -> Self {
                Self::Design(reason.into())
            }
        }
    )+ };
}
