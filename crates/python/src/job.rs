//! Long computations without Python's lock, with progress reports, and interruptible by Ctrl-C.

use pyo3::exceptions::PyRuntimeError;
use pyo3::types::PyAnyMethods;
use pyo3::{Py, PyAny, PyErr, PyResult, Python};
use rayon::ThreadPoolBuilder;
use squid_base::progress::{Event, Progress};
use squid_lpv::stop::{Stop, Stopped};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::Result as Outcome;
use std::time::Duration;

/// Interval at which Python checks for Ctrl-C.
const POLL_INTERVAL: Duration = Duration::from_millis(50);

enum Message<T> {
    Progress(&'static str, String, String),
    Ended(Outcome<T>),
}

/// Runs `work` on its own threads, one per core. `progress` is called with the kind of each event (`began`, `done`,
/// `warning`), the stage or the kind of the finding, and a text. If it raises, or Ctrl-C is pressed, this returns at
/// once and the work ends at its next step.
///
/// # Errors
/// The exception that `progress` raises; `KeyboardInterrupt`; `RuntimeError` for an internal error.
pub fn run<T: Send + 'static>(
    python: Python<'_>,
    progress: Option<Py<PyAny>>,
    work: impl FnOnce(&Progress<'_>) -> T + Send + 'static,
) -> PyResult<T> {
    let stop = Stop::default();
    let installed = stop.clone();
    let pool = ThreadPoolBuilder::new().start_handler(move |_| installed.install()).build();
    let pool = pool.map_err(|reason| PyRuntimeError::new_err(reason.to_string()))?;
    let (to, mut from) = channel();
    pool.spawn(move || {
        let back = |event: Event<'_>| send_progress(&to, event);
        let outcome = catch_unwind(AssertUnwindSafe(|| work(&Progress::new(&back))));
        let _ = to.send(Message::Ended(outcome));
    });
    loop {
        let message;
        (message, from) = python.detach(move || wait(from));
        let outcome = match message {
            Ok(Message::Ended(outcome)) => return outcome.map_err(|reason| defect(&*reason)),
            Ok(Message::Progress(kind, stage, text)) => progress
                .as_ref()
                .map_or(Ok(()), |call| call.bind(python).call1((kind, stage, text)).map(|_| ())),
            Err(RecvTimeoutError::Timeout) => python.check_signals(),
            Err(RecvTimeoutError::Disconnected) => {
                Err(PyRuntimeError::new_err("the work ended without a result"))
            }
        };
        outcome.inspect_err(|_| stop.request())?;
    }
}

type Received<T> = Result<Message<T>, RecvTimeoutError>;

fn wait<T>(from: Receiver<Message<T>>) -> (Received<T>, Receiver<Message<T>>) {
    (from.recv_timeout(POLL_INTERVAL), from)
}

fn send_progress<T>(to: &Sender<Message<T>>, event: Event<'_>) {
    let (kind, stage, text) = match event {
        Event::Began { stage, what } => ("began", stage, what),
        Event::Done { stage, figures } => ("done", stage, figures),
        Event::Warning(finding) => ("warning", finding.kind.as_str(), finding.why.as_str()),
        Event::Ended => return,
    };
    let _ = to.send(Message::Progress(kind, stage.to_owned(), text.to_owned()));
}

/// Returns the exception for a panic, which is an internal error.
fn defect(reason: &(dyn std::any::Any + Send)) -> PyErr {
    let message =
        match (reason.is::<Stopped>(), reason.downcast_ref::<String>(), reason.downcast_ref::<&str>()) {
            (true, _, _) => "stopped",
            (_, Some(text), _) => text,
            (_, _, Some(text)) => text,
            _ => "no message",
        };
    PyRuntimeError::new_err(format!("internal error in squid_lpv (please report it): {message}"))
}
