//! Errors as Python's exceptions, of three kinds: see `squid_lpv/errors.py`.

use pyo3::{PyErr, import_exception};
use squid_design::error::Error as DesignError;
use squid_lpv::error::SynthesisError;
use squid_problem::error::Error as ProblemError;
use squid_proof::error::ProofError;

import_exception!(squid_lpv.errors, InfeasibleError);
import_exception!(squid_lpv.errors, InputError);
import_exception!(squid_lpv.errors, NumericalError);

/// What a design failed for.
pub fn of_design(error: &DesignError) -> PyErr {
    let words = error.to_string();
    match error {
        DesignError::Synthesis(reason) | DesignError::NoController { reason, .. } => {
            of_synthesis(reason, words)
        }
        DesignError::Input(_) | DesignError::Model(_) | DesignError::Store(_) | DesignError::File(_) => {
            InputError::new_err(words)
        }
        DesignError::Proof(reason) => of_proof(reason, words),
        _ => NumericalError::new_err(words),
    }
}

/// The exception of a synthesis without a controller.
pub fn of_synthesis(reason: &SynthesisError, words: String) -> PyErr {
    if reason.is_infeasible() { InfeasibleError::new_err(words) } else { NumericalError::new_err(words) }
}

/// What a problem of any plant failed for.
pub fn of_problem(error: &ProblemError) -> PyErr {
    use squid_lpv::mu::sweep::SweepError;
    let words = error.to_string();
    match error {
        ProblemError::Mu { reason: SweepError::Stuck { .. }, .. } => NumericalError::new_err(words),
        ProblemError::Proof(reason) => of_proof(reason, words),
        _ => InputError::new_err(words),
    }
}

fn of_proof(reason: &ProofError, words: String) -> PyErr {
    match reason {
        ProofError::Certificate { .. } => InputError::new_err(words),
        _ => NumericalError::new_err(words),
    }
}
