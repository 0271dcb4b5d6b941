//! Errors as Python's exceptions, of three kinds: see `squid_lpv/errors.py`.

use lpv::error::SynthesisError;
use proof::error::ProofError;
use pyo3::{PyErr, import_exception};
use squid_design::error::Error as DesignError;
use squid_problem::error::Error as ProblemError;

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
        DesignError::Input(_)
        | DesignError::Model(_)
        | DesignError::Store(_)
        | DesignError::File(_)
        | DesignError::Proof(ProofError::Certificate { .. }) => InputError::new_err(words),
        _ => NumericalError::new_err(words),
    }
}

fn of_synthesis(reason: &SynthesisError, words: String) -> PyErr {
    if reason.is_infeasible() { InfeasibleError::new_err(words) } else { NumericalError::new_err(words) }
}

/// What a problem of any plant failed for.
pub fn of_problem(error: &ProblemError) -> PyErr {
    use lpv::mu::sweep::SweepError;
    match error {
        ProblemError::File(_)
        | ProblemError::Problem { .. }
        | ProblemError::Proof(ProofError::Certificate { .. }) => InputError::new_err(error.to_string()),
        ProblemError::Mu { reason, .. } if !matches!(reason, SweepError::Stuck { .. }) => {
            InputError::new_err(error.to_string())
        }
        ProblemError::Proof(_) | ProblemError::Mu { .. } => NumericalError::new_err(error.to_string()),
    }
}
