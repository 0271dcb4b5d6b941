//! Progress for people: one line a stage, with its key figure.

use crate::output::say;
use indicatif::{ProgressBar, ProgressStyle};
use std::time::{Duration, Instant};

/// Prints stages as they pass. The finished lines go to standard output, the moving ones to the terminal.
#[derive(Debug, Default)]
pub struct Stages {
    quiet: bool,
}

impl Stages {
    /// Prints nothing.
    pub fn quiet() -> Self {
        Self { quiet: true }
    }

    /// Says that a stage is under way; the guard clears the line when it goes.
    pub fn begin(&self, name: &str, what: &str) -> Running {
        if self.quiet {
            return Running { bar: ProgressBar::hidden(), started: Instant::now() };
        }
        let bar = ProgressBar::new_spinner();
        if let Ok(style) = ProgressStyle::with_template("{spinner} {msg} {elapsed}") {
            bar.set_style(style);
        }
        bar.set_message(format!("{name:<12} {what}"));
        bar.enable_steady_tick(Duration::from_millis(120));
        Running { bar, started: Instant::now() }
    }

    /// Says that a stage is done, with its key figure.
    pub fn done(&self, name: &str, figure: &str) {
        if !self.quiet {
            for (i, line) in figure.lines().enumerate() {
                say(&format!("{:<12} {line}", if i == 0 { name } else { "" }));
            }
        }
    }
}

/// A stage under way.
#[derive(Debug)]
pub struct Running {
    bar: ProgressBar,
    started: Instant,
}

impl Running {
    /// Seconds since it began.
    pub fn seconds(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
