//! What the prover asks of a claim.

use crate::error::Failure;
use crate::system::Loop;

/// What the prover asks of a claim.
pub(crate) trait Proved {
    /// The name in messages.
    fn name(&self) -> &'static str;

    /// Checks the sizes of its matrices; `path` is its own.
    ///
    /// # Errors
    /// [`Failure::Malformed`].
    fn check(&self, path: &str, of: Loop<'_>) -> Result<(), Failure>;

    /// Proves it for the loop of a checked certificate.
    ///
    /// # Errors
    /// [`Failure`], the first condition that is violated.
    fn prove(&self, of: Loop<'_>) -> Result<(), Failure>;
}
