//! The C ABI of FMI 2.0 (`fmi2TypesPlatform.h`, `fmi2FunctionTypes.h`, `fmi2Functions.h`).
//!
//! All `unsafe` code of the crate is in this module. The C functions are generic over the model; the macro
//! [`export!`](crate::export) exports them under their C names. Every call passes `component.rs`, which
//! checks handle and state table, catches panics, and logs one sentence for each refusal; it computes in
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
