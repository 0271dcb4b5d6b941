//! The C ABI of FMI 2.0 (`fmi2TypesPlatform.h`, `fmi2FunctionTypes.h`, `fmi2Functions.h`).
//!
//! All `unsafe` code lives here. The C functions are here, generic over the model; the macro
//! [`export!`](crate::export) gives them their C names. Each call passes one gate (`component.rs`) that
//! checks pointer and state table, catches panics, and logs one sentence for what it refuses; it computes in
//! the default floating-point environment (`environment.rs`).

#![allow(unsafe_code)]

pub mod access;
mod component;
mod environment;
pub mod exchange;
mod export;
pub mod lifecycle;
mod logger;
mod pointers;
pub mod state;
pub mod step;
mod types;

pub use types::{CallbackFunctions, Component, EventInfo, FmuState, Logger, Status, StatusKind};
