//! Interface of a claim to the prover.

use crate::error::ClaimName;
use crate::error::Failure;
use crate::system::Loop;

/// Interface of a claim to the prover.
pub(crate) trait Provable {
    /// Returns the name in messages.
    fn name(&self) -> ClaimName;

    /// Checks the sizes of its matrices; `path` is that of the claim.
    ///
    /// # Errors
    /// [`Failure::Malformed`].
    fn check(&self, path: &str, system: Loop<'_>) -> Result<(), Failure>;

    /// Proves the claim for the loop of a checked certificate.
    ///
    /// # Errors
    /// [`Failure`], the first violated condition.
    fn prove(&self, system: Loop<'_>) -> Result<(), Failure>;
}
