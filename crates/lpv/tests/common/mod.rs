//! Reads the cases with known answers.
#![allow(dead_code)] // Each test file uses a part.

use lpv::matrix::Mat;
use lpv::plant::GeneralisedPlant;
use serde_json::Value;

/// The case `name` of the repository's `tests/cases`.
pub fn case(name: &str) -> Value {
    let path = format!("{}/../../tests/cases/{name}.json", env!("CARGO_MANIFEST_DIR"));
    serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap()
}

/// A matrix given as a list of rows.
pub fn matrix(value: &Value) -> Mat {
    let rows: Vec<Vec<f64>> = serde_json::from_value(value.clone()).unwrap();
    lpv::matrix::from_rows(&rows, rows.first().map_or(0, Vec::len)).unwrap()
}

/// The plant of a case of kind `lpvsyn-lft` or `hinfsyn`.
pub fn plant(case: &Value) -> GeneralisedPlant {
    let data = &case["data"];
    let scheduled = data.get("P").is_some();
    let p = if scheduled { &data["P"] } else { data };
    let m = |key: &str| matrix(&p[key]);
    let (a, b1, b2, c1, c2) = (m("A"), m("B1"), m("B2"), m("C1"), m("C2"));
    let (n, w, u, z, y) = (a.nrows(), b1.ncols(), b2.ncols(), c1.nrows(), c2.nrows());
    let part = |key: &str, rows: usize, cols: usize| if scheduled { m(key) } else { Mat::zeros(rows, cols) };
    GeneralisedPlant {
        bt: part("Bt", n, 0),
        ct: part("Ct", 0, n),
        dtt: part("Dtt", 0, 0),
        dt1: part("Dt1", 0, w),
        dt2: part("Dt2", 0, u),
        d1t: part("D1t", z, 0),
        d2t: part("D2t", y, 0),
        d11: m("D11"),
        d12: m("D12"),
        d21: m("D21"),
        blocks: if scheduled { serde_json::from_value(data["blocks"].clone()).unwrap() } else { vec![] },
        a,
        b1,
        b2,
        c1,
        c2,
    }
}

/// The plant of the certificate `name` of the repository's `tests/certificates`.
pub fn certified_plant(name: &str) -> GeneralisedPlant {
    let path = format!("{}/../../tests/certificates/{name}.json", env!("CARGO_MANIFEST_DIR"));
    let certificate: Value = serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
    plant(&serde_json::json!({ "data": { "P": certificate["plant"], "blocks": certificate["blocks"] } }))
}
