//! Design file: every mistake is reported with its line, its key, the value found and the allowed ones.

use squid_auv::Pitch;
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

/// Returns the message for the design of Squid with texts replaced, and the lines of the replacements.
fn mistakes_after(edits: &[(&str, &str)]) -> (Vec<String>, Vec<usize>) {
    let (original, mut text) = (squid(), squid());
    let mut lines = Vec::new();
    for (old, new) in edits {
        let old = &present(&original, old);
        let (before, _) = original.split_once(old).expect(old);
        lines.push(before.matches('\n').count() + 1);
        text = text.replacen(old, new, 1);
    }
    let message = DesignFile::parse(&text, "design.toml", "design").unwrap_err().to_string();
    (message.lines().map(str::to_owned).collect(), lines)
}

/// Asserts that one replaced text gives one mistake, on its line or a given number of lines below.
fn assert_mistake(old: &str, new: &str, below: usize, expected: &str) {
    let (found, lines) = mistakes_after(&[(old, new)]);
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].starts_with(&format!("design.toml:{}: {expected}", lines[0] + below)), "{found:?}");
}

#[test]
fn reports_wrong_types_in_one_sentence() {
    for (old, new, expected) in [
        (
            "speeds = 26",
            "speeds = 26.5",
            "'model.speeds' is the number 26.5; it must be a whole number, more than",
        ),
        ("order = 2", "order = -2", "'model.order' is the number -2; it must be a whole number, from 1 to 5"),
        (
            "depth = 50.0",
            "depth = \"50 m\"",
            "'model.depth' is the text \"50 m\"; it must be a number, 0 or more (m)",
        ),
        (
            "back_off = *",
            "back_off = true",
            "'synthesis.back_off' is true; it must be a number, from 0.001 to 1",
        ),
        (
            "weight = *",
            "weight = { value = 1 }",
            "'control.weight' is a table; it must be a number, from 1e-6 to 1e6",
        ),
        (
            "lags = true",
            "actuators = { lower = 0 }\nlags = true",
            "'control.actuators.lower' is 0; it must be from 0.01 to 100",
        ),
        ("weight = *", "weight = [0.5]", "'control.weight' is a list; it must be a number, from 1e-6 to 1e6"),
        (
            "weight = *",
            "weight = 2026-01-01",
            "'control.weight' is the date or time 2026-01-01; it must be a number",
        ),
        (
            "disturbance = *",
            "disturbance = 54.3",
            "'control.disturbance' is 54.3; it must be from 0 to 10; 1 is the larger of |min| and |max| of each",
        ),
        ("unit = \"m/s\"", "unit = 7", "'track.unit' is the number 7; it must be \"m/s\""),
        (
            "output = \"pitch\"",
            "output = \"picth\"",
            "'track.output' is \"picth\" (did you mean \"pitch\"?); it must be \"pitch\" or \"speed\"",
        ),
        (
            "back_off = *",
            "back_off = 0.1\nrate = -0.1",
            "'synthesis.rate' is -0.1; it must be from 1e-6 to 1e3 (m/s^2)",
        ),
        ("back_off = *", "back_off = 1e17", "'synthesis.back_off' is 1e17; it must be from 0.001 to 1"),
        ("depth = 50.0", "depth = 1e300", "'model.depth' is 1e300; it must be at most 1e18 in size"),
        ("depth = 50.0", "depth = 50.0\ndepth = 50.0", "'depth' stands here a second time"),
    ] {
        assert_mistake(old, new, usize::from(new.contains("\ndepth") || new.contains("\nrate")), expected);
    }
}

#[test]
fn checks_measurements() {
    for (old, new, expected) in [
        (
            "signal = \"pitch_rate\"",
            "signal = \"pitchrate\"",
            "'measure.signal' is \"pitchrate\" (did you mean",
        ),
        ("signal = \"pitch_rate\"", "signal = \"pitch\"", "'measure.signal' is \"pitch\" a second time"),
        ("unit = \"deg/s\"", "unit = \"deg\"", "'measure.unit' is \"deg\""),
        ("noise = *", "noise = 0.0", "'measure.noise' is 0; it must be from 1e-9 to 1e6; without noise"),
        ("rise = *", "rise = 0.5", "'measure.rise' is 0.5; it must be from 1, no less than"),
        ("damping = *", "damping = 0.0", "'track.damping' is 0; it must be from 0.3 to 3"),
        ("follow = *", "follow = 0.5", "'track.follow' is 0.5; it must be from 1, as much as fast ones"),
        ("lags = true", "lags = 1", "'control.lags' is the number 1; it must be true or false"),
        (
            "sample_time = 0.02",
            "delay = 0.03\nsample_time = 0.02",
            "'autopilot.delay' is 0.03; it must be a multiple of the sample time, from 0 to 10 of them (s)",
        ),
        ("sample_time = 0.02", "delay = 0.22\nsample_time = 0.02", "'autopilot.delay' is 0.22; it must be"),
    ] {
        assert_mistake(old, new, 0, expected);
    }
    let (half, _) = mistakes_after(&[("corner = *", "")]);
    assert!(half[0].contains("missing key 'track.corner'"), "{half:?}");
    let (half, _) = mistakes_after(&[("follow = *", "")]);
    assert!(half[0].contains("missing key 'track.follow'"), "{half:?}");
    let (missing, _) = mistakes_after(&[("frequency = 1.2\n", "")]);
    assert!(missing[0].contains("missing key 'track.frequency'"), "{missing:?}");
    let (second_order, _) = mistakes_after(&[("frequency = 1.2\n", "frequency = 1.2\ndamping = 0.7\n")]);
    assert!(second_order[0].contains("left out for the speed"), "{second_order:?}");
    // The controller measures the errors if there is no [[measure]], and then has no reference models.
    let text = squid();
    let (start, rest) = text.split_once("[[measure]]").unwrap();
    let (_, end) = rest.split_once("[control]").unwrap();
    let errors = format!("{start}[control]{end}");
    let message = DesignFile::parse(&errors, "design.toml", "design").unwrap_err().to_string();
    assert!(message.contains("unknown key 'track.frequency'"), "{message}");
}

/// Each mistake has one line, in the order of the file; a misspelt key is not reported as missing as well.
#[test]
fn reports_all_mistakes_at_once() {
    let (found, lines) = mistakes_after(&[
        ("sample_time =", "sampletime ="),
        ("speed_min =", "speedmin ="),
        ("peak = *", "peak = \"two\""),
        ("depth = 50.0", "depth = -50.0"),
        ("ramp_start = 5.0", "ramp_start = nan"),
    ]);
    let mut lines = lines;
    lines.sort_unstable();
    assert_eq!(found.len(), lines.len(), "{found:?}");
    for (expected, line) in found.iter().zip(lines) {
        assert!(expected.starts_with(&format!("design.toml:{line}: ")), "{expected}");
    }
    assert!(found[0].contains("unknown key 'model.speedmin' (did you mean 'speed_min'?)"), "{found:?}");
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
    for (lines, expected) in [
        (
            "pitch = \"lvel\"",
            "'trim.pitch' is \"lvel\" (did you mean \"level\"?); it must be \"level\" or \"free\"",
        ),
        ("pitch = 3.0", "'trim.pitch' is the number 3.0; it must be \"level\" or \"free\""),
        (
            "pitch = { angle = 61.0, unit = \"deg\" }",
            "'trim.pitch.angle' is 61; it must be at most 60 deg in size",
        ),
        (
            "pitch = { angle = -1.1, unit = \"rad\" }",
            "'trim.pitch.angle' is -1.1; it must be at most 60 deg in size",
        ),
        ("pitch = { angle = 2.0, unit = \"m\" }", "'trim.pitch.unit' is \"m\"; it must be"),
        ("pitch = { angle = 2.0 }", "missing key 'trim.pitch.unit'"),
        ("pitch = { unit = \"deg\" }", "missing key 'trim.pitch.angle'"),
        ("pitch = { angle = 2.0, unit = \"deg\", x = 1 }", "unknown key 'trim.pitch.x'"),
    ] {
        let message = read(lines).unwrap_err().to_string();
        assert!(message.starts_with(&format!("design.toml:{line}: {expected}")), "{message}");
    }
    let message = read("angle = 2.0").unwrap_err().to_string();
    assert!(
        message.contains("missing key 'trim.pitch'") && message.contains("unknown key 'trim.angle'"),
        "{message}"
    );
}

#[test]
fn manoeuvre_is_within_design_limits() {
    for (old, new, expected) in [
        (
            "speed_to = 2.9",
            "speed_to = 3.1",
            "'manoeuvre.speed_to' is 3.1; it must be from 0.5 to 3 (m/s), the range",
        ),
        (
            "speed_from = 0.6",
            "speed_from = 0.4",
            "'manoeuvre.speed_from' is 0.4; it must be from 0.5 to 3 (m/s)",
        ),
        (
            "pitch_step = 10.0",
            "pitch_step = -10.1",
            "'manoeuvre.pitch_step' is -10.1; it must be other than 0 and at most 10 deg",
        ),
        (
            "step_time = 10.0",
            "step_time = 60.0",
            "'manoeuvre.step_time' is 60; it must be 0 or more, and before the end",
        ),
        (
            "duration = 60.0",
            "duration = 20001",
            "'manoeuvre.duration' is 20001; it must be above 0 and at most 20000 (s)",
        ),
    ] {
        assert_mistake(old, new, 0, expected);
    }
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
    for (keys, expected) in [
        ("height = 2.0\nperiod = 3.0\nheading = 180.0", "'sea.period' is 3 s; it must be at least 4.38 s"),
        (
            "height = 0.2\nperiod = 3.0\nheading = 0.0",
            "'sea.heading' is 0; it must be such that the vehicle is not carried along by the waves",
        ),
        (
            "height = 0.2\nperiod = 3.0\nheading = 0.0\nweight = 0.0",
            "'sea.weight' is 0; it must be from 0.001",
        ),
        (
            "height = 5.0\nperiod = 9.0\nheading = 180.0",
            "'sea.depth' is 2; it must be at least half the significant height (m)",
        ),
    ] {
        let found = parsed(&sea(keys)).unwrap_err().to_string();
        assert!(found.starts_with("design.toml:") && found.contains(expected), "{found}");
        assert_eq!(found.lines().count(), 1, "{found}");
    }
    let sound = sea("height = 0.2\nperiod = 3.0\nheading = 180.0");
    assert!(parsed(&sound).unwrap().sea.is_some());
    let vehicle = squid_base::files::read(
        &Path::new(env!("CARGO_MANIFEST_DIR")).join("../../vehicles/squid/vehicle.toml"),
    )
    .unwrap();
    let (before, after) = vehicle.split_once("\n[geometry]\n").unwrap();
    let (_, after) = after.split_once("\n[").unwrap();
    let found = Inputs::parse(&format!("{before}\n[{after}"), &sound).unwrap_err().to_string();
    assert!(found.starts_with("design.toml: [sea] needs the size of the hull"), "{found}");
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
    let found = Inputs::parse(&vehicle, &text).unwrap_err().to_string();
    let expected = format!(
        "design.toml:{line}: 'control.actuators.lover' is no actuator of this axis; it must be named lower, \
         upper_port, upper_starboard"
    );
    assert_eq!(found, expected);
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
    for (old, new, at, expected) in [
        ("[axis.synthesis]\nback_off = 0.04\n", "", heading, "missing key 'synthesis': back_off"),
        ("back_off = 0.04", "back_off = 4.0", line("back_off = 0.04"), "'synthesis.back_off' is 4; it must"),
        ("order = 2", "order = 7", line("order = 2"), "'model.order' is the number 7; it must be"),
        (
            "back_off = 0.04",
            "back_off = 0.04\n[axis.model]\norder = 3",
            line("back_off = 0.04") + 2,
            "'model.order' stands outside [[axis]], too, where it holds for each; it may stand in one of the two",
        ),
    ] {
        let found = read(&text.replace(old, new)).unwrap_err().to_string();
        assert!(
            found.starts_with(&format!("design.toml:{at}: {expected}")) && !found.contains('\n'),
            "{found}"
        );
    }
    let alone = DesignFile::parse(&text, "design.toml", "mine").unwrap_err().to_string();
    assert!(alone.starts_with(&format!("design.toml:{heading}: 'axis' is a second one")), "{alone}");
}
