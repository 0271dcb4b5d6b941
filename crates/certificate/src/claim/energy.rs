//! The gain with saturated commands, for w of bounded energy, without model error.

use super::gain::{check_scalings, prove_gain};
use super::limits::{beside, is_zero, out_of_reach};
use super::proved::Proved;
use crate::closed_loop::ClosedLoop;
use crate::error::Failure;
use crate::exact::dyadic::Dyadic;
use crate::exact::matrix::Matrix;
use crate::plant::Rows;
use crate::shape::{at_least_one, check_length, check_list, check_matrix, check_number};
use crate::structure::{positive, symmetric};
use crate::system::Loop;
use serde::{Deserialize, Serialize};
use std::fmt;

/// The claim with saturated commands for w of bounded energy, with the plant without model error.
///
/// The plant gets `u - phi`, and `E phi` is added to the derivative of the controller's state, with `phi = u - sat(u)`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Energy {
    /// The least limit of each command, in both directions.
    pub limits: Vec<f64>,
    /// nk x u.
    #[serde(rename = "E")]
    pub e: Rows,
    /// At least one.
    pub bounds: Vec<EnergyBound>,
}

/// The gain from w to z is below gamma for every w whose energy is at most beta, from rest; with `H = 0` for every w.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EnergyBound {
    /// The bound.
    pub gamma: f64,
    /// The largest energy, the integral of w'w over time; without a meaning where H is 0.
    pub beta: f64,
    /// The Lyapunov matrix: x'Xx stays below gamma beta.
    #[serde(rename = "X")]
    pub x: Rows,
    /// The symmetric scaling.
    #[serde(rename = "S")]
    pub s: Rows,
    /// The skew scaling.
    #[serde(rename = "T")]
    pub t: Rows,
    /// The multiplier of each limit.
    #[serde(rename = "U")]
    pub u: Vec<f64>,
    /// Below which part of u a limit is out of reach, u x (n + nk).
    #[serde(rename = "H")]
    pub h: Rows,
}

/// A proved bound of the gain of a loop with saturated commands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EnergyTheorem {
    /// The L2 gain from w to z is below this.
    pub gamma: f64,
    /// The largest energy of w; `None` where it may have any, and H is 0.
    pub beta: Option<f64>,
}

impl EnergyTheorem {
    pub(crate) fn of(claim: &Energy) -> Vec<Self> {
        let beta = |bound: &EnergyBound| Some(bound.beta).filter(|_| !is_zero(&bound.h));
        claim.bounds.iter().map(|bound| Self { gamma: bound.gamma, beta: beta(bound) }).collect()
    }

    /// The sentence about these bounds; empty without one.
    pub(crate) fn sentence(bounds: &[Self]) -> Option<String> {
        let each: Vec<String> = bounds.iter().map(|bound| format!("below {bound}")).collect();
        (!each.is_empty()).then(|| {
            format!(
                "With commands saturated at the limits in the file, and anti-windup by the gain E, the gain from rest \
                 is {}, and with w = 0 the state then returns to rest exponentially.",
                each.join(", ")
            )
        })
    }
}

impl fmt::Display for EnergyTheorem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.beta {
            Some(beta) => write!(f, "{} for every w of an energy of at most {beta}", self.gamma),
            None => write!(f, "{} for every w", self.gamma),
        }
    }
}

/// Bounds, at most: each is proved.
const MOST_BOUNDS: usize = 100;

impl Proved for Energy {
    fn name(&self) -> &'static str {
        "the claim of bounded energy"
    }

    fn check(&self, path: &str, of: Loop<'_>) -> Result<(), Failure> {
        of.check_no_direct_path(path)?;
        let (s, found) = (of.sizes(), self.bounds.len());
        let bounds = format!("{path}.bounds");
        at_least_one(&bounds, "entries", (found, "bounds"))?;
        check_length(&bounds, found, found <= MOST_BOUNDS, &format!("at most {MOST_BOUNDS}"))?;
        check_list(&format!("{path}.limits"), &self.limits, s.controls())?;
        check_matrix(&format!("{path}.E"), &self.e, (s.xk, "controller's states"), s.controls())?;
        self.bounds.iter().enumerate().try_for_each(|(k, bound)| {
            let path = format!("{bounds}[{k}]");
            check_number(&format!("{path}.gamma"), bound.gamma)?;
            check_number(&format!("{path}.beta"), bound.beta)?;
            check_scalings(&path, s.states(), s, ("X", &bound.x), [&bound.s, &bound.t])?;
            check_list(&format!("{path}.U"), &bound.u, s.controls())?;
            check_matrix(&format!("{path}.H"), &bound.h, s.controls(), s.states())
        })
    }

    /// x leaves `x'Xx <= gamma beta` for no w of the energy beta, there H x leaves each limit out of reach, and the
    /// inequality is that of the gain.
    fn prove(&self, of: Loop<'_>) -> Result<(), Failure> {
        for (k, bound) in self.bounds.iter().enumerate() {
            let claim = &format!("bound {k} of bounded energy");
            positive(claim, "beta", bound.beta)?;
            self.limits.iter().try_for_each(|limit| positive(claim, "a limit", *limit))?;
            let closed = ClosedLoop::with_energy(of, &self.e, &bound.h)?;
            let gamma = Dyadic::from_f64(bound.gamma);
            let level = &gamma * &Dyadic::from_f64(bound.beta);
            symmetric(claim, "X", &bound.x)?;
            let x = Matrix::from_rows(&bound.x, closed.states);
            let (s, t) = (beside(&bound.s, &bound.u), beside(&bound.t, &vec![0.0; bound.u.len()]));
            prove_gain(claim, &closed, gamma, None, x.clone(), (&s, &t))?;
            out_of_reach(claim, (&x, &bound.h, &self.limits), &level, "gamma beta")?;
        }
        Ok(())
    }
}
