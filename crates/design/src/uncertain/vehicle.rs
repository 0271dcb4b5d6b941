//! The effect of a perturbation of the uncertain model on a vehicle: its coefficients and the gains of its actuators
//! are changed, it is trimmed again and linearised.
//!
//! The model takes what belongs to the trim, the incidence, for parameters of their own, free of the coefficients. No
//! vehicle has those: its trim follows from its coefficients. So what is found in the model need not be found in any
//! vehicle.

use crate::augment::{LinearModel, augment};
use crate::check::frozen_controller;
use crate::error::Error;
use crate::inputs::design_file::DesignFile;
use crate::uncertain::frozen::FrozenUncertain;
use crate::uncertain::model::Uncertain;
use crate::uncertain::trim::retrim;
use auv::{Actuator, Linearisation, Vehicle, linearise};
use lpv::controller::Controller;
use lpv::mu::CMat;

/// The values of the parameters of a perturbation, which repeats each on its channels.
pub fn values(frozen: &FrozenUncertain, delta: &CMat) -> Vec<f64> {
    let mut top = 0;
    let value = |repetitions: usize| {
        let at = top;
        top += repetitions;
        delta[(at, at)].re
    };
    frozen.model.blocks.iter().map(|b| b.repetitions).map(value).collect()
}

/// The vehicle whose coefficients and gains are those of a perturbation, one entry a block of the model, trimmed again
/// at the same speed; `None` where there is no such vehicle, or none that trims within the limits of its actuators.
pub fn vehicle_at(vehicle: &Vehicle, frozen: &FrozenUncertain, delta: &[f64]) -> Option<Linearisation> {
    let blocks = &frozen.model.blocks;
    let (changed, trim) = retrim(vehicle, &frozen.nominal.trim, blocks, delta).ok()?;
    let mut outputs = vehicle.actuators.iter().zip(&trim.actuators);
    if !outputs.all(|(actuator, output)| (actuator.min..=actuator.max).contains(output)) {
        return None;
    }
    let mut found = linearise(&changed, &trim).ok()?;
    for (b, d) in blocks.iter().zip(delta) {
        if let Uncertain::Gain(actuator) = b.uncertain {
            found.b.column_mut(actuator).scale_mut(1.0 + b.half_range * d);
        }
    }
    Some(found)
}

/// The gain from w to z of a linearisation with the controller frozen at rho: infinite where the loop is unstable.
///
/// # Errors
/// [`ModelError::Lft`](crate::error::ModelError::Lft) where the controller is not well posed at rho.
pub fn gain(
    actuators: &[Actuator],
    file: &DesignFile,
    l: &Linearisation,
    controller: &Controller,
    rho: f64,
) -> Result<f64, Error> {
    let plant = augment(actuators, file, LinearModel::at(l, actuators))?;
    Ok(plant.close(&frozen_controller(controller, rho)?).frozen(&[])?.hinf_norm().value)
}

/// Sizes that are tried along a perturbation, and how often the first that destabilises is narrowed down.
const SIZES: u32 = 100;
const HALVED: u32 = 30;

/// The smallest size found along a perturbation, without what it has of the trim, at which the loop of the vehicle is
/// not stable, up to `farthest`: a part of the declared uncertainty. `None` when it stays stable as far as there are
/// such vehicles.
pub fn destabilised_at(
    vehicle: &Vehicle,
    frozen: &FrozenUncertain,
    delta: &[f64],
    farthest: f64,
    is_stable: impl Fn(&Linearisation) -> bool,
) -> Option<f64> {
    let largest = |most: f64, (b, d): (&crate::uncertain::model::Block, &f64)| {
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
    for _ in 0..HALVED {
        let middle = 0.5 * (low + high);
        if stable(middle)? { low = middle } else { high = middle }
    }
    Some(high)
}
