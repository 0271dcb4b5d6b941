//! The largest size of Delta for a gain, by widening a bound of the loop step by step.
//!
//! The rows N of Delta's channels grow with the size: the inequality of [`crate::analysis::bounded_gain()`] becomes
//!
//! ```text
//! F(X, S, T) + tau N' S_d N < 0,   tau = (size / previous size)^2 - 1
//! ```
//!
//! where S_d is Delta's part of S, and Delta's part of T is divided by the growth of the size. In the coordinates in
//! which the previous S is the identity, `S_d < growth I` and `F + tau growth N'N < 0` suffice: tau enters linearly,
//! and tau = 0 is feasible at the previous point, which therefore is a starting point. The size that the multipliers
//! actually prove is evaluated afterwards. The ratio is thus maximised as in W. Dinkelbach, Management Science 13(7),
//! 1967.

use crate::analysis::bounded_gain::{Base, Posed};
use crate::lmi::{Affine, SolverOptions, solver};
use crate::matrix::{Mat, block, largest_eigenvalue};
use crate::robust::bound::{RobustBound, RobustLoop};
use crate::system::LoopError;

/// The largest growth of S_d in one step.
const LARGEST_GROWTH: f64 = 4.0;

/// The tolerance of tau in a step, relative to (1 + tau), and the one accepted if the search gets stuck.
const STEP_TOLERANCE: f64 = 0.05;
const NEAR_ENOUGH: f64 = 0.3;

/// The fraction of a step that is taken, to the multipliers found and to the size that they prove: the next step starts
/// in the interior of its inequality.
const PART_OF_WAY: f64 = 0.95;

/// The largest number of steps, and the growth of the size below which a step is the last.
const MOST_STEPS: usize = 40;
const LEAST_GROWTH: f64 = 0.02;

impl RobustLoop<'_> {
    /// Returns the bound of the largest size at which the gain stays below the gamma of a bound, within a few per cent,
    /// or of one beyond `enough`.
    pub(crate) fn widened(&self, known: &RobustBound, enough: f64) -> RobustBound {
        let mut at = known.clone();
        for _ in 0..MOST_STEPS {
            let Some(next) = self.step(&at) else { break };
            let growth = next.size / at.size - 1.0;
            if growth > 0.0 {
                at = next;
            }
            if growth < LEAST_GROWTH || at.size > enough {
                break;
            }
        }
        at
    }

    /// Returns multipliers for a larger size.
    fn step(&self, at: &RobustBound) -> Option<RobustBound> {
        let closed = self.closed(at.size);
        let none = LoopError::none(&closed);
        let base = Base { closed: &closed, error: &none, bound: &at.bound };
        let mut posed = Posed::new(base, true).ok()?;
        let (rows, scaled) = (self.of_delta(), &posed.scaled);
        let (channels, k) = (scaled.channels.len(), rows.len());
        let without_z = Mat::zeros(channels, scaled.c1().nrows());
        let n = block(&[&[&scaled.ct(), &scaled.dtt(), &scaled.dt1(), &without_z]]);
        let n = n.rows(rows.start, k).into_owned();
        let of_delta =
            posed.unknowns.s.congruence(&Mat::identity(channels, channels).columns_range(rows).into());
        let tau = posed.program.scalar();
        posed.start.push(0.0);
        posed.program.positive("X", posed.unknowns.x.clone());
        posed.program.positive("S", posed.unknowns.s.clone());
        let most = Mat::identity(k, k) * LARGEST_GROWTH;
        posed.program.positive("growth of S_d", Affine::constant(most) - of_delta.clone());
        let wider = tau.times_identity(k).congruence(&(&n * LARGEST_GROWTH.sqrt()));
        posed.program.negative("bounded real", posed.inequality.clone() + wider);
        posed.program.minimise_trace(&tau, -1.0);
        let search = SolverOptions {
            start: Some(&posed.start),
            enough: NEAR_ENOUGH,
            ..SolverOptions::within(STEP_TOLERANCE)
        };
        let found = solver::solve(&posed.program, STAGE, search).ok()?.x;
        let point: Vec<f64> =
            posed.start.iter().zip(&found).map(|(from, to)| from + PART_OF_WAY * (to - from)).collect();
        // The largest tau with F + tau N' S_d N <= 0.
        let value = |e: &Affine| e.value(&posed.program, &point);
        let root = (-value(&posed.inequality)).cholesky()?.unpack();
        let wider = root.solve_lower_triangular(&value(&of_delta.congruence(&n)))?;
        let largest = largest_eigenvalue(&root.solve_lower_triangular(&wider.transpose())?);
        let size = at.size * (1.0 + PART_OF_WAY / largest).sqrt();
        let wider = self.resized(&RobustBound { size: at.size, bound: posed.bound(base, &point) }, size);
        (wider.bound.largest_eigenvalue < 0.0).then_some(wider)
    }

    /// Returns the multipliers of a bound at another size.
    pub fn resized(&self, at: &RobustBound, size: f64) -> RobustBound {
        let mut out = RobustBound { size, bound: at.bound.clone() };
        let rows = self.of_delta();
        out.bound.t.view_mut((rows.start, rows.start), (rows.len(), rows.len())).scale_mut(at.size / size);
        out.bound.largest_eigenvalue = self.worst_eigenvalue(&out);
        out
    }
}

const STAGE: &str = "size of the uncertainty";
