//! A finished loop some of whose parameters are constant, or change slowly.

use crate::system::model_error::LoopError;
use crate::system::plant::ClosedLoop;

/// A finished loop, and what is known of the trajectories of its parameters.
#[derive(Debug, Clone)]
pub struct ConstantLoop {
    /// The loop.
    pub closed: ClosedLoop,
    /// For each parameter its filter, if it is constant or changes slowly; `None` for one that may take any trajectory.
    pub filters: Vec<Option<Filter>>,
    /// Model errors, each with a Delta(t) of its own.
    pub errors: Vec<LoopError>,
}

/// The filter `1/(s + pole)` on the channels of a parameter that changes no faster than `rate`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Filter {
    /// rad/s, above 0.
    pub pole: f64,
    /// Bound on the rate of the parameter, 1/s; 0 for a constant one.
    pub rate: f64,
}

impl ConstantLoop {
    /// The channels with a filter, parameter by parameter.
    pub(super) fn filtered(&self) -> impl Iterator<Item = (usize, Filter)> + '_ {
        self.filters
            .iter()
            .enumerate()
            .filter_map(|(parameter, filter)| Some((parameter, (*filter)?)))
            .flat_map(|(parameter, filter)| {
                let channels = self.closed.channels.iter().enumerate();
                channels.filter(move |(_, of)| **of == parameter).map(move |(channel, _)| (channel, filter))
            })
    }
}
