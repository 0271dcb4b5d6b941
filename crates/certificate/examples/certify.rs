//! Designs a controller for a generalised plant, and writes the certificate of the loop.
//!
//! ```text
//! cargo run --release -p certificate --example certify -- PROBLEM.json CERTIFICATE.json [BALL]
//! ```
//!
//! PROBLEM.json is a case of `tests/cases` of kind `lpvsyn-lft` or `hinfsyn`, or a certificate, whose plant is taken.
//! With BALL the certificate also covers errors of `[A B2]` up to that size in the largest singular value, at a
//! gamma found by trial.

use certificate::{Certificate, Controller, Plant, Residual, Rows};
use lpv::matrix::{Mat, from_rows, skew_part, symmetric_part, to_rows};
use lpv::plant::GeneralisedPlant;
use lpv::synthesis::{Options, synthesise};
use serde_json::Value;
use std::error::Error;
use std::time::Instant;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [problem, output, rest @ ..] = arguments.as_slice() else {
        return Err("usage: certify PROBLEM.json CERTIFICATE.json [BALL]".into());
    };
    let plant = plant(&serde_json::from_str(&std::fs::read_to_string(problem)?)?)?;
    let design = synthesise(&plant, Options::default())?;
    let (k, bound) = (&design.controller, &design.certified);
    let mut certificate = Certificate {
        blocks: plant.blocks.clone(),
        controller_blocks: k.blocks.clone(),
        plant: plant_rows(&plant),
        controller: Controller {
            a: to_rows(&k.a),
            by: to_rows(&k.by),
            bt: to_rows(&k.bt),
            cu: to_rows(&k.cu),
            duy: to_rows(&k.duy),
            dut: to_rows(&k.dut),
            ct: to_rows(&k.ct),
            dty: to_rows(&k.dty),
            dtt: to_rows(&k.dtt),
        },
        gamma: bound.gamma,
        x: to_rows(&symmetric_part(&bound.x)),
        s: to_rows(&symmetric_part(&bound.s)),
        t: to_rows(&skew_part(&bound.t)),
        residual: None,
    };
    if let Some(ball) = rest.first() {
        certificate = with_ball(certificate, ball.parse()?).ok_or("no gamma covers that ball")?;
    }
    let start = Instant::now();
    println!("{}", certificate.prove().map_err(|failure| failure.to_string())?);
    println!("proved in {:.1} ms", 1e3 * start.elapsed().as_secs_f64());
    std::fs::write(output, certificate.to_json()? + "\n")?;
    Ok(())
}

fn plant(file: &Value) -> Result<GeneralisedPlant, Box<dyn Error>> {
    let data = if file["data"].is_object() { &file["data"] } else { file };
    let nested = ["P", "plant"].into_iter().find(|key| data[key].is_object());
    let p = nested.map_or(data, |key| &data[key]);
    let rows = |key: &str| serde_json::from_value::<Rows>(p[key].clone());
    let (n, z, y) = (rows("A")?.len(), rows("C1")?.len(), rows("C2")?.len());
    let (w, u) = (rows("D11")?.first().map_or(0, Vec::len), rows("D12")?.first().map_or(0, Vec::len));
    let blocks: Vec<usize> =
        if nested.is_some() { serde_json::from_value(data["blocks"].clone())? } else { vec![] };
    let r = blocks.iter().sum();
    let m = |key: &str, count: usize, cols: usize| -> Result<Mat, Box<dyn Error>> {
        if p[key].is_null() && (count == 0 || cols == 0) {
            return Ok(Mat::zeros(count, cols));
        }
        Ok(from_rows(&rows(key)?, cols).ok_or_else(|| format!("{key} has ragged rows"))?)
    };
    Ok(GeneralisedPlant {
        a: m("A", n, n)?,
        bt: m("Bt", n, r)?,
        b1: m("B1", n, w)?,
        b2: m("B2", n, u)?,
        ct: m("Ct", r, n)?,
        dtt: m("Dtt", r, r)?,
        dt1: m("Dt1", r, w)?,
        dt2: m("Dt2", r, u)?,
        c1: m("C1", z, n)?,
        d1t: m("D1t", z, r)?,
        d11: m("D11", z, w)?,
        d12: m("D12", z, u)?,
        c2: m("C2", y, n)?,
        d2t: m("D2t", y, r)?,
        d21: m("D21", y, w)?,
        blocks,
    })
}

fn plant_rows(p: &GeneralisedPlant) -> Plant {
    Plant {
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
    }
}

/// Adds the claim for `||[dA dB2]|| <= ball`, with X, S and T of the nominal claim and the first lambda and gamma of
/// a table that prove it.
fn with_ball(certificate: Certificate, ball: f64) -> Option<Certificate> {
    let (n, u) = (certificate.plant.a.len(), certificate.plant.d12.first().map_or(0, Vec::len));
    let eye = |rows: usize, cols: usize, below: usize| {
        to_rows(&Mat::from_fn(rows, cols, |i, j| if i == j + below { 1.0 } else { 0.0 }))
    };
    let trials = [1.05, 1.2, 2.0];
    let lambdas = (-12..=12).map(|k| 10f64.powi(k));
    let table = trials.into_iter().flat_map(|up| lambdas.clone().map(move |lambda| (up, lambda)));
    table
        .map(|(up, lambda)| {
            let residual = Residual {
                e: to_rows(&(Mat::identity(n, n) * ball)),
                f: eye(n + u, n, 0),
                fu: eye(n + u, u, n),
                lambda,
                gamma: certificate.gamma * up,
                x: certificate.x.clone(),
                s: certificate.s.clone(),
                t: certificate.t.clone(),
            };
            Certificate { residual: Some(residual), ..certificate.clone() }
        })
        .find(|trial| trial.prove().is_ok())
}
