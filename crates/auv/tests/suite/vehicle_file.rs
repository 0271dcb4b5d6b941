//! Every mistake in a vehicle file gets one message with file, line, key, the value found and the allowed values.

use std::path::Path;

use crate::common::{remus100, squid};
use squid_auv::{Allowed, COEFFICIENTS, DefaultValue, Effect, FileProblem, Status, Vehicle};

const SQUID: &str = include_str!("../../../../vehicles/squid/vehicle.toml");
const REMUS: &str = include_str!("../../../../vehicles/remus100/vehicle.toml");

/// Returns the line, counted from 1, that contains a marker first, or that equals it if it is a header.
fn line_of(text: &str, marker: &str) -> usize {
    let is_header = marker.starts_with('[');
    let holds = |line: &str| if is_header { line == marker } else { line.contains(marker) };
    text.lines().position(holds).expect(marker) + 1
}

/// Replaces text in a vehicle file, and returns the resulting message and the line of the replacement.
fn message(file: &str, from: &str, to: &str) -> (String, usize) {
    assert!(file.contains(from), "{from}");
    let text = file.replacen(from, to, 1);
    let line = line_of(file, from.lines().next().unwrap());
    (Vehicle::parse(&text, "vehicle.toml").expect_err(to).to_string(), line)
}

#[track_caller]
fn assert_rejected(from: &str, to: &str, expected: &str) {
    let (message, line) = message(SQUID, from, to);
    assert_eq!(message, format!("vehicle.toml:{line}: {expected}"));
}

#[test]
fn reads_both_vehicles() {
    let squid = squid();
    assert_eq!((squid.name.as_str(), squid.status), ("squid", Status::Surrogate));
    assert_eq!(squid.coefficients.Z_uw, -67.14364866073974);
    assert!((squid.coefficients.buoyancy_at(0.0) - 1.005 * squid.coefficients.weight).abs() < 1e-9);
    assert_eq!(squid.coefficients.buoyancy_at(50.0), 658.1606198442163);
    let names: Vec<&str> = squid.actuators.iter().map(|a| a.name.as_str()).collect();
    assert_eq!(names, ["lower", "upper_port", "upper_starboard"]);
    assert_eq!(squid.actuators[0].effect, Effect::thruster(0.0, 0.2, 0.0));
    assert_eq!((squid.actuators[1].min, squid.actuators[1].max, squid.actuators[1].lag), (-60.0, 100.0, 0.2));
    assert!(squid.sources["M_uw"].contains("Hoerner"));
    assert!(squid.sources["lower.max"].contains("assumed"));

    let remus = remus100();
    assert_eq!(remus.status, Status::Published);
    assert_eq!(remus.coefficients.Z_ww, -1310.0);
    assert_eq!(remus.coefficients.kinematic_viscosity, 1.19e-6);
    assert_eq!(remus.actuators[1].unit(), "rad");
    assert!((remus.actuators[1].max - 13.6_f64.to_radians()).abs() < 1e-15);
}

#[test]
fn rejects_unknown_keys() {
    assert_rejected(
        "Z_uw = {",
        "Zuw = {",
        "unknown key 'lift.Zuw' (did you mean 'Z_uw'?); allowed here: Z_uw, Z_uq, M_uw, M_uq, Y_uv, Y_up, Y_ur, K_uv, \
         K_up, K_ur, N_uv, N_up, N_ur, convention",
    );
    assert_rejected(
        "form_factor = {",
        "quality = {",
        "unknown key 'drag.quality'; allowed here: X_uu, length, wetted_area, form_factor, drag_area",
    );
    let sections = "vehicle, thruster, thruster_group, control_surface, published_linear_model, non_dimensional, \
        surge, geometry, mass, buoyancy, water, added_mass, lift, damping, hull, drag";
    assert_rejected(
        "[damping]",
        "[dampnig]",
        &format!("unknown key 'dampnig' (did you mean 'damping'?); allowed here: {sections}"),
    );
    let key = "z = { value = 0.2, unit = \"m\"";
    assert_rejected(
        key,
        "z = { value = 0.2, units = \"m\"",
        "unknown key 'thruster.z.units' (did you mean 'unit'?); allowed here: value, unit, source",
    );
    let (two, line) = message(SQUID, key, "height = { value = 0.2, unit = \"m\"");
    let header = line_of(SQUID, "[[thruster]]");
    let missing = format!("vehicle.toml:{header}: missing key 'thruster.z': position below the origin");
    let allowed = "allowed here: name, x, y, z, direction, azimuth, torque, curve, T_nn, min, max, lag, rate";
    assert_eq!(two, format!("{missing}\nvehicle.toml:{line}: unknown key 'thruster.height'; {allowed}"));
    assert_rejected(
        "status =",
        "state =",
        "unknown key 'vehicle.state' (did you mean 'status'?); allowed here: name, status, description",
    );
}

/// Table of a couple of vertical thrusters, as a builder writes it.
const GROUP: &str = "
[[thruster_group]]
name = \"couple\"
min = { value = -30.0, unit = \"N\", source = \"s\" }
max = { value = 40.0, unit = \"N\", source = \"s\" }
lag = { value = 0.1, unit = \"s\", source = \"s\" }
[[thruster_group.thruster]]
share = { value = 1.0, unit = \"1\", source = \"s\" }
x = { value = 0.5, unit = \"m\", source = \"s\" }
z = { value = 0.1, unit = \"m\", source = \"s\" }
direction = { value = -90.0, unit = \"deg\", source = \"s\" }
[[thruster_group.thruster]]
share = { value = -1.5, unit = \"1\", source = \"s\" }
x = { value = -0.4, unit = \"m\", source = \"s\" }
z = { value = 0.1, unit = \"m\", source = \"s\" }
direction = { value = -90.0, unit = \"deg\", source = \"s\" }
";

/// Thrust T up at 0.5 m and 1.5 T down at -0.4 m: `Z = -T + 1.5 T`, `M = 0.5 T + 0.4 * 1.5 T`.
#[test]
fn thruster_group_sums_its_thrusters() {
    let vehicle = Vehicle::parse(&format!("{SQUID}{GROUP}"), "vehicle.toml").unwrap();
    let couple = vehicle.actuators.last().unwrap();
    assert_eq!((couple.name.as_str(), couple.unit(), couple.min, couple.max), ("couple", "N", -30.0, 40.0));
    for (found, expected) in couple.force(2.0, 10.0).iter().zip([0.0_f64, 5.0, 11.0]) {
        assert!((found - expected).abs() < 1e-13, "{found} instead of {expected}");
    }
    assert_eq!(vehicle.sources["couple.2.share"], "s");
    assert_eq!(Vehicle::from_json(&vehicle.to_json().unwrap(), "v").unwrap(), vehicle);
    let plane = vehicle.in_plane();
    let parameter = squid_auv::Parameter::named(&plane, "couple.M_T").unwrap();
    assert!((parameter.coefficient(&plane).unwrap() - 1.1).abs() < 1e-15);
    let message = |from: &str, to: &str| {
        let text = format!("{SQUID}{}", GROUP.replacen(from, to, 1));
        let message = Vehicle::parse(&text, "v.toml").expect_err(to).to_string();
        message.split_once(": ").unwrap().1.to_owned()
    };
    assert_eq!(
        message("share = { value = 1.0, unit = \"1\", source = \"s\" }", ""),
        "missing key 'thruster_group.thruster.share': thrust of this one for that of the command"
    );
    assert_eq!(
        message("share", "part"),
        "missing key 'thruster_group.thruster.share': thrust of this one for that of the command\nv.toml:124: \
         unknown key 'thruster_group.thruster.part'; allowed here: share, x, y, z, direction, azimuth, torque"
            .replace("124", &(SQUID.lines().count() + 8).to_string())
    );
    let without = &GROUP[GROUP.find("[[thruster_group.thruster]]").unwrap()..];
    assert_eq!(
        message(without, ""),
        "missing key 'thruster_group.thruster': [[thruster_group.thruster]], once for each thruster of the group"
    );
    assert_eq!(
        message("name = \"couple\"", "name = \"lower\""),
        format!(
            "the actuator name \"lower\" is already taken at line {}; names must differ",
            line_of(SQUID, "[[thruster]]")
        )
    );
}

#[test]
fn rejects_missing_keys() {
    let without = |file: &str, start: &str| {
        let line = file.lines().find(|line| line.starts_with(start)).expect(start);
        Vehicle::parse(&file.replacen(line, "", 1), "vehicle.toml").unwrap_err().to_string()
    };
    let at =
        |marker: &str, text: &str| format!("vehicle.toml:{}: missing key {text}", line_of(SQUID, marker));
    assert_eq!(
        without(SQUID, "Z_w_dot"),
        at("[added_mass]", "'added_mass.Z_w_dot': Heave force per heave acceleration")
    );
    assert_eq!(
        without(SQUID, "convention"),
        at("[lift]", "'lift.convention': it must be \"viscous\" or \"combined\"")
    );
    assert_eq!(without(SQUID, "name"), at("[vehicle]", "'vehicle.name': a text in quotes"));
    assert_eq!(without(SQUID, "z = "), at("[[thruster]]", "'thruster.z': position below the origin"));
    assert_eq!(without(SQUID, "lag"), at("[[thruster]]", "'thruster.lag': time constant of the lag"));
    assert_rejected(
        ", source = \"derived: mass times 9.81 m/s2\"",
        "",
        "missing key 'mass.weight.source': where the number comes from",
    );
    assert_rejected(
        "unit = \"kg\", source = \"derived from geometry: displaced",
        "source = \"",
        "missing key 'mass.mass.unit': the unit, \"kg\"",
    );
    let water = SQUID.find("[water]").unwrap()..SQUID.find("# Added mass").unwrap();
    let text = SQUID.replace(&SQUID[water], "");
    let message = Vehicle::parse(&text, "v.toml").unwrap_err().to_string();
    assert_eq!(message, "v.toml:1: missing key 'water': a table with density");
}

#[test]
fn rejects_wrong_units_types_and_texts() {
    assert_rejected(
        "unit = \"N\", source = \"derived: mass times",
        "unit = \"lbf\", source = \"derived: mass times",
        "'mass.weight' is in \"lbf\"; it must be in \"N\"",
    );
    assert_rejected(
        "z_G = { value = 0.03, unit = \"m\", source = \"assumed: ballast low in the hull\" }",
        "z_G = 0.03",
        "'mass.z_G' is the number 0.03; it must be a table { value = ..., unit = \"...\", source = \"...\" }",
    );
    assert_rejected(
        "z_G = { value = 0.03",
        "z_G = { value = \"3 cm\"",
        "'mass.z_G.value' is the text \"3 cm\"; it must be a decimal number",
    );
    assert_rejected(
        "source = \"assumed: ballast low in the hull\"",
        "source = \" \"",
        "'mass.z_G.source' is empty; it must say something",
    );
    assert_rejected(
        "name = \"squid\"",
        "name = 7",
        "'vehicle.name' is the number 7; it must be a text in quotes",
    );
    assert_rejected(
        "status = \"surrogate\"",
        "status = \"surogate\"",
        "'vehicle.status' is \"surogate\" (did you mean \"surrogate\"?); it must be \"surrogate\" \
            or \"published\" or \"measured\"",
    );
    assert_rejected(
        "convention = \"viscous\"",
        "convention = \"total\"",
        "'lift.convention' is \"total\"; it must be \"viscous\" or \"combined\"",
    );
}

#[test]
fn rejects_numbers_out_of_range() {
    assert_rejected(
        "X_u_dot = { value = -1.9624543703746706",
        "X_u_dot = { value = 1.9",
        "'added_mass.X_u_dot' is 1.9 kg; it must be zero or a negative number",
    );
    assert_rejected(
        "density = { value = 1025.2255",
        "density = { value = 0",
        "'water.density' is 0 kg/m3; it must be a number above zero",
    );
    assert_rejected(
        "density = { value = 1025.2255",
        "density = { value = 1.0252255",
        "'water.density' is 1.0252255 kg/m3; it must be a density of water, from 900 to 1500 kg/m3",
    );
    assert_rejected(
        "z_G = { value = 0.03",
        "z_G = { value = nan",
        "'mass.z_G' is NaN m; it must be any finite number",
    );
    assert_rejected(
        "lag = { value = 0.2",
        "lag = { value = -0.2",
        "'thruster.lag' is -0.2 s; it must be zero or a positive number",
    );
}

#[test]
fn rejects_invalid_actuators() {
    assert_rejected(
        "min = { value = -60.0",
        "min = { value = 160.0",
        "'lower.min' is 160 N and 'lower.max' is 100 N; min must be below max",
    );
    assert_rejected(
        "source = \"assumed: ballast",
        "source = \"\\u0007assumed: ballast",
        "'mass.z_G.source' holds the character U+0007; it must hold printable ones",
    );
    let first = line_of(SQUID, "[[thruster]]");
    assert_rejected(
        "\"upper_port\"",
        "\"lower\"",
        &format!("the actuator name \"lower\" is already taken at line {first}; names must differ"),
    );
    assert_rejected(
        "\"upper_port\"",
        "\"upper port\"",
        "'thruster.name' is \"upper port\"; it must be letters, digits and '_', beginning with a letter",
    );
    let none = &SQUID[..SQUID.find("[[thruster]]").unwrap()];
    let message = Vehicle::parse(none, "v.toml").unwrap_err().to_string();
    assert_eq!(
        message,
        "v.toml:1: no actuator: give at least one [[thruster]], [[thruster_group]] or [[control_surface]]"
    );
    let (found, line) =
        message_of_remus("min = { value = -13.6, unit = \"deg\"", "min = { value = -13.6, unit = \"grad\"");
    assert_eq!(
        found,
        format!(
            "vehicle.toml:{line}: 'control_surface.min' is in \"grad\"; it must be in \"rad\" or \"deg\""
        )
    );
    let (found, line) = message_of_remus("Z_uu_delta", "Z_uud");
    assert!(
        found.starts_with(&format!(
            "vehicle.toml:{line}: unknown key 'control_surface.Z_uud' (did you mean 'Z_uu_delta'?)"
        )),
        "{found}"
    );
}

fn message_of_remus(from: &str, to: &str) -> (String, usize) {
    // The comment above the table names the keys, too.
    let start = REMUS.find("[[control_surface]]").unwrap();
    let (head, tail) = REMUS.split_at(start);
    let text = format!("{head}{}", tail.replacen(from, to, 1));
    let line = head.lines().count() + line_of(tail, from);
    (Vehicle::parse(&text, "vehicle.toml").unwrap_err().to_string(), line)
}

/// The poles printed in the thesis are data of the vehicle file; each mistake in them is reported with its line.
#[test]
fn reads_and_checks_a_published_linear_model() {
    let remus = remus100().published_linear_model.unwrap();
    let poles: Vec<(f64, f64)> = remus.poles.iter().map(|p| (p.re, p.im)).collect();
    assert_eq!((remus.speed, poles), (1.54, vec![(0.174, 0.509), (0.174, -0.509), (-2.44, 0.0)]));
    assert!(remus.source.contains("9.36") && remus.note.contains("does not follow"));
    assert_eq!(squid().published_linear_model, None);

    let poles = "poles = [[0.174, 0.509], [0.174, -0.509], [-2.44, 0.0]]";
    let pairs = "must be pairs [real part, imaginary part] in rad/s, one or more";
    let cases = [
        (
            poles,
            "poles = [[0.174, 0.509, 1.0]]",
            format!("'published_linear_model.poles' is a list; it {pairs}"),
        ),
        (poles, "poles = []", format!("'published_linear_model.poles' is a list; it {pairs}")),
        (poles, "poles = -2.44", format!("'published_linear_model.poles' is the number -2.44; it {pairs}")),
        (poles, "poles = [[inf, 0.0]]", format!("'published_linear_model.poles' is a list; it {pairs}")),
        (
            "speed = { value = 1.54,",
            "speed = { value = -1.54,",
            "'published_linear_model.speed' is -1.54 m/s; it must be a number above zero".into(),
        ),
        (poles, "", "missing key 'published_linear_model.poles': pairs [real part".into()),
        (poles, "zeros = [[0.0, 0.0]]", "unknown key 'published_linear_model.zeros'".into()),
    ];
    for (from, to, expected) in cases {
        let (message, _) = message_of_remus(from, to);
        assert!(message.contains(&expected), "{message}");
    }
}

/// Waves load the hull, whose size the file may contain.
#[test]
fn reads_and_checks_the_size_of_a_hull() {
    let geometry = remus100().geometry.unwrap();
    assert_eq!((geometry.length, geometry.diameter), (1.33, 0.191));
    let diameter = "diameter = { value = 0.191, unit = \"m\", source = \"Prestero (2001)\" }";
    let slender = "must be above zero, and at most half the length: the hull is taken as slender";
    for (from, to, expected) in [
        (diameter, "", "missing key 'geometry.diameter': largest diameter of the hull (m)".into()),
        ("value = 0.191", "value = 0.7", format!("'geometry.diameter' is 0.7 m; it {slender}")),
        ("value = 0.191", "value = -0.1", "'geometry.diameter' is -0.1 m; it must be a number above".into()),
        ("value = 1.33, unit = \"m\"", "value = 133.0, unit = \"cm\"", "is in \"cm\"; it must be in".into()),
        (diameter, "breadth = 0.2", "unknown key 'geometry.breadth'; allowed here: length, diameter".into()),
    ] {
        let (found, _) = message(REMUS, from, to);
        assert!(found.contains(&expected), "{found}");
    }
}

#[test]
fn rejects_indefinite_mass_matrix() {
    let (message, _) = message(SQUID, "Z_q_dot = { value = -0.96", "Z_q_dot = { value = -960.0");
    let line = line_of(SQUID, "[added_mass]");
    assert!(message.starts_with(&format!("vehicle.toml:{line}: the mass matrix")), "{message}");
    assert!(
        message.contains("its least eigenvalue is -") && message.ends_with("must be above zero"),
        "{message}"
    );
}

#[test]
fn rejects_text_that_is_not_toml() {
    assert_rejected("[lift]\n", "[lift\n", "this is not TOML: unclosed table, expected `]`");
}

/// All mistakes are reported, one line each, in the order of the file; a misspelt key is not also missing.
#[test]
fn reports_all_mistakes_at_once() {
    let edits = [
        ("status = \"surrogate\"", "state = \"surrogate\""),
        ("z_G = { value = 0.03, unit = \"m\"", "z_G = { value = 30, unit = \"mm\""),
        ("X_u_dot = { value = -", "X_u_dot = { value = "),
        ("\nM_uq = {", "\nMuq = {"),
        ("lag = { value = 0.2, unit = \"s\"", "lag = { value = 0.2, unit = \"ms\""),
    ];
    let text = edits.iter().fold(SQUID.to_owned(), |text, (old, new)| {
        assert!(text.contains(old), "{old}");
        text.replacen(old, new, 1)
    });
    let message = Vehicle::parse(&text, "vehicle.toml").unwrap_err().to_string();
    let lines: Vec<&str> = message.lines().collect();
    assert_eq!(lines.len(), edits.len(), "{message}");
    for (line, (old, _)) in lines.iter().zip(edits) {
        let number = line_of(SQUID, old.trim());
        assert!(line.starts_with(&format!("vehicle.toml:{number}: ")), "{line} of {number}");
    }
}

/// Common mistakes in units: the weight in kg or pounds, the mass in pounds.
#[test]
fn rejects_weight_inconsistent_with_mass() {
    for (from, to) in [
        ("weight = { value = 654.82400067414", "weight = { value = 66.75"),
        ("weight = { value = 654.82400067414", "weight = { value = 147.16"),
        ("mass = { value = 66.75066265791438", "mass = { value = 147.16"),
        ("mass = { value = 66.75066265791438", "mass = { value = 1e17"),
    ] {
        let (message, _) = message(SQUID, from, to);
        let line = line_of(SQUID, "weight = {");
        assert!(message.starts_with(&format!("vehicle.toml:{line}: 'mass.weight' is ")), "{message}");
        assert!(message.contains("they must agree within 10 % (a weight in kg or pounds"), "{message}");
        assert!(message.lines().count() == 1 && message.len() < 250, "{message}");
    }
    let (found, _) = message(SQUID, "weight = { value = 654.82400067414", "weight = { value = 66.75");
    assert!(found.contains("is 66.75 N and 'mass.mass' times 9.81 m/s2 is 654.824 N"), "{found}");
    // A mass of two digits is accepted.
    let rounded = SQUID.replacen("mass = { value = 66.75066265791438", "mass = { value = 70", 1);
    assert!(Vehicle::parse(&rounded, "vehicle.toml").is_ok());
}

#[test]
fn rejects_duplicate_keys() {
    let duplicated = SQUID.replacen(
        "\nM_q = {",
        "\nZ_w = { value = -1.0, unit = \"kg/s\", source = \"again\" }\nM_q = {",
        1,
    );
    let line = line_of(SQUID, "Z_w = {") + 1;
    let message = Vehicle::parse(&duplicated, "vehicle.toml").unwrap_err().to_string();
    assert!(
        message.starts_with(&format!("vehicle.toml:{line}: 'Z_w' stands here a second time; ")),
        "{message}"
    );
    assert_eq!(message.lines().count(), 1);
}

#[test]
fn shortens_large_numbers_in_messages() {
    assert_rejected(
        "I_yy = { value = 16.687665664478594",
        "I_yy = { value = 1e300",
        "'mass.I_yy' is 1e300 kg.m2; it must be at most 1e18 in size, for the products of larger numbers overflow",
    );
    let trim_error = squid_auv::trim(&squid(), squid_auv::Speed::Path(1e300), 50.0).unwrap_err().to_string();
    assert!(
        trim_error.starts_with("no level trim at 1e300 m/s and 50 m") && trim_error.len() < 300,
        "{trim_error}"
    );
}

#[test]
fn table_of_coefficients_is_consistent() {
    for (i, spec) in COEFFICIENTS.iter().enumerate() {
        assert!(COEFFICIENTS[..i].iter().all(|other| other.key != spec.key), "{} twice", spec.key);
        assert!(!spec.meaning.is_empty() && !spec.unit.is_empty());
        match spec.default {
            DefaultValue::Required => {}
            DefaultValue::Number(default) => assert!(spec.allowed.contains(default), "{}", spec.key),
            DefaultValue::Axisymmetric(of, factor) => {
                assert!(spec.acts_out_of_plane() && factor.abs() == 1.0, "{}", spec.key);
                assert!(
                    COEFFICIENTS.iter().any(|other| other.key == of && !other.acts_out_of_plane()),
                    "{of}"
                );
            }
        }
        let mut coefficients = squid().coefficients;
        (spec.set)(&mut coefficients, -7.5);
        assert_eq!((spec.get)(&coefficients), -7.5, "{}", spec.key);
    }
    assert!(Allowed::NonPositive.contains(0.0) && !Allowed::NonPositive.contains(1e-300));
    assert!(!Allowed::Any.contains(f64::INFINITY));
}

/// Limits of Squid's first thruster, which a table of points may replace.
const LIMITS: &str = "min = { value = -60.0, unit = \"N\"";

/// Returns the file with lines before the limits of the first thruster.
fn with(lines: &str) -> String {
    SQUID.replacen(LIMITS, &format!("{lines}\n{LIMITS}"), 1)
}

/// Returns the file with a curve of points.
fn curve(points: &str) -> String {
    with(&format!("curve = {{ unit = \"us\", source = \"s\", value = {points} }}"))
}

const DEAD_BAND_CURVE: &str = "[[1100.0, -60.0], [1470.0, 0.0], [1530.0, 0.0], [1900.0, 120.0]]";

#[test]
fn reads_the_curve_of_a_thruster() {
    let read = |text: &str| Vehicle::parse(text, "vehicle.toml").unwrap();
    let vehicle = read(&curve(DEAD_BAND_CURVE));
    let lower = &vehicle.actuators[0];
    assert_eq!((lower.unit(), lower.input_unit(), lower.requested_output(1500.0)), ("N", "us", (0.0, 0.0)));
    assert_eq!((lower.min, lower.max, lower.input_for(0.0).0), (-60.0, 100.0, 1500.0));
    assert!((lower.requested_output(lower.input_for(30.0).0).0 - 30.0).abs() < 1e-12);
    assert_eq!(vehicle.sources["lower.curve"], "s");
    assert_eq!(vehicle.actuators[1].curve, None);

    let limits = SQUID.lines().filter(|line| line.starts_with("min =") || line.starts_with("max =")).take(2);
    let without = limits.fold(curve(DEAD_BAND_CURVE), |text, line| text.replacen(line, "", 1));
    let lower = &read(&without).actuators[0];
    assert_eq!((lower.min, lower.max), (-60.0, 120.0), "the limits are the ends of the curve");

    let square = with("T_nn = { value = 1e-4, unit = \"N/rpm2\", source = \"s\" }");
    let lower = &read(&square).actuators[0];
    assert_eq!((lower.input_unit(), lower.requested_output(-100.0).0, lower.max), ("rpm", -1.0, 100.0));
    let back = Vehicle::from_json(&read(&square).to_json().unwrap(), "v").unwrap();
    assert_eq!(back.actuators, read(&square).actuators);
}

#[test]
fn rejects_invalid_curves() {
    let points = "it must be two pairs [command, thrust] or more: commands rise, thrusts never fall, and one is zero \
        or the first is below zero and the last above";
    let key = "'thruster.curve.value' is";
    let expected = [
        ("[[1.0, 2.0]]", format!("{key} [1, 2] alone; {points}")),
        ("[[2.0, -70.0], [1.0, 120.0]]", format!("{key} [1, 120] after [2, -70]; {points}")),
        ("[[1.0, -70.0], [2.0, 120.0], [3.0, 119.0]]", format!("{key} [3, 119] after [2, 120]; {points}")),
        ("[[1.0, 5.0], [2.0, 120.0]]", format!("{key} from [1, 5] to [2, 120]; {points}")),
        ("[]", format!("{key} a list; {points}")),
        ("7.0", format!("{key} the number 7.0; {points}")),
        (
            "[[1.0, -40.0], [2.0, 120.0]]",
            "'thruster.min' is -60 N; it must be at least -40 N, where the curve ends".to_owned(),
        ),
        (
            "[[1.0, -70.0], [2.0, 99.0]]",
            "'thruster.max' is 100 N; it must be at most 99 N, where the curve ends".to_owned(),
        ),
    ];
    for (value, expected_message) in expected {
        let message = Vehicle::parse(&curve(value), "vehicle.toml").unwrap_err().to_string();
        let (_, found) = message.split_once(": ").unwrap();
        assert_eq!(found, expected_message, "{value}");
    }
    let message = |text: &str| {
        Vehicle::parse(text, "v").unwrap_err().to_string().split_once(": ").unwrap().1.to_owned()
    };
    let units = "\"1\" or \"%\" or \"us\" or \"rpm\" or \"rad/s\"";
    assert_eq!(
        message(&curve(DEAD_BAND_CURVE).replacen("\"us\"", "\"ms\"", 1)),
        format!("'thruster.curve.unit' is \"ms\"; it must be {units}")
    );
    let square = "T_nn = { value = 1e-4, unit = \"N/rpm2\", source = \"s\" }";
    assert_eq!(
        message(&with(&square.replace("rpm2", "rpm"))),
        "'thruster.T_nn' is in \"N/rpm\"; it must be in \"N/rpm2\" or \"N.s2/rad2\""
    );
    assert_eq!(
        message(&with(&square.replace("1e-4", "-1e-4"))),
        "'thruster.T_nn' is -0.0001 N/rpm2; it must be a number above zero"
    );
    assert_eq!(
        message(&curve(DEAD_BAND_CURVE).replacen("curve =", &format!("{square}\ncurve ="), 1)),
        "'thruster.T_nn' is given; it must be left out, since 'curve' is there: a thruster has one of the two"
    );
    let fin = REMUS.replacen(
        "Z_uu_delta =",
        "T_nn = { value = 1.0, unit = \"N/rpm2\", source = \"s\" }\nZ_uu_delta =",
        1,
    );
    assert!(message(&fin).starts_with("unknown key 'control_surface.T_nn'"), "{}", message(&fin));
}

/// A physically impossible moment of inertia, and deflections beyond 90 deg, are rejected with the value found and the
/// allowed values; deflections beyond stall get a remark.
#[test]
fn rejects_impossible_inertia_and_deflection() {
    let (found, _) = message(SQUID, "I_yy = { value = 16.687665664478594", "I_yy = { value = 1e-6");
    assert!(found.contains("'mass.I_yy' is 1e-6 kg.m2"), "{found}");
    assert!(found.contains("above mass (x_G^2 + z_G^2) = 0.0600"), "{found}");
    let small = SQUID.replacen("I_yy = { value = 16.68", "I_yy = { value = 1.68", 1);
    let remarks = Vehicle::parse(&small, "vehicle.toml").unwrap().remarks();
    assert!(remarks.iter().any(|remark| remark.contains("below 1.66")), "{remarks:?}");
    let limit = "max = { value = 13.6, unit = \"deg\"";
    assert!(REMUS.contains(limit));
    let with = |value: &str, unit: &str| {
        REMUS.replacen(limit, &format!("max = {{ value = {value}, unit = \"{unit}\""), 1)
    };
    let message = Vehicle::parse(&with("13.6", "rad"), "vehicle.toml").unwrap_err().to_string();
    assert!(message.contains("'control_surface.max' is 13.6 rad, or 779"), "{message}");
    assert!(message.contains("it must be from -90 to 90 deg"), "{message}");
    let remarks = Vehicle::parse(&with("60", "deg"), "vehicle.toml").unwrap().remarks();
    assert!(remarks.len() == 1 && remarks[0].contains("is deflected by up to 60 deg"), "{remarks:?}");
}

/// Changes that are allowed but improbable get a remark each; the vehicles of this repository get none.
#[test]
fn remarks_on_improbable_changes() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let shipped = ["squid", "remus100", "lauv", "tethys", "sparus2", "bluerov2_heavy"];
    let files = shipped.map(|name| format!("vehicles/{name}/vehicle.toml"));
    for file in files.iter().map(String::as_str).chain(["tests/vehicles/nps_auv_ii/vehicle.toml"]) {
        let text = std::fs::read_to_string(root.join(file)).unwrap();
        assert_eq!(Vehicle::parse(&text, file).unwrap().remarks(), [""; 0], "{file}");
    }
    for (from, to, expected) in [
        ("z_G = { value = 0.03,", "z_G = { value = -0.03,", "gravity is 0.03 m above the centre of buoyancy"),
        ("Z_uw = { value = -67", "Z_uw = { value = 67", "acts in the direction of w"),
        ("M_uq = { value = -20", "M_uq = { value = 20", "acts in the direction of q"),
        ("I_yy = { value = 16.68", "I_yy = { value = 166.8", "at the two ends of the hull"),
        ("M_q_dot = { value = -12.25", "M_q_dot = { value = -1225.", "'M_q_dot' is 73.4"),
        ("lag = { value = 0.2,", "lag = { value = 200.0,", "the lag of 'lower' is 200 s"),
        (
            "Z_q_dot = { value = -0.96",
            "Z_q_dot = { value = 0.96",
            "'Z_q_dot' is 0.960938 kg.m and 'M_w_dot' -0.960938",
        ),
        ("max = { value = 100", "max = { value = 2000", "push ahead with up to 2200 N"),
        (
            "[geometry]\nlength = { value = 2.0",
            "[geometry]\nlength = { value = 2210",
            "length' is 2210 m long",
        ),
    ] {
        assert_one_remark(SQUID, &[(from, to)], expected);
    }
    for (changes, expected) in [
        (
            &[("M_uu_delta = { value = -6.15", "M_uu_delta = { value = 6.15")][..],
            "pitches as a fin 0.637967 m ahead",
        ),
        (
            &[("N_uu_delta = { value = -6.15", "N_uu_delta = { value = 6.15")],
            "yaws as a fin 0.637967 m ahead",
        ),
        (&[("X_uu = { value = -1.62", "X_uu = { value = 0.0")], "no drag along the hull"),
        (
            &[("convention = \"combined\"", "convention = \"viscous\"")],
            "resist with 'lift.convention' \"combined\"",
        ),
        (
            &[(
                "[damping]",
                "[damping]\nZ_w = { value = -44.044, unit = \"kg/s\", source = \"Z_uw at 1.54 m/s\" }\n\
               M_q = { value = -3.08, unit = \"kg.m2/s\", source = \"M_uq at 1.54 m/s\" }",
            )],
            "'Z_w', 'M_q' are 'Z_uw', 'M_uq' times 1.54 m/s",
        ),
        (
            &[(
                "[damping]",
                "[damping]\nZ_w = { value = -44.0, unit = \"kg/s\", source = \"s\" }\n\
               M_w = { value = 40.0, unit = \"kg.m/s\", source = \"with the Munk moment\" }\n\
               M_q = { value = -3.1, unit = \"kg.m2/s\", source = \"s\" }",
            )],
            "'Z_q' and 'M_w' drive the hull",
        ),
    ] {
        assert_one_remark(REMUS, changes, expected);
    }
    let duplicated = [("convention = \"viscous\"", "convention = \"combined\"")];
    assert_one_remark(SQUID, &duplicated, "resist with 'lift.convention' \"viscous\"");
}

/// Checks that a file with these changes gets one remark, with the expected text.
fn assert_one_remark(text: &str, changes: &[(&str, &str)], expected: &str) {
    let changed = changes.iter().fold(text.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replacen(from, to, 1)
    });
    let remarks = Vehicle::parse(&changed, "vehicle.toml").unwrap().remarks();
    assert!(remarks.len() == 1 && remarks[0].contains(expected), "{expected}: {remarks:?}");
}

/// Common mistakes in a first file have specific messages.
#[test]
fn names_common_mistakes() {
    let of = |text: &str| Vehicle::parse(text, "vehicle.toml").unwrap_err().mistakes;
    let mistakes_after = |from: &str, to: &str| of(&SQUID.replacen(from, to, 1));
    let comma = mistakes_after("z_G = { value = 0.03,", "z_G = { value = 0,03,");
    assert!(matches!(&comma[0].problem, FileProblem::DecimalComma { found } if found == "0,03"), "{comma:?}");
    let partner = "N_v_dot = { value = 1.0, unit = \"kg.m\", source = \"s\" }";
    let partner = mistakes_after("[added_mass]", &format!("[added_mass]\n{partner}"));
    assert!(
        matches!(&partner[0].problem, FileProblem::UnknownKey { suggestion: Some(own), .. } if own == "Y_r_dot"),
        "{partner:?}"
    );
    let reversed = REMUS.replacen("min = { value = -13.6", "min = { value = 13.7", 1);
    let reversed = of(&reversed);
    assert!(
        matches!(&reversed[0].problem, FileProblem::LimitsReversed { unit: "deg", min, .. }
            if (min - 13.7).abs() < 1e-9),
        "{reversed:?}"
    );
}

/// A dotted name is a table in TOML, unless it is in quotes.
#[test]
fn distinguishes_dotted_names_from_tables() {
    let text = "a.b = 1\n\"c.d\" = 2\n[e]\nf = 3\n";
    let document = squid_auv::toml_file::Document::parse(text, "f.toml").unwrap();
    assert_eq!(["a", "c.d", "e", "g"].map(|key| document.root().is_dotted(key)), [true, false, false, false]);
}

/// Lists far longer than for any vehicle are rejected at once, with their limit.
#[test]
fn rejects_overlong_lists() {
    let points: Vec<String> = (0..100_000).map(|i| format!("[{i}.0, {i}.0]")).collect();
    let points = format!("[{}]", points.join(", "));
    let thruster = SQUID.split("\n[[thruster]]\n").nth(1).unwrap();
    let thrusters: String = (0..2000)
        .map(|i| format!("\n[[thruster]]\n{}\n", thruster.replacen("\"lower\"", &format!("\"t{i}\""), 1)))
        .collect();
    let stations = format!("\n[hull]\nstations = {{ value = {points}, unit = \"m\", source = \"s\" }}\n");
    let stations = stations + "C_d = { value = 1.0, unit = \"1\", source = \"s\" }\n[drag]\n";
    for (text, most) in [
        (curve(&points), 1000),
        (SQUID.replacen("\n[drag]\n", &stations, 1), 1000),
        (SQUID.replacen("\n[[thruster]]\n", &format!("{thrusters}\n[[thruster]]\n"), 1), 100),
    ] {
        let mistakes = Vehicle::parse(&text, "vehicle.toml").unwrap_err().mistakes;
        assert_eq!(mistakes.len(), 1, "{mistakes:?}");
        assert!(matches!(mistakes[0].problem, FileProblem::TooLong { most: found, .. } if found == most));
    }
}
