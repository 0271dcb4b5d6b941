//! The design, stage by stage: trim, linearise, fit, LFT, augment, synthesise, check, certify in continuous time and as
//! sampled, freeze, anti-windup, limits, verdict.

mod judge;
mod prove;
mod summary;

pub use crate::run::prove::{FinishedAxis, Synthesised};

use crate::augment::augment;
use crate::axis::VehicleModel;
use crate::check::Checks;
use crate::error::{Error, InputError};
use crate::findings::not_proved;
use crate::fit::Model;
use crate::fit::{authority, reach};
use crate::inputs::Inputs;
use crate::inputs::design_file::DesignFile;
use crate::run::judge::{Judge, Judged};
use crate::run::prove::proved;
use crate::run::summary::{augment_line, fit_line, lft_line, linearise_line, trim_line, vehicle_line};
use crate::store::freeze::{Frozen, lpv_model};
use crate::synthesise::robust::{Robust, robust};
use crate::synthesise::synthesise;
use crate::verdict::Verdict;
use squid_base::progress::Progress;
use squid_finding::Finding;
use squid_lpv::plant::GeneralisedPlant;
use squid_lpv::synthesis::Design;
use squid_proof::claim::Proof;
use squid_scheduled::InputHashes;

/// Design with the results of all stages.
#[derive(Debug, Clone)]
pub struct Finished {
    /// LPV model of the vehicle.
    pub model: Model,
    /// Generalised plant.
    pub plant: GeneralisedPlant,
    /// Controller and its gammas.
    pub design: Design,
    /// Results of the checks.
    pub checks: Checks,
    /// Certificate, or the reason why there is none.
    pub proof: Result<Proof, String>,
    /// Certificate of the sampled loop, or the reason why there is none.
    pub sampled: Result<Proof, String>,
    /// Contents of the frozen files.
    pub frozen: Frozen,
    /// Robust design, if requested.
    pub robust: Option<Robust>,
    /// Requirements and achieved figures.
    pub verdict: Verdict,
}

impl Finished {
    /// Returns the finding on a design whose proof fails.
    pub fn unproved(&self) -> Option<Finding> {
        self.proof.as_ref().err().map(|reason| not_proved(&self.frozen.controller.design, reason))
    }
}

/// Runs all stages of a nominal design.
///
/// # Errors
/// The error of the first stage that fails. A controller that fails a check is not returned.
pub fn run(inputs: &Inputs, progress: &Progress) -> Result<Finished, Error> {
    run_with(inputs, progress, false)
}

/// Runs all stages like [`run`], with a robust controller in place of the nominal one if `with_robust`; see
/// [`crate::synthesise::robust`].
///
/// # Errors
/// The errors of [`run`] and of [`robust`].
pub fn run_with(inputs: &Inputs, progress: &Progress, with_robust: bool) -> Result<Finished, Error> {
    if with_robust && inputs.design.controller.is_some() {
        let (file, what) = (inputs.design.file.clone(), "there is no robust controller to search for");
        return Err(InputError::GivenController { file, what }.into());
    }
    progress.done("vehicle", &vehicle_line(inputs));
    inputs.findings().iter().for_each(|found| progress.warn(found));
    let (vehicle, file) = (&inputs.axis(), &inputs.design);
    progress.done("design", &format!("{}: {}", file.source(), file.description));
    let model = Model::new(vehicle, file)?;
    progress.done("trim", &trim_line(inputs, &model));
    progress.done("linearise", &linearise_line(&model));
    progress.done("fit", &fit_line(inputs, &model));
    progress.done("LFT", &lft_line(&model));
    let plant = augmented(vehicle, file, &model, progress)?;
    let authority = authority::findings(&inputs.vehicle.actuators, file, &model);
    authority.iter().for_each(|found| progress.warn(found));
    let nominal = synthesise(&inputs.vehicle.actuators, file, &plant, progress)?;
    let robust = with_robust.then(|| robust(inputs, &model, &plant, &nominal, progress)).transpose()?;
    let judge = Judge { inputs, model: &model, plant: &plant };
    let Judged { axis, verdict } = match &robust {
        Some(robust) => judge.assess(robust.design.clone(), progress)?,
        None => judge.smallest(nominal, progress)?,
    };
    let FinishedAxis { synthesised, checks, proof, sampled, controller } = axis;
    let Synthesised { model, plant, design } = synthesised;
    let frozen = Frozen { controller, plant: lpv_model(inputs, &model)? };
    Ok(Finished { model, plant, design, checks, proof, sampled, frozen, robust, verdict })
}

/// Runs the stages of an axis of any vehicle, from its linear models to the frozen, proved controller.
///
/// # Errors
/// The errors of [`run`].
pub fn run_axis(
    vehicle: &dyn VehicleModel,
    file: &DesignFile,
    hashes: &InputHashes,
    progress: &Progress,
) -> Result<FinishedAxis, Error> {
    progress.done("design", &format!("{}: {}", file.source(), file.description));
    let model = Model::new(vehicle, file)?;
    progress.done("linearise", &linearise_line(&model));
    progress.done("LFT", &lft_line(&model));
    let plant = augmented(vehicle, file, &model, progress)?;
    let design = synthesise(vehicle.actuators(), file, &plant, progress)?;
    proved(vehicle, file, hashes, Synthesised { model, plant, design }, progress)
}

/// Generalised plant of a model that is controllable by the actuators and observable from the measurements.
fn augmented(
    vehicle: &dyn VehicleModel,
    file: &DesignFile,
    model: &Model,
    progress: &Progress,
) -> Result<GeneralisedPlant, Error> {
    reach::check(vehicle.actuators(), file, model)?;
    let plant = augment(vehicle.actuators(), file, model.linear())?;
    progress.done("augment", &augment_line(file, &plant));
    Ok(plant)
}
