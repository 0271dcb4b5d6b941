//! Saved state of an autopilot.

use crate::{Outputs, Saturation, Transition};

/// Complete state of an [`Autopilot`](crate::Autopilot), without its design.
#[derive(Debug, Clone, PartialEq)]
pub struct Snapshot {
    /// State xk of the controller.
    pub state: Vec<f64>,
    /// Filtered speed reference V_r in m/s.
    pub filtered_speed: f64,
    /// References after all limits.
    pub references: Vec<f64>,
    /// Transitions of the references to their targets.
    pub transitions: Vec<Transition>,
    /// Saturation of each actuator.
    pub saturation: Vec<Saturation>,
    /// Applied commands of the last [`follow`](crate::Autopilot::follow).
    pub anchor: Vec<f64>,
    /// Ticks since then.
    pub followed_for: u32,
    /// Value of each signal at initialisation, for those with [`Level::Start`](crate::Level::Start).
    pub origins: Vec<f64>,
    /// Outputs of the last tick.
    pub outputs: Outputs,
    /// Delayed commands, computed but not yet output; see [`ControllerDesign::delay_ticks`](crate::ControllerDesign).
    pub delayed: Vec<f64>,
    /// Time of tick 0 in s.
    pub start: f64,
    /// Number of ticks so far.
    pub ticks: u64,
    /// `true` if the last tick was outside the scheduled range.
    pub outside: bool,
}

/// Mismatch between a snapshot and an autopilot.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[allow(missing_docs)]
pub enum SnapshotError {
    /// List whose length differs from that of the design.
    #[error("the number of {what} is {found}; in the controller it is {expected}")]
    Length { what: &'static str, found: usize, expected: usize },
    /// Value that is infinite or not a number.
    #[error("it contains the number {value}")]
    NotFinite { value: f64 },
}

impl Snapshot {
    /// Checks the numbers of states, commands, trims, delayed commands, signals, references, applied commands,
    /// transitions and actuators, and that all values are finite.
    pub(crate) fn check(&self, lengths: [usize; 9]) -> Result<(), SnapshotError> {
        let Self { filtered_speed, start, ref outputs, .. } = *self;
        let lists = [
            &self.state,
            &outputs.commands,
            &outputs.trim,
            &self.delayed,
            &self.origins,
            &self.references,
            &self.anchor,
        ];
        let found = lists.map(Vec::len).into_iter().chain([self.transitions.len(), self.saturation.len()]);
        let names = [
            "states",
            "commands",
            "trims",
            "delayed commands",
            "signals",
            "references",
            "applied commands",
            "transitions",
            "saturations",
        ];
        for ((what, found), expected) in names.into_iter().zip(found).zip(lengths) {
            if found != expected {
                return Err(SnapshotError::Length { what, found, expected });
            }
        }
        let others = [filtered_speed, start, outputs.scheduling_parameter];
        let transitions = self.transitions.iter().flat_map(|one| [one.start, one.rate, one.share, one.lag]);
        let mut all = lists.into_iter().flatten().copied().chain(others).chain(transitions);
        match all.find(|value| !value.is_finite()) {
            Some(value) => Err(SnapshotError::NotFinite { value }),
            None => Ok(()),
        }
    }
}
