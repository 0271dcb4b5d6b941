//! Progress on the terminal: one line for each stage, with its key figure.

use crate::output::{say_indented, warn};
use indicatif::{ProgressBar, ProgressStyle};
use squid_base::progress::Event;
use std::sync::Mutex;
use std::time::Duration;

/// Spinners of the stages in progress.
static RUNNING: Mutex<Vec<ProgressBar>> = Mutex::new(Vec::new());

/// Width of the name of a stage, with the space after it.
const STAGE: usize = 13;

/// Update interval of a spinner.
const TICK: Duration = Duration::from_millis(120);

/// Shows an event. Results go to standard output, spinners to the terminal.
pub fn show(event: Event) {
    match event {
        Event::Began { stage, what } => {
            let text = format!("{stage:<12} {what}");
            let bar = moving(ProgressBar::new_spinner(), "{spinner} {msg} {elapsed}", &text);
            if let Ok(mut all) = RUNNING.lock() {
                all.push(bar);
            }
        }
        Event::Ended => {
            if let Some(bar) = RUNNING.lock().ok().and_then(|mut all| all.pop()) {
                bar.finish_and_clear();
            }
        }
        Event::Warning(finding) => warn(finding),
        Event::Done { stage, figures } => {
            for (i, line) in figures.lines().enumerate() {
                say_indented(&format!("{:<12} {line}", if i == 0 { stage } else { "" }), STAGE);
            }
        }
    }
}

/// Returns a progress bar that counts up to a number; `finish_and_clear`, or dropping it, clears it.
pub fn counter(stage: &str, up_to: u64) -> ProgressBar {
    moving(ProgressBar::new(up_to), "{spinner} {msg:<12} {pos} of {len} {wide_bar} {eta}", stage)
}

fn moving(bar: ProgressBar, template: &str, text: &str) -> ProgressBar {
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
    bar.set_message(text.to_owned());
    bar.enable_steady_tick(TICK);
    bar
}
