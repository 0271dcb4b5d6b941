//! What was proved, in words.

use crate::constant::{ConstantCertificate, Filter};
use std::fmt;

/// A proved claim; it is displayed as a sentence.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct ConstantTheorem {
    /// The L2 gain from w to z is below this.
    pub gamma: f64,
    /// Parameters that may take any trajectory in `[-1, 1]`.
    pub varying: usize,
    /// The bounds on the rates of those that may take any trajectory in `[-1, 1]` that is no faster, 1/s.
    pub rates: Vec<f64>,
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
        let mut filters: Vec<&Filter> = certificate.filters.iter().collect();
        filters.dedup_by_key(|f| f.parameter);
        let rates: Vec<f64> = filters.iter().map(|f| f.rate).filter(|rate| *rate > 0.0).collect();
        Self {
            gamma: certificate.gamma,
            varying: certificate.parameters() - filters.len(),
            constant: filters.len() - rates.len(),
            rates,
            scheduled: certificate.controller_blocks.iter().filter(|repetitions| **repetitions > 0).count(),
            states: certificate.lyapunov.len(),
            errors: certificate.errors.len(),
        }
    }
}

impl fmt::Display for ConstantTheorem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { gamma, varying, rates, constant, scheduled, states, errors } = self;
        let s = |n: usize| if n == 1 { "" } else { "s" };
        write!(f, "For every measurable trajectory of {varying} parameter{} in [-1, 1], ", s(*varying))?;
        for rate in rates {
            write!(f, "every trajectory in [-1, 1] of one more that changes by at most {rate} a second, ")?;
        }
        write!(
            f,
            "and every constant value of {constant} more in [-1, 1], the closed loop of {states} state{}, whose \
             controller depends on {scheduled} parameter{}, is exponentially stable and its L2 gain from w to z is \
             below {gamma}",
            s(*states),
            s(*scheduled),
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
