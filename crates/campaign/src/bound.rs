//! Gains of the drawn vehicles, and the guaranteed gain of the uncertain model.
//!
//! Both are gains of the same loop from w to z of the design, in continuous time: the uncertain linear model at a speed
//! (`squid_design::uncertain`) with the controller frozen there. The guaranteed gain is an upper bound for all constant
//! values of the uncertain parameters in their ranges, by mu with a performance block ([`squid_lpv::mu::worst_case`]).
//! A drawn vehicle has one of these values: its coefficients, the gains of its actuators, and the parameters at its own
//! trim.

use crate::error::Error;
use crate::plan::{Axis, Plan};
use nalgebra::{Complex, DVector};
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use squid_design::certify::controller_of;
use squid_design::error::Error as DesignError;
use squid_design::uncertain::closed_loop::uncertain_loop;
use squid_design::uncertain::frozen::{FrozenUncertain, at_speed};
use squid_design::uncertain::model::{Block as Channels, Uncertain};
use squid_design::uncertain::trim::retrim;
use squid_lpv::controller::Controller;
use squid_lpv::mu::CMat;
use squid_lpv::mu::worst_case::worst_case_gain;

/// Number of speeds, evenly spaced over the range of the design, as for mu in its report.
const SPEEDS: usize = 6;

/// Gains at a speed.
#[derive(Debug, Clone, PartialEq)]
pub struct Gains {
    /// Signal controlled by the axis.
    pub axis: &'static str,
    /// Speed along the path, m/s.
    pub speed: f64,
    /// Flight and gain of each vehicle; infinite for an unstable loop.
    pub drawn: Vec<(u64, f64)>,
    /// Number of vehicles without a gain: they have no trim at the speed within the ranges of the model.
    pub outside: usize,
    /// Upper bound of the gain over the model; `None` if mu gives none.
    pub guaranteed: Option<f64>,
}

impl Gains {
    /// Returns the flight with the largest gain, and the gain.
    pub fn largest(&self) -> Option<(u64, f64)> {
        self.drawn.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1))
    }
}

/// Returns the gains of the vehicles of some flights and the guaranteed gain at each speed, for each axis separately;
/// empty without uncertainty.
///
/// # Errors
/// All errors of trim and linearisation at a speed.
pub fn gains(plan: &Plan<'_>, flights: &[u64]) -> Result<Vec<Gains>, Error> {
    let mut found = vec![];
    for axis in plan.axes.iter().filter(|axis| !axis.uncertain.is_empty()) {
        let controller = controller_of(&axis.stored.controller.lft).map_err(DesignError::from)?;
        let speeds = axis.inputs.design.spread(SPEEDS);
        let axis_gains =
            speeds.par_iter().map(|speed| gains_at_speed((plan, axis), flights, &controller, *speed));
        found.extend(axis_gains.collect::<Result<Vec<Gains>, Error>>()?);
    }
    Ok(found)
}

fn gains_at_speed(
    (plan, axis): (&Plan<'_>, &Axis<'_>),
    flights: &[u64],
    controller: &Controller,
    speed: f64,
) -> Result<Gains, Error> {
    let frozen = at_speed(axis.inputs, speed)?;
    let all = uncertain_loop(axis.inputs, &frozen, controller)?;
    let guaranteed = worst_case_gain(&all).ok().map(|found| found.upper);
    let one = |flight: &u64| {
        let delta = delta_of((plan, axis), &frozen, *flight)?;
        Some((*flight, all.closed(&delta).map_or(f64::INFINITY, |closed| closed.hinf_norm().value)))
    };
    let drawn: Vec<(u64, f64)> = flights.par_iter().filter_map(one).collect();
    Ok(Gains {
        axis: axis.steered_signal().name,
        speed,
        outside: flights.len() - drawn.len(),
        drawn,
        guaranteed,
    })
}

/// Returns the uncertainty matrix of the vehicle of a flight; `None` if its trim is outside the ranges of the model.
fn delta_of((plan, axis): (&Plan<'_>, &Axis<'_>), frozen: &FrozenUncertain, flight: u64) -> Option<CMat> {
    let (drawn, nominal) = (plan.draw(flight).delta, &frozen.nominal.trim);
    let drawn: Vec<f64> = axis.indices.iter().map(|index| drawn[*index]).collect();
    let own = &axis.inputs.vehicle;
    let (vehicle, trim) = retrim(own, nominal, &axis.uncertain, &drawn).ok()?;
    let of = |uncertain: Uncertain| match uncertain {
        Uncertain::Parameter(parameter) if uncertain.is_of_trim() => {
            let block = frozen.parameters.iter().find(|block| block.uncertain == uncertain)?;
            let change = parameter.value(&vehicle, &trim) - parameter.value(own, nominal);
            Some(change / block.half_range).filter(|part| part.abs() <= 1.0)
        }
        _ => axis.uncertain.iter().position(|block| block.uncertain == uncertain).map(|i| drawn[i]),
    };
    let entries_of = |block: &Channels| Some(vec![Complex::from(of(block.uncertain)?); block.repetitions]);
    let entries: Vec<Vec<_>> = frozen.model.blocks.iter().map(entries_of).collect::<Option<_>>()?;
    Some(CMat::from_diagonal(&DVector::from_vec(entries.concat())))
}
