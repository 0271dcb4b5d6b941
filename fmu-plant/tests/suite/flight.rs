//! Simulations of the plant as an FMU without the C interface: start in trim, inputs, fidelity, warnings, refusals.

use crate::common::flight::masked;
use crate::common::{DEPTH, Flight, prepare, remus100, squid, start, vehicle};
use squid_auv::{CoefficientError, Speed, TrimError, trim};
use squid_fmi2::Failure;
use squid_fmu_plant::{PlantError, PlantModel};
use squid_sea::SeaError;

const THRUSTERS: [&str; 3] = ["lower", "upper_port", "upper_starboard"];

fn command_trim(flight: &mut Flight<PlantModel>) {
    for name in THRUSTERS {
        let value = flight.get(&format!("trim_{name}"));
        flight.set(name, value);
    }
}

#[test]
fn starts_and_stays_in_trim() {
    let vehicle = vehicle("squid");
    for speed in [0.5, 1.0, 2.2, 3.0] {
        let level = trim(&vehicle, Speed::Path(speed), 20.0).unwrap();
        let mut flight = prepare(&squid(), &[("initial_speed", speed), ("initial_depth", 20.0)]);
        command_trim(&mut flight);
        flight.exit().unwrap();
        for (name, expected) in [
            ("pitch", level.pitch),
            ("trim_pitch", level.pitch),
            ("speed", level.forward_speed),
            ("heave", level.heave),
            ("lower_output", level.actuators[0]),
            ("trim_upper_port", level.actuators[1]),
        ] {
            assert_eq!(flight.get(name), expected, "{name}");
        }
        flight.fly_in(60.0, 600);
        assert!((flight.get("pitch") - level.pitch).abs() < 1e-9);
        assert!((flight.get("path_speed") - speed).abs() < 1e-9);
        assert!((flight.get("depth") - 20.0).abs() < 1e-8);
        assert!((flight.get("distance") - 60.0 * speed).abs() < 1e-8);
        assert_eq!(flight.get("trim_pitch"), level.pitch);
        assert!(flight.log.0.is_empty(), "{:?}", flight.log.0);
    }
}

#[test]
fn stays_in_trim_by_default() {
    let mut flight = start(&squid(), &[]);
    let pitch = flight.get("pitch");
    flight.fly_in(60.0, 600);
    assert!((flight.get("pitch") - pitch).abs() < 1e-9);
    assert!((flight.get("path_speed") - 1.75).abs() < 1e-9);
}

#[test]
fn commands_act_through_lag_and_limits_from_start() {
    let mut flight = prepare(&squid(), &[]);
    let trim = flight.get("trim_lower");
    flight.set("lower", 500.0);
    flight.exit().unwrap();
    assert_eq!(flight.get("lower_output"), trim, "the output starts at trim whatever the command");
    flight.fly_in(0.1, 4);
    let expected = 100.0 + (trim - 100.0) * (-0.1_f64 / 0.2).exp();
    assert!((flight.get("lower_output") - expected).abs() < 1e-11);
    flight.fly_in(10.0, 100);
    assert!((flight.get("lower_output") - 100.0).abs() < 1e-10 && flight.get("lower_output") <= 100.0);
    assert_eq!(flight.get("lower"), 500.0, "the command reads back as it was set");
}

/// The vehicle has inertia: a new current changes the velocity through the water immediately, and the velocity over
/// ground only during a step.
#[test]
fn new_current_changes_velocity_through_water_only() {
    let mut flight = start(&squid(), &[]);
    flight.fly_in(1.0, 10);
    let held = ["pitch", "surge_over_ground", "depth", "lower_output"];
    let before = held.map(|name| flight.get(name));
    let (pitch, speed, heave) = (flight.get("pitch"), flight.get("speed"), flight.get("heave"));
    flight.set("lower", 40.0);
    flight.set("current_horizontal", 0.5);
    assert_eq!(held.map(|name| flight.get(name)), before);
    assert!((flight.get("speed") - speed + 0.5 * pitch.cos()).abs() < 1e-14);
    assert!((flight.get("heave") - heave + 0.5 * pitch.sin()).abs() < 1e-14);
    flight.fly_in(1.1, 1);
    assert!(held.map(|name| flight.get(name)).iter().zip(before).all(|(after, before)| *after != before));
}

#[test]
fn result_does_not_depend_on_step_size() {
    let ends = [5, 500, 5000].map(|steps| {
        let mut flight = start(&squid(), &[]);
        flight.set("lower", 30.0);
        flight.set("current_vertical", 0.1);
        flight.fly_in(10.0, steps);
        ["pitch", "speed", "heave", "depth", "distance"].map(|name| flight.get(name))
    });
    assert!((ends[0][0]).abs() > 0.05, "the vehicle must have moved");
    for end in &ends[1..] {
        assert!(end.iter().zip(&ends[0]).all(|(a, b)| (a - b).abs() < 1e-9), "{ends:?}");
    }
}

#[test]
fn initial_current_carries_the_vehicle() {
    let mut flight = prepare(&squid(), &[]);
    flight.set("current_horizontal", 0.25);
    flight.exit().unwrap();
    let pitch = flight.get("pitch");
    assert!((flight.get("path_speed") - 1.75).abs() < 1e-12, "trim is through the water");
    flight.fly_in(20.0, 200);
    assert!((flight.get("distance") - 20.0 * (1.75 + 0.25)).abs() < 1e-8);
    assert!((flight.get("pitch") - pitch).abs() < 1e-9);
}

#[test]
fn coefficient_changes_trim_and_motion() {
    let mut light = start(&squid(), &[("buoyancy", 664.0), ("initial_speed", 1.0)]);
    let mut plain = start(&squid(), &[("initial_speed", 1.0)]);
    assert!(light.get("trim_pitch") < plain.get("trim_pitch") - 0.02, "more lift downwards is needed");
    let mut stiff = start(&squid(), &[("z_G", 0.06)]);
    let mut soft = start(&squid(), &[]);
    for flight in [&mut stiff, &mut soft] {
        flight.set("lower", 20.0);
        flight.fly_in(5.0, 50);
    }
    assert!(stiff.get("pitch") < soft.get("pitch") - 0.02);
}

#[test]
fn lpv_model_agrees_with_nonlinear_equations_near_trim() {
    let nudged = |fidelity: f64| {
        let mut flight = prepare(&squid(), &[("fidelity", fidelity), ("initial_speed", 1.75)]);
        flight.set("lower", flight.instance.model().inputs.commands[0] + 0.5);
        flight.exit().unwrap();
        flight.fly_in(10.0, 100);
        (flight.get("pitch") - flight.get("trim_pitch"), flight.log.0)
    };
    let ((nonlinear, _), (lpv, log)) = (nudged(1.0), nudged(2.0));
    assert!(nonlinear > 1e-3 && (lpv - nonlinear).abs() < 0.05 * nonlinear, "{nonlinear} {lpv}");
    assert_ne!(nonlinear, lpv);
    assert!(log.is_empty(), "{log:?}");
}

#[test]
fn warns_once_per_excursion() {
    let mut flight = start(&squid(), &[("fidelity", 2.0)]);
    for (k, speed) in [3.0, 3.5, 3.6, 2.0, 0.4, 0.3].into_iter().enumerate() {
        flight.set("operating_speed", speed);
        flight.fly_in(0.01 * (k as f64 + 1.0), 1);
    }
    assert_eq!(flight.log.0.len(), 2, "{:?}", flight.log.0);
    insta::assert_snapshot!(flight.log.0.join("\n"));
    let mut nonlinear = start(&squid(), &[]);
    nonlinear.set("operating_speed", 9.0);
    nonlinear.fly_in(1.0, 10);
    assert!(nonlinear.log.0.is_empty());
}

#[test]
fn warns_of_coefficients_unknown_to_lpv_model() {
    let warned = |parameters: &[(&str, f64)]| start(&squid(), parameters).log.0;
    insta::assert_snapshot!(warned(&[("fidelity", 2.0), ("Z_uw", -60.0)])[0]);
    assert!(warned(&[("fidelity", 1.0), ("Z_uw", -60.0)]).is_empty());
}

#[test]
fn warns_above_the_surface() {
    let mut flight = start(&squid(), &[("initial_depth", 0.05)]);
    flight.set("current_vertical", -0.1);
    flight.fly_in(3.0, 30);
    assert!(flight.get("depth") < 0.0);
    assert_eq!(flight.log.0.len(), 1);
    // The vehicle drifts up with the water, which takes half a second for 0.05 m; it surfaces later because it has
    // inertia.
    let message = &flight.log.0[0];
    insta::assert_snapshot!(masked(message));
    assert!(message.contains(" 1.7"), "{message}");
    let time: f64 = message.split_whitespace().nth(1).unwrap().parse().unwrap();
    assert!((0.5..1.5).contains(&time), "{message}");
}

#[test]
fn warns_when_hull_leaves_the_waves() {
    let shallow = [("initial_depth", 1.5), ("wave_height", 2.0), ("wave_period", 8.0)];
    let mut flight = start(&squid(), &shallow);
    flight.set("current_vertical", -0.05);
    let mut seconds = (1..=18).map(f64::from);
    while flight.log.0.is_empty() {
        flight.fly_in(seconds.next().unwrap(), 10);
    }
    insta::assert_snapshot!(masked(&flight.log.0[0]));
}

#[test]
fn rejects_impossible_waves() {
    let rejected = |height: f64, period: f64, depth: f64| {
        let waves = [("wave_height", height), ("wave_period", period), ("initial_depth", depth)];
        reason(prepare(&squid(), &waves).exit())
    };
    let (steep, high) = (rejected(1.0, 2.0, 50.0), rejected(2.0, 8.0, 0.0));
    assert!(
        matches!(steep, PlantError::Waves(SeaError::TooSteep { height: 1.0, period: 2.0, .. })),
        "{steep}"
    );
    assert!(matches!(high, PlantError::BreaksSurface { depth: 0.0, .. }), "{high}");
    insta::assert_snapshot!(masked(&format!("{steep}\n{high}")));
}

/// Returns the reason why a plant did not start.
fn reason(outcome: Result<(), Failure<PlantError>>) -> PlantError {
    match outcome.unwrap_err() {
        Failure::Model(reason) => reason,
        Failure::Refused(refusal) => panic!("{refusal}"),
    }
}

#[test]
fn rejects_invalid_start_and_recovers_by_reset() {
    let mut messages = vec![];
    for (parameter, value) in
        [("initial_speed", 9.0), ("initial_speed", 0.0), ("initial_depth", -1.0), ("Z_ww", 3.0), ("z_G", 1.0)]
    {
        let mut flight = prepare(&squid(), &[(parameter, value)]);
        let reason = reason(flight.exit());
        let found = match &reason {
            PlantError::Trim(TrimError::BeyondLimits { speed, .. }) | PlantError::NotAhead { speed } => {
                ("initial_speed", *speed)
            }
            PlantError::AboveSurface { depth } => ("initial_depth", *depth),
            PlantError::Coefficients(CoefficientError::NotAllowed { key, found, .. }) => (*key, *found),
            PlantError::Coefficients(CoefficientError::MassMatrixNotPositiveDefinite { .. }) => ("z_G", 1.0),
            _ => panic!("{reason}"),
        };
        assert_eq!(found, (parameter, value), "{reason}");
        // Both upper thrusters carry the same.
        messages.push(masked(&reason.to_string()).replace("upper_starboard", "upper_port"));
        flight.instance.reset().unwrap();
        flight.instance.enter_initialization().unwrap();
        flight.exit().unwrap();
        assert!((flight.get("path_speed") - 1.75).abs() < 1e-12);
    }
    insta::assert_snapshot!(messages.join("\n"));
}

#[test]
fn vehicle_with_stern_planes_flies() {
    let mut flight = start(&remus100(), &[("initial_speed", 1.54)]);
    let (propeller, planes) = (flight.get("trim_propeller"), flight.get("trim_stern_planes"));
    flight.set("propeller", propeller);
    flight.set("stern_planes", planes);
    flight.fly_in(10.0, 100);
    assert!((flight.get("pitch") - flight.get("trim_pitch")).abs() < 1e-9);
    assert!((flight.get("depth") - DEPTH).abs() < 1e-8);
    flight.set("stern_planes", planes - 0.05);
    flight.fly_in(12.0, 20);
    assert!(flight.get("pitch") > flight.get("trim_pitch") + 0.02, "planes down by the stern lift the bow");
}

/// The description of each command states the sign of the vehicle's response.
#[test]
fn description_states_sign_of_command() {
    for (resources, vehicle) in [(squid(), vehicle("squid")), (remus100(), vehicle("remus100"))] {
        let description = squid_fmu_plant::describe(&resources).unwrap().description;
        for actuator in &vehicle.actuators {
            let name = &actuator.name;
            let flown = |more: f64| {
                let mut flight = prepare(&resources, &[]);
                let level = flight.get(&format!("trim_{name}"));
                flight.set(name, level + more * actuator.reach());
                flight.exit().unwrap();
                flight.fly(0.2, 0.01);
                (flight.get("pitch_rate"), flight.get("speed"))
            };
            let (more, less) = (flown(0.1), flown(-0.1));
            let (turn, faster) = (more.0 - less.0, more.1 - less.1);
            let message = &description.variables[description.position(name).unwrap()].description;
            let sign = match (message.contains("bow up"), message.contains("bow down")) {
                (true, false) => 1.0,
                (false, true) => -1.0,
                _ => 0.0,
            };
            assert_eq!(sign == 0.0, name == "propeller", "only the propeller is on the axis: {message}");
            assert!(sign * turn > 1e-6 || sign == 0.0, "{message}: {turn} rad/s");
            if actuator.unit() == "N" {
                assert_eq!(message.contains("pushes forward"), faster > 0.0, "{message}: {faster} m/s");
            }
        }
    }
}
