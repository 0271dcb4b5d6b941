//! Claim with limits, on a loop that can be checked by hand, and by another route on that of Squid.

use crate::common::{Refused, add, add_model_error, claim, prove, remove};
use serde_json::{Value, json};
use squid_certificate::{Certificate, LimitTheorem};

/// Returns the certificate of `x' = -a x + u`, `y = r - x`, `u = y`, `|u| <= 1`: with e = u - H x the form is, in x and
/// phi, apart from its terms in r, `[(alpha - 2 (1 + a)) X, *; -X - 2 U (1 + H), -4 U]`. A step r is held by
/// `x = r/(1 + a)`, `u = a r/(1 + a)`.
fn saturated(a: f64, limits: Value) -> Value {
    let zero = json!([[0.0]]);
    let mut c = json!({
        "format": "lpv-certificate/1", "blocks": [], "controller_blocks": [],
        "plant": {
            "A": [[-a]], "Bt": [[]], "B1": [[0.0]], "B2": [[1.0]], "Ct": [], "C1": [[1.0]], "C2": [[-1.0]],
            "Dtt": [], "Dt1": [], "Dt2": [], "D1t": [[]], "D11": [[0.0]], "D12": [[0.0]], "D2t": [[]], "D21": [[1.0]]
        },
        "controller": {
            "A": [], "By": [], "Bt": [], "Cu": [[]], "Duy": [[1.0]], "Dut": [[]], "Ct": [], "Dty": [], "Dtt": []
        },
        "claims": [{"gain": {"gamma": 1.25, "X": [[1.0]], "S": [], "T": []}}]
    });
    add_model_error(
        &mut c,
        json!({
            "E": zero, "F": zero, "Fu": zero, "lambda": 1.0, "gamma": 1.25, "X": [[1.0]], "S": [], "T": []
        }),
    );
    add(&mut c, "limits", limits);
    c
}

/// Returns the case a = 0, H = -1, where e = 0: the form is negative for 4 U > X; the limit is out of reach for 4 beta
/// < X, and steps below `(beta/X)^(1/2)` stay inside.
fn integrator() -> Value {
    saturated(
        0.0,
        json!({
            "input": 0, "size": 0.4, "limits": [1.0], "E": [], "decay": 1.0, "beta": 1.0, "x_held": [1.0],
            "u_held": [0.0], "lambda": 1.0, "X": [[5.0]], "S": [], "T": [], "U": [2.0], "H": [[-1.0]]
        }),
    )
}

fn with(mut c: Value, key: &str, value: Value) -> Value {
    claim(&mut c, "limits")[key] = value;
    c
}

#[test]
fn loop_by_hand() {
    let theorem = prove(&integrator()).unwrap();
    let expected =
        LimitTheorem { input: 0, size: 0.4, decay: 1.0, delta_rows: None, rates: 0, everywhere: false };
    assert_eq!(theorem.limits, Some(expected));
    let mut refused = Refused::default();
    // Values are accepted up to their bounds, and no further.
    for (key, true_, false_, place) in [
        ("U", json!([1.26]), json!([1.25]), "Limits inequality"),
        ("beta", json!([1.24]), json!([1.26]), "Limits limit"),
        ("beta", json!([0.81]), json!([0.79]), "Limits size"),
        ("H", json!([[-1.1]]), json!([[-1.12]]), "Limits limit"),
        ("X", json!([[6.2]]), json!([[6.3]]), "Limits size"),
        ("X", json!([[4.1]]), json!([[3.9]]), "Limits limit"),
        ("size", json!(0.44), json!(0.45), "Limits size"),
        ("limits", json!([0.9]), json!([0.89]), "Limits limit"),
        ("decay", json!(1.3), json!(1.4), "Limits inequality"),
    ] {
        let unpacked = |v: &Value| if key == "beta" { v[0].clone() } else { v.clone() };
        assert!(prove(&with(integrator(), key, unpacked(&true_))).is_ok(), "{key} {true_}");
        refused.at(place, &with(integrator(), key, unpacked(&false_)));
    }
    insta::assert_snapshot!(format!("{}{theorem}", refused.0));
}

/// Checks a = 1, where H may be 0: the limit may be reached, and the claim holds from every state.
#[test]
fn claim_holds_from_every_state() {
    let everywhere = |a: f64| {
        saturated(
            a,
            json!({
                "input": 0, "size": 0.9, "limits": [1.0], "E": [], "decay": 1.0, "beta": 1.0, "x_held": [0.5],
                "u_held": [0.5], "lambda": 1.0, "X": [[4.0]], "S": [], "T": [], "U": [2.0], "H": [[0.0]]
            }),
        )
    };
    let theorem = prove(&everywhere(1.0)).unwrap();
    assert!(theorem.limits.unwrap().everywhere);
    let mut refused = Refused::default();
    // The decay rate of a limited integrator is bounded.
    refused.at("Limits inequality", &everywhere(0.0));
    // The held step uses 0.9/2 of the limit; a step of 1.1 would use more than half.
    refused.at("Limits size", &with(with(everywhere(1.0), "size", json!(1.1)), "X", json!([[3.0]])));
    insta::assert_snapshot!(format!("{}{theorem}", refused.0));
}

/// Checks the integrator with a limit on its rate as well as its command. With H = -1 for both, `x' = -x - phi - psi`
/// and the rate minus H x is -phi: the form is, in x, phi and psi, `-[5 5 5; 5 4U_1 2U_2; 5 2U_2 4U_2]`, and for U_2 =
/// 2 negative for U_1 > 4/3.
#[test]
fn rate_limit_by_hand() {
    let by_rate = |key: &str, value: Value| {
        let limits = json!({
            "input": 0, "size": 0.4, "limits": [1.0, 1.0], "rates": [0], "E": [], "decay": 1.0, "beta": 1.0,
            "x_held": [1.0], "u_held": [0.0, 0.0], "lambda": 1.0, "X": [[5.0]], "S": [], "T": [], "U": [1.34, 2.0],
            "H": [[-1.0], [-1.0]]
        });
        with(saturated(0.0, limits), key, value)
    };
    let theorem = prove(&by_rate("rates", json!([0]))).unwrap();
    assert_eq!(theorem.limits.unwrap().rates, 1);
    let mut refused = Refused::default();
    for (key, value, place) in [
        ("U", json!([1.33, 2.0]), "Limits inequality"),
        ("U", json!([1.34, 0.0]), "Limits S"),
        ("limits", json!([1.0, 0.89]), "Limits limit"),
        ("limits", json!([1.0, -1.0]), "Limits limit"),
        ("u_held", json!([0.0, 2.0]), "Limits inequality"),
        ("rates", json!([]), "claims[2].limits.H"),
        ("rates", json!([1]), "claims[2].limits.rates[0]"),
        ("rates", json!([0, 0]), "claims[2].limits.rates[1]"),
        ("rates", json!([0.5]), "claims[2].limits.rates[0]"),
    ] {
        refused.at(place, &by_rate(key, value));
    }
    let mut moved = by_rate("rates", json!([0]));
    moved["errors"][0]["E"] = json!([[0.1]]);
    refused.at("claims[2].limits.rates[0]", &moved);
    insta::assert_snapshot!(format!("{}{theorem}", refused.0));
}

#[test]
fn names_invalid_input_in_one_sentence() {
    let mut refused = Refused::default();
    for (key, value, place) in [
        ("limits", json!([-1.0]), "Limits limit"),
        ("limits", json!([1.0, 1.0]), "claims[2].limits.limits"),
        ("beta", json!(0.0), "Limits beta"),
        ("size", json!(-0.4), "Limits size"),
        ("decay", json!(0.0), "Limits decay"),
        ("lambda", json!(-1.0), "Limits lambda"),
        ("X", json!([[-5.0]]), "Limits X"),
        ("U", json!([-2.0]), "Limits S"),
        ("U", json!([]), "claims[2].limits.U"),
        ("H", json!([[1.0, 2.0]]), "claims[2].limits.H"),
        ("input", json!(1), "claims[2].limits.input"),
        ("more", json!(1), "claims[2].limits.more"),
    ] {
        refused.at(place, &with(integrator(), key, value));
    }
    let mut alone = integrator();
    alone.as_object_mut().unwrap().remove("errors");
    for path in ["claims[1].gain", "claims[0].limits"] {
        refused.at(path, &alone);
        remove(&mut alone, "gain");
    }
    let mut direct = integrator();
    direct["plant"]["D22"] = json!([[0.5]]);
    refused.at("claims[2].limits", &direct);
    insta::assert_snapshot!(refused.0);
}

#[test]
fn other_claims_stand_without_limits() {
    let mut without = integrator();
    remove(&mut without, "limits");
    assert_eq!(prove(&without).unwrap().limits, None);
    let mut discrete = integrator();
    discrete["discrete"] = json!(true);
    Refused::default().at("claims[1].gain", &discrete);
}

/// Returns the integrator with a filter `x_f' = -x_f + r` from the reference to y, and the direct and filtered parts
/// weighted by the arguments.
fn filtered(direct: f64, of_filter: f64) -> Value {
    let mut c = integrator();
    c["plant"] = json!({
        "A": [[0.0, 0.0], [0.0, -1.0]], "Bt": [[], []], "B1": [[0.0], [1.0]], "B2": [[1.0], [0.0]], "Ct": [],
        "C1": [[1.0, 0.0]], "C2": [[-1.0, of_filter]], "Dtt": [], "Dt1": [], "Dt2": [], "D1t": [[]],
        "D11": [[0.0]], "D12": [[0.0]], "D2t": [[]], "D21": [[direct]]
    });
    c["errors"][0]["E"] = json!([[0.0], [0.0]]);
    c["errors"][0]["F"] = json!([[0.0, 0.0]]);
    for gain in 0..2 {
        c["claims"][gain]["gain"]["X"] = json!([[1.0, 0.0], [0.0, 1.0]]);
        c["claims"][gain]["gain"]["gamma"] = json!(10.0);
    }
    c
}

/// Rejects a step through a filter without feedthrough: the loop without the filter would not get the step, and any
/// size would be proved.
#[test]
fn rejects_step_removed_with_a_filter() {
    assert!(prove(&filtered(1.0, 0.5)).is_ok(), "{:?}", prove(&filtered(1.0, 0.5)));
    let mut refused = Refused::default();
    for (direct, size) in [(0.0, 1e9), (1e-9, 0.4e9), (2.0, 0.2)] {
        let mut crafted = with(filtered(direct, 0.5), "size", json!(size));
        for key in ["x_held", "u_held"] {
            let held = &mut claim(&mut crafted, "limits")[key][0];
            *held = json!(direct * held.as_f64().unwrap());
        }
        refused.at("claims[2].limits.input", &crafted);
    }
    insta::assert_snapshot!(refused.0);
}

/// Checks that the step may reach only one y of a loop with two states and another y: directly, and additionally
/// through filters.
#[test]
fn step_reaches_one_measurement() {
    let mut c = Certificate::from_json(&filtered(1.0, 0.5).to_string()).unwrap();
    c.plant.c2 = vec![vec![-1.0, 0.5], vec![1.0, 0.0]];
    c.plant.d21 = vec![vec![1.0], vec![0.0]];
    assert_eq!(c.jumping_measurement(0), Some(0));
    let refused = |change: &dyn Fn(&mut Certificate)| {
        let mut changed = c.clone();
        change(&mut changed);
        assert_eq!(changed.jumping_measurement(0), None);
    };
    refused(&|c| c.plant.d21[0][0] = 0.5);
    refused(&|c| c.plant.d21[1][0] = 1.0);
    refused(&|c| c.plant.b1[0][0] = 1.0);
    // Other paths through the filter: to the other y, to the loop's state, to Delta.
    refused(&|c| c.plant.c2[1][1] = 0.1);
    refused(&|c| c.plant.a[0][1] = 0.1);
    refused(&|c| c.errors[0].f[0][1] = 0.1);
    // Another path: through a channel from the filter to the other y.
    refused(&|c| {
        c.plant.ct = vec![vec![0.0, 1.0]];
        c.plant.dtt = vec![vec![0.0]];
        c.plant.dt1 = vec![vec![0.0]];
        c.plant.dt2 = vec![vec![0.0]];
        c.plant.bt = vec![vec![0.0]; 2];
        c.plant.d2t = vec![vec![0.0], vec![1.0]];
    });
}

/// Checks that filters of w and of z do not belong to the loop.
#[test]
fn weights_are_omitted() {
    let plain = Certificate::from_json(&integrator().to_string()).unwrap();
    assert_eq!(plain.moving_states(), [0]);
    let mut c = plain;
    // State 1 filters w, state 2 weighs x.
    c.plant.a = vec![vec![0.0, 0.0, 0.0], vec![0.0, -1.0, 0.0], vec![1.0, 0.0, -1.0]];
    c.plant.b1 = vec![vec![0.0], vec![1.0], vec![0.0]];
    c.plant.b2 = vec![vec![1.0], vec![0.0], vec![0.0]];
    c.plant.bt = vec![vec![]; 3];
    c.plant.c1 = vec![vec![0.0, 0.0, 1.0]];
    c.plant.c2 = vec![vec![-1.0, 1.0, 0.0]];
    assert_eq!(c.moving_states(), [0]);
    c.plant.c2[0][2] = 1.0;
    assert_eq!(c.moving_states(), [0, 2]);
    // A parameter-dependent filter of w does not belong to it either, unless controls drive its channel.
    c.plant.bt = vec![vec![0.0], vec![1.0], vec![0.0]];
    c.plant.ct = vec![vec![0.0, 1.0, 0.0]];
    (c.plant.dtt, c.plant.dt2) = (vec![vec![0.0]], vec![vec![0.0]]);
    assert_eq!(c.moving_states(), [0, 2]);
    c.plant.dt2 = vec![vec![1.0]];
    assert_eq!(c.moving_states(), [0, 1, 2]);
}
