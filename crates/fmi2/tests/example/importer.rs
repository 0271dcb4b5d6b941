//! A minimal importer: the C functions as declared in a C header, and a logger that records messages.

#![allow(dead_code, reason = "not every test needs everything")]

use std::cell::RefCell;
use std::ffi::{CStr, CString, c_char, c_int, c_void};

use squid_fmi2::abi::{CallbackFunctions, Component, EventInfo, FmuState, Logger, Status, StatusKind};
use squid_fmi2::{Interface, Resources, describe};

use crate::example::Lag;

squid_fmi2::export!(Lag);

#[rustfmt::skip]
unsafe extern "C" {
    pub fn fmi2GetTypesPlatform() -> *const c_char;
    pub fn fmi2GetVersion() -> *const c_char;
    pub fn fmi2Instantiate(name: *const c_char, fmu_type: c_int, guid: *const c_char, location: *const c_char,
        functions: *const CallbackFunctions, visible: c_int, logging_on: c_int) -> Component;
    pub fn fmi2FreeInstance(c: Component);
    pub fn fmi2SetDebugLogging(c: Component, on: c_int, n: usize, categories: *const *const c_char) -> Status;
    pub fn fmi2SetupExperiment(c: Component, defined: c_int, tolerance: f64, start: f64, stop_defined: c_int,
        stop: f64) -> Status;
    pub fn fmi2EnterInitializationMode(c: Component) -> Status;
    pub fn fmi2ExitInitializationMode(c: Component) -> Status;
    pub fn fmi2Terminate(c: Component) -> Status;
    pub fn fmi2Reset(c: Component) -> Status;
    pub fn fmi2GetReal(c: Component, vr: *const u32, n: usize, value: *mut f64) -> Status;
    pub fn fmi2GetInteger(c: Component, vr: *const u32, n: usize, value: *mut c_int) -> Status;
    pub fn fmi2GetBoolean(c: Component, vr: *const u32, n: usize, value: *mut c_int) -> Status;
    pub fn fmi2GetString(c: Component, vr: *const u32, n: usize, value: *mut *const c_char) -> Status;
    pub fn fmi2SetReal(c: Component, vr: *const u32, n: usize, value: *const f64) -> Status;
    pub fn fmi2SetInteger(c: Component, vr: *const u32, n: usize, value: *const c_int) -> Status;
    pub fn fmi2SetBoolean(c: Component, vr: *const u32, n: usize, value: *const c_int) -> Status;
    pub fn fmi2SetString(c: Component, vr: *const u32, n: usize, value: *const *const c_char) -> Status;
    pub fn fmi2GetFMUstate(c: Component, state: *mut FmuState) -> Status;
    pub fn fmi2SetFMUstate(c: Component, state: FmuState) -> Status;
    pub fn fmi2FreeFMUstate(c: Component, state: *mut FmuState) -> Status;
    pub fn fmi2SerializedFMUstateSize(c: Component, state: FmuState, size: *mut usize) -> Status;
    pub fn fmi2SerializeFMUstate(c: Component, state: FmuState, bytes: *mut u8, size: usize) -> Status;
    pub fn fmi2DeSerializeFMUstate(c: Component, bytes: *const u8, size: usize, state: *mut FmuState) -> Status;
    pub fn fmi2GetDirectionalDerivative(c: Component, unknowns: *const u32, n: usize, knowns: *const u32, m: usize,
        seed: *const f64, sensitivity: *mut f64) -> Status;
    pub fn fmi2EnterEventMode(c: Component) -> Status;
    pub fn fmi2NewDiscreteStates(c: Component, info: *mut EventInfo) -> Status;
    pub fn fmi2EnterContinuousTimeMode(c: Component) -> Status;
    pub fn fmi2CompletedIntegratorStep(c: Component, no_set_state: c_int, event: *mut c_int, end: *mut c_int) -> Status;
    pub fn fmi2SetTime(c: Component, time: f64) -> Status;
    pub fn fmi2SetContinuousStates(c: Component, x: *const f64, n: usize) -> Status;
    pub fn fmi2GetDerivatives(c: Component, x: *mut f64, n: usize) -> Status;
    pub fn fmi2GetEventIndicators(c: Component, z: *mut f64, n: usize) -> Status;
    pub fn fmi2GetContinuousStates(c: Component, x: *mut f64, n: usize) -> Status;
    pub fn fmi2GetNominalsOfContinuousStates(c: Component, x: *mut f64, n: usize) -> Status;
    pub fn fmi2SetRealInputDerivatives(c: Component, vr: *const u32, n: usize, order: *const c_int,
        value: *const f64) -> Status;
    pub fn fmi2GetRealOutputDerivatives(c: Component, vr: *const u32, n: usize, order: *const c_int,
        value: *mut f64) -> Status;
    pub fn fmi2DoStep(c: Component, at: f64, size: f64, no_set_state: c_int) -> Status;
    pub fn fmi2CancelStep(c: Component) -> Status;
    pub fn fmi2GetStatus(c: Component, kind: StatusKind, value: *mut Status) -> Status;
    pub fn fmi2GetRealStatus(c: Component, kind: StatusKind, value: *mut f64) -> Status;
    pub fn fmi2GetIntegerStatus(c: Component, kind: StatusKind, value: *mut c_int) -> Status;
    pub fn fmi2GetBooleanStatus(c: Component, kind: StatusKind, value: *mut c_int) -> Status;
    pub fn fmi2GetStringStatus(c: Component, kind: StatusKind, value: *mut *const c_char) -> Status;
}

/// Input of [`Lag`].
pub const U: u32 = 0;
/// Output of [`Lag`].
pub const Y: u32 = 1;
/// Parameter of [`Lag`].
pub const GAIN: u32 = 2;

/// Returns the value of a Real, which must be defined.
pub fn real(c: Component, reference: u32) -> f64 {
    let mut value = f64::NAN;
    assert_eq!(unsafe { fmi2GetReal(c, &reference, 1, &mut value) }, Status::Ok, "{:?}", messages());
    value
}

/// Sets a Real.
pub fn set(c: Component, reference: u32, value: f64) -> Status {
    unsafe { fmi2SetReal(c, &reference, 1, &value) }
}

thread_local! {
    static MESSAGES: RefCell<Vec<String>> = const { RefCell::new(Vec::new()) };
}

/// Records "name status category message"; its fixed arguments are those of `fmi2CallbackLogger`. It reads no variable
/// arguments, like the loggers of some importers, so that the format must be the complete message.
unsafe extern "C" fn remember(
    _: *mut c_void,
    name: *const c_char,
    status: Status,
    category: *const c_char,
    format: *const c_char,
) {
    let text = |pointer| unsafe { CStr::from_ptr(pointer) }.to_str().unwrap().to_owned();
    let format = text(format);
    assert!(!format.replace("%%", "").contains('%'), "no conversion: {format}");
    let line = format!("{} {status:?} {} {}", text(name), text(category), format.replace("%%", "%"));
    MESSAGES.with_borrow_mut(|messages| messages.push(line));
}

/// Returns the messages since the last call of this function.
pub fn messages() -> Vec<String> {
    MESSAGES.take()
}

pub fn callbacks() -> CallbackFunctions {
    type Fixed = unsafe extern "C" fn(*mut c_void, *const c_char, Status, *const c_char, *const c_char);
    // The calling convention of variadic functions is that of others on the platforms of the tests.
    let logger = unsafe { std::mem::transmute::<Fixed, Logger>(remember) };
    CallbackFunctions {
        logger: Some(logger),
        allocate_memory: None,
        free_memory: None,
        step_finished: None,
        component_environment: std::ptr::null_mut(),
    }
}

/// A folder with the resources of a lag of gain 2, its GUID and URI.
pub struct Unpacked {
    _folder: tempfile::TempDir,
    pub guid: CString,
    pub uri: CString,
}

pub fn unpack() -> Unpacked {
    unpack_with("2.0\n")
}

/// Unpacks the resources with another gain.
pub fn unpack_with(gain: &str) -> Unpacked {
    unpack_files(&[("gain.txt", gain)])
}

/// Unpacks other resources.
pub fn unpack_files(files: &[(&str, &str)]) -> Unpacked {
    let folder = tempfile::tempdir().unwrap();
    for (name, content) in files {
        std::fs::write(folder.path().join(name), content).unwrap();
    }
    let resources = Resources::from_folder(folder.path()).unwrap();
    let guid = CString::new(describe::<Lag>(&resources).unwrap().guid).unwrap();
    let uri = CString::new(format!("file://{}", folder.path().display())).unwrap();
    Unpacked { _folder: folder, guid, uri }
}

impl Unpacked {
    pub fn instantiate(&self, logging_on: bool) -> Component {
        self.made_for(Interface::CoSimulation, logging_on)
    }

    pub fn made_for(&self, interface: Interface, logging_on: bool) -> Component {
        let name = CString::new("one").unwrap();
        let callbacks = callbacks();
        unsafe {
            fmi2Instantiate(
                name.as_ptr(),
                c_int::from(interface == Interface::CoSimulation),
                self.guid.as_ptr(),
                self.uri.as_ptr(),
                &callbacks,
                0,
                c_int::from(logging_on),
            )
        }
    }
}

/// Initialises a new instance, up to step or event mode.
pub fn initialise(c: Component) {
    unsafe {
        assert_eq!(fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0), Status::Ok);
        assert_eq!(fmi2EnterInitializationMode(c), Status::Ok);
        assert_eq!(fmi2ExitInitializationMode(c), Status::Ok);
    }
}
