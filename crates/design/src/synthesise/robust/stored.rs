//! The stored files of a robust design: figures and certificate, written, read and checked.

use crate::certify::verify;
use crate::error::{Error, StoreError};
use crate::fit::Model;
use crate::inputs::Inputs;
use crate::synthesise::robust::figures::{RobustFigures, declared_without};
use crate::synthesise::robust::{REDUCTION, Robust};
use crate::uncertain::truncate::reduced;
use crate::uncertain::{Fidelity, over_range};
use squid_base::files::{self, Files, read};
use squid_certificate::{Certificate, Failure};
use squid_proof::claim::{parse, text};
use squid_proof::error::ProofError;
use squid_proof::same_plant;
use squid_scheduled::LftMatrices;
use std::path::Path;

/// The file of the figures.
pub const FIGURES: &str = "robust.json";

/// The file of the certificate with uncertainty.
pub const CERTIFICATE: &str = "robust_certificate.json";

impl Robust {
    /// Adds the certificate and the figures to the files of the design.
    ///
    /// # Errors
    /// [`ProofError::Certificate`], [`files::Error::Json`].
    pub fn add_to(&self, files: &mut Files, directory: &Path) -> Result<(), Error> {
        let path = directory.join(CERTIFICATE);
        files.add(path.clone(), text(&self.certificate, &path)?);
        Ok(files.add_json(directory.join(FIGURES), &self.figures)?)
    }
}

/// Removes the files of an earlier robust design, which belong to another controller.
pub fn remove_from(files: &mut Files, directory: &Path) {
    files.remove(directory.join(CERTIFICATE));
    files.remove(directory.join(FIGURES));
}

/// A stored robust design.
#[derive(Debug, Clone)]
pub struct StoredRobust {
    /// The figures.
    pub figures: RobustFigures,
    certificate: Certificate,
}

/// The robust design in a directory, if there is one.
///
/// # Errors
/// [`files::Error::Unreadable`], [`files::Error::Json`], [`ProofError::Certificate`]; [`StoreError::OtherFormat`] if
/// another version wrote the files.
pub fn stored(directory: &Path) -> Result<Option<StoredRobust>, Error> {
    let path = directory.join(FIGURES);
    if !path.is_file() {
        return Ok(None);
    }
    let wrong = |reason: serde_json::Error| match reason {
        reason if reason.is_data() => Error::from(StoreError::other_format(&path, reason)),
        reason => files::Error::Json { path: path.display().to_string(), reason }.into(),
    };
    let figures = serde_json::from_str(&read(&path)?).map_err(wrong)?;
    let path = directory.join(CERTIFICATE);
    let certificate = parse(&read(&path)?, &path.display().to_string()).map_err(|reason| match reason {
        ProofError::Certificate { reason: Failure::Json(json), .. } if json.is_json => {
            Error::from(StoreError::other_format(&path, json))
        }
        reason => reason.into(),
    })?;
    Ok(Some(StoredRobust { figures, certificate }))
}

impl StoredRobust {
    /// Proves the certificate again, and checks that it belongs to this controller, to the gain in the figures, and to
    /// the uncertain model at the size in the figures.
    ///
    /// # Errors
    /// [`ProofError::Unproved`], [`ProofError::Mismatch`], [`ProofError::WrongPlant`], the errors of the
    /// uncertain model.
    pub fn check(&self, inputs: &Inputs, model: &Model, controller: &LftMatrices) -> Result<(), Error> {
        verify::same_controller(controller, &self.certificate)?;
        if self.certificate.gain().map(|claim| claim.gamma.to_bits()) != Some(self.figures.proved.to_bits()) {
            return Err(ProofError::Mismatch { what: format!("`proved` of {FIGURES}") }.into());
        }
        let full = over_range(inputs, model, Fidelity::COARSE)?;
        let (_, uncertain) = reduced(inputs, &full, model, REDUCTION)?;
        let sized = uncertain.sized(self.figures.robust_tolerated_fraction);
        same_plant::check_in_box(&self.certificate.plant, &self.certificate.blocks, &sized)?;
        Ok(self.certificate.prove().map(|_| ())?)
    }
}

/// The uncertainty covered by a robust certificate.
#[derive(Debug, Clone, PartialEq)]
pub struct CoveredUncertainty {
    /// The fraction of the declared uncertainty.
    pub fraction: f64,
    /// The uncertainty that this is a fraction of.
    pub declared: String,
}

/// Checks that the plant of a certificate is the uncertain model of the inputs for some fraction of the declared
/// uncertainty; `None` for a certificate without uncertain parameters.
///
/// # Errors
/// [`ProofError::WrongPlant`], the errors of the uncertain model.
pub fn check_inputs(
    certificate: &Certificate,
    inputs: &Inputs,
    model: &Model,
) -> Result<Option<CoveredUncertainty>, Error> {
    if certificate.blocks.len() < 2 {
        return Ok(None);
    }
    let full = over_range(inputs, model, Fidelity::COARSE)?;
    let (truncated, uncertain) = reduced(inputs, &full, model, REDUCTION)?;
    let fraction = same_plant::fraction_of(&certificate.plant, &certificate.blocks, &uncertain)?;
    Ok(Some(CoveredUncertainty { fraction, declared: declared_without(&truncated.removed) }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::augment::augment;
    use crate::certify::lft_matrices;
    use crate::inputs::tests::shipped;
    use crate::synthesise::synthesise;
    use squid_base::progress::Progress;
    use squid_lpv::robust_bound::RobustLoop;
    use squid_proof::claim::nominal;

    /// Squid's nominal controller at a small fraction of the declared uncertainty: figures that the certificate does
    /// not prove are refused.
    #[test]
    fn only_what_is_proved_is_confirmed() {
        let inputs = shipped("squid", "design");
        let (actuators, file) = (&inputs.vehicle.actuators, &inputs.design);
        let model = Model::new(&inputs.axis(), file).unwrap();
        let plant = augment(actuators, &file.with_unweighted_references(), model.linear()).unwrap();
        let design = synthesise(actuators, file, &plant, &Progress::default()).unwrap();
        let full = over_range(&inputs, &model, Fidelity::COARSE).unwrap();
        let (_, uncertain) = reduced(&inputs, &full, &model, REDUCTION).unwrap();
        let found =
            RobustLoop::new(&uncertain, &design.controller).at_small_size(&design.certified, 1.0).unwrap();
        let certificate = nominal(&uncertain.sized(found.size), &design.controller, &found.bound);
        let k = &design.controller;
        let controller = lft_matrices(k);

        let confirmed = |proved: f64, robust_tolerated_fraction: f64| {
            let figures = RobustFigures { proved, robust_tolerated_fraction, ..RobustFigures::default() };
            let stored = StoredRobust { figures, certificate: certificate.clone() };
            stored.check(&inputs, &model, &controller)
        };
        let (gamma, size, found_bound) = (found.bound.gamma, found.size, found.bound);
        confirmed(gamma, size).unwrap();
        let found = check_inputs(&certificate, &inputs, &model).unwrap().unwrap();
        assert!((found.fraction / size - 1.0).abs() < 1e-9, "{} of {size}", found.fraction);
        let beyond = nominal(&uncertain.sized(1.1), &design.controller, &found_bound);
        insta::assert_snapshot!(check_inputs(&beyond, &inputs, &model).unwrap_err());

        let refused = |proved, size| confirmed(proved, size).unwrap_err();
        assert!(matches!(refused(gamma, 5.0), Error::Proof(ProofError::WrongPlant { .. })));
        assert!(matches!(refused(0.5 * gamma, size), Error::Proof(ProofError::Mismatch { .. })));
    }
}
