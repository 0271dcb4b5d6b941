//! Coefficients of sway, roll and yaw in a vehicle file, and the defaults of those that are absent.

use super::*;
use crate::common::places;
use squid_auv::Effect;

/// Absent coefficients are those of an axisymmetric hull; both forms of lift agree on this.
#[test]
fn absent_coefficients_are_those_of_an_axisymmetric_hull() {
    let c = remus().coefficients;
    let pairs = [
        (c.I_zz, c.I_yy),
        (c.Y_v_dot, c.Z_w_dot),
        (c.Y_r_dot, -c.Z_q_dot),
        (c.N_r_dot, c.M_q_dot),
        (c.Y_uv, c.Z_uw),
        (c.Y_ur, -c.Z_uq),
        (c.N_uv, -c.M_uw),
        (c.N_ur, c.M_uq),
        (c.Y_vv, c.Z_ww),
        (c.Y_rr, -c.Z_qq),
        (c.N_vv, -c.M_ww),
    ];
    for (lateral, plane) in pairs {
        assert_eq!(lateral, plane);
    }
    assert_eq!((c.N_rr, c.K_pp, c.I_xx), (-94.0, -0.13, 0.177));
    // Prestero (2001) prints combined coefficients: Y_ur 5.22, N_uv -24, N_ur -2; the rest is unchanged.
    let printed = [
        ("[lift]", r#"Y_ur = { value = 5.22, unit = "kg", source = "Prestero (2001)" }"#),
        ("[lift]", r#"N_uv = { value = -24.0, unit = "kg", source = "Prestero (2001)" }"#),
        ("[lift]", r#"N_ur = { value = -2.0, unit = "kg.m", source = "Prestero (2001)" }"#),
    ];
    assert_eq!(read(&with(&printed)).coefficients, six_dof("remus100").coefficients);
}

#[test]
fn reports_missing_coefficients_of_a_turning_vehicle() {
    let remus = |from: &str, to: &str| text("remus100").replace(from, to);
    let plane = without(&["Z_uu_delta", "M_uu_delta"])
        .replace("[[thruster]]", "[surge]\nspeed = \"given\"\n[[thrust]]");
    let rudder = without(&["I_xx", "K_p_dot", "K_up", "K_pp", "N_rr"]);
    let mut messages = vec![];
    for (what, text, keys) in [
        ("no inertia", without(&["I_xx"]), &["mass.I_xx"][..]),
        ("no inertia for a rudder", rudder, &["mass.I_xx"]),
        ("inertia zero", remus("value = 0.177", "value = 0.0"), &["mass.I_xx"]),
        ("inertia in words", remus("value = 0.177", "value = \"light\""), &["mass.I_xx.value"]),
        ("inertia of another unit", remus("value = 0.177", "value = 0.01"), &["I_xx"]),
        ("no damping", without(&["K_up", "K_pp"]), &["lift.K_up"]),
        ("half a rudder", without(&["N_uu_delta"]), &["control_surface.N_uu_delta"]),
        ("added mass above zero", remus("value = -0.0704", "value = 0.0704"), &["added_mass.K_p_dot"]),
        (
            "planes without effect",
            plane,
            &["drag", "thrust", "control_surface.Z_uu_delta", "control_surface.M_uu_delta"],
        ),
    ] {
        let error = Vehicle::parse(&text, "v.toml").expect_err(what);
        let found: Vec<_> = places(&error).into_iter().map(|(_, key)| key).collect();
        assert_eq!(found, keys, "{what}: {error}");
        messages.push(format!("{what}:\n{}", error.mistakes.last().unwrap().problem));
    }
    insta::assert_snapshot!(messages.join("\n\n"));
}

#[test]
fn turning_vehicle_round_trips_json() {
    let vehicle = remus();
    let json = vehicle.to_json().unwrap();
    let read = Vehicle::from_json(&json, "vehicle.json").unwrap();
    assert_eq!((&read.coefficients, &read.actuators), (&vehicle.coefficients, &vehicle.actuators));
    // Absent coefficients have their defaults there, too.
    let shortened: String =
        json.lines().filter(|line| !line.contains("\"N_uv\"")).map(|l| format!("{l}\n")).collect();
    assert_eq!(Vehicle::from_json(&shortened, "vehicle.json").unwrap().coefficients, vehicle.coefficients);
    let planar = crate::common::remus100().to_json().unwrap();
    assert!(!planar.contains("I_xx") && !planar.contains("Y_uu_delta") && !planar.contains("azimuth"));
}

#[test]
fn finds_improbable_numbers() {
    assert_eq!(remus().findings(), []);
    let found = read(&text("remus100").replace("value = -0.722", "value = 0.722")).findings();
    let [rolling] = &found[..] else { panic!("{found:?}") };
    assert_eq!((rolling.kind.as_str(), rolling.key.as_str()), ("acts_with_motion", "K_up"));
    assert_eq!((rolling.value, rolling.limit), (Some(0.722), Some(0.0)));
    let mut wide = remus();
    wide.coefficients.I_xx = 5.0;
    insta::assert_snapshot!(format!("{rolling}\n\n{}", wide.findings()[0]));
}

/// The two upper thrusters of Squid work against one another, and their effect in the vertical plane is exactly zero.
#[test]
fn upper_thrusters_of_squid_only_yaw_it() {
    let vehicle = six_dof("squid");
    let yaw = vehicle.actuators.last().unwrap();
    assert_eq!((yaw.name.as_str(), yaw.acts_in_plane(), yaw.force(2.0, 7.3)), ("yaw", false, [0.0; 3]));
    let [sway, roll, moment] = yaw.lateral_force(2.0, 7.3);
    let arm = 0.2 * 60.0_f64.to_radians().sin();
    assert!((moment - 2.0 * arm * 7.3).abs() < 1e-14 && (sway, roll) == (0.0, 0.0), "{sway} {roll} {moment}");
    assert_eq!(squid_auv::LATERAL.vehicle(&vehicle).actuators, std::slice::from_ref(yaw));
    let plane: Vec<String> = vehicle.in_plane().actuators.into_iter().map(|one| one.name).collect();
    assert_eq!(plane, ["lower", "upper_port", "upper_starboard"]);
}

/// A vehicle reduced to the vertical plane equals one whose file never had the lateral coefficients.
#[test]
fn vehicle_in_the_plane_has_no_lateral_coefficients() {
    let torque = r#"torque = { value = -0.14, unit = "m", source = "a test" }"#;
    let lateral = ["I_xx", "K_p_dot", "K_up", "K_pp", "N_rr"];
    let text = without(&lateral);
    let (planar, _) = text.split_once("# A positive deflection pushes to starboard").unwrap();
    let without_lateral = read(planar);
    let mut plane = read(&with(&[("[[thruster]]", torque)])).in_plane();
    plane.published_linear_model = None;
    assert_eq!(plane, without_lateral);
    assert_eq!(plane.in_plane(), plane);
    assert_eq!(crate::common::squid().in_plane(), crate::common::squid());
    assert!(plane.supposed().is_empty() && remus().supposed().iter().any(|one| one.0 == "N_uv"));
    // A thruster with an azimuth keeps the ahead component of its thrust.
    plane.actuators[0].effect =
        Effect::Thruster { x: 0.3, y: 0.2, z: 0.1, direction: 0.2, azimuth: 0.5, torque: 0.1 };
    let turned_thruster = plane.in_plane().actuators[0].clone();
    assert_eq!(turned_thruster.force(0.0, 2.0), plane.actuators[0].force(0.0, 2.0));
    assert_eq!(turned_thruster.lateral_force(0.0, 2.0), [0.0; 3]);
}
