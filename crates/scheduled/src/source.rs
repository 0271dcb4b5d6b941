//! Rates of measured signals from other signals or from the commands.

use crate::design::Source;
use crate::{ControllerDesign, Trim};

/// [`Source`] with the index of its signal.
#[derive(Debug)]
enum From {
    Rate(usize),
    Path(usize),
    Commands { gains: Vec<f64>, time: f64 },
}

/// Source of the rate of each signal.
#[derive(Debug)]
pub(crate) struct Sources {
    sources: Vec<Option<From>>,
    /// Index of the speed.
    speed: usize,
}

impl Sources {
    #[inline]
    pub(crate) fn new(design: &ControllerDesign, speed: usize) -> Self {
        let sources = |signal: usize| {
            Some(match design.source(signal)? {
                Source::Rate(name) => From::Rate(design.index(name)?),
                Source::Path(name) => From::Path(design.index(name)?),
                Source::Commands { gains, time } => From::Commands { gains: gains.clone(), time: *time },
            })
        };
        Self { sources: (0..design.signals.len()).map(sources).collect(), speed }
    }

    /// Returns the rate of a signal, SI per second, from the `measured` values of others; `None` if they do not
    /// determine it.
    pub(crate) fn rate(&self, trim: &Trim, signal: usize, measured: impl Fn(usize) -> f64) -> Option<f64> {
        match self.sources[signal].as_ref()? {
            From::Rate(other) => Some(measured(*other)),
            From::Path(pitch) => {
                let speed = measured(self.speed);
                Some(-(speed * (measured(*pitch) - trim.signal(speed, *pitch, 0.0))))
            }
            From::Commands { .. } => None,
        }
    }

    /// Returns the index of the signal that is the rate of another.
    pub(crate) fn rate_signal(&self, signal: usize) -> Option<usize> {
        match self.sources[signal] {
            Some(From::Rate(other)) => Some(other),
            _ => None,
        }
    }

    /// Returns the sum over the actuators of gain times command; 0 for a signal whose rate does not follow from the
    /// commands.
    pub(crate) fn force(&self, signal: usize, commands: &[f64]) -> f64 {
        let Some(From::Commands { gains, .. }) = &self.sources[signal] else { return 0.0 };
        gains.iter().zip(commands).fold(0.0, |sum, (gain, command)| sum + gain * command)
    }

    /// Returns the rate of a signal, SI per second, that has changed by `moved` since the weighted sum of the commands
    /// was `anchor`; `None` if its rate does not follow from the commands.
    pub(crate) fn rate_from_commands(
        &self,
        signal: usize,
        commands: &[f64],
        anchor: f64,
        moved: f64,
    ) -> Option<f64> {
        let Some(From::Commands { time, .. }) = &self.sources[signal] else { return None };
        Some(self.force(signal, commands) - anchor - moved / time)
    }
}
