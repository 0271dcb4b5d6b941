//! Designs a controller for the plant of a file, and prints the time of each stage: `timed FILE.json [RATE]`.
//!
//! With a rate only the least gamma of controllers for a parameter of that rate is computed. For a certificate of
//! constant parameters the bound for the loop of its plant and controller is computed, within one per cent. The file is
//! a problem of `squid lpv synth` or a certificate. The JSON object printed has the seconds of the least gamma and of
//! the complete design, both gammas and, for a plant without parameters, the controller's matrices.

use serde_json::{Value, json};
use squid_certificate::Certificate;
use squid_lpv::bounded_rate::{self, SlowOptions};
use squid_lpv::matrix::{Mat, from_rows, to_rows};
use squid_lpv::model_error::ModelError;
use squid_lpv::robust::constant::{ConstantLoop, Filters};
use squid_lpv::synthesis::{Options, ScalingClass, least_gamma, synthesise};
use squid_problem::problem_file::problem;
use squid_problem::source::Source;
use squid_proof::claim::controller;
use squid_proof::same_plant::plant_with;
use std::error::Error;
use std::time::Instant;

/// Returns the loop of a certificate, with the filters and errors of its claim about constant parameters.
fn constant_loop(
    file: &Certificate,
    claim: &squid_certificate::Constant,
) -> Result<ConstantLoop, Box<dyn Error>> {
    let plant = plant_with(&file.plant, &file.blocks, &file.blocks)?;
    let controller =
        controller(&file.controller_blocks, &file.controller).ok_or("the controller is ragged")?;
    let mut filters: Vec<Option<Filters>> = vec![None; plant.blocks.len()];
    for filter in &claim.filters {
        let of = filters.get_mut(filter.parameter).ok_or("filters: no such parameter")?;
        of.get_or_insert(Filters { poles: vec![], rate: filter.rate }).poles.push(filter.pole);
    }
    let matrix =
        |rows: &[Vec<f64>]| from_rows(rows, rows.first().map_or(0, Vec::len)).ok_or("a ball is ragged");
    let mut errors = vec![];
    for ball in &file.errors {
        let (e, f, fu) = (matrix(&ball.e)?, matrix(&ball.f)?, matrix(&ball.fu)?);
        let fw = Mat::zeros(f.nrows(), plant.sizes().w);
        errors.push(ModelError { e, f, fw, fu }.close(&plant, &controller));
    }
    Ok(ConstantLoop { closed: plant.close(&controller), filters, errors })
}

/// Relative tolerance of the bound for constant parameters, as in `squid design --constant`.
const CLOSE: f64 = 0.01;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("a file is needed: a problem or a certificate")?;
    let text = std::fs::read_to_string(&path)?;
    let certificate = Certificate::from_json(&text).ok();
    if let Some((file, claim)) = certificate.as_ref().and_then(|file| Some((file, file.constant()?))) {
        let closed = constant_loop(file, claim)?;
        let begin = Instant::now();
        let found = closed.bound(claim.gamma, CLOSE, f64::INFINITY)?;
        let seconds = begin.elapsed().as_secs_f64();
        println!("{}", json!({ "seconds": seconds, "gamma": found.gamma }));
        return Ok(());
    }
    let plant = match certificate {
        Some(file) => plant_with(&file.plant, &file.blocks, &file.blocks)?,
        None => problem(&Source::read(path.as_ref())?)?.plant,
    };
    if let Some(rate) = std::env::args().nth(2) {
        let begin = Instant::now();
        let least = bounded_rate::least_gamma(&plant, SlowOptions::at(rate.parse()?))?;
        let seconds = begin.elapsed().as_secs_f64();
        println!("{}", json!({ "seconds_least_gamma": seconds, "gamma": least.gamma }));
        return Ok(());
    }
    let begin = Instant::now();
    least_gamma(&plant, ScalingClass::SymmetricAndSkew)?;
    let least = begin.elapsed().as_secs_f64();
    let begin = Instant::now();
    let design = synthesise(&plant, Options::default())?;
    let complete = begin.elapsed().as_secs_f64();
    let k = &design.controller;
    let controller =
        json!({ "A": to_rows(&k.a()), "B": to_rows(&k.by()), "C": to_rows(&k.cu()), "D": to_rows(&k.duy()) });
    let report = json!({
        "seconds_least_gamma": least,
        "seconds": complete,
        "gamma": design.gamma_optimum,
        "gamma_design": design.gamma_design,
        "certified_gamma": design.certified.gamma,
        "controller": if plant.blocks.is_empty() { controller } else { Value::Null },
    });
    println!("{report}");
    Ok(())
}
