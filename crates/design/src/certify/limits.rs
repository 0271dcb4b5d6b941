//! The section `limits` of the certificate: how large a step of the reference of pitch or depth may be for the loop,
//! with its commands cut off at their limits and its anti-windup, to stay in a region from which it comes back. Limits
//! on the rates of the actuators are such limits on the rates of states of the plant, which has the lags.

use crate::error::{CertifyError, Error};
use crate::inputs::design_file::DesignFile;
use crate::linearise::trim_table;
use crate::numbers::readable;
use auv::{Actuator, Vehicle};
use certificate::{Certificate, Theorem};
use lpv::controller::Controller;
use lpv::plant::GeneralisedPlant;
use proof::claim::Proof;
use proof::error::ProofError;
use proof::limits::{Step, with_limits as with_step};
use scheduled::{ControllerDesign, Kind, Manoeuvre};
use signals::{DEPTH, PITCH, SIGNALS, Signal, place};
use std::collections::BTreeMap;
use std::fmt::{self, Display, Formatter};

/// The largest pitch step \[rad\] (90 deg) that is claimed: the linear models know no larger pitch, however strong the
/// actuators. Of the depth it is one up to the surface.
const MOST: f64 = std::f64::consts::FRAC_PI_2;

/// Bound on a gain that is sought \[1/s\]: that of the quick one.
const FASTEST: f64 = crate::synthesise::anti_windup::FASTEST;

/// How much wider than those of the vehicle the limits of a claim may be, relative: its trims are computed again, with
/// the rounding of another processor.
const SAME_LIMIT: f64 = 1e-8;

/// Adds the claim for the largest step found to a proof, and proves all of it.
///
/// The gain of the frozen design is that of the quickest recovery, the step that is wanted that of the default flight:
/// the claim has the gain that is to fly. `None` where there is nothing to claim: without anti-windup, or without a
/// reference of pitch or depth. The rates of the actuators are cut off at their limits, too.
///
/// # Errors
/// Those of [`with_step`]; [`CertifyError::RateWithoutLag`].
pub fn with_limits(
    proof: &Proof,
    (plant, controller): (&GeneralisedPlant, &Controller),
    frozen: &ControllerDesign,
    actuators: &[Actuator],
    design: &DesignFile,
) -> Result<Option<Proof>, Error> {
    let (Some(quick), Some(Stepped { input, signal, scale })) = (&frozen.anti_windup, Stepped::of(frozen))
    else {
        return Ok(None);
    };
    let step = Step {
        input,
        largest: if signal == PITCH { MOST } else { design.depth.max(scale) } / scale,
        wanted: design.manoeuvre.steps()[signal].abs() / scale,
        quick,
        fastest: FASTEST,
        commands: sides(frozen),
        rates: rates(actuators, design, &proof.certificate.moving_states())?,
        states: design.states.len(),
    };
    Ok(with_step(proof, (plant, controller), step)?)
}

/// Checks that a claim with limits is about the autopilot that flies: its anti-windup, its limits, steps of pitch.
///
/// # Errors
/// [`ProofError::Mismatch`] with the first part that differs.
pub fn of_autopilot(design: &ControllerDesign, certificate: &Certificate) -> Result<(), ProofError> {
    let Some(limits) = &certificate.limits else { return Ok(()) };
    let differs = |what: &str| Err(ProofError::Mismatch { what: format!("{what} of the claim with limits") });
    if design.anti_windup.as_ref() != Some(&limits.e) {
        return differs("the anti-windup");
    }
    let there = sides(design);
    if there.len() + limits.rates.len() != limits.limits.len()
        || limits.limits.iter().zip(&there).any(|(claimed, side)| claimed > side)
    {
        return differs("a limit");
    }
    if Stepped::of(design).map(|stepped| stepped.input) != Some(limits.input) {
        return differs("the reference");
    }
    Ok(())
}

/// Checks that the limits of a claim are no wider than those of a vehicle's actuators about its trims, computed again,
/// nor those on their rates.
///
/// # Errors
/// [`CertifyError::RateWithoutLag`], [`ProofError::WrongPlant`]; those of the trims.
pub fn of_vehicle(certificate: &Certificate, vehicle: &Vehicle, design: &DesignFile) -> Result<(), Error> {
    let Some(limits) = &certificate.limits else { return Ok(()) };
    let actuators = &vehicle.actuators;
    let wrong =
        |what: &str| Err(ProofError::WrongPlant { what: format!("{what} of the claim with limits") }.into());
    let rates_there = rates(actuators, design, &certificate.moving_states())?;
    if limits.limits.len() != actuators.len() + limits.rates.len() {
        return wrong("the number of limits");
    }
    let (commands, claimed) = limits.limits.split_at(actuators.len());
    let trims = trim_table(vehicle, design)?;
    let rows: Vec<&[f64]> = trims.iter().map(|trim| trim.actuators.as_slice()).collect();
    let sides = actuators.iter().enumerate().map(|(j, a)| side(&rows, j, (a.min, a.max)) / a.reach());
    if commands.iter().zip(sides).any(|(claimed, side)| *claimed > (1.0 + SAME_LIMIT) * side) {
        return wrong("a limit");
    }
    let claimed: BTreeMap<usize, f64> = limits.rates.iter().copied().zip(claimed.iter().copied()).collect();
    let holds = |(state, rate): (&usize, &f64)| claimed.get(state).is_some_and(|claimed| claimed <= rate);
    if rates_there.iter().all(holds) { Ok(()) } else { wrong("a limit on a rate,") }
}

/// The states of the design's plant that are outputs of actuators with a limit on their rate, among those that the loop
/// consists of, with that limit in units of the actuator's reach \[1/s\]. The lags follow the model's states.
fn rates(
    actuators: &[Actuator],
    design: &DesignFile,
    kept: &[usize],
) -> Result<BTreeMap<usize, f64>, CertifyError> {
    if let Some(one) = actuators.iter().find(|one| one.rate.is_some()).filter(|_| !design.lags) {
        return Err(CertifyError::RateWithoutLag { actuator: one.name.clone() });
    }
    let lagged = actuators.iter().filter(|one| one.lag > 0.0).zip(design.states.len()..);
    let limited = lagged.filter_map(|(one, state)| Some((state, one.rate? / one.reach())));
    Ok(limited.filter(|(state, _)| kept.contains(state)).collect())
}

/// The reference of which the claim is: pitch, or depth without one of pitch.
struct Stepped {
    /// Its place among the references, with which w begins.
    input: usize,
    /// Its place in [`SIGNALS`].
    signal: usize,
    /// What counts as 1, SI.
    scale: f64,
}

impl Stepped {
    fn of(design: &ControllerDesign) -> Option<Self> {
        let references = design.controller_inputs.iter().filter(|input| input.kind == Kind::Reference);
        let each: Vec<(usize, f64)> =
            references.filter_map(|input| Some((place(&input.signal)?, input.scale))).collect();
        [PITCH, DEPTH].into_iter().find_map(|wanted| {
            let input = each.iter().position(|(signal, _)| *signal == wanted)?;
            Some(Self { input, signal: wanted, scale: each[input].1 })
        })
    }
}

/// The largest step of a proved claim.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClaimedStep {
    /// The row of the output.
    pub output: &'static Signal,
    /// Its size in `unit`, rounded down to a tenth of a degree or a hundredth of a metre.
    pub size: f64,
    /// deg or m.
    pub unit: &'static str,
    /// The size that is proved, in `unit`.
    proved: f64,
}

impl ClaimedStep {
    /// The step of a manoeuvre, in `unit`, if it is larger than the one that is proved.
    pub fn exceeded_by(&self, manoeuvre: &Manoeuvre) -> Option<f64> {
        let (factor, _) = readable(self.output.unit);
        let flown = factor * manoeuvre.steps()[place(self.output.name)?].abs();
        (flown > self.proved).then_some(flown)
    }

    /// By the frozen design that the claim is of.
    pub fn of(design: &ControllerDesign, theorem: &Theorem) -> Option<Self> {
        let (limits, stepped) = (theorem.limits?, Stepped::of(design)?);
        (limits.input == stepped.input).then(|| Self::new(stepped.signal, limits.size * stepped.scale))
    }

    /// By the design file that the claim is of; `None` where what steps is neither pitch nor depth.
    pub fn of_file(file: &DesignFile, theorem: &Theorem) -> Option<Self> {
        let limits = theorem.limits?;
        let stepped = file.tracked.get(limits.input).filter(|tracked| tracked.place == file.stepped())?;
        Some(Self::new(stepped.place, limits.size * stepped.scale))
    }

    pub(crate) fn new(place: usize, size: f64) -> Self {
        let (factor, unit) = readable(SIGNALS[place].unit);
        let digits = if place == PITCH { 10.0 } else { 100.0 };
        let proved = factor * size;
        Self { output: &SIGNALS[place], size: (digits * proved).floor() / digits, unit, proved }
    }
}

impl Display for ClaimedStep {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "a {} step of up to {} {}", self.output.name, self.size, self.unit)
    }
}

/// How far each command can go either way from the trim of any speed, in units of its scale: the trim table is
/// interpolated linearly, so that its rows decide.
fn sides(design: &ControllerDesign) -> Vec<f64> {
    let rows: Vec<&[f64]> = design.trim.actuators.iter().map(Vec::as_slice).collect();
    let one = |(j, a): (usize, &scheduled::Actuator)| side(&rows, j, (a.minimum, a.maximum)) / a.scale;
    design.actuators.iter().enumerate().map(one).collect()
}

/// How far an actuator can go either way from the trim of the speed at which that is least.
fn side(trims: &[&[f64]], actuator: usize, (least, most): (f64, f64)) -> f64 {
    let each = trims.iter().map(|row| (most - row[actuator]).min(row[actuator] - least));
    each.fold(f64::INFINITY, f64::min)
}
