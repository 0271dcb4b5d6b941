//! Life cycle: `fmi2Instantiate` to `fmi2FreeInstance`, and logging.

use std::ffi::{c_char, c_int};
use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::abi::component::{Component, call, functions, panic_text};
use crate::abi::environment::in_default;
use crate::abi::logger::Logger;
use crate::abi::pointers::{slice, text};
use crate::abi::types::{self, CO_SIMULATION, CallbackFunctions, MODEL_EXCHANGE, Status};
use crate::instance::Outcome;
use crate::log::{Category, Filter};
use crate::{Experiment, Function, Instance, Interface, Model, Refusal, Resources, describe, path_of};

/// `fmi2GetTypesPlatform`.
pub extern "C" fn get_types_platform() -> *const c_char {
    c"default".as_ptr()
}

/// `fmi2GetVersion`.
pub extern "C" fn get_version() -> *const c_char {
    c"2.0".as_ptr()
}

/// `fmi2Instantiate`: returns NULL and logs one sentence on any error.
///
/// # Safety
/// Strings are NULL or NUL-terminated; `functions` is NULL or points to a valid structure.
pub unsafe extern "C" fn instantiate<M: Model>(
    instance_name: *const c_char,
    fmu_type: c_int,
    fmu_guid: *const c_char,
    fmu_resource_location: *const c_char,
    functions: *const CallbackFunctions,
    _visible: c_int,
    _logging_on: c_int,
) -> types::Component {
    // SAFETY: the importer guarantees its pointers.
    let (name, guid, callbacks) =
        unsafe { (text(instance_name, "instanceName"), text(fmu_guid, "fmuGUID"), functions.as_ref()) };
    let logger = Logger::new(callbacks, name.as_ref().copied().unwrap_or("(no name)"));
    let location = if fmu_resource_location.is_null() {
        Err(Refusal::NoResourceLocation)
    } else {
        // SAFETY: not NULL, and the importer guarantees the rest.
        unsafe { text(fmu_resource_location, "fmuResourceLocation") }
    };
    in_default(|| match catch_unwind(AssertUnwindSafe(|| load::<M>(name?, fmu_type, guid?, location?))) {
        Ok(Ok(instance)) => {
            let component = Component { instance, logger, strings: Vec::new(), last_step: Status::Ok };
            Box::into_raw(Box::new(component)).cast()
        }
        Ok(Err(refusal)) => {
            logger.error(Function::Instantiate.name(), &refusal);
            std::ptr::null_mut()
        }
        Err(payload) => {
            logger.fatal(Function::Instantiate.name(), panic_text(&*payload));
            std::ptr::null_mut()
        }
    })
}

fn load<M: Model>(name: &str, fmu_type: c_int, guid: &str, location: &str) -> Result<Instance<M>, Refusal> {
    if name.is_empty() {
        return Err(Refusal::EmptyName);
    }
    let interface = match (fmu_type, M::MODEL_EXCHANGE) {
        (CO_SIMULATION, _) => Interface::CoSimulation,
        (MODEL_EXCHANGE, true) => Interface::ModelExchange,
        (given, true) => {
            return Err(Refusal::WrongFmuType {
                given,
                supported: "0 (model exchange) and 1 (co-simulation)",
            });
        }
        (given, false) => return Err(Refusal::WrongFmuType { given, supported: "1 (co-simulation)" }),
    };
    let resources = Resources::from_folder(&path_of(location)?)?;
    let loaded = describe::load::<M>(&resources)?;
    if loaded.guid != guid {
        return Err(Refusal::WrongGuid { given: guid.to_owned(), expected: loaded.guid });
    }
    if !describe::offers(loaded.interfaces, interface) {
        return Err(Refusal::InterfaceNotPacked { interface: interface.name() });
    }
    Ok(Instance::of(interface, loaded.model, loaded.table, guid))
}

/// `fmi2FreeInstance`.
///
/// # Safety
/// `component` is NULL or a handle from [`instantiate`] of the same model that was not freed.
pub unsafe extern "C" fn free_instance<M: Model>(component: types::Component) {
    if component.is_null() {
        return;
    }
    // SAFETY: the handle came from Box::into_raw, and the importer guarantees that it was not freed.
    let component = unsafe { Box::from_raw(component.cast::<Component<M>>()) };
    // A panicking destructor must not unwind into C; there is no logger left to report it.
    let _ = in_default(|| catch_unwind(AssertUnwindSafe(|| drop(component))));
}

functions! {
    /// `fmi2SetDebugLogging`.
    set_debug_logging(logging_on: c_int, count: usize, categories: *const *const c_char) = SetDebugLogging, |own| {
        // SAFETY: the importer guarantees its array.
        let names = unsafe { slice(categories, count, "categories") }?;
        let mut listed = Vec::with_capacity(count);
        for &name in names {
            // SAFETY: the importer guarantees its strings.
            let name = unsafe { text(name, "categories") }?;
            let known = Category::ALL.into_iter().find(|known| known.name() == name);
            listed.push(known.ok_or_else(|| Refusal::UnknownCategory { category: name.to_owned() })?);
        }
        own.logger.filter = if logging_on != 0 && count > 0 { Filter::listed(&listed) } else { Filter::ALL };
        Ok(())
    };
    /// `fmi2SetupExperiment`; an infinite stop time means no stop time.
    setup_experiment(tolerance_defined: c_int, tolerance: f64, start: f64, stop_defined: c_int, stop: f64)
        = SetupExperiment, |own| {
        let stop = (stop_defined != 0 && stop != f64::INFINITY).then_some(stop);
        let tolerance = (tolerance_defined != 0).then_some(tolerance);
        Ok(own.instance.set_up(Experiment { start, stop, tolerance })?)
    };
    /// `fmi2EnterInitializationMode`.
    enter_initialization_mode() = EnterInitializationMode, |own| Ok(own.instance.enter_initialization()?);
    /// `fmi2ExitInitializationMode`.
    exit_initialization_mode() = ExitInitializationMode, |own| own.instance.exit_initialization(&mut own.logger);
    /// `fmi2Terminate`.
    terminate() = Terminate, |own| Ok(own.instance.terminate()?);
    /// `fmi2Reset`.
    reset() = Reset, |own| {
        own.last_step = Status::Ok;
        Ok(own.instance.reset()?)
    };
}
