//! C functions of the three models, and the folder with resources from which they are instantiated.

#![allow(dead_code, reason = "not every test needs everything")]

use std::cell::{Cell, RefCell};
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::marker::PhantomData;
use std::ptr::null;
use std::sync::atomic::{AtomicUsize, Ordering};

use squid_fmi2::abi::{CallbackFunctions, Component, Logger, Status, access, lifecycle, step};
use squid_fmi2::{Interface, Model, Resources, describe};

/// Number of messages of all instances; their text is not stored, so that the logger itself does not allocate.
pub static MESSAGES: AtomicUsize = AtomicUsize::new(0);
/// Number of messages that report a defect of the FMU.
pub static DEFECTS: AtomicUsize = AtomicUsize::new(0);

thread_local! {
    /// Number of defects reported on this thread.
    static OWN_DEFECTS: Cell<usize> = const { Cell::new(0) };
    /// Messages of this thread, stored if a test asks for them.
    static TEXTS: RefCell<Option<Vec<String>>> = const { RefCell::new(None) };
}

/// Returns the number of defects reported on this thread since the last call.
pub fn own_defects() -> usize {
    OWN_DEFECTS.take()
}

/// Stores the messages of this thread from now on, and returns those since the last call.
pub fn texts() -> Vec<String> {
    TEXTS.with_borrow_mut(|texts| texts.replace(Vec::new())).unwrap_or_default()
}

unsafe extern "C" fn count(
    _: *mut c_void,
    _: *const c_char,
    status: Status,
    _: *const c_char,
    text: *const c_char,
) {
    MESSAGES.fetch_add(1, Ordering::Relaxed);
    TEXTS.with_borrow_mut(|texts| {
        if let Some(texts) = texts {
            texts.push(unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned());
        }
    });
    if status == Status::Fatal {
        DEFECTS.fetch_add(1, Ordering::Relaxed);
        OWN_DEFECTS.set(OWN_DEFECTS.get() + 1);
    }
}

pub fn callbacks() -> CallbackFunctions {
    type Fixed = unsafe extern "C" fn(*mut c_void, *const c_char, Status, *const c_char, *const c_char);
    // The calling convention of variadic functions is that of others on the platforms of the tests.
    let logger = unsafe { std::mem::transmute::<Fixed, Logger>(count) };
    CallbackFunctions {
        logger: Some(logger),
        allocate_memory: None,
        free_memory: None,
        step_finished: None,
        component_environment: std::ptr::null_mut(),
    }
}

/// An unpacked FMU of one model.
pub struct Unpacked<M> {
    pub folder: tempfile::TempDir,
    pub guid: CString,
    pub uri: CString,
    model: PhantomData<fn() -> M>,
}

impl<M: Model> Unpacked<M> {
    pub fn new(resources: &Resources) -> Self {
        let folder = tempfile::tempdir().unwrap();
        for (name, bytes) in resources.iter() {
            std::fs::write(folder.path().join(name), bytes).unwrap();
        }
        let guid = CString::new(describe::<M>(resources).unwrap().guid).unwrap();
        let uri = CString::new(format!("file://{}", folder.path().display())).unwrap();
        Self { folder, guid, uri, model: PhantomData }
    }

    pub fn instantiate(&self, interface: Interface) -> Component {
        let kind = c_int::from(interface == Interface::CoSimulation);
        let (name, callbacks) = (c"one".as_ptr(), callbacks());
        let (guid, uri) = (self.guid.as_ptr(), self.uri.as_ptr());
        unsafe { lifecycle::instantiate::<M>(name, kind, guid, uri, &callbacks, 0, 0) }
    }

    /// Returns an instance ready to step, or in event mode.
    pub fn started(&self, interface: Interface) -> Component {
        self.started_with(interface, &[])
    }

    /// Returns such an instance with other values of parameters.
    pub fn started_with(&self, interface: Interface, parameters: &[(u32, f64)]) -> Component {
        let c = self.instantiate(interface);
        assert!(!c.is_null());
        for (parameter, value) in parameters {
            assert_eq!(set::<M>(c, *parameter, *value), Status::Ok);
        }
        unsafe {
            assert_eq!(lifecycle::setup_experiment::<M>(c, 0, 0.0, 0.0, 0, 0.0), Status::Ok);
            assert_eq!(lifecycle::enter_initialization_mode::<M>(c), Status::Ok);
            assert_eq!(lifecycle::exit_initialization_mode::<M>(c), Status::Ok);
        }
        c
    }
}

pub fn free<M: Model>(c: Component) {
    unsafe { lifecycle::free_instance::<M>(c) };
}

pub fn do_step<M: Model>(c: Component, at: f64, size: f64) -> Status {
    unsafe { step::do_step::<M>(c, at, size, 1) }
}

pub fn set<M: Model>(c: Component, reference: u32, value: f64) -> Status {
    unsafe { access::set_real::<M>(c, &reference, 1, &value) }
}

pub fn get<M: Model>(c: Component, references: &[u32], values: &mut [f64]) -> Status {
    unsafe { access::get_real::<M>(c, references.as_ptr(), references.len(), values.as_mut_ptr()) }
}

pub fn no_reference() -> *const u32 {
    null()
}
