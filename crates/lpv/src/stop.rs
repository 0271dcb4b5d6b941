//! Cancellation of a long computation.
//!
//! A cancelled computation ends by unwinding, like a panic but without its message; the caller that started the threads
//! catches it. A [`Stop`] affects only the threads on which it is installed, so that other computations continue.

use std::cell::RefCell;
use std::panic::resume_unwind;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

thread_local! {
    static INSTALLED: RefCell<Option<Stop>> = const { RefCell::new(None) };
}

/// Cancels the computations of the threads on which it is installed.
#[derive(Debug, Clone, Default)]
pub struct Stop(Arc<AtomicBool>);

/// The payload of the unwinding.
#[derive(Debug, Clone, Copy)]
pub struct Stopped;

impl Stop {
    /// Installs this `Stop` on the current thread.
    pub fn install(&self) {
        INSTALLED.with_borrow_mut(|installed| *installed = Some(self.clone()));
    }

    /// Stops the threads on which it is installed, at their next [`check`].
    pub fn request(&self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// Returns `true` if the current thread is to stop.
pub fn is_requested() -> bool {
    INSTALLED.with_borrow(|installed| installed.as_ref().is_some_and(|stop| stop.0.load(Ordering::Relaxed)))
}

/// Unwinds with [`Stopped`] if the current thread is to stop. Called in each step of a long computation.
pub fn check() {
    if is_requested() {
        resume_unwind(Box::new(Stopped));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::panic::catch_unwind;
    use std::thread::spawn;

    #[test]
    fn only_threads_with_an_installed_stop_end() {
        let stop = Stop::default();
        stop.request();
        let installed = stop.clone();
        let stopped = spawn(move || {
            installed.install();
            catch_unwind(check).map_err(|reason| reason.is::<Stopped>())
        });
        assert_eq!(stopped.join().unwrap(), Err(true));
        assert!(spawn(|| catch_unwind(check).is_ok()).join().unwrap());
    }
}
