//! What was proved, in words.

use crate::constant::ConstantCertificate;
use std::fmt;

/// A proved claim; it is displayed as a sentence.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct ConstantTheorem {
    /// The L2 gain from w to z is below this.
    pub gamma: f64,
    /// Parameters that may take any trajectory in `[-1, 1]`.
    pub varying: usize,
    /// Parameters that have any constant value in `[-1, 1]`.
    pub constant: usize,
    /// Parameters on which the controller depends.
    pub scheduled: usize,
    /// States of the closed loop.
    pub states: usize,
    /// Model errors covered.
    pub errors: usize,
}

impl ConstantTheorem {
    pub(super) fn of(certificate: &ConstantCertificate) -> Self {
        let all = certificate.blocks.len().max(certificate.controller_blocks.len());
        Self {
            gamma: certificate.gamma,
            varying: all - certificate.filters.len(),
            constant: certificate.filters.len(),
            scheduled: certificate.controller_blocks.iter().filter(|repetitions| **repetitions > 0).count(),
            states: certificate.lyapunov.len(),
            errors: certificate.errors.len(),
        }
    }
}

impl fmt::Display for ConstantTheorem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { gamma, varying, constant, scheduled, states, errors } = self;
        let s = |n: usize| if n == 1 { "" } else { "s" };
        write!(
            f,
            "For every measurable trajectory of {varying} parameter{} in [-1, 1], on {scheduled} of which the \
             controller depends, and every constant value of {constant} more in [-1, 1], the closed loop of {states} \
             state{} is exponentially stable and its L2 gain from w to z is below {gamma}",
            s(*varying),
            s(*states),
        )?;
        match errors {
            0 => f.write_str("."),
            n => write!(
                f,
                ", also when to [A B2] of the plant {n} term{} E Delta [F Fu] {} added, for any measurable Delta(t) \
                 with a largest singular value of at most 1.",
                s(*n),
                if *n == 1 { "is" } else { "are" }
            ),
        }
    }
}
