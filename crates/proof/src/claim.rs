//! Certificates of plants, controllers and bounds: matrices, claims with and without model error, and text.

use crate::error::ProofError;
use crate::rate::{rate, with_error};
use squid_certificate::{
    Certificate, Claim, Controller as ControllerRows, Gain, Multipliers, Plant, Rows, Theorem,
};
use squid_lpv::analysis::GainBound;
use squid_lpv::analysis::bounded_gain::{with_raised_gamma, without_error};
use squid_lpv::controller::Controller;
use squid_lpv::matrix::{Mat, from_rows, to_rows};
use squid_lpv::model_error::{LoopError, ModelError};
use squid_lpv::partition::{self, CONTROLLER, NamedBlock, Names, Partitioned};
use squid_lpv::plant::{ClosedLoop, GeneralisedPlant};
use squid_lpv::synthesis::{Design, DualMultipliers};
use std::path::Path;

/// Certificate with the theorem that it proves.
#[derive(Debug, Clone)]
pub struct Proof {
    /// Certificate.
    pub certificate: Certificate,
    /// Theorem proved by the certificate.
    pub theorem: Theorem,
    /// Size of the covered model error, in the coordinates of [`ModelError`]; `None` if none is covered.
    pub model_error: Option<f64>,
}

/// Returns a certificate with plant and controller, without claims.
pub fn without_claims(plant: &GeneralisedPlant, k: &Controller) -> Certificate {
    Certificate {
        blocks: plant.blocks.clone(),
        controller_blocks: k.blocks.clone(),
        plant: plant_rows(plant),
        controller: controller_rows(k),
        ..Certificate::default()
    }
}

/// Returns the certificate of a bound without model error: plant, controller, gamma, X or V, S and T.
pub fn nominal(plant: &GeneralisedPlant, k: &Controller, bound: &GainBound) -> Certificate {
    Certificate { claims: vec![gain(bound, None)], ..without_claims(plant, k) }
}

/// Returns the claim of a bound; with `lambda`, for the model error.
fn gain(bound: &GainBound, lambda: Option<f64>) -> Claim {
    let v = bound.factor.as_ref().filter(|_| lambda.is_none()).map(to_rows);
    let x = if v.is_some() { None } else { Some(to_rows(&bound.x)) };
    Claim::Gain(Gain { gamma: bound.gamma, lambda, x, v, s: to_rows(&bound.s), t: to_rows(&bound.t) })
}

/// Proves the bound of a design for its plant, the bound `covered` for a model error of size `size`, and the bound for
/// a bounded rate, if the design has one; returns the proved bound for the plant, too. `closed` and `closed_error` are
/// the loop and the error with the controller of the design.
///
/// Delta = 0 is among the model errors, so that `covered` also bounds the gain of the plant alone; where it is the
/// smaller bound, it takes the place of that of the design.
///
/// # Errors
/// [`ProofError::Unproved`] with the first failed check; [`ProofError::Synthesis`] if no bound at the rate covers the
/// model error.
pub fn with_model_error(
    plant: &GeneralisedPlant,
    design: &Design,
    error: &ModelError,
    size: f64,
    closed: &ClosedLoop,
    closed_error: &LoopError,
    covered: &GainBound,
) -> Result<(Proof, GainBound), ProofError> {
    let proved = |covered: &GainBound| -> Result<(Proof, GainBound), ProofError> {
        let alone = if covered.gamma < design.certified.gamma {
            without_error(closed, covered)
        } else {
            design.certified.clone()
        };
        let mut certificate = nominal(plant, &design.controller, &alone);
        certificate.errors = vec![squid_certificate::ModelError {
            e: to_rows(&error.e),
            f: to_rows(&error.f),
            fw: to_rows(&error.fw),
            fu: to_rows(&error.fu),
        }];
        certificate.claims.push(gain(covered, Some(covered.lambda)));
        if let Some(slow) = &design.slow {
            let covered = with_error(closed, closed_error, slow, covered.lambda)?;
            certificate.claims.extend([rate(slow, None), covered]);
        }
        let theorem = certificate.prove()?;
        Ok((Proof { certificate, theorem, model_error: Some(size) }, alone))
    };
    // A tight bound can fail by rounding; gamma is then raised slightly.
    proved(covered).or_else(|reason| {
        with_raised_gamma(closed, closed_error, covered).map_or(Err(reason), |clear| proved(&clear))
    })
}

/// Returns a lower bound on the gain of any controller, from the first multipliers that prove one; better multipliers
/// may violate an inequality by rounding.
pub fn lower_bound(plant: &GeneralisedPlant, multipliers: &[DualMultipliers]) -> Option<f64> {
    let rows = plant_rows(plant);
    multipliers.iter().find_map(|m| {
        let guess = Multipliers {
            primal: to_rows(&m.primal),
            dual: to_rows(&m.dual),
            coupling: (to_rows(&m.coupling.0), to_rows(&m.coupling.1)),
        };
        squid_certificate::lower_bound(&rows, &guess)
    })
}

/// Converts a plant to the form of the certificate.
pub fn plant_rows(p: &GeneralisedPlant) -> Plant {
    let mut out = Plant::default();
    out.named_mut().into_iter().for_each(|(key, rows)| *rows = rows_of(&p.parts, key));
    out
}

fn rows_of(parts: &Partitioned, key: &str) -> Rows {
    parts.named(key).map_or_else(Vec::new, |m| to_rows(&m))
}

/// Converts a direct path from u to y to the form of the certificate: no rows if it is 0.
pub fn direct_path_rows(d22: &Mat) -> Rows {
    if d22.iter().all(|entry| *entry == 0.0) { vec![] } else { to_rows(d22) }
}

/// Converts a controller to the form of the certificate.
pub fn controller_rows(k: &Controller) -> ControllerRows {
    let mut out = ControllerRows::default();
    out.named_mut().into_iter().for_each(|(key, rows)| *rows = rows_of(&k.parts, key));
    out
}

/// Returns the controller with these matrices; `None` if their sizes do not agree.
pub fn controller(blocks: &[usize], rows: &ControllerRows) -> Option<Controller> {
    Controller::new(blocks.to_vec(), &blocks_of(CONTROLLER, &rows.named())?).ok()
}

/// Returns the blocks of a partition, from matrices with their keys; `None` if a matrix is ragged or has an unknown
/// key. Matrices without rows are omitted.
pub fn blocks_of(names: Names, matrices: &[(&'static str, &Rows)]) -> Option<Vec<NamedBlock>> {
    let given = matrices.iter().filter(|(_, rows)| !rows.is_empty());
    let block = |(key, rows): &(&'static str, &Rows)| {
        let (_, row, column) = partition::names(names).find(|(name, _, _)| name == key)?;
        Some((row, column, from_rows(rows, rows.first()?.len())?))
    };
    given.map(block).collect()
}

/// Returns the name of the first matrix that differs in any bit; the sign of zero is ignored.
pub fn first_difference(a: &[(&'static str, &Rows)], b: &[(&'static str, &Rows)]) -> Option<&'static str> {
    a.iter().zip(b).find(|((_, p), (_, q))| p != q).map(|((name, _), _)| *name)
}

/// Reads a certificate; `file` is for messages.
///
/// # Errors
/// [`ProofError::Certificate`].
pub fn parse(text: &str, file: &str) -> Result<Certificate, ProofError> {
    Certificate::from_json(text).map_err(|reason| ProofError::Certificate { file: file.into(), reason })
}

/// Returns the text of a certificate for the file `path`.
///
/// # Errors
/// [`ProofError::Certificate`].
pub fn text(certificate: &Certificate, path: &Path) -> Result<String, ProofError> {
    let to_error = |reason| ProofError::Certificate { file: path.display().to_string(), reason };
    certificate.to_json().map_err(to_error)
}
