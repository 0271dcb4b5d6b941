//! How far uncertain coefficients move the trim.
//!
//! The linear motion depends on the trim through the incidence, and through the deflection of control surfaces
//! (thrusts at trim do not enter A and B). Both become parameters of the uncertain model, with the range that
//! trimming again at corners of the box of coefficients gives. They are taken to be independent of the coefficients,
//! which covers more than can happen.

use crate::error::Error;
use crate::error::UncertainError;
use crate::inputs::Inputs;
use crate::uncertain::gradients::perturbed;
use crate::uncertain::model::{Block, Uncertain};
use auv::{Descriptor, Linearisation, Parameter, Speed, Trim, TrimError, Vehicle, trim_with};

/// Corners of the box at which the vehicle is trimmed, beside those to which each coefficient alone points.
const RANDOM_CORNERS: usize = 48;

/// Limits of actuators are widened by this, so that a corner beyond them is measured and not refused.
const WIDENED: f64 = 1e3;

/// Moves of the trim smaller than this (rad, or N) count as zero.
const STILL: f64 = 1e-9;

/// How far the trim moves over the box of coefficients.
#[derive(Debug, Clone, PartialEq)]
pub struct TrimRange {
    /// The quantities of the trim on which A and B depend and that move, with the farthest move.
    pub deviations: Vec<(Parameter, f64)>,
    /// Corners at which the vehicle was trimmed.
    pub corners: usize,
    /// Among them, those at which an actuator would have to go beyond its limits.
    pub beyond_limits: usize,
}

impl TrimRange {
    /// The quantities that move at any of the trims, with no move.
    pub(crate) fn all_that_move(ranges: &[Self]) -> Vec<Parameter> {
        let mut out = Vec::new();
        for (parameter, _) in ranges.iter().flat_map(|r| &r.deviations) {
            if !out.contains(parameter) {
                out.push(*parameter);
            }
        }
        out
    }

    /// The farthest moves of these quantities; 0 for those that do not move here.
    pub(crate) fn of(&self, parameters: &[Parameter]) -> Vec<(Parameter, f64)> {
        let of = |p: &Parameter| self.deviations.iter().find(|(q, _)| q == p).map_or(0.0, |(_, d)| *d);
        parameters.iter().map(|p| (*p, of(p))).collect()
    }
}

/// All uncertain parameters of the design: coefficients, then what of the trim they move and how far, then gains of
/// actuators.
///
/// # Errors
/// [`UncertainError::NothingUncertain`].
pub fn blocks(
    inputs: &Inputs,
    trim: &Trim,
    deviations: &[(Parameter, f64)],
) -> Result<Vec<Block>, UncertainError> {
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
    let trims = deviations.iter().map(|(parameter, deviation)| {
        let value = parameter.value(vehicle, trim);
        of(Uncertain::Parameter(*parameter), value, *deviation, parameter.unit(vehicle))
    });
    let gain = inputs.actuator_gain();
    let actuators = if gain > 0.0 { vehicle.actuators.len() } else { 0 };
    let gains = (0..actuators).map(|actuator| of(Uncertain::Gain(actuator), 1.0, gain, "1"));
    let all: Vec<Block> = coefficients.chain(trims).chain(gains).collect();
    if all.is_empty() {
        let design = inputs.design.file.clone();
        return Err(UncertainError::NothingUncertain { design });
    }
    Ok(all)
}

/// Trims the vehicle with its coefficients at `delta`, at the speed and depth of a trim, as if actuators had no limits.
///
/// # Errors
/// [`UncertainError::NoTrim`], [`UncertainError::Corner`].
pub fn retrim(
    vehicle: &Vehicle,
    nominal: &Trim,
    blocks: &[Block],
    delta: &[f64],
) -> Result<(Vehicle, Trim), UncertainError> {
    let changed = perturbed(vehicle, blocks, delta);
    let mut free = changed.clone();
    for actuator in &mut free.actuators {
        actuator.min *= WIDENED;
        actuator.max *= WIDENED;
    }
    let retrimmed = trim_with(&free, Speed::Path(nominal.speed), nominal.depth, &nominal.rule);
    let retrimmed = retrimmed.map_err(|reason| match reason {
        TrimError::Coefficients(reason) => UncertainError::Corner { reason },
        reason => UncertainError::NoTrim { reason },
    })?;
    Ok((changed, retrimmed))
}

/// Trims at corners of the box: each coefficient alone at its ends, all of them where the incidence and each
/// deflection move farthest by that, and random corners.
///
/// # Errors
/// [`UncertainError::NothingUncertain`], [`UncertainError::NoTrim`], [`UncertainError::Corner`].
pub fn trim_range(inputs: &Inputs, linear: &Linearisation) -> Result<TrimRange, Error> {
    let (vehicle, nominal) = (&inputs.vehicle, &linear.trim);
    let mut range = TrimRange { deviations: Vec::new(), corners: 0, beyond_limits: 0 };
    let all = blocks(inputs, nominal, &[])?;
    let outputs = (0..vehicle.actuators.len()).map(Parameter::Output);
    let matters = |p: &Parameter| {
        Descriptor::derivative(vehicle, nominal, linear.has_depth(), *p).stacked().amax() > 0.0
    };
    let quantities: Vec<Parameter> =
        std::iter::once(Parameter::Incidence).chain(outputs).filter(matters).collect();
    let mut farthest = vec![0.0_f64; quantities.len()];
    let mut visit = |delta: &[f64]| -> Result<Vec<f64>, UncertainError> {
        let (changed, found) = retrim(vehicle, nominal, &all, delta)?;
        let moves: Vec<f64> =
            quantities.iter().map(|p| p.value(&changed, &found) - p.value(vehicle, nominal)).collect();
        farthest.iter_mut().zip(&moves).for_each(|(most, move_)| *most = most.max(move_.abs()));
        let pairs = || vehicle.actuators.iter().zip(&found.actuators);
        range.corners += 1;
        range.beyond_limits += usize::from(pairs().any(|(a, output)| !(a.min..=a.max).contains(output)));
        Ok(moves)
    };
    let mut uphill = vec![vec![0.0; all.len()]; quantities.len()];
    for i in 0..all.len() {
        let mut delta = vec![0.0; all.len()];
        for end in [-1.0, 1.0] {
            delta[i] = end;
            let moves = visit(&delta)?;
            uphill.iter_mut().zip(moves).for_each(|(slope, move_)| slope[i] += end * move_);
        }
    }
    for slope in &uphill {
        for side in [-1.0, 1.0] {
            visit(&slope.iter().map(|s| side * s.signum()).collect::<Vec<f64>>())?;
        }
    }
    for delta in random_corners(all.len(), RANDOM_CORNERS, 1) {
        visit(&delta)?;
    }
    let moved = quantities.into_iter().zip(farthest).filter(|(_, most)| *most > STILL);
    range.deviations = moved.collect();
    Ok(range)
}

/// Corners of a box of `n` sides, for each seed the same ones every time.
pub fn random_corners(n: usize, count: usize, seed: u64) -> Vec<Vec<f64>> {
    // A linear congruential generator; multiplier of Knuth, The Art of Computer Programming 2 (MMIX).
    let mut state = seed;
    let mut sign = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        if state >> 63 == 1 { 1.0 } else { -1.0 }
    };
    (0..count).map(|_| (0..n).map(|_| sign()).collect()).collect()
}
