//! Progress of a long computation, reported through a callback.

use squid_finding::Finding;
use std::fmt::{self, Debug, Formatter};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Event of a running computation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Event<'e> {
    /// Start of a stage.
    Began {
        /// Name of the stage.
        stage: &'e str,
        /// Description of the work.
        what: &'e str,
    },
    /// End of the stage that began last; its result, if any, follows as [`Event::Done`].
    Ended,
    /// Finding that is a warning.
    Warning(&'e Finding),
    /// Result of a stage.
    Done {
        /// Name of the stage.
        stage: &'e str,
        /// Key figures, one a line.
        figures: &'e str,
    },
}

/// Callback for events; parallel work calls it from several threads.
#[derive(Clone, Copy, Default)]
pub struct Progress<'p>(Option<&'p (dyn Fn(Event) + Sync)>);

impl<'p> Progress<'p> {
    /// Returns a reporter that calls `back` on each event; [`Progress::default`] has no callback.
    pub fn new(back: &'p (dyn Fn(Event) + Sync)) -> Self {
        Self(Some(back))
    }

    fn call_back(&self, event: Event) {
        if let Some(back) = self.0 {
            back(event);
        }
    }

    /// Reports the start of a stage, and its end when the guard is dropped.
    pub fn begin(&self, stage: &str, what: &str) -> Running<'p> {
        self.call_back(Event::Began { stage, what });
        Running { progress: *self }
    }

    /// Runs the work of a stage; returns its value and the elapsed time \[s\].
    pub fn timed<T>(&self, stage: &str, what: &str, work: impl FnOnce() -> T) -> (T, f64) {
        let (_running, started) = (self.begin(stage, what), Instant::now());
        (work(), started.elapsed().as_secs_f64())
    }

    /// Reports a finding as a warning.
    pub fn warn(&self, finding: &Finding) {
        self.call_back(Event::Warning(finding));
    }

    /// Reports the result of a stage.
    pub fn done(&self, stage: &str, figures: &str) {
        self.call_back(Event::Done { stage, figures });
    }
}

/// Results and warnings of stages, stored to be reported later, such as those of one of several attempts.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Results(Vec<Reported>);

#[derive(Debug, Clone, PartialEq)]
enum Reported {
    Warning(Finding),
    Done { stage: String, figures: String },
}

impl Results {
    /// Runs the work; returns its value and the results that it reported.
    pub fn collect<T>(work: impl FnOnce(&Progress) -> T) -> (T, Self) {
        let results = Mutex::new(vec![]);
        let store = |event: Event| {
            let one = match event {
                Event::Done { stage, figures } => {
                    Reported::Done { stage: stage.to_owned(), figures: figures.to_owned() }
                }
                Event::Warning(finding) => Reported::Warning(finding.clone()),
                Event::Began { .. } | Event::Ended => return,
            };
            results.lock().unwrap_or_else(PoisonError::into_inner).push(one);
        };
        let value = work(&Progress::new(&store));
        (value, Self(results.into_inner().unwrap_or_else(PoisonError::into_inner)))
    }

    /// Reports the stored events in order.
    pub fn report(&self, progress: &Progress) {
        for one in &self.0 {
            match one {
                Reported::Done { stage, figures } => progress.done(stage, figures),
                Reported::Warning(finding) => progress.warn(finding),
            }
        }
    }
}

impl Debug for Progress<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "Progress({})", if self.0.is_some() { "called back" } else { "silent" })
    }
}

/// Guard of a running stage.
#[derive(Debug)]
pub struct Running<'p> {
    progress: Progress<'p>,
}

impl Drop for Running<'_> {
    fn drop(&mut self) {
        self.progress.call_back(Event::Ended);
    }
}
