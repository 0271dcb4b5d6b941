//! The vehicle with its uncertain coefficients: one LFT of the linear model at each speed, and one over the whole range.
//!
//! ```text
//! x' = A x + Bd wd + B u,   zd = Cd x + Ddd wd + Dd2 u,   wd = blkdiag(delta_i I_ri) zd,   |delta_i| <= 1
//! ```
//!
//! At a trim the motion is `M(c) x' = C(c) x + D(c) u` with M, C and D affine in each coefficient c, and the LFT of
//! `[A B] = M^-1 [C D]` is exact. A coefficient changes the trim, too, on which the motion depends: what that does comes
//! through further parameters, the incidence and the outputs of actuators at trim, to first order; see [`crate::uncertain_trim`].
//!
//! Source of the descriptor form: K. Zhou, J. C. Doyle, K. Glover, Robust and Optimal Control, 1996, ch. 10.

use crate::error::Error;
use crate::inputs::Inputs;
use crate::model::{Model, STATES, linearise_at, stacked};
use crate::uncertain_gradients::{Gradients, coarsen};
use crate::uncertain_pencil::{DETAIL, DETAIL_OVER_RANGE, Pencil};
use crate::uncertain_reduce::{minimal, runs};
use crate::uncertain_trim::{TrimRange, trim_range};
use auv::{Linearisation, Parameter, Trim, Vehicle};
use lpv::lft::Lft;
use lpv::matrix::Mat;
use thiserror::Error as ThisError;

/// Why there is no uncertain model.
#[derive(Debug, Clone, PartialEq, ThisError)]
pub enum UncertainError {
    /// The design has no section `[uncertainty]`, or it names nothing.
    #[error(
        "the design {design} names nothing uncertain; add a section [uncertainty], as vehicles/squid/design.toml has"
    )]
    NothingUncertain {
        /// The design.
        design: String,
    },
    /// A coefficient enters the motion otherwise than affinely.
    #[error(
        "[uncertainty]: '{name}' does not enter the equations of motion linearly (off by {off:.1e} of them over its range), so it \
         cannot be uncertain; name what it acts through, for instance 'form_factor' or 'drag_area' for friction"
    )]
    NotAffine {
        /// The coefficient.
        name: String,
        /// The relative difference.
        off: f64,
    },
    /// Three of the coefficients multiply one another.
    #[error(
        "[uncertainty]: three of the coefficients multiply one another (off by {off:.1e} of the equations of motion); name two of \
         them at most, for instance not density, form_factor and wetted_area together"
    )]
    ThreeMultiply {
        /// The relative difference.
        off: f64,
    },
    /// The vehicle is none at some corner of the ranges.
    #[error("[uncertainty]: with every coefficient at an end of its range, {reason}")]
    Corner {
        /// Why.
        reason: auv::CoefficientError,
    },
    /// The vehicle does not trim at some corner of the ranges.
    #[error("[uncertainty]: with every coefficient at an end of its range there is no trim: {reason}")]
    NoTrim {
        /// Why.
        reason: auv::TrimError,
    },
}

/// What is uncertain.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Uncertain {
    /// A coefficient, or a quantity of the trim.
    Parameter(Parameter),
    /// The gain of an actuator.
    Gain(usize),
}

impl Uncertain {
    /// Its name.
    pub fn name(self, vehicle: &Vehicle) -> String {
        match self {
            Self::Parameter(parameter) => parameter.name(vehicle),
            Self::Gain(actuator) => format!("gain of {}", vehicle.actuators[actuator].name),
        }
    }

    /// Whether it belongs to the trim, and so follows from the others.
    pub fn is_of_trim(self) -> bool {
        matches!(self, Self::Parameter(Parameter::Incidence | Parameter::Output(_)))
    }
}

/// One normalised uncertain parameter: `value + half_range delta`, |delta| <= 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Block {
    /// What.
    pub uncertain: Uncertain,
    /// Its name.
    pub name: String,
    /// Its nominal value, SI; at the middle of the range of speed for what belongs to the trim.
    pub value: f64,
    /// How far it may be off to either side, SI; as above.
    pub half_range: f64,
    /// Unit.
    pub unit: &'static str,
    /// How often it is repeated: its number of channels.
    pub repetitions: usize,
}

/// The linear model with its uncertain channels; those of the scheduling parameter, if any, stand first.
///
/// Shapes, with n = 4 states, m actuators and k channels: A n x n, B n x m, Bd n x k, Cd k x n, Ddd k x k, Dd2 k x m.
#[derive(Debug, Clone, PartialEq)]
pub struct UncertainModel {
    /// Nominal A.
    pub a: Mat,
    /// Nominal B.
    pub b: Mat,
    /// From wd to x'.
    pub bd: Mat,
    /// From x to zd.
    pub cd: Mat,
    /// From wd to zd.
    pub dd: Mat,
    /// From u to zd.
    pub dd2: Mat,
    /// Channels of the scheduling parameter rho, the first ones; none at a frozen speed.
    pub scheduled: usize,
    /// The uncertain parameters in the order of their channels; none of them has no channel.
    pub blocks: Vec<Block>,
}

impl UncertainModel {
    /// From an LFT of `[A B]` whose parameter 0 is rho and parameter 1 + i is `all[i]`.
    pub(crate) fn from_lft(lft: &Lft, all: &[Block]) -> Self {
        let mut scheduled = 0;
        let mut blocks = Vec::new();
        for (parameter, _, count) in runs(&lft.channels) {
            match parameter.checked_sub(1).and_then(|i| all.get(i)) {
                Some(block) => blocks.push(Block { repetitions: count, ..block.clone() }),
                None => scheduled = count,
            }
        }
        let split =
            |m: &Mat| (m.columns(0, STATES).into_owned(), m.columns(STATES, m.ncols() - STATES).into_owned());
        let ((a, b), (cd, dd2)) = (split(&lft.constant), split(&lft.right));
        Self { a, b, bd: lft.left.clone(), cd, dd: lft.inner.clone(), dd2, scheduled, blocks }
    }

    /// The number of channels k.
    pub fn channels(&self) -> usize {
        self.bd.ncols()
    }

    /// Repetitions: of rho first where it has channels, then of every block.
    pub fn repetitions(&self) -> Vec<usize> {
        let scheduled = (self.scheduled > 0).then_some(self.scheduled);
        scheduled.into_iter().chain(self.blocks.iter().map(|b| b.repetitions)).collect()
    }

    /// The LFT of `[A B]`: its parameters are rho, where it has channels, and then the blocks.
    pub fn lft(&self) -> Lft {
        Lft {
            constant: lpv::matrix::block(&[&[&self.a, &self.b]]),
            left: self.bd.clone(),
            inner: self.dd.clone(),
            right: lpv::matrix::block(&[&[&self.cd, &self.dd2]]),
            channels: lpv::plant::channels(&self.repetitions()),
        }
    }

    /// `[A B]` at rho (nothing where the model is of one speed) and at one delta for each block.
    ///
    /// # Errors
    /// [`Error::Lft`] where `I - Ddd Delta` is singular.
    pub fn evaluate(&self, rho: f64, delta: &[f64]) -> Result<Mat, Error> {
        let scheduled = (self.scheduled > 0).then_some(rho);
        let values: Vec<f64> = scheduled.into_iter().chain(delta.iter().copied()).collect();
        Ok(self.lft().evaluate(&values)?)
    }
}

/// The uncertain model at one speed, and what it came from.
#[derive(Debug, Clone)]
pub struct FrozenUncertain {
    /// Speed along the path, m/s.
    pub speed: f64,
    /// The nominal linearisation and its trim.
    pub nominal: Linearisation,
    /// How far the trim moves.
    pub trim_range: TrimRange,
    /// The model.
    pub model: UncertainModel,
}

/// All uncertain parameters of the design: coefficients, then what of the trim they move, then gains of actuators.
pub(crate) fn blocks(inputs: &Inputs, trim: &Trim, range: &TrimRange) -> Vec<Block> {
    let vehicle = &inputs.vehicle;
    let of = |uncertain: Uncertain, value, half_range, unit| Block {
        uncertain,
        name: uncertain.name(vehicle),
        value,
        half_range,
        unit,
        repetitions: 0,
    };
    let coefficients = inputs
        .uncertain
        .iter()
        .map(|u| of(Uncertain::Parameter(u.parameter), u.value, u.half_range, u.parameter.unit(vehicle)));
    let trims = range.deviations.iter().map(|(parameter, deviation)| {
        let value = parameter.value(vehicle, trim);
        of(Uncertain::Parameter(*parameter), value, *deviation, parameter.unit(vehicle))
    });
    let gain = inputs.design.uncertainty.as_ref().map_or(0.0, |u| u.actuator_gain);
    let actuators = if gain > 0.0 { vehicle.actuators.len() } else { 0 };
    let gains = (0..actuators).map(|actuator| of(Uncertain::Gain(actuator), 1.0, gain, "1"));
    coefficients.chain(trims).chain(gains).collect()
}

/// The uncertain model at a speed \[m/s\].
///
/// # Errors
/// [`Error::Trim`], [`Error::Uncertain`].
pub fn at_speed(inputs: &Inputs, speed: f64) -> Result<FrozenUncertain, Error> {
    let nominal = linearise_at(inputs, speed)?;
    let trim_range = trim_range(inputs, &nominal.trim)?;
    let all = something(inputs, blocks(inputs, &nominal.trim, &trim_range))?;
    let mut gradients = [Gradients::at(&inputs.vehicle, &nominal.trim, &all)?];
    coarsen(&inputs.vehicle, &all, DETAIL, &mut gradients);
    let pencil = Pencil::frozen(&gradients[0], &stacked(&nominal));
    let model = UncertainModel::from_lft(&minimal(&pencil.lft()), &all);
    Ok(FrozenUncertain { speed, nominal, trim_range, model })
}

/// The uncertain model over the range of speed: the fit of `model` at delta = 0, and the uncertain parts fitted likewise.
///
/// # Errors
/// [`Error::Trim`], [`Error::Fit`], [`Error::Uncertain`].
pub fn over_range(inputs: &Inputs, model: &Model) -> Result<UncertainModel, Error> {
    let mut ranges = Vec::new();
    for (_, nominal) in &model.grid {
        ranges.push(trim_range(inputs, &nominal.trim)?);
    }
    let moved = TrimRange::all_that_move(&ranges);
    let (mut rhos, mut gradients, mut middle) = (Vec::new(), Vec::new(), Vec::new());
    for (i, ((rho, nominal), range)) in model.grid.iter().zip(&ranges).enumerate() {
        let all = something(inputs, blocks(inputs, &nominal.trim, &range.with(&moved)))?;
        gradients.push(Gradients::at(&inputs.vehicle, &nominal.trim, &all)?);
        rhos.push(*rho);
        if i == model.grid.len() / 2 {
            middle = all;
        }
    }
    coarsen(&inputs.vehicle, &middle, DETAIL_OVER_RANGE, &mut gradients);
    let samples: Vec<(f64, Gradients)> = rhos.into_iter().zip(gradients).collect();
    let pencil = Pencil::scheduled(&inputs.vehicle, &samples, &model.lft, inputs.design.order)?;
    Ok(UncertainModel::from_lft(&minimal(&pencil.lft()), &middle))
}

fn something(inputs: &Inputs, blocks: Vec<Block>) -> Result<Vec<Block>, Error> {
    if blocks.is_empty() {
        let design = format!("{}.toml", inputs.design.name);
        return Err(UncertainError::NothingUncertain { design }.into());
    }
    Ok(blocks)
}
