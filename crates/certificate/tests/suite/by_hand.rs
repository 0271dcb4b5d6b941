//! Certificates whose numbers can be checked by hand, at and next to their limits.

use crate::common::{Refused, add_model_error, claim, integrator, is_at, prove, scheduled};
use serde_json::{Value, json};
use squid_certificate::{ClaimName, Failure};

/// Returns the pivot that refutes the inequality of the claim `gain`.
fn pivot(file: &Value) -> f64 {
    let failure = prove(file).unwrap_err();
    match failure {
        Failure::NotDefinite { claim: ClaimName::Gain, pivot: Some(pivot), .. } => pivot,
        other => panic!("{other}"),
    }
}

#[test]
fn bound_is_strict_to_last_bit() {
    assert!(prove(&integrator(1.0_f64.next_up())).is_ok());
    let mut refused = Refused::default();
    refused.at("Gain inequality", &integrator(1.0));
    refused.at("Gain inequality", &integrator(1.0_f64.next_down()));
    insta::assert_snapshot!(refused.0);
}

#[test]
fn one_parameter_in_plant_and_controller() {
    // 2/3 lies between two f64; the larger is proved, the smaller is not.
    let above = if 3.0 * (2.0_f64 / 3.0) > 2.0 { 2.0 / 3.0 } else { (2.0_f64 / 3.0).next_up() };
    let theorem = prove(&scheduled(0.75)).unwrap();
    assert_eq!((theorem.gamma, theorem.gamma_with_model_error), (Some(0.75), None));
    assert_eq!((theorem.parameters, theorem.scheduled, theorem.states), (1, 1, 1));
    insta::assert_snapshot!(theorem);
    assert!(prove(&scheduled(above)).is_ok());
    assert!(prove(&scheduled((2.0_f64 / 3.0).next_down())).is_err());
}

/// Returns the integrator with `y = x + d u`: `u = k y` is `u = -x` for `k = -1/(1 - d)`, and det(I - Duy D22) is
/// `1/(1 - d)`.
fn with_direct_path(d: f64, k: f64, gamma: f64) -> Value {
    let mut c = integrator(gamma);
    c["plant"]["D22"] = json!([[d]]);
    c["controller"]["Duy"] = json!([[k]]);
    c
}

#[test]
fn direct_path_is_closed_without_rounding() {
    for (d, k) in [(0.5, -2.0), (-1.0, -0.5), (3.0, 0.5), (0.0, -1.0)] {
        assert!(prove(&with_direct_path(d, k, 1.0_f64.next_up())).is_ok(), "{d}");
        assert_eq!(pivot(&with_direct_path(d, k, 1.0)), 0.0);
        let below = pivot(&with_direct_path(d, k, 1.0_f64.next_down()));
        assert!((below - f64::EPSILON).abs() < 1e-19, "{d}: {below}");
        // The model error depends on u, too: see residual_of_control_matrix_acts_through_controller.
        let with = |gamma: f64| {
            let mut c = with_direct_path(d, k, 1.25);
            add_model_error(
                &mut c,
                json!({"E": [[0.25]], "F": [[0.0]], "Fu": [[1.0]], "lambda": 0.25, "gamma": gamma,
                "X": [[1.0]], "S": [], "T": []}),
            );
            prove(&c)
        };
        assert!(with(1.34).is_ok() && with(1.33).is_err());
    }
    // With the direct path, u = -y is u = -x/4: another loop.
    assert!(prove(&with_direct_path(3.0, -1.0, 1.25)).is_err());
}

#[test]
fn rejects_direct_path_that_leaves_u_undetermined() {
    for (d, k) in [(0.5, 2.0), (-1.0, -1.0)] {
        let refusal = prove(&with_direct_path(d, k, 1e6)).unwrap_err();
        assert!(matches!(refusal, Failure::NotWellPosed), "{refusal}");
        // Next to this value u is about -x/2^-53.
        assert!(prove(&with_direct_path(d.next_up(), k, 1e6)).is_ok());
    }
}

#[test]
fn proves_model_error_too() {
    // x' = -x + Delta x/4 + w: the gain is 1/(1 - 1/4) = 4/3. The inequality with X = 1 and E = 1/4, F = 1 is
    // -2 + lambda + 1/(16 lambda) + 2/gamma < 0; lambda = 1/4 is the best, gamma > 4/3.
    let with = |gamma: f64, lambda: f64| {
        let mut c = integrator(1.25);
        add_model_error(
            &mut c,
            json!({"E": [[0.25]], "F": [[1.0]], "Fu": [[0.0]], "lambda": lambda, "gamma": gamma,
            "X": [[1.0]], "S": [], "T": []}),
        );
        prove(&c)
    };
    let theorem = with(1.34, 0.25).unwrap();
    assert_eq!((theorem.gamma, theorem.gamma_with_model_error), (Some(1.25), Some(1.34)));
    insta::assert_snapshot!(theorem);
    for (gamma, lambda, part) in [
        (1.33, 0.25, "inequality"),
        (1.34, 0.3, "inequality"),
        (1.34, 0.2, "inequality"),
        (1.34, 0.0, "lambda"),
    ] {
        let refusal = with(gamma, lambda).unwrap_err();
        assert!(is_at(&refusal, &format!("RobustGain {part}")), "{refusal}");
    }
}

#[test]
fn residual_of_control_matrix_acts_through_controller() {
    // Fu = 1, F = 0: z_Delta = u = -x, the same loop as with F = 1 up to the sign of Delta. With F = Fu = 1 nothing
    // enters Delta: -2 + 1/(16 lambda) + 2/gamma < 0, gamma > 8/7. With Fu = 1/2 it is -2 + 1/16 + 1/4 + 2/gamma < 0.
    let with = |f: f64, fu: f64, gamma: f64| {
        let mut c = integrator(1.25);
        add_model_error(
            &mut c,
            json!({"E": [[0.25]], "F": [[f]], "Fu": [[fu]], "lambda": 0.25, "gamma": gamma,
            "X": [[1.0]], "S": [], "T": []}),
        );
        prove(&c)
    };
    assert!(with(0.0, 1.0, 1.34).is_ok());
    assert!(with(0.0, 1.0, 1.33).is_err());
    assert!(with(1.0, 1.0, 1.15).is_ok());
    assert!(with(1.0, 0.5, 1.15).is_err());
}

#[test]
fn residual_of_input_matrix_acts_on_w() {
    // x' = -x + (1 + Delta/4) w: the gain is 5/4. With X = 1 and lambda = 1/4 the form is negative where
    // (gamma - 1/4) (2 - 1/gamma - 1/4) > 1, above gamma = 1.282; without Fw nothing enters Delta.
    let with = |fw: Value, gamma: f64| {
        let mut c = integrator(1.25);
        add_model_error(
            &mut c,
            json!({"E": [[0.25]], "F": [[0.0]], "Fw": fw, "Fu": [[0.0]], "lambda": 0.25, "gamma": gamma,
            "X": [[1.0]], "S": [], "T": []}),
        );
        prove(&c)
    };
    assert!(with(json!([[1.0]]), 1.29).is_ok());
    assert!(with(json!([[1.0]]), 1.27).is_err());
    assert!(with(json!([]), 1.2).is_ok() && with(json!([[0.0]]), 1.2).is_ok());
    for wrong in [json!([[1.0, 0.0]]), json!([[1.0], [1.0]])] {
        assert!(is_at(&with(wrong, 1.29).unwrap_err(), "errors[0].Fw"));
    }
}

#[test]
fn names_each_violated_condition() {
    let tiny = f64::from_bits(1);
    let mut refused = Refused::default();
    for (pointer, value, place) in [
        ("/claims/0/gain/gamma", json!(-1.0), "Gain gamma"),
        ("/claims/0/gain/X", json!([[-1.0]]), "Gain X"),
        ("/claims/0/gain/X", json!([[0.0]]), "Gain X"),
        ("/claims/0/gain/S/0/1", json!(tiny), "Gain S"),
        ("/claims/0/gain/T/0/0", json!(tiny), "Gain T"),
        ("/claims/0/gain/S/1/1", json!(-1.0), "Gain S"),
        ("/plant/A", json!([[2.0]]), "Gain inequality"),
    ] {
        let mut c = scheduled(0.75);
        *c.pointer_mut(pointer).unwrap() = value;
        refused.at(place, &c);
    }
    let mut two = scheduled(0.75);
    two["blocks"] = json!([1, 0]);
    two["controller_blocks"] = json!([0, 1]);
    assert_eq!(prove(&two).unwrap().parameters, 2);
    claim(&mut two, "gain")["S"] = json!([[1.0, 0.25], [0.25, 0.5]]);
    refused.at("Gain S", &two);
    insta::assert_snapshot!(refused.0);
}

#[test]
fn accepts_coupling_of_plant_and_controller_channels() {
    let mut c = scheduled(0.75);
    claim(&mut c, "gain")["S"] = json!([[1.0, 0.03], [0.03, 0.5]]);
    claim(&mut c, "gain")["T"] = json!([[0.0, 0.01], [-0.01, 0.0]]);
    assert!(prove(&c).is_ok());
}

#[test]
fn rejects_ill_posed_parameter_loop() {
    // zt = x + wt: at theta = 1 it has no solution, whatever S is.
    for s in [1e-6, 1.0, 1e6] {
        let mut c = scheduled(1e3);
        c["plant"]["Dtt"] = json!([[1.0]]);
        claim(&mut c, "gain")["S"][0][0] = json!(s);
        assert!(prove(&c).is_err());
    }
}

#[test]
fn keeps_tiny_terms() {
    // gamma = 1 + 2^-52 leaves a margin of 2^-51; a disturbance of X by 1e-300 does not matter, one of A by 1e-300
    // does when gamma = 1.
    let mut c = integrator(1.0);
    c["plant"]["A"] = json!([[-1e-300]]);
    assert!(prove(&c).is_ok());
    c["plant"]["A"] = json!([[1e-300]]);
    assert!(prove(&c).is_err());
}
