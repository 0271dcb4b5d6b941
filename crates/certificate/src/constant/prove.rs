//! The claim for parameters some of which are constant, and its proof.
//!
//! # The claim
//!
//! The loop of plant and controller is, in the notation of the crate's root, `x' = A x + Bt wt + B1 w`, `zt = Ct x +
//! Dtt wt + Dt1 w`, `z = C1 x + D1t wt + D11 w`, `wt = Theta zt`. A parameter with filters stays in `[-1, 1]` and is
//! Lipschitz continuous with its `rate`, 1/s: constant where that is 0. Every other may take any measurable trajectory
//! in `[-1, 1]`. To `[A B2]` of the plant any `E Delta(t) [F Fu]` of `errors` may be added: `w_D = Delta z_D` enters x'
//! by E, with `z_D = F x + Fu u`. Then the loop through the parameters is well posed, the closed loop is exponentially
//! stable, and its L2 gain from w to z is below gamma.
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

use super::ConstantCertificate;
use super::inequality::Filtered;
use super::theorem::ConstantTheorem;
use crate::closed_loop::ClosedLoop;
use crate::error::{Claim, Failure, Proved};
use crate::exact::matrix::Matrix;
use crate::exact::witness::shown_positive;
use crate::prove::positive;
use crate::structure::{commuting, skew, symmetric};

const CLAIM: Claim = Claim::Nominal;

impl ConstantCertificate {
    /// Proves the claim in exact arithmetic.
    ///
    /// # Errors
    /// [`Failure`], the first condition that was not shown. The claim may still be true.
    pub fn prove(&self) -> Result<ConstantTheorem, Failure> {
        self.check()?;
        positive(CLAIM, "gamma", self.gamma)?;
        self.filters.iter().try_for_each(|f| positive(CLAIM, "the pole of a filter", f.pole))?;
        self.errors.iter().try_for_each(|e| positive(CLAIM, "lambda", e.lambda))?;
        symmetric(CLAIM, Proved::X, &self.x)?;
        symmetric(CLAIM, Proved::S, &self.s)?;
        skew(CLAIM, Proved::T, &self.t)?;
        symmetric(CLAIM, Proved::Lyapunov, &self.lyapunov)?;
        let frame = self.frame();
        let closed = ClosedLoop::new(&frame, frame.residual.as_ref())?;
        let filtered = Filtered::new(self, &closed);
        commuting(CLAIM, Proved::S, &self.s, &filtered.parameters())?;
        commuting(CLAIM, Proved::T, &self.t, &filtered.parameters())?;
        shown(Proved::Lyapunov, "positive", &Matrix::square(&self.lyapunov))?;
        shown(Proved::Decay, "negative", &filtered.decay())?;
        let all = self.parameters();
        for parameter in 0..all {
            shown(Proved::Multiplier(parameter), "positive", &filtered.multiplier(parameter))?;
            shown(Proved::RateMultiplier(parameter), "positive", &filtered.multiplier(all + parameter))?;
        }
        shown(Proved::Inequality, "negative", &filtered.main())?;
        Ok(ConstantTheorem::of(self))
    }
}

fn shown(matrix: Proved, sign: &'static str, m: &Matrix) -> Result<(), Failure> {
    let shown = if sign == "negative" { shown_positive(&m.negated()) } else { shown_positive(m) };
    if shown { Ok(()) } else { Err(Failure::NotShown { claim: CLAIM, matrix, sign }) }
}
