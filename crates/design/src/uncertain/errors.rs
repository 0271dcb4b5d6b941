//! The errors of an uncertain model against the vehicle, at corners of the box of coefficients.

use crate::error::Error;
use crate::inputs::Inputs;
use crate::linearise::{scaled, stacked};
use crate::uncertain::frozen::FrozenUncertain;
use crate::uncertain::model::{Block, Uncertain, UncertainModel};
use crate::uncertain::trim::{random_corners, retrim};
use crate::uncertain::vehicle::with_gains;
use auv::{Trim, Vehicle, linearise_with};
use lpv::matrix::Mat;

/// Corners of the box at which the models are compared.
const CORNERS: usize = 40;

/// Distances of `[A B]`, relative to `[A B]` of the vehicle at the same corner: Frobenius norms with inputs in units
/// of their reach, the largest over the corners.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ModelErrors {
    /// The nominal vehicle from the vehicle trimmed again: how much is uncertain at all.
    pub movement: f64,
    /// The vehicle with the nominal trim held from the vehicle trimmed again: how much of that comes through the trim.
    pub through_trim: f64,
    /// The model from the vehicle with the nominal trim held.
    pub at_held_trim: f64,
    /// The model, its parameters of the trim where the new trim puts them, from the vehicle trimmed again.
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

/// The deltas of a model for the coefficients at `point`, as fractions of their half ranges: those of the trim are what
/// `of_trim` makes of the move to the trim of the changed vehicle. A parameter that the model does without has none.
fn deltas(
    vehicle: &Vehicle,
    frozen: &FrozenUncertain,
    model: &UncertainModel,
    (changed, moved, point): (&Vehicle, &Trim, &[f64]),
    of_trim: impl Fn(f64) -> f64,
) -> Vec<f64> {
    let delta = |b: &Block| {
        let Some(i) = frozen.parameters.iter().position(|a| a.uncertain == b.uncertain) else { return 0.0 };
        match b.uncertain {
            Uncertain::Parameter(p) if b.uncertain.is_of_trim() => {
                let move_ = p.value(changed, moved) - p.value(vehicle, &frozen.nominal.trim);
                of_trim(move_ / frozen.parameters[i].half_range)
            }
            _ => point[i],
        }
    };
    model.blocks.iter().map(delta).collect()
}

/// Compares a model with the vehicle at a speed.
///
/// # Errors
/// [`ModelError::Lft`](crate::error::ModelError::Lft), [`Error::Uncertain`].
pub fn errors(
    inputs: &Inputs,
    frozen: &FrozenUncertain,
    model: &UncertainModel,
) -> Result<ModelErrors, Error> {
    let (vehicle, rho) = (&inputs.vehicle, inputs.design.rho(frozen.speed));
    let (trim, depth) = (&frozen.nominal.trim, frozen.nominal.has_depth());
    let relative = |found: &Mat, wanted: &Mat| {
        let norm = |stacked: Mat| scaled(&vehicle.actuators, stacked).norm();
        norm(found - wanted) / norm(wanted.clone())
    };
    let nominal = stacked(&frozen.nominal);
    let mut worst = ModelErrors::default();
    for corner in random_corners(frozen.parameters.len(), CORNERS, 2) {
        let (changed, moved) = retrim(vehicle, trim, &frozen.parameters, &corner)?;
        let truth = |trim: &Trim| -> Result<Mat, Error> {
            let l = linearise_with(&changed, trim, depth)?;
            Ok(stacked(&with_gains(l, &frozen.parameters, &corner)))
        };
        let model_at = |of_trim: fn(f64) -> f64| {
            model.evaluate(rho, &deltas(vehicle, frozen, model, (&changed, &moved, &corner), of_trim))
        };
        let (held, retrimmed) = (truth(trim)?, truth(&moved)?);
        worst = worst.or(ModelErrors {
            movement: relative(&nominal, &retrimmed),
            through_trim: relative(&held, &retrimmed),
            at_held_trim: relative(&model_at(|_| 0.0)?, &held),
            remainder: relative(&model_at(|move_| move_)?, &retrimmed),
        });
    }
    Ok(worst)
}

/// What a model misses of `[A B]` of the vehicle with its coefficients at `point`, trimmed again: the model's
/// parameters of the trim are where the new trim puts them, as far as `share` of their ranges goes.
///
/// # Errors
/// [`ModelError::Lft`](crate::error::ModelError::Lft), [`Error::Uncertain`].
pub fn missing(
    inputs: &Inputs,
    frozen: &FrozenUncertain,
    model: &UncertainModel,
    (point, share): (&[f64], f64),
) -> Result<Mat, Error> {
    let (vehicle, all) = (&inputs.vehicle, &frozen.parameters);
    let (changed, moved) = retrim(vehicle, &frozen.nominal.trim, all, point)?;
    let delta = deltas(vehicle, frozen, model, (&changed, &moved, point), |move_| move_.clamp(-share, share));
    let truth = with_gains(linearise_with(&changed, &moved, frozen.nominal.has_depth())?, all, point);
    Ok(stacked(&truth) - model.evaluate(inputs.design.rho(frozen.speed), &delta)?)
}
