//! Every mistake in a vehicle file is reported with its line and key; snapshots hold the messages.

use std::path::Path;

use crate::common::{message, places, remus100, squid};
use squid_auv::toml_file::FileError;
use squid_auv::{Allowed, COEFFICIENTS, DefaultValue, Effect, FileProblem, Status, Vehicle};

const SQUID: &str = include_str!("../../../../vehicles/squid/vehicle.toml");
const REMUS: &str = include_str!("../../../../vehicles/remus100/vehicle.toml");

/// Returns the line, counted from 1, that contains a marker first, or that equals it if it is a header.
fn line_of(text: &str, marker: &str) -> usize {
    let is_header = marker.starts_with('[');
    let holds = |line: &str| if is_header { line == marker } else { line.contains(marker) };
    text.lines().position(holds).expect(marker) + 1
}

/// Replaces text in a vehicle file, and returns the error and the line of the replacement.
fn rejected(file: &str, from: &str, to: &str) -> (FileError, usize) {
    assert!(file.contains(from), "{from}");
    let line = line_of(file, from.lines().next().unwrap());
    (Vehicle::parse(&file.replacen(from, to, 1), "vehicle.toml").expect_err(to), line)
}

/// Does the same in the actuators with fins of REMUS 100: the comment above the table names the keys, too.
fn rejected_fin(from: &str, to: &str) -> (FileError, usize) {
    let (head, tail) = REMUS.split_at(REMUS.find("[[control_surface]]").unwrap());
    let text = format!("{head}{}", tail.replacen(from, to, 1));
    (Vehicle::parse(&text, "vehicle.toml").expect_err(to), head.lines().count() + line_of(tail, from))
}

/// Checks that each replacement in the file of Squid is a mistake in its line with this key; returns the messages.
#[track_caller]
fn messages(cases: &[(&str, &str, &str)]) -> String {
    let one = |&(from, to, key): &(&str, &str, &str)| {
        let (error, line) = rejected(SQUID, from, to);
        message(to, &error, (line, key))
    };
    cases.iter().map(one).collect::<Vec<_>>().join("\n\n")
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
    let key = "z = { value = 0.2, unit = \"m\"";
    insta::assert_snapshot!(messages(&[
        ("Z_uw = {", "Zuw = {", "lift.Zuw"),
        ("form_factor = {", "quality = {", "drag.quality"),
        ("[damping]", "[dampnig]", "dampnig"),
        (key, "z = { value = 0.2, units = \"m\"", "thruster.z.units"),
        ("status =", "state =", "vehicle.state"),
    ]));
    let (two, line) = rejected(SQUID, key, "height = { value = 0.2, unit = \"m\"");
    assert_eq!(places(&two), [(line_of(SQUID, "[[thruster]]"), "thruster.z"), (line, "thruster.height")]);
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
    let rejected = |from: &str, to: &str| {
        let text = format!("{SQUID}{}", GROUP.replacen(from, to, 1));
        Vehicle::parse(&text, "vehicle.toml").expect_err(to)
    };
    let line = SQUID.lines().count() + 2;
    let share = "share = { value = 1.0, unit = \"1\", source = \"s\" }";
    let thrusters = &GROUP[GROUP.find("[[thruster_group.thruster]]").unwrap()..];
    let messages = [
        message("no share", &rejected(share, ""), (line + 5, "thruster_group.thruster.share")),
        message("no thruster", &rejected(thrusters, ""), (line, "thruster_group.thruster")),
    ];
    insta::assert_snapshot!(messages.join("\n\n"));
    let misspelt = [(line + 5, "thruster_group.thruster.share"), (line + 6, "thruster_group.thruster.part")];
    assert_eq!(places(&rejected("share", "part")), misspelt);
    assert_name_is_taken(&rejected("\"couple\"", "\"lower\""), line + 1);
}

/// Checks that the only mistake is the name of Squid's first thruster in a line.
fn assert_name_is_taken(error: &FileError, line: usize) {
    message("", error, (line, ""));
    let FileProblem::DuplicateActuator { name, first_line } = &error.mistakes[0].problem else {
        panic!("{error}")
    };
    assert_eq!((name.as_str(), *first_line), ("lower", line_of(SQUID, "[[thruster]]")));
}

#[test]
fn rejects_missing_keys() {
    let mut found = vec![];
    for (start, table, key) in [
        ("Z_w_dot", "[added_mass]", "added_mass.Z_w_dot"),
        ("convention", "[lift]", "lift.convention"),
        ("name", "[vehicle]", "vehicle.name"),
        ("z = ", "[[thruster]]", "thruster.z"),
        ("lag", "[[thruster]]", "thruster.lag"),
    ] {
        let line = SQUID.lines().find(|line| line.starts_with(start)).expect(start);
        let (error, _) = rejected(SQUID, line, "");
        found.push(message(&format!("no {start}"), &error, (line_of(SQUID, table), key)));
    }
    let water = &SQUID[SQUID.find("[water]").unwrap()..SQUID.find("# Added mass").unwrap()];
    found.push(message("no [water]", &rejected(SQUID, water, "").0, (1, "water")));
    found.push(messages(&[
        (", source = \"derived: mass times 9.81 m/s2\"", "", "mass.weight.source"),
        ("unit = \"kg\", source = \"derived from geometry: displaced", "source = \"", "mass.mass.unit"),
    ]));
    insta::assert_snapshot!(found.join("\n\n"));
}

#[test]
fn rejects_wrong_units_types_and_texts() {
    let ballast = "source = \"assumed: ballast low in the hull\"";
    insta::assert_snapshot!(messages(&[
        (
            "unit = \"N\", source = \"derived: mass times",
            "unit = \"lbf\", source = \"derived: mass times",
            "mass.weight",
        ),
        (&format!("z_G = {{ value = 0.03, unit = \"m\", {ballast} }}"), "z_G = 0.03", "mass.z_G"),
        ("z_G = { value = 0.03", "z_G = { value = \"3 cm\"", "mass.z_G.value"),
        (ballast, "source = \" \"", "mass.z_G.source"),
        (ballast, "source = \"\\u0007\"", "mass.z_G.source"),
        ("name = \"squid\"", "name = 7", "vehicle.name"),
        ("status = \"surrogate\"", "status = \"surogate\"", "vehicle.status"),
        ("convention = \"viscous\"", "convention = \"total\"", "lift.convention"),
    ]));
}

#[test]
fn rejects_numbers_out_of_range() {
    insta::assert_snapshot!(messages(&[
        ("X_u_dot = { value = -1.9624543703746706", "X_u_dot = { value = 1.9", "added_mass.X_u_dot"),
        ("density = { value = 1025.2255", "density = { value = 0", "water.density"),
        ("density = { value = 1025.2255", "density = { value = 1.0252255", "water.density"),
        ("z_G = { value = 0.03", "z_G = { value = nan", "mass.z_G"),
        ("lag = { value = 0.2", "lag = { value = -0.2", "thruster.lag"),
        ("I_yy = { value = 16.687665664478594", "I_yy = { value = 1e300", "mass.I_yy"),
    ]));
}

#[test]
fn rejects_invalid_actuators() {
    let none = Vehicle::parse(&SQUID[..SQUID.find("[[thruster]]").unwrap()], "vehicle.toml").unwrap_err();
    let (degrees, line) =
        rejected_fin("min = { value = -13.6, unit = \"deg\"", "min = { value = -13.6, unit = \"grad\"");
    let (misspelt, at) = rejected_fin("Z_uu_delta", "Z_uud");
    let found = [
        messages(&[
            ("min = { value = -60.0", "min = { value = 160.0", "lower"),
            ("\"upper_port\"", "\"upper port\"", "thruster.name"),
        ]),
        message("no actuator", &none, (1, "")),
        message("grad", &degrees, (line, "control_surface.min")),
        message("Z_uud", &misspelt, (at, "control_surface.Z_uud")),
    ];
    insta::assert_snapshot!(found.join("\n\n"));
    let (twice, line) = rejected(SQUID, "\"upper_port\"", "\"lower\"");
    assert_name_is_taken(&twice, line);
}

/// The poles printed in the thesis are data of the vehicle file; each mistake in them is reported with its line.
#[test]
fn reads_and_checks_a_published_linear_model() {
    let remus = remus100().published_linear_model.unwrap();
    let poles: Vec<(f64, f64)> = remus.poles.iter().map(|p| (p.re, p.im)).collect();
    assert_eq!((remus.speed, poles), (1.54, vec![(0.174, 0.509), (0.174, -0.509), (-2.44, 0.0)]));
    assert!(remus.source.contains("9.36") && !remus.note.is_empty());
    assert_eq!(squid().published_linear_model, None);

    let poles = "poles = [[0.174, 0.509], [0.174, -0.509], [-2.44, 0.0]]";
    let header = line_of(REMUS, "[published_linear_model]");
    let at = line_of(REMUS, poles);
    let messages = [
        (poles, "poles = [[0.174, 0.509, 1.0]]", at, "poles"),
        (poles, "poles = []", at, "poles"),
        (poles, "poles = -2.44", at, "poles"),
        (poles, "poles = [[inf, 0.0]]", at, "poles"),
        (
            "speed = { value = 1.54,",
            "speed = { value = -1.54,",
            line_of(REMUS, "speed = { value = 1.54,"),
            "speed",
        ),
        (poles, "", header, "poles"),
    ]
    .map(|(from, to, line, key)| {
        message(to, &rejected(REMUS, from, to).0, (line, &format!("published_linear_model.{key}")))
    });
    insta::assert_snapshot!(messages.join("\n\n"));
    let unknown = rejected(REMUS, poles, "zeros = [[0.0, 0.0]]").0;
    let expected = [(header, "published_linear_model.poles"), (at, "published_linear_model.zeros")];
    assert_eq!(places(&unknown), expected);
}

/// Waves load the hull, whose size the file may contain.
#[test]
fn reads_and_checks_the_size_of_a_hull() {
    let geometry = remus100().geometry.unwrap();
    assert_eq!((geometry.length, geometry.diameter), (1.33, 0.191));
    let diameter = "diameter = { value = 0.191, unit = \"m\", source = \"Prestero (2001)\" }";
    let (header, at) = (line_of(REMUS, "[geometry]"), line_of(REMUS, diameter));
    let length = "length = { value = 1.33, unit = \"m\"";
    let messages = [
        (diameter, "", header, "diameter"),
        ("value = 0.191", "value = 0.7", at, "diameter"),
        ("value = 0.191", "value = -0.1", at, "diameter"),
        (length, "length = { value = 133.0, unit = \"cm\"", line_of(REMUS, length), "length"),
    ]
    .map(|(from, to, line, key)| {
        message(to, &rejected(REMUS, from, to).0, (line, &format!("geometry.{key}")))
    });
    insta::assert_snapshot!(messages.join("\n\n"));
    let unknown = rejected(REMUS, diameter, "breadth = 0.2").0;
    assert_eq!(places(&unknown), [(header, "geometry.diameter"), (at, "geometry.breadth")]);
}

#[test]
fn rejects_indefinite_mass_matrix() {
    let (mut error, _) = rejected(SQUID, "Z_q_dot = { value = -0.96", "Z_q_dot = { value = -960.0");
    message("", &error, (line_of(SQUID, "[added_mass]"), ""));
    let problem = &mut error.mistakes[0].problem;
    let FileProblem::MassMatrixNotPositiveDefinite { least_eigenvalue, .. } = problem else {
        panic!("{problem}")
    };
    assert!(std::mem::replace(least_eigenvalue, -1.0) < 0.0);
    insta::assert_snapshot!(problem);
}

#[test]
fn rejects_text_that_is_not_toml() {
    insta::assert_snapshot!(messages(&[("[lift]\n", "[lift\n", "")]));
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
    let error = Vehicle::parse(&text, "vehicle.toml").unwrap_err();
    let lines = error.mistakes.iter().map(|one| one.line);
    assert!(lines.eq(edits.map(|(old, _)| line_of(SQUID, old.trim()))), "{error}");
    insta::assert_snapshot!(error);
}

/// Common mistakes in units: the weight in kg or pounds, the mass in pounds.
#[test]
fn rejects_weight_inconsistent_with_mass() {
    let (weight, mass) = ("weight = { value = 654.82400067414", "mass = { value = 66.75066265791438");
    let messages = [
        (weight, "weight = { value = 66.75", 66.75, 66.75066265791438),
        (weight, "weight = { value = 147.16", 147.16, 66.75066265791438),
        (mass, "mass = { value = 147.16", 654.82400067414, 147.16),
        (mass, "mass = { value = 1e17", 654.82400067414, 1e17),
    ]
    .map(|(from, to, newtons, kilograms)| {
        let (error, _) = rejected(SQUID, from, to);
        let FileProblem::MassAndWeight { weight, expected, gravity, .. } = error.mistakes[0].problem else {
            panic!("{error}")
        };
        assert_eq!((weight, expected, gravity), (newtons, kilograms * 9.81, 9.81));
        message(to, &error, (line_of(SQUID, "weight = {"), ""))
    });
    insta::assert_snapshot!(messages.join("\n\n"));
    // A mass of two digits is accepted.
    let rounded = SQUID.replacen(mass, "mass = { value = 70", 1);
    assert!(Vehicle::parse(&rounded, "vehicle.toml").is_ok());
}

#[test]
fn rejects_duplicate_keys() {
    let again = "\nZ_w = { value = -1.0, unit = \"kg/s\", source = \"again\" }\nM_q = {";
    let (error, _) = rejected(SQUID, "\nM_q = {", again);
    insta::assert_snapshot!(message("Z_w", &error, (line_of(SQUID, "Z_w = {") + 1, "Z_w")));
}

#[test]
fn shortens_large_numbers_in_messages() {
    let error = squid_auv::trim(&squid(), squid_auv::Speed::Path(1e300), 50.0).unwrap_err();
    assert!(error.to_string().len() < 300, "{error}");
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
    let at = line_of(SQUID, LIMITS);
    let limits = line_of(&curve(DEAD_BAND_CURVE), LIMITS);
    let square = "T_nn = { value = 1e-4, unit = \"N/rpm2\", source = \"s\" }";
    let both = curve(DEAD_BAND_CURVE).replacen("curve =", &format!("{square}\ncurve ="), 1);
    let mut messages = vec![];
    for (what, text, line, key) in [
        ("one point", curve("[[1.0, 2.0]]"), at, "curve.value"),
        ("falling commands", curve("[[2.0, -70.0], [1.0, 120.0]]"), at, "curve.value"),
        ("falling thrusts", curve("[[1.0, -70.0], [2.0, 120.0], [3.0, 119.0]]"), at, "curve.value"),
        ("no zero", curve("[[1.0, 5.0], [2.0, 120.0]]"), at, "curve.value"),
        ("no point", curve("[]"), at, "curve.value"),
        ("a number", curve("7.0"), at, "curve.value"),
        ("a limit below the curve", curve("[[1.0, -40.0], [2.0, 120.0]]"), limits, "min"),
        ("a limit above the curve", curve("[[1.0, -70.0], [2.0, 99.0]]"), limits + 1, "max"),
        ("the unit of commands", curve(DEAD_BAND_CURVE).replacen("\"us\"", "\"ms\"", 1), at, "curve.unit"),
        ("the unit of a square law", with(&square.replace("rpm2", "rpm")), at, "T_nn"),
        ("a negative square law", with(&square.replace("1e-4", "-1e-4")), at, "T_nn"),
        ("a square law beside a curve", both, at, "T_nn"),
    ] {
        let error = Vehicle::parse(&text, "vehicle.toml").expect_err(what);
        messages.push(message(what, &error, (line, &format!("thruster.{key}"))));
    }
    insta::assert_snapshot!(messages.join("\n\n"));
    let (fin, line) = rejected_fin("Z_uu_delta =", &format!("{square}\nZ_uu_delta ="));
    message("", &fin, (line, "control_surface.T_nn"));
}

/// A physically impossible moment of inertia, and deflections beyond 90 deg, are rejected; deflections beyond stall get
/// a remark.
#[test]
fn rejects_impossible_inertia_and_deflection() {
    let light = rejected(SQUID, "I_yy = { value = 16.687665664478594", "I_yy = { value = 1e-6");
    let FileProblem::Inertia { inertia, of_a_point, .. } = light.0.mistakes[0].problem else {
        panic!("{}", light.0)
    };
    assert!(inertia == 1e-6 && (of_a_point - 66.75066265791438 * 0.03 * 0.03).abs() < 1e-12, "{of_a_point}");
    let small = SQUID.replacen("I_yy = { value = 16.68", "I_yy = { value = 1.68", 1);
    let small = Vehicle::parse(&small, "vehicle.toml").unwrap();
    let limit = "max = { value = 13.6, unit = \"deg\"";
    let radians = rejected(REMUS, limit, "max = { value = 13.6, unit = \"rad\"");
    let messages = [
        message("a light hull", &light.0, (light.1, "I_yy")),
        message("13.6 rad", &radians.0, (radians.1, "control_surface.max")),
        small.findings().iter().map(|found| format!("{found}\n")).collect(),
        finding(REMUS, (limit, "max = { value = 60, unit = \"deg\"")),
    ];
    insta::assert_snapshot!(messages.join("\n\n"));
}

/// Changes that are allowed but improbable give a finding each; the vehicles of this repository give none.
#[test]
fn finds_improbable_changes() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let shipped = ["squid", "remus100", "lauv", "tethys", "sparus2", "bluerov2_heavy"];
    let files = shipped.map(|name| format!("vehicles/{name}/vehicle.toml"));
    for file in files.iter().map(String::as_str).chain(["tests/vehicles/nps_auv_ii/vehicle.toml"]) {
        let text = std::fs::read_to_string(root.join(file)).unwrap();
        assert_eq!(Vehicle::parse(&text, file).unwrap().findings(), [], "{file}");
    }
    let squid = [
        ("z_G = { value = 0.03,", "z_G = { value = -0.03,"),
        ("Z_uw = { value = -67", "Z_uw = { value = 67"),
        ("M_uq = { value = -20", "M_uq = { value = 20"),
        ("I_yy = { value = 16.68", "I_yy = { value = 166.8"),
        ("M_q_dot = { value = -12.25", "M_q_dot = { value = -1225."),
        ("lag = { value = 0.2,", "lag = { value = 200.0,"),
        ("Z_q_dot = { value = -0.96", "Z_q_dot = { value = 0.96"),
        ("max = { value = 100", "max = { value = 2000"),
        ("[geometry]\nlength = { value = 2.0", "[geometry]\nlength = { value = 2210"),
        ("convention = \"viscous\"", "convention = \"combined\""),
    ];
    let remus = [
        ("M_uu_delta = { value = -6.15", "M_uu_delta = { value = 6.15"),
        ("N_uu_delta = { value = -6.15", "N_uu_delta = { value = 6.15"),
        ("X_uu = { value = -1.62", "X_uu = { value = 0.0"),
        ("convention = \"combined\"", "convention = \"viscous\""),
        (
            "[damping]",
            "[damping]\nZ_w = { value = -44.044, unit = \"kg/s\", source = \"Z_uw at 1.54 m/s\" }\n\
             M_q = { value = -3.08, unit = \"kg.m2/s\", source = \"M_uq at 1.54 m/s\" }",
        ),
        (
            "[damping]",
            "[damping]\nZ_w = { value = -44.0, unit = \"kg/s\", source = \"s\" }\n\
             M_w = { value = 40.0, unit = \"kg.m/s\", source = \"with the Munk moment\" }\n\
             M_q = { value = -3.1, unit = \"kg.m2/s\", source = \"s\" }",
        ),
    ];
    let of_squid = squid.into_iter().map(|change| finding(SQUID, change));
    let all: Vec<_> = of_squid.chain(remus.into_iter().map(|change| finding(REMUS, change))).collect();
    insta::assert_snapshot!(all.join("\n\n"));
}

/// Returns the only finding on a file with a change, below the change.
fn finding(text: &str, (from, to): (&str, &str)) -> String {
    assert!(text.contains(from), "{from}");
    let found = Vehicle::parse(&text.replacen(from, to, 1), "vehicle.toml").unwrap().findings();
    let [one] = &found[..] else { panic!("{from}: {found:?}") };
    format!("{to}:\n{} of {}: {one}", one.kind, one.key)
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
