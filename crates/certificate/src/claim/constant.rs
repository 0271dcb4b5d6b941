//! The gain for parameters some of which are constant, with model errors: the claim and its proof.
//!
//! # The claim
//!
//! The loop of plant and controller is, in the notation of the crate's root, `x' = A x + Bt wt + B1 w`, `zt = Ct x +
//! Dtt wt + Dt1 w`, `z = C1 x + D1t wt + D11 w`, `wt = Theta zt`. A parameter with filters stays in `[-1, 1]` and is
//! Lipschitz continuous with its `rate`, 1/s: constant where that is 0. Every other may take any measurable trajectory
//! in `[-1, 1]`. To `[A B1 B2]` of the plant any `E Delta(t) [F Fw Fu]` of `errors` may be added: `w_D = Delta z_D`
//! enters x' by E, with `z_D = F x + Fw w + Fu u`. Then the loop through the parameters is well posed, the closed loop
//! is exponentially stable, and its L2 gain from w to z is below gamma.
//!
//! # Conditions, checked without rounding
//!
//! A parameter with filters has two states for each filter and channel, `f' = -a f + zt` and `g' = -a g + wt + v`. The
//! v is there where `rate > 0`, a channel more: v belongs to `rate f`, as wt to zt. Z is the map from the states xi of
//! loop and filters and from (wt, v, w_D, w) to (zt, f, rate f), W that to (wt, g, v); `xi' = M (xi, wt, v, w_D, w)`.
//!
//! 1. `gamma > 0`, every `lambda > 0`, `a > 0` and `rate >= 0`, one rate a parameter; X, S symmetric; T skew; S and T
//!    commute with Theta, repeated on the filtered channels, and with any diagonal matrix of one value a parameter on
//!    those of the rates.
//! 2. `L = L' > 0` and `A'L + LA < 0`.
//! 3. `S > 0`.
//! 4. `[X; 0] M + M' [X 0] + Z'SZ - W'SW + W'TZ + Z'T'W + sum lambda (z_D'z_D - w_D'w_D) - gamma w'w + z'z/gamma < 0`
//!    as a quadratic form of (xi, wt, v, w_D, w).
//!
//! # Why they suffice
//!
//! A. Megretski, A. Rantzer, "System analysis via integral quadratic constraints", IEEE Trans. Automatic Control
//! 42(6), 1997, theorem 1: a stable system G in a loop with a bounded operator is stable if, for every tau in [0, 1],
//! the loop with tau times the operator is well posed and that operator satisfies the constraint, and G satisfies the
//! opposite inequality strictly at all frequencies.
//!
//! - *G is stable*, by 2, and so are the filters. So 4 gives the strict inequality at every frequency: with `xi = (j
//!   omega - A)^-1 B (wt, v, w_D, w)` the terms of X cancel. X need not be definite.
//! - *The constraint of a parameter with any trajectory.* Let `wt = tau theta zt`. `zt'S zt - wt'S wt =
//!   (1 - tau^2 theta^2) zt'S zt >= 0` at every instant, and `wt'T zt = 0`.
//! - *The constraint of one with filters.* The operator takes zt to `wt = tau theta zt` and, where `rate > 0`, to
//!   `v = tau theta' f` with `f' = -a f + zt` from rest. Then `g = tau theta f`, because both sides are 0 at rest and
//!   `(tau theta f)' = v + tau theta (-a f + zt) = -a (tau theta f) + wt + v`. So W is `tau theta` times Z on the
//!   channels and the filtered ones, and `tau theta'/rate` times Z on those of the rate: each is at most 1 in size, and
//!   the terms in S and T are as for a parameter with any trajectory, at every instant. (The swapping of a filter and a
//!   slow parameter: U. Jonsson, A. Rantzer, "Systems with uncertain parameters: time-variations with bounded
//!   derivatives", Int. J. Robust and Nonlinear Control 6, 1996.)
//! - *The constraint of Delta.* `lambda (|z_D|^2 - |tau Delta z_D|^2) >= 0` at every instant.
//! - *Well-posedness for every tau.* If `I - tau Theta Dtt` were singular at some value, there would be `wt = tau Theta
//!   zt` other than 0 with `zt = Dtt wt`. At xi = 0, v = 0, w = 0, w_D = 0 and this wt all terms of 4 vanish or are not
//!   negative, S on the channels that are not filtered being a diagonal block of S: a contradiction. The values form a
//!   compact set, so that the inverse is bounded. w_D acts on x' alone, so that it is determined, too.
//! - *Stability.* By the theorem wt and w_D have finite energy, bounded by that of what acts on the loop, the response
//!   to an initial state among it, with one constant for all trajectories of the parameters. So x has finite energy,
//!   bounded by |x(0)|^2, from whatever time one begins; the loop is linear with bounded coefficients, so it is
//!   exponentially stable (R. Datko, SIAM J. Math. Analysis 3(3), 1972).
//! - *Gain.* From rest, with w of finite energy, all signals have finite energy. Integrating 4 along them, the terms of
//!   X vanish at both ends and those of the constraints are not negative: the energy of z is below gamma^2 times that
//!   of w.

use super::filtered::{Filter, Filtered};
use super::proved::Proved;
use crate::closed_loop::ClosedLoop;
use crate::error::Failure;
use crate::exact::matrix::Matrix;
use crate::exact::witness::shown_positive;
use crate::plant::Rows;
use crate::shape::{check_list, check_matrix, check_number};
use crate::structure::{Sign, commuting, positive, skew, symmetric};
use crate::system::Loop;
use serde::{Deserialize, Serialize};
use std::fmt;

/// The claim `gain from w to z < gamma` for every trajectory of some parameters and every constant value of the others,
/// with the matrices that prove it.
///
/// With n states of plant and controller, r channels of both, and k channels of the parameters with a filter, X is
/// (n + 2k) x (n + 2k). S and T are (r + k + v) x (r + k + v), with v channels of the parameters that may change.
/// States: plant's, controller's, those of the filters of zt, then of wt; channels: plant's, controller's, the filtered
/// ones in the order of `filters`, and the rates of those that have one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Constant {
    /// The bound.
    pub gamma: f64,
    /// The matrix of the inequality, symmetric.
    #[serde(rename = "X")]
    pub x: Rows,
    /// The symmetric multiplier.
    #[serde(rename = "S")]
    pub s: Rows,
    /// The skew multiplier.
    #[serde(rename = "T")]
    pub t: Rows,
    /// A Lyapunov matrix of the loop where all parameters are 0; n x n.
    #[serde(rename = "L")]
    pub lyapunov: Rows,
    /// The filters, one or more, of each parameter that is constant or changes slowly, in the order of the parameters;
    /// all others may take any trajectory.
    pub filters: Vec<Filter>,
    /// The multiplier of Delta of each model error of the certificate.
    pub lambdas: Vec<f64>,
}

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
    pub(crate) fn of(claim: &Constant, of: Loop<'_>) -> Self {
        let mut filters: Vec<&Filter> = claim.filters.iter().collect();
        filters.dedup_by_key(|f| f.parameter);
        let rates: Vec<f64> = filters.iter().map(|f| f.rate).filter(|rate| *rate > 0.0).collect();
        Self {
            gamma: claim.gamma,
            varying: of.parameters() - filters.len(),
            constant: filters.len() - rates.len(),
            rates,
            scheduled: of.controller_blocks.iter().filter(|repetitions| **repetitions > 0).count(),
            states: claim.lyapunov.len(),
            errors: of.errors.len(),
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
                ", also when to [A B1 B2] of the plant {n} term{} E Delta [F Fw Fu] {} added, for any \
                 measurable Delta(t) with a largest singular value of at most 1.",
                s(*n),
                if *n == 1 { "is" } else { "are" }
            ),
        }
    }
}

impl Constant {
    /// Checks that each filter is of a parameter with channels, in order, with one rate a parameter.
    fn check_filters(&self, path: &str, of: Loop<'_>) -> Result<(), Failure> {
        let mut before: Option<&Filter> = None;
        for (i, filter) in self.filters.iter().enumerate() {
            let at = |name: &str| format!("{path}.filters[{i}].{name}");
            let Filter { parameter, pole, rate } = *filter;
            if of.channels_of(parameter) == 0 || before.is_some_and(|before| parameter < before.parameter) {
                let allowed =
                    "the number of a parameter that has channels, not smaller than that of the filter before";
                return Err(Failure::found(at("parameter"), parameter, allowed));
            }
            check_number(&at("pole"), pole)?;
            check_number(&at("rate"), rate)?;
            if rate < 0.0 {
                return Err(Failure::found(at("rate"), rate, "a number that is at least 0"));
            }
            if before.is_some_and(|before| before.parameter == parameter && before.rate != rate) {
                return Err(Failure::found(
                    at("rate"),
                    rate,
                    "the rate of the other filters of that parameter",
                ));
            }
            before = Some(filter);
        }
        Ok(())
    }
}

impl Proved for Constant {
    fn name(&self) -> &'static str {
        "the claim for constant parameters"
    }

    fn check(&self, path: &str, of: Loop<'_>) -> Result<(), Failure> {
        let (s, at) = (of.sizes(), |name: &str| format!("{path}.{name}"));
        of.check_no_direct_path(path)?;
        check_number(&at("gamma"), self.gamma)?;
        check_matrix(&at("L"), &self.lyapunov, s.states(), s.states())?;
        check_list(&at("lambdas"), &self.lambdas, (of.errors.len(), "model errors"))?;
        self.check_filters(path, of)?;
        let of_filter = |filter: &Filter| of.channels_of(filter.parameter);
        let filtered: usize = self.filters.iter().map(of_filter).sum();
        let moving: usize = self.filters.iter().filter(|filter| filter.rate > 0.0).map(of_filter).sum();
        let states = (s.states().0 + 2 * filtered, "states of plant, controller and filters");
        let channels = s.channels().0 + filtered + moving;
        let channels = (channels, "channels of plant and controller, the filtered ones, and those of rates");
        check_matrix(&at("X"), &self.x, states, states)?;
        check_matrix(&at("S"), &self.s, channels, channels)?;
        check_matrix(&at("T"), &self.t, channels, channels)
    }

    fn prove(&self, of: Loop<'_>) -> Result<(), Failure> {
        let claim = self.name();
        positive(claim, "gamma", self.gamma)?;
        self.filters.iter().try_for_each(|f| positive(claim, "the pole of a filter", f.pole))?;
        self.lambdas.iter().try_for_each(|lambda| positive(claim, "lambda", *lambda))?;
        symmetric(claim, "X", &self.x)?;
        symmetric(claim, "S", &self.s)?;
        skew(claim, "T", &self.t)?;
        symmetric(claim, "L", &self.lyapunov)?;
        let closed = ClosedLoop::new(of, of.errors)?;
        let filtered = Filtered::new(of, &self.filters, &closed);
        commuting(claim, "S", &self.s, &filtered.parameters())?;
        commuting(claim, "T", &self.t, &filtered.parameters())?;
        shown(claim, "L", Sign::Positive, &Matrix::square(&self.lyapunov))?;
        shown(claim, "A'L + LA", Sign::Negative, &filtered.decay(&self.lyapunov))?;
        let all = of.parameters();
        for parameter in 0..all {
            let [own, rate] = [parameter, all + parameter].map(|place| filtered.multiplier(&self.s, place));
            shown(claim, &format!("the multiplier of parameter {parameter}"), Sign::Positive, &own)?;
            let name = format!("the multiplier of the rate of parameter {parameter}");
            shown(claim, &name, Sign::Positive, &rate)?;
        }
        shown(
            claim,
            "the matrix of the inequality",
            Sign::Negative,
            &filtered.main((&self.x, &self.s, &self.t), self.gamma, &self.lambdas),
        )
    }
}

fn shown(claim: &str, matrix: &str, sign: Sign, m: &Matrix) -> Result<(), Failure> {
    if if sign == Sign::Negative { shown_positive(&m.negated()) } else { shown_positive(m) } {
        return Ok(());
    }
    let reason = format!("{matrix} is not shown to be {} definite", sign.word());
    Err(Failure::NotDefinite { claim: claim.into(), reason, pivot: None })
}
