//! Designs a controller for a plant in a file, and prints how long each part took: `timed FILE.json [RATE]`.
//!
//! With a rate only the least gamma of controllers for a parameter that moves at that rate is sought.
//! The file is a case of `tests/cases` (`data` with the plant's matrices) or a certificate (`plant` and `blocks`). The
//! one JSON object printed has the seconds of the least gamma alone and of the whole design, both gammas and, for a
//! plant without parameters, the controller's matrices.

use lpv::bounded_rate::{self, SlowOptions};
use lpv::matrix::{from_rows, to_rows};
use lpv::partition::{PLANT, names};
use lpv::plant::GeneralisedPlant;
use lpv::synthesis::{Options, ScalingClass, least_gamma, synthesise};
use serde_json::{Value, json};
use std::error::Error;
use std::time::Instant;

fn plant(file: &Value) -> Result<GeneralisedPlant, Box<dyn Error>> {
    let data = file.get("data").unwrap_or(file);
    let p = data.get("P").or_else(|| data.get("plant")).unwrap_or(data);
    let blocks: Vec<usize> =
        data.get("blocks").map_or(Ok(vec![]), |blocks| serde_json::from_value(blocks.clone()))?;
    let mut parts = vec![];
    for (key, row, column) in names(PLANT) {
        let list: Vec<Vec<f64>> =
            p.get(key).map_or(Ok(vec![]), |rows| serde_json::from_value(rows.clone()))?;
        if let Some(first) = list.first() {
            let m = from_rows(&list, first.len()).ok_or_else(|| format!("{key}: rows of unequal length"))?;
            parts.push((row, column, m));
        }
    }
    Ok(GeneralisedPlant::new(blocks, &parts)?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("a file is needed: a case or a certificate")?;
    let plant = plant(&serde_json::from_str(&std::fs::read_to_string(path)?)?)?;
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
