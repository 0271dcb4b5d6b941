//! Output directory of a design: its files, written and read back.
//!
//! | file | what |
//! |---|---|
//! | `controller.json` | the frozen controller |
//! | `plant.json` | the frozen LPV model of the vehicle |
//! | `manoeuvre.json` | the default manoeuvre of the FMU of the complete loop |
//! | `certificate.json` | the proof of the gain bound, if there is one |
//! | `design.json` | the figures of the design |
//! | `robust.json` | for a robust design: the figures of the nominal and the robust controller |
//! | `sampled_certificate.json` | the proof of the gain bound of the sampled loop, if there is one |
//! | `robust_certificate.json` | for a robust design: the proof of the gain bound with uncertainty |
//! | `constant_certificate.json` | with `--constant`: the proof of the gain bound for constant coefficients |
//! | `.squid-vehicle` | the vehicle's directory, so that a vehicle of the same name does not replace the design |
//! | `.squid-lock` | empty; locked while the others are written or read, so that all belong to one design |

pub mod freeze;
pub mod owner;
pub mod unedited;

use crate::augment::augment;
use crate::certify::constant;
use crate::certify::controller_of;
use crate::certify::limits::check_autopilot;
use crate::certify::sampled;
use crate::certify::verify;
use crate::check::{CHECKED_SPEEDS, check};
use crate::error::{Error, StoreError};
use crate::findings::not_proved;
use crate::fit::Model;
use crate::fit::frequency::{Errors, errors, outputs};
use crate::inputs::Inputs;
use crate::run::Finished;
use crate::store::freeze::Frozen;
use crate::synthesise::robust::stored::{self, StoredRobust};
use crate::verdict::Verdict;
use crate::verdict::row::{Outcome, StoredRow};
use serde::Serialize;
use serde::de::IgnoredAny;
use serde_json::Value;
use squid_auv::{Actuator, LpvModel, LpvModelError};
use squid_base::files::{Files, read, reading};
use squid_certificate::{Certificate, Theorem};
use squid_finding::Finding;
use squid_proof::claim::{parse, text};
use squid_scheduled::{ControllerDesign, DesignError, Manoeuvre};
use squid_signals::States;
use std::path::{Path, PathBuf};

/// Returns the default directory of an autopilot: `build/VEHICLE/DESIGN`.
pub fn default_directory(inputs: &Inputs) -> PathBuf {
    let name: String = inputs
        .design
        .autopilot
        .chars()
        .map(|c| if c.is_ascii_alphanumeric() || "._-".contains(c) { c } else { '_' })
        .collect();
    let vehicle =
        inputs.directory.file_name().map_or_else(|| inputs.vehicle.name.clone().into(), ToOwned::to_owned);
    Path::new("build").join(vehicle).join(name)
}

/// Returns the directory of the files of an axis: a folder in that of its autopilot, or that itself if there is one
/// axis.
pub fn axis_directory(directory: &Path, inputs: &Inputs) -> PathBuf {
    inputs
        .design
        .axis
        .map_or_else(|| directory.to_owned(), |_| directory.join(inputs.design.steered_signal()))
}

/// Returns the directory of the source of an axis, in C, whose design is stored in a directory.
pub fn source_directory(directory: &Path, inputs: &Inputs) -> PathBuf {
    let autopilot = inputs.design.axis.and_then(|_| directory.parent()).unwrap_or(directory);
    axis_directory(&autopilot.join("c"), inputs)
}

/// Frozen files of a design.
#[derive(Debug, Clone)]
pub struct Stored {
    /// Frozen controller.
    pub controller: ControllerDesign,
    /// Frozen LPV model; only for surge, heave and pitch.
    pub plant: Option<LpvModel>,
    /// Default manoeuvre.
    pub manoeuvre: Manoeuvre,
    /// Text of the certificate, or the reason why there is none.
    pub certificate: Result<String, String>,
    /// Text of the certificate of the sampled loop, if there is one.
    pub sampled: Option<String>,
    /// Figures and certificate of a robust design, if there is one.
    pub robust: Option<StoredRobust>,
    /// Readable rows of the verdict.
    pub rows: Vec<StoredRow>,
    /// Proved coupling with the design of another axis.
    pub coupling: Option<StoredCoupling>,
}

/// Proved coupling of a design with that of another axis.
#[derive(Debug, Clone)]
pub struct StoredCoupling {
    /// Text of the certificate of this axis.
    pub certificate: String,
    /// Text of the claim of both certificates.
    pub claim: String,
}

impl Stored {
    /// Describes the missed requirements; `None` if none is known to be missed.
    pub fn missed(&self) -> Option<String> {
        let missed = self.rows.iter().filter(|row| row.outcome == Outcome::Missed);
        let names: Vec<&str> = missed.map(|row| row.name.as_str()).collect();
        (!names.is_empty()).then(|| format!("requirements MISSED: {}", names.join("; ")))
    }

    /// Returns a new design without its certificate: sufficient for flights and comparisons.
    pub fn of(frozen: &Frozen, inputs: &Inputs) -> Self {
        Self {
            controller: frozen.controller.clone(),
            plant: frozen.plant.clone(),
            manoeuvre: inputs.design.manoeuvre.clone(),
            certificate: Err("no certificate was requested".into()),
            sampled: None,
            robust: None,
            rows: vec![],
            coupling: None,
        }
    }

    /// Proves the certificate again, for the stored controller and for the plant and weights of the inputs, and repeats
    /// the checks of a new controller.
    ///
    /// # Errors
    /// The reason why this controller is not certified.
    pub fn prove(&self, inputs: &Inputs) -> Result<Theorem, String> {
        let text = self.certificate.as_ref().map_err(Clone::clone)?;
        let certificate = parse(text, "certificate.json").map_err(|e| e.to_string())?;
        verify::check_design(&self.controller, &certificate).map_err(|e| e.to_string())?;
        let theorem = certificate.prove().map_err(|e| e.to_string())?;
        self.check_unproved_parts(inputs, &certificate).map_err(|e| e.to_string())?;
        check_autopilot(&self.controller, &certificate).map_err(|e| e.to_string())?;
        Ok(theorem)
    }

    /// Proves the certificate of the sampled loop again, for the stored controller and for the plant and weights of the
    /// inputs.
    ///
    /// # Errors
    /// The reason why nothing is proved of the sampled loop.
    pub fn prove_sampled(&self, inputs: &Inputs) -> Result<Theorem, String> {
        let text = self.sampled.as_ref().ok_or_else(|| format!("{} is missing", sampled::CERTIFICATE))?;
        let certificate = parse(text, sampled::CERTIFICATE).map_err(|e| e.to_string())?;
        let (vehicle, design) = (inputs.axis(), &inputs.design);
        sampled::check_controller(&self.controller, design.delay_ticks(), &certificate)
            .map_err(|e| e.to_string())?;
        let model = Model::new(&vehicle, design).map_err(|e| e.to_string())?;
        let is_sampled_plant =
            sampled::check_inputs(&certificate, &vehicle, design, &model).map_err(|e| e.to_string())?;
        is_sampled_plant.ok_or("its plant is not that of a sampled loop")?;
        certificate.prove().map_err(|e| e.to_string())
    }

    /// Returns the finding on a design whose proof fails.
    pub fn unproved(&self, inputs: &Inputs) -> Option<Finding> {
        self.unproved_by(&self.prove(inputs))
    }

    /// Returns the finding of [`Stored::unproved`] for the result of an earlier proof.
    pub fn unproved_by(&self, proof: &Result<Theorem, String>) -> Option<Finding> {
        let reason = match proof {
            Ok(_) if self.controller.gamma.certified => return None,
            Ok(_) => "controller.json marks the controller as not certified",
            Err(reason) => reason,
        };
        Some(not_proved(&self.controller.design, reason))
    }

    /// Checks the facts that the proof does not cover: the plant and the ball of the certificate, scales and trims, the
    /// frozen loops.
    fn check_unproved_parts(&self, inputs: &Inputs, certificate: &Certificate) -> Result<(), Error> {
        let model = Model::new(&inputs.axis(), &inputs.design)?;
        verify::check_inputs(certificate, &inputs.axis(), &inputs.design, &model)?;
        unedited::check(&self.controller, self.plant.as_ref(), inputs, &model)?;
        let plant = augment(&inputs.vehicle.actuators, &inputs.design, model.linear())?;
        let bound = self.controller.gamma.bound;
        check(&inputs.axis(), &inputs.design, &plant, &controller_of(&self.controller.lft)?, bound)
            .map(|_| ())
    }
}

/// Figures of a design in `design.json`.
#[derive(Debug, Serialize)]
struct Figures<'a> {
    vehicle: &'a str,
    status: &'a str,
    design: &'a str,
    /// Prefix of the FMUs' names: IDENTIFIER.fmu, IDENTIFIER_plant.fmu, IDENTIFIER_controller.fmu.
    fmu_identifier: String,
    gamma_optimum: f64,
    gamma_design: f64,
    gamma_bound: f64,
    back_off: f64,
    /// Regularisation of the plant for the synthesis.
    #[serde(skip_serializing_if = "Option::is_none")]
    added_for_the_design: Option<String>,
    gamma_bound_with_model_error: Option<f64>,
    model_error: Option<f64>,
    /// Bound of the sampled loop, for a speed that is constant between ticks.
    gamma_bound_sampled: Option<f64>,
    not_certified_sampled_because: Option<&'a str>,
    certified: bool,
    not_certified_because: Option<&'a str>,
    largest_eigenvalue: f64,
    fit: Vec<FitFigures>,
    lft_size: usize,
    lft_error: f64,
    checked_speeds: usize,
    largest_real_part: f64,
    largest_real_part_truth: f64,
    largest_frozen_gain: f64,
    largest_frozen_gain_truth: f64,
    sampled_radius: f64,
    fastest_controller_mode: f64,
    verdict: &'a Verdict,
}

#[derive(Debug, Serialize)]
struct FitFigures {
    order: usize,
    rms_relative_to_variation: f64,
    rms_relative: f64,
    largest_norm: f64,
    frequency_response: ResponseFigures,
}

/// Largest relative errors of the frequency response; see [`crate::fit::frequency::Errors`].
#[derive(Debug, Serialize)]
struct ResponseFigures {
    scaled: f64,
    channels: Vec<ChannelFigures>,
}

#[derive(Debug, Serialize)]
struct ChannelFigures {
    from: String,
    to: &'static str,
    error: f64,
}

fn response_figures((actuators, states): (&[Actuator], States), errors: Option<&Errors>) -> ResponseFigures {
    let channel = |(i, to): (usize, &'static str), j: usize| ChannelFigures {
        from: actuators[j].name.clone(),
        to,
        error: errors.map_or(f64::NAN, |e| e.channels[(i, j)]),
    };
    let outputs = outputs(states).into_iter().map(|signal| signal.name).enumerate();
    ResponseFigures {
        scaled: errors.map_or(f64::NAN, |e| e.scaled),
        channels: outputs
            .flat_map(|to| (0..actuators.len()).map(move |j| (to, j)))
            .map(|(to, j)| channel(to, j))
            .collect(),
    }
}

/// Writes the files of a finished design, all of them or none, and removes those of an earlier design, including its
/// FMUs.
///
/// # Errors
/// [`Unwritable`](squid_base::files::Error::Unwritable).
pub fn save(directory: &Path, inputs: &Inputs, finished: &Finished) -> Result<(), Error> {
    let to = |name: &str| directory.join(name);
    let mut files = Files::default();
    match &finished.frozen.plant {
        Some(plant) => files.add(to("plant.json"), plant.to_json()?),
        None => files.remove(to("plant.json")),
    }
    files.add(to("manoeuvre.json"), inputs.design.manoeuvre.to_json()?);
    let continuous = finished.proof.as_ref().ok().map(|proof| &proof.certificate);
    let sampled = finished.sampled.as_ref().ok().map(|proof| &proof.certificate);
    for (name, certificate) in [("certificate.json", continuous), (sampled::CERTIFICATE, sampled)] {
        match certificate {
            Some(certificate) => files.add(to(name), text(certificate, &to(name))?),
            None => files.remove(to(name)),
        }
    }
    files.add_json(to("design.json"), &figures(inputs, finished))?;
    owner::outdated(directory, inputs, finished)?.into_iter().for_each(|path| files.remove(path));
    if let Some(mark) = owner::mark(inputs) {
        files.add(to(owner::MARK), mark);
    }
    match &finished.robust {
        Some(found) => found.add_to(&mut files, directory)?,
        None => stored::remove_from(&mut files, directory),
    }
    // An existing certificate belongs to another controller.
    files.remove(to(constant::CERTIFICATE));
    // The controller is added last, because `load` relies on its hashes.
    files.add(to("controller.json"), finished.frozen.controller.to_json()?);
    Ok(files.save(directory)?)
}

/// Reads the files of a design, if they belong to these inputs.
///
/// # Errors
/// [`StoreError::NotDesigned`] if there is none, [`StoreError::OtherFormat`] if another version wrote it,
/// [`StoreError::OtherDesign`], [`StoreError::Stale`] if the vehicle or the design file has changed.
pub fn load(directory: &Path, inputs: &Inputs) -> Result<Stored, Error> {
    let path = directory.join("controller.json");
    let _lock = reading(&path);
    if !path.is_file() {
        return Err(StoreError::NotDesigned { directory: directory.display().to_string() }.into());
    }
    let controller = ControllerDesign::from_json(&read(&path)?).map_err(|reason| match reason {
        DesignError::Json(json) if json.is_data() => StoreError::other_format(&path, json),
        DesignError::WrongFormat { .. } => StoreError::other_format(&path, reason),
        reason => StoreError::BadController { path: path.display().to_string(), reason },
    })?;
    let (vehicle, design) = (&controller.vehicle.name, &controller.design);
    if (vehicle, design) != (&inputs.vehicle.name, &inputs.design.name) {
        let (vehicle, design) = (vehicle.clone(), design.clone());
        return Err(
            StoreError::OtherDesign { directory: directory.display().to_string(), vehicle, design }.into()
        );
    }
    if let Some(what) = inputs.changed_since(&controller.inputs) {
        return Err(StoreError::Stale { directory: directory.display().to_string(), what }.into());
    }
    let plant = (!inputs.design.view().is_level_held).then(|| lpv_model(directory)).transpose()?;
    let certificate_path = directory.join("certificate.json");
    let certificate = if certificate_path.is_file() {
        Ok(read(&certificate_path)?)
    } else {
        Err(format!("certificate.json is missing{}", why_not_certified(directory)))
    };
    let sampled_path = directory.join(sampled::CERTIFICATE);
    let sampled = sampled_path.is_file().then(|| read(&sampled_path)).transpose()?;
    let robust = stored::stored(directory)?;
    let (manoeuvre, rows) = (inputs.design.manoeuvre.clone(), rows(directory));
    Ok(Stored { controller, plant, manoeuvre, certificate, sampled, robust, rows, coupling: None })
}

/// Reads the stored LPV model.
fn lpv_model(directory: &Path) -> Result<LpvModel, Error> {
    let path = directory.join("plant.json");
    let (file, text) = (path.display().to_string(), read(&path)?);
    let is_json = || serde_json::from_str::<IgnoredAny>(&text).is_ok();
    let found = LpvModel::from_json(&text, &file).map_err(|reason| match reason {
        LpvModelError::NotJson { message, .. } if is_json() => StoreError::other_format(&path, message),
        LpvModelError::Format { .. } => StoreError::other_format(&path, reason),
        LpvModelError::NotJson { .. } => StoreError::LpvModel(reason),
        reason => StoreError::BadPlant { path: file, reason },
    })?;
    Ok(found)
}

/// Reads the figures of a stored design; `None` if they cannot be read.
fn stored_figures(directory: &Path) -> Option<Value> {
    serde_json::from_str(&read(&directory.join("design.json")).ok()?).ok()
}

/// Reads the stored verdict.
fn rows(directory: &Path) -> Vec<StoredRow> {
    let figures = stored_figures(directory).unwrap_or_default();
    let rows = figures["verdict"]["rows"].as_array().into_iter().flatten();
    rows.filter_map(|row| serde_json::from_value(row.clone()).ok()).collect()
}

/// Reads the stored reason for a missing proof.
fn why_not_certified(directory: &Path) -> String {
    let figures = stored_figures(directory).unwrap_or_default();
    figures["not_certified_because"].as_str().map_or_else(String::new, |reason| format!(": {reason}"))
}

fn figures<'a>(inputs: &'a Inputs, f: &'a Finished) -> Figures<'a> {
    let responses = errors(&inputs.vehicle.actuators, &inputs.design.tracked, &f.model);
    Figures {
        vehicle: &inputs.vehicle.name,
        status: inputs.vehicle.status.word(),
        design: &inputs.design.name,
        fmu_identifier: squid_model_description::identifier(&inputs.vehicle.name),
        gamma_optimum: f.design.gamma_optimum,
        gamma_design: f.design.gamma_design,
        gamma_bound: f.design.certified.gamma,
        back_off: crate::synthesise::back_off(&f.design),
        added_for_the_design: f.design.regularisation.as_ref().map(ToString::to_string),
        gamma_bound_with_model_error: f.proof.as_ref().ok().and_then(|p| p.theorem.gamma_with_model_error),
        model_error: f.proof.as_ref().ok().and_then(|p| p.model_error),
        gamma_bound_sampled: f.sampled.as_ref().ok().and_then(|p| p.theorem.gamma),
        not_certified_sampled_because: f.sampled.as_ref().err().map(String::as_str),
        certified: f.proof.is_ok(),
        not_certified_because: f.proof.as_ref().err().map(String::as_str),
        largest_eigenvalue: f.design.certified.largest_eigenvalue,
        fit: f
            .model
            .residuals
            .iter()
            .map(|r| FitFigures {
                order: r.order,
                rms_relative_to_variation: r.relative_to_variation,
                rms_relative: r.a.relative_rms,
                largest_norm: r.ab.norms.iter().copied().fold(0.0, f64::max),
                frequency_response: response_figures(
                    (&inputs.vehicle.actuators, inputs.design.states),
                    responses.iter().find(|e| e.order == r.order),
                ),
            })
            .collect(),
        lft_size: f.model.lft.size(),
        lft_error: f.model.lft_error,
        checked_speeds: CHECKED_SPEEDS,
        largest_real_part: f.checks.abscissa_fit,
        largest_real_part_truth: f.checks.abscissa_truth,
        largest_frozen_gain: f.checks.gain_fit,
        largest_frozen_gain_truth: f.checks.gain_truth,
        sampled_radius: f.checks.sampled_radius,
        fastest_controller_mode: f.checks.fastest_controller_mode,
        verdict: &f.verdict,
    }
}
