//! Bounds mu of the problem in a file repeatedly, and prints the median of the seconds: `mu_timed FILE.json [CALLS]`.
//!
//! The file is as for `squid lpv mu`, with all entries of `M` as `[re, im]`. For a matrix only `upper_bound` is timed,
//! for a system the complete sweep over frequency with the perturbation. One JSON object is printed: `seconds`,
//! `upper`, `lower` (of a system) and `intervals`.

use lpv::matrix::{Mat, from_rows};
use lpv::mu::over_frequency::mu_over_frequency;
use lpv::mu::upper::upper_bound;
use lpv::mu::{CMat, Structure};
use lpv::state_space::StateSpace;
use nalgebra::Complex;
use serde_json::{Value, from_value, json};
use std::error::Error;
use std::hint::black_box;
use std::time::Instant;

/// The median time of a call in seconds, after an uncounted first one, and the last answer.
fn timed<T, E>(calls: usize, mut call: impl FnMut() -> Result<T, E>) -> Result<(f64, T), E> {
    let mut answer = call()?;
    let mut seconds = Vec::with_capacity(calls);
    for _ in 0..calls {
        let begin = Instant::now();
        answer = black_box(call()?);
        seconds.push(begin.elapsed().as_secs_f64());
    }
    seconds.sort_by(f64::total_cmp);
    Ok((seconds[calls / 2], answer))
}

fn matrix(p: &Value, key: &str) -> Result<Mat, Box<dyn Error>> {
    let list: Vec<Vec<f64>> = from_value(p[key].clone())?;
    let found = from_rows(&list, list.first().map_or(0, Vec::len));
    Ok(found.ok_or_else(|| format!("{key}: rows of unequal length"))?)
}

fn complex_matrix(value: &Value) -> Result<CMat, Box<dyn Error>> {
    let list: Vec<Vec<(f64, f64)>> = from_value(value.clone())?;
    let width = list.first().map_or(0, Vec::len);
    if list.iter().any(|row| row.len() != width) {
        return Err("M: rows of unequal length".into());
    }
    Ok(CMat::from_fn(list.len(), width, |i, j| Complex::new(list[i][j].0, list[i][j].1)))
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut words = std::env::args().skip(1);
    let path = words.next().ok_or("a file is needed: a problem of `squid lpv mu`")?;
    let calls = words.next().map_or(Ok(1), |word| word.parse::<usize>())?.max(1);
    let file: Value = serde_json::from_str(&std::fs::read_to_string(path)?)?;
    let data = &file["data"];
    let structure = Structure::from_notation(&from_value::<Vec<(i64, i64)>>(data["blocks"].clone())?)?;
    let report = if data.get("M").is_some() {
        let m = complex_matrix(&data["M"])?;
        let (seconds, bound) = timed(calls, || upper_bound(black_box(&m), &structure))?;
        json!({ "seconds": seconds, "upper": bound.value })
    } else {
        let p = &data["P"];
        let system =
            StateSpace { a: matrix(p, "A")?, b: matrix(p, "B")?, c: matrix(p, "C")?, d: matrix(p, "D")? };
        let (seconds, found) = timed(calls, || mu_over_frequency(black_box(&system), &structure))?;
        let lower = found.lower.map_or(0.0, |l| l.value);
        json!({ "seconds": seconds, "upper": found.upper.upper, "lower": lower, "intervals": found.upper.pieces.len() })
    };
    println!("{report}");
    Ok(())
}
