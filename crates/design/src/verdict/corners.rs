//! Steps flown by vehicles at corners of the declared uncertainty.

use crate::error::Error;
use crate::inputs::Inputs;
use crate::uncertain::gradients::perturbed;
use crate::uncertain::model::{Block, Uncertain};
use crate::uncertain::trim::{blocks, random_corners};
use crate::uncertain::vehicle::gains;
use crate::verdict::flown::{StepAtSpeed, step_at};
use rayon::prelude::*;
use serde::Serialize;
use squid_flight::error::Error as FlightError;
use squid_flight::flight::{Variations, fly_varied, unless_lost};
use squid_scheduled::ControllerDesign;

/// Number of random corners at each speed, besides the two with all coefficients at the same end of their ranges.
const RANDOM: usize = 10;

/// Worst figures of the default step over corners of the declared uncertainty at one speed: each coefficient at an end
/// of its range, and each actuator at its least or its largest gain.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Corners {
    /// Name of the stepped output.
    pub output: &'static str,
    /// Speed along the path, m/s.
    pub speed: f64,
    /// Number of corners flown.
    pub flown: usize,
    /// Number of corners that were not flown, because their actuators cannot hold level flight.
    pub untrimmed: usize,
    /// Largest excursion beyond the reference, relative to the step; infinite if a flight was lost, or none flown.
    pub overshoot: f64,
    /// Largest error at the end, relative to the step; infinite if a flight was lost, or none flown.
    pub remaining_error: f64,
}

impl Corners {
    /// Flies the steps at a number of speeds; none without an output to step, or without declared uncertainty.
    ///
    /// # Errors
    /// The errors of the flights.
    pub fn of(inputs: &Inputs, controller: &ControllerDesign, speeds: usize) -> Result<Vec<Self>, Error> {
        if !inputs.is_uncertain() || speeds == 0 {
            return Ok(vec![]);
        }
        let at = |speed: f64| Self::at(inputs, controller, speed);
        inputs.design.spread(speeds).into_par_iter().filter_map(|speed| at(speed).transpose()).collect()
    }

    fn at(inputs: &Inputs, controller: &ControllerDesign, speed: f64) -> Result<Option<Self>, Error> {
        let Some(output) = inputs.design.tracked.iter().find(|one| one.index == inputs.design.stepped())
        else {
            return Ok(None);
        };
        let uncertain = blocks(inputs, &inputs.axis().at(speed)?.trim, &[])?;
        let mut worst = Self {
            output: output.signal.name,
            speed,
            flown: 0,
            untrimmed: 0,
            overshoot: 0.0,
            remaining_error: 0.0,
        };
        for corner in corners(&uncertain) {
            let vehicle = perturbed(&inputs.vehicle, &uncertain, &corner);
            let gains = gains(vehicle.actuators.len(), &uncertain, &corner);
            let variations = Variations { gains: &gains, ..Variations::default() };
            let manoeuvre = step_at(inputs, output, speed);
            let flown = fly_varied(&vehicle, controller, inputs.design.level(), &manoeuvre, &variations);
            if matches!(flown, Err(FlightError::Trim { .. })) {
                worst.untrimmed += 1;
                continue;
            }
            let flight = unless_lost(flown)?;
            let step = StepAtSpeed::flown(output.index, speed, flight.as_ref(), inputs);
            worst.flown += 1;
            let lost = |one: f64| if one.is_nan() { f64::INFINITY } else { one };
            worst.overshoot = worst.overshoot.max(lost(step.overshoot));
            worst.remaining_error = worst.remaining_error.max(lost(step.steady_error));
        }
        if worst.flown == 0 {
            (worst.overshoot, worst.remaining_error) = (f64::INFINITY, f64::INFINITY);
        }
        Ok(Some(worst))
    }
}

/// Corners of the box: every coefficient at its lower, or its upper end, and random ones; gains are at their least in
/// the first two.
fn corners(uncertain: &[Block]) -> Vec<Vec<f64>> {
    let at_end = |end: f64| {
        let one = |block: &Block| if matches!(block.uncertain, Uncertain::Gain(_)) { -1.0 } else { end };
        uncertain.iter().map(one).collect()
    };
    let random = random_corners(uncertain.len(), RANDOM, 4);
    [at_end(-1.0), at_end(1.0)].into_iter().chain(random).collect()
}
