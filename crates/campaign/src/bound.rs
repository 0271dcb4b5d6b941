//! The gains of the vehicles that were drawn, beside the gain that is guaranteed for the whole model.
//!
//! Both are of the same loop: the uncertain linear model at a speed (`squid_design::uncertain`) with the controller
//! frozen there, in continuous time, from w to z of the design. The guaranteed one is an upper bound for every constant
//! value of the uncertain numbers in their ranges, by mu with a block for performance ([`lpv::mu::worst_case`]). A
//! vehicle that was drawn is one of these values: its coefficients, the gains of its actuators, and where its own trim
//! puts what belongs to the trim.

use crate::error::Error;
use crate::plan::Plan;
use lpv::controller::Controller;
use lpv::mu::CMat;
use lpv::mu::worst_case::worst_case_gain;
use nalgebra::{Complex, DVector};
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use squid_design::certify::controller_of;
use squid_design::error::Error as DesignError;
use squid_design::uncertain::closed_loop::uncertain_loop;
use squid_design::uncertain::frozen::{FrozenUncertain, at_speed};
use squid_design::uncertain::model::{Block as Channels, Uncertain};
use squid_design::uncertain::trim::retrim;

/// Speeds, evenly spread over the range of the design: those of mu in its report.
const SPEEDS: usize = 6;

/// Gains at a speed.
#[derive(Debug, Clone, PartialEq)]
pub struct Gains {
    /// Along the path, m/s.
    pub speed: f64,
    /// Of each vehicle with its flight; infinite where its loop is unstable.
    pub drawn: Vec<(u64, f64)>,
    /// Vehicles without a gain: none of them trims at that speed within what the model allows its trim.
    pub outside: usize,
    /// Below this is the gain everywhere in the model; none where mu does not show that.
    pub guaranteed: Option<f64>,
}

impl Gains {
    /// The largest that was drawn, with its flight.
    pub fn largest(&self) -> Option<(u64, f64)> {
        self.drawn.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1))
    }
}

/// The gains of the vehicles of some flights, and those guaranteed, at each speed; none where nothing is uncertain.
///
/// # Errors
/// Those of trim and linearisation at a speed.
pub fn gains(plan: &Plan<'_>, flights: &[u64]) -> Result<Vec<Gains>, Error> {
    if plan.uncertain.is_empty() {
        return Ok(Vec::new());
    }
    let controller = controller_of(&plan.stored.controller.lft).map_err(DesignError::from)?;
    let speeds = plan.inputs.design.spread(SPEEDS);
    speeds.par_iter().map(|speed| at(plan, flights, &controller, *speed)).collect()
}

fn at(plan: &Plan<'_>, flights: &[u64], controller: &Controller, speed: f64) -> Result<Gains, Error> {
    let frozen = at_speed(plan.inputs, speed)?;
    let all = uncertain_loop(plan.inputs, &frozen, controller)?;
    let guaranteed = worst_case_gain(&all).ok().map(|found| found.upper);
    let one = |flight: &u64| {
        let delta = place(plan, &frozen, *flight)?;
        Some((*flight, all.closed(&delta).map_or(f64::INFINITY, |own| own.hinf_norm().value)))
    };
    let drawn: Vec<(u64, f64)> = flights.par_iter().filter_map(one).collect();
    Ok(Gains { speed, outside: flights.len() - drawn.len(), drawn, guaranteed })
}

/// Where in the uncertain model the vehicle of a flight is; `None` where its trim is beyond what the model has.
fn place(plan: &Plan<'_>, frozen: &FrozenUncertain, flight: u64) -> Option<CMat> {
    let (drawn, nominal) = (plan.draw(flight), &frozen.nominal.trim);
    let (vehicle, trim) = retrim(&plan.inputs.vehicle, nominal, &plan.uncertain, &drawn.delta).ok()?;
    let of = |uncertain: Uncertain| match uncertain {
        Uncertain::Parameter(parameter) if uncertain.is_of_trim() => {
            let block = frozen.parameters.iter().find(|block| block.uncertain == uncertain)?;
            let moved = parameter.value(&vehicle, &trim) - parameter.value(&plan.inputs.vehicle, nominal);
            Some(moved / block.half_range).filter(|part| part.abs() <= 1.0)
        }
        _ => plan.uncertain.iter().position(|block| block.uncertain == uncertain).map(|i| drawn.delta[i]),
    };
    let repeated = |block: &Channels| Some(vec![Complex::from(of(block.uncertain)?); block.repetitions]);
    let entries: Vec<Vec<_>> = frozen.model.blocks.iter().map(repeated).collect::<Option<_>>()?;
    Some(CMat::from_diagonal(&DVector::from_vec(entries.concat())))
}
