//! Readers of the cases with known answers.

use serde_json::Value;
use squid_lpv::matrix::Mat;
use squid_lpv::partition::{PLANT, names};
use squid_lpv::plant::GeneralisedPlant;
use squid_lpv::state_space::StateSpace;

/// Returns the case `name` of the repository's `tests/cases`.
pub fn case(name: &str) -> Value {
    let path = format!("{}/../../tests/cases/{name}.json", env!("CARGO_MANIFEST_DIR"));
    serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap()
}

/// Returns a matrix given as a list of rows.
pub fn matrix(value: &Value) -> Mat {
    let rows: Vec<Vec<f64>> = serde_json::from_value(value.clone()).unwrap();
    squid_lpv::matrix::from_rows(&rows, rows.first().map_or(0, Vec::len)).unwrap()
}

/// Returns the plant of a case of kind `lpvsyn-lft` or `hinfsyn`.
pub fn plant(case: &Value) -> GeneralisedPlant {
    let data = &case["data"];
    let scheduled = data.get("P").is_some();
    let p = if scheduled { &data["P"] } else { data };
    let given =
        names(PLANT).filter(|(key, _, _)| p.get(key).is_some_and(|rows| rows != &serde_json::json!([])));
    let blocks: Vec<_> = given.map(|(key, row, column)| (row, column, matrix(&p[key]))).collect();
    let repetitions =
        if scheduled { serde_json::from_value(data["blocks"].clone()).unwrap() } else { vec![] };
    GeneralisedPlant::new(repetitions, &blocks).unwrap()
}

/// Returns the plant, the controller and the sample time of a case of kind `sampled`.
pub fn sampled(case: &Value) -> (GeneralisedPlant, StateSpace, f64) {
    let data = &case["data"];
    let [a, b, c, d] = ["A", "B", "C", "D"].map(|key| matrix(&data["K"][key]));
    let plant = plant(&serde_json::json!({ "data": { "P": data["P"], "blocks": [] } }));
    (plant, StateSpace { a, b, c, d }, data["sample_time"].as_f64().unwrap())
}
