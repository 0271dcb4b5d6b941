//! Assesses the controller of a vehicle's default design with the weights of another design:
//!
//! ```text
//! cargo run --release -p squid-design --example judge vehicles/squid tests/designs/errors_alone.toml [robust] [RATE]
//! ```
//!
//! or with that of `squid design --robust`. Prints mu for robust stability and for robust performance at six frozen
//! speeds, and then proves a gain for constant coefficients and any trajectory of the speed, or one no faster than
//! RATE, m/s^2. See `DesignFile::with_weights_of`.
//!
//! 'No controller below' m: a perturbation of size 1/m was found for which even the optimal controller has a gain of m,
//! so mu is at least m for every controller with the same measurements.
#![allow(clippy::print_stdout)]

use squid_base::progress::{Event, Progress};
use squid_design::augment::{LinearModel, augment};
use squid_design::certify::constant::constant;
use squid_design::check::frozen_controller;
use squid_design::inputs::Inputs;
use squid_design::inputs::design_file::DesignFile;
use squid_design::run::run_with;
use squid_design::uncertain::closed_loop::uncertain_loop;
use squid_design::uncertain::frozen::{FrozenUncertain, at_speed};
use squid_design::uncertain::trim::random_corners;
use squid_lpv::controller::Controller;
use squid_lpv::lft::Lft;
use squid_lpv::mu::over_frequency::mu_over_frequency;
use squid_lpv::mu::sweep::{CLOSEST, bound_over_frequency};
use squid_lpv::synthesis::{ScalingClass, least_gamma};
use std::error::Error;

/// Number of speeds at which mu is shown.
const SPEEDS: usize = 6;

/// Numbers of initial corners for the search for the lower limit, and of steps towards each.
const CORNERS: usize = 4;
const STEPS: usize = 4;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [vehicle, weights, rest @ ..] = arguments.as_slice() else {
        return Err("usage: judge VEHICLE WEIGHTS.toml [robust] [RATE]".into());
    };
    let (robust, rest) = match rest {
        [first, rest @ ..] if first == "robust" => (true, rest),
        rest => (false, rest),
    };
    let rate = rest.first().map(|rate| rate.parse()).transpose()?;
    let mut inputs = Inputs::read(vehicle.as_ref(), "design")?;
    let weights = DesignFile::parse(&std::fs::read_to_string(weights)?, weights, weights)?;
    let judged = inputs.design.with_weights_of(&weights)?;
    let finished = run_with(&inputs, &Progress::default(), robust)?;
    let k = &finished.design.controller;
    inputs.design = judged;
    println!(
        "| speed, m/s | mu, robust stability | mu, robust performance | no controller below | gain without uncertainty \
         |\n\
         |---|---|---|---|---|"
    );
    for speed in inputs.design.spread(SPEEDS) {
        println!("{}", at(&inputs, k, speed)?);
    }
    let plant = augment(&inputs.vehicle.actuators, &inputs.design, finished.model.linear())?;
    let gains = inputs.design.spread(SPEEDS).into_iter().map(|speed| {
        let rho = inputs.design.rho(speed);
        let frozen = plant.frozen(&[rho])?.close(&frozen_controller(k, rho)?);
        Ok::<_, Box<dyn Error>>(frozen.frozen(&[])?.hinf_norm().value)
    });
    let nominal = gains.collect::<Result<Vec<f64>, _>>()?.into_iter().fold(0.0, f64::max);
    println!("\nlargest frozen gain of the fit: {nominal:.4}");
    let show = |event: Event| {
        if let Event::Done { figures, .. } = event {
            println!("{figures}");
        }
    };
    constant(&inputs, &finished.model, k, nominal, rate, &Progress::new(&show))?;
    Ok(())
}

/// Returns a row of the table: guaranteed bounds over all frequencies, and values reached.
fn at(inputs: &Inputs, k: &Controller, speed: f64) -> Result<String, Box<dyn Error>> {
    let frozen = at_speed(inputs, speed)?;
    let closed = uncertain_loop(inputs, &frozen, k)?;
    let stability = bound_over_frequency(&closed.stability(), &closed.structure, CLOSEST)?.upper;
    let system = closed.system.without_idle_states();
    let performance = mu_over_frequency(&system, &closed.with_performance()?)?;
    let reached = performance.lower.map_or(0.0, |lower| lower.value);
    let (k, w) = (closed.structure.cols(), closed.structure.rows());
    let (outputs, inputs_of_loop) = system.d.shape();
    let nominal = system.parts(k..outputs, w..inputs_of_loop);
    Ok(format!(
        "| {speed:.2} | {stability:.3} | {:.3} at {:.2} rad/s (at least {reached:.3}) | {:.3} | {:.3} |",
        performance.upper.upper,
        performance.upper.frequency,
        least_possible(inputs, &frozen),
        nominal.hinf_norm().value
    ))
}

/// Returns a computed lower limit of mu for robust performance with any controller at one speed.
fn least_possible(inputs: &Inputs, frozen: &FrozenUncertain) -> f64 {
    let actuators = &inputs.vehicle.actuators;
    let gain = |delta: &[f64]| -> Option<f64> {
        let ab = Lft::constant(frozen.model.evaluate(0.0, delta).ok()?);
        let linear = LinearModel { ab, ..LinearModel::at(&frozen.linear(actuators), &inputs.design) };
        let plant = augment(actuators, &inputs.design, linear).ok()?;
        Some(least_gamma(&plant, ScalingClass::SymmetricAndSkew).ok()?.1.lower)
    };
    let at = |corner: &[f64], level: f64| gain(&corner.iter().map(|d| d / level).collect::<Vec<_>>());
    let n = frozen.model.blocks.len();
    let mut least = gain(&vec![0.0; n]).unwrap_or(0.0);
    let mut try_corner = |corner: &[f64]| {
        let before = least;
        for _ in 0..STEPS {
            let Some(found) = at(corner, least).filter(|found| *found > least) else { break };
            // A smaller perturbation leaves a smaller gain, so the limit is between the two.
            let middle = 0.5 * (least + found);
            least = if at(corner, middle).is_some_and(|found| found >= middle) { middle } else { break };
        }
        least > before
    };
    let mut best = vec![1.0; n];
    for corner in random_corners(n, CORNERS, 5) {
        if try_corner(&corner) {
            best = corner;
        }
    }
    for i in 0..n {
        best[i] = -best[i];
        if !try_corner(&best) {
            best[i] = -best[i];
        }
    }
    least
}
