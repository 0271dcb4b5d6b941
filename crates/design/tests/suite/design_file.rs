//! Design file: every mistake is reported with its line and key; snapshots hold the messages.

use crate::designs::message;
use squid_auv::Pitch;
use squid_auv::toml_file::{FileError, FileProblem};
use squid_design::error::InputError;
use squid_design::inputs::Inputs;
use squid_design::inputs::design_file::DesignFile;
use std::path::Path;

fn squid() -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../vehicles/squid/design.toml");
    squid_base::files::read(&path).unwrap()
}

/// Text of the file, where `*` is any number, because the numbers of a tuned design change.
fn present(file: &str, sought: &str) -> String {
    let Some((start, end)) = sought.split_once('*') else { return sought.into() };
    let (_, rest) = file.split_once(&format!("\n{start}")).expect(sought);
    let number = rest.split_whitespace().next().unwrap();
    format!("{start}{number}{end}")
}

/// Returns the error in the design of Squid with texts replaced, and the lines of the replacements.
fn rejected(edits: &[(&str, &str)]) -> (FileError, Vec<usize>) {
    let (original, mut text) = (squid(), squid());
    let mut lines = Vec::new();
    for (old, new) in edits {
        let old = &present(&original, old);
        let (before, _) = original.split_once(old).expect(old);
        lines.push(before.matches('\n').count() + 1);
        text = text.replacen(old, new, 1);
    }
    (DesignFile::parse(&text, "design.toml", "design").unwrap_err(), lines)
}

/// Checks that each replaced text is a mistake with this key, on the line of the text; returns the messages.
fn messages(cases: &[(&str, &str, &str)]) -> String {
    let one = |&(old, new, key): &(&str, &str, &str)| {
        let (error, lines) = rejected(&[(old, new)]);
        message(new, &error, (lines[0], key))
    };
    cases.iter().map(one).collect::<Vec<_>>().join("\n\n")
}

#[test]
fn rejects_wrong_types_and_numbers() {
    insta::assert_snapshot!(messages(&[
        ("speeds = 26", "speeds = 26.5", "model.speeds"),
        ("order = 2", "order = -2", "model.order"),
        ("depth = 50.0", "depth = \"50 m\"", "model.depth"),
        ("back_off = *", "back_off = true", "synthesis.back_off"),
        ("weight = *", "weight = { value = 1 }", "control.weight"),
        ("lags = true", "actuators = { lower = 0 }\nlags = true", "control.actuators.lower"),
        ("weight = *", "weight = [0.5]", "control.weight"),
        ("weight = *", "weight = 2026-01-01", "control.weight"),
        ("disturbance = *", "disturbance = 54.3", "control.disturbance"),
        ("unit = \"m/s\"", "unit = 7", "track.unit"),
        ("output = \"pitch\"", "output = \"picth\"", "track.output"),
        ("back_off = *", "rate = -0.1\nback_off = 0.1", "synthesis.rate"),
        ("back_off = *", "back_off = 1e17", "synthesis.back_off"),
        ("depth = 50.0", "depth = 1e300", "model.depth"),
    ]));
    let (twice, lines) = rejected(&[("depth = 50.0", "depth = 50.0\ndepth = 50.0")]);
    message("", &twice, (lines[0] + 1, "depth"));
    assert!(matches!(twice.mistakes[0].problem, FileProblem::DuplicateKey { .. }));
}

#[test]
fn checks_measurements() {
    insta::assert_snapshot!(messages(&[
        ("signal = \"pitch_rate\"", "signal = \"pitchrate\"", "measure.signal"),
        ("signal = \"pitch_rate\"", "signal = \"pitch\"", "measure.signal"),
        ("unit = \"deg/s\"", "unit = \"deg\"", "measure.unit"),
        ("noise = *", "noise = 0.0", "measure.noise"),
        ("rise = *", "rise = 0.5", "measure.rise"),
        ("damping = *", "damping = 0.0", "track.damping"),
        ("follow = *", "follow = 0.5", "track.follow"),
        ("lags = true", "lags = 1", "control.lags"),
        ("sample_time = 0.02", "delay = 0.03\nsample_time = 0.02", "autopilot.delay"),
        ("sample_time = 0.02", "delay = 0.22\nsample_time = 0.02", "autopilot.delay"),
        ("frequency = 1.2\n", "damping = 0.7\nfrequency = 1.2\n", "track.damping"),
    ]));
    for (without, key) in [
        ("corner = *", "track.corner"),
        ("follow = *", "track.follow"),
        ("frequency = 1.2\n", "track.frequency"),
    ] {
        let problem = &rejected(&[(without, "")]).0.mistakes[0].problem;
        assert!(matches!(problem, FileProblem::MissingKey { key: found, .. } if found == key), "{problem}");
    }
    // The controller measures the errors if there is no [[measure]], and then has no reference models.
    let text = squid();
    let (start, rest) = text.split_once("[[measure]]").unwrap();
    let (_, end) = rest.split_once("[control]").unwrap();
    let error = DesignFile::parse(&format!("{start}[control]{end}"), "design.toml", "design").unwrap_err();
    let unknown =
        |problem: &_| matches!(problem, FileProblem::UnknownKey { key, .. } if key == "track.frequency");
    assert!(error.mistakes.iter().any(|one| unknown(&one.problem)), "{error}");
}

/// Each mistake has one line, in the order of the file; a misspelt key is not reported as missing as well.
#[test]
fn reports_all_mistakes_at_once() {
    let (found, mut lines) = rejected(&[
        ("sample_time =", "sampletime ="),
        ("speed_min =", "speedmin ="),
        ("peak = *", "peak = \"two\""),
        ("depth = 50.0", "depth = -50.0"),
        ("ramp_start = 5.0", "ramp_start = nan"),
    ]);
    lines.sort_unstable();
    assert_eq!(found.mistakes.iter().map(|one| one.line).collect::<Vec<_>>(), lines, "{found}");
    let problem = &found.mistakes[0].problem;
    assert!(
        matches!(problem, FileProblem::UnknownKey { key, suggestion: Some(meant), .. }
            if key == "model.speedmin" && meant == "speed_min"),
        "{problem}"
    );
}

#[test]
fn trim_pitch_is_keyword_or_angle() {
    let with = |lines: &str| squid().replacen("\n[control]", &format!("\n[trim]\n{lines}\n[control]"), 1);
    let read = |lines: &str| DesignFile::parse(&with(lines), "design.toml", "design");
    let line = squid().split_once("\n[control]").unwrap().0.matches('\n').count() + 3;
    for (lines, pitch) in [
        ("pitch = \"level\"", Pitch::Held(0.0)),
        ("pitch = \"free\"", Pitch::Free),
        ("pitch = { angle = -60.0, unit = \"deg\" }", Pitch::Held(-60f64.to_radians())),
        ("pitch = { angle = 0.5, unit = \"rad\" }", Pitch::Held(0.5)),
    ] {
        assert_eq!(read(lines).unwrap().pitch_asked, Some(pitch), "{lines}");
    }
    let messages = [
        ("pitch = \"lvel\"", "pitch"),
        ("pitch = 3.0", "pitch"),
        ("pitch = { angle = 61.0, unit = \"deg\" }", "pitch.angle"),
        ("pitch = { angle = -1.1, unit = \"rad\" }", "pitch.angle"),
        ("pitch = { angle = 2.0, unit = \"m\" }", "pitch.unit"),
        ("pitch = { angle = 2.0 }", "pitch.unit"),
        ("pitch = { unit = \"deg\" }", "pitch.angle"),
        ("pitch = { angle = 2.0, unit = \"deg\", x = 1 }", "pitch.x"),
    ]
    .map(|(lines, key)| message(lines, &read(lines).unwrap_err(), (line, &format!("trim.{key}"))));
    insta::assert_snapshot!(messages.join("\n\n"));
    let error = read("angle = 2.0").unwrap_err();
    let keys: Vec<_> = error.mistakes.iter().map(|one| one.problem.key().unwrap()).collect();
    assert_eq!(keys, ["trim.pitch", "trim.angle"], "{error}");
}

#[test]
fn manoeuvre_is_within_design_limits() {
    insta::assert_snapshot!(messages(&[
        ("speed_to = 2.9", "speed_to = 3.1", "manoeuvre.speed_to"),
        ("speed_from = 0.6", "speed_from = 0.4", "manoeuvre.speed_from"),
        ("pitch_step = 10.0", "pitch_step = -10.1", "manoeuvre.pitch_step"),
        ("step_time = 10.0", "step_time = 60.0", "manoeuvre.step_time"),
        ("duration = 60.0", "duration = 20001", "manoeuvre.duration"),
    ]));
    let at_the_limits = squid().replacen("speed_to = 2.9", "speed_to = 3", 1).replacen(
        "pitch_step = 10.0",
        "pitch_step = -10",
        1,
    );
    let design = DesignFile::parse(&at_the_limits, "design.toml", "design").unwrap();
    assert_eq!((design.manoeuvre.speed_to, design.manoeuvre.step("pitch")), (3.0, -10f64.to_radians()));
}

/// Waves that break, that carry the vehicle along, or that act on a hull without dimensions.
#[test]
fn rejects_impossible_seas() {
    let sea = |keys: &str| {
        let section = "[sea]\ndepth = 2.0\nspectrum = \"jonswap\"\ngamma = 3.3\n";
        squid().replace("\n[synthesis]\n", &format!("\n{section}{keys}\n[synthesis]\n"))
    };
    let parsed = |text: &str| DesignFile::parse(text, "design.toml", "design");
    let first = squid().split_once("\n[synthesis]\n").unwrap().0.matches('\n').count() + 3;
    let messages = [
        ("height = 2.0\nperiod = 3.0\nheading = 180.0", 4, "sea.period"),
        ("height = 0.2\nperiod = 3.0\nheading = 0.0", 5, "sea.heading"),
        ("height = 0.2\nperiod = 3.0\nheading = 0.0\nweight = 0.0", 6, "sea.weight"),
        ("height = 5.0\nperiod = 9.0\nheading = 180.0", 0, "sea.depth"),
    ]
    .map(|(keys, below, key)| message(keys, &parsed(&sea(keys)).unwrap_err(), (first + below, key)));
    insta::assert_snapshot!(messages.join("\n\n"));
    let sound = sea("height = 0.2\nperiod = 3.0\nheading = 180.0");
    assert!(parsed(&sound).unwrap().sea.is_some());
    let vehicle = squid_base::files::read(
        &Path::new(env!("CARGO_MANIFEST_DIR")).join("../../vehicles/squid/vehicle.toml"),
    )
    .unwrap();
    let (before, after) = vehicle.split_once("\n[geometry]\n").unwrap();
    let (_, after) = after.split_once("\n[").unwrap();
    let error = Inputs::parse(&format!("{before}\n[{after}"), &sound).unwrap_err();
    assert!(matches!(error, InputError::NoGeometry { .. }), "{error}");
}

#[test]
fn relative_weight_names_actuator_of_vehicle() {
    let vehicle = squid_base::files::read(
        &Path::new(env!("CARGO_MANIFEST_DIR")).join("../../vehicles/squid/vehicle.toml"),
    )
    .unwrap();
    let with = |table: &str| squid().replacen("\n[synthesis]", &format!("\n{table}\n\n[synthesis]"), 1);
    let inputs = Inputs::parse(&vehicle, &with("[control.actuators]\nlower = 3.0")).unwrap();
    let all = inputs.design.control_weight;
    assert_eq!(inputs.design.weight_on("lower").low, 3.0 * all.low);
    assert_eq!(inputs.design.weight_on("upper_port"), all);
    let text = with("[control.actuators]\nlover = 3.0");
    let line = text.lines().position(|line| line == "lover = 3.0").unwrap() + 1;
    let error = Inputs::parse(&vehicle, &text).unwrap_err();
    let InputError::File(error) = error else { panic!("{error}") };
    insta::assert_snapshot!(message("lover", &error, (line, "control.actuators.lover")));
}

/// A mistake in an axis is reported on its line, a missing key on that of its `[[axis]]`, and a mistake outside of them
/// once. An axis has the keys outside of the axes, its index and its name.
#[test]
fn axes_share_keys_outside_them() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../vehicles/remus100/design.toml");
    let text = squid_base::files::read(&path).unwrap();
    let read = |text: &str| DesignFile::parse_each(text, "design.toml", "mine");
    let axes = read(&text).unwrap();
    let names: Vec<_> = axes.iter().map(|axis| (axis.axis, axis.name.as_str(), axis.source())).collect();
    let source = |axis: &str| format!("{axis} of mine.toml");
    assert_eq!(names, [(Some(0), "depth", source("depth")), (Some(1), "heading", source("heading"))]);
    assert!(axes.iter().all(|axis| axis.sample_time == 0.02 && axis.manoeuvre.duration == 100.0));
    assert_eq!([axes[0].back_off, axes[1].back_off], [0.1, 0.04]);
    assert_eq!(
        axes[1].parse_again(&text.replace("back_off = 0.04", "back_off = 0.05")).unwrap().back_off,
        0.05
    );

    let line = |sought: &str| text[..text.rfind(sought).unwrap()].matches('\n').count() + 1;
    let heading = line("[[axis]]\n");
    let messages = [
        ("[axis.synthesis]\nback_off = 0.04\n", "", heading, "synthesis"),
        ("back_off = 0.04", "back_off = 4.0", line("back_off = 0.04"), "synthesis.back_off"),
        ("order = 2", "order = 7", line("order = 2"), "model.order"),
        (
            "back_off = 0.04",
            "back_off = 0.04\n[axis.model]\norder = 3",
            line("back_off = 0.04") + 2,
            "model.order",
        ),
    ]
    .map(|(old, new, at, key)| message(new, &read(&text.replace(old, new)).unwrap_err(), (at, key)));
    let alone = DesignFile::parse(&text, "design.toml", "mine").unwrap_err();
    let alone = message("one axis alone", &alone, (heading, "axis"));
    insta::assert_snapshot!(format!("{}\n\n{alone}", messages.join("\n\n")));
}
