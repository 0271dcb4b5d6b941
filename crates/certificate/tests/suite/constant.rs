//! Certificates for a constant parameter: one checked by hand, and the effect of changes of single numbers.

use crate::common::{Refused, integrator, is_at, prove};
use serde_json::{Value, json};
use squid_certificate::{Certificate, Claim, ConstantTheorem};

/// Returns the certificate of `x' = delta x/2 + u + w`, `z = y = x`, `u = -y`, hence `x' = (-1 + delta/2) x + w`: the
/// gain is 2, at delta = 1.
///
/// The channel is `zt = x`, `wt = delta zt`, with the filter `1/(s + 1)` and its states f and g for zt and wt. With
/// `X = diag(1, p, p)` and `S = diag(1/2, e)` the inequality is, after the Schur complements of w and z and without the
/// filters, `-2 + 1/2 + (1/4)/(1/2) + 2/gamma < 0`, that is `gamma > 2`. For `p = 1/20` and `e = 1/50`, f adds
/// `p^2/(2p - e) = 1/32`, and g subtracts `p^2/(2p + e) = 1/48` from the denominator 1/2 of 1/4, so that
/// `gamma > 2/(2 - 1/2 - 12/23 - 1/32) = 2.112` is required.
fn first_order(gamma: f64) -> Value {
    json!({
        "format": "lpv-certificate/1", "blocks": [1], "controller_blocks": [],
        "plant": {
            "A": [[0.0]], "Bt": [[0.5]], "B1": [[1.0]], "B2": [[1.0]], "Ct": [[1.0]], "C1": [[1.0]], "C2": [[1.0]],
            "Dtt": [[0.0]], "Dt1": [[0.0]], "Dt2": [[0.0]], "D1t": [[0.0]], "D11": [[0.0]], "D12": [[0.0]],
            "D2t": [[0.0]], "D21": [[0.0]]
        },
        "controller": {
            "A": [], "By": [], "Bt": [], "Cu": [[]], "Duy": [[-1.0]], "Dut": [[]], "Ct": [], "Dty": [], "Dtt": []
        },
        "claims": [{"constant": {
            "gamma": gamma,
            "X": [[1.0, 0.0, 0.0], [0.0, 0.05, 0.0], [0.0, 0.0, 0.05]],
            "S": [[0.5, 0.0], [0.0, 0.02]],
            "T": [[0.0, 0.0], [0.0, 0.0]],
            "L": [[1.0]],
            "filters": [{"parameter": 0, "pole": 1.0}],
            "lambdas": []
        }}]
    })
}

/// Returns the same certificate with the model error `Delta [1/10 0]` of `[A B2]`: the gain is 1/(1 - 1/2 - 1/10) =
/// 2.5.
fn with_error(gamma: f64) -> Value {
    let mut file = first_order(gamma);
    file["errors"] = json!([{"E": [[1.0]], "F": [[0.1]], "Fu": [[0.0]]}]);
    claim(&mut file)["lambdas"] = json!([10.0]);
    file
}

fn claim(file: &mut Value) -> &mut Value {
    crate::common::claim(file, "constant")
}

fn proved(file: &Value) -> ConstantTheorem {
    prove(file).unwrap().constant.unwrap()
}

#[test]
fn proves_certificate_checked_by_hand() {
    let theorem = proved(&first_order(2.113));
    let numbers = |t: &ConstantTheorem| (t.gamma, t.varying, t.constant, t.scheduled, t.states, t.errors);
    assert_eq!((numbers(&theorem), &theorem.rates), ((2.113, 0, 1, 0, 1, 0), &vec![]));
    assert!(is_at(&prove(&first_order(2.111)).unwrap_err(), "Constant inequality"));
    let with_one = proved(&with_error(2.9));
    assert_eq!(numbers(&with_one), (2.9, 0, 1, 0, 1, 1));
    insta::assert_snapshot!(format!("{theorem}\n\n{with_one}"));
    assert!(prove(&with_error(2.49)).is_err(), "the gain is 2.5");
    let read = Certificate::from_json(&first_order(3.0).to_string()).unwrap();
    assert_eq!(Certificate::from_json(&read.to_json().unwrap()).unwrap(), read);
}

/// Returns the certificate with a delta that may vary: with `S = diag(1/2, e, q)` on the channel, the filtered one and
/// that of the rate, `q rate^2` is added to the terms of f, and g is coupled with v, weighted by `q`:
/// `[-2ap - e, p; p, -q]`.
fn slow(gamma: f64, rate: f64) -> Value {
    let mut file = first_order(gamma);
    claim(&mut file)["filters"][0]["rate"] = rate.into();
    claim(&mut file)["S"] = json!([[0.5, 0.0, 0.0], [0.0, 0.02, 0.0], [0.0, 0.0, 0.05]]);
    claim(&mut file)["T"] = json!([[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]);
    file
}

#[test]
fn proves_bounded_rate_and_no_faster_one() {
    let theorem = proved(&slow(2.5, 0.5));
    assert_eq!((theorem.constant, &theorem.rates), (0, &vec![0.5]));
    let mut refused = Refused::default();
    refused.at("Constant inequality", &slow(2.5, 2.0));
    refused.at("claims[0].constant.filters[0].rate", &slow(2.5, -0.5));
    refused.at("claims[0].constant.S", &slow(2.5, 0.0));
    let mut coupled = slow(2.5, 0.5);
    claim(&mut coupled)["S"][2][0] = 0.001.into();
    claim(&mut coupled)["S"][0][2] = 0.001.into();
    assert!(prove(&coupled).is_err(), "the rate is a parameter of its own");
    let mut negative = slow(2.5, 0.5);
    claim(&mut negative)["S"][2][2] = (-0.05).into();
    refused.at("Constant rate", &negative);
    insta::assert_snapshot!(format!("{}{theorem}", refused.0));
    let read = Certificate::from_json(&slow(2.5, 0.5).to_string()).unwrap();
    assert_eq!(Certificate::from_json(&read.to_json().unwrap()).unwrap(), read);
}

/// Returns the same certificate with a second filter with another pole, whose states and channels have small entries in
/// X and S.
fn two_filters(gamma: f64, rates: [f64; 2]) -> Value {
    let mut file = first_order(gamma);
    claim(&mut file)["filters"] = [1.0, 4.0]
        .iter()
        .zip(rates)
        .map(|(pole, rate)| json!({"parameter": 0, "pole": pole, "rate": rate}))
        .collect();
    let diagonal = |values: &[f64]| -> Value {
        let n = values.len();
        (0..n).map(|i| (0..n).map(|j| if i == j { values[i] } else { 0.0 }).collect::<Vec<_>>()).collect()
    };
    let moving = rates.iter().filter(|rate| **rate > 0.0).count();
    claim(&mut file)["X"] = diagonal(&[1.0, 0.05, 1e-4, 0.05, 1e-4]);
    claim(&mut file)["S"] = diagonal(&[&[0.5, 0.02, 1e-4][..], &[0.05, 1e-3][..moving]].concat());
    claim(&mut file)["T"] = diagonal(&vec![0.0; 3 + moving]);
    file
}

#[test]
fn accepts_two_filters_with_one_rate() {
    let theorem = proved(&two_filters(2.2, [0.0, 0.0]));
    assert_eq!((theorem.constant, theorem.rates), (1, vec![]));
    assert!(prove(&two_filters(2.0, [0.0, 0.0])).is_err(), "the gain is 2");
    let theorem = proved(&two_filters(2.5, [0.5, 0.5]));
    assert_eq!((theorem.constant, theorem.rates), (0, vec![0.5]));
    let mut refused = Refused::default();
    for rates in [[0.5, 0.25], [0.0, 0.5]] {
        refused.at("claims[0].constant.filters[1].rate", &two_filters(2.5, rates));
    }
    insta::assert_snapshot!(refused.0);
    let read = Certificate::from_json(&two_filters(2.5, [0.5, 0.5]).to_string()).unwrap();
    assert_eq!(Certificate::from_json(&read.to_json().unwrap()).unwrap(), read);
}

/// Proves the certificate of Squid's default design, of full size.
#[test]
fn proves_golden_certificate() {
    let path = format!("{}/../../tests/certificates/constant_squid.json", env!("CARGO_MANIFEST_DIR"));
    let mut golden = Certificate::from_json(&std::fs::read_to_string(path).unwrap()).unwrap();
    let theorem = golden.prove().unwrap().constant.unwrap();
    assert_eq!((theorem.varying, theorem.constant, theorem.scheduled, theorem.errors), (2, 13, 1, 3));
    let [Claim::Constant(claim)] = golden.claims.as_mut_slice() else { panic!("one claim") };
    claim.gamma *= 0.8;
    assert!(golden.prove().is_err());
}

/// Returns `true` if the loop is stable and the gain is below gamma at many constant values of delta and of a constant
/// error.
fn is_true(file: &Value) -> bool {
    let n = |at: &str| file.pointer(at).and_then(Value::as_f64).unwrap();
    let (p, k) = (|name: &str| n(&format!("/plant/{name}/0/0")), n("/controller/Duy/0/0"));
    // With u = k y: rows x', zt, z, columns x, wt, w.
    let closed = |row: [&str; 3], b: &str| {
        let y = [p("C2"), p("D2t"), p("D21")];
        [0, 1, 2].map(|j| p(row[j]) + p(b) * k * y[j])
    };
    let (x, t, z) = (
        closed(["A", "Bt", "B1"], "B2"),
        closed(["Ct", "Dtt", "Dt1"], "Dt2"),
        closed(["C1", "D1t", "D11"], "D12"),
    );
    let error = file["errors"].as_array().into_iter().flatten().map(|ball| {
        let at = |key: &str| ball[key][0][0].as_f64().unwrap();
        // This is E (F x + Fu u) with u in terms of x, wt, w.
        let y = [p("C2"), p("D2t"), p("D21")];
        [0, 1, 2].map(|j| at("E") * (if j == 0 { at("F") } else { 0.0 } + at("Fu") * k * y[j]))
    });
    let error = error.fold([0.0; 3], |sum, e: [f64; 3]| [0, 1, 2].map(|j| sum[j] + e[j]));
    let steps = || (-20..=20).map(|i| f64::from(i) / 20.0);
    steps().flat_map(|delta| [-1.0, 0.0, 1.0].map(|size| (delta, size))).all(|(delta, size)| {
        let moved = [0, 1, 2].map(|j| x[j] + size * error[j]);
        let f = delta / (1.0 - delta * t[1]);
        let (a, b) = (moved[0] + moved[1] * f * t[0], moved[2] + moved[1] * f * t[2]);
        let (c, d) = (z[0] + z[1] * f * t[0], z[2] + z[1] * f * t[2]);
        // |c b/(j omega - a) + d| is largest at 0 or at infinity.
        let gain = f64::max((d - c * b / a).abs(), d.abs());
        f.is_finite() && a < 0.0 && gain <= n("/claims/0/constant/gamma") * (1.0 + 1e-12)
    })
}

/// Changes one number at a time: claims that are still proved are true.
#[test]
fn changed_numbers_prove_no_false_claim() {
    let (mut proved, mut refused, mut lies) = (0, 0, 0);
    for file in [first_order(2.2), with_error(2.9), slow(2.5, 0.5)] {
        assert!(prove(&file).is_ok() && is_true(&file));
        for pointer in numbers(&file, "") {
            let old = file.pointer(&pointer).unwrap().as_f64().unwrap();
            for new in
                [-old, 10.0 * old, 0.1 * old, 0.9 * old, 1.1 * old, 0.0, old + 1.0, old - 1.0, old + 1e-3]
            {
                let mut changed = file.clone();
                *changed.pointer_mut(&pointer).unwrap() = new.into();
                let is_so = is_true(&changed);
                lies += usize::from(!is_so);
                match prove(&changed) {
                    Ok(_) => {
                        assert!(is_so, "{pointer}: {old} -> {new} is proved, and not true");
                        proved += 1;
                    }
                    Err(_) => refused += 1,
                }
            }
        }
    }
    assert!(proved > 50 && refused > 100 && lies > 50, "{proved} proved, {refused} refused, {lies} lies");
}

fn numbers(value: &Value, at: &str) -> Vec<String> {
    match value {
        Value::Number(_) if !at.contains("blocks") && !at.ends_with("parameter") => vec![at.to_string()],
        Value::Array(items) => {
            items.iter().enumerate().flat_map(|(i, v)| numbers(v, &format!("{at}/{i}"))).collect()
        }
        Value::Object(items) => items.iter().flat_map(|(k, v)| numbers(v, &format!("{at}/{k}"))).collect(),
        _ => vec![],
    }
}

#[test]
fn names_each_condition() {
    let mut refused = Refused::default();
    let mut at = |place: &str, change: &dyn Fn(&mut Value)| {
        let mut file = with_error(2.9);
        change(&mut file);
        refused.at(place, &file);
    };
    at("Constant L", &|f| claim(f)["L"][0][0] = json!(-1.0));
    at("Constant A'L", &|f| f["plant"]["A"][0][0] = json!(1.0));
    at("Constant multiplier", &|f| claim(f)["S"][1][1] = json!(-0.1));
    at("Constant X", &|f| claim(f)["X"][0][1] = json!(0.1));
    at("Constant T", &|f| claim(f)["T"][0][0] = json!(0.1));
    at("Constant pole", &|f| claim(f)["filters"][0]["pole"] = json!(-1.0));
    at("Constant lambda", &|f| claim(f)["lambdas"][0] = json!(0.0));
    at("Constant gamma", &|f| claim(f)["gamma"] = json!(-2.0));
    at("claims[0].constant.filters[0].parameter", &|f| claim(f)["filters"][0]["parameter"] = json!(1));
    at("claims[0].constant.filters[0].Y", &|f| claim(f)["filters"][0]["Y"] = json!([[1.0]]));
    at("errors[0].E", &|f| f["errors"][0]["E"] = json!([[1.0], [1.0]]));
    at("errors[0].F", &|f| f["errors"][0]["F"] = json!([[1.0, 1.0]]));
    at("claims[0].constant.X", &|f| claim(f)["X"] = json!([[1.0]]));
    at("claims[0].constant.S", &|f| claim(f)["S"] = json!([[1.0]]));
    at("claims[0].constant.L", &|f| claim(f)["L"] = json!([]));
    at("claims[0].constant.lambdas", &|f| claim(f)["lambdas"] = json!([1.0, 1.0]));
    at("claims[0].constant", &|f| f["plant"]["D22"] = json!([[1.0]]));
    at("claims[0].constant.filters", &|f| claim(f)["filters"] = json!(1.0));
    at("claims[0].constant.poles", &|f| claim(f)["poles"] = json!(1.0));
    let other = integrator(1.25)["claims"][0].clone();
    at("claims[0].constant", &|f| f["claims"].as_array_mut().unwrap().push(other.clone()));
    insta::assert_snapshot!(refused.0);
}
