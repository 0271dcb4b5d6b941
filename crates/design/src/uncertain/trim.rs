//! Effect of uncertain coefficients on the trim.
//!
//! The linear motion depends on the trim through the incidence and the deflection of control surfaces (thrusts at trim
//! do not enter A and B). Both become parameters of the uncertain model, with the ranges found by retrimming at corners
//! of the box of coefficients. They are treated as independent of the coefficients, which is conservative.

use crate::error::Error;
use crate::error::UncertainError;
use crate::inputs::Inputs;
use crate::uncertain::gradients::perturbed;
use crate::uncertain::model::{Block, Uncertain};
use squid_auv::{Descriptor, Linearisation, Parameter, Speed, Trim, TrimError, Vehicle, trim_with};

/// Number of random corners of the box at which the vehicle is trimmed, besides the corners along the gradients.
const RANDOM_CORNERS: usize = 48;

/// Factor on the limits of actuators, so that a corner beyond them is measured rather than refused.
const LIMIT_FACTOR: f64 = 1e3;

/// Change of the trim (rad, or N) below which it counts as zero.
const NEGLIGIBLE: f64 = 1e-9;

/// Range of the trim over the box of coefficients.
#[derive(Debug, Clone, PartialEq)]
pub struct TrimRange {
    /// Varying quantities of the trim that affect A and B, with their largest change.
    pub deviations: Vec<(Parameter, f64)>,
    /// Number of corners at which the vehicle was trimmed.
    pub corners: usize,
    /// Number of these at which an actuator would exceed its limits.
    pub beyond_limits: usize,
}

impl TrimRange {
    /// Returns the quantities that vary at any of the trims.
    pub(crate) fn varying(ranges: &[Self]) -> Vec<Parameter> {
        let mut out = Vec::new();
        for (parameter, _) in ranges.iter().flat_map(|r| &r.deviations) {
            if !out.contains(parameter) {
                out.push(*parameter);
            }
        }
        out
    }

    /// Returns the largest changes of these quantities; 0 for those that do not vary at this trim.
    pub(crate) fn largest_changes(&self, parameters: &[Parameter]) -> Vec<(Parameter, f64)> {
        let change = |p: &Parameter| self.deviations.iter().find(|(q, _)| q == p).map_or(0.0, |(_, d)| *d);
        parameters.iter().map(|p| (*p, change(p))).collect()
    }
}

/// Returns all uncertain parameters of the design: coefficients, then quantities of the trim with their largest
/// changes, then gains of actuators.
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

/// Trims the vehicle with its coefficients at `delta`, at the speed and depth of a trim, ignoring actuator limits.
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
    // Coefficients of sway, roll and yaw do not affect a level trim.
    if vehicle.coefficients.leaves_plane() {
        return Ok((changed, nominal.clone()));
    }
    let mut free = changed.clone();
    for actuator in &mut free.actuators {
        actuator.min *= LIMIT_FACTOR;
        actuator.max *= LIMIT_FACTOR;
    }
    let retrimmed = trim_with(&free, Speed::Path(nominal.speed), nominal.depth, &nominal.rule);
    let retrimmed = retrimmed.map_err(|reason| match reason {
        TrimError::Coefficients(reason) => UncertainError::Corner { reason },
        reason => UncertainError::NoTrim { reason },
    })?;
    Ok((changed, retrimmed))
}

/// Trims at corners of the box: each coefficient alone at its ends, the corners along the gradients of the incidence
/// and of each deflection, and random corners.
///
/// # Errors
/// [`UncertainError::NothingUncertain`], [`UncertainError::NoTrim`], [`UncertainError::Corner`].
pub fn trim_range(inputs: &Inputs, linear: &Linearisation) -> Result<TrimRange, Error> {
    let (vehicle, nominal) = (&inputs.vehicle, &linear.trim);
    let mut range = TrimRange { deviations: Vec::new(), corners: 0, beyond_limits: 0 };
    let all = blocks(inputs, nominal, &[])?;
    let outputs = (0..vehicle.actuators.len()).map(Parameter::Output);
    let has_effect =
        |p: &Parameter| Descriptor::derivative(vehicle, nominal, linear.states, *p).stacked().amax() > 0.0;
    let quantities: Vec<Parameter> =
        std::iter::once(Parameter::Incidence).chain(outputs).filter(has_effect).collect();
    let mut farthest = vec![0.0_f64; quantities.len()];
    let mut visit = |delta: &[f64]| -> Result<Vec<f64>, UncertainError> {
        let (changed, found) = retrim(vehicle, nominal, &all, delta)?;
        let changes: Vec<f64> =
            quantities.iter().map(|p| p.value(&changed, &found) - p.value(vehicle, nominal)).collect();
        farthest.iter_mut().zip(&changes).for_each(|(most, change)| *most = most.max(change.abs()));
        let pairs = || vehicle.actuators.iter().zip(&found.actuators);
        range.corners += 1;
        range.beyond_limits += usize::from(pairs().any(|(a, output)| !(a.min..=a.max).contains(output)));
        Ok(changes)
    };
    let mut gradients = vec![vec![0.0; all.len()]; quantities.len()];
    for i in 0..all.len() {
        let mut delta = vec![0.0; all.len()];
        for end in [-1.0, 1.0] {
            delta[i] = end;
            let changes = visit(&delta)?;
            gradients.iter_mut().zip(changes).for_each(|(slope, change)| slope[i] += end * change);
        }
    }
    for slope in &gradients {
        for side in [-1.0, 1.0] {
            visit(&slope.iter().map(|s| side * s.signum()).collect::<Vec<f64>>())?;
        }
    }
    for delta in random_corners(all.len(), RANDOM_CORNERS, 1) {
        visit(&delta)?;
    }
    let moved = quantities.into_iter().zip(farthest).filter(|(_, most)| *most > NEGLIGIBLE);
    range.deviations = moved.collect();
    Ok(range)
}

/// Returns pseudorandom corners of a box with `n` sides, reproducible for each seed.
pub fn random_corners(n: usize, count: usize, seed: u64) -> Vec<Vec<f64>> {
    // Linear congruential generator; multiplier of Knuth, The Art of Computer Programming 2 (MMIX).
    let mut state = seed;
    let mut sign = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        if state >> 63 == 1 { 1.0 } else { -1.0 }
    };
    (0..count).map(|_| (0..n).map(|_| sign()).collect()).collect()
}
