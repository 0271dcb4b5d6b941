//! The controller as C: header and source, with the design and the certificate from which they were written.

use crate::error::Error;
use squid_base::files::{Files, read};
use squid_certificate::Theorem;
use squid_design::certify::claims;
use squid_design::inputs::{Inputs, sha256};
use squid_design::store::Stored;
use squid_embedded::{Real, Source, Standing, export, together};
use squid_fmi2::model_description::identifier;
use squid_scheduled::{ControllerDesign, DEFAULT_DESIGN};
use std::path::{Path, PathBuf};

/// File name of the design next to a source.
pub const CONTROLLER: &str = "controller.json";
/// File name of the certificate next to a source.
pub const CERTIFICATE: &str = "certificate.json";

/// Files of a controller for a directory.
#[derive(Debug)]
pub struct Packed {
    /// All files.
    pub files: Files,
    /// Paths of header and source.
    pub paths: Vec<PathBuf>,
    /// Header and source.
    pub source: Source,
}

/// Returns header and source of an autopilot of several axes, whose own sources are in folders named for the axes, and
/// their paths in `directory`.
pub fn whole(
    inputs: &Inputs,
    axes: &[(&str, ControllerDesign, Source)],
    directory: &Path,
) -> (Files, Vec<PathBuf>) {
    let of_design = &inputs.design.autopilot;
    let of_design = if of_design == DEFAULT_DESIGN { "" } else { of_design };
    let name = identifier(&format!("{} {of_design}", inputs.six_dof.name));
    let all: Vec<_> = axes.iter().map(|(called, design, source)| (*called, design, source)).collect();
    let Source { name, header, source } = together(&name, &all);
    let paths = [format!("{name}.h"), format!("{name}.c")].map(|name| directory.join(name));
    let mut files = Files::default();
    for (path, text) in paths.iter().zip([header, source]) {
        files.add(path.clone(), text);
    }
    (files, paths.into())
}

/// Writes the files of a controller for a directory.
///
/// # Errors
/// [`Error::Export`], and errors of the design.
pub fn pack(
    stored: &Stored,
    proof: &Result<Theorem, String>,
    real: Real,
    directory: &Path,
) -> Result<Packed, Error> {
    let design = &stored.controller;
    let certificate = stored.certificate.as_ref().ok().filter(|_| proof.is_ok());
    let claims = match proof {
        Ok(theorem) => claims::all(design, theorem)
            .into_iter()
            .map(|claim| format!("PROVED in exact arithmetic: {claim}"))
            .chain([limits_of_the_proof()])
            .collect(),
        Err(reason) => vec![format!("UNCERTIFIED: {reason}")],
    };
    let certificate_sha256 = certificate.map(|text| sha256(text));
    let source = export(design, &Standing { claims, certificate_sha256 }, real)?;
    let to = |name: &str| directory.join(name);
    let mut files = Files::default();
    match certificate {
        Some(text) => files.add(to(CERTIFICATE), text.as_str()),
        None => files.remove(to(CERTIFICATE)),
    }
    files.add(to(CONTROLLER), design.to_json()?);
    let paths = ["h", "c"].map(|ending| to(&format!("{}.{ending}", source.name)));
    files.add(paths[0].clone(), source.header.as_str());
    files.add(paths[1].clone(), source.source.as_str());
    Ok(Packed { files, paths: paths.into(), source })
}

/// Returns a statement of what no claim of a certificate covers.
fn limits_of_the_proof() -> String {
    "This applies to the controller in continuous time and to linear models. Claims about the sampled loop are in \
     sampled_certificate.json of the design; rounding, other saturation and the nonlinear vehicle are not covered."
        .to_owned()
}

/// Checks that a source and its header are those written for a design and the text of its certificate.
///
/// # Errors
/// [`Error::Source`], [`Error::Export`], and errors of reading the header.
pub(crate) fn compare(
    path: &Path,
    source: &str,
    design: &ControllerDesign,
    certificate: &str,
) -> Result<(), Error> {
    let header_path = path.with_extension("h");
    let header = read(&header_path)?;
    let is_of = |real: &Real| header.contains(&format!("typedef {} ", real.name()));
    let real = Real::ALL.into_iter().find(is_of).unwrap_or(Real::Double);
    let standing = Standing { claims: vec![], certificate_sha256: Some(sha256(certificate)) };
    let expected = export(design, &standing, real)?;
    let pairs =
        [(&header_path, header.as_str(), &expected.header), (&path.to_path_buf(), source, &expected.source)];
    pairs.into_iter().try_for_each(|(path, found, expected)| {
        squid_embedded::compare(found, expected)
            .map_err(|reason| Error::Source { path: path.display().to_string(), reason })
    })
}
