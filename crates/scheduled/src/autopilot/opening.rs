//! Opening of the range of the commands after following those of another source.

use crate::{Actuator, ControllerDesign, ticks};

/// Time in which the range of the commands opens after [`follow`](crate::Autopilot::follow), s.
const OPENING: f64 = 1.0;

/// Range of the commands after [`follow`](crate::Autopilot::follow), which opens from the applied commands to the
/// limits of the actuators:
///
/// ```text
/// |command - applied| <= (maximum - minimum) t/1 s,   t after that
/// ```
#[derive(Debug)]
pub(crate) struct Opening {
    /// [`OPENING`] in ticks.
    pub(crate) ticks: u32,
    /// Opening of the range of each command per tick, SI.
    pub(crate) steps: Vec<f64>,
}

impl Opening {
    #[inline]
    pub(crate) fn new(design: &ControllerDesign) -> Self {
        let ticks = ticks(OPENING, design.sample_time);
        let step = |one: &Actuator| (one.maximum - one.minimum) / f64::from(ticks);
        Self { ticks, steps: design.actuators.iter().map(step).collect() }
    }
}
