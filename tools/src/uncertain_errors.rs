//! How well an uncertain model stands for the vehicle: compared at corners of the box of coefficients.

use crate::error::Error;
use crate::inputs::Inputs;
use crate::model::{STATES, stacked};
use crate::uncertain::{Block, FrozenUncertain, Uncertain, UncertainModel, blocks};
use crate::uncertain_trim::{random_corners, retrim};
use auv::linearise;
use lpv::matrix::Mat;

/// Corners of the box at which the models are compared.
const CORNERS: usize = 40;

/// Distances of `[A B]`, relative to `[A B]` of the vehicle at the same corner: Frobenius norms with inputs in units of their
/// reach, the largest over the corners.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ModelErrors {
    /// The nominal vehicle from the vehicle trimmed anew: how much is uncertain at all.
    pub movement: f64,
    /// The vehicle with the nominal trim held from the vehicle trimmed anew: how much of that comes through the trim.
    pub through_trim: f64,
    /// The model from the vehicle with the nominal trim held.
    pub at_held_trim: f64,
    /// The model, its parameters of the trim where the new trim puts them, from the vehicle trimmed anew.
    pub remainder: f64,
}

impl ModelErrors {
    /// The larger of each.
    pub fn or(self, other: Self) -> Self {
        Self {
            movement: self.movement.max(other.movement),
            through_trim: self.through_trim.max(other.through_trim),
            at_held_trim: self.at_held_trim.max(other.at_held_trim),
            remainder: self.remainder.max(other.remainder),
        }
    }
}

/// Compares a model, at rho where it is scheduled, with the vehicle at a speed.
///
/// # Errors
/// [`Error::Lft`], [`Error::Uncertain`].
pub fn errors(
    inputs: &Inputs,
    frozen: &FrozenUncertain,
    model: &UncertainModel,
    rho: f64,
) -> Result<ModelErrors, Error> {
    let trim = &frozen.nominal.trim;
    let all = blocks(inputs, trim, &frozen.trim_range);
    let nominal = stacked(&frozen.nominal);
    let mut worst = ModelErrors::default();
    for corner in random_corners(all.len(), CORNERS) {
        let (changed, moved) = retrim(&inputs.vehicle, trim, &all, &corner)?;
        let held = with_gains(stacked(&linearise(&changed, trim)?), &all, &corner);
        let truth = with_gains(stacked(&linearise(&changed, &moved)?), &all, &corner);
        // Where the corner and its trim lie in the ranges; parameters that the model has none of have no place.
        let place = |b: &Block, through_trim: bool| {
            let Some(i) = all.iter().position(|a| a.uncertain == b.uncertain) else { return 0.0 };
            match b.uncertain {
                Uncertain::Parameter(p) if b.uncertain.is_of_trim() => {
                    let move_ = p.value(&changed, &moved) - p.value(&inputs.vehicle, trim);
                    if through_trim { move_ / all[i].half_range } else { 0.0 }
                }
                _ => corner[i],
            }
        };
        let value = |through_trim: bool| {
            let delta: Vec<f64> = model.blocks.iter().map(|b| place(b, through_trim)).collect();
            model.evaluate(rho, &delta)
        };
        let relative = |found: &Mat, wanted: &Mat| {
            scaled(inputs, &(found - wanted)).norm() / scaled(inputs, wanted).norm()
        };
        worst = worst.or(ModelErrors {
            movement: relative(&nominal, &truth),
            through_trim: relative(&held, &truth),
            at_held_trim: relative(&value(false)?, &held),
            remainder: relative(&value(true)?, &truth),
        });
    }
    Ok(worst)
}

/// `[A B]` with the gains of the actuators at their deltas.
fn with_gains(mut stacked: Mat, all: &[Block], delta: &[f64]) -> Mat {
    for (b, d) in all.iter().zip(delta) {
        if let Uncertain::Gain(actuator) = b.uncertain {
            stacked.column_mut(STATES + actuator).scale_mut(1.0 + b.half_range * d);
        }
    }
    stacked
}

/// `[A B]` with inputs in units of their reach.
fn scaled(inputs: &Inputs, stacked: &Mat) -> Mat {
    let mut out = stacked.clone();
    for (j, actuator) in inputs.vehicle.actuators.iter().enumerate() {
        out.column_mut(STATES + j).scale_mut(actuator.reach());
    }
    out
}
