//! The loop as an FMU, without the C interface: its motion, and its independence of the steps.

use crate::example::{
    Flight, design, input, manoeuvre, resources, started, turning, two_degrees, with, with_two_degrees,
};
use squid_fmi2::{Resources, Silent};
use squid_fmu_loop::{ClosedLoop, describe};
use squid_scheduled::{Kind, Manoeuvre};

const MOTION: [&str; 7] = ["pitch", "speed", "pitch_rate", "heave", "path_speed", "depth", "distance"];
const ACTUATORS: [&str; 3] = ["lower", "upper_port", "upper_starboard"];
const NONLINEAR: i32 = 1;
const LPV: i32 = 2;

fn differ(a: &mut Flight<ClosedLoop>, b: &mut Flight<ClosedLoop>) -> f64 {
    let gap = |name| (a.get(name) - b.get(name)).abs();
    MOTION.into_iter().chain(ACTUATORS).map(gap).fold(0.0, f64::max)
}

#[test]
fn follows_step_and_ramp() {
    for fidelity in [NONLINEAR, LPV] {
        let mut flight = Flight::prepare(describe(&resources()).unwrap(), 0.0);
        flight.set("fidelity", fidelity);
        flight.begin().unwrap();
        assert!(flight.get("tracking_error").abs() < 1e-6, "starts in trim");
        let level = flight.get("pitch");
        flight.fly(1.9, 0.1);
        // The trim of this LPV model is interpolated between three speeds, none of which is 0.8 m/s.
        let drift = (flight.get("pitch") - level).abs();
        assert!(fidelity == LPV || drift < 1e-4, "and stays there until the step: {drift}");
        flight.fly(60.0, 0.1);
        let design = design();
        let (speed, pitch) = (design.trim.forward_speed[19], design.trim.signals["pitch"][19]);
        assert!((flight.get("speed_reference_used") - speed).abs() < 1e-12, "2.4 m/s along the path");
        assert!((flight.get("pitch_reference_used") - pitch - manoeuvre().step("pitch")).abs() < 1e-12);
        assert!((flight.get("trim_pitch") - pitch).abs() < 1e-12);
        assert!(flight.get("tracking_error").abs() < 0.01 * manoeuvre().step("pitch"));
        assert!((flight.get("speed") - speed).abs() < 0.01);
        assert!((flight.get("scheduling_parameter") - (2.4 - 1.75) / 1.25).abs() < 0.01);
        assert!(flight.get("depth") < 45.0, "bow up, it climbs");
        assert!(flight.log.0.is_empty(), "{:?}", flight.log.0);
    }
}

/// Returns the references by the explicit formulas of the manoeuvre, with the trim table of the design.
fn references(time: f64) -> [f64; 3] {
    let design = design();
    let autopilot = squid_scheduled::Autopilot::new(&design).unwrap();
    let speed = 0.8 + 1.6 * ((time - 3.0) / 10.0).clamp(0.0, 1.0);
    let forward = autopilot.trim().forward_speed(speed);
    let step = if time > 2.0 - 1e-6 { 10f64.to_radians() } else { 0.0 };
    [autopilot.trim().signal(forward, 0, 0.0) + step, forward, speed]
}

#[test]
fn equals_plant_and_controller_stepped_by_a_master() {
    equals_both_stepped_by_a_master(&resources(), &["pitch", "speed"]);
    equals_both_stepped_by_a_master(&with_two_degrees(), &["pitch", "speed", "pitch_rate"]);
}

#[test]
fn equals_plant_and_controller_in_six_dof() {
    let measured = ["pitch", "speed", "pitch_rate", "heading", "heading_rate"];
    equals_both_stepped_by_a_master(&turning(), &measured);
}

fn equals_both_stepped_by_a_master(resources: &Resources, measured: &[&str]) {
    let turns = measured.contains(&"heading");
    let (fidelities, way, others): (&[_], _, &[_]) = if turns {
        (&[NONLINEAR], "north", &["east", "heading", "roll", "rudder_output"])
    } else {
        (&[NONLINEAR, LPV], "distance", &[])
    };
    for &fidelity in fidelities {
        let mut whole = Flight::prepare(describe(resources).unwrap(), 0.0);
        let mut plant = Flight::prepare(squid_fmu_plant::describe(resources).unwrap(), 0.0);
        if !turns {
            whole.set("fidelity", fidelity);
            plant.set("fidelity", fidelity);
        }
        whole.begin().unwrap();
        plant.set("initial_speed", 0.8);
        plant.begin().unwrap();
        let mut controller = Flight::prepare(squid_fmu_controller::describe(resources).unwrap(), 0.0);
        // Initial value of the reference filter.
        controller.set("speed_reference", references(0.0)[1]);
        controller.begin().unwrap();
        for tick in 0..1000 {
            let time = f64::from(tick) * 0.02;
            let [pitch_reference, speed_reference, operating_speed] = references(time);
            for name in measured {
                controller.set(name, plant.get(name));
            }
            controller.set("pitch_reference", pitch_reference);
            controller.set("speed_reference", speed_reference);
            if turns {
                let turn = if time > 2.0 - 1e-6 { 20f64.to_radians() } else { 0.0 };
                controller.set("heading_reference", turn);
            }
            controller.instance.step(time, 0.02, &mut Silent).unwrap();
            for name in ACTUATORS.into_iter().chain(turns.then_some("rudder")) {
                plant.set(name, controller.get(name));
            }
            if !turns {
                plant.set("operating_speed", operating_speed);
            }
            plant.instance.step(time, 0.02, &mut Silent).unwrap();
            whole.instance.step(time, 0.02, &mut Silent).unwrap();
            let motion = MOTION.iter().filter(|name| **name != "distance").chain([&"lower_output", &way]);
            for name in motion.chain(others) {
                let (one, two) = (whole.get(name), plant.get(name));
                assert!((one - two).abs() < 1e-9, "{name} at {time} s: {one} and {two}");
            }
            for name in ACTUATORS.into_iter().chain(["scheduling_parameter", "trim_pitch"]) {
                let (one, two) = (whole.get(name), controller.get(name));
                assert!((one - two).abs() < 1e-9, "{name} at {time} s: {one} and {two}");
            }
        }
        assert!(whole.get("pitch") > 0.1 && whole.get(way) > 20.0, "it flew");
        assert!(!turns || (whole.get("heading") - 20f64.to_radians()).abs() < 0.1, "it turned");
    }
}

/// A design with unused measurements behaves like the design without them; one with references and measurements as
/// inputs behaves like the one with their differences.
#[test]
fn equivalent_controllers_give_equal_motion() {
    let mut idle = design();
    idle.controller_inputs.push(input("pitch_rate", Kind::Measurement, 0.1));
    idle.controller_inputs.push(input("heave", Kind::Measurement, 0.1));
    for rows in [&mut idle.lft.by, &mut idle.lft.duy, &mut idle.lft.dty] {
        rows.iter_mut().for_each(|row| row.extend([0.0; 2]));
    }
    let mut apart = two_degrees();
    apart.reference_filter = None;
    apart.lft.duy.iter_mut().for_each(|row| row[4] = 0.0);
    let mut expected = started(&resources());
    expected.fly(20.0, 0.02);
    for same in [&idle, &apart] {
        let mut flight = started(&with(same, &manoeuvre()));
        flight.fly(20.0, 0.02);
        let gap = differ(&mut flight, &mut expected);
        assert!(gap < 1e-9, "{gap:e}");
    }
    let mut damped = started(&with_two_degrees());
    damped.fly(20.0, 0.02);
    assert!(differ(&mut damped, &mut expected) > 1e-3, "what is measured acts");
}

#[test]
fn results_do_not_depend_on_the_communication_step() {
    let resources = resources();
    let steps = [0.001, 0.01, 0.013, 0.1, 0.37, 20.0];
    let mut flights = steps.map(|_| started(&resources));
    let mut expected = started(&resources);
    // The second and third lie between two ticks.
    for to in [2.0, 7.773, 12.999, 20.0] {
        expected.fly(to, 0.02);
        for (flight, step) in flights.iter_mut().zip(steps) {
            flight.fly(to, step);
            let gap = differ(flight, &mut expected);
            assert!(gap < 1e-9, "{gap:e} at {to} s with steps of {step} s");
        }
    }
}

#[test]
fn rounded_steps_neither_skip_nor_repeat_a_tick() {
    let resources = resources();
    let mut exact = started(&resources);
    exact.fly(10.0, 0.02);
    for step in [0.00999999999999934, 0.01, 0.010000000000000009] {
        let mut flight = started(&resources);
        for _ in 0..1000 {
            let now = flight.instance.time();
            flight.instance.step(now, step, &mut Silent).unwrap();
        }
        assert_eq!(flight.instance.model().axes[0].autopilot().ticks(), 500, "{step}");
        assert!(differ(&mut flight, &mut exact) < 1e-9, "{step}");
    }
}

#[test]
fn manual_switches_references_over_and_back() {
    let mut flight = started(&with(&design(), &Manoeuvre { speed_to: 0.8, ..manoeuvre().without_steps() }));
    let (pitch, speed) = (flight.get("pitch_reference_used"), flight.get("speed_reference_used"));
    flight.set("pitch_reference", 0.1);
    flight.set("speed_reference", 1.5);
    flight.fly(5.0, 0.1);
    let used =
        |flight: &mut Flight<_>| (flight.get("pitch_reference_used"), flight.get("speed_reference_used"));
    assert_eq!(used(&mut flight), (pitch, speed), "without manual the inputs mean nothing");
    flight.set("manual", true);
    flight.fly(60.0, 0.1);
    assert_eq!(used(&mut flight), (0.1, 1.5));
    assert!((flight.get("pitch") - 0.1).abs() < 1e-3 && (flight.get("speed") - 1.5).abs() < 1e-2);
    flight.set("manual", false);
    flight.fly(60.02, 0.02);
    assert_eq!(used(&mut flight), (pitch, speed));
}

#[test]
fn manual_references_of_the_manoeuvre_change_nothing() {
    for fidelity in [NONLINEAR, LPV] {
        let mut flights = [false, true].map(|manual| {
            let mut flight = Flight::prepare(describe(&resources()).unwrap(), 0.0);
            flight.set("fidelity", fidelity);
            flight.set("manual", manual);
            flight.begin().unwrap();
            flight
        });
        let [flown, manual] = &mut flights;
        for tick in 0..600 {
            let time = f64::from(tick) * 0.02;
            let [pitch, speed, _] = references(time);
            manual.set("pitch_reference", pitch);
            manual.set("speed_reference", speed);
            for flight in [&mut *flown, &mut *manual] {
                flight.instance.step(time, 0.02, &mut Silent).unwrap();
            }
        }
        assert!(differ(flown, manual) < 1e-9);
    }
}

#[test]
fn reset_and_restored_states_repeat_the_motion() {
    let mut flight = started(&resources());
    flight.fly(6.01, 0.01);
    let middle = flight.instance.snapshot().unwrap();
    flight.fly(12.0, 0.01);
    let end = MOTION.map(|name| flight.get(name));
    flight.instance.restore(&middle).unwrap();
    flight.fly(12.0, 0.01);
    assert_eq!(MOTION.map(|name| flight.get(name)), end);
    flight.set("manual", true);
    flight.instance.reset().unwrap();
    flight.begin().unwrap();
    flight.fly(6.01, 0.01);
    flight.fly(12.0, 0.01);
    assert_eq!(MOTION.map(|name| flight.get(name)), end);
}

#[test]
fn applies_parameters_of_manoeuvre_and_vehicle() {
    let mut flight = Flight::prepare(describe(&resources()).unwrap(), 0.0);
    flight.set("speed_from", 1.5);
    flight.set("pitch_step", -0.1);
    flight.set("initial_depth", 20.0);
    flight.set("z_G", 0.05);
    flight.begin().unwrap();
    assert!((flight.get("path_speed") - 1.5).abs() < 1e-9);
    assert_eq!(flight.get("depth"), 20.0);
    assert_eq!(flight.instance.model().plant.settings.coefficients.z_G, 0.05);
    flight.fly(30.0, 0.1);
    assert!(flight.get("pitch") < -0.08 && flight.get("depth") > 20.0, "bow down, it dives");
}

#[test]
fn starts_at_any_time() {
    let mut flight = Flight::prepare(describe(&resources()).unwrap(), 100.0);
    flight.begin().unwrap();
    assert!((flight.get("path_speed") - 2.4).abs() < 1e-9, "the ramp is over");
    flight.fly(100.05, 0.05);
    let model = flight.instance.model();
    assert_eq!((model.plant.time(), model.axes[0].autopilot().ticks()), (100.05, 3));
}

#[test]
fn current_carries_the_vehicle() {
    let resources = resources();
    let mut flights = [0.0, 0.5].map(|current| {
        let mut flight = started(&resources);
        flight.set("current_horizontal", current);
        flight.fly(20.0, 0.1);
        flight
    });
    let [still, carried] = &mut flights;
    let way = carried.get("distance") - still.get("distance");
    assert!((way - 10.0).abs() < 1.0, "{way} m");
}

#[test]
fn warns_once_per_excursion() {
    // The speed leaves the range at the end of the ramp, returns by `manual`, and leaves the range again at the lower
    // end.
    let fast = Manoeuvre { speed_from: 2.5, speed_to: 3.4, ..manoeuvre() };
    let mut flight = started(&with(&design(), &fast));
    flight.fly(20.0, 0.1);
    assert_eq!(flight.log.0.len(), 1, "{:?}", flight.log.0);
    assert!(flight.log.0[0].contains(" 0.5 to 3 m/s"), "{}", flight.log.0[0]);
    flight.set("manual", true);
    flight.set("speed_reference", 2.0);
    flight.fly(60.0, 0.1);
    assert_eq!(flight.log.0.len(), 1, "{:?}", flight.log.0);
    flight.set("speed_reference", 3.4);
    flight.fly(80.0, 0.1);
    assert_eq!(flight.log.0.len(), 2, "{:?}", flight.log.0);
}
