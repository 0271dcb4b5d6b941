//! References over time, and the contents of a manoeuvre file.

use crate::example::{design, manoeuvre};
use serde_json::{Value, json};
use squid_scheduled::{Manoeuvre, ManoeuvreError};

#[test]
fn speed_ramps_between_its_ends() {
    let manoeuvre = manoeuvre();
    for (time, speed) in [(-5.0, 0.8), (3.0, 0.8), (8.0, 1.6), (13.0, 2.4), (1e6, 2.4)] {
        assert!((manoeuvre.speed_reference(time) - speed).abs() < 1e-15, "{time}");
    }
    assert_eq!(
        (manoeuvre.speed_reference(0.0), manoeuvre.speed_reference(20.0)),
        (0.8, 2.4),
        "exact at the ends"
    );
}

#[test]
fn step_starts_and_ends_on_time_despite_rounding() {
    let manoeuvre = Manoeuvre { step_time: 0.3, step_end: 0.6, ..manoeuvre() };
    let height = manoeuvre.step("pitch");
    let at = |tick: f64| manoeuvre.above_trim(tick * 0.02, "pitch");
    assert_eq!([14.0, 15.0, 29.0, 30.0].map(at), [0.0, height, height, 0.0]);
    assert_eq!(manoeuvre.above_trim(0.3f64.next_down(), "pitch"), height);
    assert_eq!(manoeuvre.above_trim(0.6f64.next_down(), "pitch"), 0.0);
}

#[test]
fn manoeuvre_file_round_trips() {
    let manoeuvre = manoeuvre().with_step("pitch", 0.1 + 0.2);
    assert_eq!(Manoeuvre::from_json(&manoeuvre.to_json().unwrap()).unwrap(), manoeuvre);
    let deeper = manoeuvre.with_step("depth", -1.5);
    assert_eq!((deeper.step("depth"), deeper.step("pitch")), (-1.5, 0.0));
    assert_eq!(Manoeuvre::from_json(&deeper.to_json().unwrap()).unwrap(), deeper);
}

#[test]
fn message_names_the_wrong_key() {
    for (key, value, expected) in [
        ("format", json!("squid-manoeuvre/2"), "format is 'squid-manoeuvre/2', but only 'squid-manoeuvre/1'"),
        ("steps", json!({"pitch": "high"}), "invalid type: string \"high\", expected f64"),
        ("ramp_duration", json!(0.0), "ramp_duration is 0, but must be finite and above 0"),
        ("duration", json!(-2.0), "duration is -2, but must be finite and above 0"),
        ("step_end", json!(1.0), "step_end is 1 s, before step_time at 2 s"),
        ("step_time", json!("soon"), "invalid type: string \"soon\", expected f64"),
        ("speed", json!(1.0), "unknown field `speed`"),
    ] {
        let mut file: Value = serde_json::from_str(&manoeuvre().to_json().unwrap()).unwrap();
        file[key] = value;
        let message = Manoeuvre::from_json(&file.to_string()).unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    }
    for (one, expected) in [
        (Manoeuvre { speed_from: 0.0, ..manoeuvre() }, "speed_from is 0, but must be finite and above 0"),
        (Manoeuvre { speed_to: -1.0, ..manoeuvre() }, "speed_to is -1, but must be finite and above 0"),
    ] {
        one.check().unwrap();
        assert_eq!(one.check_ahead().unwrap_err().to_string(), expected);
    }
    for (signal, height, expected) in [
        (
            "pitch",
            1.6,
            "pitch_step is 1.6, but must be above -1.5707963267948966 and below 1.5707963267948966",
        ),
        ("yaw", 0.1, "yaw_step is 0.1, but must be 0: the autopilot has no reference of it"),
    ] {
        let found = manoeuvre().with_step(signal, height).check_steps(&design());
        assert_eq!(found.unwrap_err().to_string(), expected);
    }
    let message = Manoeuvre::from_json("{}").unwrap_err().to_string();
    assert!(message.contains("missing field `format`"), "{message}");
}

#[test]
fn rejects_non_finite_numbers() {
    for (manoeuvre, expected) in [
        (Manoeuvre { step_end: f64::INFINITY, ..manoeuvre() }, "step_end"),
        (Manoeuvre { step_time: f64::NAN, ..manoeuvre() }, "step_time"),
        (Manoeuvre { ramp_start: f64::NAN, ..manoeuvre() }, "ramp_start"),
        (Manoeuvre { duration: f64::INFINITY, ..manoeuvre() }, "duration"),
    ] {
        let error = manoeuvre.to_json().unwrap_err();
        assert!(matches!(&error, ManoeuvreError::BadNumber { key, .. } if key == expected), "{error}");
    }
}
