//! Errors of an uncertain model against the vehicle, at corners of the box of coefficients.

use crate::error::Error;
use crate::inputs::Inputs;
use crate::linearise::{scaled, stacked};
use crate::uncertain::frozen::FrozenUncertain;
use crate::uncertain::model::{Block, Uncertain, UncertainModel};
use crate::uncertain::trim::{random_corners, retrim};
use crate::uncertain::vehicle::with_gains;
use squid_auv::{Linearisation, Trim, Vehicle, linearise_with};
use squid_lpv::matrix::Mat;

/// Number of corners of the box at which the models are compared.
const CORNERS: usize = 40;

/// Relative distances of `[A B]` from that of the vehicle at the same corner: Frobenius norms with inputs in units of
/// their reach, the largest over the corners.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ModelErrors {
    /// Distance of the nominal vehicle from the retrimmed vehicle: the total effect of the uncertainty.
    pub movement: f64,
    /// Distance of the vehicle held at the nominal trim from the retrimmed vehicle: the effect through the trim.
    pub through_trim: f64,
    /// Distance of the model from the vehicle held at the nominal trim.
    pub at_held_trim: f64,
    /// Distance of the model, with its trim parameters set to the new trim, from the retrimmed vehicle.
    pub remainder: f64,
}

impl ModelErrors {
    /// Returns the elementwise maximum.
    pub fn max(self, other: Self) -> Self {
        Self {
            movement: self.movement.max(other.movement),
            through_trim: self.through_trim.max(other.through_trim),
            at_held_trim: self.at_held_trim.max(other.at_held_trim),
            remainder: self.remainder.max(other.remainder),
        }
    }
}

/// Vehicle with the coefficients at a point, as fractions of their half ranges, and its trim.
struct Retrimmed<'a> {
    vehicle: &'a Vehicle,
    trim: &'a Trim,
    point: &'a [f64],
}

/// Returns the deltas of a model for a retrimmed vehicle. Those of the trim are `of_trim` of its change relative to the
/// half range; a parameter of the model that is not uncertain at this speed is at 0.
fn deltas(
    vehicle: &Vehicle,
    frozen: &FrozenUncertain,
    model: &UncertainModel,
    retrimmed: &Retrimmed<'_>,
    of_trim: impl Fn(f64) -> f64,
) -> Vec<f64> {
    let delta = |b: &Block| {
        let Some(i) = frozen.parameters.iter().position(|a| a.uncertain == b.uncertain) else { return 0.0 };
        match b.uncertain {
            Uncertain::Parameter(p) if b.uncertain.is_of_trim() => {
                let change =
                    p.value(retrimmed.vehicle, retrimmed.trim) - p.value(vehicle, &frozen.nominal.trim);
                of_trim(change / frozen.parameters[i].half_range)
            }
            _ => retrimmed.point[i],
        }
    };
    model.blocks.iter().map(delta).collect()
}

/// Compares a model with the vehicle at a speed.
///
/// # Errors
/// [`ModelError::System`](crate::error::ModelError::System), [`Error::Uncertain`].
pub fn errors(
    inputs: &Inputs,
    frozen: &FrozenUncertain,
    model: &UncertainModel,
) -> Result<ModelErrors, Error> {
    let (vehicle, rho) = (&inputs.vehicle, inputs.design.rho(frozen.speed));
    let (trim, states) = (&frozen.nominal.trim, frozen.nominal.states);
    let relative = |found: &Mat, expected: &Mat| {
        let norm = |stacked: Mat| scaled(&vehicle.actuators, stacked).norm();
        norm(found - expected) / norm(expected.clone())
    };
    let stacked = |l: &Linearisation| stacked(&l.a, &l.b);
    let nominal = stacked(&frozen.nominal);
    let mut worst = ModelErrors::default();
    for corner in random_corners(frozen.parameters.len(), CORNERS, 2) {
        let (changed, moved) = retrim(vehicle, trim, &frozen.parameters, &corner)?;
        let truth = |trim: &Trim| -> Result<Mat, Error> {
            let l = linearise_with(&changed, trim, states)?;
            Ok(stacked(&with_gains(l, &frozen.parameters, &corner)))
        };
        let model_at = |of_trim: fn(f64) -> f64| {
            let changed = Retrimmed { vehicle: &changed, trim: &moved, point: &corner };
            model.evaluate(rho, &deltas(vehicle, frozen, model, &changed, of_trim))
        };
        let (held, retrimmed) = (truth(trim)?, truth(&moved)?);
        worst = worst.max(ModelErrors {
            movement: relative(&nominal, &retrimmed),
            through_trim: relative(&held, &retrimmed),
            at_held_trim: relative(&model_at(|_| 0.0)?, &held),
            remainder: relative(&model_at(|change| change)?, &retrimmed),
        });
    }
    Ok(worst)
}

/// Returns the error of a model in `[A B]` against the retrimmed vehicle with its coefficients at `point`. The model's
/// trim parameters are set to the new trim, within `share` of their ranges.
///
/// # Errors
/// [`ModelError::System`](crate::error::ModelError::System), [`Error::Uncertain`].
pub fn model_error(
    inputs: &Inputs,
    frozen: &FrozenUncertain,
    model: &UncertainModel,
    point: &[f64],
    share: f64,
) -> Result<Mat, Error> {
    let (vehicle, all) = (&inputs.vehicle, &frozen.parameters);
    let (changed, moved) = retrim(vehicle, &frozen.nominal.trim, all, point)?;
    let retrimmed = Retrimmed { vehicle: &changed, trim: &moved, point };
    let delta = deltas(vehicle, frozen, model, &retrimmed, |change| change.clamp(-share, share));
    let truth = with_gains(linearise_with(&changed, &moved, frozen.nominal.states)?, all, point);
    Ok(stacked(&truth.a, &truth.b) - model.evaluate(inputs.design.rho(frozen.speed), &delta)?)
}
