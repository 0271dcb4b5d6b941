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
    let read = |text: &str| Manoeuvre::from_json(text).unwrap_err();
    let [format, steps, ramp, duration, end, time, unknown] = [
        ("format", json!("squid-manoeuvre/2")),
        ("steps", json!({"pitch": "high"})),
        ("ramp_duration", json!(0.0)),
        ("duration", json!(-2.0)),
        ("step_end", json!(1.0)),
        ("step_time", json!("soon")),
        ("speed", json!(1.0)),
    ]
    .map(|(key, value)| {
        let mut file: Value = serde_json::from_str(&manoeuvre().to_json().unwrap()).unwrap();
        file[key] = value;
        read(&file.to_string())
    });
    let empty = read("{}");
    assert!(
        matches!(&format, ManoeuvreError::WrongFormat { found } if found == "squid-manoeuvre/2"),
        "{format}"
    );
    for error in [&steps, &time, &unknown, &empty] {
        assert!(matches!(error, ManoeuvreError::Json(_)), "{error}");
    }
    assert!(matches!(end, ManoeuvreError::StepEndsBeforeItStarts { step_time: 2.0, step_end: 1.0 }), "{end}");
    let (slow, astern) =
        (Manoeuvre { speed_from: 0.0, ..manoeuvre() }, Manoeuvre { speed_to: -1.0, ..manoeuvre() });
    let [slow, astern] = [slow, astern].map(|one| {
        one.check().unwrap();
        one.check_ahead().unwrap_err()
    });
    let [pitch, yaw] = [("pitch", 1.6), ("yaw", 0.1)]
        .map(|(signal, height)| manoeuvre().with_step(signal, height).check_steps(&design()).unwrap_err());
    for (error, at, found) in [
        (&ramp, "ramp_duration", 0.0),
        (&duration, "duration", -2.0),
        (&slow, "speed_from", 0.0),
        (&astern, "speed_to", -1.0),
        (&pitch, "pitch_step", 1.6),
        (&yaw, "yaw_step", 0.1),
    ] {
        let ManoeuvreError::BadNumber { key, value, .. } = error else { panic!("{error}") };
        assert_eq!((key.as_str(), *value), (at, found));
    }
    let all = [format, steps, ramp, duration, end, time, unknown, empty, slow, astern, pitch, yaw];
    insta::assert_snapshot!(all.map(|error| error.to_string()).join("\n"));
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
