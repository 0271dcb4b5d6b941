//! A finished loop some of whose parameters are constant.

use crate::system::model_error::LoopError;
use crate::system::plant::ClosedLoop;

/// A finished loop, and what is known of the trajectories of its parameters.
#[derive(Debug, Clone)]
pub struct ConstantLoop {
    /// The loop.
    pub closed: ClosedLoop,
    /// For each parameter the `a` of its filter `1/(s + a)`, rad/s: such a parameter must be constant. `None` for one
    /// that may take any trajectory.
    pub poles: Vec<Option<f64>>,
    /// Model errors, each with a Delta(t) of its own.
    pub errors: Vec<LoopError>,
}

impl ConstantLoop {
    /// The channels of each parameter that has a filter, and its pole.
    pub(super) fn dynamic(&self) -> impl Iterator<Item = (Vec<usize>, f64)> + '_ {
        self.poles.iter().enumerate().filter_map(|(parameter, pole)| {
            let own = |c: &usize| self.closed.channels[*c] == parameter;
            pole.map(|pole| ((0..self.closed.channels.len()).filter(own).collect(), pole))
        })
    }
}
