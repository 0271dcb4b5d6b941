//! Progress on the terminal: a line for each stage, with its key figure.

use crate::output::say;
use indicatif::{ProgressBar, ProgressStyle};
use squid_design::progress::Event;
use std::sync::Mutex;
use std::time::Duration;

/// The moving line of the stage under way, if there is one.
static RUNNING: Mutex<Vec<ProgressBar>> = Mutex::new(Vec::new());

/// How often a moving line moves.
const TICK: Duration = Duration::from_millis(120);

/// Shows an event. Results go to standard output, the moving line to the terminal.
pub fn show(event: Event) {
    match event {
        Event::Began { stage, what } => begin(&format!("{stage:<12} {what}")),
        Event::Ended => {
            if let Some(bar) = RUNNING.lock().ok().and_then(|mut all| all.pop()) {
                bar.finish_and_clear();
            }
        }
        Event::Warning { words } => say(words),
        Event::Done { stage, figures } => {
            for (i, line) in figures.lines().enumerate() {
                say(&format!("{:<12} {line}", if i == 0 { stage } else { "" }));
            }
        }
    }
}

fn begin(words: &str) {
    let bar = ProgressBar::new_spinner();
    if let Ok(style) = ProgressStyle::with_template("{spinner} {msg} {elapsed}") {
        bar.set_style(style);
    }
    bar.set_message(words.to_owned());
    bar.enable_steady_tick(TICK);
    if let Ok(mut all) = RUNNING.lock() {
        all.push(bar);
    }
}

/// A moving line that counts.
#[derive(Debug)]
pub struct Counter(ProgressBar);

impl Counter {
    /// Of a stage, up to a number.
    pub fn new(stage: &str, up_to: u64) -> Self {
        let bar = ProgressBar::new(up_to);
        if let Ok(style) = ProgressStyle::with_template("{spinner} {msg:<12} {pos} of {len} {wide_bar} {eta}")
        {
            bar.set_style(style);
        }
        bar.set_message(stage.to_owned());
        bar.enable_steady_tick(TICK);
        Self(bar)
    }

    /// So many are done.
    pub fn at(&self, done: u64) {
        self.0.set_position(done);
    }
}

impl Drop for Counter {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
