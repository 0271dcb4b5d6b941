//! The synthesis inequalities of a scheduled controller.
//!
//! P. Apkarian, P. Gahinet, "A convex characterization of gain-scheduled H-infinity controllers", IEEE Trans.
//! Automatic Control 40(5), 1995; with skew scalings G. Scorletti, L. El Ghaoui, "Improved LMI conditions for
//! gain scheduling and related control problems", Int. J. Robust Nonlinear Control 8, 1998. As printed in
//! A. Sutarto, A. Budiyono, Indian J. Geo-Marine Sci. 40(2), 2011, section 2B.

use crate::analysis::bounded_real::{Multipliers, bounded_real_compact};
use crate::lmi::{Affine, Program, Solution, symmetric};
use crate::matrix::{Mat, diagonal_blocks, kernel, scaled_least_eigenvalue, skew_part, symmetric_part};
use crate::system::Group::{T, W, X, Y};
use crate::system::{GeneralisedPlant, LoopError, channels};

/// The class of scalings of the parameter channels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ScalingClass {
    /// Symmetric S and Sigma only (T = Gamma = 0), coupled by [S I; I Sigma] >= 0.
    Symmetric,
    /// Symmetric and skew-symmetric scalings, as in the paper.
    #[default]
    SymmetricAndSkew,
}

/// A solution of the synthesis inequalities.
#[derive(Debug, Clone, PartialEq)]
pub struct LmiSolution {
    /// The performance level.
    pub gamma: f64,
    /// Lyapunov matrix of the primal inequality, n x n, symmetric.
    pub x: Mat,
    /// Lyapunov matrix of the dual inequality, n x n, symmetric.
    pub y: Mat,
    /// S + T, r x r: the multiplier of the primal inequality.
    pub primal_scaling: Mat,
    /// Sigma + Gamma, r x r: the multiplier of the dual inequality.
    pub dual_scaling: Mat,
    /// The least eigenvalue over all inequalities, each scaled to a unit diagonal; positive if they hold strictly.
    pub margin: f64,
    /// An estimate of the relative excess of gamma over the least; infinite if unknown or gamma was given.
    pub gap: f64,
    /// A lower bound of gamma by multipliers in floating point; 0 if unknown.
    pub lower: f64,
    /// Multipliers that may prove a lower bound of gamma, the most promising first; empty if gamma was given.
    pub multipliers: Vec<DualMultipliers>,
}

/// Multipliers of the synthesis inequalities in floating point; exact arithmetic determines the bound that they prove.
///
/// The multipliers of the primal and of the dual inequality are `P P'`, with the control eliminated: `[C2 D2t D21 0] P
/// = 0` to rounding.
#[derive(Debug, Clone, PartialEq)]
pub struct DualMultipliers {
    /// P of the primal inequality, rows x, wt, w, z.
    pub primal: Mat,
    /// P of the dual inequality, with the rows of the primal one of [`GeneralisedPlant::dual`].
    pub dual: Mat,
    /// E and F of the upper right block `-Z11 E F' Z22` of the multiplier of `[X I; I Y]`, whose other blocks follow
    /// from the first two.
    pub coupling: (Mat, Mat),
}

impl LmiSolution {
    /// Returns the least eigenvalue over the synthesis inequalities of `plant`.
    pub(crate) fn true_margin(&self, plant: &GeneralisedPlant, scalings: ScalingClass) -> f64 {
        let unknowns = Unknowns {
            gamma: Affine::number(self.gamma),
            x: Affine::constant(symmetric_part(&self.x)),
            y: Affine::constant(symmetric_part(&self.y)),
            s: Affine::constant(symmetric_part(&self.primal_scaling)),
            sigma: Affine::constant(symmetric_part(&self.dual_scaling)),
            t: Affine::constant(skew_part(&self.primal_scaling)),
            skew: Affine::constant(skew_part(&self.dual_scaling)),
        };
        let nothing = Program::default();
        let each = inequalities(plant, &unknowns, scalings).into_iter();
        each.map(|(_, e)| scaled_least_eigenvalue(&e.value(&nothing, &[]))).fold(f64::INFINITY, f64::min)
    }
}

/// The unknowns of the synthesis inequalities.
pub(crate) struct Unknowns {
    pub(crate) gamma: Affine,
    pub(crate) x: Affine,
    pub(crate) y: Affine,
    pub(crate) s: Affine,
    pub(crate) sigma: Affine,
    pub(crate) t: Affine,
    pub(crate) skew: Affine,
}

impl Unknowns {
    /// Returns their values at a solution.
    pub(crate) fn lmi_solution(&self, program: &Program, solution: &Solution) -> LmiSolution {
        LmiSolution { margin: solution.margin, ..self.at(program, &solution.x) }
    }

    /// Returns their values at a point `x` of the program; the margin is not evaluated.
    pub(crate) fn at(&self, program: &Program, x: &[f64]) -> LmiSolution {
        let value = |e: &Affine| e.value(program, x);
        LmiSolution {
            gamma: value(&self.gamma)[(0, 0)],
            x: value(&self.x),
            y: value(&self.y),
            primal_scaling: value(&self.s) + value(&self.t),
            dual_scaling: value(&self.sigma) + value(&self.skew),
            margin: f64::NAN,
            gap: f64::INFINITY,
            lower: 0.0,
            multipliers: vec![],
        }
    }
}

/// Adds the inequalities of a plant to a program; gamma is an unknown unless it is given.
pub(crate) fn add_inequalities(
    program: &mut Program,
    plant: &GeneralisedPlant,
    gamma: Option<f64>,
    scalings: ScalingClass,
) -> Unknowns {
    let (size, theta) = (plant.sizes(), channels(&plant.blocks));
    let skew = |program: &mut Program| match scalings {
        ScalingClass::Symmetric => Affine::zeros(size.t, size.t),
        ScalingClass::SymmetricAndSkew => program.skew_commuting(&theta),
    };
    let unknowns = Unknowns {
        gamma: gamma.map_or_else(|| program.scalar(), Affine::number),
        x: program.symmetric(size.x),
        y: program.symmetric(size.x),
        s: program.symmetric_commuting(&theta),
        sigma: program.symmetric_commuting(&theta),
        t: skew(program),
        skew: skew(program),
    };
    for (name, expression) in inequalities(plant, &unknowns, scalings) {
        program.positive(name, expression);
    }
    unknowns
}

/// Returns the inequalities, each required to be positive.
fn inequalities(
    plant: &GeneralisedPlant,
    unknowns: &Unknowns,
    scalings: ScalingClass,
) -> Vec<(&'static str, Affine)> {
    let Unknowns { gamma, x, y, s, sigma, t, skew } = unknowns;
    let mut out = vec![
        (PRIMAL, -projected(plant, gamma, x, s, t)),
        (DUAL, -projected(&plant.dual(), gamma, y, sigma, skew)),
        (COUPLING, coupling(x, y, 1.0)),
        ("S", s.clone()),
        ("Sigma", sigma.clone()),
    ];
    if scalings == ScalingClass::Symmetric {
        out.push(("[S I; I Sigma]", coupling(s, sigma, 1.0)));
    }
    out
}

/// Names of the inequalities.
pub(crate) const PRIMAL: &str = "primal";
pub(crate) const DUAL: &str = "dual";
pub(crate) const COUPLING: &str = "[X I; I Y]";

/// Returns `[P c I; c I Q]`.
pub(crate) fn coupling(p: &Affine, q: &Affine, c: f64) -> Affine {
    let n = p.shape().0;
    symmetric(&[vec![p.clone(), Affine::constant(Mat::identity(n, n) * c)], vec![q.clone()]])
}

/// Returns the scaled bounded-real inequality of an open plant with its control eliminated by projection on the kernel
/// of `[C2 D2t D21]` (Apkarian and Gahinet 1995, eq. 20, with the skew scaling T).
fn projected(p: &GeneralisedPlant, gamma: &Affine, x: &Affine, s: &Affine, t: &Affine) -> Affine {
    let open = p.open();
    let lambda = Affine::zeros(1, 1);
    let m = Multipliers { gamma: gamma.clone(), x: x.clone(), s: s.clone(), t: t.clone(), lambda };
    let full = bounded_real_compact(&open, &LoopError::none(&open), &m);
    full.congruence(&unmeasured(p))
}

/// Returns a basis of the directions of (x, wt, w, z) unobservable in y: the kernel of `[C2 D2t D21 0]`.
pub(crate) fn unmeasured(p: &GeneralisedPlant) -> Mat {
    let z = p.sizes().z;
    diagonal_blocks(&[&kernel(&p.parts.join(&[Y], &[X, T, W])), &Mat::identity(z, z)])
}
