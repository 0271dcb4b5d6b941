//! Vehicles with a given speed.

use std::path::Path;

use crate::common::{json_message, message, remus100};
use nalgebra::{DVector, Matrix2, Matrix3, Vector2};
use squid_auv::longitudinal::turning;
use squid_auv::{
    Current, Descriptor, Dynamics, Effect, Motion, Parameter, Pitch, Plant, Slopes, Speed, Surge, Trim,
    Vehicle, actuator_force, index, linearise, linearise_with, trim, trims,
};

/// Returns the file of NPS AUV II, used here in heave and pitch.
fn text() -> String {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/vehicles/nps_auv_ii/vehicle.toml");
    std::fs::read_to_string(file).unwrap()
}

fn nps() -> Vehicle {
    Vehicle::parse(&text(), "vehicle.toml").unwrap().in_plane()
}

/// Returns REMUS 100 with its stern planes only; incidence and deflection change with the speed.
fn remus() -> Vehicle {
    let mut vehicle = remus100();
    vehicle.coefficients.surge = Surge::Given { lag: 0.7 };
    vehicle.actuators.retain(|one| matches!(one.effect, Effect::ControlSurface { .. }));
    for one in &mut vehicle.actuators {
        one.effect = one.effect.map(|key, value| if key == "X_uu_delta2" { 0.0 } else { value });
    }
    vehicle
}

fn close(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() < tolerance * (1.0 + expected.abs()), "{found} and {expected}");
}

/// Reference: Healey and Lienard (1993), in the dive plane about level flight: `(m - Z_w') w' - Z_q' q' = Z_w U w + (m
/// + Z_q) U q + Z_d U^2 d`, `-M_w' w' + (I - M_q') q' = M_w U w + M_q U q - z_G W theta + M_d U^2 d`, theta' = q.
#[test]
fn linear_model_matches_the_dive_plane_equations() {
    let vehicle = nps();
    assert_eq!(vehicle.coefficients.X_u_dot, 0.0, "it is not given");
    let [r2, r3, r4, r5] = [2, 3, 4, 5].map(|power| 0.5 * 1025.0 * 5.3_f64.powi(power));
    let m = 5454.54;
    let mass = Matrix2::new(m + 0.24 * r3, 6.8e-3 * r4, 6.8e-3 * r4, 13587.0 + 0.017 * r5);
    for u in [1.0, 1.7, 2.2] {
        let forces = [
            Vector2::new(-0.3 * r2 * u, 0.1 * r3 * u),
            Vector2::new((m - 0.14 * r3) * u, -0.068 * r4 * u),
            Vector2::new(0.0, -0.061 * 53400.0),
            Vector2::new(-0.073 * r2 * u * u, -0.041 * r3 * u * u),
        ];
        let expected = forces.map(|force| mass.try_inverse().unwrap() * force);
        let level = trim(&vehicle, Speed::Path(u), 20.0).unwrap();
        let linear = linearise(&vehicle, &level).unwrap();
        assert_eq!(linear.states.iter().map(|state| state.symbol).collect::<Vec<_>>(), ["w", "q", "theta"]);
        assert_eq!((linear.a.shape(), linear.b.shape()), ((3, 3), (3, 1)));
        for (j, column) in expected.iter().enumerate() {
            for i in 0..2 {
                let found = if j < 3 { linear.a[(i, j)] } else { linear.b[(i, 0)] };
                close(found, column[i], 1e-12);
            }
        }
        assert_eq!(linear.a.row(2).iter().copied().collect::<Vec<_>>(), [0.0, 1.0, 0.0]);
        let Descriptor { mass, state, input } =
            Descriptor::at(&vehicle, &level, vehicle.coefficients.surge.states(false));
        let inverse = mass.try_inverse().unwrap();
        assert!(
            (&inverse * state - &linear.a).amax() < 1e-12 && (inverse * input - &linear.b).amax() < 1e-12
        );
    }
}

/// The given speed replaces an axial thruster: heave and pitch have the same trim.
#[test]
fn heave_and_pitch_trim_match_those_with_a_propeller() {
    let (given, free) = (remus(), remus100());
    for speed in [1.4, 1.8, 2.2] {
        let [one, other] = [&given, &free].map(|vehicle| trim(vehicle, Speed::Path(speed), 20.0).unwrap());
        close(one.pitch, other.pitch, 1e-9);
        close(one.actuators[0], other.actuators[1], 1e-9);
        assert!(one.pitch.abs() > 1e-3 && one.actuators[0].abs() > 1e-3);
        let linear = linearise(&given, &one).unwrap();
        let full = linearise(&free, &other).unwrap();
        // The same forces, with the mass matrix of heave and pitch only.
        let mass = free.coefficients.mass_matrix();
        let force = mass * full.a.view((0, 0), (3, 4));
        let heave_pitch: Matrix2<f64> = mass.fixed_view::<2, 2>(1, 1).into_owned();
        let expected = heave_pitch.try_inverse().unwrap() * force.view((1, 1), (2, 3));
        assert!((linear.a.rows(0, 2) - expected).amax() < 1e-9);
    }
}

/// The row of `z' = w cos(theta) - u sin(theta)` in level flight at a speed V and a pitch theta is \[-sin(theta)
/// cos(theta) 0 -V 0\]; nothing depends on z, and z has no trim slope.
#[test]
fn depth_is_the_last_state() {
    for (vehicle, all) in
        [(remus100(), &["u", "w", "q", "theta", "z"][..]), (remus(), &["w", "q", "theta", "z"])]
    {
        let level = trim(&vehicle, Speed::Path(1.7), 20.0).unwrap();
        let (deep, plain) = (
            linearise_with(&vehicle, &level, vehicle.coefficients.surge.states(true)).unwrap(),
            linearise(&vehicle, &level).unwrap(),
        );
        let n = all.len();
        assert_eq!(deep.states.iter().map(|state| state.symbol).collect::<Vec<_>>(), all);
        assert_eq!(deep.a.view((0, 0), (n - 1, n - 1)), plain.a);
        assert_eq!(
            (deep.b.rows(0, n - 1), turning(deep.states)),
            (plain.b.rows(0, n - 1), turning(plain.states))
        );
        assert!(deep.b.row(n - 1).iter().chain(deep.a.column(n - 1).iter()).all(|entry| *entry == 0.0));
        let (sin, cos) = level.pitch.sin_cos();
        let row = [-sin, cos, 0.0, -1.7, 0.0];
        for (found, expected) in deep.a.row(n - 1).iter().zip(&row[5 - n..]) {
            close(*found, *expected, 1e-12);
        }
        let (slope, plain_slope) =
            (deep.trim_slope(&vehicle.actuators), plain.trim_slope(&vehicle.actuators));
        assert!(slope[n - 1].abs() < 1e-12);
        assert!((slope.remove_row(n - 1) - plain_slope).amax() < 1e-9);
    }
}

#[test]
fn trim_slope_matches_differences() {
    let vehicle = remus();
    let speeds: Vec<f64> = (0..=8).map(|i| 1.4 + 0.1 * f64::from(i)).collect();
    assert!(trims(&vehicle, 20.0, &speeds, &Pitch::Free).is_ok(), "they lie on one branch");
    for speed in speeds {
        let at = |v: f64| trim(&vehicle, Speed::Path(v), 20.0).unwrap();
        let (before, after) = (at(speed - 1e-4), at(speed + 1e-4));
        let slope = linearise(&vehicle, &at(speed)).unwrap().trim_slope(&vehicle.actuators);
        let rise = after.forward_speed - before.forward_speed;
        let difference = |of: fn(&Trim) -> f64| (of(&after) - of(&before)) / rise;
        let expected =
            [difference(|t| t.heave), 0.0, difference(|t| t.pitch), difference(|t| t.actuators[0])];
        assert!((slope - DVector::from_column_slice(&expected)).amax() < 1e-6, "{speed}");
    }
}

/// Closed form: `u = given + (u0 - given) exp(-t/lag)`, and `given - rate lag` behind a ramp, independent of planes and
/// current.
#[test]
fn speed_follows_the_given_speed_only() {
    let vehicle = remus();
    let Surge::Given { lag } = vehicle.coefficients.surge else { panic!() };
    let mut plant = Plant::new(&vehicle).unwrap();
    plant.start(0.0, &trim(&vehicle, Speed::Forward(1.5), 20.0).unwrap()).unwrap();
    plant.set_command(0, 0.1).unwrap();
    plant.advance(2.0).unwrap();
    assert_eq!(plant.state().motion.u, 1.5, "that of the trim, until another is given");
    plant.set_given_speed(1.9).unwrap();
    plant.advance(2.0 + lag).unwrap();
    close(plant.state().motion.u, 1.9 - 0.4 * (-1.0_f64).exp(), 1e-12);
    plant.set_slopes(&Slopes { given_speed: 0.05, ..Slopes::held(1) }).unwrap();
    plant.advance(2.0 + 41.0 * lag).unwrap();
    close(plant.given_speed(), 1.9 + 0.05 * 40.0 * lag, 1e-12);
    close(plant.state().motion.u, plant.given_speed() - 0.05 * lag, 1e-9);
    plant.set_slopes(&Slopes::held(1)).unwrap();
    let before = plant.state().motion.u;
    plant.set_current(Current { horizontal: 0.3, vertical: 0.1, ..Current::default() }).unwrap();
    let Motion { u, theta, .. } = plant.state().motion;
    close(u - before, 0.1 * theta.sin() - 0.3 * theta.cos(), 1e-9);
    plant.advance(2.0 + 81.0 * lag).unwrap();
    close(plant.state().motion.u, plant.given_speed(), 1e-9);
    let instant = plant.instant();
    let rates = plant.rates(&instant, |i| plant.outputs()[i]);
    let before = plant.clone();
    plant.advance(before.time() + 1e-5).unwrap();
    let after = plant.instant();
    for index in [index::HEAVE, index::Q] {
        close((after.state[index] - instant.state[index]) / 1e-5, rates[index], 1e-3);
    }
    let mut restored = before.clone();
    restored.restore(&before.snapshot()).unwrap();
    restored.advance(plant.time()).unwrap();
    assert_eq!(restored.state(), plant.state());
}

/// A given surge acceleration couples into heave and pitch through the mass matrix: `M_22 [w' q']' = F - M_21 u'`.
#[test]
fn surge_acceleration_couples_into_heave_and_pitch() {
    let vehicle = remus();
    let dynamics = Dynamics::new(&vehicle.coefficients).unwrap();
    let motion = Motion::in_plane(1.6, 0.05, 0.1, 0.2);
    let force = actuator_force(&vehicle.actuators, motion.u, [0.05]);
    let at = |given: f64| dynamics.rate(&motion, 20.0, given, force);
    let (held, accelerated) = (at(1.6), at(1.6 + 0.7 * 0.5));
    assert_eq!((held[0], accelerated[3]), (0.0, 0.1));
    close(accelerated[0], 0.5, 1e-12);
    let mass: Matrix3<f64> = remus100().coefficients.mass_matrix();
    let heave_pitch: Matrix2<f64> = mass.fixed_view::<2, 2>(1, 1).into_owned();
    let expected = -heave_pitch.try_inverse().unwrap() * Vector2::new(mass[(1, 0)], mass[(2, 0)]) * 0.5;
    assert!(expected[1].abs() > 1e-3);
    close(accelerated[1] - held[1], expected[0], 1e-12);
    close(accelerated[2] - held[2], expected[1], 1e-12);
}

#[test]
fn json_round_trips_and_rejects_a_thruster() {
    let vehicle = nps();
    let json = vehicle.to_json().unwrap();
    let read = Vehicle::from_json(&json, "vehicle.json").unwrap();
    assert_eq!(read.coefficients, vehicle.coefficients);
    assert!(!remus100().to_json().unwrap().contains("given_speed_lag"));
    let messages = [
        ("\"given_speed_lag\": 2.0", "\"given_speed_lag\": -2.0", "given_speed_lag"),
        (
            "\"actuators\": [",
            "\"actuators\": [{\"name\": \"prop\", \"kind\": \"thruster\", \"numbers\": {\"min\": -1.0, \"max\": 1.0, \
                \"lag\": 0.0, \"x\": 0.0, \"z\": 0.0, \"direction\": 0.0}},",
            "prop",
        ),
        ("\"X_uu_delta2\": 0.0", "\"X_uu_delta2\": -1.0", "stern_planes"),
    ]
    .map(|(found, replacement, key)| {
        assert_eq!(json.matches(found).count(), 1, "{json}");
        let error = Vehicle::from_json(&json.replace(found, replacement), "vehicle.json").unwrap_err();
        json_message(replacement, &error, key)
    });
    insta::assert_snapshot!(messages.join("\n\n"));
}

/// Each entry is rejected with its line.
#[test]
fn rejects_forces_along_the_hull() {
    let number =
        |key: &str, unit: &str| format!("{key} = {{ value = -1.0, unit = \"{unit}\", source = \"x\" }}\n");
    let thruster = "[[thruster]]\nname = \"prop\"\n".to_owned()
        + &number("z", "m")
        + &number("min", "N")
        + "max = { value = 1.0, unit = \"N\", source = \"x\" }\nlag = { value = 0.0, unit = \"s\", source = \"x\" }\n";
    let text = text();
    let line = text.lines().count() + 1;
    let mut messages = vec![];
    for (addition, key, at) in [
        (thruster, "thruster", line),
        ("[drag]\n".to_owned() + &number("X_uu", "kg/m"), "drag", line),
        ("[damping]\n".to_owned() + &number("X_u", "kg/s"), "damping.X_u", line + 1),
        (number("X_uu_delta2", "prime"), "control_surface.X_uu_delta2", line),
    ] {
        let error = Vehicle::parse(&(text.clone() + &addition), "vehicle.toml").unwrap_err();
        messages.push(message(key, &error, (at, key)));
    }
    for (found, replacement, at, key) in [
        ("\"given\"", "\"held\"", "speed = \"given\"", "surge.speed"),
        ("speed = \"given\"\n", "", "[surge]", "surge.speed"),
        (
            "{ value = 2.0, unit = \"s\"",
            "{ value = 0.0, unit = \"s\"",
            "{ value = 2.0, unit = \"s\"",
            "surge.lag",
        ),
        ("\"combined\"", "\"viscous\"", "[added_mass]", "added_mass.X_u_dot"),
    ] {
        let error = Vehicle::parse(&text.replacen(found, replacement, 1), "vehicle.toml").unwrap_err();
        let line = text.lines().position(|line| line.contains(at)).unwrap() + 1;
        messages.push(message(replacement, &error, (line, key)));
    }
    let unknown = Parameter::named(&nps(), "X_uu").unwrap_err();
    assert_eq!(unknown.name, "X_uu");
    messages.push(unknown.to_string());
    insta::assert_snapshot!(messages.join("\n\n"));
}
