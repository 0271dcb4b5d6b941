//! LPV synthesis: the matrix inequalities whose solution gives a scheduled controller.
//!
//! P. Apkarian, P. Gahinet, "A convex characterization of gain-scheduled H-infinity controllers", IEEE Trans.
//! Automatic Control 40(5), 1995; with skew scalings G. Scorletti, L. El Ghaoui, "Improved LMI conditions for
//! gain scheduling and related control problems", Int. J. Robust Nonlinear Control 8, 1998. As printed in
//! A. Sutarto, A. Budiyono, Indian J. Geo-Marine Sci. 40(2), 2011, section 2B.

use crate::analysis::{GainBound, bounded_gain};
use crate::balance::Coordinates;
use crate::bounded_real::{Multipliers, bounded_real_compact};
use crate::controller::Controller;
use crate::error::SynthesisError;
use crate::lmi::{Affine, Program, symmetric};
use crate::matrix::{Mat, block, diagonal_blocks, kernel, symmetric_part};
use crate::model_error::LoopError;
use crate::plant::{GeneralisedPlant, channels};
use crate::reconstruct::reconstruct;
use crate::solver::{self, Solution};

/// Which scalings of the parameter channels are sought.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Scalings {
    /// Symmetric S and Sigma alone (T = Gamma = 0), coupled by [S I; I Sigma] >= 0.
    Symmetric,
    /// Symmetric and skew-symmetric ones: the paper's.
    #[default]
    SymmetricAndSkew,
}

/// How a controller is sought.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// The scalings.
    pub scalings: Scalings,
    /// The controller is built at `(1 + back_off)` times the least gamma, where X Y keeps off I.
    pub back_off: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self { scalings: Scalings::SymmetricAndSkew, back_off: 0.1 }
    }
}

/// A solution of the synthesis inequalities.
#[derive(Debug, Clone, PartialEq)]
pub struct Existence {
    /// The performance level.
    pub gamma: f64,
    /// n x n, symmetric.
    pub x: Mat,
    /// n x n, symmetric.
    pub y: Mat,
    /// S + T, r x r: the multiplier of the primal inequality.
    pub primal_scaling: Mat,
    /// Sigma + Gamma, r x r: the multiplier of the dual inequality.
    pub dual_scaling: Mat,
    /// The least eigenvalue over all inequalities; positive if they hold strictly.
    pub margin: f64,
}

/// A controller with what is known of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Design {
    /// The controller, in the plant's coordinates.
    pub controller: Controller,
    /// The least gamma that the synthesis inequalities allow.
    pub gamma_optimum: f64,
    /// The gamma at which the controller was built.
    pub gamma_design: f64,
    /// The gain bound of the closed loop, with the matrices that show it.
    pub certified: GainBound,
}

/// Designs a controller and bounds the gain of the loop that it closes.
///
/// # Errors
/// Three outcomes are kept apart: a design; [`SynthesisError::Infeasible`], [`SynthesisError::NotStabilisable`],
/// [`SynthesisError::NotDetectable`] for a problem without solution; [`SynthesisError::Numerical`] when nothing
/// is known.
pub fn synthesise(plant: &GeneralisedPlant, options: Options) -> Result<Design, SynthesisError> {
    plant.check()?;
    crate::modes::check_stabilisable(plant)?;
    crate::modes::check_detectable(plant)?;
    let (coordinates, optimum) = least_gamma(plant, options.scalings)?;
    let gamma_design = optimum.gamma * (1.0 + options.back_off);
    let balanced = coordinates.apply(plant);
    let small = smallest(&balanced, gamma_design, options.scalings)?;
    let centred = centre(&balanced, gamma_design, &small, options.scalings)?;
    let (in_balance, shown) = reconstruct(&balanced, &centred)?;
    let controller = coordinates.undo(&in_balance);
    let closed = plant.close(&controller);
    let certified = bounded_gain(&closed, &LoopError::none(&closed), &coordinates.undo_bound(&shown))?;
    Ok(Design { controller, gamma_optimum: optimum.gamma, gamma_design, certified })
}

/// The least gamma, and coordinates in which the inequalities are well conditioned.
///
/// The problem is solved in diagonally balanced coordinates. A little above the gamma found the point of least
/// trace is sought: its X and Y are as small as they may be, and in the coordinates that make them equal and
/// diagonal the problem is solved again. The lowest gamma whose inequalities hold to rounding counts.
///
/// # Errors
/// As [`synthesise`].
pub fn least_gamma(
    plant: &GeneralisedPlant,
    scalings: Scalings,
) -> Result<(Coordinates, Existence), SynthesisError> {
    let mut coordinates = Coordinates::diagonal(plant);
    let mut best = minimise(&coordinates.apply(plant), scalings);
    let mut level = match &best {
        Ok(found) => found.gamma,
        Err(SynthesisError::Numerical { .. }) => f64::INFINITY,
        Err(_) => return best.map(|b| (coordinates, b)),
    };
    for _ in 0..4 {
        if !level.is_finite() {
            break;
        }
        let Ok(small) = smallest(&coordinates.apply(plant), level * RELAXED, scalings) else { break };
        let Some(next) = equalised(&coordinates, &small, plant) else { break };
        coordinates = next;
        let again = minimise(&coordinates.apply(plant), scalings);
        let Ok(found) = &again else { continue };
        let settled = (found.gamma - level).abs() < 1e-6 * level;
        level = found.gamma;
        best = again;
        if settled {
            break;
        }
    }
    best.map(|b| (coordinates, b))
}

/// How far above gamma the coordinates are sought.
const RELAXED: f64 = 1.1;

/// The point of least trace at a given gamma: the smallest X, Y, S and Sigma.
fn smallest(plant: &GeneralisedPlant, gamma: f64, scalings: Scalings) -> Result<Existence, SynthesisError> {
    let mut program = Program::new();
    let unknowns = state(&mut program, plant, Some(gamma), scalings);
    if scalings == Scalings::SymmetricAndSkew {
        // Without a coupling S and Sigma would shrink against each other.
        program.positive("[S I; I Sigma]", coupling(&unknowns.s, &unknowns.sigma, 1.0));
    }
    for e in [&unknowns.x, &unknowns.y, &unknowns.s, &unknowns.sigma] {
        program.minimise_trace(e, 1.0);
    }
    let solution = solver::solve(&program, SMALLEST).map_err(contradiction)?;
    Ok(unknowns.existence(&program, &solution))
}

fn equalised(at: &Coordinates, found: &Existence, plant: &GeneralisedPlant) -> Option<Coordinates> {
    let s = symmetric_part(&found.primal_scaling);
    let sigma = symmetric_part(&found.dual_scaling);
    at.equalising(&found.x, &found.y, &s, &sigma, &channels(&plant.blocks))
}

/// The unknowns of the synthesis inequalities.
struct Unknowns {
    gamma: Affine,
    x: Affine,
    y: Affine,
    s: Affine,
    sigma: Affine,
    t: Affine,
    skew: Affine,
}

impl Unknowns {
    fn existence(&self, program: &Program, solution: &Solution) -> Existence {
        let value = |e: &Affine| e.value(program, &solution.x);
        Existence {
            gamma: value(&self.gamma)[(0, 0)],
            x: value(&self.x),
            y: value(&self.y),
            primal_scaling: value(&self.s) + value(&self.t),
            dual_scaling: value(&self.sigma) + value(&self.skew),
            margin: solution.margin,
        }
    }
}

/// States the inequalities of a plant; gamma is an unknown unless it is given.
fn state(
    program: &mut Program,
    plant: &GeneralisedPlant,
    gamma: Option<f64>,
    scalings: Scalings,
) -> Unknowns {
    let (size, theta) = (plant.sizes(), channels(&plant.blocks));
    let skew = |program: &mut Program| match scalings {
        Scalings::Symmetric => Affine::zeros(size.t, size.t),
        Scalings::SymmetricAndSkew => program.skew_commuting(&theta),
    };
    let unknowns = Unknowns {
        gamma: gamma.map_or_else(|| program.scalar(), |g| Affine::constant(Mat::from_element(1, 1, g))),
        x: program.symmetric(size.x),
        y: program.symmetric(size.x),
        s: program.symmetric_commuting(&theta),
        sigma: program.symmetric_commuting(&theta),
        t: skew(program),
        skew: skew(program),
    };
    let Unknowns { gamma, x, y, s, sigma, t, skew } = &unknowns;
    program.negative("primal", projected(plant, gamma, x, s, t));
    program.negative("dual", projected(&plant.dual(), gamma, y, sigma, skew));
    program.positive("[X I; I Y]", coupling(x, y, 1.0));
    program.positive("S", s.clone());
    program.positive("Sigma", sigma.clone());
    if scalings == Scalings::Symmetric {
        program.positive("[S I; I Sigma]", coupling(s, sigma, 1.0));
    }
    unknowns
}

/// `[P c I; c I Q]`.
fn coupling(p: &Affine, q: &Affine, c: f64) -> Affine {
    let n = p.shape().0;
    symmetric(&[vec![p.clone(), Affine::constant(Mat::identity(n, n) * c)], vec![q.clone()]])
}

/// The scaled bounded-real inequality of an open plant with its control taken out by projection on the
/// kernel of `[C2 D2t D21]` (Apkarian and Gahinet 1995, eq. 20, with the skew scaling T).
fn projected(p: &GeneralisedPlant, gamma: &Affine, x: &Affine, s: &Affine, t: &Affine) -> Affine {
    let open = p.open();
    let lambda = Affine::zeros(1, 1);
    let m = Multipliers { gamma: gamma.clone(), x: x.clone(), s: s.clone(), t: t.clone(), lambda };
    let whole = bounded_real_compact(&open, &LoopError::none(&open), &m);
    let z = p.c1.nrows();
    let n = diagonal_blocks(&[&kernel(&block(&[&[&p.c2, &p.d2t, &p.d21]])), &Mat::identity(z, z)]);
    whole.congruence(&n)
}

/// The least gamma in the plant's own coordinates.
fn minimise(plant: &GeneralisedPlant, scalings: Scalings) -> Result<Existence, SynthesisError> {
    let stage = "least gamma";
    let mut program = Program::new();
    let unknowns = state(&mut program, plant, None, scalings);
    program.minimise_trace(&unknowns.gamma, 1.0);
    let solution = solver::solve(&program, stage)?;
    let found = unknowns.existence(&program, &solution);
    // At the optimum the inequalities are tight: they may be missed by rounding, not by more.
    let size = found.x.amax().max(found.y.amax()).max(found.gamma).max(1.0);
    if solution.margin < -1e-6 * size {
        return Err(SynthesisError::Numerical {
            stage,
            diagnosis: format!(
                "the point that the solver returned misses '{}' by {:.1e} (matrices up to {size:.1e})",
                solution.tightest, -solution.margin
            ),
        });
    }
    Ok(found)
}

/// A solution at a given gamma, above the least, that lies well inside the inequalities.
///
/// At the least gamma eigenvalues of X Y reach 1, X - Y^-1 is singular and the controller gets modes that no
/// frozen frequency response shows. So the room between X and Y^-1 is maximised first (t in
/// `[X tI; tI Y] >= 0`), under an upper bound on all unknowns. Half of that room is then kept, and the
/// inequalities made as clear as they can be.
fn centre(
    plant: &GeneralisedPlant,
    gamma: f64,
    small: &Existence,
    scalings: Scalings,
) -> Result<Existence, SynthesisError> {
    let room = push(plant, gamma, small, scalings, Aim::Room)?.1;
    let kept = 1.0 + 0.5 * (room - 1.0).max(0.0);
    let found = push(plant, gamma, small, scalings, Aim::Clearance { room: kept })?.0;
    if found.margin <= 0.0 {
        return Err(SynthesisError::Numerical {
            stage: BACK_OFF,
            diagnosis: format!(
                "the inequalities do not hold strictly at gamma = {gamma:.4} (margin {:.1e})",
                found.margin
            ),
        });
    }
    Ok(found)
}

const BACK_OFF: &str = "back-off";

/// What [`push`] maximises.
#[derive(Clone, Copy)]
enum Aim {
    /// t in `[X tI; tI Y] >= 0`.
    Room,
    /// c in `primal <= -c I`, `dual <= -c I`, `S >= c I`, `Sigma >= c I`, at a given t.
    Clearance { room: f64 },
}

/// Maximises `aim` under the synthesis inequalities at `gamma`; returns the point and the value of the aim.
fn push(
    plant: &GeneralisedPlant,
    gamma: f64,
    small: &Existence,
    scalings: Scalings,
    aim: Aim,
) -> Result<(Existence, f64), SynthesisError> {
    let (n, r) = (plant.sizes().x, plant.sizes().t);
    let mut program = Program::new();
    let unknowns = state(&mut program, plant, Some(gamma), scalings);
    for (e, least) in [
        (&unknowns.x, &small.x),
        (&unknowns.y, &small.y),
        (&unknowns.s, &small.primal_scaling),
        (&unknowns.sigma, &small.dual_scaling),
    ] {
        program.positive("upper bound", Affine::constant(symmetric_part(least) * GROWTH) - e.clone());
    }
    let value = program.scalar();
    let room = match aim {
        Aim::Room => value.times_identity(n),
        Aim::Clearance { room } => Affine::constant(Mat::identity(n, n) * room),
    };
    program.positive("[X tI; tI Y]", symmetric(&[vec![unknowns.x.clone(), room], vec![unknowns.y.clone()]]));
    if matches!(aim, Aim::Clearance { .. }) {
        for inequality in ["primal", "dual"] {
            program.tighten(inequality, &value);
        }
        program.positive("floor of S", unknowns.s.clone() - value.times_identity(r));
        program.positive("floor of Sigma", unknowns.sigma.clone() - value.times_identity(r));
    }
    program.minimise_trace(&value, -1.0);
    let solution = solver::solve(&program, BACK_OFF).map_err(contradiction)?;
    let reached = value.value(&program, &solution.x)[(0, 0)];
    // What counts are the inequalities themselves, not those tightened and bounded here.
    let mut original = Program::new();
    state(&mut original, plant, Some(gamma), scalings);
    let (margin, _) = solver::margin(&original, &solution.x[..original.unknowns()]);
    let found = Existence { margin, ..unknowns.existence(&program, &solution) };
    Ok((found, reached))
}

/// Above the least gamma there is a solution: a solver that denies it has failed.
fn contradiction(error: SynthesisError) -> SynthesisError {
    match error {
        SynthesisError::Infeasible { stage } => SynthesisError::Numerical {
            stage,
            diagnosis:
                "the solver finds no point above the least gamma, where one exists; the problem is badly \
                        conditioned: check units and weights"
                    .into(),
        },
        other => other,
    }
}

const SMALLEST: &str = "smallest matrices";

/// How many times their least size the unknowns may reach.
const GROWTH: f64 = 10.0;
