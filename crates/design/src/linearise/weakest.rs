//! The corner of the declared uncertainty that is the weakest for a steady motion.

use crate::inputs::design_file::UncertainParameter;
use auv::{Actuator, Vehicle};

/// The vehicle with each uncertain coefficient at the end of its range at which `load` is larger, the others being
/// nominal: the share of their limits that actuators take for a motion, or infinity where there is no such motion.
/// Where the effects of coefficients do not add up, another corner may be weaker.
pub(super) fn weakest(
    vehicle: &Vehicle,
    uncertain: &[UncertainParameter],
    load: impl Fn(&Vehicle) -> f64,
) -> Vehicle {
    let at_end = |of: &Vehicle, one: &UncertainParameter, sign: f64| {
        one.parameter.with_value(of, one.value + sign * one.half_range)
    };
    uncertain.iter().fold(vehicle.clone(), |corner, one| {
        let [less, more] = [-1.0, 1.0].map(|sign| load(&at_end(vehicle, one, sign)));
        at_end(&corner, one, if more >= less { 1.0 } else { -1.0 })
    })
}

/// The largest share of its limit that an actuator gives of these outputs.
pub(super) fn share(vehicle: &Vehicle, outputs: &[f64]) -> f64 {
    let of =
        |(one, output): (&Actuator, &f64)| (output / if *output < 0.0 { one.min } else { one.max }).abs();
    vehicle.actuators.iter().zip(outputs).map(of).fold(0.0, f64::max)
}
