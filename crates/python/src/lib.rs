//! Compiled part of the Python package `squid_lpv`, with text as input and output. The public interface is in
//! `squid_lpv/*.py`.
//!
//! Problems and reports use the same JSON as the command line.

mod failure;
mod job;
mod plants;
mod syntheses;
mod vehicles;

use pyo3::pymodule;

/// Compiled part of `squid_lpv`.
#[pymodule(name = "_core")]
mod core {
    #[pymodule_export]
    use crate::plants::{gain, hinfnorm, mu, prove, synth};
    #[pymodule_export]
    use crate::syntheses::{augw, h2syn, musyn};
    #[pymodule_export]
    use crate::vehicles::Vehicle;
    use pyo3::types::{PyModule, PyModuleMethods};
    use pyo3::{Bound, PyResult};

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        squid_lpv::lmi::keep_caught_panics_quiet();
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
