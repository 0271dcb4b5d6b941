//! The rates of measured signals that follow from other signals or from the commands.

use crate::design::Source;
use crate::{ControllerDesign, Trim};

/// A [`Source`], its signal by its index.
#[derive(Debug)]
enum From {
    Rate(usize),
    Path(usize),
    Commands { gains: Vec<f64>, time: f64 },
}

/// What the rate of each signal follows from.
#[derive(Debug)]
pub(crate) struct Sources {
    of: Vec<Option<From>>,
    /// The index of the speed.
    speed: usize,
}

impl Sources {
    #[inline]
    pub(crate) fn new(design: &ControllerDesign, speed: usize) -> Self {
        let of = |signal: usize| {
            Some(match design.source(signal)? {
                Source::Rate(name) => From::Rate(design.index(name)?),
                Source::Path(name) => From::Path(design.index(name)?),
                Source::Commands { gains, time } => From::Commands { gains: gains.clone(), time: *time },
            })
        };
        Self { of: (0..design.signals.len()).map(of).collect(), speed }
    }

    /// The rate of a signal, SI per second, from the `measured` values of others; `None` of one whose rate they do not
    /// give.
    pub(crate) fn rate(&self, trim: &Trim, signal: usize, measured: impl Fn(usize) -> f64) -> Option<f64> {
        match self.of[signal].as_ref()? {
            From::Rate(other) => Some(measured(*other)),
            From::Path(pitch) => {
                let along = measured(self.speed);
                Some(-(along * (measured(*pitch) - trim.signal(along, *pitch, 0.0))))
            }
            From::Commands { .. } => None,
        }
    }

    /// The signal that is the rate of another.
    pub(crate) fn rate_signal(&self, signal: usize) -> Option<usize> {
        match self.of[signal] {
            Some(From::Rate(other)) => Some(other),
            _ => None,
        }
    }

    /// The sum of gain and command over the actuators; 0 of a signal whose rate does not follow from the commands.
    pub(crate) fn force(&self, signal: usize, commands: &[f64]) -> f64 {
        let Some(From::Commands { gains, .. }) = &self.of[signal] else { return 0.0 };
        gains.iter().zip(commands).fold(0.0, |sum, (gain, command)| sum + gain * command)
    }

    /// The rate of a signal, SI per second, that has `moved` since the sum of gain and command was `anchor`; `None` of
    /// one whose rate does not follow from the commands.
    pub(crate) fn accelerated(
        &self,
        signal: usize,
        commands: &[f64],
        anchor: f64,
        moved: f64,
    ) -> Option<f64> {
        let Some(From::Commands { time, .. }) = &self.of[signal] else { return None };
        Some(self.force(signal, commands) - anchor - moved / time)
    }
}
