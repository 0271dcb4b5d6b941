//! Gain of the sampled loop for every trajectory of the speed that is constant between ticks.

use crate::augment::augment;
use crate::axis::VehicleModel;
use crate::certify::controller_of;
use crate::error::{Error, ModelError};
use crate::fit::Model;
use crate::inputs::design_file::DesignFile;
use squid_certificate::Certificate;
use squid_lpv::analysis::AtTicks;
use squid_lpv::synthesis::Design;
use squid_proof::claim::{Proof, controller_rows, first_difference};
use squid_proof::error::ProofError;
use squid_scheduled::ControllerDesign;

/// File name of the certificate.
pub const CERTIFICATE: &str = "sampled_certificate.json";

/// Bounds the gain of the sampled loop and proves the bound in exact arithmetic. The plant is the fit, discretised by
/// the trapezoidal rule; the controller is that of the FMU, its commands held and delayed. The bound holds for every
/// sequence of rho that is constant between ticks and may jump arbitrarily at them. See
/// [`squid_lpv::analysis::at_ticks`].
///
/// # Errors
/// [`ProofError::Unproved`] with the first check that fails; [`ProofError::Synthesis`] when no bound is found.
pub fn sampled(
    vehicle: &dyn VehicleModel,
    file: &DesignFile,
    model: &Model,
    design: &Design,
) -> Result<Proof, Error> {
    let ticks = at_ticks(vehicle, file, model)?;
    let controller = design.controller.delayed_at_ticks(file.delay_ticks(), file.sample_time);
    // A given controller may perform far worse when sampled.
    let near = Some(&design.certified).filter(|_| file.controller.is_none());
    Ok(squid_proof::sampled::sampled(&ticks, &controller, near)?)
}

/// Plant of the claim; the delay of the commands is in the controller.
fn at_ticks(vehicle: &dyn VehicleModel, file: &DesignFile, model: &Model) -> Result<AtTicks, Error> {
    let undelayed = DesignFile { delay: 0.0, ..file.clone() };
    let plant = augment(vehicle.actuators(), &undelayed, model.linear())?;
    Ok(plant.at_ticks(file.sample_time).map_err(ModelError::System)?)
}

/// Checks that the plant of a certificate is the sampled plant of this vehicle and design file, recomputed. Returns
/// `None` if the certificate is not of a sampled plant, which has every output z twice.
///
/// # Errors
/// [`ProofError::WrongPlant`] with the first part that differs; the errors of [`augment`].
pub fn check_inputs(
    certificate: &Certificate,
    vehicle: &dyn VehicleModel,
    file: &DesignFile,
    model: &Model,
) -> Result<Option<()>, Error> {
    let Ok(ticks) = at_ticks(vehicle, file, model) else { return Ok(None) };
    Ok(squid_proof::sampled::check(certificate, &ticks)?)
}

/// Checks that the controller of a certificate of the sampled loop is the frozen one, delayed by `ticks`: the same
/// numbers to the bit.
///
/// # Errors
/// [`ProofError::Mismatch`] with the first part that differs.
pub fn check_controller(
    design: &ControllerDesign,
    ticks: usize,
    certificate: &Certificate,
) -> Result<(), ProofError> {
    let wrong = |what: &str| ProofError::Mismatch { what: format!("the {what} of the controller") };
    let controller = controller_of(&design.lft).map_err(|_| wrong("shape"))?;
    let delayed = controller_rows(&controller.delayed_at_ticks(ticks, design.sample_time));
    match first_difference(&delayed.named(), &certificate.controller.named()) {
        Some(name) => Err(wrong(&format!("matrix {name}"))),
        None => Ok(()),
    }
}
