//! The certificate: the gain bound of the finished loop in a form that exact arithmetic re-checks.
//!
//! One file states two claims: the bound for the fitted model, and the bound that also holds for a model error as
//! large as the fit's residual against the true linearisations anywhere in the range of speed.

pub mod ball;
pub mod claims;
pub mod constant;
pub mod limits;
pub mod rate;
pub mod same_plant;
pub mod sampled;
pub mod verify;

use crate::certify::ball::{bends_at_rest, smallest_ball};
use crate::error::{Error, ProofError};
use crate::fit::Model;
use crate::inputs::design_file::DesignFile;
use auv::Vehicle;
use certificate::{AnyRate, Certificate, Residual, Rows, Theorem};
use lpv::analysis::bounded_gain::with_raised_gamma;
use lpv::analysis::{GainBound, bounded_gain};
use lpv::controller::Controller;
use lpv::error::SynthesisError;
use lpv::matrix::{Mat, from_rows, to_rows};
use lpv::model_error::ModelError;
use lpv::partition::{self, CONTROLLER, NamedBlock, Names, Partitioned};
use lpv::plant::GeneralisedPlant;
use lpv::synthesis::Design;
use scheduled::LftMatrices;

/// What was proved, and the text that proves it.
#[derive(Debug, Clone)]
pub struct Proof {
    /// The certificate.
    pub certificate: Certificate,
    /// What it proves.
    pub theorem: Theorem,
    /// The size of the model error that is covered, in the coordinates of [`ModelError`]; `None` where none is.
    pub model_error: Option<f64>,
}

/// Computes the certificate of a design, for the fit and for a ball of models that contains the true linearisations
/// ([`ball`]), and proves it in exact arithmetic.
///
/// # Errors
/// [`ProofError::Unproved`] with the first check that fails; [`ProofError::BendsAtRest`] or [`Error::Synthesis`] when
/// no bound covers the model error.
pub fn certify(
    vehicle: &Vehicle,
    file: &DesignFile,
    model: &Model,
    plant: &GeneralisedPlant,
    design: &Design,
) -> Result<Proof, Error> {
    let (error, size) = smallest_ball(vehicle, file, model, plant, &design.certified)?;
    let closed = plant.close(&design.controller);
    let missed = error.close(plant, &design.controller);
    let covered = bounded_gain(&closed, &missed, &design.certified)
        .map_err(|reason| why_not(vehicle, file, model, reason))?;
    let proved = |covered: &GainBound| -> Result<(Certificate, Theorem), Error> {
        let mut certificate = nominal(plant, &design.controller, &design.certified);
        certificate.residual = Some(residual(&error, covered));
        let slow = design.slow.as_ref();
        certificate.bounded_rate =
            slow.map(|slow| rate::bounded_rate(&closed, &missed, slow, covered.lambda)).transpose()?;
        let theorem = certificate.prove()?;
        Ok((certificate, theorem))
    };
    let (certificate, theorem) = proved(&covered).or_else(|reason| {
        // Inequalities that hold by their eigenvalues may be lost in the rounding of a tight bound.
        with_raised_gamma(&closed, &missed, &covered).map_or(Err(reason), |clear| proved(&clear))
    })?;
    Ok(Proof { certificate, theorem, model_error: Some(size) })
}

/// Why no bound covers the model error, in words of the vehicle where they are known.
fn why_not(vehicle: &Vehicle, file: &DesignFile, model: &Model, reason: SynthesisError) -> Error {
    match bends_at_rest(vehicle, file, model) {
        Ok(true) => ProofError::BendsAtRest { from: file.speed_min, to: file.speed_max }.into(),
        _ => reason.into(),
    }
}

/// The certificate of a bound without model error, with plant, controller, gamma, X or V, S and T.
pub fn nominal(plant: &GeneralisedPlant, k: &Controller, bound: &GainBound) -> Certificate {
    let any_rate = AnyRate {
        gamma: bound.gamma,
        x: if bound.factor.is_some() { vec![] } else { to_rows(&bound.x) },
        v: bound.factor.as_ref().map_or_else(Vec::new, to_rows),
        s: to_rows(&bound.s),
        t: to_rows(&bound.t),
    };
    Certificate { any_rate: Some(any_rate), ..without_claims(plant, k) }
}

/// A certificate with plant and controller, and no claim yet.
pub fn without_claims(plant: &GeneralisedPlant, k: &Controller) -> Certificate {
    Certificate {
        blocks: plant.blocks.clone(),
        controller_blocks: k.blocks.clone(),
        plant: plant_rows(plant),
        controller: controller_rows(k),
        ..Certificate::default()
    }
}

/// A plant in the form of the certificate.
pub fn plant_rows(p: &GeneralisedPlant) -> certificate::Plant {
    let mut out = certificate::Plant::default();
    out.named_mut().into_iter().for_each(|(key, rows)| *rows = rows_of(&p.parts, key));
    out
}

fn rows_of(parts: &Partitioned, key: &str) -> Rows {
    parts.named(key).map_or_else(Vec::new, |m| to_rows(&m))
}

/// A direct path from u to y in the form of the certificate: nothing where it is 0.
pub fn direct_path(d22: &Mat) -> Rows {
    if d22.iter().all(|entry| *entry == 0.0) { vec![] } else { to_rows(d22) }
}

/// A controller in the form of the certificate.
pub fn controller_rows(k: &Controller) -> certificate::Controller {
    let mut out = certificate::Controller::default();
    out.named_mut().into_iter().for_each(|(key, rows)| *rows = rows_of(&k.parts, key));
    out
}

/// The blocks of a partition whose matrices are given with their keys; `None` when one is ragged or no part of it. A
/// matrix without rows is left out.
pub fn blocks_of(names: Names, matrices: &[(&'static str, &Rows)]) -> Option<Vec<NamedBlock>> {
    let given = matrices.iter().filter(|(_, rows)| !rows.is_empty());
    let block = |(key, rows): &(&'static str, &Rows)| {
        let (_, row, column) = partition::names(names).find(|(name, _, _)| name == key)?;
        Some((row, column, from_rows(rows, rows.first()?.len())?))
    };
    given.map(block).collect()
}

/// A controller of a certificate and its blocks, in the form of a controller file.
pub fn lft_matrices(blocks: Vec<usize>, rows: certificate::Controller) -> LftMatrices {
    let certificate::Controller { a, by, bt, cu, duy, dut, ct, dty, dtt } = rows;
    LftMatrices { blocks, a, by, bt, cu, duy, dut, ct, dty, dtt }
}

/// The frozen controller's matrices in the form of the certificate.
pub fn frozen_rows(lft: &LftMatrices) -> certificate::Controller {
    let LftMatrices { blocks: _, a, by, bt, cu, duy, dut, ct, dty, dtt } = lft.clone();
    certificate::Controller { a, by, bt, cu, duy, dut, ct, dty, dtt }
}

/// The frozen controller's matrices as the theory has them.
///
/// # Errors
/// [`ProofError::Mismatch`] when they do not fit together.
pub fn controller_of(lft: &LftMatrices) -> Result<Controller, ProofError> {
    let blocks = blocks_of(CONTROLLER, &frozen_rows(lft).named());
    let controller = blocks.and_then(|blocks| Controller::new(lft.blocks.clone(), &blocks).ok());
    controller.ok_or_else(|| ProofError::Mismatch { what: "the shape of a matrix of the controller".into() })
}

fn residual(error: &ModelError, bound: &GainBound) -> Residual {
    Residual {
        e: to_rows(&error.e),
        f: to_rows(&error.f),
        fw: to_rows(&error.fw),
        fu: to_rows(&error.fu),
        lambda: bound.lambda,
        gamma: bound.gamma,
        x: to_rows(&bound.x),
        s: to_rows(&bound.s),
        t: to_rows(&bound.t),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inputs::tests::shipped;

    /// The drag of BlueROV2 Heavy is quadratic: a range of speed with rest inside is distinguished from others.
    #[test]
    fn a_proof_that_fails_at_rest_is_explained_by_the_vehicle() {
        let mut inputs = shipped("bluerov2_heavy", "design");
        for (from, to, bends) in [(-0.5, 0.5, true), (-0.2, 0.5, true), (0.0, 0.5, false), (-0.5, 0.0, false)]
        {
            (inputs.design.speed_min, inputs.design.speed_max) = (from, to);
            let model = Model::new(&inputs.vehicle, &inputs.design).unwrap();
            let reason = SynthesisError::Infeasible { stage: "test" };
            let words = why_not(&inputs.vehicle, &inputs.design, &model, reason).to_string();
            assert_eq!(words.contains("bends at rest"), bends, "{words}");
            assert!(!bends || words.contains(&format!("from {from} to {to} m/s")), "{words}");
        }
    }
}
