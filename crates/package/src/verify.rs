//! Proves the certificate of an FMU or of a file, in exact arithmetic.
//!
//! For an FMU it also checks that the certificate belongs to the controller in the FMU and, given vehicle and design
//! file, that plant, ball and all other resources of the FMU follow from them. Other files are compared with those that
//! this version of squid packs.

use crate::archive::FmuArchive;
use crate::c::{self, CONTROLLER};
use crate::contents::Contents;
use crate::coupling;
use crate::error::Error;
use crate::kind::Kind;
use crate::page::{Given, page};
use squid_auv::LpvModel;
use squid_base::files::{self, read};
use squid_certificate::{Certificate, Theorem};
use squid_design::axis::several;
use squid_design::certify::claims::{Terms, lines, unproved};
use squid_design::certify::limits::{ClaimedStep, check_autopilot};
use squid_design::certify::sampled;
use squid_design::certify::verify::{check_design, check_inputs, same_controller};
use squid_design::fit::Model;
use squid_design::inputs::Inputs;
use squid_design::store::{Stored, freeze};
use squid_design::synthesise::robust::stored;
use squid_fmi2::Resources;
use squid_fmu_controller::of_axis;
use squid_proof::claim::parse;
use squid_scheduled::{ControllerDesign, Manoeuvre};
use std::io::{self, Read};
use std::path::Path;

/// Statement of what only vehicle and design file can verify.
const NOT_RECOMPUTED: &str = "not verified without --vehicle: scales, trims, limits of commands and references, and \
                              the vehicle and manoeuvre of a closed loop";

/// Returns the claims in the units that a controller file declares, for scales that are not verified.
fn claims_as_declared(terms: &Terms, theorem: &Theorem) -> String {
    let claims = lines(theorem, Some(terms)).join("; ");
    format!("with the scales in {CONTROLLER}, which are not verified without --vehicle: {claims}")
}

/// Result of verifying a file.
#[derive(Debug, Clone)]
pub struct Verification {
    /// Result for each axis, at least one.
    pub axes: Vec<Verified>,
    /// Claim proved for both axes in turns.
    pub coupling: Option<String>,
    /// Statements about the file besides its axes.
    pub about: Vec<String>,
    /// Files in an FMU that the proof does not cover.
    pub contents: Contents,
}

impl From<Verified> for Verification {
    fn from(first: Verified) -> Self {
        Self { axes: vec![first], coupling: None, about: vec![], contents: Contents::default() }
    }
}

/// Result of verifying an axis.
#[derive(Debug, Clone)]
pub struct Verified {
    /// Quantity that the axis steers; empty if the file does not state it.
    pub axis: String,
    /// Proved theorem.
    pub theorem: Theorem,
    /// Name of vehicle and design if the file states it, and statements of what was recomputed.
    pub about: Vec<String>,
    /// Proved claims, one per line.
    pub lines: Vec<String>,
    /// Statement of what is not proved for saturated commands.
    pub unproved: Option<String>,
    /// Largest step covered by the claim with limits, if its unit is known.
    pub step: Option<ClaimedStep>,
}

/// Verifies an FMU (by its extension) or a JSON certificate, against vehicle and design file if given.
///
/// # Errors
/// [`files::Error::Unreadable`], [`Error::Archive`], [`Error::NoCertificate`],
/// [`ProofError::Certificate`](squid_proof::error::ProofError::Certificate),
/// [`ProofError::Mismatch`](squid_proof::error::ProofError::Mismatch),
/// [`CertifyError::NoResidual`](squid_design::error::CertifyError::NoResidual), [`Error::WrongGuid`],
/// [`Error::NotOfInputs`], [`Error::OtherAxes`], [`ProofError::Unproved`](squid_proof::error::ProofError::Unproved).
pub fn verify(path: &Path, given: Option<Given<'_>>) -> Result<Verification, Error> {
    let name = path.display().to_string();
    let inputs = given.map(|given| given.inputs);
    let found = if is_archive(path)? {
        verify_fmu(path, given)
    } else {
        let one = inputs.map(|inputs| match inputs {
            [one] => Ok(*one),
            _ => Err(other_axes(&name, "one axis", inputs)),
        });
        one.transpose().and_then(|one| verify_certificate(path, one).map(Verification::from))
    };
    found.map_err(|reason| {
        if reason.to_string().starts_with(&name) {
            reason
        } else {
            Error::InFile { path: name, reason: Box::new(reason) }
        }
    })
}

/// Verifies the source of a controller against the certificate and the design next to it, and these against vehicle and
/// design file if given.
///
/// # Errors
/// [`Error::NotBeside`], [`Error::Source`], and those of [`verify`].
pub fn verify_source(path: &Path, inputs: Option<&Inputs>) -> Result<Verified, Error> {
    let beside = |name: &str| {
        let path = path.with_file_name(name);
        if path.is_file() {
            Ok(read(&path)?)
        } else {
            Err(Error::NotBeside { path: path.display().to_string() })
        }
    };
    let source = read(path)?;
    let design = ControllerDesign::from_json(&beside(CONTROLLER)?)?;
    let text = beside(c::CERTIFICATE)?;
    let certificate = parse(&text, &path.with_file_name(c::CERTIFICATE).display().to_string())?;
    check_design(&design, &certificate)?;
    let theorem = certificate.prove()?;
    check_autopilot(&design, &certificate)?;
    c::compare(path, &source, &design, &text)?;
    let shown = path.display();
    let mut about = vec![format!(
        "{shown}: every number follows from the controller of the certificate by the trapezoidal rule at {} s \
         (recomputed in floating point), and the rest is the source that squid writes for {} next to it; comments \
         are not compared",
        design.sample_time, CONTROLLER
    )];
    let manoeuvre = inputs.map(|inputs| &inputs.design.manoeuvre);
    let terms = Terms::of(&design, &theorem, manoeuvre);
    let mut verified = Verified::in_terms(&design, theorem, terms, inputs.is_some());
    if let Some(inputs) = inputs {
        check_follows_from(design, text, None, inputs)
            .map_err(|reason| Error::NotOfInputs { path: shown.to_string(), reason })?;
        about.push(format!("{} follows from {}", CONTROLLER, named(inputs)));
    }
    verified.about.splice(..0, about);
    Ok(verified)
}

impl Verified {
    /// Returns the claims of a controller file, in its own units if these are checked, else in those of its
    /// certificate.
    fn in_terms(design: &ControllerDesign, theorem: Theorem, terms: Terms, checked: bool) -> Self {
        let axis = design.steered_signal();
        let unproved = unproved(&theorem, &terms);
        let (lines, about, step) = if checked {
            (lines(&theorem, Some(&terms)), vec![], ClaimedStep::of(design, &theorem))
        } else {
            (lines(&theorem, None), vec![NOT_RECOMPUTED.into(), claims_as_declared(&terms, &theorem)], None)
        };
        Self { axis, theorem, about, lines, unproved, step }
    }
}

/// Returns `true` if a file starts as a zip does, or has the extension of an FMU.
fn is_archive(path: &Path) -> Result<bool, Error> {
    let unreadable = |reason| files::Error::Unreadable { path: path.display().to_string(), reason };
    let mut start = Vec::new();
    if path.is_dir() {
        let hint = "this is a directory; give an FMU or a certificate.json (the directory of a vehicle is given with \
            --vehicle)";
        return Err(unreadable(io::Error::new(io::ErrorKind::IsADirectory, hint)).into());
    }
    files::open(path)?.take(2).read_to_end(&mut start).map_err(unreadable)?;
    Ok(start == b"PK" || path.extension().is_some_and(|e| e.eq_ignore_ascii_case("fmu")))
}

fn verify_certificate(path: &Path, inputs: Option<&Inputs>) -> Result<Verified, Error> {
    let certificate = parse(&read(path)?, &path.display().to_string())?;
    let theorem = certificate.prove()?;
    let (mut about, mut step, mut terms) = (vec![], None, None);
    if let Some(inputs) = inputs {
        let of_plant = |about| {
            Ok(Verified {
                axis: String::new(),
                lines: lines(&theorem, None),
                unproved: None,
                theorem: theorem.clone(),
                about,
                step: None,
            })
        };
        let (vehicle, design) = (&inputs.axis(), &inputs.design);
        let model = Model::new(vehicle, design)?;
        if let Some(found) = stored::check_inputs(&certificate, inputs, &model)? {
            return of_plant(describe_uncertain(path, &certificate, inputs, &found)?);
        }
        if sampled::check_inputs(&certificate, vehicle, design, &model)?.is_some() {
            return of_plant(describe_sampled(path, &certificate, inputs)?);
        }
        step = ClaimedStep::of_file(design, &theorem);
        terms = Some(Terms::of_file(design, &theorem));
        check_inputs(&certificate, vehicle, design, &model)?;
        let what = match certificate.model_error() {
            Some(_) => "its plant and its ball of models are those",
            None => "its plant is that (without the residual between the fit and the true linearisations)",
        };
        about.push(format!("{}: {what} of {}", path.display(), named(inputs)));
    }
    let unproved = terms.as_ref().and_then(|terms| unproved(&theorem, terms));
    let lines = lines(&theorem, terms.as_ref());
    Ok(Verified { axis: String::new(), lines, unproved, theorem, about, step })
}

/// Returns statements about a certificate with uncertain parameters whose plant is that of the inputs.
fn describe_uncertain(
    path: &Path,
    certificate: &Certificate,
    inputs: &Inputs,
    found: &stored::CoveredUncertainty,
) -> Result<Vec<String>, Error> {
    let shown = path.display();
    let plant = format!(
        "{shown}: its plant is the uncertain model of {}, for {:.1} % of {}, which like the speed may change \
         arbitrarily fast; the error of this model relative to the vehicle is not covered",
        named(inputs),
        100.0 * found.fraction,
        found.declared
    );
    let controller = compare_controller(path, |design| {
        same_controller(&design.lft, certificate)?;
        Ok(String::new())
    })?;
    Ok(vec![plant, controller])
}

/// Compares the controller next to a certificate, if there is one; `same` returns further text about it.
fn compare_controller(
    path: &Path,
    same: impl FnOnce(&ControllerDesign) -> Result<String, Error>,
) -> Result<String, Error> {
    let (shown, beside) = (path.display(), path.with_file_name(CONTROLLER));
    if !beside.is_file() {
        return Ok(format!(
            "{shown}: its controller was not compared, because {CONTROLLER} is missing in its directory"
        ));
    }
    let more = same(&ControllerDesign::from_json(&read(&beside)?)?)?;
    Ok(format!("{shown}: its controller is that of {CONTROLLER} in the same directory{more}"))
}

/// Returns statements about a certificate of the sampled loop whose plant is that of the inputs.
fn describe_sampled(path: &Path, certificate: &Certificate, inputs: &Inputs) -> Result<Vec<String>, Error> {
    let (shown, tick) = (path.display(), inputs.design.sample_time);
    let plant = format!(
        "{shown}: its plant is that of {}, discretised by the trapezoidal rule at {tick} s; the proof holds for the \
         sampled loop with the fit discretised in this way, for every speed that is constant between ticks",
        named(inputs)
    );
    let controller = compare_controller(path, |design| {
        let ticks = inputs.design.delay_ticks();
        sampled::check_controller(design, ticks, certificate)?;
        Ok(format!(", with a delay of {ticks} ticks"))
    })?;
    Ok(vec![plant, controller])
}

fn verify_fmu(path: &Path, given: Option<Given<'_>>) -> Result<Verification, Error> {
    let archive = FmuArchive::read(path)?;
    let resources = &archive.resources;
    let of_path = || path.display().to_string();
    let has = |axis: usize| resources.bytes(&of_axis(CONTROLLER, axis)).is_ok();
    let axes = (1..).take_while(|axis| has(*axis)).count() + 1;
    let proved: Vec<Proved> =
        (0..axes).map(|axis| Proved::read(path, resources, axis)).collect::<Result<_, _>>()?;
    let (kind, (guid, xml, description)) = match resources.text(squid_fmu_plant::VEHICLE_RESOURCE) {
        Ok(_) => {
            (Kind::Squid, squid_fmu_loop::describe(resources).map(|of| (of.guid, of.xml, of.description))?)
        }
        Err(_) => (
            Kind::Controller,
            squid_fmu_controller::describe(resources).map(|of| (of.guid, of.xml, of.description))?,
        ),
    };
    if guid != archive.guid {
        return Err(Error::WrongGuid { path: of_path() });
    }
    if xml.as_bytes() != archive.description {
        return Err(Error::WrongDescription { path: of_path() });
    }
    let inputs = given.map(|given| given.inputs);
    let names = |all: &[Proved]| all.iter().map(|one| one.design.steered_signal()).collect::<Vec<_>>();
    if let Some(inputs) = inputs.filter(|inputs| inputs.len() != proved.len()) {
        return Err(other_axes(&of_path(), &names(&proved).join(" and "), inputs));
    }
    let not_of_inputs = |reason| Error::NotOfInputs { path: of_path(), reason };
    let manoeuvre = resources.text("manoeuvre.json").ok().and_then(|text| Manoeuvre::from_json(text).ok());
    let owned: Vec<ControllerDesign> = proved.iter().map(|proved| proved.design.clone()).collect();
    let controllers: Vec<&ControllerDesign> = owned.iter().collect();
    let axis = |(index, proved): (usize, Proved)| {
        let Proved { design, text, certificate, theorem, covered } = proved;
        check_autopilot(&design, &certificate)?;
        let inputs = inputs.and_then(|inputs| inputs.get(index).copied());
        let flown = manoeuvre.as_ref().or(inputs.map(|inputs| &inputs.design.manoeuvre));
        let terms = Terms::of(&design, &theorem, flown);
        let mut verified = Verified::in_terms(&design, theorem, terms, inputs.is_some());
        verified.about.insert(0, covered);
        if let Some(inputs) = inputs {
            check_follows_from(design, text, resources.text("plant.json").ok(), inputs)
                .map_err(not_of_inputs)?;
            verified.about.push(format!(
                "the proved controller and all other resources, including the limits of its references, follow from \
                 {}",
                named(inputs)
            ));
        }
        Ok::<_, Error>(verified)
    };
    let axes: Vec<Verified> = proved.into_iter().enumerate().map(axis).collect::<Result<_, _>>()?;
    // Compared after the axes, because a change of the design files is reported as such first.
    inputs.map_or(Ok(()), |inputs| same_files(resources, inputs)).map_err(not_of_inputs)?;
    let (coupling, about) = coupling::verify(path, resources, &controllers, inputs)?;
    let proofs: Vec<&Theorem> = axes.iter().map(|axis| &axis.theorem).collect();
    let page = given.and_then(|given| page(path, kind, (given, &controllers), &proofs, coupling.as_deref()));
    let contents = Contents::of(archive, (kind, &description), &controllers, page)
        .map_err(|reason| files::Error::Unreadable { path: of_path(), reason })?;
    Ok(Verification { axes, coupling, about: about.into_iter().collect(), contents })
}

/// An axis of an FMU with a proved certificate that belongs to its controller.
struct Proved {
    design: ControllerDesign,
    /// Text of the certificate.
    text: String,
    certificate: Certificate,
    theorem: Theorem,
    /// Statement of vehicle and design, and of the coverage of a model error.
    covered: String,
}

impl Proved {
    fn read(path: &Path, resources: &Resources, axis: usize) -> Result<Self, Error> {
        let [controller, certificate] = [CONTROLLER, c::CERTIFICATE].map(|name| of_axis(name, axis));
        let resource = |name: String| {
            let missing = Error::NoCertificate { path: path.display().to_string(), name: name.clone() };
            resources.text(&name).map_err(|_| missing)
        };
        let file = format!("{}, resources/{certificate}", path.display());
        let design = ControllerDesign::from_json(resource(controller)?)?;
        let text = resource(certificate)?.to_owned();
        let certificate = parse(&text, &file)?;
        check_design(&design, &certificate)?;
        let coverage = match certificate.model_error() {
            Some(_) => "for the fit, and for a ball of models around it",
            None => {
                "for the fit only; the residual between the fit and the true linearisations is not covered"
            }
        };
        let covered = format!(
            "{} ({} coefficients), design '{}': {coverage}",
            design.vehicle.name,
            design.vehicle.status.word(),
            design.design
        );
        let theorem = certificate.prove()?;
        Ok(Self { design, text, certificate, theorem, covered })
    }
}

/// Returns a text that names the vehicle and design used for a comparison.
pub fn named(inputs: &Inputs) -> String {
    let directory = inputs.directory.display();
    format!("vehicle.toml and design '{}' in {directory} (recomputed in floating point)", inputs.design.name)
}

/// Returns the error for a file whose axes are not those of a design.
fn other_axes(path: &str, found: &str, inputs: &[&Inputs]) -> Error {
    let design = inputs.first().map(|one| one.design.file.clone()).unwrap_or_default();
    let axes: Vec<&str> = inputs.iter().map(|one| one.design.steered_signal()).collect();
    Error::OtherAxes { path: path.into(), found: found.into(), design, axes: axes.join(" and ") }
}

/// Checks that vehicle and manoeuvre of an FMU are those of the files.
fn same_files(resources: &Resources, inputs: &[&Inputs]) -> Result<(), String> {
    let Some((vehicle, manoeuvre)) = several::vehicle(inputs).zip(several::manoeuvre(inputs)) else {
        return Ok(());
    };
    let texts = [
        (squid_fmu_plant::VEHICLE_RESOURCE, vehicle.to_json().map_err(|e| e.to_string())?),
        ("manoeuvre.json", manoeuvre.to_json().map_err(|e| e.to_string())?),
    ];
    match texts.iter().find(|(name, text)| resources.text(name).is_ok_and(|found| found != text)) {
        Some((name, _)) => Err(format!("resources/{name} differs")),
        None => Ok(()),
    }
}

/// Checks that an axis, with the LPV model next to it, follows from vehicle and design file and the controller's
/// matrices, and that the certificate is that of their plant, as required before packing an FMU.
fn check_follows_from(
    controller: ControllerDesign,
    certificate: String,
    plant: Option<&str>,
    inputs: &Inputs,
) -> Result<(), String> {
    if let Some(what) = inputs.changed_since(&controller.inputs) {
        return Err(format!("{what} differs from the one used for the design (SHA-256)"));
    }
    // The LPV model is that of surge, heave and pitch.
    let plant = match plant.filter(|_| !inputs.design.view().is_level_held) {
        Some(text) => Some(LpvModel::from_json(text, "plant.json").map_err(|e| e.to_string())?),
        None => {
            let model = Model::new(&inputs.axis(), &inputs.design).map_err(|e| e.to_string())?;
            let (lft, gamma) = (controller.lft.clone(), controller.gamma.clone());
            freeze::frozen(inputs, &model, lft, gamma).map_err(|e| e.to_string())?.plant
        }
    };
    let manoeuvre = inputs.design.manoeuvre.clone();
    let certificate = Ok(certificate);
    let (sampled, robust, rows, coupling) = Default::default();
    let stored = Stored { controller, plant, manoeuvre, certificate, sampled, robust, rows, coupling };
    stored.prove(inputs).map(|_| ())
}
