//! Certificate: the gain bound of the finished loop in a form that exact arithmetic re-checks.
//!
//! One file states two claims: a bound for the fitted model, and a bound that also holds for a model error as large as
//! the residual of the fit anywhere in the range of speed.

pub mod claims;
pub mod constant;
pub mod fit_residual;
pub mod limits;
pub mod sampled;
pub mod verify;

use crate::axis::VehicleModel;
use crate::certify::fit_residual::{bends_at_rest, fit_residual};
use crate::error::{CertifyError, Error};
use crate::fit::Model;
use crate::inputs::design_file::DesignFile;
use squid_lpv::analysis::{GainBound, bounded_gain};
use squid_lpv::controller::Controller;
use squid_lpv::error::SynthesisError;
use squid_lpv::plant::GeneralisedPlant;
use squid_lpv::synthesis::Design;
use squid_proof::claim::{Proof, controller, controller_rows, with_model_error};
use squid_proof::error::ProofError;
use squid_scheduled::LftMatrices;

/// Computes the certificate of a design, for the fit and for a ball of models that contains the true linearisations
/// ([`fit_residual()`]), and proves it in exact arithmetic. Also returns the proved bound for the fit, which is the one
/// of the design or a smaller one.
///
/// # Errors
/// [`ProofError::Unproved`] with the first check that fails; [`CertifyError::BendsAtRest`] or [`Error::Synthesis`] if
/// no bound covers the model error.
pub fn certify(
    vehicle: &dyn VehicleModel,
    file: &DesignFile,
    model: &Model,
    plant: &GeneralisedPlant,
    design: &Design,
) -> Result<(Proof, GainBound), Error> {
    let (error, size) = fit_residual(vehicle, file, model)?.smallest(&design.certified)?;
    let (closed, closed_error) = (plant.close(&design.controller), error.close(plant, &design.controller));
    let covered = bounded_gain(&closed, &closed_error, &design.certified)
        .map_err(|reason| explain(vehicle, file, model, reason))?;
    Ok(with_model_error(plant, design, &error, size, &closed, &closed_error, &covered)?)
}

/// Explains by the vehicle, if possible, that no bound covers the model error.
fn explain(vehicle: &dyn VehicleModel, file: &DesignFile, model: &Model, reason: SynthesisError) -> Error {
    match bends_at_rest(vehicle, file, model) {
        Ok(true) => CertifyError::BendsAtRest { from: file.speed_min, to: file.speed_max }.into(),
        _ => reason.into(),
    }
}

/// Returns the matrices of a controller in the form of a controller file.
pub fn lft_matrices(k: &Controller) -> LftMatrices {
    let squid_certificate::Controller { a, by, bt, cu, duy, dut, ct, dty, dtt } = controller_rows(k);
    LftMatrices { blocks: k.blocks.clone(), a, by, bt, cu, duy, dut, ct, dty, dtt }
}

/// Returns the matrices of a frozen controller in the form of the certificate.
pub fn frozen_rows(lft: &LftMatrices) -> squid_certificate::Controller {
    let LftMatrices { blocks: _, a, by, bt, cu, duy, dut, ct, dty, dtt } = lft.clone();
    squid_certificate::Controller { a, by, bt, cu, duy, dut, ct, dty, dtt }
}

/// Returns the matrices of a frozen controller as a [`Controller`].
///
/// # Errors
/// [`ProofError::Mismatch`] if their shapes do not match.
pub fn controller_of(lft: &LftMatrices) -> Result<Controller, ProofError> {
    let wrong = || ProofError::Mismatch { what: "the shape of a controller matrix".into() };
    controller(&lft.blocks, &frozen_rows(lft)).ok_or_else(wrong)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inputs::tests::shipped;

    /// BlueROV2 Heavy has quadratic drag: ranges of speed with rest in their interior are distinguished from others.
    #[test]
    fn explains_failed_proof_by_drag_at_rest() {
        let mut inputs = shipped("bluerov2_heavy", "design");
        for (from, to, bends) in [(-0.5, 0.5, true), (-0.2, 0.5, true), (0.0, 0.5, false), (-0.5, 0.0, false)]
        {
            (inputs.design.speed_min, inputs.design.speed_max) = (from, to);
            let model = Model::new(&inputs.axis(), &inputs.design).unwrap();
            let reason = SynthesisError::Infeasible { stage: "test" };
            let error = explain(&inputs.axis(), &inputs.design, &model, reason);
            let found = match error {
                Error::Certify(CertifyError::BendsAtRest { from, to }) => Some((from, to)),
                _ => None,
            };
            assert_eq!(found, bends.then_some((from, to)));
        }
    }
}
