//! Effect of a perturbation of the uncertain model on a vehicle: the coefficients and the actuator gains are changed,
//! and the vehicle is retrimmed and linearised.
//!
//! In the model the quantities of the trim, such as the incidence, are parameters that are independent of the
//! coefficients. In a vehicle the trim follows from the coefficients, so a perturbation of the model need not
//! correspond to any vehicle.

use crate::augment::{LinearModel, augment};
use crate::axis::Linearisation;
use crate::check::frozen_controller;
use crate::error::Error;
use crate::inputs::Inputs;
use crate::uncertain::frozen::FrozenUncertain;
use crate::uncertain::model::{Block, Uncertain};
use crate::uncertain::trim::retrim;
use squid_auv::{Vehicle, linearise_with};
use squid_lpv::controller::Controller;
use squid_lpv::mu::CMat;

/// Returns the parameter values of a perturbation, which repeats each on its channels.
pub fn values(frozen: &FrozenUncertain, delta: &CMat) -> Vec<f64> {
    let mut top = 0;
    let value = |repetitions: usize| {
        let at = top;
        top += repetitions;
        delta[(at, at)].re
    };
    frozen.model.blocks.iter().map(|b| b.repetitions).map(value).collect()
}

/// Returns the vehicle with the coefficients and gains of a perturbation, one entry per block of the model, retrimmed
/// at the same speed; `None` if there is no such vehicle, or it has no trim within its actuator limits.
pub fn vehicle_at(vehicle: &Vehicle, frozen: &FrozenUncertain, delta: &[f64]) -> Option<Linearisation> {
    let blocks = &frozen.model.blocks;
    let (changed, trim) = retrim(vehicle, &frozen.nominal.trim, blocks, delta).ok()?;
    let mut outputs = vehicle.actuators.iter().zip(&trim.actuators);
    if !outputs.all(|(actuator, output)| (actuator.min..=actuator.max).contains(output)) {
        return None;
    }
    let mut linearisation = linearise_with(&changed, &trim, frozen.nominal.states).ok()?;
    linearisation.by_waves.clone_from(&frozen.nominal.by_waves);
    Some(Linearisation::of(&with_gains(linearisation, blocks, delta), &vehicle.actuators))
}

/// Scales the inputs of a linearisation by the gains of the actuators at their deltas.
pub(crate) fn with_gains(
    mut l: squid_auv::Linearisation,
    blocks: &[Block],
    delta: &[f64],
) -> squid_auv::Linearisation {
    let gains = gains(l.b.ncols(), blocks, delta);
    l.b.column_iter_mut().zip(gains).for_each(|(mut column, gain)| column.scale_mut(gain));
    l
}

/// Returns the output of each of `actuators` actuators relative to its command.
pub fn gains(actuators: usize, blocks: &[Block], delta: &[f64]) -> Vec<f64> {
    let mut gains = vec![1.0; actuators];
    for (b, d) in blocks.iter().zip(delta) {
        if let Uncertain::Gain(actuator) = b.uncertain {
            gains[actuator] += b.half_range * d;
        }
    }
    gains
}

/// Returns the gain from w to z of a linearisation with the controller frozen at rho; infinite if the loop is unstable.
///
/// # Errors
/// [`ModelError::System`](crate::error::ModelError::System) if the controller is not well posed at rho.
pub fn gain(inputs: &Inputs, l: &Linearisation, controller: &Controller) -> Result<f64, Error> {
    let (actuators, file) = (&inputs.vehicle.actuators, &inputs.design);
    let rho = file.rho(l.trim.speed);
    let plant = augment(actuators, &file.with_unweighted_references(), LinearModel::at(l, file))?;
    Ok(plant.close(&frozen_controller(controller, rho)?).frozen(&[])?.hinf_norm().value)
}

/// Number of sizes tried along a perturbation, and of bisections for the first that destabilises.
const SIZES: u32 = 100;
const BISECTIONS: u32 = 30;

/// Returns the smallest size found along a perturbation, as a fraction of the declared uncertainty up to `farthest`, at
/// which the loop of the vehicle is unstable. The size does not include parameters of the trim. `None` if the loop is
/// stable for all such vehicles that exist.
pub fn destabilised_at(
    vehicle: &Vehicle,
    frozen: &FrozenUncertain,
    delta: &[f64],
    farthest: f64,
    is_stable: impl Fn(&Linearisation) -> bool,
) -> Option<f64> {
    let largest = |most: f64, (b, d): (&Block, &f64)| {
        if b.uncertain.is_of_trim() { most } else { most.max(d.abs()) }
    };
    let unit = frozen.model.blocks.iter().zip(delta).fold(0.0, largest);
    let stable = |size: f64| {
        let scaled: Vec<f64> = delta.iter().map(|d| d * size / unit).collect();
        vehicle_at(vehicle, frozen, &scaled).map(|l| is_stable(&l))
    };
    let size = |k: u32| farthest * f64::from(k) / f64::from(SIZES);
    let first =
        (1..=SIZES).map_while(|k| stable(size(k)).map(|found| (k, found))).find(|(_, found)| !found)?.0;
    let (mut low, mut high) = (size(first - 1), size(first));
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        if stable(middle)? { low = middle } else { high = middle }
    }
    Some(high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inputs::tests::shipped;
    use crate::uncertain::frozen::at_speed;
    use squid_auv::{Dynamics, Motion, actuator_force};

    const SPEED: f64 = 1.3;

    /// Squid, its uncertain model, and a perturbation: fractions of the half ranges by name.
    fn squid(changes: &[(&str, f64)]) -> (Vehicle, FrozenUncertain, Vec<f64>) {
        let inputs = shipped("squid", "design");
        let frozen = at_speed(&inputs, SPEED).unwrap();
        let mut delta = vec![0.0; frozen.model.blocks.len()];
        for (name, change) in changes {
            delta[frozen.model.blocks.iter().position(|b| b.name == *name).unwrap()] = *change;
        }
        (inputs.vehicle, frozen, delta)
    }

    /// Central differences of the nonlinear motion, with manually changed coefficients, give the same linearisation.
    #[test]
    fn vehicle_is_linearised_with_perturbation_at_its_own_trim() {
        let (vehicle, frozen, delta) = squid(&[
            ("M_uw", 0.5),
            ("Z_w", -0.8),
            ("drag_area", 1.0),
            ("gain of lower", -0.6),
            ("incidence", 0.9),
        ]);
        let found = vehicle_at(&vehicle, &frozen, &delta).unwrap();

        let mut by_hand = vehicle.coefficients.clone();
        // An increase of a negative value is towards zero.
        by_hand.M_uw *= 1.0 - 0.3 * 0.5;
        by_hand.Z_w *= 1.0 + 0.7 * 0.8;
        by_hand.drag_area *= 1.3;
        let dynamics = Dynamics::new(&by_hand).unwrap();
        let trim = &found.trim;
        let [theta, u, depth, q, w] = std::array::from_fn(|index| trim.signals[index]);
        let start = [u, w, q, theta];
        let start: Vec<f64> = start.into_iter().chain(trim.actuators.iter().copied()).collect();
        let rate = |at: &[f64]| {
            let motion = Motion::in_plane(at[0], at[1], at[2], at[3]);
            let force = actuator_force(&vehicle.actuators, at[0], at[4..].iter().copied());
            dynamics.rate(&motion, depth, 0.0, force)
        };
        assert!(rate(&start).iter().all(|v| v.abs() < 1e-9), "no trim: {:?}", rate(&start));
        assert!((start[0].hypot(start[1]) - SPEED).abs() < 1e-9);
        assert!((w - frozen.nominal.trim.heave).abs() > 1e-4, "the trim should move");
        for j in 0..start.len() {
            let step = 1e-7 * start[j].abs().max(1.0);
            let moved = |by: f64| {
                let mut at = start.clone();
                at[j] += by;
                rate(&at)
            };
            let (high, low) = (moved(step), moved(-step));
            let factor = if j == 4 { 1.0 - 0.1 * 0.6 } else { 1.0 };
            for i in 0..4 {
                let expected = factor * (high[i] - low[i]) / (2.0 * step);
                let entry = if j < 4 { found.a[(i, j)] } else { found.b[(i, j - 4)] };
                assert!(
                    (entry - expected).abs() < 1e-6 * expected.abs().max(1.0),
                    "{i} {j}: {entry} {expected}"
                );
            }
        }
    }

    #[test]
    fn no_vehicle_beyond_actuator_limits() {
        let (mut vehicle, frozen, delta) = squid(&[("drag_area", 1.0)]);
        assert!(vehicle_at(&vehicle, &frozen, &delta).is_some());
        let most = frozen.nominal.trim.actuators[0];
        (vehicle.actuators[0].min, vehicle.actuators[0].max) = (-most.abs(), most.abs());
        assert!(vehicle_at(&vehicle, &frozen, &vec![0.0; delta.len()]).is_some());
        assert!(vehicle_at(&vehicle, &frozen, &delta).is_none(), "more drag takes more thrust");
    }

    /// The thrust is below 96.5 % above a size of 0.35 along a thrust loss of 10 %; the incidence does not affect the
    /// size.
    #[test]
    fn finds_first_unstable_size() {
        let (vehicle, frozen, delta) = squid(&[("gain of lower", -0.5), ("incidence", 2.0)]);
        let enough = |l: &Linearisation| l.b[(0, 0)] / frozen.nominal.b[(0, 0)] > 0.965;
        let found = destabilised_at(&vehicle, &frozen, &delta, 1.0, enough).unwrap();
        assert!((found - 0.35).abs() < 1e-9, "{found}");
        assert_eq!(destabilised_at(&vehicle, &frozen, &delta, 0.34, enough), None);
    }
}
