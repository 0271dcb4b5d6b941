//! What is refused: each message names file, line, key, what was found, and what is allowed.

use crate::vehicles::{layout, made};
use squid_pid::Layout;

const GOOD: &str = "[controller]\nkind = \"pid\"\n[controller.pitch]\nkp = { value = 5.0, unit = \"rad/rad\" }\n\
    ki = { value = 0.3, unit = \"1/s\" }\nkd = { value = 2.0, unit = \"s\" }\n[controller.speed]\n\
    kp = { value = 30.0, unit = \"N.s/m\" }\n";

/// The message of the good file with one part replaced.
fn refused(from: &str, to: &str) -> String {
    assert!(GOOD.contains(from), "{from}");
    made("remus100", &layout("pitch"), &GOOD.replacen(from, to, 1)).unwrap_err()
}

#[test]
fn the_good_file_is_read() {
    let states = made("remus100", &layout("pitch"), GOOD).unwrap().states;
    assert_eq!(states, ["integral of the pitch error"]);
}

#[test]
fn an_integrator_without_gain_is_refused() {
    for gain in ["value = 0.0", "value = [0.3, 0.3]"] {
        let words = refused("value = 0.3", gain);
        assert!(words.starts_with("mine.toml:5: 'controller.pitch.ki' is 0 rad/(rad.s)"), "{words}");
        assert!(words.contains("or left out: an integrator without gain"), "{words}");
    }
}

#[test]
fn unknown_units_are_refused_with_those_allowed() {
    let words = refused("\"rad/rad\"", "\"N.m/rad\"");
    let expected =
        "mine.toml:4: 'controller.pitch.kp' is in \"N.m/rad\"; it must be in \"rad/rad\" or \"deg/deg\"";
    assert_eq!(words, expected);
    assert!(refused("\"N.s/m\"", "\"rad/rad\"").ends_with("it must be in \"N.s/m\""));
    // Squid pitches by thrusters.
    let words = made("squid", &layout("pitch"), GOOD).unwrap_err();
    assert!(words.ends_with("it must be in \"N.m/rad\" or \"N.m/deg\""), "{words}");
}

#[test]
fn positive_feedback_is_refused() {
    let words = refused("value = 5.0", "value = -5.0");
    assert!(
        words.starts_with("mine.toml:4: 'controller.pitch.kp' is -5 rad/rad; it must be above 0"),
        "{words}"
    );
    assert!(words.contains("positive feedback"), "{words}");
    // A polynomial that changes its sign says where.
    let words = refused("value = 2.0", "value = [1.0, -2.0]");
    assert!(words.contains("'controller.pitch.kd' is") && words.contains(" at 2"), "{words}");
    // The sign of a stated allocation counts: without the minus the planes turn the bow down.
    let wrong = format!("{GOOD}[controller.allocation]\npitch = {{ stern_planes = 1.0 }}\n");
    let words = made("remus100", &layout("pitch"), &wrong).unwrap_err();
    assert!(words.contains("below 0, with this [controller.allocation]"), "{words}");
    assert!(made("remus100", &layout("pitch"), &wrong.replace("= 1.0 }", "= -2.0 }")).is_ok());
}

#[test]
fn gains_before_the_integrator_are_refused_with_the_other_form() {
    let words = refused("kind = \"pid\"", "kind = \"pid\"\nintegrator = \"scheduled input\"");
    assert!(words.contains("\"scheduled output\"") && words.contains("a factor of a hundred"), "{words}");
    assert!(
        made(
            "remus100",
            &layout("pitch"),
            &GOOD.replacen("kind", "integrator = \"scheduled output\"\nkind", 1)
        )
        .is_ok()
    );
}

#[test]
fn a_signal_that_is_not_measured_is_named() {
    let mut blind = layout("pitch");
    blind.measurements.retain(|port| port.signal != "pitch_rate");
    let words = made("remus100", &blind, GOOD).unwrap_err();
    let expected = "mine.toml:6: 'controller.pitch.kd' is a gain on pitch_rate, which design.toml does not measure; it \
                    must be left out, or design.toml must have a [[measure]] with signal = \"pitch_rate\"";
    assert_eq!(words, expected);
    // A design that measures the errors alone.
    let words = made("remus100", &Layout::default(), GOOD).unwrap_err();
    assert!(words.contains("pitch, which design.toml does not measure"), "{words}");
    // Depth is tracked, and no loop is given for it.
    let words = made("remus100", &layout("depth"), GOOD).unwrap_err();
    assert!(
        words.contains("'controller.depth' is left out; it must be there: design.toml tracks depth"),
        "{words}"
    );
}

#[test]
fn tables_and_lists_of_the_wrong_size_are_refused() {
    let words = refused("value = 5.0", "table = [[1.4, 5.0], [2.2, 4.0]], degree = 2");
    assert!(
        words.contains("'controller.pitch.kp.table' is 2 points; it must be 3 points or more"),
        "{words}"
    );
    assert!(refused("value = 5.0", "table = [[2.2, 5.0], [1.4, 4.0]]").contains("increasing speeds"));
    assert!(refused("value = 5.0", "value = [1.0, 2.0, 3.0, 4.0]").contains("a list of 4"));
    assert!(refused("value = 5.0", "value = 5.0, table = [[1.4, 5.0]]").contains("left out beside 'value'"));
}

#[test]
fn actuators_that_cannot_carry_out_a_command_are_refused() {
    let with = |allocation: &str| {
        let text = format!("{GOOD}[controller.allocation]\n{allocation}\n");
        made("remus100", &layout("pitch"), &text).unwrap_err()
    };
    let words = with("pitch = { rudder = 1.0 }");
    assert!(
        words.contains("is of 'rudder'; it must be of the vehicle's actuators: propeller, stern_planes"),
        "{words}"
    );
    assert!(
        with("speed = { stern_planes = 1.0 }").contains("must be of"),
        "{}",
        with("speed = { stern_planes = 1.0 }")
    );
    assert!(with("pitch = { propeller = 1.0 }").contains("turns the vehicle in pitch"));
}
