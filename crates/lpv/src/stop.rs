//! Stopping a long computation from outside.
//!
//! A computation that nobody waits for any more ends by unwinding, as a panic does but without its message: whoever
//! started the threads catches that. Only threads that were told of a [`Stop`] obey one, so that computations beside it
//! go on.

use std::cell::RefCell;
use std::panic::resume_unwind;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

thread_local! {
    static OBEYED: RefCell<Option<Stop>> = const { RefCell::new(None) };
}

/// Asks the threads that obey it to stop.
#[derive(Debug, Clone, Default)]
pub struct Stop(Arc<AtomicBool>);

/// What a stopped computation unwinds with.
#[derive(Debug, Clone, Copy)]
pub struct Stopped;

impl Stop {
    /// This thread obeys it from now on.
    pub fn obeyed_here(&self) {
        OBEYED.with_borrow_mut(|obeyed| *obeyed = Some(self.clone()));
    }

    /// Stops what runs on the threads that obey it, at their next [`check`].
    pub fn ask(&self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// Whether this thread is asked to stop.
pub fn is_asked() -> bool {
    OBEYED.with_borrow(|obeyed| obeyed.as_ref().is_some_and(|stop| stop.0.load(Ordering::Relaxed)))
}

/// Unwinds with [`Stopped`] if this thread is asked to stop. Called in each step of what takes long.
pub fn check() {
    if is_asked() {
        resume_unwind(Box::new(Stopped));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::panic::catch_unwind;
    use std::thread::spawn;

    #[test]
    fn only_threads_that_were_told_obey() {
        let stop = Stop::default();
        stop.ask();
        let obeys = stop.clone();
        let obedient = spawn(move || {
            obeys.obeyed_here();
            catch_unwind(check).map_err(|reason| reason.is::<Stopped>())
        });
        assert_eq!(obedient.join().unwrap(), Err(true));
        assert!(spawn(|| catch_unwind(check).is_ok()).join().unwrap());
    }
}
