//! Stands in for the crate `blas-src`, which Clarabel names, so that whatever is linked with Clarabel has the symbols.
//!
//! Beside the Rust library, cargo makes a C library of Clarabel, which nobody uses; on Windows no library links with
//! symbols that are not there.
#![no_std]

extern crate squid_blas_symbols;
