//! Gain for parameters that vary arbitrarily fast, with or without the model error.

use super::proved::Provable;
use crate::closed_loop::ClosedLoop;
use crate::error::ClaimName;
use crate::error::Failure;
use crate::exact::dyadic::Dyadic;
use crate::exact::matrix::Matrix;
use crate::inequality::{Scalings, inequality};
use crate::plant::Rows;
use crate::shape::{Size, Sizes, check_matrix, check_number};
use crate::strict::given;
use crate::structure::{Sign, commuting, definite, positive, single_block, skew, symmetric};
use crate::system::Loop;
use serde::{Deserialize, Serialize};

/// Claim `gain from w to z < gamma` for parameters that vary arbitrarily fast, with the matrices that prove it; with
/// `lambda`, for the plant with the model error of the certificate.
///
/// With n states, r parameter channels, signals w, z, y, u of the plant, and nk states and rk channels of the
/// controller, X is (n + nk) x (n + nk), S and T are (r + rk) x (r + rk); the plant's part is first.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gain {
    /// Bound on the gain.
    pub gamma: f64,
    /// Multiplier of Delta.
    #[serde(default, deserialize_with = "given", skip_serializing_if = "Option::is_none")]
    pub lambda: Option<f64>,
    /// Lyapunov matrix, if V is not given.
    #[serde(rename = "X", default, deserialize_with = "given", skip_serializing_if = "Option::is_none")]
    pub x: Option<Rows>,
    /// Factor V with `X = V'V`, formed without rounding: 16 digits of V may suffice where those of X do not.
    #[serde(rename = "V", default, deserialize_with = "given", skip_serializing_if = "Option::is_none")]
    pub v: Option<Rows>,
    /// Symmetric scaling.
    #[serde(rename = "S")]
    pub s: Rows,
    /// Skew scaling.
    #[serde(rename = "T")]
    pub t: Rows,
}

impl Provable for Gain {
    fn name(&self) -> ClaimName {
        if self.lambda.is_some() { ClaimName::RobustGain } else { ClaimName::Gain }
    }

    fn check(&self, path: &str, system: Loop<'_>) -> Result<(), Failure> {
        if let Some(lambda) = self.lambda {
            check_number(&format!("{path}.lambda"), lambda)?;
        }
        check_number(&format!("{path}.gamma"), self.gamma)?;
        let lyapunov = match (&self.x, &self.v) {
            (Some(x), None) => ("X", x),
            (None, Some(v)) => ("V", v),
            (Some(_), Some(_)) => return Err(Failure::found(path, "both X and V", "only one of them")),
            (None, None) => return Err(Failure::malformed(path, "missing field `X`, or `V`")),
        };
        check_scalings(path, system.sizes().states(), system.sizes(), lyapunov, [&self.s, &self.t])
    }

    fn prove(&self, system: Loop<'_>) -> Result<(), Failure> {
        let x = match (&self.x, &self.v) {
            (Some(x), _) => symmetric(self.name(), "X", x).map(|()| Matrix::square(x))?,
            (None, v) => {
                let v = Matrix::square(v.as_ref().unwrap_or(&vec![]));
                v.transpose().times(&v)
            }
        };
        let errors = if self.lambda.is_some() { system.errors } else { &[] };
        let gamma = Dyadic::from_f64(self.gamma);
        prove_gain(self.name(), &ClosedLoop::new(system, errors)?, gamma, self.lambda, x, (&self.s, &self.t))
    }
}

/// Checks the sizes of a Lyapunov matrix and of the scalings of plant and controller.
pub(super) fn check_scalings(
    path: &str,
    states: Size,
    s: Sizes,
    (name, x): (&str, &Rows),
    [sym, skew]: [&Rows; 2],
) -> Result<(), Failure> {
    check_matrix(&format!("{path}.{name}"), x, states, states)?;
    check_matrix(&format!("{path}.S"), sym, s.channels(), s.channels())?;
    check_matrix(&format!("{path}.T"), skew, s.channels(), s.channels())
}

/// Proves the inequality of a loop: `gamma > 0`, `lambda > 0`, `S = S' > 0` and `T = -T'` commute with Theta, `X > 0`,
/// and the matrix of the inequality is negative definite. The caller ensures `X = X'`.
pub(super) fn prove_gain(
    claim: ClaimName,
    closed: &ClosedLoop,
    gamma: Dyadic,
    lambda: Option<f64>,
    x: Matrix,
    (s, t): (&Rows, &Rows),
) -> Result<(), Failure> {
    positive(claim, "gamma", gamma.to_f64())?;
    lambda.map_or(Ok(()), |lambda| positive(claim, "lambda", lambda))?;
    symmetric(claim, "S", s)?;
    skew(claim, "T", t)?;
    commuting(claim, "S", s, &closed.parameters)?;
    commuting(claim, "T", t, &closed.parameters)?;
    let lambda = Dyadic::from_f64(lambda.unwrap_or(0.0));
    let proof = Scalings { gamma, lambda, x, s: Matrix::square(s), t: Matrix::square(t) };
    definite(claim, "X", Sign::Positive, &single_block("x", &proof.x))?;
    definite(claim, "S", Sign::Positive, &single_block("zt", &proof.s))?;
    definite(claim, "the matrix of the inequality", Sign::Negative, &inequality(closed, &proof))
}
