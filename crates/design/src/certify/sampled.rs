//! The gain of the sampled loop for every course of the speed that is constant from tick to tick.

use crate::augment::augment;
use crate::certify::{direct_path, nominal};
use crate::error::{Error, ModelError};
use crate::fit::Model;
use crate::inputs::design_file::DesignFile;
use auv::Vehicle;
use certificate::{Certificate, Theorem};
use lpv::analysis::bounded_gain::{balanced_start, bounded_gain};
use lpv::analysis::{AtTicks, GainBound};
use lpv::direct_path::around;
use lpv::error::SynthesisError;
use lpv::model_error::LoopError;
use lpv::plant::ClosedLoop;
use lpv::synthesis::Design;

/// The file of the certificate.
pub const CERTIFICATE: &str = "sampled_certificate.json";

const STAGE: &str = "analysis of the sampled loop";

/// What is proved of the sampled loop.
#[derive(Debug, Clone)]
pub struct SampledProof {
    /// The certificate: of the plant at the ticks.
    pub certificate: Certificate,
    /// What it proves.
    pub theorem: Theorem,
}

/// Bounds the gain of the loop as it is sampled and proves the bound in exact arithmetic: the fit, advanced by the
/// trapezoidal rule, and the controller as the FMU has it, its commands held and late, for every sequence of rho that
/// is constant from tick to tick and jumps at the ticks however far. See [`lpv::analysis::at_ticks`].
///
/// # Errors
/// [`ProofError::Unproved`](crate::error::ProofError::Unproved) with the first check that fails; [`Error::Synthesis`]
/// when no bound is found.
pub fn sampled(
    vehicle: &Vehicle,
    file: &DesignFile,
    model: &Model,
    design: &Design,
) -> Result<SampledProof, Error> {
    // The commands wait in the controller.
    let soon = DesignFile { delay: 0.0, ..file.clone() };
    let plant = augment(&vehicle.actuators, &soon, model.linear())?;
    let AtTicks { plant, d22 } = plant.at_ticks(file.sample_time).map_err(ModelError::Sampled)?;
    let controller = design.controller.late_at_ticks(file.delay_ticks(), file.sample_time);
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
    Ok(SampledProof { certificate, theorem })
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
