//! `squid verify`: proves the certificate of an FMU or of a file, in exact arithmetic.
//!
//! Of an FMU it also checks that the certificate speaks of the very controller that the FMU flies.

use crate::error::Error;
use crate::output::read;
use crate::problem_file;
use certificate::{Certificate, Theorem};
use lpv::matrix::to_rows;
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
/// [`Error::Unreadable`], [`Error::NoCertificate`], [`Error::Certificate`], [`Error::Mismatch`], [`Error::Unproved`].
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
    let about =
        format!("{} ({} coefficients), design '{}'", design.vehicle.name, status(&design), design.design);
    Ok(Verified { theorem: certificate.prove()?, about: Some(about) })
}

fn status(design: &ControllerDesign) -> String {
    serde_json::to_value(design.vehicle.status)
        .ok()
        .and_then(|v| v.as_str().map(str::to_owned))
        .unwrap_or_default()
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

/// Checks that a certificate speaks of a frozen controller: the same numbers to the bit, the same bound.
///
/// # Errors
/// [`Error::Mismatch`] with the first part that differs.
pub fn matches(design: &ControllerDesign, certificate: &Certificate) -> Result<(), Error> {
    let (k, c) = (&design.lft, &certificate.controller);
    let pairs = [
        ("A", &k.a, &c.a),
        ("By", &k.by, &c.by),
        ("Bt", &k.bt, &c.bt),
        ("Cu", &k.cu, &c.cu),
        ("Duy", &k.duy, &c.duy),
        ("Dut", &k.dut, &c.dut),
        ("Ct", &k.ct, &c.ct),
        ("Dty", &k.dty, &c.dty),
        ("Dtt", &k.dtt, &c.dtt),
    ];
    if let Some((name, _, _)) = pairs.into_iter().find(|(_, shipped, proved)| !same(shipped, proved)) {
        return Err(Error::Mismatch { what: format!("the controller's matrix {name}") });
    }
    if k.blocks != certificate.controller_blocks {
        return Err(Error::Mismatch { what: "the controller's blocks".into() });
    }
    if design.gamma.bound.to_bits() != certificate.gamma.to_bits() {
        return Err(Error::Mismatch { what: "gamma".into() });
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
    let p = &certificate.plant;
    let pairs = [
        ("A", &plant.a, &p.a),
        ("Bt", &plant.bt, &p.bt),
        ("B1", &plant.b1, &p.b1),
        ("B2", &plant.b2, &p.b2),
        ("Ct", &plant.ct, &p.ct),
        ("C1", &plant.c1, &p.c1),
        ("C2", &plant.c2, &p.c2),
        ("Dtt", &plant.dtt, &p.dtt),
        ("Dt1", &plant.dt1, &p.dt1),
        ("Dt2", &plant.dt2, &p.dt2),
        ("D1t", &plant.d1t, &p.d1t),
        ("D11", &plant.d11, &p.d11),
        ("D12", &plant.d12, &p.d12),
        ("D2t", &plant.d2t, &p.d2t),
        ("D21", &plant.d21, &p.d21),
    ];
    if let Some((name, _, _)) = pairs.into_iter().find(|(_, given, proved)| !same(&to_rows(given), proved)) {
        return Err(Error::WrongPlant { what: format!("matrix {name}") });
    }
    if plant.blocks != certificate.blocks {
        return Err(Error::WrongPlant { what: "blocks".into() });
    }
    Ok(certificate.prove()?)
}

/// Equal to the bit, but for the sign of zero.
fn same(a: &[Vec<f64>], b: &[Vec<f64>]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(p, q)| p == q)
}
