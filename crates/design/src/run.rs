//! The design, stage by stage: trim, linearise, fit, LFT, augment, synthesise, check, certify in continuous time and as
//! sampled, freeze, anti-windup, limits, verdict.

use crate::augment::augment;
use crate::axis::{OperatingPoint, VehicleModel};
use crate::certify::certify;
use crate::certify::claims;
use crate::certify::lft_matrices;
use crate::certify::limits::with_limits;
use crate::certify::sampled::sampled;
use crate::check::{CHECKED_SPEEDS, Checks, check, fastest_sampled};
use crate::error::{Error, InputError};
use crate::fit::Model;
use crate::fit::{authority, frequency, reach};
use crate::inputs::Inputs;
use crate::inputs::design_file::DesignFile;
use crate::linearise::{envelope, sensors};
use crate::numbers::{above, decimals};
use crate::store::freeze::{Frozen, controller, gamma, lpv_model};
use crate::synthesise::anti_windup::{SPEEDS, anti_windup};
use crate::synthesise::follow::follow;
use crate::synthesise::given;
use crate::synthesise::robust::{Robust, robust};
use crate::synthesise::synthesise;
use crate::verdict::Verdict;
use crate::verdict::found::{Effort, Found};
use auv::longitudinal::{DEPTH, PITCH};
use auv::{Pitch, Status};
use base::progress::{Progress, Results};
use lpv::controller::Controller;
use lpv::matrix::to_rows;
use lpv::plant::GeneralisedPlant;
use lpv::reduce::Reductions;
use lpv::synthesis::Design;
use proof::claim::Proof;
use scheduled::{ControllerDesign, InputHashes, Rows};

/// A design with the results of all stages.
#[derive(Debug, Clone)]
pub struct Finished {
    /// The vehicle's LPV model.
    pub model: Model,
    /// The generalised plant.
    pub plant: GeneralisedPlant,
    /// The controller and its gammas.
    pub design: Design,
    /// The results of the checks.
    pub checks: Checks,
    /// The certificate, or why there is none.
    pub proof: Result<Proof, String>,
    /// The certificate of the sampled loop, or why there is none.
    pub sampled: Result<Proof, String>,
    /// The contents of the frozen files.
    pub frozen: Frozen,
    /// The robust design, if requested.
    pub robust: Option<Robust>,
    /// The requirements and what is achieved.
    pub verdict: Verdict,
}

/// Runs all stages of a nominal design.
///
/// # Errors
/// The error of the first stage that fails. A controller that fails a check is not returned.
pub fn run(inputs: &Inputs, progress: &Progress) -> Result<Finished, Error> {
    run_with(inputs, progress, false)
}

/// As [`run`], with a robust controller in place of the nominal one if `with_robust`; see
/// [`crate::synthesise::robust`].
///
/// # Errors
/// As [`run`], and the errors of [`robust`].
pub fn run_with(inputs: &Inputs, progress: &Progress, with_robust: bool) -> Result<Finished, Error> {
    if with_robust && inputs.design.controller.is_some() {
        let (file, what) = (inputs.design.file.clone(), "there is no robust one to look for");
        return Err(InputError::GivenController { file, what }.into());
    }
    progress.done("vehicle", &vehicle_line(inputs));
    for words in inputs.doubts() {
        progress.done("", &format!("WARNING: {words}"));
    }
    let (vehicle, file) = (&inputs.axis(), &inputs.design);
    progress.done("design", &format!("{}: {}", file.source(), file.description));
    let model = Model::new(vehicle, file)?;
    progress.done("trim", &trim_line(inputs, &model));
    progress.done("linearise", &linearise_line(&model));
    progress.done("fit", &fit_line(inputs, &model));
    progress.done("LFT", &lft_line(&model));
    let plant = augmented(vehicle, file, &model, progress)?;
    for words in authority::remarks(&inputs.vehicle.actuators, file, &model) {
        progress.done("", &words);
    }
    let nominal = synthesise(&inputs.vehicle.actuators, file, &plant, progress)?;
    let robust = with_robust.then(|| robust(inputs, &model, &plant, &nominal, progress)).transpose()?;
    let judge = Judge { inputs, model: &model, plant: &plant };
    let Judged { axis, verdict } = match &robust {
        Some(robust) => judge.told(robust.design.clone(), progress)?,
        None => judge.smallest(nominal, progress)?,
    };
    let FinishedAxis { synthesised, checks, proof, sampled, controller } = axis;
    let Synthesised { model, plant, design } = synthesised;
    let frozen = Frozen { controller, plant: lpv_model(inputs, &model)? };
    Ok(Finished { model, plant, design, checks, proof, sampled, frozen, robust, verdict })
}

/// An axis with the results of its stages.
#[derive(Debug, Clone)]
pub struct FinishedAxis {
    /// Model, generalised plant and controller.
    pub synthesised: Synthesised,
    /// The results of the checks.
    pub checks: Checks,
    /// The certificate, or why there is none.
    pub proof: Result<Proof, String>,
    /// The certificate of the sampled loop, or why there is none.
    pub sampled: Result<Proof, String>,
    /// The frozen controller.
    pub controller: ControllerDesign,
}

/// The results of the stages up to the synthesis.
#[derive(Debug, Clone)]
pub struct Synthesised {
    /// The LPV model of the axis.
    pub model: Model,
    /// The generalised plant.
    pub plant: GeneralisedPlant,
    /// The controller and its gammas.
    pub design: Design,
}

/// Runs the stages of an axis of any vehicle, from its linear models to the frozen, proved controller.
///
/// # Errors
/// As [`run`].
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

/// The generalised plant of a model that actuators and measurements reach.
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

/// A proved axis with its verdict.
struct Judged {
    axis: FinishedAxis,
    verdict: Verdict,
}

impl Judged {
    fn has_limits(&self) -> bool {
        self.axis.proof.as_ref().is_ok_and(|proof| proof.certificate.limits().is_some())
    }

    /// Whether it claims all that the full design claims, and meets every requirement that the full one meets.
    fn keeps_all_of(&self, full: &Self) -> bool {
        (self.has_limits() || !full.has_limits()) && self.verdict.meets_all_of(&full.verdict)
    }

    /// Whether no other controller of the design file can claim more or meet more requirements.
    fn lacks_nothing(&self, file: &DesignFile) -> bool {
        (self.has_limits() || !file.anti_windup) && self.verdict.missed().next().is_none()
    }
}

/// What judges the controllers of a generalised plant.
#[derive(Clone, Copy)]
struct Judge<'a> {
    inputs: &'a Inputs,
    model: &'a Model,
    plant: &'a GeneralisedPlant,
}

impl Judge<'_> {
    /// The design, proved and with its verdict.
    fn told(self, design: Design, progress: &Progress) -> Result<Judged, Error> {
        let Self { inputs, model, plant } = self;
        let (vehicle, file) = (&inputs.axis(), &inputs.design);
        let synthesised = Synthesised { model: model.clone(), plant: plant.clone(), design };
        let axis = proved(vehicle, file, &inputs.hashes, synthesised, progress)?;
        progress.done("envelope", &envelope::words(&axis.controller));
        sensors::words(&axis.controller).iter().for_each(|words| progress.done("failsafe", words));
        envelope::doubt(&axis.controller, &file.manoeuvre).iter().for_each(|words| progress.done("", words));
        let judge = || Verdict::of(inputs, &axis.controller, Effort::FULL);
        let verdict = progress.timed("verdict", "the loop as it flies, and mu", judge).0?;
        progress.done("verdict", &verdict.to_string());
        Ok(Judged { axis, verdict })
    }

    /// The verdict on the frozen loops alone, without proof; `None` where it fails.
    fn frozen(self, design: &Design) -> Option<Verdict> {
        let found = Found::of_frozen(self.inputs, &design.controller).ok()?;
        Some(Verdict::judge(self.inputs, gamma(design, true).bound, found))
    }

    /// The design with the fewest controller states and channels whose bound rises by at most the share that the design
    /// file allows, whose loop is proved in continuous time, sampled and, if the full one's is, with saturated
    /// commands, and whose verdict meets every requirement that the full one meets; the full one if there is none. The
    /// full one is judged only if a smaller one lacks something.
    fn smallest(self, full: Design, progress: &Progress) -> Result<Judged, Error> {
        let Self { inputs, plant, .. } = self;
        let file = &inputs.design;
        let whole = full.slow.is_some() || file.controller.is_some();
        let Some(share) = file.reduce.filter(|_| !whole) else { return self.told(full, progress) };
        let mut judged_full = None;
        let search = || {
            let fastest = fastest_sampled(file.sample_time);
            let mut frozen_full = None;
            Reductions::of(plant, &full, share, Some(fastest)).find_map(|smaller| {
                let frozen = self.frozen(&smaller)?;
                if frozen.missed().next().is_some() {
                    let full = frozen_full.get_or_insert_with(|| self.frozen(&full));
                    if !full.as_ref().is_some_and(|full| frozen.meets_all_of(full)) {
                        return None;
                    }
                }
                let (judged, results) = Results::of(|quiet| self.told(smaller.clone(), quiet));
                let judged = judged.ok().filter(|one| one.axis.proof.is_ok() && one.axis.sampled.is_ok())?;
                if !judged.lacks_nothing(file) {
                    let full = judged_full
                        .get_or_insert_with(|| Results::of(|quiet| self.told(full.clone(), quiet)));
                    if !full.0.as_ref().is_ok_and(|full| judged.keeps_all_of(full)) {
                        return None;
                    }
                }
                Some((smaller, judged, results))
            })
        };
        let (found, seconds) = progress.timed("reduce", "states and channels without need", search);
        let line = match &found {
            Some((smaller, ..)) => format!(
                "{} instead of {}: gain below {} instead of {}, the same requirements met ({seconds:.1} s)",
                sizes(smaller),
                sizes(&full),
                above(smaller.certified.gamma),
                above(full.certified.gamma)
            ),
            None => format!(
                "{} are kept: no smaller controller was found that is proved and meets the same requirements \
                 ({seconds:.1} s)",
                sizes(&full)
            ),
        };
        progress.done("reduce", &line);
        match (found, judged_full) {
            (Some((_, judged, results)), _) => {
                results.tell(progress);
                Ok(judged)
            }
            (None, Some((judged, results))) => {
                results.tell(progress);
                judged
            }
            (None, None) => self.told(full, progress),
        }
    }
}

fn sizes(design: &Design) -> String {
    let sizes = design.controller.parts.sizes();
    format!("{} states and {} {} of rho", sizes.x, sizes.t, if sizes.t == 1 { "channel" } else { "channels" })
}

/// Checks and proves a controller, freezes it, and adds anti-windup.
fn proved(
    vehicle: &dyn VehicleModel,
    file: &DesignFile,
    hashes: &InputHashes,
    synthesised: Synthesised,
    progress: &Progress,
) -> Result<FinishedAxis, Error> {
    let Synthesised { model, plant, design } = &synthesised;
    let what = "the closed loop against the fit and the true linearisations";
    let check = || check(vehicle, file, plant, &design.controller, design.certified.gamma);
    let checks = progress.timed("check", what, check).0?;
    progress.done("check", &check_line(&checks, design.certified.gamma));
    if let Some(words) = checks.remark(file.sample_time, file.control_weight.low) {
        progress.done("", &words);
    }
    let axis = Axis { vehicle, file, progress };
    let proof = axis.certificate(model, plant, design);
    let sampled = axis.sampled(model, design);
    let lft = lft_matrices(&design.controller);
    let mut controller = controller(vehicle, file, hashes, lft, gamma(design, proof.is_ok()))?;
    let gains = match given::anti_windup(vehicle.actuators(), file)? {
        Some(given) => vec![to_rows(&given)],
        None => axis.anti_windup(&design.controller)?,
    };
    controller.anti_windup = gains.first().cloned();
    controller.follow = follow(file, &design.controller)?;
    let limits = |proof| axis.limits(proof, plant, &design.controller, (&controller, &gains));
    let proof = proof.map(|proof| if gains.is_empty() { proof } else { limits(proof) });
    if let Some(limits) = proof.as_ref().ok().and_then(|proof| proof.certificate.limits()) {
        controller.anti_windup = Some(limits.e.clone());
    }
    Ok(FinishedAxis { synthesised, checks, proof, sampled, controller })
}

/// What the stages of a proof have in common.
#[derive(Clone, Copy)]
struct Axis<'a> {
    vehicle: &'a dyn VehicleModel,
    file: &'a DesignFile,
    progress: &'a Progress<'a>,
}

impl Axis<'_> {
    /// Computes the certificate. If the proof fails, the reason is reported and returned, so that the design can be
    /// inspected.
    fn certificate(&self, model: &Model, plant: &GeneralisedPlant, design: &Design) -> Result<Proof, String> {
        let Self { vehicle, file, progress } = *self;
        let what = "covering the fit's residual and proving in exact arithmetic";
        let (proof, seconds) =
            progress.timed("certify", what, || certify(vehicle, file, model, plant, design));
        let proof = proof.map_err(|reason| reason.to_string());
        match &proof {
            Ok(proof) => {
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
        let words = match &proof {
            Ok(proof) => format!(
                "PROVED in exact arithmetic ({seconds:.1} s): gain below {} when sampled every {} s,\n\
             for every trajectory of speed in the range that is constant between ticks, with the fit discretised by \
             the trapezoidal rule",
                claims::bound(&proof.theorem),
                file.sample_time
            ),
            Err(reason) => format!("NOT PROVED: {reason}"),
        };
        progress.done("sampled", &words);
        proof
    }

    /// Gains of anti-windup, if the design has it, the first to be used. If none is found, the controller is used
    /// without it.
    fn anti_windup(&self, controller: &Controller) -> Result<Vec<Rows>, Error> {
        let Self { vehicle, file, progress } = *self;
        if !file.anti_windup {
            return Ok(vec![]);
        }
        let what = "a gain for commands beyond the limits";
        let (found, seconds) = progress.timed("windup", what, || anti_windup(vehicle, file, controller));
        match found {
            Ok(found) => {
                let words = format!(
                    "anti-windup gain computed at {SPEEDS} frozen speeds ({seconds:.1} s);\n\
                 it acts only while a command saturates"
                );
                progress.done("windup", &words);
                Ok(found.iter().map(to_rows).collect())
            }
            Err(Error::Synthesis(reason)) => {
                progress.done("windup", &format!("WARNING: no anti-windup: {reason}"));
                Ok(vec![])
            }
            Err(other) => Err(other),
        }
    }

    /// The claim for saturated commands, if one is found; without it the rest of the proof remains valid.
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
        let words = match &found {
            Ok(None) => return proof,
            Ok(Some(found)) => {
                let flown = claims::unproved_step(frozen.0, &found.theorem, &file.manoeuvre);
                let claim = claims::limits(frozen.0, &found.theorem).map(|claim| proved_in(&claim, seconds));
                let lines: Vec<String> = claim.into_iter().chain(flown).collect();
                Some(lines.join("\n")).filter(|words| !words.is_empty())
            }
            Err(reason) => {
                Some(format!("no step with saturated commands is proved, and none is claimed: {reason}"))
            }
        };
        words.iter().for_each(|words| progress.done("limits", words));
        found.ok().flatten().unwrap_or(proof)
    }
}

/// A proved claim, with the time of the proof.
fn proved_in(claim: &str, seconds: f64) -> String {
    format!("PROVED in exact arithmetic ({seconds:.1} s): {claim}")
}

fn vehicle_line(inputs: &Inputs) -> String {
    let v = &inputs.vehicle;
    let names: Vec<&str> = v.actuators.iter().map(|a| a.name.as_str()).collect();
    let standing = match v.status {
        Status::Surrogate => "SURROGATE coefficients, not the real vehicle's",
        Status::Published => "published coefficients",
        Status::Measured => "measured coefficients",
    };
    format!("{} ({standing}); actuators: {}", v.name, names.join(", "))
}

fn trim_line(inputs: &Inputs, model: &Model) -> String {
    if inputs.design.is_lateral() {
        let (low, high) = (inputs.design.speed_min, inputs.design.speed_max);
        return format!(
            "straight and level at {} speeds, {low:.2} to {high:.2} m/s, {:.0} m deep: another autopilot keeps speed, \
             pitch and depth",
            model.grid.len(),
            inputs.design.depth
        );
    }
    let (first, last) = (&model.grid[0].1.trim, &model.grid[model.grid.len() - 1].1.trim);
    let angle = |trim: &OperatingPoint| decimals(trim.signals[PITCH].to_degrees(), 2);
    let default = inputs.design.pitch_asked.is_none();
    let pitch = match &inputs.design.pitch {
        Pitch::Free => format!("incidence {} to {} deg", angle(first), angle(last)),
        Pitch::Held(_) if default => "pitch held at 0 deg, which thrusters alone can do at every speed\n\
            (with [trim] pitch = \"free\" it is the one of least effort)"
            .into(),
        Pitch::Held(_) => format!("pitch held at {} deg", angle(first)),
        Pitch::Followed(_) => format!(
            "incidence {} to {} deg,\nfollowed along one branch, since the trims of least effort jump",
            angle(first),
            angle(last)
        ),
    };
    format!(
        "level at {} speeds, {:.2} to {:.2} m/s, {:.0} m deep; {pitch}",
        model.grid.len(),
        first.speed,
        last.speed,
        first.signals[DEPTH]
    )
}

/// A real part that is less than this in size is that of an integrator, 1/s.
const INTEGRATES: f64 = 1e-9;

fn linearise_line(model: &Model) -> String {
    let slowest =
        |i: usize| model.grid[i].1.eigenvalues().iter().map(|e| e.re).fold(f64::NEG_INFINITY, f64::max);
    let worst = (0..model.grid.len()).map(slowest).fold(f64::NEG_INFINITY, f64::max);
    let verdict = match worst {
        worst if worst < -INTEGRATES => "stable at every speed",
        worst if worst <= INTEGRATES => "stable without control, but for what integrates",
        _ => "UNSTABLE without control",
    };
    let states = model.grid.first().map_or(&[][..], |(_, l)| l.states);
    let states: Vec<&str> = states.iter().map(|state| state.symbol).collect();
    format!("x = [{}]; {verdict} (largest real part {worst:+.3} rad/s)", states.join(" "))
}

fn fit_line(inputs: &Inputs, model: &Model) -> String {
    let each: Vec<String> = model
        .residuals
        .iter()
        .map(|r| format!("order {}: {:.2} %", r.order, 100.0 * r.relative_to_variation))
        .collect();
    let errors = frequency::errors(&inputs.vehicle.actuators, &inputs.design.tracked, model);
    let responses = |of: &dyn Fn(&frequency::Errors) -> f64| -> String {
        let each = errors.iter().map(|e| format!("order {}: {:.2} %", e.order, 100.0 * of(e)));
        each.collect::<Vec<_>>().join(", ")
    };
    let most = frequency::turning_actuator(&inputs.vehicle.actuators, model);
    format!(
        "order {} in rho; rms residual of A against its variation over speed: {}\n\
         largest error of the frequency response, in the scales of the design: {}\n\
         and from {} to {} alone: {}",
        inputs.design.order,
        each.join(", "),
        responses(&|e| e.scaled),
        inputs.vehicle.actuators[most].name,
        frequency::angle(inputs.design.states).name,
        responses(&|e| e.of_angle(most))
    )
}

fn lft_line(model: &Model) -> String {
    format!(
        "{} channels of rho; differs from the polynomial by {:.1e} at most; {} more for the slope of the trim",
        model.lft.size(),
        model.lft_error,
        model.trim_slope.size()
    )
}

fn augment_line(file: &DesignFile, plant: &GeneralisedPlant) -> String {
    let s = plant.sizes();
    let tracked: Vec<String> = file
        .tracked
        .iter()
        .map(|t| format!("{} (w_b {} rad/s)", t.signal.name, t.weight.bandwidth))
        .collect();
    format!(
        "tracks {}; {} states, {} inputs w, {} outputs z, {} measurements, {} controls",
        tracked.join(" and "),
        s.x,
        s.w,
        s.z,
        s.y,
        s.u
    )
}

fn check_line(c: &Checks, bound: f64) -> String {
    let beyond = if c.gain_truth > bound { ", above the bound, which is for the fit" } else { "" };
    format!(
        "{} speeds: stable with the fit, with the true linearisations, and sampled with the actuators' lags;\n\
         largest frozen gain {:.4}, bound {}; with the true linearisations and trims {:.4}{beyond};\n\
         fastest mode of the controller {:.0} rad/s",
        CHECKED_SPEEDS,
        c.gain_fit,
        above(bound),
        c.gain_truth,
        c.fastest_controller_mode
    )
}
