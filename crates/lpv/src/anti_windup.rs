//! Anti-windup: feedback of the saturated part of the commands into the states of the controller.
//!
//! With `phi = u - sat(u)`, the part of the command u beyond its limits, a loop with saturation is
//!
//! ```text
//! x' = A x - B phi + J E phi,   u = K x + u_o,   z = C x,   J = [0; I] into the controller's states
//! ```
//!
//! x is the deviation from the loop without limits, and u_o the command of that loop. For a gain E, a matrix
//! `Q = P^-1 > 0`, a diagonal U > 0 and any Y = H Q the inequalities
//!
//! ```text
//! [AQ + QA'  (JE - B) U + QK' - Y'   0          QC'     ]
//! [*         -2U                     I          0       ]
//! [*         *                      -gamma I    0       ] < 0        [Q  Y_j'     ]
//! [*         *                       *         -gamma I ]            [*  limit_j^2] > 0   for each command j
//! ```
//!
//! imply that for x' P x < 1 the sector condition `phi' U^-1 (u - phi - H x) >= 0` holds (J. M. Gomes da Silva Jr.,
//! S. Tarbouriech, "Antiwindup design with guaranteed regions of stability: an LMI-based approach", IEEE Trans.
//! Automatic Control 50(1), 2005, lemma 1), that `x' P x` decreases if u_o = 0, and that the gain from u_o to z is
//! below gamma as long as x stays there. With `L = E U` they are linear in (Q, U, Y, L), so E follows from one program.
//!
//! The least gamma gives the fastest return to the loop without limits: P. F. Weston, I. Postlethwaite, "Linear
//! conditioning for systems containing saturating actuators", Automatica 36(9), 2000; static gains: M. C. Turner, I.
//! Postlethwaite, "A new perspective on static and low order anti-windup synthesis", Int. J. Control 77(1), 2004. Many
//! gains have nearly that gamma; [`smallest_gains`] takes those with the least sum of all `|L_ij|`. Larger ones couple
//! axes: a rudder at its limit would move the integral of the speed error.

pub mod follow;
pub mod region;
mod saturated;

use crate::error::{SynthesisError, SystemError};
use crate::lmi::{Affine, Program, SolverOptions, solver, symmetric};
use crate::matrix::{Mat, diagonal, unit};
use crate::system::lyapunov;
use nalgebra::DVector;

const STAGE: &str = "anti-windup";

/// The relative tolerance of the optimum: only a gain is needed.
const ACCURACY: f64 = 1e-2;

/// The objective below which the tolerance is absolute: the region may be many times the required one, and the
/// objective is its inverse square.
const FLOOR: f64 = 1e-9;

/// A stable loop at one parameter value, without limits, with n states, the controller's last, and m commands.
#[derive(Debug, Clone, PartialEq)]
pub struct LimitedLoop {
    /// System matrix A, n x n.
    pub a: Mat,
    /// Input matrix B, n x m: the effect of the commands.
    pub b: Mat,
    /// Feedback K, m x n, from the states to the commands.
    pub k: Mat,
    /// Output matrix C, p x n, of the output that must recover fast.
    pub c: Mat,
    /// The limit of each command in both directions, m positive numbers; for unequal limits, the smaller one.
    pub limits: Vec<f64>,
    /// Region S, n x k: the region of the states must contain `S v` for every v with |v| <= 1.
    pub region: Mat,
}

/// The objective of the design.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Aim<'a> {
    /// The gain E with the least gamma.
    Recovery,
    /// The gain E with the largest region, a multiple of S.
    Region,
    /// The largest region, a multiple of S, for a gain E, n_k x m.
    RegionOf(&'a Mat),
}

/// An anti-windup gain, with the bound and the region that hold at each of the loops.
#[derive(Debug, Clone, PartialEq)]
pub struct AntiWindup {
    /// Gain E, n_k x m: E phi is added to the rates of the controller's n_k states.
    pub gain: Mat,
    /// A bound of the gain from u_o to z as long as the state stays in the region; infinite if not computed.
    pub gamma: f64,
    /// The multiple of S that the region contains.
    pub region: f64,
}

/// Computes one gain E for all `loops`, whose last `controller_states` states are those of the controller.
///
/// `largest_gain` bounds the entries of E \[1/s\], with the states in units of their sizes in the loop and phi in those
/// of the limits: otherwise E may be too large for a sampled controller, with almost no improvement of gamma.
///
/// Each loop has its own P. The result therefore holds for frozen parameters.
///
/// # Errors
/// Returns [`SynthesisError::System`] without a loop, or if its matrices do not fit; [`SynthesisError::Infeasible`],
/// also if a limit is not positive; [`SynthesisError::Numerical`].
pub fn anti_windup(
    loops: &[LimitedLoop],
    controller_states: usize,
    largest_gain: f64,
    aim: Aim<'_>,
) -> Result<AntiWindup, SynthesisError> {
    Sought { loops, controller_states, largest_gain, aim }.gain(None)
}

/// Computes [`anti_windup`] for [`Aim::Recovery`]: for each of `slacks` the smallest gain whose gamma is above the
/// least by at most that fraction.
///
/// # Errors
/// Errors of [`anti_windup`].
pub fn smallest_gains(
    loops: &[LimitedLoop],
    controller_states: usize,
    largest_gain: f64,
    slacks: &[f64],
) -> Result<Vec<AntiWindup>, SynthesisError> {
    let problem = Sought { loops, controller_states, largest_gain, aim: Aim::Recovery };
    let least = problem.gain(None)?.gamma;
    slacks.iter().map(|slack| problem.gain(Some((1.0 + slack) * least))).collect()
}

/// The arguments of [`anti_windup`].
#[derive(Clone, Copy)]
struct Sought<'a> {
    loops: &'a [LimitedLoop],
    controller_states: usize,
    largest_gain: f64,
    aim: Aim<'a>,
}

impl Sought<'_> {
    /// Returns the gain of the aim or, for a given gamma, the smallest one.
    fn gain(self, gamma: Option<f64>) -> Result<AntiWindup, SynthesisError> {
        let Self { loops, controller_states, largest_gain, aim } = self;
        check(loops, controller_states)?;
        let sizes = sizes(loops)?;
        let (n, m) = (sizes.len(), loops[0].limits.len());
        let mut program = Program::default();
        // Units are phi_j / limit_j for commands, and the sizes of the states.
        let u = program.symmetric_commuting(&(0..m).collect::<Vec<_>>());
        let controller_sizes = sizes.rows(n - controller_states, controller_states).into_owned();
        let largest = |j: usize| loops.iter().map(|each| each.limits[j]).fold(0.0, f64::max);
        let inward =
            |e: &Mat| Mat::from_fn(e.nrows(), m, |i, j| e[(i, j)] * largest(j) / controller_sizes[i]);
        let moved = match aim {
            Aim::RegionOf(gain) => u.after(&inward(gain)),
            Aim::Recovery | Aim::Region => {
                bounded_gain(&mut program, &u, controller_states, largest_gain, gamma.is_some())
            }
        };
        let level = gamma.map_or_else(
            || {
                let level = program.scalar();
                program.minimise_trace(&level, 1.0);
                level
            },
            Affine::number,
        );
        for each in loops {
            impose(&mut program, &scaled(each, &sizes, &largest), &u, &moved, aim, &level);
        }
        let options = SolverOptions {
            floor: FLOOR,
            enough: ACCURACY,
            settles: true,
            ..SolverOptions::within(ACCURACY)
        };
        let solution = solver::solve(&program, STAGE, options)?.feasible(STAGE)?;
        let value = |e: &Affine| e.value(&program, &solution.x);
        let (u, moved, level) = (value(&u), value(&moved), value(&level)[(0, 0)]);
        let gain = Mat::from_fn(controller_states, m, |i, j| {
            moved[(i, j)] / u[(j, j)] * controller_sizes[i] / largest(j)
        });
        let (gamma, region) = match aim {
            Aim::Recovery => (level, 1.0),
            Aim::Region | Aim::RegionOf(_) => (f64::INFINITY, level.powf(-0.5)),
        };
        Ok(AntiWindup { gain, gamma, region })
    }
}

/// Checks that the matrices fit together and the limits are positive.
fn check(loops: &[LimitedLoop], controller_states: usize) -> Result<(), SynthesisError> {
    let size = |l: &LimitedLoop| (l.a.nrows(), l.limits.len());
    let (n, m) = loops.first().map_or((0, 0), size);
    for LimitedLoop { a, b, k, c, limits, region } in loops {
        for (name, found, expected) in [
            ("A", a.shape(), (n, n)),
            ("B", b.shape(), (n, m)),
            ("K", k.shape(), (m, n)),
            ("C", c.shape(), (c.nrows(), n)),
            ("limits", (limits.len(), 1), (m, 1)),
            ("S", region.shape(), (n, region.ncols())),
        ] {
            if found != expected {
                return Err(SystemError::Shape { name, found, expected }.into());
            }
        }
        if !limits.iter().all(|limit| *limit > 0.0) {
            return Err(SynthesisError::Infeasible { stage: STAGE });
        }
    }
    if n < controller_states.max(1) {
        return Err(SystemError::Shape {
            name: "A",
            found: (n, n),
            expected: (controller_states, controller_states),
        }
        .into());
    }
    Ok(())
}

/// Returns `L = E U` with `|E_ij| < largest`; the objective is the sum of all `|L_ij|` for the smallest.
fn bounded_gain(program: &mut Program, u: &Affine, states: usize, largest: f64, smallest: bool) -> Affine {
    let m = u.shape().0;
    let l = program.full(states, m);
    for (i, j) in (0..states).flat_map(|i| (0..m).map(move |j| (i, j))) {
        let (row, column) = (unit(states, i).transpose(), unit(m, j));
        let entry = l.between(&row, &column);
        let mut size = u.congruence(&column).scaled(largest);
        if smallest {
            let most = size;
            size = program.scalar();
            program.minimise_trace(&size, 1.0);
            program.positive("gain", most - size.clone());
        }
        program.positive("gain", size.clone() - entry.clone());
        program.positive("gain", size + entry);
    }
    l
}

/// Adds the inequalities of one loop in its scaled coordinates.
fn impose(
    program: &mut Program,
    each: &LimitedLoop,
    u: &Affine,
    moved: &Affine,
    aim: Aim<'_>,
    level: &Affine,
) {
    let LimitedLoop { a, b, k, c, limits, region } = each;
    let (n, m) = b.shape();
    let states = moved.shape().0;
    let into = Mat::from_fn(n, states, |i, j| if i == n - states + j { 1.0 } else { 0.0 });
    let (q, y) = (program.symmetric(n), program.full(m, n));
    let flow = q.after(a);
    let phi = moved.after(&into) - u.after(b) + q.times(&k.transpose()) - y.t();
    let twice = -u.scaled(2.0);
    let (inequality, size) = match aim {
        Aim::Recovery => {
            let gamma = |size: usize| -level.times_identity(size);
            let p = c.nrows();
            let through = vec![
                vec![flow.clone() + flow.t(), phi, Affine::zeros(n, m), q.times(&c.transpose())],
                vec![twice, Affine::constant(Mat::identity(m, m)), Affine::zeros(m, p)],
                vec![gamma(m), Affine::zeros(m, p)],
                vec![gamma(p)],
            ];
            (symmetric(&through), Affine::constant(Mat::identity(1, 1)))
        }
        Aim::Region | Aim::RegionOf(_) => {
            (symmetric(&[vec![flow.clone() + flow.t(), phi], vec![twice]]), level.clone())
        }
    };
    program.negative("anti-windup", inequality);
    for (j, limit) in limits.iter().enumerate() {
        let row = y.after(&unit(m, j).transpose());
        let limit = Affine::number(limit * limit);
        program.positive("limit", symmetric(&[vec![q.clone(), row.t()], vec![limit]]));
    }
    let columns = Affine::constant(region.transpose());
    program.positive("region", symmetric(&[vec![size.times_identity(region.ncols()), columns], vec![q]]));
}

/// Returns the loop in states `x_i / size_i` and commands `u_j / largest_j`.
fn scaled(each: &LimitedLoop, sizes: &DVector<f64>, largest: &impl Fn(usize) -> f64) -> LimitedLoop {
    let LimitedLoop { a, b, k, c, limits, region } = each;
    let from = |m: &Mat| Mat::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)] / sizes[i]);
    let to = |m: &Mat| Mat::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)] * sizes[j]);
    let k = to(k);
    LimitedLoop {
        a: from(&to(a)),
        b: Mat::from_fn(b.nrows(), b.ncols(), |i, j| b[(i, j)] * largest(j) / sizes[i]),
        k: Mat::from_fn(k.nrows(), k.ncols(), |i, j| k[(i, j)] / largest(i)),
        c: to(c),
        limits: limits.iter().enumerate().map(|(j, limit)| limit / largest(j)).collect(),
        region: from(region),
    }
}

/// Returns the size of each state under white noise of unit size in the directions of the region and on the commands,
/// in units of their limits.
fn sizes(loops: &[LimitedLoop]) -> Result<DVector<f64>, SynthesisError> {
    let n = loops.first().map_or(0, |l| l.a.nrows());
    let mut variances = DVector::zeros(n);
    for LimitedLoop { a, b, limits, region, .. } in loops {
        let pushed = b * diagonal(limits.iter().copied());
        let noise = &pushed * pushed.transpose() + region * region.transpose();
        let gramian = lyapunov(&a.transpose(), &noise)
            .ok_or_else(|| SynthesisError::numerical(STAGE, "the loop without limits is unstable"))?;
        variances = variances.zip_map(&gramian.diagonal(), f64::max);
    }
    let floor = 1e-12 * variances.max().max(f64::MIN_POSITIVE);
    Ok(variances.map(|v| v.max(floor).sqrt()))
}
