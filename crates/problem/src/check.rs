//! `squid lpv check`: whether a certificate is for the plant in a problem file.

use crate::error::Error;
use crate::problem_file::{Problem, finished, problem as read_problem};
use crate::source::Source;
use squid_certificate::Theorem;
use squid_proof::claim::{direct_path_rows, first_difference, parse, plant_rows};
use squid_proof::error::ProofError;

/// Proves a certificate and checks that it is for the plant in a problem file.
///
/// # Errors
/// [`ProofError::Unproved`]; [`ProofError::WrongPlant`] with the first matrix of the plant that differs.
pub fn check(problem: &Source, certificate: &Source) -> Result<Theorem, Error> {
    let certificate = parse(&certificate.text, &certificate.name)?;
    let of = &certificate.plant;
    // The file of a closed loop has no matrices for controls and measurements.
    let is_finished = of.c2.is_empty() && of.d12.iter().all(Vec::is_empty);
    let read = if is_finished { finished } else { read_problem };
    let Problem { plant, d22, rate, discrete } = read(problem)?;
    let is_discrete = discrete.is_some();
    let (plant, d22) = discrete.map_or((plant, d22), |given| (given.plant, given.d22));
    // A certificate without the claim `rate` may hold for any rate.
    let any_rate = certificate.gain().map_or(f64::NEG_INFINITY, |_| f64::INFINITY);
    let proved_at = certificate.rate().map_or(any_rate, |claim| claim.rate);
    let others = [
        ("matrix D22", direct_path_rows(&d22) != of.direct_path().cloned().unwrap_or_default()),
        ("dt", is_discrete != certificate.discrete),
        ("blocks", plant.blocks != certificate.blocks),
        ("rate", rate.map_or(certificate.gain().is_none(), |rate| proved_at < rate)),
    ];
    let matrix =
        first_difference(&plant_rows(&plant).named(), &of.named()).map(|name| format!("matrix {name}"));
    let other = || others.iter().find(|(_, differs)| *differs).map(|(what, _)| (*what).to_owned());
    if let Some(what) = matrix.or_else(other) {
        return Err(ProofError::WrongPlant { what }.into());
    }
    Ok(certificate.prove().map_err(ProofError::from)?)
}

/// Proves a certificate.
///
/// # Errors
/// [`ProofError::Unproved`]; [`ProofError::Certificate`] if it cannot be read.
pub fn prove(certificate: &Source) -> Result<Theorem, Error> {
    Ok(parse(&certificate.text, &certificate.name)?.prove().map_err(ProofError::from)?)
}
