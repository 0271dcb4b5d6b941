//! The gain of the sampled loop for every trajectory of the speed that is constant from tick to tick.

use crate::augment::augment;
use crate::certify::verify::first_unlike;
use crate::certify::{Proof, controller_of, controller_rows, direct_path, nominal, same_plant};
use crate::error::{Error, ModelError, ProofError};
use crate::fit::Model;
use crate::inputs::design_file::DesignFile;
use auv::Vehicle;
use certificate::{Certificate, Plant};
use lpv::analysis::bounded_gain::{balanced_start, bounded_gain};
use lpv::analysis::{AtTicks, GainBound};
use lpv::direct_path::around;
use lpv::error::SynthesisError;
use lpv::model_error::LoopError;
use lpv::plant::ClosedLoop;
use lpv::synthesis::Design;
use scheduled::ControllerDesign;

/// The file of the certificate.
pub const CERTIFICATE: &str = "sampled_certificate.json";

const STAGE: &str = "analysis of the sampled loop";

/// Bounds the gain of the loop as it is sampled and proves the bound in exact arithmetic: the fit, advanced by the
/// trapezoidal rule, and the controller as the FMU has it, its commands held and late, for every sequence of rho that
/// is constant from tick to tick and jumps at the ticks however far. See [`lpv::analysis::at_ticks`].
///
/// # Errors
/// [`ProofError::Unproved`] with the first check that fails; [`Error::Synthesis`]
/// when no bound is found.
pub fn sampled(vehicle: &Vehicle, file: &DesignFile, model: &Model, design: &Design) -> Result<Proof, Error> {
    let AtTicks { plant, d22 } = at_ticks(vehicle, file, model)?;
    let controller = design.controller.delayed_at_ticks(file.delay_ticks(), file.sample_time);
    let inner = around(&controller, &-&d22).ok_or_else(|| {
        SynthesisError::numerical(
            STAGE,
            "the direct paths of plant and controller make a loop that is not well posed",
        )
    })?;
    let closed = plant.close(&inner);
    let bound = bound(&closed, &design.certified)?;
    let mut certificate = nominal(&plant, &controller, &bound);
    certificate.plant.d22 = direct_path(&d22);
    let theorem = certificate.prove()?;
    Ok(Proof { certificate, theorem, model_error: None })
}

/// The plant of the claim. The commands wait in the controller.
fn at_ticks(vehicle: &Vehicle, file: &DesignFile, model: &Model) -> Result<AtTicks, Error> {
    let soon = DesignFile { delay: 0.0, ..file.clone() };
    let plant = augment(&vehicle.actuators, &soon, model.linear())?;
    Ok(plant.at_ticks(file.sample_time).map_err(ModelError::Sampled)?)
}

/// Checks that the plant of a certificate is the one of this vehicle and design file at the ticks, computed again.
/// `None` where the certificate is of no plant at the ticks: these have every output z twice.
///
/// # Errors
/// [`ProofError::WrongPlant`] with the first part that differs; those of [`augment`].
pub fn of_inputs(
    certificate: &Certificate,
    vehicle: &Vehicle,
    file: &DesignFile,
    model: &Model,
) -> Result<Option<()>, Error> {
    let Ok(AtTicks { plant, d22 }) = at_ticks(vehicle, file, model) else { return Ok(None) };
    if certificate.plant.c1.len() != plant.sizes().z {
        return Ok(None);
    }
    same_plant::check_direct_path(&certificate.plant, &d22)?;
    let without = Plant { d22: vec![], ..certificate.plant.clone() };
    same_plant::check(&without, &certificate.blocks, &plant).map(Some)
}

/// Checks that the controller of a certificate at the ticks is a frozen one, late by so many ticks: the same numbers to
/// the bit.
///
/// # Errors
/// [`ProofError::Mismatch`] with the first part that differs.
pub fn matches(design: &ControllerDesign, ticks: usize, certificate: &Certificate) -> Result<(), ProofError> {
    let wrong = |what: &str| ProofError::Mismatch { what: format!("the controller's {what}") };
    let controller = controller_of(&design.lft).map_err(|_| wrong("shape"))?;
    let late = controller_rows(&controller.delayed_at_ticks(ticks, design.sample_time));
    match first_unlike(&late.named(), &certificate.controller.named()) {
        Some(name) => Err(wrong(&format!("matrix {name}"))),
        None => Ok(()),
    }
}

/// From how far above the bound of the design one of the sampled loop is looked for.
const ROOM: [f64; 3] = [1.0, 2.0, 8.0];

/// A bound of the loop, sought from that of the design; the Lyapunov matrix of the latter does not fit where commands
/// wait in other states.
fn bound(closed: &ClosedLoop, certified: &GainBound) -> Result<GainBound, SynthesisError> {
    let from = |factor: &f64| {
        let roomy = GainBound { gamma: factor * certified.gamma, ..certified.clone() };
        let start = match certified.x.nrows() == closed.a().nrows() {
            true => roomy,
            false => balanced_start(closed, &roomy).ok_or_else(|| {
                SynthesisError::numerical(STAGE, "it is not stable in the middle of the range of speed")
            })?,
        };
        bounded_gain(closed, &LoopError::none(closed), &start)
    };
    let [first, further @ ..] = &ROOM;
    further.iter().fold(from(first), |found, factor| found.or_else(|_| from(factor)))
}
