//! Requirements on the default designs in flight, frozen at speeds over the range.

use crate::designs::{Made, made};
use squid_auv::Pitch;
use squid_auv::longitudinal::{PITCH, SPEED};
use squid_design::axis::VehicleModel;
use squid_design::certify::lft_matrices;
use squid_design::check::flown::Flown;
use squid_design::check::sampled::Sampling;
use squid_design::inputs::Inputs;
use squid_design::store::freeze::{Frozen, frozen, gamma};
use squid_flight::flight::{Row, fly};
use squid_lpv::controller::Controller;
use squid_lpv::state_space::StateSpace;
use squid_scheduled::Manoeuvre;

/// Loops at five speeds, and the largest rms of each command under noise relative to the allowed one: 4 N, 0.5 deg.
fn loops(inputs: &Inputs, controller: &Controller) -> (Vec<Flown>, f64) {
    let sampling = Sampling::of(&inputs.vehicle.actuators, &inputs.design);
    let at = |speed: f64| {
        let l = inputs.axis().linearise(speed).unwrap();
        let k: StateSpace = controller.frozen(&[inputs.design.rho(speed)]).unwrap();
        Flown::of(&sampling, &l, &k).unwrap()
    };
    let loops: Vec<Flown> = inputs.design.spread(5).into_iter().map(at).collect();
    let allowed =
        |j: usize| if inputs.vehicle.actuators[j].unit() == "N" { 4.0 } else { 0.5f64.to_radians() };
    let noise =
        most(&loops, |f| (0..f.noise_rms.len()).map(|j| f.noise_rms[j] / allowed(j)).fold(0.0, f64::max));
    (loops, noise)
}

/// Worst value of all loops.
fn most(loops: &[Flown], of: impl Fn(&Flown) -> f64) -> f64 {
    loops.iter().map(of).fold(f64::NEG_INFINITY, f64::max)
}

/// Every vehicle has a delay margin of at least 0.15 s, phase and disk margins of at least 45 and 35 deg (REMUS 100: 40
/// and 30), speed steps with at most 5 % overshoot (8 %), steady errors of at most 0.05 %, and at most 4 deg of pitch
/// after a gust (REMUS 100: 5, Tethys, which is slow: 9).
#[test]
fn default_designs_meet_flight_requirements() {
    for (name, phase, disk, overshoot, gust) in [
        ("squid", 45.0, 35.0, 0.05, 4.0),
        ("remus100", 40.0, 30.0, 0.08, 5.0),
        ("lauv", 45.0, 35.0, 0.05, 4.0),
        ("tethys", 45.0, 35.0, 0.05, 9.0),
    ] {
        let Made { inputs, design, .. } = made(name);
        let (loops, noise) = loops(inputs, &design.controller);
        let least = |of: fn(&squid_design::check::margins::Margins) -> f64| {
            loops.iter().flat_map(Flown::margins).map(of).fold(f64::INFINITY, f64::min)
        };
        assert!(least(|m| m.delay) >= 0.15 && most(&loops, |f| -f.common_delay) <= -0.15, "{name} {loops:?}");
        assert!(least(|m| m.phase.to_degrees()) >= phase, "{name} {loops:?}");
        assert!(least(|m| m.disk_phase().to_degrees()) >= disk, "{name} {loops:?}");
        assert!(most(&loops, |f| f.steps[1].overshoot) <= overshoot, "{name} {loops:?}");
        assert!(most(&loops, |f| f.steps[0].overshoot) <= 0.03, "{name} {loops:?}");
        let steady = |f: &Flown| f.steps.iter().map(|s| s.steady_error).fold(0.0, f64::max);
        assert!(most(&loops, steady) <= 5e-4, "{name} {loops:?}");
        assert!(most(&loops, |f| f.gust.to_degrees()) <= gust, "{name} {loops:?}");
        assert!(noise <= 1.0, "{name} {loops:?}");
    }
}

/// A box-shaped vehicle with vertical thrusters is level, proved, and flown from 0 to 0.45 m/s with a pitch step on the
/// way.
#[test]
fn box_shaped_vehicle_flies_from_rest() {
    let made = made("bluerov2_heavy");
    let Made { inputs, model, design, .. } = made;
    assert_eq!(inputs.design.pitch, Pitch::Held(0.0));
    let (lft, gamma) = (lft_matrices(&design.controller), gamma(design, true));
    assert!(made.proof().theorem.gamma_with_model_error.unwrap() < 1.01 * gamma.bound);
    let frozen = frozen(inputs, model, lft, gamma).unwrap();
    let Frozen { controller, plant: Some(plant) } = &frozen else { panic!() };
    assert_eq!((plant.pitch(), plant.trim[0].speed), (Pitch::Held(0.0), 0.0));

    let manoeuvre = Manoeuvre { speed_from: 0.0, ..inputs.design.manoeuvre.clone() };
    let flight = fly(&inputs.vehicle, controller, inputs.design.level(), &manoeuvre).unwrap();
    let within = |row: &Row| {
        let mut pairs = inputs.vehicle.actuators.iter().zip(&row.commands);
        pairs.all(|(a, command)| a.min < *command && *command < a.max)
    };
    assert!(flight.surfacing.is_none() && flight.rows.iter().all(within));
    let last = flight.rows.last().unwrap();
    assert!(last.error(SPEED).abs() < 0.01 && last.error(PITCH).abs() < 0.5f64.to_radians(), "{last:?}");
}
