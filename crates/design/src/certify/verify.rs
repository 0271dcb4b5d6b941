//! Checks that a certificate belongs to a frozen controller, and to the plant of a vehicle and a design file.

use crate::augment::augment;
use crate::axis::VehicleModel;
use crate::certify::fit_residual::fit_residual;
use crate::certify::{frozen_rows, limits};
use crate::error::{CertifyError, Error};
use crate::fit::Model;
use crate::inputs::design_file::DesignFile;
use squid_certificate::Certificate;
use squid_proof::claim::first_difference;
use squid_proof::error::ProofError;
use squid_proof::same_plant;
use squid_scheduled::{ControllerDesign, LftMatrices};

/// Checks that the plant of a certificate is that of this vehicle and design file, recomputed from the trims on, that
/// its ball of models contains the true linearisations, and that its limits are no wider than those of the vehicle.
///
/// # Errors
/// [`ProofError::WrongPlant`], [`ProofError::Ball`], the errors of [`augment`].
pub fn check_inputs(
    certificate: &Certificate,
    vehicle: &dyn VehicleModel,
    file: &DesignFile,
    model: &Model,
) -> Result<(), Error> {
    same_plant::check(
        &certificate.plant,
        &certificate.blocks,
        &augment(vehicle.actuators(), file, model.linear())?,
    )?;
    limits::check_vehicle(certificate, vehicle, file)?;
    let held = certificate.limits().and_then(|limits| limits.delta_rows);
    match certificate.model_error() {
        Some(ball) => Ok(fit_residual(vehicle, file, model)?.check(ball, held)?),
        None => Ok(()),
    }
}

/// Checks that a certificate belongs to a frozen controller: the same numbers to the bit, the same bound, and
/// everything that the mark `certified` implies. A design is marked only with a bound that covers the residual of the
/// fit ([`crate::certify::certify`]), so the certificate of a marked design must cover a model error.
///
/// # Errors
/// [`ProofError::Mismatch`] with the first part that differs; [`CertifyError::NoResidual`].
pub fn check_design(design: &ControllerDesign, certificate: &Certificate) -> Result<(), Error> {
    same_controller(&design.lft, certificate)?;
    if certificate.gain().map(|claim| claim.gamma.to_bits()) != Some(design.gamma.bound.to_bits()) {
        return Err(ProofError::Mismatch { what: "gamma".into() }.into());
    }
    if design.gamma.certified && certificate.model_error().is_none() {
        return Err(CertifyError::NoResidual.into());
    }
    Ok(())
}

/// Checks that the controller of a certificate equals this one to the bit.
///
/// # Errors
/// [`ProofError::Mismatch`] with the first part that differs.
pub fn same_controller(lft: &LftMatrices, certificate: &Certificate) -> Result<(), ProofError> {
    if certificate.discrete {
        return Err(ProofError::Mismatch {
            what: "the kind of time (discrete instead of continuous)".into(),
        });
    }
    if let Some(name) = first_difference(&frozen_rows(lft).named(), &certificate.controller.named()) {
        return Err(ProofError::Mismatch { what: format!("matrix {name} of the controller") });
    }
    if lft.blocks != certificate.controller_blocks {
        return Err(ProofError::Mismatch { what: "the blocks of the controller".into() });
    }
    Ok(())
}
