//! The prover: it walks the claims.

use crate::certificate::Certificate;
use crate::error::Failure;
use crate::theorem::Theorem;

impl Certificate {
    /// Proves every claim of the certificate in exact arithmetic.
    ///
    /// # Errors
    /// [`Failure`], the first condition that is violated. The claim may still be true, with other matrices.
    pub fn prove(&self) -> Result<Theorem, Failure> {
        self.check()?;
        self.claims.iter().try_for_each(|claim| claim.parts().1.prove(self.system()))?;
        Ok(Theorem::of(self))
    }
}
