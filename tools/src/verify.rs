//! `squid verify`: proves the certificate of an FMU or of a file, in exact arithmetic.
//!
//! Of an FMU it also checks that the certificate speaks of the very controller that the FMU flies.

use crate::certify::{frozen_rows, plant_rows};
use crate::error::Error;
use crate::inputs::Inputs;
use crate::model::Model;
use crate::model_ball;
use crate::output::read;
use crate::problem::augment;
use crate::problem_file;
use certificate::{Certificate, Rows, Theorem};
use fmi2::Resources;
use lpv::matrix::{Mat, from_rows};
use lpv::plant::GeneralisedPlant;
use scheduled::ControllerDesign;
use std::io::Read;
use std::path::Path;

/// What was verified.
#[derive(Debug, Clone)]
pub struct Verified {
    /// The theorem.
    pub theorem: Theorem,
    /// Name of vehicle and design, when the file says so.
    pub about: Option<String>,
}

/// Verifies an FMU (by its ending) or a certificate as JSON.
///
/// # Errors
/// [`Error::Unreadable`], [`Error::NoCertificate`], [`Error::Certificate`], [`Error::Mismatch`], [`Error::NoResidual`],
/// [`Error::Unproved`].
pub fn verify(path: &Path) -> Result<Verified, Error> {
    if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("fmu")) {
        return verify_fmu(path);
    }
    let certificate = parse(&read(path)?, &path.display().to_string())?;
    Ok(Verified { theorem: certificate.prove()?, about: None })
}

/// Reads a certificate; `file` is for messages.
///
/// # Errors
/// [`Error::Certificate`].
pub fn parse(text: &str, file: &str) -> Result<Certificate, Error> {
    Certificate::from_json(text).map_err(|reason| Error::Certificate { file: file.into(), reason })
}

fn verify_fmu(path: &Path) -> Result<Verified, Error> {
    let controller_text = resource(path, "controller.json")?;
    let design = ControllerDesign::from_json(&controller_text)?;
    let name = format!("{}, resources/certificate.json", path.display());
    let certificate = parse(&resource(path, "certificate.json")?, &name)?;
    matches(&design, &certificate)?;
    let coverage = match certificate.residual {
        Some(_) => "for the fit, and for a ball of models around it (residual)",
        None => "for the fit alone; nothing about the residual between the fit and the true linearisations",
    };
    let about = format!(
        "{} ({} coefficients), design '{}': {coverage}",
        design.vehicle.name,
        status(&design),
        design.design
    );
    let theorem = certificate.prove()?;
    unchanged(path)?;
    Ok(Verified { theorem, about: Some(about) })
}

fn status(design: &ControllerDesign) -> String {
    serde_json::to_value(design.vehicle.status)
        .ok()
        .and_then(|v| v.as_str().map(str::to_owned))
        .unwrap_or_default()
}

/// Asserts that the GUID in the XML is the one of the resources, scales, trims and limits of the controller included.
fn unchanged(path: &Path) -> Result<(), Error> {
    let zip_error = |reason| Error::Zip { path: path.display().to_string(), reason };
    let unreadable = |reason| Error::Unreadable { path: path.display().to_string(), reason };
    let mut archive =
        zip::ZipArchive::new(std::fs::File::open(path).map_err(unreadable)?).map_err(zip_error)?;
    let (mut resources, mut xml) = (Resources::default(), String::new());
    for index in 0..archive.len() {
        let mut entry = archive.by_index(index).map_err(zip_error)?;
        let name = entry.name().map_err(zip_error)?.into_owned();
        if name == "modelDescription.xml" {
            entry.read_to_string(&mut xml).map_err(unreadable)?;
        } else if let Some(resource) = name.strip_prefix("resources/").filter(|rest| !rest.is_empty()) {
            let mut bytes = Vec::new();
            entry.read_to_end(&mut bytes).map_err(unreadable)?;
            resources.insert(resource, bytes);
        }
    }
    let guid = match resources.text(fmu_plant::VEHICLE_RESOURCE) {
        Ok(_) => fmu_squid::describe(&resources)?.guid,
        Err(_) => fmu_controller::describe(&resources)?.guid,
    };
    match xml.contains(&format!("guid=\"{guid}\"")) {
        true => Ok(()),
        false => Err(Error::WrongGuid { path: path.display().to_string() }),
    }
}

/// One file of an FMU's resources.
fn resource(path: &Path, name: &str) -> Result<String, Error> {
    let unreadable = |reason| Error::Unreadable { path: path.display().to_string(), reason };
    let file = std::fs::File::open(path).map_err(unreadable)?;
    let zip_error = |reason| Error::Zip { path: path.display().to_string(), reason };
    let mut archive = zip::ZipArchive::new(file).map_err(zip_error)?;
    let mut entry = match archive.by_name(&format!("resources/{name}")) {
        Ok(entry) => entry,
        Err(zip::result::ZipError::FileNotFound) => {
            return Err(Error::NoCertificate { path: path.display().to_string(), name: name.into() });
        }
        Err(other) => return Err(zip_error(other)),
    };
    let mut text = String::new();
    entry.read_to_string(&mut text).map_err(unreadable)?;
    Ok(text)
}

/// Checks that a certificate speaks of a frozen controller: the same numbers to the bit, the same bound, and of all that the mark
/// `certified` stands for. No design is marked without a bound that covers the fit's residual ([`crate::certify::certify`]), so that
/// where the mark is, the section `residual` must be.
///
/// # Errors
/// [`Error::Mismatch`] with the first part that differs; [`Error::NoResidual`].
pub fn matches(design: &ControllerDesign, certificate: &Certificate) -> Result<(), Error> {
    let shipped = frozen_rows(&design.lft);
    if let Some(name) = first_unlike(&shipped.named(), &certificate.controller.named()) {
        return Err(Error::Mismatch { what: format!("the controller's matrix {name}") });
    }
    if design.lft.blocks != certificate.controller_blocks {
        return Err(Error::Mismatch { what: "the controller's blocks".into() });
    }
    if design.gamma.bound.to_bits() != certificate.gamma.to_bits() {
        return Err(Error::Mismatch { what: "gamma".into() });
    }
    if design.gamma.certified && certificate.residual.is_none() {
        return Err(Error::NoResidual);
    }
    Ok(())
}

/// Proves a certificate and checks that it is of the plant in a problem file.
///
/// # Errors
/// As [`verify`]; [`Error::Mismatch`] with the first matrix of the plant that differs.
pub fn check(problem: &Path, certificate: &Path) -> Result<Theorem, Error> {
    let plant = problem_file::plant(problem)?;
    let certificate = parse(&read(certificate)?, &certificate.display().to_string())?;
    if let Some(name) = first_unlike(&plant_rows(&plant).named(), &certificate.plant.named()) {
        return Err(Error::WrongPlant { what: format!("matrix {name}") });
    }
    if plant.blocks != certificate.blocks {
        return Err(Error::WrongPlant { what: "blocks".into() });
    }
    Ok(certificate.prove()?)
}

/// Checks that the plant in a certificate is the one of these inputs: trimmed, linearised, fitted and weighted anew, and compared
/// at parameter values over the range, because the basis of an LFT's channels is not unique; and that its ball holds the true linearisations.
///
/// # Errors
/// [`Error::WrongPlant`] with the first part that differs; [`Error::Ball`]; the errors of [`augment`].
pub fn matches_inputs(certificate: &Certificate, inputs: &Inputs, model: &Model) -> Result<(), Error> {
    let wanted = augment(inputs, model.lft.clone())?;
    let found =
        plant_of(certificate).ok_or_else(|| Error::WrongPlant { what: "the shape of a matrix".into() })?;
    found.check()?;
    for rho in [-1.0, -0.6, -0.1, 0.3, 0.8, 1.0] {
        let (a, b) = (wanted.frozen(&[rho])?, found.frozen(&[rho])?);
        let pairs = [
            ("A", a.a, b.a),
            ("B1", a.b1, b.b1),
            ("B2", a.b2, b.b2),
            ("C1", a.c1, b.c1),
            ("D11", a.d11, b.d11),
            ("D12", a.d12, b.d12),
            ("C2", a.c2, b.c2),
            ("D21", a.d21, b.d21),
        ];
        let unlike =
            |p: &Mat, q: &Mat| p.shape() != q.shape() || (p - q).amax() > SAME_PLANT * p.amax().max(1.0);
        if let Some((name, _, _)) = pairs.into_iter().find(|(_, p, q)| unlike(p, q)) {
            return Err(Error::WrongPlant { what: format!("matrix {name} at rho = {rho}") });
        }
    }
    certificate.residual.as_ref().map_or(Ok(()), |ball| model_ball::holds(ball, inputs, model))
}

/// How far the plant of a certificate may be from the one computed anew: rounding on another processor.
const SAME_PLANT: f64 = 1e-8;

/// The plant of a certificate; `None` when its matrices are ragged.
fn plant_of(certificate: &Certificate) -> Option<GeneralisedPlant> {
    let p = &certificate.plant;
    let (n, w, u) = (p.a.len(), p.b1.first()?.len(), p.b2.first()?.len());
    let r = certificate.blocks.iter().sum();
    Some(GeneralisedPlant {
        a: from_rows(&p.a, n)?,
        bt: from_rows(&p.bt, r)?,
        b1: from_rows(&p.b1, w)?,
        b2: from_rows(&p.b2, u)?,
        ct: from_rows(&p.ct, n)?,
        dtt: from_rows(&p.dtt, r)?,
        dt1: from_rows(&p.dt1, w)?,
        dt2: from_rows(&p.dt2, u)?,
        c1: from_rows(&p.c1, n)?,
        d1t: from_rows(&p.d1t, r)?,
        d11: from_rows(&p.d11, w)?,
        d12: from_rows(&p.d12, u)?,
        c2: from_rows(&p.c2, n)?,
        d2t: from_rows(&p.d2t, r)?,
        d21: from_rows(&p.d21, w)?,
        blocks: certificate.blocks.clone(),
    })
}

/// The name of the first matrix that differs in any bit, but for the sign of zero.
fn first_unlike(a: &[(&'static str, &Rows)], b: &[(&'static str, &Rows)]) -> Option<&'static str> {
    a.iter().zip(b).find(|((_, p), (_, q))| p != q).map(|((name, _), _)| *name)
}
