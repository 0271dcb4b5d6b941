//! Rate limit of an actuator: its closed form, its invariants, and its entry in a file.

use crate::common::{json_message, message, remus100, squid};
use proptest::prelude::*;
use squid_auv::{Actuator, Plant, Speed, Vehicle, trim};

const REMUS: &str = include_str!("../../../../vehicles/remus100/vehicle.toml");

/// Returns a plane with limits of +-0.25 rad and a lag of 0.1 s.
fn plane(rate: Option<f64>) -> Actuator {
    let actuator = remus100().actuators[1].clone();
    Actuator { min: -0.25, max: 0.25, lag: 0.1, rate, ..actuator }
}

/// Integrates `T' = clamp((sat(c + s t) - T)/tau, -r, r)` by the classical fourth-order Runge-Kutta method.
fn integrated(actuator: &Actuator, elapsed: f64, start: f64, command: f64, slope: f64) -> f64 {
    let rate = actuator.rate.unwrap_or(f64::INFINITY);
    let rate_at = |time: f64, output: f64| {
        let target = (command + slope * time).clamp(actuator.min, actuator.max);
        ((target - output) / actuator.lag).clamp(-rate, rate)
    };
    let (mut output, steps) = (start, 20_000);
    let h = elapsed / f64::from(steps);
    for step in 0..steps {
        let time = f64::from(step) * h;
        let k1 = rate_at(time, output);
        let k2 = rate_at(time + 0.5 * h, output + 0.5 * h * k1);
        let k3 = rate_at(time + 0.5 * h, output + 0.5 * h * k2);
        let k4 = rate_at(time + h, output + h * k3);
        output += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    }
    output
}

/// A step runs at the rate limit until the error is r tau, and then decays with the lag: computed by hand.
#[test]
fn step_matches_hand_computation() {
    let plane = plane(Some(0.5));
    // Path from -0.2 to 0.2 rad: 0.35 rad at 0.5 rad/s, then 0.05 rad left.
    assert!((plane.output_after(0.4, -0.2, 0.2) - 0.0).abs() < 1e-15);
    assert!((plane.output_after(0.7, -0.2, 0.2) - 0.15).abs() < 1e-15);
    assert!((plane.output_after(0.8, -0.2, 0.2) - (0.2 - 0.05 * (-1.0_f64).exp())).abs() < 1e-15);
    assert_eq!(plane.output_rate(-0.2, 0.2), 0.5);
    assert_eq!(plane.output_rate(0.2, -9.0), -0.5);
    assert!((plane.output_rate(0.0_f64, 0.02) - 0.2).abs() < 1e-15);
}

/// Steps and ramps slower and faster than the rate limit, starting at and below it, through both limits.
#[test]
fn closed_form_matches_integration() {
    let plane = plane(Some(0.5));
    for start in [-0.2, 0.0, 0.24] {
        for command in [-0.6, -0.1, 0.02, 0.3] {
            for slope in [0.0, 0.3, -0.3, 0.5, 2.0, -2.0, -0.8] {
                for elapsed in [0.02, 0.3, 1.5] {
                    let found = plane.output_along(elapsed, start, command, slope);
                    let expected = integrated(&plane, elapsed, start, command, slope);
                    let label = format!("{start} {command} {slope} {elapsed}");
                    assert!((found - expected).abs() < 1e-6, "{label}: {found} and {expected}");
                }
            }
        }
    }
}

proptest! {
    /// The rate limit holds, and an additional division of the interval changes nothing.
    #[test]
    fn output_keeps_its_rate_limit(
        (start, command, slope) in (-0.25..0.25, -1.0..1.0, -3.0..3.0),
        (rate, elapsed, part) in (0.01..2.0, 0.0..3.0, 0.0..1.0),
    ) {
        let plane = plane(Some(rate));
        let undivided = plane.output_along(elapsed, start, command, slope);
        prop_assert!((undivided - start).abs() <= rate * elapsed + 1e-15);
        prop_assert!((plane.min..=plane.max).contains(&undivided));
        let first_part = part * elapsed;
        let first = plane.output_along(first_part, start, command, slope);
        let second = plane.output_along(elapsed - first_part, first, command + slope * first_part, slope);
        prop_assert!((second - undivided).abs() < 1e-12, "{second} and {undivided}");
    }

    /// While the error stays below r tau, the lag acts alone, to the bit.
    #[test]
    fn slow_commands_see_only_the_lag(
        (start, command, elapsed) in (-0.25..0.25, -1.0..1.0, 0.0..3.0),
        (rate, slope) in (5.1..9.0, -5.0..5.0),
    ) {
        let (limited, plain) = (plane(Some(rate)), plane(None));
        let both = |of: &dyn Fn(&Actuator) -> f64| (of(&limited), of(&plain));
        let (found, expected) = both(&|one| one.output_along(elapsed, start, command, slope));
        prop_assert_eq!(found.to_bits(), expected.to_bits());
        let (found, expected) = both(&|one| one.output_rate(start, command));
        prop_assert_eq!(found.to_bits(), expected.to_bits());
    }

    /// A flight barely depends on its division, across the corners of the rate limit.
    #[test]
    fn dividing_a_flight_changes_nothing(first_part in 0.0..4.0, command in -0.25..0.25, rate in 0.05..1.0) {
        let mut vehicle = remus100();
        vehicle.actuators[1].rate = Some(rate);
        let mut undivided = Plant::new(&vehicle).unwrap();
        undivided.start(0.0, &trim(&vehicle, Speed::Path(1.8), 30.0).unwrap()).unwrap();
        undivided.set_command(1, command).unwrap();
        let mut divided = undivided.clone();
        undivided.advance(4.0).unwrap();
        divided.advance(first_part).unwrap();
        divided.advance(4.0).unwrap();
        let (a, b) = (undivided.state(), divided.state());
        prop_assert!((a.motion.theta - b.motion.theta).abs() < 1e-8);
        prop_assert!((a.depth - b.depth).abs() < 1e-8);
    }
}

/// Returns the file of REMUS 100 with a line added to the table of its planes.
fn with(line: &str) -> String {
    let head = "name = \"stern_planes\"\n";
    assert_eq!(REMUS.matches(head).count(), 1);
    REMUS.replace(head, &format!("{head}{line}\n"))
}

#[test]
fn reads_the_rate_limit_in_radians_or_degrees() {
    let read = |line: &str| Vehicle::parse(&with(line), "v.toml").unwrap();
    let vehicle = read(r#"rate = { value = 60.0, unit = "deg/s", source = "a test" }"#);
    assert_eq!(vehicle.actuators[1].rate, Some(60.0_f64.to_radians()));
    assert_eq!((vehicle.actuators[0].rate, remus100().actuators[1].rate), (None, None));
    assert_eq!(vehicle.sources["stern_planes.rate"], "a test");
    let other = read(r#"rate = { value = 1.5, unit = "rad/s", source = "a test" }"#);
    assert_eq!(other.actuators[1].rate, Some(1.5));
    let mut thrust = squid();
    thrust.actuators[0].rate = Some(40.0);
    for mut vehicle in [vehicle, thrust] {
        vehicle.published_linear_model = None;
        let json = vehicle.to_json().unwrap();
        assert_eq!(Vehicle::from_json(&json, "v").unwrap(), vehicle);
        assert!(json.contains("\"rate\": "));
    }
    assert!(!squid().to_json().unwrap().contains("rate\": "));
}

#[test]
fn rejects_invalid_rate_limits() {
    let text = with("rate = { value = 60.0, unit = \"deg/s\", source = \"s\" }");
    let limit = "value = 60.0, unit = \"deg/s\"";
    let line = |marker: &str| text.lines().position(|line| line.contains(marker)).unwrap() + 1;
    let at = line(limit);
    let mut messages = vec![];
    for (from, to, line, key) in [
        (limit, "value = 0.0, unit = \"rad/s\"", at, "rate"),
        (limit, "value = -60, unit = \"deg/s\"", at, "rate"),
        (limit, "value = nan, unit = \"deg/s\"", at, "rate"),
        (limit, "value = 60, unit = \"deg\"", at, "rate"),
        (limit, "value = 60, unit = \"N/s\"", at, "rate"),
        ("lag = { value = 0.1,", "lag = { value = 0.0,", line("lag = { value = 0.1,"), "lag"),
    ] {
        let error = Vehicle::parse(&text.replace(from, to), "v.toml").unwrap_err();
        messages.push(message(to, &error, (line, &format!("control_surface.{key}"))));
    }
    let mut json: serde_json::Value = serde_json::from_str(&remus100().to_json().unwrap()).unwrap();
    for (rate, lag, key) in [(0.0, 0.1, "stern_planes.rate"), (1.0, 0.0, "stern_planes.lag")] {
        let numbers = &mut json["actuators"][1]["numbers"];
        (numbers["rate"], numbers["lag"]) = (rate.into(), lag.into());
        let error = Vehicle::from_json(&json.to_string(), "v.json").unwrap_err();
        messages.push(json_message(&format!("JSON with rate {rate}, lag {lag}"), &error, key));
    }
    insta::assert_snapshot!(messages.join("\n\n"));
}
