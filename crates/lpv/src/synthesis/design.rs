//! Options and result of a synthesis.

use crate::analysis::gain_bound::GainBound;
use crate::bounded_rate::intervals::SlowBound;
use crate::synthesis::inequalities::{DualMultipliers, ScalingClass};
use crate::synthesis::regularity::Regularisation;
use crate::system::{Controller, GeneralisedPlant};

/// Options of a synthesis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// The class of scalings.
    pub scalings: ScalingClass,
    /// The back-off: the controller is built at `(1 + back_off)` times the least gamma, where X Y is away from I. If no
    /// controller can be built so close, the back-off is doubled, at most twice.
    pub back_off: f64,
    /// The largest least gamma that is not treated as infeasible.
    pub gamma_limit: Option<f64>,
    /// The relative accuracy of the least gamma.
    pub accuracy: f64,
    /// The limit on the modes of the frozen controller, rad/s.
    pub fastest_mode: Option<f64>,
    /// `true` to give up if the search gets stuck, for one of many trial controllers. The general solver, other
    /// back-offs and modified plants, which take ten times as long, are left out.
    pub quick: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            scalings: ScalingClass::SymmetricAndSkew,
            back_off: 0.1,
            gamma_limit: None,
            accuracy: 1e-5,
            fastest_mode: None,
            quick: false,
        }
    }
}

/// A controller with its bounds.
#[derive(Debug, Clone, PartialEq)]
pub struct Design {
    /// The controller, in the plant's coordinates.
    pub controller: Controller,
    /// The least gamma that the synthesis inequalities allow.
    pub gamma_optimum: f64,
    /// A lower bound of gamma in floating point; 0 if unknown. Without parameters it holds for every controller, with
    /// parameters for those of the synthesis inequalities.
    pub lower: f64,
    /// Multipliers that may prove a lower bound of the least gamma, the most promising first.
    pub multipliers: Vec<DualMultipliers>,
    /// The gamma at which the controller was built.
    pub gamma_design: f64,
    /// The gain bound of the closed loop, with the matrices that prove it.
    pub certified: GainBound,
    /// The additions to the plant for the design, if no controller could be built without them; gamma_design is then
    /// that of the modified plant, and everything else that of the given plant.
    pub regularisation: Option<Regularisation>,
    /// The gain of the closed loop for a bounded parameter rate, if the controller was designed for one.
    pub slow: Option<SlowBound>,
}

impl Design {
    /// Builds a design from a controller with a bound; no lower bound is known.
    pub fn new(controller: Controller, gamma_optimum: f64, gamma_design: f64, certified: GainBound) -> Self {
        let (regularisation, slow) = (None, None);
        Self {
            controller,
            gamma_optimum,
            lower: 0.0,
            multipliers: vec![],
            gamma_design,
            certified,
            regularisation,
            slow,
        }
    }

    /// Returns the first design with which a search may end, or else the one of the lowest bound.
    pub(crate) fn first_or_best(
        designs: impl Iterator<Item = Self>,
        ends: impl Fn(&Self) -> bool,
    ) -> Option<Self> {
        let mut best: Option<Self> = None;
        for found in designs {
            let best = match &mut best {
                Some(best) if best.certified.gamma <= found.certified.gamma => best,
                best => best.insert(found),
            };
            if ends(best) {
                break;
            }
        }
        best
    }
}

/// The excess of a controller's gamma over the least, in back-offs, up to which it ends a search, without parameters
/// after some changed plants; above it, one is also designed with weights and noises added, whose bound is often lower.
pub(crate) const FAR_ABOVE: f64 = 1.5;

/// Returns the number of times, at least one, that a search may be repeated for a changed plant or in other
/// coordinates.
///
/// A search takes about the third power of its number of unknowns; this count gives the same result on every machine.
pub(crate) fn repetitions(plant: &GeneralisedPlant) -> usize {
    let n = plant.sizes().x;
    let of_scalings: usize = plant.blocks.iter().map(|r| 2 * r * r).sum();
    let unknowns = (n * (n + 1) + of_scalings) as f64;
    (MOST_WORK / unknowns.powi(3)).max(1.0) as usize
}

/// The work of all repetitions of a search.
const MOST_WORK: f64 = 1e8;
