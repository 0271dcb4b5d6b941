//! Designs a controller for a plant in a file, and prints how long each part took: `timed FILE.json`.
//!
//! The file is a case of `tests/cases` (`data` with the plant's matrices) or a certificate (`plant` and `blocks`). The
//! one JSON object printed has the seconds of the least gamma alone and of the whole design, both gammas and, for a
//! plant without parameters, the controller's matrices.

use lpv::matrix::{Mat, from_rows};
use lpv::plant::GeneralisedPlant;
use lpv::synthesis::{Options, Scalings, least_gamma, synthesise};
use serde_json::{Value, json};
use std::error::Error;
use std::time::Instant;

/// The matrix of a list of rows; without the key, zeros of the shape given.
fn matrix(p: &Value, key: &str, (rows, cols): (usize, usize)) -> Result<Mat, Box<dyn Error>> {
    let Some(value) = p.get(key) else { return Ok(Mat::zeros(rows, cols)) };
    let list: Vec<Vec<f64>> = serde_json::from_value(value.clone())?;
    let found = from_rows(&list, list.first().map_or(cols, Vec::len));
    Ok(found.ok_or_else(|| format!("{key}: rows of unequal length"))?)
}

fn plant(file: &Value) -> Result<GeneralisedPlant, Box<dyn Error>> {
    let data = file.get("data").unwrap_or(file);
    let p = data.get("P").or_else(|| data.get("plant")).unwrap_or(data);
    let blocks: Vec<usize> =
        data.get("blocks").map_or(Ok(vec![]), |blocks| serde_json::from_value(blocks.clone()))?;
    let r = blocks.iter().sum();
    let given = |key| matrix(p, key, (0, 0));
    let (a, b1, b2, c1, c2) = (given("A")?, given("B1")?, given("B2")?, given("C1")?, given("C2")?);
    let (n, w, u, z, y) = (a.nrows(), b1.ncols(), b2.ncols(), c1.nrows(), c2.nrows());
    Ok(GeneralisedPlant {
        bt: matrix(p, "Bt", (n, r))?,
        ct: matrix(p, "Ct", (r, n))?,
        dtt: matrix(p, "Dtt", (r, r))?,
        dt1: matrix(p, "Dt1", (r, w))?,
        dt2: matrix(p, "Dt2", (r, u))?,
        d1t: matrix(p, "D1t", (z, r))?,
        d11: matrix(p, "D11", (z, w))?,
        d12: matrix(p, "D12", (z, u))?,
        d2t: matrix(p, "D2t", (y, r))?,
        d21: matrix(p, "D21", (y, w))?,
        blocks,
        a,
        b1,
        b2,
        c1,
        c2,
    })
}

fn rows(m: &Mat) -> Vec<Vec<f64>> {
    m.row_iter().map(|row| row.iter().copied().collect()).collect()
}

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("a file is needed: a case or a certificate")?;
    let plant = plant(&serde_json::from_str(&std::fs::read_to_string(path)?)?)?;
    let begin = Instant::now();
    least_gamma(&plant, Scalings::SymmetricAndSkew)?;
    let least = begin.elapsed().as_secs_f64();
    let begin = Instant::now();
    let design = synthesise(&plant, Options::default())?;
    let whole = begin.elapsed().as_secs_f64();
    let k = &design.controller;
    let controller = json!({ "A": rows(&k.a), "B": rows(&k.by), "C": rows(&k.cu), "D": rows(&k.duy) });
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
