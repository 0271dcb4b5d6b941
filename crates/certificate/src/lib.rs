//! Proves the gain bound of an LPV closed loop from its certificate, in exact arithmetic.
//!
//! ```text
//! JSON text -> Certificate: a loop and a list of claims -> check shapes
//!           -> each claim: close the loop -> structure of X, S, T -> X > 0, S > 0, LMI < 0 -> Theorem
//! ```
//!
//! # The theorem
//!
//! Plant and controller are linear fractional transformations in the same parameters, `wt = Theta zt` and
//! `wk = Theta zk` with `Theta = blkdiag(theta_i I_ri)`. Closed, they are
//!
//! ```text
//! x' = A x + Bt wt + B1 w,   zt = Ct x + Dtt wt + Dt1 w,   z = C1 x + D1t wt + D11 w,   wt = Theta_e zt
//! ```
//!
//! where the states and channels of the plant come first, and `Theta_e = blkdiag(Theta, Theta)`.
//!
//! *The claim `gain`.* For every measurable trajectory with `|theta_i(t)| <= 1` the parameter loop is well posed, the
//! closed loop is exponentially stable, and its L2 gain from w to z is below gamma.
//!
//! A certificate with the claim `rate` may omit this one, together with the claims with model error and `limits`:
//! nothing is then claimed about a parameter that changes faster than its rate.
//!
//! *Conditions, checked without rounding.* `gamma > 0`; `X = X' > 0`; `S = S' > 0` and `T = -T'` commute with
//! `Theta_e`; and
//!
//! ```text
//! [ A'X+XA   XBt+Ct'T'          XB1      Ct'S    C1'  ]
//! [   *     -S+TDtt+Dtt'T'      T Dt1    Dtt'S   D1t' ]
//! [   *        *               -gamma I  Dt1'S   D11' ]  < 0        rows x, wt, w, zt, z
//! [   *        *                 *       -S      0    ]
//! [   *        *                 *        *   -gamma I]
//! ```
//!
//! *Why they suffice* (P. Apkarian, P. Gahinet, IEEE Trans. Automatic Control 40(5), 1995, lemma 3.1; the skew
//! scaling: G. Scorletti, L. El Ghaoui, Int. J. Robust Nonlinear Control 8, 1998):
//!
//! - *The parameters.* S and Theta_e commute and S > 0, so `zt'S zt - wt'S wt = zt' S (I - Theta_e^2) zt >= 0`
//!   whenever `wt = Theta_e zt`. Theta_e T is skew, because `(Theta_e T)' = -T Theta_e = -Theta_e T`; so `wt'T zt =
//!   0`.
//! - *Well-posedness.* Rows and columns wt and zt alone, after a Schur complement, read
//!   `-S + T Dtt + Dtt'T' + Dtt'S Dtt < 0`. If `I - Theta_e Dtt` were singular, there would be `wt = Theta_e zt != 0`
//!   with `zt = Dtt wt`, and that matrix would give `-wt'S wt + 2 wt'T zt + zt'S zt >= 0`, a contradiction. On the
//!   compact box the inverse is then bounded, and the loop has measurable, bounded coefficients.
//! - *Stability and gain.* Schur complements of the rows zt and z give, for some `eps > 0`, all x, wt, w, and
//!   `V = x'X x`, `dV/dt + (zt'S zt - wt'S wt) + 2 wt'T zt + z'z/gamma - gamma w'w <= -eps (x'x + w'w)`. The two terms
//!   of the parameters are non-negative along the loop. With `w = 0`, V decays exponentially; integrated from
//!   `x(0) = 0`, the energy of z is at most `gamma^2 - eps gamma` times that of w.
//!
//! *With a direct path* `D22` of the plant, `y = C2 x + D2t wt + D21 w + D22 u`: with `wt = 0` and `wk = 0`, i.e.
//! at `Theta = 0`, u and y are determined by the states and w if and only if `I - Duy D22` is regular. This is
//! checked. They are then linear in x, wt, wk and w at every Theta, the closed loop has the form above, and the proof
//! applies; its parameter loop is well posed by the block of wt and zt, so that plant and controller
//! determine all signals together at every Theta. Its matrices have the denominator `det(I - Duy D22)`. The
//! inequality is linear in them and contains no product of two of them. Multiplied by the magnitude of that
//! determinant, which is positive, it contains sums and products of the file's numbers alone.
//!
//! *With a model error* (an entry of `errors`, and a claim `gain` with `lambda`): `[A B1 B2]` of the plant becomes `[A
//! B1 B2] + E Delta(t) [F Fw Fu]`, i.e. `x' = ... + E w_D`, `w_D = Delta z_D`, `z_D = F x + Fw w + Fu u`, which is `F_x
//! x + F_t wt + F_w w` once the controller gives u; Fw is 0 where the file has none. For `||Delta|| <= 1` and `lambda >
//! 0`, `lambda (z_D'z_D - w_D'w_D) >= 0`: added to the left side above, it gives the inequality a row w_D, `[E'X 0
//! -lambda I 0 0 0 0]`, and a row z_D, `[lambda F_x  lambda F_t  0  lambda F_w  0 -lambda I  0]`. Delta acts on x'
//! alone, so the parameter loop stays well posed as before.
//!
//! *With a bounded rate* (the claim `rate`): for one parameter, Lipschitz continuous with `|theta'| <= rate` almost
//! everywhere, a Lyapunov matrix that depends on it, `X(theta) = X_0 + theta X_1 + ...`, shows a smaller gamma. On
//! each interval between breakpoints there is a constant multiplier N, and for both signs the form
//!
//! ```text
//! q(xi) = 2 x'X(theta) x' +- rate x' dX/dtheta x + 2 (N xi)'(wt - theta zt) + z'z/gamma - gamma w'w,  xi = (x, wt, w)
//! ```
//!
//! must be negative definite at every theta of the interval, with x', zt and z the rows of the closed loop in terms of
//! xi. It is a matrix polynomial in theta, and negative definite on the interval if its Bernstein coefficients there
//! are, which exact arithmetic decides. The breakpoints ascend from -1 to 1, and `X_0` must be positive definite. (F.
//! Wu, X. H. Yang, A. Packard, G. Becker, Int. J. Robust Nonlinear Control 6, 1996; the multiplier: P. Finsler,
//! Comment. Math. Helv. 9, 1937.) Why this suffices:
//!
//! - *Well-posedness.* If `wt = theta Dtt wt` with wt not 0, then q of `(0, wt, 0)` is `z'z/gamma >= 0`.
//! - *X(theta) is positive definite.* With `w = 0` and wt from the loop, the mean of the two signs is `2 x'X(theta)
//!   x' < 0` for every x but 0, with `x' = A(theta) x`. So `X(theta) v = 0` only for v = 0: no eigenvalue of
//!   X(theta), which is continuous, reaches 0 on the way from `X_0`.
//! - *Stability and gain.* Along the loop the term of N vanishes, and `dV/dt = 2 x'X x' + theta' x' dX/dtheta x` of
//!   `V = x'X(theta) x` is between its values for the two signs. On the compact range `dV/dt + z'z/gamma - gamma w'w
//!   <= -eps (x'x + w'w)` for some `eps > 0`, and the rest is as above.
//!
//! With `lambda` the claim covers the model error: `lambda (z_D'z_D - w_D'w_D)` is added to q, and xi gets w_D.
//!
//! With `inverse` the matrices are those of the transposed loop, `A', Ct', C1', ...` in place of `A, Bt, B1, ...`. At
//! each theta, with wt eliminated, its inequality is
//! `[A Q + Q A' -+ rate dQ/dtheta, Q C', B; *, -gamma I, D; *, *, -gamma I] < 0` with `Q = X(theta)`, and multiplied by
//! `blkdiag(Q^-1, I, I)` from both sides it is that of the loop itself with the Lyapunov matrix `Q^-1`, whose
//! derivative is `-Q^-1 dQ/dtheta Q^-1`; lambda becomes 1/lambda.
//!
//! *With limits* (the claim `limits`): the plant gets `u - phi`, xk' gets `E phi`, with `phi = u - sat(u)`, and sat
//! limits each command at `limit_j` or above, in both directions. Only those states of the plant count that controls or
//! Delta drive, also through channels, and that act on channels, Delta or y ([`Certificate::moving_states`]). The
//! others are weights that only z depends on, or filters of w. In place of these filters, one component of w steps from
//! 0 to any r with `|r| <= size` and, later, back. While the step is held, x denotes the state minus `r x_held`. With
//! `V = x'Xx` and the model error (only the first `delta_rows` rows of Delta may differ from 0, if the file has this
//! key), the form
//!
//! ```text
//! dV/dt + decay V - decay beta (r/size)^2 + zt'S zt - wt'S wt + 2 wt'T zt + lambda (z_D'z_D - w_D'w_D)
//!     + 4 phi'U (u - phi - H x - r u_held)
//! ```
//!
//! must be negative definite in (x, wt, phi, w_D, r); `X > 0`; `size^2 x_held'X x_held < beta`; and for each command
//! `size |u_held_j| <= limit_j/2` and `[X h_j'; h_j limit_j^2/(4 beta)] > 0`. The rates of the plant's states in
//! `rates` are saturated, too: the derivative of such a state is `x_i' - phi_j`, with x_i' from the plant's equations
//! and `phi_j = x_i' - sat(x_i')`; x_i' is one of the u of the form. Delta does not act on these states. *Claim:* from
//! rest, V stays below beta while the step is held, is below `4 beta` when it has been removed, and then decays at
//! least as fast as `exp(-decay t)`.
//!
//! - *The region.* Where V < beta, `|h_j x + r u_held_j| < limit_j`; with r = 0 also where `V < 4 beta`. Where phi_j is
//!   positive, `u_j - phi_j` is at the upper limit, which is at least `limit_j`, so that the other factor is positive;
//!   likewise where phi_j is negative. So the term of U is not negative, and `dV/dt < 0` at V = beta. Removing the step
//!   adds `r x_held` to x, and so less than the square root of beta to that of V.
//! - *Well-posedness.* With `e = u - H x - r u_held` and `s = 2 phi - e`, `4 phi'U (e - phi) = e'U e - s'U s`: the form
//!   is the inequality of a loop with further parameters, `s_j = delta_j e_j`, `|delta_j| <= 1`, and is proved as such,
//!   with `decay/2` added to A. For two values of u, the phi differ by a share of the difference, between 0 and 1,
//!   which corresponds to such parameters. So the loop equation for u is one to one at each theta, as that for wt and
//!   zt is.
//! - *Rates.* The phi of a rate has the sign of the excess over its limit, like that of a command; nothing above
//!   depends on the origin of the u of a phi, or on the signals on which a phi acts. (A lag with a limited rate as a
//!   second saturation: F. Tyan, D. S. Bernstein, Int. J. Control 67(4), 1997.)
//!
//! *In discrete time* (`discrete`), `x+`, the state at the next tick, replaces `x'`, and the sums of squares over the
//! ticks replace the energies. Only the claim `gain` without model error is available; its inequality is
//!
//! ```text
//! [ -X    Ct'T'              0         A'X     Ct'S    C1'  ]
//! [  *   -S+TDtt+Dtt'T'      T Dt1     Bt'X    Dtt'S   D1t' ]
//! [  *      *               -gamma I   B1'X    Dt1'S   D11' ]  < 0        rows x, wt, w, x+, zt, z
//! [  *      *                  *       -X      0       0    ]
//! [  *      *                  *        *     -S       0    ]
//! [  *      *                  *        *      *   -gamma I]
//! ```
//!
//! Schur complements of the rows x+, zt and z turn it into
//! `x+'X x+ - x'X x + (zt'S zt - wt'S wt) + 2 wt'T zt + z'z/gamma - gamma w'w <= -eps (x'x + w'w)`. The rest is as
//! above, with sums in place of integrals: for every sequence of Theta in the box the loop is well posed and
//! exponentially stable, and its l2 gain is below gamma. (P. Gahinet, P. Apkarian, Int. J. Robust Nonlinear Control 4,
//! 1994.)
//!
//! # What it does not cover
//!
//! - Saturation of the actuators, except in the claim `limits`: in all other claims the loop is linear at every
//!   instant.
//! - Sampling: in continuous time the controller is the continuous one of the file, with Theta(t) measured without
//!   delay or error; in discrete time nothing is claimed between the ticks.
//! - The nonlinear vehicle: the plant is the LPV model of the file. A model error covers those of its `A`, `B1` and
//!   `B2`, up to the size that the file states, and no others.
//! - A plant or controller other than those of the file: users must compare them with those in use.
//!
//! # Exactness
//!
//! Every number of the file is read as the f64 nearest to it, and every f64 is exactly a number `m 2^e`. Sums and
//! products of such numbers are formed without rounding; a matrix counts as definite when exact arithmetic says so.
//! The crate shares no code with the synthesis of the controller.
//!
//! # Example
//!
//! The plant `x' = u + w`, `z = y = x` under `u = -y` has the gain 1, which is below 1.25:
//!
//! ```
//! let text = r#"{"format": "lpv-certificate/1", "blocks": [], "controller_blocks": [],
//!   "plant": {"A": [[0]], "Bt": [[]], "B1": [[1]], "B2": [[1]], "Ct": [], "C1": [[1]], "C2": [[1]], "Dtt": [],
//!     "Dt1": [], "Dt2": [], "D1t": [[]], "D11": [[0]], "D12": [[0]], "D2t": [[]], "D21": [[0]]},
//!   "controller": {"A": [], "By": [], "Bt": [], "Cu": [[]], "Duy": [[-1]], "Dut": [[]], "Ct": [], "Dty": [],
//!     "Dtt": []},
//!   "claims": [{"gain": {"gamma": 1.25, "X": [[1]], "S": [], "T": []}}]}"#;
//! let theorem = squid_certificate::Certificate::from_json(text)?.prove()?;
//! assert_eq!(
//!     theorem.to_string(),
//!     "The closed loop of 1 state is exponentially stable and its L2 gain from w to z is below 1.25. \
//!      The certificate covers no model error: nothing is proved about a plant that differs from the one in it."
//! );
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! - [`Certificate`], [`Plant`], [`Controller`], [`ModelError`]: the loop of the file;
//! - [`Claim`]: its claims, each in a file of `claim/`; the one with constant parameters is explained and proved in
//!   `claim/constant.rs`;
//! - [`Certificate::prove`]: the proof, with a [`Theorem`] or a [`Failure`] as its result;
//! - [`lower_bound`]: a gamma below which no controller exists, proved from [`Multipliers`];
//! - [`from_json`]: a strict JSON reader, also for other files; a [`JsonError`] contains the path to the error.

mod certificate;
mod claim;
mod closed_loop;
mod error;
mod exact;
mod inequality;
mod lower_bound;
mod plant;
mod prove;
mod shape;
mod strict;
mod structure;
mod system;
mod theorem;

pub use certificate::{Certificate, Format};
pub use claim::{Claim, Constant, ConstantTheorem, Filter, Gain, LimitTheorem, Limits, Rate, RateTheorem};
pub use error::{ClaimName, Failure};
pub use lower_bound::{Multipliers, lower_bound};
pub use plant::{Controller, ModelError, Plant, Rows};
pub use strict::{JsonError, from_json, given};
pub use theorem::Theorem;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
