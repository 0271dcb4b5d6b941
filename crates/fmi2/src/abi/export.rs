//! The macro that exports the generic functions under their C names.

/// Exports the 44 functions of FMI 2.0 for one model: 34 for co-simulation, and 10 more for model exchange.
///
/// Only one crate of a binary may use it, hence a separate crate for each shared library:
///
/// ```text
/// squid_fmi2::export!(autopilot::Autopilot);
/// ```
#[macro_export]
macro_rules! export {
    ($model:ty) => {
        const _: () = {
            use ::std::ffi::{c_char, c_int};
            use $crate::abi::{CallbackFunctions, Component, EventInfo, FmuState, Status, StatusKind};
            use $crate::abi::{access, exchange, lifecycle, state, step};

            $crate::export_functions! { $model,
                fmi2SetDebugLogging = lifecycle::set_debug_logging
                    (on: c_int, count: usize, categories: *const *const c_char);
                fmi2SetupExperiment = lifecycle::setup_experiment
                    (tolerance_defined: c_int, tolerance: f64, start: f64, stop_defined: c_int, stop: f64);
                fmi2EnterInitializationMode = lifecycle::enter_initialization_mode ();
                fmi2ExitInitializationMode = lifecycle::exit_initialization_mode ();
                fmi2Terminate = lifecycle::terminate ();
                fmi2Reset = lifecycle::reset ();
                fmi2GetReal = access::get_real (references: *const u32, count: usize, values: *mut f64);
                fmi2GetInteger = access::get_integer (references: *const u32, count: usize, values: *mut c_int);
                fmi2GetBoolean = access::get_boolean (references: *const u32, count: usize, values: *mut c_int);
                fmi2GetString = access::get_string (references: *const u32, count: usize, values: *mut *const c_char);
                fmi2SetReal = access::set_real (references: *const u32, count: usize, values: *const f64);
                fmi2SetInteger = access::set_integer (references: *const u32, count: usize, values: *const c_int);
                fmi2SetBoolean = access::set_boolean (references: *const u32, count: usize, values: *const c_int);
                fmi2SetString = access::set_string
                    (references: *const u32, count: usize, values: *const *const c_char);
                fmi2GetFMUstate = state::get_fmu_state (state: *mut FmuState);
                fmi2SetFMUstate = state::set_fmu_state (state: FmuState);
                fmi2FreeFMUstate = state::free_fmu_state (state: *mut FmuState);
                fmi2SerializedFMUstateSize = state::serialized_fmu_state_size (state: FmuState, size: *mut usize);
                fmi2SerializeFMUstate = state::serialize_fmu_state (state: FmuState, bytes: *mut u8, size: usize);
                fmi2DeSerializeFMUstate = state::deserialize_fmu_state
                    (bytes: *const u8, size: usize, state: *mut FmuState);
                fmi2GetDirectionalDerivative = state::get_directional_derivative
                    (unknowns: *const u32, unknown_count: usize, knowns: *const u32, known_count: usize,
                     seed: *const f64, sensitivity: *mut f64);
                fmi2EnterEventMode = exchange::enter_event_mode ();
                fmi2NewDiscreteStates = exchange::new_discrete_states (info: *mut EventInfo);
                fmi2EnterContinuousTimeMode = exchange::enter_continuous_time_mode ();
                fmi2CompletedIntegratorStep = exchange::completed_integrator_step
                    (no_set_state_prior: c_int, enter_event_mode: *mut c_int, terminate: *mut c_int);
                fmi2SetTime = exchange::set_time (time: f64);
                fmi2SetContinuousStates = exchange::set_continuous_states (states: *const f64, count: usize);
                fmi2GetDerivatives = exchange::get_derivatives (derivatives: *mut f64, count: usize);
                fmi2GetEventIndicators = exchange::get_event_indicators (indicators: *mut f64, count: usize);
                fmi2GetContinuousStates = exchange::get_continuous_states (states: *mut f64, count: usize);
                fmi2GetNominalsOfContinuousStates = exchange::get_nominals_of_continuous_states
                    (nominals: *mut f64, count: usize);
                fmi2SetRealInputDerivatives = step::set_real_input_derivatives
                    (references: *const u32, count: usize, orders: *const c_int, values: *const f64);
                fmi2GetRealOutputDerivatives = step::get_real_output_derivatives
                    (references: *const u32, count: usize, orders: *const c_int, values: *mut f64);
                fmi2DoStep = step::do_step (at: f64, size: f64, no_set_state_prior: c_int);
                fmi2CancelStep = step::cancel_step ();
                fmi2GetStatus = step::get_status (kind: StatusKind, value: *mut Status);
                fmi2GetRealStatus = step::get_real_status (kind: StatusKind, value: *mut f64);
                fmi2GetIntegerStatus = step::get_integer_status (kind: StatusKind, value: *mut c_int);
                fmi2GetBooleanStatus = step::get_boolean_status (kind: StatusKind, value: *mut c_int);
                fmi2GetStringStatus = step::get_string_status (kind: StatusKind, value: *mut *const c_char);
            }

            #[unsafe(no_mangle)]
            #[allow(unsafe_code)]
            extern "C" fn fmi2GetTypesPlatform() -> *const c_char {
                lifecycle::get_types_platform()
            }

            #[unsafe(no_mangle)]
            #[allow(unsafe_code)]
            extern "C" fn fmi2GetVersion() -> *const c_char {
                lifecycle::get_version()
            }

            #[unsafe(no_mangle)]
            #[allow(unsafe_code)]
            unsafe extern "C" fn fmi2Instantiate(
                name: *const c_char,
                fmu_type: c_int,
                guid: *const c_char,
                location: *const c_char,
                functions: *const CallbackFunctions,
                visible: c_int,
                logging_on: c_int,
            ) -> Component {
                // SAFETY: the importer observes the contract of the C function of this name.
                unsafe {
                    lifecycle::instantiate::<$model>(
                        name, fmu_type, guid, location, functions, visible, logging_on,
                    )
                }
            }

            #[unsafe(no_mangle)]
            #[allow(unsafe_code)]
            unsafe extern "C" fn fmi2FreeInstance(component: Component) {
                // SAFETY: the importer observes the contract of the C function of this name.
                unsafe { lifecycle::free_instance::<$model>(component) }
            }
        };
    };
}

/// Exports functions that take an instance and the listed arguments and return a status.
#[doc(hidden)]
#[macro_export]
macro_rules! export_functions {
    ($model:ty, $($name:ident = $file:ident::$function:ident ($($argument:ident: $type:ty),*);)+) => {
        $(
            #[unsafe(no_mangle)]
            #[allow(unsafe_code)]
            unsafe extern "C" fn $name(component: Component, $($argument: $type),*) -> Status {
                // SAFETY: the importer observes the contract of the C function of this name.
                unsafe { $file::$function::<$model>(component, $($argument),*) }
            }
        )+
    };
}
