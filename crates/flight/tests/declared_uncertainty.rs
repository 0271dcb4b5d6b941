//! Default designs on nonlinear vehicles over their declared uncertainty: sampled, with lags, limits and the trim table
//! of the nominal vehicle.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use nalgebra::DMatrix;
use squid_auv::longitudinal::PITCH;
use squid_auv::{Actuator, Trim, Vehicle, linearise};
use squid_base::progress::Progress;
use squid_design::inputs::Inputs;
use squid_design::run::run;
use squid_design::store::load;
use squid_design::uncertain::frozen::at_speed;
use squid_design::uncertain::model::Uncertain;
use squid_design::uncertain::trim::retrim;
use squid_flight::flight::{Variations, fly_varied};
use squid_flight::metrics::StepFigures;
use squid_scheduled::{ControllerDesign, Manoeuvre};
use std::path::Path;

/// Time of the step (s), after the transient from the nominal trim has settled.
const STEP_TIME: f64 = 20.0;

/// Worst metrics over many flights.
#[derive(Debug, Default)]
struct Worst {
    flights: usize,
    /// Number of vehicles whose actuators cannot hold the trim or the pitch reference at the speed.
    too_weak: usize,
    /// Number of flights with a final error above a tenth of the step.
    lost: usize,
    overshoot: f64,
    rise_time: f64,
    settling_time: f64,
    steady_error: f64,
}

/// Returns a random number in [0, 1): xorshift64, G. Marsaglia, J. Statistical Software 8(14), 2003.
fn random(seed: &mut u64) -> f64 {
    *seed ^= *seed << 13;
    *seed ^= *seed >> 7;
    *seed ^= *seed << 17;
    (*seed >> 11) as f64 / (1u64 << 53) as f64
}

/// Simulates a pitch step at some speeds (m/s) for vertices of the box (all parameters at one end, a single one at the
/// other end, random signs) and for random points.
fn fly_over_the_box(
    inputs: &Inputs,
    design: &ControllerDesign,
    speeds: &[f64],
    corners: usize,
    points: usize,
) -> Worst {
    let Inputs { vehicle, design: file, .. } = inputs;
    let mut worst = Worst::default();
    let mut seed = 2011;
    for &speed in speeds {
        let frozen = at_speed(inputs, speed).unwrap();
        let blocks = &frozen.parameters;
        let manoeuvre = Manoeuvre {
            speed_from: speed,
            speed_to: speed,
            step_time: STEP_TIME,
            duration: STEP_TIME + 40.0,
            ..file.manoeuvre.clone()
        };
        for flight in 0..corners + points {
            let delta: Vec<f64> = (0..blocks.len())
                .map(|i| match flight {
                    0 => 1.0,
                    1 => -1.0,
                    _ if flight < corners && flight - 2 < blocks.len() => {
                        if i == flight - 2 {
                            1.0
                        } else {
                            -1.0
                        }
                    }
                    _ if flight < corners => (2.0 * random(&mut seed) - 1.0).signum(),
                    _ => 2.0 * random(&mut seed) - 1.0,
                })
                .collect();
            let (changed, trim) = retrim(vehicle, &frozen.nominal.trim, blocks, &delta).unwrap();
            let mut gains = vec![1.0; vehicle.actuators.len()];
            for (block, d) in blocks.iter().zip(&delta) {
                if let Uncertain::Gain(actuator) = block.uncertain {
                    gains[actuator] += block.half_range * d;
                }
            }
            if !is_strong_enough(&changed, &trim, &gains, manoeuvre.step("pitch")) {
                worst.too_weak += 1;
                continue;
            }
            let variations = Variations { gains: &gains, ..Variations::default() };
            let result = fly_varied(&changed, design, file.level(), &manoeuvre, &variations);
            worst.flights += 1;
            let Some(flight) = result.ok().filter(|flight| flight.surfacing.is_none()) else {
                worst.lost += 1;
                continue;
            };
            let figures =
                StepFigures::of(&flight.rows, PITCH, (STEP_TIME, manoeuvre.step("pitch")), &inputs.limits());
            if figures.steady_error.is_nan() || figures.steady_error > 0.1 {
                worst.lost += 1;
            }
            worst.overshoot = worst.overshoot.max(figures.overshoot);
            worst.rise_time = worst.rise_time.max(figures.rise_time);
            worst.settling_time = worst.settling_time.max(figures.settling_time);
            worst.steady_error = worst.steady_error.max(figures.steady_error);
        }
    }
    worst
}

/// Returns `true` if the actuators, with their gains, can hold the trim and then a pitch step: to first order at the
/// same forward speed, from `0 = A [0 w 0 step] + B outputs` with the least outputs relative to their reach.
fn is_strong_enough(vehicle: &Vehicle, trim: &Trim, gains: &[f64], step: f64) -> bool {
    let l = linearise(vehicle, trim).unwrap();
    let reach: Vec<f64> = vehicle.actuators.iter().map(Actuator::reach).collect();
    let mut m = DMatrix::zeros(3, 1 + reach.len());
    // Heave has no cost.
    m.column_mut(0).copy_from(&(l.a.view((0, 1), (3, 1)) * 1e6));
    for (j, reach) in reach.iter().enumerate() {
        m.column_mut(1 + j).copy_from(&(l.b.view((0, j), (3, 1)) * *reach));
    }
    let right_side = l.a.view((0, 3), (3, 1)) * -step;
    let found = m.svd(true, true).solve(&right_side, 1e-12).unwrap();
    let holds = |j: usize, output: f64| {
        let a = &vehicle.actuators[j];
        (a.min * gains[j]..=a.max * gains[j]).contains(&output)
    };
    (0..reach.len()).all(|j| {
        let output = trim.actuators[j];
        holds(j, output) && holds(j, output + reach[j] * found[1 + j])
    })
}

/// Returns the default design of a vehicle: the committed one for Squid, a new one for another vehicle.
fn default_design(name: &str) -> (Inputs, ControllerDesign) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../vehicles").join(name);
    let inputs = Inputs::read(&folder, if name == "squid" { "design" } else { "pitch" }).unwrap();
    let frozen = folder.join("frozen");
    let controller = if frozen.exists() {
        load(&frozen, &inputs).unwrap().controller
    } else {
        run(&inputs, &Progress::default()).unwrap().frozen.controller
    };
    (inputs, controller)
}

#[test]
fn keeps_every_vehicle_of_the_box() {
    for (name, speeds, overshoot) in [("squid", [0.6, 2.9], 0.05), ("remus100", [1.5, 2.1], 0.15)] {
        let (inputs, design) = default_design(name);
        let worst = fly_over_the_box(&inputs, &design, &speeds, 29, 6);
        println!("{name}: {worst:?}");
        assert_eq!(worst.lost, 0, "{name}: {worst:?}");
        assert!(worst.flights > 60 && worst.overshoot <= overshoot, "{name}: {worst:?}");
    }
}

/// Prints the figures in docs/benchmarks.md: `cargo test --release -p squid-flight -- --ignored --nocapture`.
#[test]
#[ignore = "night: two thousand flights"]
fn keeps_five_hundred_vehicles_at_four_speeds() {
    for (name, speeds) in [("squid", [0.6, 1.0, 2.0, 2.9]), ("remus100", [1.5, 1.7, 1.9, 2.1])] {
        let (inputs, design) = default_design(name);
        println!("{name}: {:?}", fly_over_the_box(&inputs, &design, &speeds, 29, 500));
    }
}
