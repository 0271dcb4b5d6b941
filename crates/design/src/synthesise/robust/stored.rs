//! A robust design in its directory: figures and certificate, written, read back and confirmed.

use crate::certify::verify;
use crate::error::Error;
use crate::fit::Model;
use crate::inputs::Inputs;
use crate::synthesise::robust::figures::{RobustFigures, declared_without};
use crate::synthesise::robust::{Robust, TRUNCATION};
use crate::uncertain::truncate::thinned;
use crate::uncertain::{Fidelity, over_range};
use base::files::{self, Files, read};
use certificate::Certificate;
use proof::claim::{parse, text};
use proof::error::ProofError;
use proof::same_plant;
use scheduled::LftMatrices;
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

/// Takes away what an earlier robust design left: it is of another controller.
pub fn forget(files: &mut Files, directory: &Path) {
    files.remove(directory.join(CERTIFICATE));
    files.remove(directory.join(FIGURES));
}

/// A robust design as it was stored.
#[derive(Debug, Clone)]
pub struct StoredRobust {
    /// The figures.
    pub figures: RobustFigures,
    certificate: Certificate,
}

/// The robust design in a directory, if there is one.
///
/// # Errors
/// [`files::Error::Unreadable`], [`files::Error::Json`], [`ProofError::Certificate`].
pub fn stored(directory: &Path) -> Result<Option<StoredRobust>, Error> {
    let path = directory.join(FIGURES);
    if !path.is_file() {
        return Ok(None);
    }
    let wrong = |reason| files::Error::Json { path: path.display().to_string(), reason };
    let figures = serde_json::from_str(&read(&path)?).map_err(wrong)?;
    let path = directory.join(CERTIFICATE);
    let certificate = parse(&read(&path)?, &path.display().to_string())?;
    Ok(Some(StoredRobust { figures, certificate }))
}

impl StoredRobust {
    /// Proves the certificate again, and checks that it is of this controller, of the gain in the figures, and of the
    /// uncertain model at the size in the figures.
    ///
    /// # Errors
    /// [`ProofError::Unproved`], [`ProofError::Mismatch`], [`ProofError::WrongPlant`], those of the uncertain model.
    pub fn confirm(&self, inputs: &Inputs, model: &Model, controller: &LftMatrices) -> Result<(), Error> {
        verify::same_controller(controller, &self.certificate)?;
        if self.certificate.gamma().map(f64::to_bits) != Some(self.figures.proved.to_bits()) {
            return Err(ProofError::Mismatch { what: format!("`proved` of {FIGURES}") }.into());
        }
        let whole = over_range(inputs, model, Fidelity::COARSE)?;
        let (_, uncertain) = thinned(inputs, &whole, model, TRUNCATION)?;
        let sized = uncertain.sized(self.figures.robust_bears);
        same_plant::check_in_box(&self.certificate.plant, &self.certificate.blocks, &sized)?;
        Ok(self.certificate.prove().map(|_| ())?)
    }
}

/// What the plant of a robust certificate is found to be.
#[derive(Debug, Clone, PartialEq)]
pub struct OfInputs {
    /// The part of the declared uncertainty.
    pub part: f64,
    /// What that is a part of, in words.
    pub declared: String,
}

/// Checks that the plant of a certificate is the uncertain model of the inputs at some part of what they declare;
/// `None` for a certificate that has no uncertain parameter.
///
/// # Errors
/// [`ProofError::WrongPlant`], those of the uncertain model.
pub fn of_inputs(
    certificate: &Certificate,
    inputs: &Inputs,
    model: &Model,
) -> Result<Option<OfInputs>, Error> {
    if certificate.blocks.len() < 2 {
        return Ok(None);
    }
    let whole = over_range(inputs, model, Fidelity::COARSE)?;
    let (fewer, uncertain) = thinned(inputs, &whole, model, TRUNCATION)?;
    let part = same_plant::part_of(&certificate.plant, &certificate.blocks, &uncertain)?;
    Ok(Some(OfInputs { part, declared: declared_without(&fewer.gone) }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::augment::augment;
    use crate::certify::lft_matrices;
    use crate::inputs::tests::shipped;
    use crate::synthesise::synthesise;
    use base::progress::Progress;
    use lpv::robust_bound::RobustLoop;
    use proof::claim::nominal;

    /// Of Squid's nominal controller, at a small part of the declared uncertainty: no figure is confirmed that the
    /// certificate beside it does not prove.
    #[test]
    fn only_what_is_proved_is_confirmed() {
        let inputs = shipped("squid", "design");
        let (actuators, file) = (&inputs.vehicle.actuators, &inputs.design);
        let model = Model::new(&inputs.vehicle, file).unwrap();
        let plant = augment(actuators, &file.with_even_references(), model.linear()).unwrap();
        let design = synthesise(actuators, file, &plant, &Progress::default()).unwrap();
        let whole = over_range(&inputs, &model, Fidelity::COARSE).unwrap();
        let (_, uncertain) = thinned(&inputs, &whole, &model, TRUNCATION).unwrap();
        let found =
            RobustLoop::new(&uncertain, &design.controller).at_small_size(&design.certified, 1.0).unwrap();
        let certificate = nominal(&uncertain.sized(found.size), &design.controller, &found.bound);
        let k = &design.controller;
        let controller = lft_matrices(k);

        let confirmed = |proved: f64, robust_bears: f64| {
            let figures = RobustFigures { proved, robust_bears, ..RobustFigures::default() };
            let stored = StoredRobust { figures, certificate: certificate.clone() };
            stored.confirm(&inputs, &model, &controller)
        };
        let (gamma, size, found_bound) = (found.bound.gamma, found.size, found.bound);
        confirmed(gamma, size).unwrap();
        let found = of_inputs(&certificate, &inputs, &model).unwrap().unwrap();
        assert!((found.part / size - 1.0).abs() < 1e-9, "{} of {size}", found.part);
        let beyond = nominal(&uncertain.sized(1.1), &design.controller, &found_bound);
        let refusal = of_inputs(&beyond, &inputs, &model).unwrap_err().to_string();
        assert!(refusal.contains("the size of the uncertainty"), "{refusal}");

        let refused = |proved, size| confirmed(proved, size).unwrap_err();
        assert!(matches!(refused(gamma, 5.0), Error::Proof(ProofError::WrongPlant { .. })));
        assert!(matches!(refused(0.5 * gamma, size), Error::Proof(ProofError::Mismatch { .. })));
    }
}
