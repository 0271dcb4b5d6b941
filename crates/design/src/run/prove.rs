//! Stages from a controller to its frozen, proved form.

use crate::axis::VehicleModel;
use crate::certify::certify;
use crate::certify::claims;
use crate::certify::lft_matrices;
use crate::certify::limits::with_limits;
use crate::certify::sampled::sampled;
use crate::check::{CHECKED_SPEEDS, Checks, check};
use crate::error::Error;
use crate::findings::no_anti_windup;
use crate::fit::Model;
use crate::inputs::design_file::DesignFile;
use crate::store::freeze::{controller, gamma};
use crate::synthesise::anti_windup::{SPEEDS, anti_windup};
use crate::synthesise::follow::follow;
use crate::synthesise::given;
use squid_base::numbers::above;
use squid_base::progress::Progress;
use squid_lpv::analysis::GainBound;
use squid_lpv::controller::Controller;
use squid_lpv::matrix::to_rows;
use squid_lpv::plant::GeneralisedPlant;
use squid_lpv::synthesis::Design;
use squid_proof::claim::Proof;
use squid_scheduled::{ControllerDesign, InputHashes, Rows};

/// Axis with the results of its stages.
#[derive(Debug, Clone)]
pub struct FinishedAxis {
    /// Model, generalised plant and controller.
    pub synthesised: Synthesised,
    /// Results of the checks.
    pub checks: Checks,
    /// Certificate, or the reason why there is none.
    pub proof: Result<Proof, String>,
    /// Certificate of the sampled loop, or the reason why there is none.
    pub sampled: Result<Proof, String>,
    /// Frozen controller.
    pub controller: ControllerDesign,
}

/// Results of the stages up to the synthesis.
#[derive(Debug, Clone)]
pub struct Synthesised {
    /// LPV model of the axis.
    pub model: Model,
    /// Generalised plant.
    pub plant: GeneralisedPlant,
    /// Controller and its gammas.
    pub design: Design,
}

/// Checks and proves a controller, freezes it, and adds anti-windup.
pub(super) fn proved(
    vehicle: &dyn VehicleModel,
    file: &DesignFile,
    hashes: &InputHashes,
    synthesised: Synthesised,
    progress: &Progress,
) -> Result<FinishedAxis, Error> {
    let Synthesised { model, plant, mut design } = synthesised;
    let what = "the loop with the fit and with the true linearisations";
    let check = || check(vehicle, file, &plant, &design.controller, design.certified.gamma);
    let checks = progress.timed("check", what, check).0?;
    progress.done("check", &check_line(&checks, design.certified.gamma));
    checks.finding(file.sample_time, file.control_weight.low).iter().for_each(|found| progress.warn(found));
    let axis = Axis { vehicle, file, progress };
    let proof = axis.certificate(&model, &plant, &design);
    let sampled = axis.sampled(&model, &design);
    let proof = proof.map(|(proof, bound)| {
        design.certified = bound;
        proof
    });
    let lft = lft_matrices(&design.controller);
    let mut controller = controller(vehicle, file, hashes, lft, gamma(&design, proof.is_ok()))?;
    let gains = match given::anti_windup(vehicle.actuators(), file)? {
        Some(given) => vec![to_rows(&given)],
        None => axis.anti_windup(&design.controller)?,
    };
    controller.anti_windup = gains.first().cloned();
    controller.follow = follow(file, &design.controller)?;
    let limits = |proof| axis.limits(proof, &plant, &design.controller, (&controller, &gains));
    let proof = proof.map(|proof| if gains.is_empty() { proof } else { limits(proof) });
    if let Some(limits) = proof.as_ref().ok().and_then(|proof| proof.certificate.limits()) {
        controller.anti_windup = Some(limits.e.clone());
    }
    let synthesised = Synthesised { model, plant, design };
    Ok(FinishedAxis { synthesised, checks, proof, sampled, controller })
}

/// Inputs common to the stages of a proof.
#[derive(Clone, Copy)]
struct Axis<'a> {
    vehicle: &'a dyn VehicleModel,
    file: &'a DesignFile,
    progress: &'a Progress<'a>,
}

impl Axis<'_> {
    /// Computes the certificate, and the proved bound for the fit. If the proof fails, the reason is reported and
    /// returned, so that the design can be inspected.
    fn certificate(
        &self,
        model: &Model,
        plant: &GeneralisedPlant,
        design: &Design,
    ) -> Result<(Proof, GainBound), String> {
        let Self { vehicle, file, progress } = *self;
        let what = "covering the residual of the fit, and proving in exact arithmetic";
        let (proof, seconds) =
            progress.timed("certify", what, || certify(vehicle, file, model, plant, design));
        let proof = proof.map_err(|reason| reason.to_string());
        match &proof {
            Ok((proof, _)) => {
                let claim = claims::gain(&proof.theorem, file.scheduling().1);
                progress.done("certify", &proved_in(&claim, seconds));
            }
            Err(reason) => progress.done("certify", &format!("NOT PROVED: {reason}")),
        }
        proof
    }

    /// Computes the certificate of the sampled loop. If the proof fails, the reason is reported and returned.
    fn sampled(&self, model: &Model, design: &Design) -> Result<Proof, String> {
        let Self { vehicle, file, progress } = *self;
        let what = "the gain of the sampled loop, in exact arithmetic";
        let (proof, seconds) = progress.timed("sampled", what, || sampled(vehicle, file, model, design));
        let proof = proof.map_err(|reason| reason.to_string());
        let text = match &proof {
            Ok(proof) => format!(
                "PROVED in exact arithmetic ({seconds:.1} s): gain below {} of the loop sampled every {} s,\nfor \
             every trajectory of speed in the range that is constant between ticks, with the fit discretised by the \
             trapezoidal rule",
                claims::bound(&proof.theorem),
                file.sample_time
            ),
            Err(reason) => format!("NOT PROVED: {reason}"),
        };
        progress.done("sampled", &text);
        proof
    }

    /// Returns gains of anti-windup, if the design has it, the preferred one first. If none is found, the controller is
    /// used without it.
    fn anti_windup(&self, controller: &Controller) -> Result<Vec<Rows>, Error> {
        let Self { vehicle, file, progress } = *self;
        if !file.anti_windup {
            return Ok(vec![]);
        }
        let what = "the gain for saturated commands";
        let (found, seconds) = progress.timed("windup", what, || anti_windup(vehicle, file, controller));
        match found {
            Ok(found) => {
                let text = format!(
                    "anti-windup gain computed at {SPEEDS} frozen speeds ({seconds:.1} s);\nit acts only while a \
                 command is saturated"
                );
                progress.done("windup", &text);
                Ok(found.iter().map(to_rows).collect())
            }
            Err(Error::Synthesis(reason)) => {
                progress.warn(&no_anti_windup(&reason.to_string()));
                Ok(vec![])
            }
            Err(other) => Err(other),
        }
    }

    /// Adds the claim for saturated commands, if one is found; without it the rest of the proof remains valid.
    fn limits(
        &self,
        proof: Proof,
        plant: &GeneralisedPlant,
        controller: &Controller,
        frozen: (&ControllerDesign, &[Rows]),
    ) -> Proof {
        let Self { vehicle, file, progress } = *self;
        let what = "the largest step from which the saturated loop returns to trim";
        let claim = || with_limits(&proof, plant, controller, frozen, vehicle, file);
        let (found, seconds) = progress.timed("limits", what, claim);
        let text = match &found {
            Ok(None) => return proof,
            Ok(Some(found)) => {
                let flown = claims::unproved_step(frozen.0, &found.theorem, &file.manoeuvre);
                let claim = claims::limits(frozen.0, &found.theorem).map(|claim| proved_in(&claim, seconds));
                let lines: Vec<String> = claim.into_iter().chain(flown).collect();
                Some(lines.join("\n")).filter(|text| !text.is_empty())
            }
            Err(reason) => Some(format!("no step with saturated commands is proved: {reason}")),
        };
        text.iter().for_each(|text| progress.done("limits", text));
        found.ok().flatten().unwrap_or(proof)
    }
}

/// Text of a proved claim, with the time of the proof.
fn proved_in(claim: &str, seconds: f64) -> String {
    format!("PROVED in exact arithmetic ({seconds:.1} s): {claim}")
}

fn check_line(c: &Checks, bound: f64) -> String {
    let beyond = if c.gain_truth > bound { ", above the bound, which applies to the fit" } else { "" };
    format!(
        "{} speeds: stable with the fit, with the true linearisations, and sampled with the lags of the \
         actuators;\nlargest frozen gain {:.4}, bound {}; with the true linearisations and trims \
         {:.4}{beyond};\nfastest mode of the controller {:.0} rad/s",
        CHECKED_SPEEDS,
        c.gain_fit,
        above(bound),
        c.gain_truth,
        c.fastest_controller_mode
    )
}
