//! Whether a certificate is of a frozen controller, and of the plant that vehicle and design file make.

use crate::augment::augment;
use crate::certify::{ball, frozen_rows, limits, same_plant};
use crate::error::{Error, ProofError};
use crate::fit::Model;
use crate::inputs::design_file::DesignFile;
use auv::Vehicle;
use certificate::{Certificate, Rows};
use scheduled::{ControllerDesign, LftMatrices};
use std::path::Path;

/// Reads a certificate; `file` is for messages.
///
/// # Errors
/// [`ProofError::Certificate`].
pub fn parse(text: &str, file: &str) -> Result<Certificate, ProofError> {
    Certificate::from_json(text).map_err(|reason| ProofError::Certificate { file: file.into(), reason })
}

/// The text of a certificate for the file `path`.
///
/// # Errors
/// [`ProofError::Certificate`].
pub fn text(certificate: &Certificate, path: &Path) -> Result<String, ProofError> {
    let wrong = |reason| ProofError::Certificate { file: path.display().to_string(), reason };
    certificate.to_json().map_err(wrong)
}

/// Checks that the plant of a certificate is the one of this vehicle and design file, trimmed, linearised, fitted and
/// weighted again, that its ball of models contains the true linearisations, and that its limits are no wider.
///
/// # Errors
/// [`ProofError::WrongPlant`], [`ProofError::Ball`], those of [`augment`].
pub fn of_inputs(
    certificate: &Certificate,
    vehicle: &Vehicle,
    file: &DesignFile,
    model: &Model,
) -> Result<(), Error> {
    same_plant::check(
        &certificate.plant,
        &certificate.blocks,
        &augment(&vehicle.actuators, file, model.linear())?,
    )?;
    limits::of_vehicle(certificate, vehicle, file)?;
    let held = certificate.limits.as_ref().and_then(|limits| limits.delta_rows);
    certificate.residual.as_ref().map_or(Ok(()), |ball| ball::holds(ball, held, vehicle, file, model))
}

/// Checks that a certificate is of a frozen controller: the same numbers to the bit, the same bound, and all that the
/// mark `certified` means. No design is marked without a bound that covers the fit's residual
/// ([`crate::certify::certify`]), so that where the mark is, the section `residual` must be.
///
/// # Errors
/// [`ProofError::Mismatch`] with the first part that differs; [`ProofError::NoResidual`].
pub fn matches(design: &ControllerDesign, certificate: &Certificate) -> Result<(), ProofError> {
    same_controller(&design.lft, certificate)?;
    if certificate.gamma().map(f64::to_bits) != Some(design.gamma.bound.to_bits()) {
        return Err(ProofError::Mismatch { what: "gamma".into() });
    }
    if design.gamma.certified && certificate.residual.is_none() {
        return Err(ProofError::NoResidual);
    }
    Ok(())
}

/// Checks that the controller of a certificate is this one, to the bit.
///
/// # Errors
/// [`ProofError::Mismatch`] with the first part that differs.
pub fn same_controller(lft: &LftMatrices, certificate: &Certificate) -> Result<(), ProofError> {
    if certificate.discrete {
        return Err(ProofError::Mismatch { what: "the time, discrete there and continuous here,".into() });
    }
    if let Some(name) = first_unlike(&frozen_rows(lft).named(), &certificate.controller.named()) {
        return Err(ProofError::Mismatch { what: format!("the controller's matrix {name}") });
    }
    if lft.blocks != certificate.controller_blocks {
        return Err(ProofError::Mismatch { what: "the controller's blocks".into() });
    }
    Ok(())
}

/// The name of the first matrix that differs in any bit, but for the sign of zero.
pub fn first_unlike(a: &[(&'static str, &Rows)], b: &[(&'static str, &Rows)]) -> Option<&'static str> {
    a.iter().zip(b).find(|((_, p), (_, q))| p != q).map(|((name, _), _)| *name)
}
