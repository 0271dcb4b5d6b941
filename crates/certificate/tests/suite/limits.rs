//! Claim with limits, on a loop that can be checked by hand, and by another route on that of Squid.

use crate::common::{add, add_model_error, claim, prove, remove};
use serde_json::{Value, json};
use squid_certificate::Certificate;

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
    assert!(theorem.contains("a step of at most 0.4 from rest at input 0, behind the filters"), "{theorem}");
    assert!(theorem.ends_with("exponentially, within its region: x'Xx decays with the rate 1."), "{theorem}");
    // Values are accepted up to their bounds, and no further.
    for (key, true_, false_, refusal) in [
        ("U", json!([1.26]), json!([1.25]), "the matrix of the inequality"),
        ("beta", json!([1.24]), json!([1.26]), "[X h'; h limit^2/(4 beta)] of limit 0"),
        ("beta", json!([0.81]), json!([0.79]), "a step of 4e-1 takes x'Xx to beta"),
        ("H", json!([[-1.1]]), json!([[-1.12]]), "[X h'; h limit^2/(4 beta)] of limit 0"),
        ("X", json!([[6.2]]), json!([[6.3]]), "a step of 4e-1 takes x'Xx to beta"),
        ("X", json!([[4.1]]), json!([[3.9]]), "[X h'; h limit^2/(4 beta)] of limit 0"),
        ("size", json!(0.44), json!(0.45), "a step of 4.5e-1 takes x'Xx to beta"),
        ("limits", json!([0.9]), json!([0.89]), "[X h'; h limit^2/(4 beta)] of limit 0"),
        ("decay", json!(1.3), json!(1.4), "the matrix of the inequality"),
    ] {
        let unpacked = |v: &Value| if key == "beta" { v[0].clone() } else { v.clone() };
        assert!(prove(&with(integrator(), key, unpacked(&true_))).is_ok(), "{key} {true_}");
        let found = prove(&with(integrator(), key, unpacked(&false_))).unwrap_err();
        assert!(
            found.contains(refusal) && found.starts_with("the claim with limits is not proved"),
            "{found}"
        );
    }
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
    assert!(prove(&everywhere(1.0)).unwrap().contains("exponentially, from every state"));
    // The decay rate of a limited integrator is bounded.
    assert!(
        prove(&everywhere(0.0))
            .unwrap_err()
            .contains("the matrix of the inequality is not negative definite")
    );
    // The held step uses 0.9/2 of the limit; a step of 1.1 would use more than half.
    let found = prove(&with(with(everywhere(1.0), "size", json!(1.1)), "X", json!([[3.0]]))).unwrap_err();
    assert!(found.contains("more than half of limit 0"), "{found}");
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
    assert!(
        theorem.contains("limits in the file and the rate of 1 state of the plant limited, anti-windup"),
        "{theorem}"
    );
    for (key, value, refusal) in [
        ("U", json!([1.33, 2.0]), "the matrix of the inequality is not negative definite"),
        ("U", json!([1.34, 0.0]), "S is not positive definite"),
        ("limits", json!([1.0, 0.89]), "[X h'; h limit^2/(4 beta)] of limit 1"),
        ("limits", json!([1.0, -1.0]), "a limit is -1e0, must be above 0"),
        ("u_held", json!([0.0, 2.0]), "the matrix of the inequality is not negative definite"),
        ("rates", json!([]), "claims[2].limits.H: found 2 rows, must have 1 (controls u and rates)"),
        (
            "rates",
            json!([1]),
            "claims[2].limits.rates[0]: found 1, allowed is a state of the plant that the loop moves",
        ),
        (
            "rates",
            json!([0, 0]),
            "claims[2].limits.rates[1]: found 0, allowed is a state of the plant that the loop moves",
        ),
        (
            "rates",
            json!([0.5]),
            "claims[2].limits.rates[0]: invalid type: floating point `0.5`, expected a whole number from 0",
        ),
    ] {
        let found = prove(&by_rate(key, value.clone())).unwrap_err();
        assert!(found.contains(refusal), "{key} {value}: {found}");
    }
    let mut moved = by_rate("rates", json!([0]));
    moved["errors"][0]["E"] = json!([[0.1]]);
    let found = prove(&moved).unwrap_err();
    assert!(
        found.ends_with("a state of the plant that the loop moves and Delta does not, each once"),
        "{found}"
    );
}

#[test]
fn names_invalid_input_in_one_sentence() {
    for (key, value, message) in [
        ("limits", json!([-1.0]), "the claim with limits is not proved: a limit is -1e0, must be above 0"),
        (
            "limits",
            json!([1.0, 1.0]),
            "claims[2].limits.limits: has 2 entries, must have 1 (controls u and rates)",
        ),
        ("beta", json!(0.0), "the claim with limits is not proved: beta is 0e0, must be above 0"),
        ("size", json!(-0.4), "the claim with limits is not proved: size is -4e-1, must be above 0"),
        ("decay", json!(0.0), "the claim with limits is not proved: decay is 0e0, must be above 0"),
        ("lambda", json!(-1.0), "the claim with limits is not proved: lambda is -1e0, must be above 0"),
        ("X", json!([[-5.0]]), "the claim with limits is not proved: X is not positive definite"),
        ("U", json!([-2.0]), "the claim with limits is not proved: S is not positive definite"),
        ("U", json!([]), "claims[2].limits.U: has 0 entries, must have 1 (controls u and rates)"),
        (
            "H",
            json!([[1.0, 2.0]]),
            "claims[2].limits.H: row 0 has 2 numbers, must have 1 (states of the loop with limits)",
        ),
        ("input", json!(1), "claims[2].limits.input: found 1, must be below 1, the number of inputs w"),
        ("more", json!(1), "claims[2].limits.more: unknown field `more`"),
    ] {
        let found = prove(&with(integrator(), key, value)).unwrap_err();
        assert!(found.starts_with(message) && !found.contains('\n'), "{found}");
    }
    let mut alone = integrator();
    alone.as_object_mut().unwrap().remove("errors");
    for path in ["claims[1].gain", "claims[0].limits"] {
        assert_eq!(
            prove(&alone).unwrap_err(),
            format!(
                "{path}: needs one model error in `errors`, and the claim `gain` with lambda, which covers it"
            )
        );
        remove(&mut alone, "gain");
    }
    let mut direct = integrator();
    direct["plant"]["D22"] = json!([[0.5]]);
    assert!(
        prove(&direct)
            .unwrap_err()
            .starts_with("claims[2].limits: is of plants without a direct path from u to y")
    );
}

/// Checks that the theorem does not mention limits without the claim.
#[test]
fn other_claims_stand_without_limits() {
    let mut without = integrator();
    remove(&mut without, "limits");
    assert!(!prove(&without).unwrap().contains("limits"));
    let mut discrete = integrator();
    discrete["discrete"] = json!(true);
    assert!(prove(&discrete).unwrap_err().starts_with("claims[1].gain: is of a loop in continuous time"));
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
    for (direct, size) in [(0.0, 1e9), (1e-9, 0.4e9), (2.0, 0.2)] {
        let mut crafted = with(filtered(direct, 0.5), "size", json!(size));
        for key in ["x_held", "u_held"] {
            let held = &mut claim(&mut crafted, "limits")[key][0];
            *held = json!(direct * held.as_f64().unwrap());
        }
        let found = prove(&crafted).unwrap_err();
        assert!(
            found.starts_with("claims[2].limits.input: found 0, allowed is an input w whose step is a jump"),
            "{found}"
        );
    }
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
