//! Refused controllers: line and key of each mistake; snapshots hold the messages.

use crate::vehicles::{layout, made, mistake};
use squid_pid::Layout;

const GOOD: &str = "[controller]\nkind = \"pid\"\n[controller.pitch]\nkp = { value = 5.0, unit = \"rad/rad\" }\n\
    ki = { value = 0.3, unit = \"1/s\" }\nkd = { value = 2.0, unit = \"s\" }\n[controller.speed]\n\
    kp = { value = 30.0, unit = \"N.s/m\" }\n";

#[test]
fn reads_a_controller() {
    let states = made("remus100", &layout("pitch"), GOOD).unwrap().states;
    insta::assert_snapshot!(states.join("\n"));
}

#[test]
fn refuses_gains_units_forms_and_tables() {
    let cases = [
        ("an integrator without gain", "value = 0.3", "value = 0.0", 5, "pitch.ki"),
        ("without gain at the slowest speed", "value = 0.3", "value = [0.3, 0.3]", 5, "pitch.ki"),
        ("a moment for planes", "\"rad/rad\"", "\"N.m/rad\"", 4, "pitch.kp"),
        ("an angle for a force", "\"N.s/m\"", "\"rad/rad\"", 8, "speed.kp"),
        ("positive feedback", "value = 5.0", "value = -5.0", 4, "pitch.kp"),
        ("positive feedback at some speeds", "value = 2.0", "value = [1.0, -2.0]", 6, "pitch.kd"),
        (
            "a gain before the integrator",
            "\"pid\"",
            "\"pid\"\nintegrator = \"scheduled input\"",
            3,
            "integrator",
        ),
        (
            "too few points",
            "value = 5.0",
            "table = [[1.4, 5.0], [2.2, 4.0]], degree = 2",
            4,
            "pitch.kp.table",
        ),
        (
            "speeds that do not increase",
            "value = 5.0",
            "table = [[2.2, 5.0], [1.4, 4.0]]",
            4,
            "pitch.kp.table",
        ),
        ("too high a degree", "value = 5.0", "value = [1.0, 2.0, 3.0, 4.0]", 4, "pitch.kp.value"),
        ("a table beside a value", "value = 5.0", "value = 5.0, table = [[1.4, 5.0]]", 4, "pitch.kp.table"),
    ];
    let mut messages = vec![];
    for (what, from, to, line, key) in cases {
        assert!(GOOD.contains(from), "{from}");
        let error = made("remus100", &layout("pitch"), &GOOD.replacen(from, to, 1)).unwrap_err();
        assert_eq!(mistake(&error), (line, format!("controller.{key}")), "{error}");
        messages.push(format!("{what}:\n{error}"));
    }
    // Squid pitches by thrusters.
    let error = made("squid", &layout("pitch"), GOOD).unwrap_err();
    assert_eq!(mistake(&error), (4, "controller.pitch.kp".into()));
    messages.push(format!("a deflection for thrusters:\n{error}"));
    insta::assert_snapshot!(messages.join("\n\n"));
    let after = GOOD.replacen("kind", "integrator = \"scheduled output\"\nkind", 1);
    assert!(made("remus100", &layout("pitch"), &after).is_ok());
}

/// The keys of the table depend on its kind: where that is wrong, it is the only mistake.
#[test]
fn reports_only_the_kind_if_it_is_wrong() {
    let mut messages = vec![];
    for kind in ["\"pdi\"", "\"full\"", "\"\"", "1"] {
        let error = squid_pid::read_file(&GOOD.replacen("\"pid\"", kind, 1), "mine.toml").unwrap_err();
        assert_eq!(mistake(&error), (2, "controller.kind".into()), "{error}");
        messages.push(error.to_string());
    }
    let error = squid_pid::read_file("[controller]\nkind = \"full\"\nkp = 1.0\n", "mine.toml").unwrap_err();
    assert_eq!(error.mistakes.iter().map(|one| one.line).collect::<Vec<_>>(), [2, 3]);
    messages.push(error.to_string());
    insta::assert_snapshot!(messages.join("\n\n"));
}

#[test]
fn refuses_loops_of_untracked_signals() {
    let mut blind = layout("pitch");
    blind.measurements.retain(|port| port.signal != "pitch_rate");
    let cases = [
        ("the rate is not measured", blind, 6, "controller.pitch.kd"),
        ("the errors alone are measured", Layout::default(), 3, "controller.pitch"),
        ("depth is tracked", layout("depth"), 1, "controller.depth"),
    ];
    let mut messages = vec![];
    for (what, layout, line, key) in cases {
        let error = made("remus100", &layout, GOOD).unwrap_err();
        assert_eq!(mistake(&error), (line, key.to_owned()), "{error}");
        messages.push(format!("{what}:\n{error}"));
    }
    insta::assert_snapshot!(messages.join("\n\n"));
}

#[test]
fn refuses_unsuitable_actuators() {
    let with = |allocation: &str| {
        let text = format!("{GOOD}[controller.allocation]\n{allocation}\n");
        made("remus100", &layout("pitch"), &text)
    };
    let cases = [
        ("pitch = { rudder = 1.0 }", 10, "controller.allocation.pitch"),
        ("speed = { stern_planes = 1.0 }", 10, "controller.allocation.speed"),
        ("pitch = { propeller = 1.0 }", 10, "controller.allocation.pitch"),
        // Without the minus sign the planes turn the bow down.
        ("pitch = { stern_planes = 1.0 }", 4, "controller.pitch.kp"),
    ];
    let mut messages = vec![];
    for (allocation, line, key) in cases {
        let error = with(allocation).unwrap_err();
        assert_eq!(mistake(&error), (line, key.to_owned()), "{error}");
        messages.push(format!("{allocation}:\n{error}"));
    }
    insta::assert_snapshot!(messages.join("\n\n"));
    assert!(with("pitch = { stern_planes = -2.0 }").is_ok());
}
