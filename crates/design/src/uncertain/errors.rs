//! The errors of an uncertain model against the vehicle, at corners of the box of coefficients.

use crate::error::Error;
use crate::linearise::{scaled, stacked};
use crate::uncertain::frozen::FrozenUncertain;
use crate::uncertain::model::{Block, Uncertain, UncertainModel};
use crate::uncertain::trim::{random_corners, retrim};
use auv::{Vehicle, linearise_with};
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

/// `[A B]` of the vehicle at one corner of the box, and what a model makes of it.
struct Compared {
    /// With the nominal trim held, and trimmed again.
    held: Mat,
    retrimmed: Mat,
    /// The model, likewise.
    model_held: Mat,
    model_retrimmed: Mat,
}

fn compare(
    vehicle: &Vehicle,
    frozen: &FrozenUncertain,
    model: &UncertainModel,
    rho: f64,
    corner: &[f64],
) -> Result<Compared, Error> {
    let (trim, depth) = (&frozen.nominal.trim, frozen.nominal.has_depth());
    let all = &frozen.parameters;
    let (changed, moved) = retrim(vehicle, trim, all, corner)?;
    // Where the corner and its trim lie in the ranges; parameters that the model has none of have no place.
    let place = |b: &Block, through_trim: bool| {
        let Some(i) = all.iter().position(|a| a.uncertain == b.uncertain) else { return 0.0 };
        match b.uncertain {
            Uncertain::Parameter(p) if b.uncertain.is_of_trim() => {
                let move_ = p.value(&changed, &moved) - p.value(vehicle, trim);
                if through_trim { move_ / all[i].half_range } else { 0.0 }
            }
            _ => corner[i],
        }
    };
    let value = |through_trim: bool| {
        let delta: Vec<f64> = model.blocks.iter().map(|b| place(b, through_trim)).collect();
        model.evaluate(rho, &delta)
    };
    Ok(Compared {
        held: with_gains(stacked(&linearise_with(&changed, trim, depth)?), all, corner),
        retrimmed: with_gains(stacked(&linearise_with(&changed, &moved, depth)?), all, corner),
        model_held: value(false)?,
        model_retrimmed: value(true)?,
    })
}

/// Compares a model, at rho where it is scheduled, with the vehicle at a speed.
///
/// # Errors
/// [`ModelError::Lft`](crate::error::ModelError::Lft), [`Error::Uncertain`].
pub fn errors(
    vehicle: &Vehicle,
    frozen: &FrozenUncertain,
    model: &UncertainModel,
    rho: f64,
) -> Result<ModelErrors, Error> {
    let nominal = stacked(&frozen.nominal);
    let mut worst = ModelErrors::default();
    for corner in random_corners(frozen.parameters.len(), CORNERS, 2) {
        let c = compare(vehicle, frozen, model, rho, &corner)?;
        let relative = |found: &Mat, wanted: &Mat| {
            let norm = |stacked: Mat| scaled(&vehicle.actuators, stacked).norm();
            norm(found - wanted) / norm(wanted.clone())
        };
        worst = worst.or(ModelErrors {
            movement: relative(&nominal, &c.retrimmed),
            through_trim: relative(&c.held, &c.retrimmed),
            at_held_trim: relative(&c.model_held, &c.held),
            remainder: relative(&c.model_retrimmed, &c.retrimmed),
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
    vehicle: &Vehicle,
    frozen: &FrozenUncertain,
    model: &UncertainModel,
    rho: f64,
    (point, share): (&[f64], f64),
) -> Result<Mat, Error> {
    let (trim, all) = (&frozen.nominal.trim, &frozen.parameters);
    let (changed, moved) = retrim(vehicle, trim, all, point)?;
    let place = |b: &Block| {
        let Some(i) = all.iter().position(|a| a.uncertain == b.uncertain) else { return 0.0 };
        match b.uncertain {
            Uncertain::Parameter(p) if b.uncertain.is_of_trim() => {
                let move_ = p.value(&changed, &moved) - p.value(vehicle, trim);
                (move_ / all[i].half_range).clamp(-share, share)
            }
            _ => point[i],
        }
    };
    let delta: Vec<f64> = model.blocks.iter().map(place).collect();
    let depth = frozen.nominal.has_depth();
    let truth = with_gains(stacked(&linearise_with(&changed, &moved, depth)?), all, point);
    Ok(truth - model.evaluate(rho, &delta)?)
}

/// A ball of `[A B]`: `E Delta F` with any `||Delta|| <= 1`, complex and full.
#[derive(Debug, Clone, PartialEq)]
pub struct Remainder {
    /// E, n x p; p = n + m.
    pub left: Mat,
    /// F, p x (n + m).
    pub right: Mat,
}

/// The ball around a model at one speed that contains the vehicle trimmed again at corners of the box, widened by half.
///
/// Row i of what the model misses is at most e_i, in units of states and of the actuators' reach; E has `sqrt(3) e_i`
/// on its diagonal, because three rows may be off at once (theta' = q is exact), or four with the depth, and F takes
/// states and inputs to those units.
///
/// # Errors
/// [`ModelError::Lft`](crate::error::ModelError::Lft), [`Error::Uncertain`].
pub fn remainder(vehicle: &Vehicle, frozen: &FrozenUncertain) -> Result<Remainder, Error> {
    let states = frozen.nominal.states.len();
    let size = states + vehicle.actuators.len();
    let mut rows = vec![0.0_f64; states];
    for corner in random_corners(frozen.parameters.len(), CORNERS, 2) {
        let c = compare(vehicle, frozen, &frozen.model, 0.0, &corner)?;
        let off = scaled(&vehicle.actuators, c.model_retrimmed - c.retrimmed);
        rows.iter_mut().zip(off.row_iter()).for_each(|(most, row)| *most = most.max(row.norm()));
    }
    let at_once = if frozen.nominal.has_depth() { 4f64 } else { 3f64 };
    let reach = vehicle.actuators.iter().map(auv::Actuator::reach);
    let units: Vec<f64> = std::iter::repeat_n(1.0, states).chain(reach.map(|r| 1.0 / r)).collect();
    Ok(Remainder {
        left: Mat::from_fn(states, size, |i, j| if i == j { WIDER * at_once.sqrt() * rows[i] } else { 0.0 }),
        right: Mat::from_diagonal(&nalgebra::DVector::from_vec(units)),
    })
}

/// How much larger than measured the remainder is taken.
const WIDER: f64 = 1.5;

/// `[A B]` with the gains of the actuators at their deltas.
fn with_gains(mut stacked: Mat, all: &[Block], delta: &[f64]) -> Mat {
    let states = stacked.nrows();
    for (b, d) in all.iter().zip(delta) {
        if let Uncertain::Gain(actuator) = b.uncertain {
            stacked.column_mut(states + actuator).scale_mut(1.0 + b.half_range * d);
        }
    }
    stacked
}
