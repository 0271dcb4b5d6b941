//! Progress of a long computation, through a callback.

use std::fmt::{self, Debug, Formatter};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// An event of a running computation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Event<'e> {
    /// A stage has begun.
    Began {
        /// Its name.
        stage: &'e str,
        /// What is being done, in words.
        what: &'e str,
    },
    /// The stage that began last is over; its result follows as [`Event::Done`], if it has one.
    Ended,
    /// What must be read before any result.
    Warning {
        /// In words.
        words: &'e str,
    },
    /// The result of a stage.
    Done {
        /// Its name.
        stage: &'e str,
        /// Its key figures, a line each.
        figures: &'e str,
    },
}

/// Calls back on each event; from several threads where work is shared out.
#[derive(Clone, Copy, Default)]
pub struct Progress<'p>(Option<&'p (dyn Fn(Event) + Sync)>);

impl<'p> Progress<'p> {
    /// Calls `back` on each event. [`Progress::default`] calls nothing.
    pub fn new(back: &'p (dyn Fn(Event) + Sync)) -> Self {
        Self(Some(back))
    }

    fn call_back(&self, event: Event) {
        if let Some(back) = self.0 {
            back(event);
        }
    }

    /// A stage begins; it ends when the guard is dropped.
    pub fn begin(&self, stage: &str, what: &str) -> Running<'p> {
        self.call_back(Event::Began { stage, what });
        Running { progress: *self }
    }

    /// Runs the work of a stage; what it returns, and the seconds that it took.
    pub fn timed<T>(&self, stage: &str, what: &str, work: impl FnOnce() -> T) -> (T, f64) {
        let (_running, started) = (self.begin(stage, what), Instant::now());
        (work(), started.elapsed().as_secs_f64())
    }

    /// Something must be read before any result.
    pub fn warn(&self, words: &str) {
        self.call_back(Event::Warning { words });
    }

    /// A stage has a result.
    pub fn done(&self, stage: &str, figures: &str) {
        self.call_back(Event::Done { stage, figures });
    }
}

/// The results that stages reported, kept to be reported later: those of one of several attempts.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Results(Vec<(String, String)>);

impl Results {
    /// Runs the work and returns its value with the results that it reported.
    pub fn of<T>(work: impl FnOnce(&Progress) -> T) -> (T, Self) {
        let found = Mutex::new(vec![]);
        let keep = |event: Event| {
            if let Event::Done { stage, figures } = event {
                let mut all = found.lock().unwrap_or_else(PoisonError::into_inner);
                all.push((stage.to_owned(), figures.to_owned()));
            }
        };
        let value = work(&Progress::new(&keep));
        (value, Self(found.into_inner().unwrap_or_else(PoisonError::into_inner)))
    }

    /// Reports the results in their order.
    pub fn tell(&self, progress: &Progress) {
        self.0.iter().for_each(|(stage, figures)| progress.done(stage, figures));
    }
}

impl Debug for Progress<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "Progress({})", if self.0.is_some() { "called back" } else { "silent" })
    }
}

/// A stage under way.
#[derive(Debug)]
pub struct Running<'p> {
    progress: Progress<'p>,
}

impl Drop for Running<'_> {
    fn drop(&mut self) {
        self.progress.call_back(Event::Ended);
    }
}
