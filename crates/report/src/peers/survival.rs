//! The fraction of the declared uncertainty that a law survives in simulation.

use crate::error::Error;
use crate::peers::law::{Law, fly};
use crate::subject::Subject;
use squid_auv::Vehicle;
use squid_auv::longitudinal::PITCH;
use squid_auv::only;
use squid_design::error::UncertainError;
use squid_design::uncertain::trim::{blocks, random_corners, retrim};
use squid_design::uncertain::vehicle::gains;
use squid_flight::flight::{Course, Demand, Disturbance, Row};

/// Time of the step (s), when the transient from the nominal vehicle's trim has settled.
const STEP_TIME: f64 = 15.0;
/// End of the flight (s).
const END: f64 = 40.0;
/// A vehicle is lost if its final pitch error is above this fraction of the step.
const LOST: f64 = 0.1;

/// Vehicles in the declared box, with the gains of their actuators.
pub type Fleet = Vec<(Vehicle, Vec<f64>)>;

/// Vehicles at the vertices with all coefficients or all but one at one end, at as many random vertices, and at random
/// points of the box, for a speed (m/s). Vehicles without a trim are left out; empty without declared uncertainty.
///
/// # Errors
/// The errors of the trim; [`UncertainError::Corner`].
pub fn fleet(subject: &Subject, speed: f64, points: usize) -> Result<Fleet, Error> {
    let inputs = subject.inputs;
    let nominal = inputs.axis().at(speed)?.trim;
    let blocks = match blocks(inputs, &nominal, &[]) {
        Err(UncertainError::NothingUncertain { .. }) => return Ok(vec![]),
        found => found.map_err(squid_design::error::Error::from)?,
    };
    let n = blocks.len();
    let alone = (0..=n).map(|i| (0..n).map(|j| if i == j { 1.0 } else { -1.0 }).collect::<Vec<f64>>());
    // The digits of a number in [-1, 1] are signs.
    let digits: Vec<Vec<Vec<f64>>> = (1..=DIGITS).map(|seed| random_corners(n, points, seed)).collect();
    let point = |i: usize| -> Vec<f64> {
        (0..n)
            .map(|j| digits.iter().enumerate().map(|(k, d)| d[i][j] * 0.5f64.powi(k as i32 + 1)).sum())
            .collect()
    };
    let all = std::iter::once(vec![1.0; n]).chain(alone).chain(random_corners(n, n + 1, 1));
    let mut fleet = vec![];
    for delta in all.chain((0..points).map(point)) {
        let (vehicle, _) = match retrim(&inputs.vehicle, &nominal, &blocks, &delta) {
            Ok(found) => found,
            Err(UncertainError::NoTrim { .. }) => continue,
            Err(other) => return Err(squid_design::error::Error::from(other).into()),
        };
        fleet.push((vehicle, gains(inputs.vehicle.actuators.len(), &blocks, &delta)));
    }
    Ok(fleet)
}

/// Number of binary digits of a random number.
const DIGITS: u64 = 24;

/// The survival of a fleet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Survival {
    /// The fraction that survived.
    pub share: f64,
    /// The largest overshoot of a survivor, relative to the step.
    pub overshoot: f64,
}

/// Simulates the pitch step of the manoeuvre for a fleet at a speed (m/s). A vehicle survives if it neither diverges
/// nor surfaces, and its final error is within a tenth of the step. Vehicles without a trim are lost.
pub fn survival(subject: &Subject, law: &dyn Law, speed: f64, fleet: &Fleet) -> Survival {
    let step = subject.stored.manoeuvre.step("pitch");
    let demand = |time: f64| Demand {
        speed,
        above_trim: only(PITCH, if time + 1e-9 < STEP_TIME { 0.0 } else { step }),
        disturbance: Disturbance::default(),
    };
    let overshoot_of_survivor = |(vehicle, gains): &(Vehicle, Vec<f64>)| -> Option<f64> {
        let flight = fly(subject, law, vehicle, gains, Course { duration: END, demand }).ok()?;
        let tail: Vec<&Row> = flight.rows.iter().filter(|row| row.time > 0.9 * END).collect();
        let off = tail.iter().map(|row| row.error(PITCH).abs()).fold(0.0, f64::max);
        let survives = flight.surfacing.is_none() && !tail.is_empty() && off <= LOST * step.abs();
        let after = flight.rows.iter().filter(|row| row.time >= STEP_TIME);
        survives.then(|| after.map(|row| -row.error(PITCH) / step).fold(0.0, f64::max))
    };
    let survivors: Vec<f64> = fleet.iter().filter_map(overshoot_of_survivor).collect();
    Survival {
        share: survivors.len() as f64 / fleet.len() as f64,
        overshoot: survivors.into_iter().fold(0.0, f64::max),
    }
}
