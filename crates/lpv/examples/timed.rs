//! Designs a controller for a plant in a file, and prints the time of each part: `timed FILE.json [RATE]`.
//!
//! With a rate only the least gamma of controllers for a parameter of that rate is computed. For a certificate of
//! constant parameters the bound for the loop of its plant and controller is computed, within a per cent. The file is a
//! case of `tests/cases` (`data` with the plant's matrices) or a certificate (`plant` and `blocks`). The JSON object
//! printed has the seconds of the least gamma and of the complete design, both gammas and, for a plant without
//! parameters, the controller's matrices.

use lpv::bounded_rate::{self, SlowOptions};
use lpv::controller::Controller;
use lpv::matrix::{Mat, from_rows, to_rows};
use lpv::model_error::{LoopError, ModelError};
use lpv::partition::{CONTROLLER, NamedBlock, Names, PLANT, names};
use lpv::plant::GeneralisedPlant;
use lpv::robust::constant::{ConstantLoop, Filters};
use lpv::synthesis::{Options, ScalingClass, least_gamma, synthesise};
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use std::error::Error;
use std::time::Instant;

/// The value at a key, or the empty value of its type.
fn at<T: DeserializeOwned + Default>(of: &Value, key: &str) -> Result<T, Box<dyn Error>> {
    Ok(of.get(key).map_or(Ok(T::default()), |value| serde_json::from_value(value.clone()))?)
}

/// The matrix at a key; `None` for one without rows.
fn matrix(of: &Value, key: &str) -> Result<Option<Mat>, Box<dyn Error>> {
    let rows: Vec<Vec<f64>> = at(of, key)?;
    let Some(first) = rows.first() else { return Ok(None) };
    Ok(Some(from_rows(&rows, first.len()).ok_or_else(|| format!("{key}: rows of unequal length"))?))
}

fn parts(of: &Value, layout: Names) -> Result<Vec<NamedBlock>, Box<dyn Error>> {
    let each = names(layout).map(|(key, row, column)| Ok(matrix(of, key)?.map(|m| (row, column, m))));
    each.filter_map(Result::transpose).collect()
}

fn plant(file: &Value) -> Result<GeneralisedPlant, Box<dyn Error>> {
    let data = file.get("data").unwrap_or(file);
    let p = data.get("P").or_else(|| data.get("plant")).unwrap_or(data);
    Ok(GeneralisedPlant::new(at(data, "blocks")?, &parts(p, PLANT)?)?)
}

/// The loop of a certificate, with the filters of its claim about constant parameters.
fn constant_loop(file: &Value, claim: &Value) -> Result<ConstantLoop, Box<dyn Error>> {
    let plant = plant(file)?;
    let controller =
        Controller::new(at(file, "controller_blocks")?, &parts(&file["controller"], CONTROLLER)?)?;
    let mut filters: Vec<Option<Filters>> = vec![None; plant.blocks.len()];
    for filter in at::<Vec<Value>>(claim, "filters")? {
        let of = filters.get_mut(at::<usize>(&filter, "parameter")?).ok_or("filters: no such parameter")?;
        let own = of.get_or_insert(Filters { poles: vec![], rate: at(&filter, "rate")? });
        own.poles.push(at(&filter, "pole")?);
    }
    let error = |ball: Value| -> Result<LoopError, Box<dyn Error>> {
        let of =
            |key: &str| Ok::<_, Box<dyn Error>>(matrix(&ball, key)?.ok_or_else(|| format!("{key}: none"))?);
        let f = of("F")?;
        let fw = Mat::zeros(f.nrows(), plant.sizes().w);
        Ok(ModelError { e: of("E")?, f, fw, fu: of("Fu")? }.close(&plant, &controller))
    };
    let errors = at::<Vec<Value>>(file, "errors")?.into_iter().map(error).collect::<Result<_, _>>()?;
    Ok(ConstantLoop { closed: plant.close(&controller), filters, errors })
}

/// The relative tolerance of the bound for constant parameters, as in `squid design --constant`.
const CLOSE: f64 = 0.01;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("a file is needed: a case or a certificate")?;
    let file: Value = serde_json::from_str(&std::fs::read_to_string(path)?)?;
    let claim = &file["claims"][0]["constant"];
    if claim.is_object() {
        let whole = constant_loop(&file, claim)?;
        let begin = Instant::now();
        let found = whole.bound(at(claim, "gamma")?, CLOSE, f64::INFINITY)?;
        let seconds = begin.elapsed().as_secs_f64();
        println!("{}", json!({ "seconds": seconds, "gamma": found.gamma }));
        return Ok(());
    }
    let plant = plant(&file)?;
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
    let whole = begin.elapsed().as_secs_f64();
    let k = &design.controller;
    let controller =
        json!({ "A": to_rows(&k.a()), "B": to_rows(&k.by()), "C": to_rows(&k.cu()), "D": to_rows(&k.duy()) });
    let report = json!({
        "seconds_least_gamma": least,
        "seconds": whole,
        "gamma": design.gamma_optimum,
        "gamma_design": design.gamma_design,
        "certified_gamma": design.certified.gamma,
        "controller": if plant.blocks.is_empty() { controller } else { Value::Null },
    });
    println!("{report}");
    Ok(())
}
