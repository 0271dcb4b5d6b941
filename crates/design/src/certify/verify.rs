//! Whether a certificate is of a frozen controller, and of the plant that vehicle and design file make.

use crate::augment::augment;
use crate::certify::missed::missed;
use crate::certify::{frozen_rows, limits};
use crate::error::{CertifyError, Error};
use crate::fit::Model;
use crate::inputs::design_file::DesignFile;
use auv::Vehicle;
use certificate::Certificate;
use proof::claim::first_unlike;
use proof::error::ProofError;
use proof::same_plant;
use scheduled::{ControllerDesign, LftMatrices};

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
    match &certificate.residual {
        Some(ball) => Ok(missed(vehicle, file, model)?.check(ball, held)?),
        None => Ok(()),
    }
}

/// Checks that a certificate is of a frozen controller: the same numbers to the bit, the same bound, and all that the
/// mark `certified` means. No design is marked without a bound that covers the fit's residual
/// ([`crate::certify::certify`]), so that where the mark is, the section `residual` must be.
///
/// # Errors
/// [`ProofError::Mismatch`] with the first part that differs; [`CertifyError::NoResidual`].
pub fn matches(design: &ControllerDesign, certificate: &Certificate) -> Result<(), Error> {
    same_controller(&design.lft, certificate)?;
    if certificate.gamma().map(f64::to_bits) != Some(design.gamma.bound.to_bits()) {
        return Err(ProofError::Mismatch { what: "gamma".into() }.into());
    }
    if design.gamma.certified && certificate.residual.is_none() {
        return Err(CertifyError::NoResidual.into());
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
