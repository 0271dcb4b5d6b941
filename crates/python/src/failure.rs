//! Conversion of errors to Python exceptions of three kinds; see `squid_lpv/errors.py`.

use pyo3::{PyErr, import_exception};
use squid_design::error::Error as DesignError;
use squid_lpv::error::SynthesisError;
use squid_problem::error::Error as ProblemError;
use squid_proof::error::ProofError;

import_exception!(squid_lpv.errors, InfeasibleError);
import_exception!(squid_lpv.errors, InputError);
import_exception!(squid_lpv.errors, NumericalError);

/// Returns the exception for an error of a design.
pub fn of_design(error: &DesignError) -> PyErr {
    let message = error.to_string();
    match error {
        DesignError::Synthesis(reason) | DesignError::NoController { reason, .. } => {
            of_synthesis(reason, message)
        }
        DesignError::Input(_) | DesignError::Model(_) | DesignError::Store(_) | DesignError::File(_) => {
            InputError::new_err(message)
        }
        DesignError::Proof(reason) => of_proof(reason, message),
        _ => NumericalError::new_err(message),
    }
}

/// Returns the exception for a synthesis without a controller.
pub fn of_synthesis(reason: &SynthesisError, message: String) -> PyErr {
    if reason.is_infeasible() { InfeasibleError::new_err(message) } else { NumericalError::new_err(message) }
}

/// Returns the exception for an error of a general problem.
pub fn of_problem(error: &ProblemError) -> PyErr {
    use squid_lpv::mu::sweep::SweepError;
    let message = error.to_string();
    match error {
        ProblemError::Mu { reason: SweepError::Stuck { .. }, .. } => NumericalError::new_err(message),
        ProblemError::Proof(reason) => of_proof(reason, message),
        _ => InputError::new_err(message),
    }
}

fn of_proof(reason: &ProofError, message: String) -> PyErr {
    match reason {
        ProofError::Certificate { .. } => InputError::new_err(message),
        _ => NumericalError::new_err(message),
    }
}
