//! Gain with constant, slow and arbitrarily varying parameters, and with model errors: the claim and its proof.
//!
//! # The claim
//!
//! The loop of plant and controller is, in the notation of the crate's root, `x' = A x + Bt wt + B1 w`,
//! `zt = Ct x + Dtt wt + Dt1 w`, `z = C1 x + D1t wt + D11 w`, `wt = Theta zt`. A parameter with filters stays in
//! `[-1, 1]` and is Lipschitz continuous with its `rate`, 1/s: constant where that is 0. Every other parameter may take
//! any measurable trajectory in `[-1, 1]`. To `[A B1 B2]` of the plant any `E Delta(t) [F Fw Fu]` of `errors` may be
//! added: `w_D = Delta z_D` enters x' by E, with `z_D = F x + Fw w + Fu u`. Then the loop through the parameters is
//! well posed, the closed loop is exponentially stable, and its L2 gain from w to z is below gamma.
//!
//! # Conditions, checked without rounding
//!
//! A parameter with filters has two states for each filter and channel, `f' = -a f + zt` and `g' = -a g + wt + v`. The
//! input v exists only where `rate > 0`, as a further channel: v corresponds to `rate f` as wt does to zt. Z maps the
//! states xi of loop and filters and (wt, v, w_D, w) to (zt, f, rate f), W maps them to (wt, g, v);
//! `xi' = M (xi, wt, v, w_D, w)`.
//!
//! 1. `gamma > 0`, every `lambda > 0`, `a > 0` and `rate >= 0`, one rate per parameter; X, S symmetric; T skew; S and T
//!    commute with Theta, repeated on the filtered channels, and with every diagonal matrix with one value per
//!    parameter on the channels of the rates.
//! 2. `L = L' > 0` and `A'L + LA < 0`.
//! 3. `S > 0`.
//! 4. `[X; 0] M + M' [X 0] + Z'SZ - W'SW + W'TZ + Z'T'W + sum lambda (z_D'z_D - w_D'w_D) - gamma w'w + z'z/gamma < 0`
//!    as a quadratic form of (xi, wt, v, w_D, w).
//!
//! # Why they suffice
//!
//! A. Megretski, A. Rantzer, "System analysis via integral quadratic constraints", IEEE Trans. Automatic Control 42(6),
//! 1997, theorem 1: the loop of a stable system G and a bounded operator is stable if, for every tau in [0, 1], the
//! loop with tau times the operator is well posed and that scaled operator satisfies the constraint, and if G satisfies
//! the opposite inequality strictly at all frequencies.
//!
//! - *G is stable*, by 2, and so are the filters. So 4 gives the strict inequality at every frequency: with `xi = (j
//!   omega - A)^-1 B (wt, v, w_D, w)` the terms of X cancel. X need not be definite.
//! - *The constraint of a parameter with any trajectory.* Let `wt = tau theta zt`. `zt'S zt - wt'S wt =
//!   (1 - tau^2 theta^2) zt'S zt >= 0` at every instant, and `wt'T zt = 0`.
//! - *The constraint of a parameter with filters.* The operator takes zt to `wt = tau theta zt` and, where `rate > 0`,
//!   to `v = tau theta' f` with `f' = -a f + zt` from rest. Then `g = tau theta f`, because both sides are 0 at rest
//!   and `(tau theta f)' = v + tau theta (-a f + zt) = -a (tau theta f) + wt + v`. So W is `tau theta` times Z on the
//!   channels and the filtered ones, and `tau theta'/rate` times Z on those of the rate: each factor is at most 1 in
//!   magnitude, and the terms in S and T are as for a parameter with any trajectory, at every instant. (The swapping of
//!   a filter and a slow parameter: U. Jonsson, A. Rantzer, "Systems with uncertain parameters: time-variations with
//!   bounded derivatives", Int. J. Robust and Nonlinear Control 6, 1996.)
//! - *The constraint of Delta.* `lambda (|z_D|^2 - |tau Delta z_D|^2) >= 0` at every instant.
//! - *Well-posedness for every tau.* If `I - tau Theta Dtt` were singular at some value, there would be
//!   `wt = tau Theta zt` other than 0 with `zt = Dtt wt`. At xi = 0, v = 0, w = 0, w_D = 0 and this wt all terms of 4
//!   vanish or are not negative, because S on the channels that are not filtered is a diagonal block of S: a
//!   contradiction. The values form a compact set, so that the inverse is bounded. w_D acts on x' alone and is
//!   therefore determined, too.
//! - *Stability.* By the theorem, wt and w_D have finite energy, bounded by that of the signals acting on the loop,
//!   including the response to an initial state, with one constant for all trajectories of the parameters. So x has
//!   finite energy, bounded by a multiple of |x(0)|^2, from any initial time; the loop is linear with bounded
//!   coefficients, so it is exponentially stable (R. Datko, SIAM J. Math. Analysis 3(3), 1972).
//! - *Gain.* From rest, with w of finite energy, all signals have finite energy. Integrating 4 along them, the terms of
//!   X vanish at both ends and those of the constraints are not negative: the energy of z is below gamma^2 times that
//!   of w.

use super::filtered::{Filter, Filtered};
use super::proved::Provable;
use crate::closed_loop::ClosedLoop;
use crate::error::ClaimName;
use crate::error::Failure;
use crate::exact::matrix::Matrix;
use crate::exact::witness::shown_positive;
use crate::plant::Rows;
use crate::shape::{check_list, check_matrix, check_number};
use crate::structure::{Sign, commuting, positive, skew, symmetric};
use crate::system::Loop;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Claim `gain from w to z < gamma` for every trajectory of some parameters and every constant value, or slow
/// trajectory, of the others, with the matrices that prove it.
///
/// With n states of plant and controller, r channels of both, and k filtered channels, X is (n + 2k) x (n + 2k). S and
/// T are (r + k + v) x (r + k + v), with v filtered channels whose rate is not 0. Order of the states: plant,
/// controller, filters of zt, filters of wt; order of the channels: plant, controller, filtered channels in the order
/// of `filters`, rates.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Constant {
    /// Bound on the gain.
    pub gamma: f64,
    /// Matrix of the inequality, symmetric.
    #[serde(rename = "X")]
    pub x: Rows,
    /// Symmetric multiplier.
    #[serde(rename = "S")]
    pub s: Rows,
    /// Skew multiplier.
    #[serde(rename = "T")]
    pub t: Rows,
    /// Lyapunov matrix of the loop with all parameters 0; n x n.
    #[serde(rename = "L")]
    pub lyapunov: Rows,
    /// Filters of the parameters that are constant or change slowly, one or more each, in the order of the parameters;
    /// all others may take any trajectory.
    pub filters: Vec<Filter>,
    /// Multiplier of Delta of each model error of the certificate.
    pub lambdas: Vec<f64>,
}

/// Proved claim; displayed as a sentence.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct ConstantTheorem {
    /// Upper bound on the L2 gain from w to z.
    pub gamma: f64,
    /// Number of parameters that may take any trajectory in `[-1, 1]`.
    pub varying: usize,
    /// Rate bounds of the parameters that may take any trajectory in `[-1, 1]` within their rate, 1/s.
    pub rates: Vec<f64>,
    /// Number of parameters with any constant value in `[-1, 1]`.
    pub constant: usize,
    /// Number of parameters on which the controller depends.
    pub scheduled: usize,
    /// Number of states of the closed loop.
    pub states: usize,
    /// Number of model errors covered.
    pub errors: usize,
}

impl ConstantTheorem {
    pub(crate) fn of(claim: &Constant, system: Loop<'_>) -> Self {
        let mut filters: Vec<&Filter> = claim.filters.iter().collect();
        filters.dedup_by_key(|f| f.parameter);
        let rates: Vec<f64> = filters.iter().map(|f| f.rate).filter(|rate| *rate > 0.0).collect();
        Self {
            gamma: claim.gamma,
            varying: system.parameters() - filters.len(),
            constant: filters.len() - rates.len(),
            rates,
            scheduled: system.controller_blocks.iter().filter(|repetitions| **repetitions > 0).count(),
            states: claim.lyapunov.len(),
            errors: system.errors.len(),
        }
    }
}

impl fmt::Display for ConstantTheorem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { gamma, varying, rates, constant, scheduled, states, errors } = self;
        let s = |n: usize| if n == 1 { "" } else { "s" };
        let varying = (*varying > 0)
            .then(|| format!("every measurable trajectory in [-1, 1] of {varying} parameter{}", s(*varying)));
        let slow = rates.iter().map(|rate| {
            format!(
                "every trajectory in [-1, 1] of one parameter that changes by at most {rate} per unit of time"
            )
        });
        let constant = (*constant > 0)
            .then(|| format!("every constant value in [-1, 1] of {constant} parameter{}", s(*constant)));
        let cases: Vec<String> = varying.into_iter().chain(slow).chain(constant).collect();
        write!(
            f,
            "For {}, the closed loop of {states} state{}, whose controller depends on {scheduled} \
             parameter{}, is exponentially stable and its L2 gain from w to z is below {gamma}",
            cases.join(" and "),
            s(*states),
            s(*scheduled),
        )?;
        match errors {
            0 => f.write_str("."),
            n => write!(
                f,
                ", also with {n} term{} E Delta [F Fw Fu] added to [A B1 B2] of the plant, for any measurable Delta(t) \
                 with largest singular value at most 1.",
                s(*n)
            ),
        }
    }
}

impl Constant {
    /// Checks that each filter belongs to a parameter with channels, in order, with one rate per parameter.
    fn check_filters(&self, path: &str, system: Loop<'_>) -> Result<(), Failure> {
        let mut before: Option<&Filter> = None;
        for (i, filter) in self.filters.iter().enumerate() {
            let at = |name: &str| format!("{path}.filters[{i}].{name}");
            let Filter { parameter, pole, rate } = *filter;
            if system.channels_of(parameter) == 0 || before.is_some_and(|before| parameter < before.parameter)
            {
                let allowed =
                    "the index of a parameter with channels, not smaller than that of the previous filter";
                return Err(Failure::found(at("parameter"), parameter, allowed));
            }
            check_number(&at("pole"), pole)?;
            check_number(&at("rate"), rate)?;
            if rate < 0.0 {
                return Err(Failure::found(at("rate"), rate, "a non-negative number"));
            }
            if before.is_some_and(|before| before.parameter == parameter && before.rate != rate) {
                return Err(Failure::found(
                    at("rate"),
                    rate,
                    "the rate of the other filters of this parameter",
                ));
            }
            before = Some(filter);
        }
        Ok(())
    }
}

impl Provable for Constant {
    fn name(&self) -> ClaimName {
        ClaimName::Constant
    }

    fn check(&self, path: &str, system: Loop<'_>) -> Result<(), Failure> {
        let (s, at) = (system.sizes(), |name: &str| format!("{path}.{name}"));
        system.check_no_direct_path(path)?;
        check_number(&at("gamma"), self.gamma)?;
        check_matrix(&at("L"), &self.lyapunov, s.states(), s.states())?;
        check_list(&at("lambdas"), &self.lambdas, (system.errors.len(), "model errors"))?;
        self.check_filters(path, system)?;
        let of_filter = |filter: &Filter| system.channels_of(filter.parameter);
        let filtered: usize = self.filters.iter().map(of_filter).sum();
        let with_rate: usize = self.filters.iter().filter(|filter| filter.rate > 0.0).map(of_filter).sum();
        let states = (s.states().0 + 2 * filtered, "states of plant, controller and filters");
        let channels = s.channels().0 + filtered + with_rate;
        let channels =
            (channels, "channels of plant and controller, filtered channels, and channels of rates");
        check_matrix(&at("X"), &self.x, states, states)?;
        check_matrix(&at("S"), &self.s, channels, channels)?;
        check_matrix(&at("T"), &self.t, channels, channels)
    }

    fn prove(&self, system: Loop<'_>) -> Result<(), Failure> {
        let claim = self.name();
        positive(claim, "gamma", self.gamma)?;
        self.filters.iter().try_for_each(|f| positive(claim, "the pole of a filter", f.pole))?;
        self.lambdas.iter().try_for_each(|lambda| positive(claim, "lambda", *lambda))?;
        symmetric(claim, "X", &self.x)?;
        symmetric(claim, "S", &self.s)?;
        skew(claim, "T", &self.t)?;
        symmetric(claim, "L", &self.lyapunov)?;
        let closed = ClosedLoop::new(system, system.errors)?;
        let filtered = Filtered::new(system, &self.filters, &closed);
        commuting(claim, "S", &self.s, &filtered.parameters())?;
        commuting(claim, "T", &self.t, &filtered.parameters())?;
        require_definite(claim, "L", Sign::Positive, &Matrix::square(&self.lyapunov))?;
        require_definite(claim, "A'L + LA", Sign::Negative, &filtered.lyapunov_form(&self.lyapunov))?;
        let all = system.parameters();
        for parameter in 0..all {
            let [own, rate] = [parameter, all + parameter].map(|index| filtered.multiplier(&self.s, index));
            require_definite(
                claim,
                &format!("the multiplier of parameter {parameter}"),
                Sign::Positive,
                &own,
            )?;
            let name = format!("the multiplier of the rate of parameter {parameter}");
            require_definite(claim, &name, Sign::Positive, &rate)?;
        }
        require_definite(
            claim,
            "the matrix of the inequality",
            Sign::Negative,
            &filtered.inequality((&self.x, &self.s, &self.t), self.gamma, &self.lambdas),
        )
    }
}

fn require_definite(claim: ClaimName, matrix: &str, sign: Sign, m: &Matrix) -> Result<(), Failure> {
    if if sign == Sign::Negative { shown_positive(&m.negated()) } else { shown_positive(m) } {
        return Ok(());
    }
    let reason = format!("{matrix} is not shown to be {} definite", sign.word());
    Err(Failure::NotDefinite { claim, part: matrix.into(), reason, pivot: None })
}
