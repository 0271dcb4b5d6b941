//! Solution of a program of linear matrix inequalities, with a check of the result.
//!
//! A primal-dual interior-point method is tried first (`interior_point.rs`): it exploits the structure of these
//! inequalities and returns a strictly feasible point with a bound on its distance from the optimum. A general conic
//! solver (`conic.rs`) is used if it gets stuck, and for proofs of infeasibility. A solver's report is not trusted:
//! every inequality is evaluated at the returned point and the least eigenvalue reported.

use crate::error::SynthesisError;
use crate::lmi::{ConicProgram, LowRank, Program, SolverOptions, Verdict, WAYS, interior_point};
use crate::matrix::{Mat, scaled_least_eigenvalue};

/// A point returned by a solver, and the margin of the inequalities there.
#[derive(Debug, Clone)]
pub struct Solution {
    /// The unknowns of the program.
    pub x: Vec<f64>,
    /// The least eigenvalue over all inequalities, each scaled to a unit diagonal: the point satisfies them strictly
    /// if it is positive.
    pub margin: f64,
    /// The largest possible excess of the objective over the least, relative to its size plus [`SolverOptions::floor`],
    /// by multipliers in floating point; infinite if unknown.
    pub gap: f64,
    /// A lower bound of the objective by multipliers in floating point, valid for points no farther from zero than
    /// `REACH` times this one; minus infinity if unknown.
    pub lower: f64,
    /// Multipliers of the last steps, one matrix per inequality; the last are closest to the optimum.
    pub(crate) multipliers: Vec<Vec<Mat>>,
}

impl Solution {
    /// Returns the point if it satisfies the inequalities.
    ///
    /// # Errors
    /// Returns [`SynthesisError::Numerical`] if it does not.
    pub(crate) fn feasible(self, stage: &'static str) -> Result<Self, SynthesisError> {
        if self.margin > 0.0 {
            return Ok(self);
        }
        let diagnosis = format!("the inequalities are violated by {:.1e}", -self.margin);
        Err(SynthesisError::numerical(stage, diagnosis))
    }
}

/// Solves `program`.
///
/// ```text
/// minimise c'x   subject to   F_k(x) = F_k0 + sum x_i F_ki > 0 for every inequality k
/// ```
///
/// `stage` names the program in errors.
///
/// # Errors
/// Returns [`SynthesisError::Infeasible`] if the general solver's certificate, verified here, excludes all points of
/// reasonable size, and [`SynthesisError::Numerical`] if no point was found for any other reason.
pub fn solve(
    program: &Program,
    stage: &'static str,
    search: SolverOptions<'_>,
) -> Result<Solution, SynthesisError> {
    let data: Vec<LowRank> =
        program.inequalities.iter().map(|i| LowRank::new(program, &i.expression)).collect();
    let costs = program.costs();
    let enough = if search.patient { search.tolerance } else { search.tolerance.max(search.enough) };
    let mut best: Option<Solution> = None;
    let mut lowest = f64::NEG_INFINITY;
    for evenness in EVENNESS {
        let even: Vec<LowRank> = data.iter().map(|d| d.with_even_rows(evenness)).collect();
        let Some(stop) = interior_point::minimise(&even, &costs, search) else { continue };
        let of_rows = |m: Vec<Mat>| m.iter().zip(&data).map(|(m, d)| d.uneven(m, evenness)).collect();
        let bounds = stop.multipliers.iter().map(|step| lower(&even, &costs, step, &stop.x));
        let lower = bounds.fold(lowest, f64::max);
        lowest = lower;
        let multipliers = stop.multipliers.into_iter().map(of_rows).collect();
        let solution = Solution { multipliers, lower, ..evaluated(program, stop.x, stop.gap) };
        if best.as_ref().is_none_or(|known| better(&solution, known, &costs)) {
            best = Some(solution);
        }
        // Scaling the rows helps a search from scratch, not one from a feasible point.
        let known = search.quick && search.start.is_some();
        if known || best.as_ref().is_some_and(|best| best.gap <= enough && best.margin > 0.0) {
            break;
        }
    }
    let best = best.map(|best| Solution { lower: lowest, ..best });
    match best {
        Some(best) if best.gap <= search.tolerance || search.start.is_some() || !search.patient => Ok(best),
        best if search.quick => best.ok_or_else(|| {
            SynthesisError::numerical(stage, "no feasible point was found, and no other solver was tried")
        }),
        Some(best) if costs.len() > MOST_UNKNOWNS => Ok(best),
        best => general(program, stage, best),
    }
}

/// The number of unknowns above which the general solver, which then takes minutes, is not used to improve a point.
const MOST_UNKNOWNS: usize = 400;

/// The degrees of equalisation of the rows of the inequalities, from none to full. Most programs are solved unscaled;
/// one with rows of very different sizes may need scaling, which is not known in advance.
const EVENNESS: [f64; 3] = [0.0, 0.5, 1.0];

fn better(one: &Solution, other: &Solution, costs: &[f64]) -> bool {
    let cost = |s: &Solution| s.x.iter().zip(costs).map(|(x, c)| x * c).sum::<f64>();
    let candidate = |s: &Solution| Candidate { margin: s.margin, cost: cost(s) };
    is_better(candidate(one), candidate(other))
}

/// The margin and the objective of a point.
pub(crate) struct Candidate {
    pub(crate) margin: f64,
    pub(crate) cost: f64,
}

/// Returns `true` if a point is better than another: strictly feasible, then of lower cost; or else of larger margin.
pub(crate) fn is_better(one: Candidate, other: Candidate) -> bool {
    match (one.margin > 0.0, other.margin > 0.0) {
        (true, true) => one.cost < other.cost,
        (false, false) => one.margin > other.margin,
        (strict, _) => strict,
    }
}

/// Returns the best of a known point and those that the general solver finds.
fn general(
    program: &Program,
    stage: &'static str,
    known: Option<Solution>,
) -> Result<Solution, SynthesisError> {
    let conic = ConicProgram::new(program);
    let costs = program.costs();
    let mut best = known;
    let mut failure = None;
    for way in &WAYS {
        let (found, solved) = match conic.run(way, stage) {
            Ok(Verdict::Solved(x)) => (evaluated(program, x, f64::INFINITY), true),
            Ok(Verdict::Stopped(x)) => (evaluated(program, x, f64::INFINITY), false),
            // A point at which the inequalities hold refutes infeasibility.
            Ok(Verdict::Infeasible) if best.as_ref().is_none_or(|b| b.margin <= 0.0) => {
                return Err(SynthesisError::Infeasible { stage });
            }
            Ok(Verdict::Infeasible) => break,
            Err(other) => {
                failure = Some(other);
                continue;
            }
        };
        if best.as_ref().is_none_or(|known| better(&found, known, &costs)) {
            best = Some(found);
        }
        if solved {
            break;
        }
    }
    best.ok_or_else(|| failure.unwrap_or_else(|| SynthesisError::numerical(stage, "no solver was run")))
}

fn evaluated(program: &Program, x: Vec<f64>, gap: f64) -> Solution {
    let margin = margin(program, &x);
    Solution { x, margin, gap, lower: f64::NEG_INFINITY, multipliers: vec![] }
}

/// Returns the bound `c'y >= -tr(F_0 M) + r'y` for every y, with the residual `r = c - tr(F_i M)` of positive M.
fn lower(data: &[LowRank], costs: &[f64], multipliers: &[Mat], x: &[f64]) -> f64 {
    let mut residual = costs.to_vec();
    let mut bound = 0.0;
    let mut rounding = 0.0;
    for (data, m) in data.iter().zip(multipliers) {
        data.add_inner_products(m, -1.0, &mut residual);
        bound -= m.dot(data.constant());
        rounding += data.rounding(m, x);
    }
    let norm = |v: &[f64]| v.iter().map(|v| v * v).sum::<f64>().sqrt();
    bound - REACH * (norm(&residual) * norm(x) + rounding)
}

/// The distance of the optimum from zero, relative to that of the point found, up to which the bound holds: a larger
/// one indicates badly conditioned coordinates.
const REACH: f64 = 1e4;

/// Returns the least eigenvalue over all inequalities at `x`, each scaled to a unit diagonal; positive if all hold.
pub fn margin(program: &Program, x: &[f64]) -> f64 {
    let each = program.inequalities.iter().map(|i| scaled_least_eigenvalue(&i.expression.value(program, x)));
    each.fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lmi::program::{Affine, symmetric};
    use nalgebra::dmatrix;

    /// The norm of 1/(s^2 + 0.2 s + 1) by the bounded-real lemma agrees with its closed form.
    #[test]
    fn bounded_real_lemma_agrees_with_the_closed_form() {
        let (a, b, c) = (dmatrix![0.0, 1.0; -1.0, -0.2], dmatrix![0.0; 1.0], dmatrix![1.0, 0.0]);
        let mut program = Program::default();
        let x = program.symmetric(2);
        let gamma = program.scalar();
        let brl = symmetric(&[
            vec![x.after(&a.transpose()) + x.times(&a), x.times(&b), Affine::constant(c.transpose())],
            vec![-gamma.clone(), Affine::zeros(1, 1)],
            vec![-gamma.clone()],
        ]);
        program.positive("X", x);
        program.negative("bounded real", brl);
        program.minimise_trace(&gamma, 1.0);
        let solution = solve(&program, "test", SolverOptions::fine()).unwrap();
        let found = gamma.value(&program, &solution.x)[(0, 0)];
        assert!((found - 1.0 / (0.2 * 0.99f64.sqrt())).abs() < 1e-5 * found, "{found}");
    }

    #[test]
    fn infeasibility_is_not_reported_as_a_failure() {
        let mut program = Program::default();
        let x = program.symmetric(2);
        program.positive("X", x.clone());
        program.negative("X", x + Affine::constant(Mat::identity(2, 2)));
        assert_eq!(
            solve(&program, "test", SolverOptions::fine()).err(),
            Some(SynthesisError::Infeasible { stage: "test" })
        );
    }
}
