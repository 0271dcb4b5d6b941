//! The macro that gives the generic functions their C names.

/// Exports the 44 functions of FMI 2.0 for one model: 34 of co-simulation, and 10 more of model exchange.
///
/// Only one crate of a binary may do so, hence the cargo feature `export` of the crates that call this:
///
/// ```text
/// #[cfg(feature = "export")]
/// fmi2::export!(Autopilot);
/// ```
#[macro_export]
macro_rules! export {
    ($model:ty) => {
        const _: () = {
            use ::std::ffi::{c_char, c_int};
            use $crate::abi::{CallbackFunctions, Component, EventInfo, FmuState, Status, StatusKind};
            use $crate::abi::{access, exchange, lifecycle, state, step};

            $crate::export_functions! { $model,
                fn fmi2GetTypesPlatform = lifecycle::get_types_platform [] () -> *const c_char;
                fn fmi2GetVersion = lifecycle::get_version [] () -> *const c_char;
                fn fmi2Instantiate = lifecycle::instantiate [$model] (
                    name: *const c_char,
                    fmu_type: c_int,
                    guid: *const c_char,
                    location: *const c_char,
                    functions: *const CallbackFunctions,
                    visible: c_int,
                    logging_on: c_int
                ) -> Component;
                fn fmi2FreeInstance = lifecycle::free_instance [$model] (component: Component) -> ();
                fn fmi2SetDebugLogging = lifecycle::set_debug_logging [$model] (
                    component: Component,
                    logging_on: c_int,
                    count: usize,
                    categories: *const *const c_char
                ) -> Status;
                fn fmi2SetupExperiment = lifecycle::setup_experiment [$model] (
                    component: Component,
                    tolerance_defined: c_int,
                    tolerance: f64,
                    start: f64,
                    stop_defined: c_int,
                    stop: f64
                ) -> Status;
                fn fmi2EnterInitializationMode = lifecycle::enter_initialization_mode [$model] (
                    component: Component
                ) -> Status;
                fn fmi2ExitInitializationMode = lifecycle::exit_initialization_mode [$model] (
                    component: Component
                ) -> Status;
                fn fmi2Terminate = lifecycle::terminate [$model] (component: Component) -> Status;
                fn fmi2Reset = lifecycle::reset [$model] (component: Component) -> Status;
                fn fmi2GetReal = access::get_real [$model] (
                    component: Component,
                    references: *const u32,
                    count: usize,
                    values: *mut f64
                ) -> Status;
                fn fmi2GetInteger = access::get_integer [$model] (
                    component: Component,
                    references: *const u32,
                    count: usize,
                    values: *mut c_int
                ) -> Status;
                fn fmi2GetBoolean = access::get_boolean [$model] (
                    component: Component,
                    references: *const u32,
                    count: usize,
                    values: *mut c_int
                ) -> Status;
                fn fmi2GetString = access::get_string [$model] (
                    component: Component,
                    references: *const u32,
                    count: usize,
                    values: *mut *const c_char
                ) -> Status;
                fn fmi2SetReal = access::set_real [$model] (
                    component: Component,
                    references: *const u32,
                    count: usize,
                    values: *const f64
                ) -> Status;
                fn fmi2SetInteger = access::set_integer [$model] (
                    component: Component,
                    references: *const u32,
                    count: usize,
                    values: *const c_int
                ) -> Status;
                fn fmi2SetBoolean = access::set_boolean [$model] (
                    component: Component,
                    references: *const u32,
                    count: usize,
                    values: *const c_int
                ) -> Status;
                fn fmi2SetString = access::set_string [$model] (
                    component: Component,
                    references: *const u32,
                    count: usize,
                    values: *const *const c_char
                ) -> Status;
                fn fmi2GetFMUstate = state::get_fmu_state [$model] (
                    component: Component,
                    state: *mut FmuState
                ) -> Status;
                fn fmi2SetFMUstate = state::set_fmu_state [$model] (
                    component: Component,
                    state: FmuState
                ) -> Status;
                fn fmi2FreeFMUstate = state::free_fmu_state [$model] (
                    component: Component,
                    state: *mut FmuState
                ) -> Status;
                fn fmi2SerializedFMUstateSize = state::serialized_fmu_state_size [$model] (
                    component: Component,
                    state: FmuState,
                    size: *mut usize
                ) -> Status;
                fn fmi2SerializeFMUstate = state::serialize_fmu_state [$model] (
                    component: Component,
                    state: FmuState,
                    bytes: *mut u8,
                    size: usize
                ) -> Status;
                fn fmi2DeSerializeFMUstate = state::deserialize_fmu_state [$model] (
                    component: Component,
                    bytes: *const u8,
                    size: usize,
                    state: *mut FmuState
                ) -> Status;
                fn fmi2GetDirectionalDerivative = state::get_directional_derivative [$model] (
                    component: Component,
                    unknowns: *const u32,
                    unknown_count: usize,
                    knowns: *const u32,
                    known_count: usize,
                    seed: *const f64,
                    sensitivity: *mut f64
                ) -> Status;
                fn fmi2EnterEventMode = exchange::enter_event_mode [$model] (component: Component) -> Status;
                fn fmi2NewDiscreteStates = exchange::new_discrete_states [$model] (
                    component: Component,
                    info: *mut EventInfo
                ) -> Status;
                fn fmi2EnterContinuousTimeMode = exchange::enter_continuous_time_mode [$model] (
                    component: Component
                ) -> Status;
                fn fmi2CompletedIntegratorStep = exchange::completed_integrator_step [$model] (
                    component: Component,
                    no_set_state_prior: c_int,
                    enter_event_mode: *mut c_int,
                    terminate: *mut c_int
                ) -> Status;
                fn fmi2SetTime = exchange::set_time [$model] (component: Component, time: f64) -> Status;
                fn fmi2SetContinuousStates = exchange::set_continuous_states [$model] (
                    component: Component,
                    states: *const f64,
                    count: usize
                ) -> Status;
                fn fmi2GetDerivatives = exchange::get_derivatives [$model] (
                    component: Component,
                    derivatives: *mut f64,
                    count: usize
                ) -> Status;
                fn fmi2GetEventIndicators = exchange::get_event_indicators [$model] (
                    component: Component,
                    indicators: *mut f64,
                    count: usize
                ) -> Status;
                fn fmi2GetContinuousStates = exchange::get_continuous_states [$model] (
                    component: Component,
                    states: *mut f64,
                    count: usize
                ) -> Status;
                fn fmi2GetNominalsOfContinuousStates = exchange::get_nominals_of_continuous_states [$model] (
                    component: Component,
                    nominals: *mut f64,
                    count: usize
                ) -> Status;
                fn fmi2SetRealInputDerivatives = step::set_real_input_derivatives [$model] (
                    component: Component,
                    references: *const u32,
                    count: usize,
                    orders: *const c_int,
                    values: *const f64
                ) -> Status;
                fn fmi2GetRealOutputDerivatives = step::get_real_output_derivatives [$model] (
                    component: Component,
                    references: *const u32,
                    count: usize,
                    orders: *const c_int,
                    values: *mut f64
                ) -> Status;
                fn fmi2DoStep = step::do_step [$model] (
                    component: Component,
                    at: f64,
                    size: f64,
                    no_set_state_prior: c_int
                ) -> Status;
                fn fmi2CancelStep = step::cancel_step [$model] (component: Component) -> Status;
                fn fmi2GetStatus = step::get_status [$model] (
                    component: Component,
                    kind: StatusKind,
                    value: *mut Status
                ) -> Status;
                fn fmi2GetRealStatus = step::get_real_status [$model] (
                    component: Component,
                    kind: StatusKind,
                    value: *mut f64
                ) -> Status;
                fn fmi2GetIntegerStatus = step::get_integer_status [$model] (
                    component: Component,
                    kind: StatusKind,
                    value: *mut c_int
                ) -> Status;
                fn fmi2GetBooleanStatus = step::get_boolean_status [$model] (
                    component: Component,
                    kind: StatusKind,
                    value: *mut c_int
                ) -> Status;
                fn fmi2GetStringStatus = step::get_string_status [$model] (
                    component: Component,
                    kind: StatusKind,
                    value: *mut *const c_char
                ) -> Status;
            }
        };
    };
}

#[doc(hidden)]
#[macro_export]
macro_rules! export_functions {
    ($model:ty, $(fn $name:ident = $file:ident::$function:ident [$($generic:ty)?] ($($argument:ident: $type:ty),*) -> $result:ty;)+) => {
        $(
            #[unsafe(no_mangle)]
            #[allow(unused_unsafe, unsafe_code)]
            unsafe extern "C" fn $name($($argument: $type),*) -> $result {
                // SAFETY: the importer keeps the contract of the C function of this name.
                unsafe { $file::$function$(::<$generic>)?($($argument),*) }
            }
        )+
    };
}
