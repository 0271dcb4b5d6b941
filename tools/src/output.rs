//! What the command prints.

use squid_design::error::StoreError;
use std::io::{self, ErrorKind, Write};
use std::sync::Mutex;

/// Why output was lost first.
static UNSAID: Mutex<Option<io::Error>> = Mutex::new(None);

/// Prints to standard output. A failure is kept for [`all_said`] and does not stop the work.
pub fn say(text: &str) {
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
