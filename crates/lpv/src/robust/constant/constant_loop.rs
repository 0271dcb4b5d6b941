//! A closed loop with some constant or slowly varying parameters.

use crate::system::{ClosedLoop, LoopError};

/// A closed loop, and the classes of trajectories of its parameters.
#[derive(Debug, Clone)]
pub struct ConstantLoop {
    /// The loop.
    pub closed: ClosedLoop,
    /// The filters of each parameter that is constant or varies slowly; `None` for one with any trajectory.
    pub filters: Vec<Option<Filters>>,
    /// Model errors, each with its own Delta(t).
    pub errors: Vec<LoopError>,
}

/// The filters `1/(s + pole)` on the channels of a parameter with a rate of at most `rate`: more poles allow the
/// multipliers to vary more with frequency.
#[derive(Debug, Clone, PartialEq)]
pub struct Filters {
    /// Poles, rad/s, above 0.
    pub poles: Vec<f64>,
    /// Bound on the rate of the parameter, 1/s; 0 for a constant one.
    pub rate: f64,
}

/// A channel with one of its filters.
#[derive(Debug, Clone, Copy)]
pub(super) struct FilteredChannel {
    pub(super) channel: usize,
    pub(super) pole: f64,
    pub(super) rate: f64,
}

impl ConstantLoop {
    /// Returns the channels with filters: parameter by parameter, pole by pole.
    pub(super) fn filtered(&self) -> impl Iterator<Item = FilteredChannel> + '_ {
        let channels_of = |parameter: usize| {
            let channels = self.closed.channels.iter().enumerate();
            channels.filter(move |(_, of)| **of == parameter).map(|(channel, _)| channel)
        };
        let filters = self.filters.iter().enumerate().filter_map(|(p, of)| Some((p, of.as_ref()?)));
        filters.flat_map(move |(parameter, &Filters { ref poles, rate })| {
            let behind = move |&pole| {
                channels_of(parameter).map(move |channel| FilteredChannel { channel, pole, rate })
            };
            poles.iter().flat_map(behind)
        })
    }
}
