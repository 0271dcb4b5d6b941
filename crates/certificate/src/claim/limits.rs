//! Return to rest from a step with saturated commands, with the model error.

use super::gain::{check_scalings, prove_gain};
use super::proved::Provable;
use crate::closed_loop::ClosedLoop;
use crate::error::ClaimName;
use crate::error::Failure;
use crate::exact::dyadic::Dyadic;
use crate::exact::matrix::Matrix;
use crate::inequality::Blocked;
use crate::plant::{ModelError, Rows};
use crate::shape::{check_list, check_matrix, check_number, columns};
use crate::strict::given;
use crate::structure::{Sign, definite, positive, symmetric};
use crate::system::Loop;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Claim about a step with saturated commands, for the plant with its model error.
///
/// The plant gets `u - phi`, and `E phi` is added to the derivative of the controller's state, with `phi = u - sat(u)`.
/// Likewise the rates of some of the plant's states are saturated. n is the number of states of that loop: those of the
/// plant that belong to it, then the controller's; see the crate's documentation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Limits {
    /// Component of w that steps, from 0.
    pub input: usize,
    /// Largest step.
    pub size: f64,
    /// Smallest limit of each command, in both directions; then that of the rate of each state of `rates`.
    pub limits: Vec<f64>,
    /// States of the plant with saturated rates; empty without this key. Each has an entry of `limits`, `u_held`, `U`
    /// and `H`, after those of the commands.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rates: Vec<usize>,
    /// Anti-windup gain, nk x u.
    #[serde(rename = "E")]
    pub e: Rows,
    /// Decay rate of x'Xx after the step is removed.
    pub decay: f64,
    /// Bound of x'Xx while the step is held, for the deviation x from `x_held` times the step.
    pub beta: f64,
    /// State from which x is measured while a step of 1 is held, n numbers.
    pub x_held: Vec<f64>,
    /// Commands from which H x is measured while a step of 1 is held.
    pub u_held: Vec<f64>,
    /// Number of first rows of Delta that may differ from 0 in this claim; all without this key.
    #[serde(default, deserialize_with = "given", skip_serializing_if = "Option::is_none")]
    pub delta_rows: Option<usize>,
    /// Multiplier of Delta.
    pub lambda: f64,
    /// Lyapunov matrix, n x n.
    #[serde(rename = "X")]
    pub x: Rows,
    /// Symmetric scaling.
    #[serde(rename = "S")]
    pub s: Rows,
    /// Skew scaling.
    #[serde(rename = "T")]
    pub t: Rows,
    /// Multiplier of each limit.
    #[serde(rename = "U")]
    pub u: Vec<f64>,
    /// Rows h of the bounds `|h x + step u_held| < limit` that hold in the region, u x n.
    #[serde(rename = "H")]
    pub h: Rows,
}

/// Proved claim about a step with saturated commands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LimitTheorem {
    /// Component of w that steps, from 0.
    pub input: usize,
    /// Largest step, measured as the jump of one y.
    pub size: f64,
    /// Decay rate after the step is removed.
    pub decay: f64,
    /// Number of rows of Delta that may differ from 0, if not all.
    pub delta_rows: Option<usize>,
    /// Number of states of the plant with saturated rates.
    pub rates: usize,
    /// `true` if H is 0: the claim holds from every state.
    pub everywhere: bool,
}

impl LimitTheorem {
    pub(crate) fn of(claim: &Limits) -> Self {
        let Limits { input, size, decay, delta_rows, .. } = *claim;
        Self { input, size, decay, delta_rows, rates: claim.rates.len(), everywhere: is_zero(&claim.h) }
    }
}

impl fmt::Display for LimitTheorem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { input, size, decay, delta_rows, rates, everywhere } = self;
        let rate_limits = match rates {
            0 => String::new(),
            1 => " and the rate of 1 state of the plant limited".to_owned(),
            n => format!(" and the rates of {n} states of the plant limited"),
        };
        let rows =
            delta_rows.map_or_else(String::new, |rows| format!(" with zero rows after the first {rows}"));
        let where_ = if *everywhere { "from every state" } else { "within its region" };
        write!(
            f,
            "With commands saturated at the limits in the file{rate_limits}, anti-windup with the gain E, and the \
             same Delta{rows}: after a step of at most {size} from rest at input {input}, applied after the filters \
             of the plant that the loop does not drive (an equal jump of one measurement), held for any time and \
             removed, the state is in the region in the file. The loop then returns to rest exponentially, {where_}: \
             x'Xx decays at the rate {decay}."
        )
    }
}

impl Limits {
    /// Returns the number of states with saturated rates, after a check that they differ, belong to the loop, and are
    /// not driven by Delta.
    fn check_rates(&self, path: &str, system: Loop<'_>, error: &ModelError) -> Result<usize, Failure> {
        let moving = system.moving_states();
        let rows = self.delta_rows.unwrap_or(usize::MAX);
        let by_delta = |row: &Vec<f64>| row.iter().take(rows).any(|entry| *entry != 0.0);
        for (i, state) in self.rates.iter().enumerate() {
            if !moving.contains(state)
                || self.rates[..i].contains(state)
                || error.e.get(*state).is_some_and(by_delta)
            {
                let allowed =
                    "a state of the plant that the loop drives and Delta does not, without repetition";
                return Err(Failure::found(format!("{path}.rates[{i}]"), state, allowed));
            }
        }
        Ok(self.rates.len())
    }
}

impl Provable for Limits {
    fn name(&self) -> ClaimName {
        ClaimName::Limits
    }

    fn check(&self, path: &str, system: Loop<'_>) -> Result<(), Failure> {
        let error = &system.errors[0];
        let (s, at) = (system.sizes(), |name: &str| format!("{path}.{name}"));
        if let Some(rows) = self.delta_rows.filter(|rows| !(1..=columns(&error.e)).contains(rows)) {
            let allowed = "from 1 to the number of columns of errors[0].E";
            return Err(Failure::found(at("delta_rows"), rows, allowed));
        }
        system.check_no_direct_path(path)?;
        if self.input >= s.w {
            let reason = format!("found {}; it must be below {}, the number of inputs w", self.input, s.w);
            return Err(Failure::malformed(at("input"), reason));
        }
        if system.jumping_measurement(self.input).is_none() {
            let allowed = "an input w whose step is an equal jump of one measurement y and acts on the loop in no \
                           other way, nor through filters (`size` would not cover all of its effect)";
            return Err(Failure::found(at("input"), self.input, allowed));
        }
        let states = (system.moving_states().len() + s.xk, "states of the loop with limits");
        let limited = (s.u + self.check_rates(path, system, error)?, "controls u and rates");
        check_matrix(&at("E"), &self.e, (s.xk, "states of the controller"), s.controls())?;
        check_scalings(path, states, s, ("X", &self.x), [&self.s, &self.t])?;
        check_matrix(&at("H"), &self.h, limited, states)?;
        let numbers = [self.size, self.decay, self.beta, self.lambda];
        let mut numbers = ["size", "decay", "beta", "lambda"].into_iter().zip(numbers);
        numbers.try_for_each(|(name, x)| check_number(&at(name), x))?;
        check_list(&at("limits"), &self.limits, limited)?;
        check_list(&at("x_held"), &self.x_held, states)?;
        check_list(&at("u_held"), &self.u_held, limited)?;
        check_list(&at("U"), &self.u, limited)
    }

    /// Proves that a held step leaves x within `x'Xx < beta`, a removed one within `4 beta`, that `|H x|` is below half
    /// of each limit in the first region and below the limit in the second, and that x'Xx decreases.
    fn prove(&self, system: Loop<'_>) -> Result<(), Failure> {
        let claim = self.name();
        for (name, found) in [("size", self.size), ("decay", self.decay), ("beta", self.beta)] {
            positive(claim, name, found)?;
        }
        self.limits.iter().try_for_each(|limit| positive(claim, "a limit", *limit))?;
        let [size, decay, beta] = [self.size, self.decay, self.beta].map(Dyadic::from_f64);
        let closed = ClosedLoop::limited(system, self, &system.errors[0])?;
        symmetric(claim, "X", &self.x)?;
        let x = Matrix::from_rows(&self.x, closed.states);
        let (s, t) = (block_diagonal(&self.s, &self.u), block_diagonal(&self.t, &vec![0.0; self.u.len()]));
        prove_gain(claim, &closed, &decay * &beta, Some(self.lambda), x.clone(), (&s, &t))?;
        let too_large = |beyond: String| {
            Failure::condition(claim, "size", format_args!("a step of {:e} {beyond}", self.size))
        };
        let held = Matrix::from_rows(&vec![self.x_held.clone()], closed.states).scaled(&size);
        let level = &held.times(&x).times(&held.transpose())[(0, 0)];
        if !(&beta + &-level).is_positive() {
            return Err(too_large("drives x'Xx to beta or above".into()));
        }
        for (j, (limit, u)) in self.limits.iter().zip(&self.u_held).enumerate() {
            let used = (&size * &Dyadic::from_f64(*u)).abs().shifted(1);
            if (&used + &-&Dyadic::from_f64(*limit)).is_positive() {
                return Err(too_large(format!("requires more than half of limit {j}")));
            }
        }
        out_of_reach(claim, (&x, &self.h, &self.limits), &beta.shifted(2), "4 beta")
    }
}

/// `[X h_j'; h_j limit_j^2/level]` is positive definite for each limit: |h_j x| is below it where x'Xx is at most the
/// level.
pub(super) fn out_of_reach(
    claim: ClaimName,
    (x, h, limits): (&Matrix, &Rows, &[f64]),
    level: &Dyadic,
    name: &str,
) -> Result<(), Failure> {
    let n = x.rows;
    for (index, (limit, h)) in limits.iter().zip(h).enumerate() {
        // The last row and column are multiplied by the level.
        let limit = Dyadic::from_f64(*limit);
        let row = Matrix::from_rows(&vec![h.clone()], n).scaled(level);
        let mut whole = Matrix::scalar(n + 1, &(level * &(&limit * &limit)));
        whole.place(0, 0, x);
        whole.place(n, 0, &row);
        whole.place(0, n, &row.transpose());
        let blocks = vec![("x", n), ("limit", 1)];
        let whole = Blocked { matrix: whole, blocks, scale: Dyadic::from_f64(1.0) };
        definite(claim, &format!("[X h'; h limit^2/({name})] of limit {index}"), Sign::Positive, &whole)?;
    }
    Ok(())
}

/// Returns `blkdiag(m, diag(more))`.
pub(super) fn block_diagonal(m: &Rows, more: &[f64]) -> Rows {
    let (n, all) = (m.len(), m.len() + more.len());
    let entry = |i: usize, j: usize| match (i < n, j < n) {
        (true, true) => m[i][j],
        (false, false) if i == j => more[i - n],
        _ => 0.0,
    };
    (0..all).map(|i| (0..all).map(|j| entry(i, j)).collect()).collect()
}

pub(super) fn is_zero(m: &Rows) -> bool {
    m.iter().flatten().all(|entry| *entry == 0.0)
}
