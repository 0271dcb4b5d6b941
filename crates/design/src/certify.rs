//! The certificate: the gain bound of the finished loop in a form that exact arithmetic re-checks.
//!
//! Two claims go into one file: the bound for the fitted model, and the bound that also holds when the model is off by
//! as much as the fit misses the true linearisations anywhere in the range of speed.

pub mod ball;
pub mod same_plant;
pub mod verify;

use crate::certify::ball::smallest_ball;
use crate::error::Error;
use crate::fit::Model;
use crate::inputs::Inputs;
use certificate::{Certificate, Residual, Rows, Theorem};
use lpv::analysis::{GainBound, bounded_gain};
use lpv::controller::Controller;
use lpv::matrix::{Mat, from_rows, to_rows};
use lpv::model_error::ModelError;
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
    /// The size of the model error that is covered, in the coordinates of [`ModelError`].
    pub model_error: f64,
}

/// Certifies a design, and proves the certificate in exact arithmetic.
///
/// # Errors
/// [`ProofError::Unproved`](crate::error::ProofError::Unproved) with the first thing that failed;
/// [`Error::Synthesis`] when no bound covers the model error.
pub fn certify(
    inputs: &Inputs,
    model: &Model,
    plant: &GeneralisedPlant,
    design: &Design,
) -> Result<Proof, Error> {
    let (error, size) = smallest_ball(inputs, model, plant, &design.certified)?;
    let closed = plant.close(&design.controller);
    let covered = bounded_gain(&closed, &error.close(plant, &design.controller), &design.certified)?;
    let mut certificate = nominal(plant, &design.controller, &design.certified);
    certificate.residual = Some(residual(&error, &covered));
    let theorem = certificate.prove()?;
    Ok(Proof { certificate, theorem, model_error: size })
}

/// The certificate of a bound without model error.
pub fn nominal(plant: &GeneralisedPlant, k: &Controller, bound: &GainBound) -> Certificate {
    Certificate {
        blocks: plant.blocks.clone(),
        controller_blocks: k.blocks.clone(),
        plant: plant_rows(plant),
        controller: controller_rows(k),
        gamma: bound.gamma,
        x: to_rows(&bound.x),
        s: to_rows(&bound.s),
        t: to_rows(&bound.t),
        residual: None,
    }
}

/// A plant as the certificate holds it.
pub fn plant_rows(p: &GeneralisedPlant) -> certificate::Plant {
    certificate::Plant {
        a: to_rows(&p.a),
        bt: to_rows(&p.bt),
        b1: to_rows(&p.b1),
        b2: to_rows(&p.b2),
        ct: to_rows(&p.ct),
        c1: to_rows(&p.c1),
        c2: to_rows(&p.c2),
        dtt: to_rows(&p.dtt),
        dt1: to_rows(&p.dt1),
        dt2: to_rows(&p.dt2),
        d1t: to_rows(&p.d1t),
        d11: to_rows(&p.d11),
        d12: to_rows(&p.d12),
        d2t: to_rows(&p.d2t),
        d21: to_rows(&p.d21),
        d22: vec![],
    }
}

/// A direct path from u to y as the certificate holds it: nothing where it is 0.
pub fn direct_path(d22: &Mat) -> Rows {
    if d22.iter().all(|entry| *entry == 0.0) { vec![] } else { to_rows(d22) }
}

/// A controller as the certificate holds it.
pub fn controller_rows(k: &Controller) -> certificate::Controller {
    certificate::Controller {
        a: to_rows(&k.a),
        by: to_rows(&k.by),
        bt: to_rows(&k.bt),
        cu: to_rows(&k.cu),
        duy: to_rows(&k.duy),
        dut: to_rows(&k.dut),
        ct: to_rows(&k.ct),
        dty: to_rows(&k.dty),
        dtt: to_rows(&k.dtt),
    }
}

/// A certificate's controller with its blocks, as files hold a controller.
pub fn rows_with_blocks(certificate: &Certificate) -> LftMatrices {
    let certificate::Controller { a, by, bt, cu, duy, dut, ct, dty, dtt } = certificate.controller.clone();
    LftMatrices { blocks: certificate.controller_blocks.clone(), a, by, bt, cu, duy, dut, ct, dty, dtt }
}

/// The frozen controller's matrices as the certificate holds them.
pub fn frozen_rows(lft: &LftMatrices) -> certificate::Controller {
    let LftMatrices { blocks: _, a, by, bt, cu, duy, dut, ct, dty, dtt } = lft.clone();
    certificate::Controller { a, by, bt, cu, duy, dut, ct, dty, dtt }
}

/// The frozen controller's matrices as the theory has them; `None` when they are ragged.
pub fn controller_of(lft: &LftMatrices) -> Option<Controller> {
    let (n, y) = (lft.a.len(), lft.by.first()?.len());
    let r = lft.blocks.iter().sum();
    Some(Controller {
        a: from_rows(&lft.a, n)?,
        by: from_rows(&lft.by, y)?,
        bt: from_rows(&lft.bt, r)?,
        cu: from_rows(&lft.cu, n)?,
        duy: from_rows(&lft.duy, y)?,
        dut: from_rows(&lft.dut, r)?,
        ct: from_rows(&lft.ct, n)?,
        dty: from_rows(&lft.dty, y)?,
        dtt: from_rows(&lft.dtt, r)?,
        blocks: lft.blocks.clone(),
    })
}

fn residual(error: &ModelError, bound: &GainBound) -> Residual {
    Residual {
        e: to_rows(&error.e),
        f: to_rows(&error.f),
        fu: to_rows(&error.fu),
        lambda: bound.lambda,
        gamma: bound.gamma,
        x: to_rows(&bound.x),
        s: to_rows(&bound.s),
        t: to_rows(&bound.t),
    }
}
