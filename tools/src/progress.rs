//! Progress on the terminal: a line for each stage, with its key figure.

use crate::output::{say, say_indented};
use indicatif::{ProgressBar, ProgressStyle};
use squid_base::progress::Event;
use std::sync::Mutex;
use std::time::Duration;

/// The moving line of the stage under way, if there is one.
static RUNNING: Mutex<Vec<ProgressBar>> = Mutex::new(Vec::new());

/// The columns of the name of a stage, and the space after it.
const STAGE: usize = 13;

/// How often a moving line moves.
const TICK: Duration = Duration::from_millis(120);

/// Shows an event. Results go to standard output, the moving line to the terminal.
pub fn show(event: Event) {
    match event {
        Event::Began { stage, what } => {
            let words = format!("{stage:<12} {what}");
            let bar = moving(ProgressBar::new_spinner(), "{spinner} {msg} {elapsed}", &words);
            if let Ok(mut all) = RUNNING.lock() {
                all.push(bar);
            }
        }
        Event::Ended => {
            if let Some(bar) = RUNNING.lock().ok().and_then(|mut all| all.pop()) {
                bar.finish_and_clear();
            }
        }
        Event::Warning { words } => say(words),
        Event::Done { stage, figures } => {
            for (i, line) in figures.lines().enumerate() {
                say_indented(&format!("{:<12} {line}", if i == 0 { stage } else { "" }), STAGE);
            }
        }
    }
}

/// The progress of work that runs beside other work, kept until it can be shown.
#[derive(Default)]
pub struct Later(Mutex<Vec<(Option<String>, String)>>);

impl Later {
    /// Keeps an event; that a stage began or ended is not kept.
    pub fn keep(&self, event: Event) {
        let said = match event {
            Event::Warning { words } => (None, words.to_owned()),
            Event::Done { stage, figures } => (Some(stage.to_owned()), figures.to_owned()),
            Event::Began { .. } | Event::Ended => return,
        };
        if let Ok(mut all) = self.0.lock() {
            all.push(said);
        }
    }

    /// Shows what was kept.
    pub fn show(self) {
        for (stage, words) in self.0.into_inner().unwrap_or_default() {
            show(match &stage {
                Some(stage) => Event::Done { stage, figures: &words },
                None => Event::Warning { words: &words },
            });
        }
    }
}

/// A moving line that counts up to a number; it is cleared with `finish_and_clear`, or when it is dropped.
pub fn counter(stage: &str, up_to: u64) -> ProgressBar {
    moving(ProgressBar::new(up_to), "{spinner} {msg:<12} {pos} of {len} {wide_bar} {eta}", stage)
}

fn moving(bar: ProgressBar, template: &str, words: &str) -> ProgressBar {
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
    bar.set_message(words.to_owned());
    bar.enable_steady_tick(TICK);
    bar
}
