//! `squid lpv check`: whether a certificate is of the plant in a problem file.

use crate::error::Error;
use crate::problem_file::{Problem, finished, problem as read_problem};
use crate::source::Source;
use certificate::Theorem;
use proof::error::ProofError;
use proof::rows::{direct_path, first_unlike, plant_rows};
use proof::text::parse;

/// Proves a certificate and checks that it is of the plant in a problem file.
///
/// # Errors
/// [`ProofError::Unproved`]; [`ProofError::WrongPlant`] with the first matrix of the plant that differs.
pub fn check(problem: &Source, certificate: &Source) -> Result<Theorem, Error> {
    let certificate = parse(&certificate.text, &certificate.name)?;
    let of = &certificate.plant;
    // The file of a finished loop has no matrices of controls and measurements.
    let is_finished = of.c2.is_empty() && of.d12.iter().all(Vec::is_empty);
    let read = if is_finished { finished } else { read_problem };
    let Problem { plant, d22, rate, discrete, limits } = read(problem)?;
    let is_discrete = discrete.is_some();
    let (plant, d22) = discrete.map_or((plant, d22), |given| (given.plant, given.d22));
    if let Some(name) = first_unlike(&plant_rows(&plant).named(), &certificate.plant.named()) {
        return Err(ProofError::WrongPlant { what: format!("matrix {name}") }.into());
    }
    if direct_path(&d22) != certificate.plant.direct_path().cloned().unwrap_or_default() {
        return Err(ProofError::WrongPlant { what: "matrix D22".into() }.into());
    }
    if is_discrete != certificate.discrete {
        return Err(ProofError::WrongPlant { what: "dt".into() }.into());
    }
    if plant.blocks != certificate.blocks {
        return Err(ProofError::WrongPlant { what: "blocks".into() }.into());
    }
    // Without the section, the claim is of any rate.
    let proved_at = certificate.bounded_rate.as_ref().map_or(f64::INFINITY, |claim| claim.rate);
    if rate.map_or(certificate.any_rate.is_none(), |rate| proved_at < rate) {
        return Err(ProofError::WrongPlant { what: "rate".into() }.into());
    }
    let nearer = |limits: &Vec<f64>| {
        // One without claims at the limits is of the plant all the same.
        let Some(energy) = &certificate.energy else { return false };
        energy.limits.len() != limits.len() || energy.limits.iter().zip(limits).any(|(at, limit)| at > limit)
    };
    if limits.as_ref().is_some_and(nearer) {
        return Err(ProofError::WrongPlant { what: "limits".into() }.into());
    }
    Ok(certificate.prove().map_err(ProofError::from)?)
}

/// Proves a certificate.
///
/// # Errors
/// [`ProofError::Unproved`]; [`ProofError::Certificate`] where it cannot be read.
pub fn prove(certificate: &Source) -> Result<Theorem, Error> {
    Ok(parse(&certificate.text, &certificate.name)?.prove().map_err(ProofError::from)?)
}
