//! What the command prints.

use serde::Serialize;
use squid_design::error::StoreError;
use std::io::{self, ErrorKind, Write};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

/// Why output was lost first.
static UNSAID: Mutex<Option<io::Error>> = Mutex::new(None);

/// Whether the one thing printed is an object for programs, and whether it has been printed.
static AS_JSON: AtomicBool = AtomicBool::new(false);
static ANSWERED: AtomicBool = AtomicBool::new(false);

/// From now on [`say`] prints nothing, and the first [`answer`] is printed.
pub fn answer_in_json() {
    AS_JSON.store(true, Ordering::Relaxed);
}

/// Whether the answer is for programs.
pub fn is_for_programs() -> bool {
    AS_JSON.load(Ordering::Relaxed)
}

/// What a verb found, for programs: printed with `--json`, the first time that it is called.
///
/// # Errors
/// [`StoreError::Json`] for a value that JSON cannot hold.
pub fn answer(found: &impl Serialize) -> Result<(), StoreError> {
    if is_for_programs() && !ANSWERED.swap(true, Ordering::Relaxed) {
        print_line(&json(found)?);
    }
    Ok(())
}

/// A value as one line of JSON.
///
/// # Errors
/// [`StoreError::Json`].
pub fn json(value: &impl Serialize) -> Result<String, StoreError> {
    serde_json::to_string(value).map_err(|reason| StoreError::Json { path: "standard output".into(), reason })
}

/// Prints words for people to standard output. A failure is kept for [`all_said`] and does not stop the work.
pub fn say(text: &str) {
    if !is_for_programs() {
        print_line(text);
    }
}

fn print_line(text: &str) {
    let mut out = io::stdout().lock();
    printed(writeln!(out, "{text}").and_then(|()| out.flush()));
}

/// Keeps the first reason why something could not be printed. A closed pipe, as by `head`, does not count.
pub fn printed(outcome: io::Result<()>) {
    if let (Err(reason), Ok(mut first)) = (outcome, UNSAID.lock()) {
        let lost = reason.kind() != ErrorKind::BrokenPipe;
        *first = first.take().or(Some(reason).filter(|_| lost));
    }
}

/// Whether everything since the last call could be printed.
///
/// # Errors
/// [`StoreError::Unwritable`] with the first reason.
pub fn all_said() -> Result<(), StoreError> {
    let lost = UNSAID.lock().ok().and_then(|mut first| first.take());
    lost.map_or(Ok(()), |reason| Err(StoreError::Unwritable { path: "standard output".into(), reason }))
}
