//! The gain with which a controller follows commands that are not its own.
//!
//! A controller `x+ = A x + B y, u = C x + D y` whose commands are not applied must be in the state in which its next
//! command is the applied one, r: `x <- x - F (u - r)`. F is the gain of a stationary Kalman filter for a controller
//! that is driven by unit white noise y and whose output r is measured almost exactly,
//!
//! ```text
//! P = A (P - F C P) A' + B B',   F = P C' (C P C' + R)^-1,   R = e tr(C B B' C')/m I
//! ```
//!
//! so `C F` is nearly the identity on the commands that the state can change, and the part of x that r does not
//! determine is the response to y. F depends on the coordinates of the state. The equation is solved by doubling.
//!
//! Source: E. K.-W. Chu, H.-Y. Fan, W.-W. Lin, C.-S. Wang, "Structure-preserving algorithms for periodic discrete-time
//! algebraic Riccati equations", Int. J. Control 77(8), 2004.

use crate::matrix::{Mat, solve};
use crate::system::StateSpace;

/// e, the part of the variance of a command that is taken as the error of its measurement.
const MEASUREMENT: f64 = 1e-6;

/// The number of doublings, which cover 2^60 ticks.
const MOST_DOUBLINGS: usize = 60;

/// The relative change at which P is accepted.
const CONVERGED: f64 = 1e-12;

/// Returns F, n x m, for a frozen controller in continuous time that is discretised by the trapezoidal rule, to
/// `(N (I + A T/2), N B T, C N, D + C N B T/2)` with `N = (I - A T/2)^-1`; T is the sample time in s.
///
/// `None` if y does not affect u through the state, or no solution of the equation is found.
pub fn following_gain(controller: &StateSpace, sample_time: f64) -> Option<Mat> {
    let n = controller.a.nrows();
    let one = Mat::identity(n, n);
    let half = &controller.a * (0.5 * sample_time);
    let implicit = solve(&(&one - &half), &one)?;
    let (a, c) = (&implicit * (&one + half), &controller.c * &implicit);
    let b = implicit * &controller.b * sample_time;
    let moved = &b * b.transpose();
    let variance = (&c * &moved * c.transpose()).trace() / c.nrows() as f64;
    if !(n > 0 && variance > 0.0 && variance.is_finite()) {
        return None;
    }
    let error = MEASUREMENT * variance;
    let (mut x, mut g, mut p) = (a.transpose(), c.transpose() * &c / error, moved);
    for _ in 0..MOST_DOUBLINGS {
        let inverse = solve(&(&one + &g * &p), &one)?;
        let next = &p + x.transpose() * &p * &inverse * &x;
        g += &x * &inverse * &g * x.transpose();
        x = &x * inverse * &x;
        let change = (&next - &p).norm();
        p = (&next + next.transpose()) * 0.5;
        if change <= CONVERGED * p.norm() {
            let across = &p * c.transpose();
            let measured = &c * &across + Mat::identity(c.nrows(), c.nrows()) * error;
            return Some(solve(&measured, &across.transpose())?.transpose());
        }
    }
    None
}
