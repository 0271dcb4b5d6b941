//! Progress on the terminal: a line for each stage, with its key figure.

use crate::output::say;
use indicatif::{ProgressBar, ProgressStyle};
use squid_design::progress::Event;
use std::sync::Mutex;
use std::time::Duration;

/// The moving line of the stage under way, if there is one.
static RUNNING: Mutex<Vec<ProgressBar>> = Mutex::new(Vec::new());

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
    bar.enable_steady_tick(Duration::from_millis(120));
    if let Ok(mut all) = RUNNING.lock() {
        all.push(bar);
    }
}
