//! Delivery of messages to the importer's logger.

use std::ffi::{CString, c_void};

use crate::Log;
use crate::abi::types::{self, CallbackFunctions, Status};
use crate::log::{Category, Filter};

/// The importer's logger, with the enabled categories.
pub(crate) struct Logger {
    callback: Option<types::Logger>,
    environment: *mut c_void,
    instance_name: CString,
    pub(crate) filter: Filter,
    /// `true` if a warning was logged in the current call.
    pub(crate) warned: bool,
}

impl Logger {
    pub(crate) fn new(callbacks: Option<&CallbackFunctions>, instance_name: &str) -> Self {
        Self {
            callback: callbacks.and_then(|callbacks| callbacks.logger),
            environment: callbacks.map_or(std::ptr::null_mut(), |callbacks| callbacks.component_environment),
            instance_name: c_string(instance_name),
            filter: Filter::ALL,
            warned: false,
        }
    }

    pub(crate) fn error(&self, function: &str, message: &dyn std::fmt::Display) {
        self.send(Status::Error, Category::Error, &format!("{function}: {message}."));
    }

    pub(crate) fn discard(&self, function: &str, message: &dyn std::fmt::Display) {
        self.send(Status::Discard, Category::Discard, &format!("{function}: {message}."));
    }

    pub(crate) fn fatal(&self, function: &str, message: &str) {
        let text = format!("{function}: the call failed because of a defect in the FMU ({message}).");
        self.send(Status::Fatal, Category::Fatal, &text);
    }

    fn send(&self, status: Status, category: Category, message: &str) {
        let Some(callback) = self.callback.filter(|_| self.filter.shows(category)) else {
            return;
        };
        // "#" would start a reference to a variable (section 2.1.5), "%" a conversion. The text is the format itself,
        // because some importers' loggers ignore variable arguments.
        let format = c_string(&message.replace('#', "##").replace('%', "%%"));
        let category = c_string(category.name());
        // SAFETY: the importer guarantees a function of this type for the lifetime of the instance; the strings
        // are NUL-terminated and outlive the call; no conversion in the format takes an argument.
        unsafe {
            callback(
                self.environment,
                self.instance_name.as_ptr(),
                status,
                category.as_ptr(),
                format.as_ptr(),
            );
        }
    }
}

impl Log for Logger {
    fn warn(&mut self, message: &str) {
        self.warned = true;
        self.send(Status::Warning, Category::Warning, message);
    }
}

/// Converts a text to a C string without its NUL bytes.
pub(crate) fn c_string(text: &str) -> CString {
    CString::new(text.replace('\0', "")).unwrap_or_default()
}
