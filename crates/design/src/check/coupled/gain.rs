//! Gain of each axis through the coupling terms of turns: a bound that proves the loop of both axes stable.
//!
//! M_ii(rho, tau) is the model of axis i, M = M_ii + D_ii on the diagonal, and D_ij couples the other axis j:
//!
//! ```text
//! [xi'; yi] = M_ii [xi; Ti] + U_i d_i,     d_i = U_i^-1 (D_ii [xi; Ti] + D_ij [xj; Tj])
//! e_i = [(1 + b_j)^(1/2) F_i; (1 + 1/b_i)^(1/2) G_i] [xi; Ti]
//! |U_j^-1 D_ji v| <= |F_i v| and |U_i^-1 D_ii v| <= |G_i v| in the turns computed
//! ```
//!
//! With the gain g_i of axis i from d_i to e_i and the Lyapunov function V_i of its proof,
//!
//! ```text
//! d/dt (g_1 V_1 + g_2 V_2) < g_1^2 |d_1|^2 + g_2^2 |d_2|^2 - |e_1|^2 - |e_2|^2
//! ```
//!
//! so that the loop of both is exponentially stable for every trajectory of speed and rate of turn along which `g_1^2
//! |d_1|^2 + g_2^2 |d_2|^2 <= |e_1|^2 + |e_2|^2` for every state (small gain theorem: G. Zames, IEEE Trans. Automatic
//! Control 11(2), 1966). The square root of the largest ratio of the two sides is the coupling of a turn relative to
//! the allowed one.
//!
//! By `|p + q|^2 <= (1 + 1/b) |p|^2 + (1 + b) |q|^2` there is `|d_i|^2 <= (1 + 1/b_i) |G_i [xi; Ti]|^2 + (1 + b_i) |F_j
//! [xj; Tj]|^2`, and so `|d_1|^2 + |d_2|^2 <= |e_1|^2 + |e_2|^2` in the turns from which F_i and G_i are computed:
//! their relative coupling is at most the larger of the two gains. Turns between them are computed as well; nothing is
//! proved about others. U_i, a diagonal matrix, and b_i > 0 are free; see `balance`.

use crate::certify::controller_of;
use crate::check::coupled::balance::{Response, complex, cover, units};
use crate::check::coupled::plant::{AxisPlant, Sample, in_parameters_of, part};
use crate::check::coupled::turn::Turning;
use crate::error::Error;
use nalgebra::{Complex, DVector};
use rayon::prelude::*;
use squid_auv::TrimError;
use squid_base::numbers::above;
use squid_base::numbers::tidy;
use squid_certificate::Certificate;
use squid_lpv::analysis::bounded_gain::with_raised_gamma;
use squid_lpv::analysis::{GainBound, given_loop};
use squid_lpv::controller::Controller;
use squid_lpv::matrix::{
    Mat, block, largest_complex_singular_value, largest_singular_value, symmetric_function,
};
use squid_lpv::model_error::LoopError;
use squid_lpv::plant::GeneralisedPlant;
use squid_proof::claim::{Proof, nominal};
use squid_proof::error::ProofError;
use squid_proof::same_plant::check_in_box;
use squid_scheduled::Scheduling;

/// Number of speeds of the turns whose D the bounds cover, closer to one another at the ends of the range.
pub const SPEEDS: usize = 13;

/// Number of rates of turn to each side, in addition to straight flight.
pub const RATES: usize = 5;

/// Fractions of the limit of the rate of turn, tried in this order until one has a bound.
const SHARES: [f64; 6] = [1.5, 1.25, 1.0, 0.75, 0.5, 0.25];

/// Files of the certificates: of the axis of pitch or depth, and of the axis of heading.
pub const CERTIFICATES: [&str; 2] = ["coupling_certificate.json", "coupling_certificate_2.json"];

/// Proved gains of two axes.
#[derive(Debug, Clone)]
pub struct Coupling {
    /// Least and largest rate of turn up to which they are proved, over the speeds, rad/s.
    pub rates: [f64; 2],
    /// Fraction of the limit of the reference that these rates are.
    pub share: f64,
    /// Largest coupling of the computed turns relative to the one that the gains allow: below 1.
    pub taken: f64,
    /// Proofs of the axis of pitch or depth, and of the axis of heading: each gain is below 1.
    pub axes: [Proof; 2],
}

impl Coupling {
    /// Returns the gain of each axis.
    pub fn gains(&self) -> [f64; 2] {
        self.axes.each_ref().map(|axis| axis.theorem.gamma.unwrap_or(f64::INFINITY))
    }

    /// Describes the proved claim; `names` are those of the axes.
    pub fn claim(&self, names: [&str; 2]) -> String {
        claim(self.rates, (self.share, self.taken), names, self.gains())
    }
}

/// Describes the claim proved by two gains below 1, for rates of turn \[rad/s\], their fraction of the limit and the
/// coupling relative to the allowed one; `names` are those of the axes.
pub fn claim(rates: [f64; 2], (share, taken): (f64, f64), names: [&str; 2], gains: [f64; 2]) -> String {
    let [least, most] = rates.map(|rate| tidy((100.0 * rate.to_degrees() + ROUNDING).floor() / 100.0, 2));
    let rates = if least == most {
        format!("{least} deg/s")
    } else {
        format!("{least} to {most} deg/s, depending on speed")
    };
    let turns = SPEEDS * (2 * RATES + 1) + (SPEEDS - 1) * (2 * RATES + 2);
    format!(
        "in turns of up to {rates} ({share} times the limit of the reference) the linear loop of both axes, \
         including roll, is stable for every trajectory of speed and turn rate, provided that no turn couples the \
         axes more than the certificates allow; the {turns} computed turns reach at most {} times this limit: {}",
        above(taken),
        of_both(names, gains)
    )
}

/// Tolerance of the rounding of a rate, 0.01 deg/s.
const ROUNDING: f64 = 1e-6;

/// Text of the gains.
fn of_both([one, other]: [&str; 2], gains: [f64; 2]) -> String {
    let [first, second] = gains.map(above);
    format!("coupling gains below {first} through {one} and below {second} through {other}, both below 1")
}

impl Turning<'_> {
    /// Returns the least and the largest rate of turn at a fraction `share` of its limit over the common speeds, rad/s.
    pub fn rates(&self, share: f64) -> [f64; 2] {
        let all = spread(self.speeds(), SPEEDS).into_iter().map(|speed| share * self.fastest(speed));
        all.fold([f64::INFINITY, 0.0], |[least, most], rate| [least.min(rate), most.max(rate)])
    }
}

/// Numbers evenly spread over a range.
fn spread([low, high]: [f64; 2], count: usize) -> Vec<f64> {
    (0..count).map(|i| low + (high - low) * i as f64 / (count - 1) as f64).collect()
}

/// Numbers over a range, closer to one another at its ends (Chebyshev's points).
fn finer_at_the_ends([low, high]: [f64; 2], count: usize) -> Vec<f64> {
    let half = 0.5 * (high - low);
    let angle = |i: usize| std::f64::consts::PI * i as f64 / (count - 1) as f64;
    (0..count).map(|i| if i + 1 == count { high } else { low + half * (1.0 - angle(i).cos()) }).collect()
}

/// Bounds the gains of two axes for rates of turn up to a fraction of the limit of the reference, the largest of those
/// tried for which both gains are below 1, and proves them in exact arithmetic. Returns `None` if there is none, if
/// heading does not turn, or if commands are delayed, because the loop of the proof has no delay.
///
/// # Errors
/// [`Error`] of a controller whose matrices do not match.
pub fn coupling(turning: &Turning<'_>) -> Result<Option<Coupling>, Error> {
    let is_delayed = turning.designs.iter().any(|design| design.delay_ticks > 0);
    if is_delayed || turning.rates(1.0)[0] <= 0.0 {
        return Ok(None);
    }
    for share in SHARES {
        let Some(turns) = Turns::new(turning, share)? else { continue };
        let loops = turns.loops()?;
        let (one, other) = rayon::join(|| loops[0].proved(), || loops[1].proved());
        let Some((one, other)) = one.zip(other) else { continue };
        let axes = [one, other];
        let taken = turns.relative_coupling(
            &loops,
            axes.each_ref().map(|axis| axis.theorem.gamma.unwrap_or(f64::INFINITY)),
        );
        if taken < 1.0 {
            return Ok(Some(Coupling { rates: turning.rates(share), share, taken, axes }));
        }
    }
    Ok(None)
}

/// Returns the fraction of the limit of the reference for which the plants of certificates are those of these designs,
/// recomputed, at values spread over the parameters; and the coupling of the turns relative to the allowed one.
///
/// # Errors
/// [`ProofError::WrongPlant`] if they are for none of the fractions tried; [`ProofError::Mismatch`] if a turn couples
/// more than is allowed.
pub fn share_of(
    turning: &Turning<'_>,
    certificates: [&Certificate; 2],
    gains: [f64; 2],
) -> Result<(f64, f64), Error> {
    let mut reason = ProofError::Mismatch { what: "the plant of the coupling".into() };
    for share in SHARES {
        let Some(turns) = Turns::new(turning, share)? else { continue };
        let loops = turns.loops()?;
        let same = loops.iter().zip(certificates).try_for_each(|(recomputed, certificate)| {
            check_in_box(&certificate.plant, &certificate.blocks, &recomputed.plant)
        });
        match same {
            Ok(()) => {
                let taken = turns.relative_coupling(&loops, gains);
                let wrong =
                    || ProofError::Mismatch { what: "a turn whose coupling exceeds the allowed one".into() };
                return (taken < 1.0).then_some((share, taken)).ok_or_else(|| wrong().into());
            }
            Err(found) => reason = found,
        }
    }
    Err(reason.into())
}

/// Turns, and the loop of each axis in them.
struct Turns {
    /// Plant of each axis, fitted to its turns.
    plants: [AxisPlant; 2],
    controllers: [Controller; 2],
    /// Matrices D_ij at `[i][j]`, first of the turns that the bounds cover, then of those between.
    added: [[Vec<Mat>; 2]; 2],
    /// Number of turns that the bounds cover.
    covered: usize,
}

impl Turns {
    /// Returns `None` if a turn does not exist.
    fn new(turning: &Turning<'_>, share: f64) -> Result<Option<Self>, Error> {
        let speeds = finer_at_the_ends(turning.speeds(), SPEEDS);
        let parts = spread([-1.0, 1.0], 2 * RATES + 1);
        let mean = |pair: &[f64]| 0.5 * (pair[0] + pair[1]);
        let other_speeds: Vec<f64> = speeds.windows(2).map(mean).collect();
        let other_parts: Vec<f64> = parts.windows(2).map(mean).chain([-1.0, 1.0]).collect();
        let grid = |speeds: &[f64], parts: &[f64]| -> Vec<(f64, f64, f64)> {
            let at = |speed: f64| {
                let fastest = share * turning.fastest(speed);
                parts.iter().map(move |part| (speed, part.abs(), part * fastest))
            };
            speeds.iter().copied().flat_map(at).collect()
        };
        let mut turns = grid(&speeds, &parts);
        let covered = turns.len();
        turns.extend(grid(&other_speeds, &other_parts));
        // Matrix M, tau and forward speed of each turn.
        let motion = |(speed, tau, rate): &(f64, f64, f64)| {
            turning.motion(*speed, *rate).map(|(m, forward_speed)| (m, *tau, forward_speed))
        };
        let found: Result<Vec<_>, TrimError> = turns.par_iter().map(motion).collect();
        let Ok(motions) = found else { return Ok(None) };
        let axes = turning.axes();
        let mut parts = vec![];
        for (i, axis) in axes.iter().enumerate() {
            let sample = |(m, tau, forward_speed): &(Mat, f64, f64)| Sample {
                rho: turning.rho(i, *forward_speed),
                tau: *tau,
                m: m.clone(),
            };
            let samples: Vec<Sample> = motions.iter().map(sample).collect();
            // The scheduling range of a design may be wider than the common range of speed.
            let Scheduling { minimum, maximum, .. } = turning.designs[i].scheduling;
            let straight = spread([minimum, maximum], SPEEDS).into_iter();
            let straight: Result<Vec<_>, TrimError> =
                straight.map(|speed| motion(&(speed, 0.0, 0.0))).collect();
            let Ok(straight) = straight else { return Ok(None) };
            let all: Vec<Sample> =
                samples[..covered].iter().cloned().chain(straight.iter().map(sample)).collect();
            let plant = AxisPlant::fit(axis.clone(), &all)?;
            let left = samples.iter().map(|one| plant.residual(one)).collect::<Result<Vec<Mat>, Error>>()?;
            parts.push((plant, left, controller_of(&turning.designs[i].lft)?));
        }
        let between = |i: usize, j: usize| -> Vec<Mat> {
            motions.iter().map(|(m, ..)| part(m, &axes[i].rows, &axes[j].columns)).collect()
        };
        let [Some((other, others, second)), Some((one, own, first))] = [parts.pop(), parts.pop()] else {
            return Ok(None);
        };
        Ok(Some(Self {
            added: [[own, between(0, 1)], [between(1, 0), others]],
            plants: [one, other],
            controllers: [first, second],
            covered,
        }))
    }

    /// Returns the loop of each axis from d to e.
    fn loops(&self) -> Result<[Loop; 2], Error> {
        let responses = [self.responses(0)?, self.responses(1)?];
        let rows = [0, 1].map(|i| self.plants[i].axis.rows.len());
        let added = [0, 1].map(|i| [0, 1].map(|j| &self.added[i][j][..self.covered]));
        let units = units(added, [&responses[0], &responses[1]], rows);
        // D_ij in those units.
        let scaled = |i: usize, j: usize| -> Vec<Mat> {
            let inverse = units[i].iter().map(|unit| 1.0 / unit);
            let inverse = Mat::from_diagonal(&DVector::from_iterator(rows[i], inverse));
            added[i][j].iter().map(|m| &inverse * m).collect()
        };
        let parts = [0, 1].map(|i| {
            let columns = self.plants[i].axis.columns.len();
            let [f, g] = [1 - i, i].map(|j| cover(&scaled(j, i), columns));
            let u = Mat::from_diagonal(&DVector::from_vec(units[i].clone()));
            let [to_other, to_itself] = [&f, &g].map(|c| {
                let size = |one: &Response| largest_complex_singular_value(&(complex(c) * one * complex(&u)));
                responses[i].iter().map(size).fold(f64::MIN_POSITIVE, f64::max)
            });
            (u, [f, g], [to_other, to_itself])
        });
        // b of each axis: the gain to itself relative to the gain from the other axis.
        let b = [0, 1].map(|i| (parts[i].2[1] / parts[1 - i].2[0]).clamp(LEAST_B, 1.0 / LEAST_B));
        let of_axis = |i: usize| -> Result<Loop, Error> {
            let (u, [f, g], _) = &parts[i];
            let c = block(&[&[&(f * (1.0 + b[1 - i]).sqrt())], &[&(g * (1.0 + 1.0 / b[i]).sqrt())]]);
            let plant = self.plants[i].plant(u, &c)?;
            let controller = in_parameters_of(&plant, &self.controllers[i]);
            Ok(Loop { plant, controller, units: units[i].clone(), c })
        };
        Ok([of_axis(0)?, of_axis(1)?])
    }

    /// Largest coupling of a turn relative to the one that the gains of two loops allow.
    fn relative_coupling(&self, loops: &[Loop; 2], gains: [f64; 2]) -> f64 {
        // [x; T] of both axes per e.
        let per_e = loops.each_ref().map(|axis| {
            symmetric_function(&(axis.c.transpose() * &axis.c), |value| {
                value.max(f64::MIN_POSITIVE).powf(-0.5)
            })
        });
        let of = |k: usize| {
            let d = |i: usize, j: usize| {
                let scaled = loops[i].units.iter().map(|unit| gains[i] / unit);
                let scaled = DVector::from_iterator(loops[i].units.len(), scaled);
                Mat::from_diagonal(&scaled) * &self.added[i][j][k] * &per_e[j]
            };
            largest_singular_value(&block(&[&[&d(0, 0), &d(0, 1)], &[&d(1, 0), &d(1, 1)]]))
        };
        (0..self.added[0][0].len()).map(of).fold(0.0, f64::max)
    }

    /// Responses of the frozen loops of an axis from \[x'; y\] to \[x; T\].
    fn responses(&self, axis: usize) -> Result<Vec<Response>, Error> {
        let plant = &self.plants[axis];
        let [rows, columns] = [&plant.axis.rows, &plant.axis.columns].map(Vec::len);
        let plant = plant.plant(&Mat::identity(rows, rows), &Mat::identity(columns, columns))?;
        let closed = plant.close(&self.controllers[axis]);
        let mut all = vec![];
        for theta in [[-1.0, -1.0], [-1.0, 1.0], [0.0, -1.0], [0.0, 1.0], [1.0, -1.0], [1.0, 1.0]] {
            let Ok(frozen) = closed.frozen(&theta) else { continue };
            let frequencies = (0..FREQUENCIES)
                .map(|i| 10f64.powf(SLOWEST + (FASTEST - SLOWEST) * i as f64 / (FREQUENCIES - 1) as f64));
            all.extend(frequencies.filter_map(|omega| frozen.response(Complex::new(0.0, omega))));
        }
        Ok(all)
    }
}

/// Loop of an axis from d to e.
struct Loop {
    plant: GeneralisedPlant,
    controller: Controller,
    /// Diagonal of U.
    units: Vec<f64>,
    /// Output matrix of e from \[x; T\].
    c: Mat,
}

impl Loop {
    /// Certificate of a gain below 1.
    fn proved(&self) -> Option<Proof> {
        let closed = self.plant.close(&self.controller);
        let bound = given_loop(&closed).ok()?;
        let proof = |bound: &GainBound| {
            let certificate = nominal(&self.plant, &self.controller, bound);
            let theorem = certificate.prove().ok().filter(|_| bound.gamma < 1.0)?;
            Some(Proof { certificate, theorem, model_error: None })
        };
        // Rounding may refute a tight bound.
        let raised = || with_raised_gamma(&closed, &LoopError::none(&closed), &bound);
        proof(&bound).or_else(|| proof(&raised()?))
    }
}

/// Frequencies of the responses by which units are chosen: their number, and the powers of ten of the ends, rad/s.
const FREQUENCIES: usize = 40;
const SLOWEST: f64 = -3.0;
const FASTEST: f64 = 2.0;

/// Least b; the largest is its inverse.
const LEAST_B: f64 = 0.01;
