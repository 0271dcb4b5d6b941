//! Claim `limits` of the certificate: the largest step of a reference for which the loop, with
//! saturated commands and anti-windup, stays in a region from which it returns to trim. Limits on actuator rates are
//! limits on the rates of the lag states of the plant.

use crate::axis::VehicleModel;
use crate::error::{CertifyError, Error};
use crate::inputs::design_file::DesignFile;
use crate::linearise::TRIM_ROWS;
use crate::synthesise::anti_windup::{keeping_speed, largest_step};
use squid_auv::readable;
use squid_auv::{Actuator, lateral};
use squid_certificate::{Certificate, Theorem};
use squid_lpv::controller::Controller;
use squid_lpv::matrix::{Mat, from_rows, to_rows};
use squid_lpv::plant::GeneralisedPlant;
use squid_proof::claim::Proof;
use squid_proof::error::ProofError;
use squid_proof::limits::{Step, with_limits as with_step};
use squid_scheduled::{ControllerDesign, Kind, Manoeuvre, Port, Rows};
use squid_signals::Level;
use std::collections::BTreeMap;
use std::fmt::{self, Display, Formatter};

/// Bound on the entries of a computed anti-windup gain \[1/s\]: that of the quick recovery.
const FASTEST: f64 = crate::synthesise::anti_windup::FASTEST;

/// Relative tolerance of the limits of a claim against those of the vehicle: its trims are recomputed, possibly with
/// the rounding of another processor.
const SAME_LIMIT: f64 = 1e-8;

/// Adds the claim for the largest step found to a proof, replacing any such claim, and proves all of it. No step is
/// claimed beyond the range of its signal, where the linear models are meaningless, however strong the actuators: a
/// pitch step of at most 90 deg, a depth step up to the surface.
///
/// The target is the step of the default flight; `given` are anti-windup gains to be tried in this order. If none of
/// them proves it, and the controller is not a given one, another gain is computed for the largest step. The claim
/// contains the gain to be flown. Actuator rates are saturated, too. Returns `None` if there is nothing to claim:
/// without a gain, or without a reference besides that of the speed.
///
/// # Errors
/// The errors of [`with_step`]; [`CertifyError::RateWithoutLag`].
pub fn with_limits(
    proof: &Proof,
    plant: &GeneralisedPlant,
    controller: &Controller,
    (frozen, given): (&ControllerDesign, &[Rows]),
    vehicle: &dyn VehicleModel,
    design: &DesignFile,
) -> Result<Option<Proof>, Error> {
    let Some(Stepped { input, scale, .. }) = Stepped::of(frozen) else { return Ok(None) };
    let signal = design.tracked[input].signal;
    let required = design.manoeuvre.step(signal.name).abs() / scale;
    let rates = rates(vehicle.actuators(), design, &proof.certificate.moving_states())?;
    let search = |gains: &[Rows], fastest: Option<f64>| {
        let step = Step {
            input,
            largest: signal.range.map_or_else(|| largest_step(design, input), |[_, most]| most) / scale,
            required,
            gains,
            fastest,
            commands: sides(frozen),
            rates: rates.clone(),
            states: design.states.len(),
        };
        with_step(proof, plant, controller, step)
    };
    let found = search(given, None);
    let size = |proof: &Option<Proof>| {
        proof.as_ref().and_then(|proof| Some(proof.certificate.limits()?.size)).unwrap_or(0.0)
    };
    let is_given = design.controller.is_some();
    if is_given || found.as_ref().is_ok_and(|found| found.is_some() && size(found) >= required) {
        return Ok(found?);
    }
    // The largest step is sought with any gain, and proved with that gain without its bias of the speed.
    let Ok(Some(any)) = search(&[], Some(FASTEST)) else { return Ok(found?) };
    let Some(limits) = any.certificate.limits() else { return Ok(found?) };
    let sought = from_rows(&limits.e, frozen.actuators.len()).unwrap_or_else(|| Mat::zeros(0, 0));
    let unbiased = to_rows(&keeping_speed(vehicle, design, controller, sought)?);
    let other = if unbiased == limits.e { Ok(Some(any)) } else { search(&[unbiased], None) };
    match (found, other) {
        (Ok(found), Ok(other)) => Ok(if size(&other) > size(&found) { other } else { found }),
        (found, other) => Ok(found.or(other)?),
    }
}

/// Checks that a claim with limits is about the autopilot that flies: its anti-windup, its limits, its stepped
/// reference.
///
/// # Errors
/// [`ProofError::Mismatch`] with the first part that differs.
pub fn check_autopilot(design: &ControllerDesign, certificate: &Certificate) -> Result<(), ProofError> {
    let Some(limits) = certificate.limits() else { return Ok(()) };
    let differs = |what: &str| Err(ProofError::Mismatch { what: format!("{what} in the claim with limits") });
    if design.anti_windup.as_ref() != Some(&limits.e) {
        return differs("the anti-windup");
    }
    let available = sides(design);
    if available.len() + limits.rates.len() != limits.limits.len()
        || limits.limits.iter().zip(&available).any(|(claimed, side)| claimed > side)
    {
        return differs("a limit");
    }
    if Stepped::of(design).map(|stepped| stepped.input) != Some(limits.input) {
        return differs("the reference");
    }
    Ok(())
}

/// Checks that the limits of a claim, on commands and on rates, are no wider than those of the vehicle's actuators
/// about its recomputed trims.
///
/// # Errors
/// [`CertifyError::RateWithoutLag`], [`ProofError::WrongPlant`]; the errors of the trims.
pub fn check_vehicle(
    certificate: &Certificate,
    vehicle: &dyn VehicleModel,
    design: &DesignFile,
) -> Result<(), Error> {
    let Some(limits) = certificate.limits() else { return Ok(()) };
    let actuators = vehicle.actuators();
    let wrong =
        |what: &str| Err(ProofError::WrongPlant { what: format!("{what} in the claim with limits") }.into());
    let vehicle_rates = rates(actuators, design, &certificate.moving_states())?;
    if limits.limits.len() != actuators.len() + limits.rates.len() {
        return wrong("the number of limits");
    }
    let (commands, claimed) = limits.limits.split_at(actuators.len());
    let trims = vehicle.trims(&design.spread(TRIM_ROWS))?;
    let rows: Vec<&[f64]> = trims.iter().map(|trim| trim.actuators.as_slice()).collect();
    let sides = actuators.iter().enumerate().map(|(j, a)| side(&rows, j, (a.min, a.max)) / a.reach());
    if commands.iter().zip(sides).any(|(claimed, side)| *claimed > (1.0 + SAME_LIMIT) * side) {
        return wrong("a limit");
    }
    let claimed: BTreeMap<usize, f64> = limits.rates.iter().copied().zip(claimed.iter().copied()).collect();
    let holds = |(state, rate): (&usize, &f64)| claimed.get(state).is_some_and(|claimed| claimed <= rate);
    if vehicle_rates.iter().all(holds) { Ok(()) } else { wrong("a rate limit") }
}

/// Rate limits of actuators, in units of the actuator's reach \[1/s\], by state of the design's plant; only states in
/// `moving`. The lags follow the model's states.
fn rates(
    actuators: &[Actuator],
    design: &DesignFile,
    moving: &[usize],
) -> Result<BTreeMap<usize, f64>, CertifyError> {
    if let Some(one) = actuators.iter().find(|one| one.rate.is_some()).filter(|_| !design.lags) {
        return Err(CertifyError::RateWithoutLag { actuator: one.name.clone() });
    }
    let lagged = actuators.iter().filter(|one| one.lag > 0.0).zip(design.states.len()..);
    let limited = lagged.filter_map(|(one, state)| Some((state, one.rate? / one.reach())));
    Ok(limited.filter(|(state, _)| moving.contains(state)).collect())
}

/// Reference of the claim: that of the first signal of the interface with a reference, besides the scheduled signal.
struct Stepped<'a> {
    /// Index among the references, with which w begins.
    input: usize,
    /// Signal of the reference.
    signal: &'a Port,
    /// Unit of the reference, SI.
    scale: f64,
}

impl<'a> Stepped<'a> {
    fn of(design: &'a ControllerDesign) -> Option<Self> {
        let references = || design.controller_inputs.iter().filter(|input| input.kind == Kind::Reference);
        design.signals.iter().filter(|signal| signal.level != Level::Scheduled).find_map(|signal| {
            let (input, found) = references().enumerate().find(|(_, input)| input.signal == signal.name)?;
            Some(Self { input, signal, scale: found.scale })
        })
    }
}

/// Largest step of a proved claim.
#[derive(Debug, Clone, PartialEq)]
pub struct ClaimedStep {
    /// Name of the stepped output.
    pub output: String,
    /// Size in `unit`, rounded down to a tenth of a degree or a hundredth of a metre.
    pub size: f64,
    /// Unit of the size: deg, m or another unit of the output.
    pub unit: String,
    /// Proved size in `unit`, not rounded.
    proved: f64,
    /// Factor from the SI unit to `unit`.
    factor: f64,
    /// `true` if the step is one of heading in a model without roll.
    without_roll: bool,
}

impl ClaimedStep {
    /// Returns the step of a manoeuvre, in `unit`, if it is larger than the proved one.
    pub fn exceeded_by(&self, manoeuvre: &Manoeuvre) -> Option<f64> {
        let flown = self.factor * manoeuvre.step(&self.output).abs();
        (flown > self.proved).then_some(flown)
    }

    /// Returns the claimed step of a frozen design.
    pub fn of(design: &ControllerDesign, theorem: &Theorem) -> Option<Self> {
        let (limits, stepped) = (theorem.limits?, Stepped::of(design)?);
        let Port { name, unit, .. } = stepped.signal;
        let inputs = design.controller_inputs.iter().map(|input| input.signal.as_str());
        let without_roll = leaves_out_roll(name, inputs);
        let step = || Self { without_roll, ..Self::new(name, unit, limits.size * stepped.scale) };
        (limits.input == stepped.input).then(step)
    }

    /// Returns the claimed step of a design file; `None` if the claim is about another reference.
    pub fn of_file(file: &DesignFile, theorem: &Theorem) -> Option<Self> {
        let limits = theorem.limits?;
        let stepped = file.tracked.get(limits.input).filter(|tracked| tracked.index == file.stepped())?;
        let inputs = file.measured.iter().map(|measured| measured.signal.name);
        let without_roll = leaves_out_roll(stepped.signal.name, inputs);
        let size = limits.size * stepped.scale;
        Some(Self { without_roll, ..Self::new(stepped.signal.name, stepped.signal.unit, size) })
    }

    pub(crate) fn new(output: &str, unit: &str, size: f64) -> Self {
        let (factor, unit) = readable(unit);
        let digits = if factor == 1.0 { 100.0 } else { 10.0 };
        let proved = factor * size;
        let size = (digits * proved).floor() / digits;
        Self { output: output.to_owned(), size, unit: unit.to_owned(), proved, factor, without_roll: false }
    }
}

/// Returns `true` if a step, with these inputs of the controller, is one of heading in a model without roll.
fn leaves_out_roll<'a>(stepped: &str, mut inputs: impl Iterator<Item = &'a str>) -> bool {
    let [heading, roll] = [lateral::HEADING, lateral::ROLL].map(|signal| lateral::SIGNALS[signal].name);
    stepped == heading && !inputs.any(|name| name == roll)
}

impl Display for ClaimedStep {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "a {} step of up to {} {}", self.output, self.size, self.unit)?;
        if self.without_roll { write!(f, " (without roll)") } else { Ok(()) }
    }
}

/// Range of each command to either side of the trim, the least over all speeds, in units of its scale. The trim table
/// is interpolated linearly, so its rows are sufficient. While a steering actuator is at its limit, a thruster that
/// does not steer pushes against the speed no more than in trim.
fn sides(design: &ControllerDesign) -> Vec<f64> {
    let rows: Vec<&[f64]> = design.trim.actuators.iter().map(Vec::as_slice).collect();
    let steered = design.actuators.iter().any(|one| !one.steers.is_empty());
    let one = |(j, a): (usize, &squid_scheduled::Actuator)| {
        let push = |(row, speed): (&&[f64], &f64)| {
            let direction = speed * a.pushes();
            if direction == 0.0 { f64::INFINITY } else { (row[j] * direction.signum()).max(0.0) }
        };
        let without_braking =
            rows.iter().zip(&design.trim.forward_speed).map(push).fold(f64::INFINITY, f64::min);
        let full = side(&rows, j, (a.minimum, a.maximum));
        (if steered { full.min(without_braking) } else { full }) / a.scale
    };
    design.actuators.iter().enumerate().map(one).collect()
}

/// Range of an actuator to either side of the trim, the least over the rows of the trim table.
fn side(trims: &[&[f64]], actuator: usize, limits: (f64, f64)) -> f64 {
    let each = trims.iter().map(|row| (limits.1 - row[actuator]).min(row[actuator] - limits.0));
    each.fold(f64::INFINITY, f64::min)
}
