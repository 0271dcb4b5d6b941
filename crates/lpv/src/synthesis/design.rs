//! What a synthesis is asked for, and what comes of it.

use crate::analysis::gain_bound::GainBound;
use crate::bounded_rate::intervals::SlowBound;
use crate::synthesis::inequalities::{DualMultipliers, ScalingClass};
use crate::synthesis::regularity::Regularisation;
use crate::system::controller::Controller;

/// How a controller is sought.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// The scalings.
    pub scalings: ScalingClass,
    /// The controller is built at `(1 + back_off)` times the least gamma, where X Y keeps off I. Where no controller
    /// can be built so close to it, the back-off is doubled, twice at most.
    pub back_off: f64,
    /// A least gamma above this counts as infeasible.
    pub gamma_limit: Option<f64>,
    /// A gamma that is known to be within this of the least, relative to itself, is near enough to it.
    pub accuracy: f64,
    /// No mode of the frozen controller may be faster than this, rad/s.
    pub fastest_mode: Option<f64>,
    /// Whether to give up where the search gets stuck: for one of many controllers, of which few are kept. The general
    /// solver, other back-offs and changes of the plant, which take ten times as long, are left out.
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

/// A controller with what is known of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Design {
    /// The controller, in the plant's coordinates.
    pub controller: Controller,
    /// The least gamma that the synthesis inequalities allow.
    pub gamma_optimum: f64,
    /// No gamma below this is possible, as floating point shows; 0 when nothing is known. Without parameters it is of
    /// every controller, with them of those that the synthesis inequalities give.
    pub lower: f64,
    /// Multipliers that may prove a lower bound of the least gamma, the most promising first.
    pub multipliers: Vec<DualMultipliers>,
    /// The gamma at which the controller was built.
    pub gamma_design: f64,
    /// The gain bound of the closed loop, with the matrices that show it.
    pub certified: GainBound,
    /// What was added to the plant for the design of the controller, where none could be built without; gamma_design
    /// is then of the plant with it, and all else of the plant as given.
    pub regularisation: Option<Regularisation>,
    /// The gain of the closed loop where the parameter moves at a bounded rate, if the controller was built for that.
    pub slow: Option<SlowBound>,
}
