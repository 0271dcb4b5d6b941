//! Fraction of the declared uncertainty that a law survives in simulation.

use crate::error::Error;
use crate::peers::course::slowness;
use crate::peers::law::Law;
use crate::subject::Subject;
use squid_auv::Vehicle;
use squid_design::error::UncertainError;
use squid_design::uncertain::trim::{blocks, random_corners, retrim};
use squid_design::uncertain::vehicle::gains;
use squid_flight::flight::Variations;

/// Time of the step (s), after the transient from the nominal vehicle's trim.
const STEP_TIME: f64 = 15.0;
/// End of the flight (s).
const END: f64 = 40.0;
/// Largest final error of a surviving vehicle, as a fraction of the step.
const LOST: f64 = 0.1;
/// Number of random points of the box, in addition to its vertices.
const POINTS: usize = 10;

/// Vehicles in the declared box, with the gains of their actuators.
pub type Fleet = Vec<(Vehicle, Vec<f64>)>;

/// Returns vehicles at the vertices with all coefficients or all but one at one end, at as many random vertices, and at
/// random points of the box, for a speed (m/s). Vehicles without a trim are omitted; empty if nothing is uncertain.
///
/// # Errors
/// Errors of the trim; [`UncertainError::Corner`].
pub fn fleet(subject: &Subject, speed: f64) -> Result<Fleet, Error> {
    let inputs = subject.inputs;
    if !inputs.is_uncertain() {
        return Ok(vec![]);
    }
    let nominal = inputs.axis().at(speed)?.trim;
    let blocks = blocks(inputs, &nominal, &[]).map_err(squid_design::error::Error::from)?;
    let n = blocks.len();
    let alone = (0..=n).map(|i| (0..n).map(|j| if i == j { 1.0 } else { -1.0 }).collect::<Vec<f64>>());
    // The digits of a number in [-1, 1] are signs.
    let digits: Vec<Vec<Vec<f64>>> = (1..=DIGITS).map(|seed| random_corners(n, POINTS, seed)).collect();
    let point = |i: usize| -> Vec<f64> {
        (0..n)
            .map(|j| digits.iter().enumerate().map(|(k, d)| d[i][j] * 0.5f64.powi(k as i32 + 1)).sum())
            .collect()
    };
    let all = std::iter::once(vec![1.0; n]).chain(alone).chain(random_corners(n, n + 1, 1));
    let mut fleet = vec![];
    for delta in all.chain((0..POINTS).map(point)) {
        match retrim(&inputs.vehicle, &nominal, &blocks, &delta) {
            Ok((vehicle, _)) => fleet.push((vehicle, gains(inputs.vehicle.actuators.len(), &blocks, &delta))),
            Err(UncertainError::NoTrim { .. }) => {}
            Err(other) => return Err(squid_design::error::Error::from(other).into()),
        }
    }
    Ok(fleet)
}

/// Number of binary digits of a random number.
const DIGITS: u64 = 24;

/// Survival of a fleet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Survival {
    /// Fraction that survived.
    pub share: f64,
    /// Largest overshoot of a survivor, relative to the step.
    pub overshoot: f64,
}

/// Simulates the step of a design for a fleet at a speed (m/s). A vehicle survives if it neither diverges nor surfaces,
/// and its final error is within a tenth of the step. Vehicles without a trim are lost; NaN without a vehicle.
pub fn survival(first: &Subject, law: &Law, speed: f64, fleet: &Fleet) -> Survival {
    let (step, [from, end]) = (first.step(), [STEP_TIME, END].map(|time| slowness(first) * time));
    let manoeuvre = first.stepped(speed, (from, f64::MAX), end);
    let overshoot_of_survivor = |(vehicle, gains): &(Vehicle, Vec<f64>)| -> Option<f64> {
        let variations = Variations { gains, ..Variations::default() };
        let flight = law.fly(vehicle, &manoeuvre, &variations).ok()?;
        let left = flight.rows.iter().map(|row| (row.time, row.error(step.index) / step.height));
        let off = left.clone().filter(|(time, _)| *time > 0.9 * end).map(|(_, left)| left.abs());
        let survives = flight.surfacing.is_none() && off.fold(0.0, f64::max) <= LOST;
        let beyond = left.filter(|(time, _)| *time >= from).map(|(_, left)| -left);
        survives.then(|| beyond.fold(0.0, f64::max))
    };
    let survivors: Vec<f64> = fleet.iter().filter_map(overshoot_of_survivor).collect();
    let none = if fleet.is_empty() { f64::NAN } else { 0.0 };
    Survival {
        share: survivors.len() as f64 / fleet.len() as f64,
        overshoot: survivors.into_iter().fold(none, f64::max),
    }
}
