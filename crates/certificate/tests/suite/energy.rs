//! The claims for w of bounded energy, on a loop that can be checked by hand.

use crate::common::{add, claim, prove};
use serde_json::{Value, json};

/// `x' = a x + u + w`, `z = y = x`, `u = -y`, `|u| <= 1`, with one bound.
fn saturated(a: f64, bound: Value) -> Value {
    let mut c = json!({
        "format": "lpv-certificate/1", "blocks": [], "controller_blocks": [],
        "plant": {
            "A": [[a]], "Bt": [[]], "B1": [[1.0]], "B2": [[1.0]], "Ct": [], "C1": [[1.0]], "C2": [[1.0]],
            "Dtt": [], "Dt1": [], "Dt2": [], "D1t": [[]], "D11": [[0.0]], "D12": [[0.0]], "D2t": [[]], "D21": [[0.0]]
        },
        "controller": {
            "A": [], "By": [], "Bt": [], "Cu": [[]], "Duy": [[-1.0]], "Dut": [[]], "Ct": [], "Dty": [], "Dtt": []
        },
        "claims": [{"gain": {"gamma": 1.25, "X": [[1.0]], "S": [], "T": []}}]
    });
    add(&mut c, "energy", json!({"limits": [1.0], "E": [], "bounds": [bound]}));
    c
}

/// With `H = -g` the form in (x, phi, w) is `[2 X (a - 1) + 1/gamma, -X - 2 U (1 - g), X; *, -4 U, 0; *, *, -gamma]`,
/// negative where `4 U (2 X (1 - a) - 1/gamma - X^2/gamma) > (X + 2 U (1 - g))^2`: here 12 > 11.56. The limit is out of
/// reach where `gamma beta g^2 < X`, here for beta below 2.367.
fn integrator() -> Value {
    saturated(
        0.0,
        json!({
            "gamma": 2.0, "beta": 2.36, "X": [[2.0]], "S": [], "T": [], "U": [2.0], "H": [[-0.65]]
        }),
    )
}

fn with(mut c: Value, key: &str, value: Value) -> Value {
    claim(&mut c, "energy")["bounds"][0][key] = value;
    c
}

#[test]
fn a_loop_by_hand() {
    let theorem = prove(&integrator()).unwrap();
    assert!(
        theorem.ends_with(
            "the gain from rest is below 2 for every w of an energy of at most 2.36, and with w = 0 the state then \
             returns to rest exponentially."
        ),
        "{theorem}"
    );
    // Up to their bounds, and no further.
    let (inequality, limit) = ("the matrix of the inequality", "[X h'; h limit^2/(gamma beta)] of limit 0");
    for (key, true_, false_, refusal) in [
        ("beta", json!(2.366), json!(2.367), limit),
        ("H", json!([[-0.6509]]), json!([[-0.651]]), limit),
        ("H", json!([[-0.634]]), json!([[-0.633]]), inequality),
        ("U", json!([1.8]), json!([1.6]), inequality),
        ("gamma", json!(1.98), json!(1.9), inequality),
        ("gamma", json!(2.005), json!(2.006), limit),
        ("X", json!([[1.997]]), json!([[1.992]]), limit),
    ] {
        assert!(prove(&with(integrator(), key, true_.clone())).is_ok(), "{key} {true_}");
        let found = prove(&with(integrator(), key, false_.clone())).unwrap_err();
        assert!(
            found.contains(refusal) && found.starts_with("bound 0 of bounded energy is not proved"),
            "{key} {false_}: {found}"
        );
    }
    let mut limits = integrator();
    claim(&mut limits, "energy")["limits"] = json!([0.99]);
    assert!(prove(&limits).unwrap_err().contains(limit));
}

/// With a = -1 H may be 0, and the claim is about every w; beside it may stand another. An integrator can have none.
#[test]
fn a_claim_about_every_w() {
    let every = json!({
        "gamma": 2.0, "beta": 1.0, "X": [[2.0]], "S": [], "T": [], "U": [1.0], "H": [[0.0]]
    });
    let mut stable = saturated(-1.0, every.clone());
    assert!(prove(&stable).unwrap().contains("is below 2 for every w, and with w = 0"));
    let small = json!({
        "gamma": 1.0, "beta": 0.5, "X": [[1.4]], "S": [], "T": [], "U": [2.0], "H": [[-0.8]]
    });
    claim(&mut stable, "energy")["bounds"] = json!([small, every]);
    let theorem = prove(&stable).unwrap();
    assert!(
        theorem.contains("below 1 for every w of an energy of at most 0.5, below 2 for every w, and"),
        "{theorem}"
    );
    claim(&mut stable, "energy")["bounds"][1]["U"] = json!([0.1]);
    assert!(prove(&stable).unwrap_err().starts_with("bound 1 of bounded energy is not proved"));
    for u in [0.1, 0.5, 1.0, 2.0, 10.0] {
        let found = prove(&with(saturated(0.0, every.clone()), "U", json!([u]))).unwrap_err();
        assert!(found.contains("the matrix of the inequality is not negative definite"), "{found}");
    }
}

#[test]
fn bad_input_is_named_in_one_sentence() {
    for (key, value, message) in [
        ("beta", json!(0.0), "bound 0 of bounded energy is not proved: beta is 0e0, must be above 0"),
        ("gamma", json!(-2.0), "bound 0 of bounded energy is not proved: gamma is -2e0, must be above 0"),
        ("X", json!([[-2.0]]), "bound 0 of bounded energy is not proved: X is not positive definite"),
        ("U", json!([-2.0]), "bound 0 of bounded energy is not proved: S is not positive definite"),
        ("U", json!([]), "claims[1].energy.bounds[0].U: has 0 entries, must have 1 (controls u)"),
        (
            "H",
            json!([[1.0, 2.0]]),
            "claims[1].energy.bounds[0].H: row 0 has 2 numbers, must have 1 (states of plant",
        ),
        ("S", json!([[1.0]]), "claims[1].energy.bounds[0].S: found 1 rows, must have 0 (channels"),
        ("size", json!(1), "claims[1].energy.bounds[0].size: unknown field `size`, expected one of"),
    ] {
        let found = prove(&with(integrator(), key, value)).unwrap_err();
        assert!(found.starts_with(message) && !found.contains('\n'), "{found}");
    }
    for (key, value, message) in [
        (
            "limits",
            json!([-1.0]),
            "bound 0 of bounded energy is not proved: a limit is -1e0, must be above 0",
        ),
        ("limits", json!([1.0, 1.0]), "claims[1].energy.limits: has 2 entries, must have 1 (controls u)"),
        ("E", json!([[1.0]]), "claims[1].energy.E: found 1 rows, must have 0 (controller's states)"),
        ("bounds", json!([]), "claims[1].energy.bounds: has no entries, must have at least one (bounds)"),
        (
            "bounds",
            json!(vec![claim(&mut integrator(), "energy")["bounds"][0].clone(); 101]),
            "claims[1].energy.bounds: has 101 entries, must have at most 100",
        ),
        ("bounds", json!(1), "claims[1].energy.bounds: invalid type: integer `1`, expected a list"),
    ] {
        let mut wrong = integrator();
        claim(&mut wrong, "energy")[key] = value;
        let found = prove(&wrong).unwrap_err();
        assert!(found.starts_with(message) && !found.contains('\n'), "{found}");
    }
    let mut direct = integrator();
    direct["plant"]["D22"] = json!([[0.5]]);
    assert!(
        prove(&direct)
            .unwrap_err()
            .starts_with("claims[1].energy: is of plants without a direct path from u to y")
    );
}

/// What is claimed of a loop in continuous time is refused of one in discrete time.
#[test]
fn of_continuous_time_alone() {
    let mut discrete = integrator();
    discrete["discrete"] = json!(true);
    assert!(prove(&discrete).unwrap_err().starts_with("claims[1].energy: is of a loop in continuous time"));
    discrete["discrete"] = json!("yes");
    assert!(
        prove(&discrete)
            .unwrap_err()
            .starts_with("discrete: invalid type: string \"yes\", expected a boolean")
    );
}
