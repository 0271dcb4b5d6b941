//! The bound of a loop as a claim, with and without model error, and its proof.

use crate::error::ProofError;
use crate::rate::bounded_rate;
use crate::rows::{controller_rows, plant_rows};
use certificate::{AnyRate, Certificate, Residual, Theorem};
use lpv::analysis::GainBound;
use lpv::analysis::bounded_gain::cleared;
use lpv::controller::Controller;
use lpv::matrix::to_rows;
use lpv::model_error::{LoopError, ModelError};
use lpv::plant::{ClosedLoop, GeneralisedPlant};
use lpv::synthesis::Design;

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

/// Proves the bound of a design for its plant, and `covered` for a model error of size `size`; both also at a bounded
/// rate where the design has a bound for that. `closed` and `missed` are loop and error with its controller.
///
/// # Errors
/// [`ProofError::Unproved`] with the first check that fails; [`ProofError::Synthesis`] when no bound at the rate covers
/// the model error.
pub fn with_model_error(
    plant: &GeneralisedPlant,
    design: &Design,
    (error, size): (&ModelError, f64),
    (closed, missed): (&ClosedLoop, &LoopError),
    covered: &GainBound,
) -> Result<Proof, ProofError> {
    let proved = |covered: &GainBound| -> Result<Proof, ProofError> {
        let mut certificate = nominal(plant, &design.controller, &design.certified);
        certificate.residual = Some(residual(error, covered));
        let slow = design.slow.as_ref();
        certificate.bounded_rate =
            slow.map(|slow| bounded_rate(closed, missed, slow, covered.lambda)).transpose()?;
        let theorem = certificate.prove()?;
        Ok(Proof { certificate, theorem, model_error: Some(size) })
    };
    // Inequalities that hold by their eigenvalues may be lost in the rounding of a tight bound.
    proved(covered)
        .or_else(|reason| cleared(closed, missed, covered).map_or(Err(reason), |clear| proved(&clear)))
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
