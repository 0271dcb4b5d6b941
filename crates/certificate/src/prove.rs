//! Proof of all claims of a certificate.

use crate::certificate::Certificate;
use crate::error::Failure;
use crate::theorem::Theorem;

impl Certificate {
    /// Proves every claim of the certificate in exact arithmetic.
    ///
    /// # Errors
    /// [`Failure`], the first violated condition. The claim may still be true, with other matrices.
    pub fn prove(&self) -> Result<Theorem, Failure> {
        self.check()?;
        self.claims.iter().try_for_each(|claim| claim.parts().1.prove(self.system()))?;
        Ok(Theorem::of(self))
    }
}
