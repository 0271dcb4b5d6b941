//! The object behind a `fmi2Component`, and the checks common to all calls.

use std::any::Any;
use std::ffi::CString;
use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::abi::environment::in_default;
use crate::abi::logger::Logger;
use crate::abi::types::{self, Status};
use crate::instance::Outcome;
use crate::{Failure, Function, Instance, Model, Refusal};

/// An instance with its logger and the strings that the importer may still read.
pub(crate) struct Component<M: Model> {
    pub(crate) instance: Instance<M>,
    pub(crate) logger: Logger,
    /// Strings of the last `fmi2GetString`.
    pub(crate) strings: Vec<CString>,
    /// Status of the last `fmi2DoStep` that left the instance ready for another one.
    pub(crate) last_step: Status,
}

/// Runs one call in the default floating-point environment: checks handle and state table, catches panics, logs errors,
/// and returns the status.
///
/// # Safety
/// `component` is NULL or a handle from `fmi2Instantiate::<M>` that was not freed and is in no other call.
pub(crate) unsafe fn call<M: Model>(
    component: types::Component,
    function: Function,
    body: impl FnOnce(&mut Component<M>) -> Outcome<M>,
) -> Status {
    // SAFETY: the caller guarantees the handle.
    let Some(component) = (unsafe { component.cast::<Component<M>>().as_mut() }) else {
        return Status::Error;
    };
    in_default(|| run(component, function, body))
}

fn run<M: Model>(
    component: &mut Component<M>,
    function: Function,
    body: impl FnOnce(&mut Component<M>) -> Outcome<M>,
) -> Status {
    if let Err(refusal) = component.instance.allows(function) {
        component.logger.error(function.name(), &refusal);
        return Status::Error;
    }
    component.logger.warned = false;
    // Unwind safety: after a panic the instance is fatal and accepts `fmi2FreeInstance` only.
    match catch_unwind(AssertUnwindSafe(|| body(component))) {
        Ok(Ok(())) if component.logger.warned => Status::Warning,
        Ok(Ok(())) => Status::Ok,
        // With `fmi2Discard` an integrator can take a shorter step (section 2.1.3).
        Ok(Err(failure @ Failure::Refused(Refusal::Undefined { .. }))) => {
            component.logger.discard(function.name(), &failure);
            Status::Discard
        }
        Ok(Err(failure)) => {
            component.logger.error(function.name(), &failure);
            Status::Error
        }
        Err(payload) => {
            component.instance.abandon();
            component.logger.fatal(function.name(), panic_text(&*payload));
            Status::Fatal
        }
    }
}

/// C functions that take an instance and return its status: name, further arguments, row of the state table, and body.
macro_rules! functions {
    ($(
        $(#[$about:meta])*
        $name:ident($($argument:ident: $type:ty),*) = $function:ident, |$own:ident| $body:expr;
    )+) => {
        $(
            $(#[$about])*
            ///
            /// # Safety
            /// `component` is NULL or a live handle of this model. Every other pointer is NULL or as the standard
            /// requires: an array of the given length, a NUL-terminated string, writable memory, or a state of the
            /// same model.
            pub unsafe extern "C" fn $name<M: Model>(
                component: types::Component,
                $($argument: $type),*
            ) -> Status {
                let body = |$own: &mut Component<M>| -> Outcome<M> { $body };
                // SAFETY: the importer guarantees the handle.
                unsafe { call(component, Function::$function, body) }
            }
        )+
    };
}
pub(crate) use functions;

/// Returns the text of a panic.
pub(crate) fn panic_text(payload: &(dyn Any + Send)) -> &str {
    let text = payload.downcast_ref::<&str>().copied();
    text.or_else(|| payload.downcast_ref::<String>().map(String::as_str)).unwrap_or("panic without a text")
}
