//! What the command prints.

use squid_design::error::StoreError;
use std::io::{self, ErrorKind, Write};
use std::sync::Mutex;

/// The first thing that could not be printed.
static UNSAID: Mutex<Option<io::Error>> = Mutex::new(None);

/// Prints to standard output. What fails is kept for [`all_said`]: it is no reason to stop working.
pub fn say(text: &str) {
    let mut out = io::stdout().lock();
    printed(writeln!(out, "{text}").and_then(|()| out.flush()));
}

/// Keeps why something could not be printed. A reader that went away, as `head` does, wants no more, and misses
/// nothing.
pub fn printed(outcome: io::Result<()>) {
    if let (Err(reason), Ok(mut first)) = (outcome, UNSAID.lock()) {
        let lost = reason.kind() != ErrorKind::BrokenPipe;
        *first = first.take().or(Some(reason).filter(|_| lost));
    }
}

/// Whether all that was said since the last call could be printed.
///
/// # Errors
/// [`StoreError::Unwritable`] with the first reason why not.
pub fn all_said() -> Result<(), StoreError> {
    let lost = UNSAID.lock().ok().and_then(|mut first| first.take());
    lost.map_or(Ok(()), |reason| Err(StoreError::Unwritable { path: "standard output".into(), reason }))
}
