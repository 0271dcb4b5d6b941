//! The gain of each axis from what turns add to it, back to that: a bound that proves the loop of both.
//!
//! With M_ii(rho, tau) the model of axis i and M = M_ii + D_ii on the diagonal, D_ij beside it, j the other axis,
//!
//! ```text
//! [xi'; yi] = M_ii [xi; Ti] + U_i d_i,     d_i = U_i^-1 (D_ii [xi; Ti] + D_ij [xj; Tj])
//! e_i = [(1 + b_j)^(1/2) F_i; (1 + 1/b_i)^(1/2) G_i] [xi; Ti]
//! |U_j^-1 D_ji v| <= |F_i v| and |U_i^-1 D_ii v| <= |G_i v| in every turn
//! ```
//!
//! By `|p + q|^2 <= (1 + 1/b) |p|^2 + (1 + b) |q|^2` there is `|d_i|^2 <= (1 + 1/b_i) |G_i [xi; Ti]|^2 + (1 + b_i) |F_j
//! [xj; Tj]|^2`, and so `|d_1|^2 + |d_2|^2 <= |e_1|^2 + |e_2|^2`. Where the gain g_i of each axis from d_i to e_i is
//! below 1, the loop of both is exponentially stable, for every trajectory of speed and of the rate of turn: with the
//! Lyapunov functions V_i of the two proofs `g_1 V_1 + g_2 V_2` decreases (small gain theorem: G. Zames, IEEE Trans.
//! Automatic Control 11(2), 1966). U_i, a diagonal matrix, and b_i > 0 are free; see `balance`. F_i and G_i are of the
//! turns at some speeds and rates; nothing is proved of those between.

use crate::certify::controller_of;
use crate::check::coupled::balance::{cover, units};
use crate::check::coupled::plant::{AxisPlant, in_parameters_of, part};
use crate::check::coupled::turn::Turning;
use crate::error::{Error, ModelError};
use crate::numbers::above;
use auv::TrimError;
use base::numbers::tidy;
use certificate::Certificate;
use lpv::analysis::given_loop;
use lpv::controller::Controller;
use lpv::matrix::{Mat, block, largest_complex_singular_value};
use lpv::plant::GeneralisedPlant;
use nalgebra::{Complex, DMatrix, DVector};
use proof::claim::{Proof, controller_rows, first_difference, nominal};
use proof::error::ProofError;
use proof::same_plant::check_in_box;
use rayon::prelude::*;
use scheduled::Autopilot;

/// The number of speeds of the turns whose D the bounds cover.
pub const SPEEDS: usize = 13;

/// Their number of rates to each side, beside straight flight.
pub const RATES: usize = 5;

/// Shares of the limit of the rate of turn for which a bound is sought, until there is one.
const SHARES: [f64; 6] = [1.5, 1.25, 1.0, 0.75, 0.5, 0.25];

/// The files of the certificates: of the axis of pitch or depth, and of that of heading.
pub const CERTIFICATES: [&str; 2] = ["coupling_certificate.json", "coupling_certificate_2.json"];

/// Proved gains of two axes.
#[derive(Debug, Clone)]
pub struct Coupling {
    /// The lowest and the highest common speed, m/s.
    pub speeds: [f64; 2],
    /// Rates of turn up to which they are proved, rad/s, there.
    pub rates: [f64; 2],
    /// Those rates by the limit of the reference.
    pub share: f64,
    /// Of pitch or depth, and of heading: each gain is below 1.
    pub axes: [Proof; 2],
}

impl Coupling {
    /// The gains.
    pub fn gains(&self) -> [f64; 2] {
        self.axes.each_ref().map(|axis| axis.theorem.gamma.unwrap_or(f64::INFINITY))
    }

    /// The product of the gains.
    pub fn product(&self) -> f64 {
        self.gains().iter().product()
    }

    /// What is proved; `names` are those of the axes.
    pub fn words(&self, names: [&str; 2]) -> String {
        format!(
            "in turns of up to {} {}",
            up_to(self.speeds, self.rates, self.share),
            together(names, self.gains())
        )
    }
}

/// Speeds \[m/s\], and rates of turn \[rad/s\] at them, in words.
pub fn up_to(speeds: [f64; 2], rates: [f64; 2], share: f64) -> String {
    let [low, high] = rates.map(|rate| tidy((100.0 * rate.to_degrees() + ROUNDING).floor() / 100.0, 2));
    let both = if low == high {
        format!("{low} deg/s")
    } else {
        format!("{low} deg/s at {} m/s to {high} at {}", speeds[0], speeds[1])
    };
    format!("{both} ({share} times the limit of the reference)")
}

/// Rounding of a rate, 0.01 deg/s.
const ROUNDING: f64 = 1e-6;

/// What two gains below 1 prove, in words that follow "in turns"; `names` are those of the axes.
pub fn together([one, other]: [&str; 2], gains: [f64; 2]) -> String {
    let [first, second] = gains.map(above);
    let turns = SPEEDS * (2 * RATES + 1);
    format!(
        "the linear loop of both axes, with roll, is stable for every trajectory of speed and rate of turn: the gain \
         of the coupling, computed in {turns} turns, is below {first} through {one} and below {second} through \
         {other}, both below 1"
    )
}

impl Turning<'_> {
    /// The limit of the rate of turn at a speed \[m/s\], rad/s: that of the reference, the smaller of both sides.
    ///
    /// # Errors
    /// [`Error`] of a design that cannot be flown.
    pub fn fastest(&self, speed: f64) -> Result<f64, Error> {
        let design = self.designs[1];
        let trim = Autopilot::new(design)?.trim().clone();
        let limits = design.envelope.get(auv::lateral::SIGNALS[auv::lateral::HEADING].name);
        let ends = limits.and_then(|limits| limits.rate.as_ref());
        let end =
            |end: usize| ends.map_or(0.0, |ends| trim.over(trim.forward_speed(speed), &ends[end]).abs());
        Ok(end(0).min(end(1)))
    }

    /// A share of that at the lowest and at the highest common speed.
    ///
    /// # Errors
    /// As [`Turning::fastest`].
    pub fn rates(&self, share: f64) -> Result<[f64; 2], Error> {
        let [low, high] = self.speeds();
        Ok([share * self.fastest(low)?, share * self.fastest(high)?])
    }

    fn rho(&self, axis: usize, speed: f64) -> f64 {
        (speed - self.designs[axis].scheduling.centre) / self.designs[axis].scheduling.half_range
    }
}

/// Bounds the gains of two axes for rates of turn up to a share of the limit of the reference, the largest of those
/// tried for which both are below 1, and proves them in exact arithmetic. `None` if there is none.
///
/// # Errors
/// [`Error`] of a controller that cannot be flown.
pub fn coupling(turning: &Turning<'_>) -> Result<Option<Coupling>, Error> {
    if turning.rates(1.0)? == [0.0; 2] {
        return Ok(None);
    }
    for share in SHARES {
        let Some(turns) = Turns::new(turning, share)? else { continue };
        let Some(axes) = turns.proved()? else { continue };
        return Ok(Some(Coupling { speeds: turning.speeds(), rates: turning.rates(share)?, share, axes }));
    }
    Ok(None)
}

/// The share of the limit of the reference for which certificates are of the loops of these designs, recomputed.
///
/// # Errors
/// [`ProofError::Mismatch`] if they are for none of those tried.
pub fn share_of(turning: &Turning<'_>, certificates: [&Certificate; 2]) -> Result<f64, Error> {
    let mut reason = ProofError::Mismatch { what: "the plant of the coupling".into() };
    for share in SHARES {
        let Some(turns) = Turns::new(turning, share)? else { continue };
        let same = turns.loops()?.into_iter().zip(certificates).try_for_each(|(made, certificate)| {
            check_in_box(&certificate.plant, &certificate.blocks, &made.plant)?;
            let wanted = controller_rows(&made.controller);
            match first_difference(&wanted.named(), &certificate.controller.named()) {
                Some(name) => Err(ProofError::Mismatch { what: format!("the controller's matrix {name}") }),
                None => Ok(()),
            }
        });
        match same {
            Ok(()) => return Ok(share),
            Err(found) => reason = found,
        }
    }
    Err(reason.into())
}

/// Turns, and the loop of each axis in them.
struct Turns {
    /// Each axis, in its own turns.
    plants: [AxisPlant; 2],
    controllers: [Controller; 2],
    /// `added[i][j]`: the D_ij.
    added: [[Vec<Mat>; 2]; 2],
}

impl Turns {
    /// `None` if there are no such turns.
    fn new(turning: &Turning<'_>, share: f64) -> Result<Option<Self>, Error> {
        let spread = |[low, high]: [f64; 2], count: usize| -> Vec<f64> {
            (0..count).map(|i| low + (high - low) * i as f64 / (count - 1) as f64).collect()
        };
        let mut turns = vec![];
        for speed in spread(turning.speeds(), SPEEDS) {
            let fastest = share * turning.fastest(speed)?;
            turns.extend(spread([-fastest, fastest], 2 * RATES + 1).iter().enumerate().map(|(i, rate)| {
                let tau = (i as f64 - RATES as f64).abs() / RATES as f64;
                (speed, tau, *rate)
            }));
        }
        type Sample = (f64, f64, Mat);
        let motion = |(speed, tau, rate): &(f64, f64, f64)| -> Result<Sample, TrimError> {
            let rate = if *tau == 0.0 { 0.0 } else { *rate };
            Ok((*speed, *tau, turning.motion(*speed, rate)?))
        };
        let found: Result<Vec<Sample>, TrimError> = turns.par_iter().map(motion).collect();
        let Ok(motions) = found else { return Ok(None) };
        let axes = turning.axes();
        let plant = |i: usize| -> Result<(AxisPlant, Vec<Mat>), Error> {
            let own = |(speed, tau, m): &Sample| (turning.rho(i, *speed), *tau, m.clone());
            let mut samples: Vec<Sample> = motions.iter().map(own).collect();
            // A design is proved at all of its speeds.
            let scheduling = &turning.designs[i].scheduling;
            let straight = spread([scheduling.minimum, scheduling.maximum], SPEEDS);
            let straight: Result<Vec<Sample>, TrimError> =
                straight.iter().map(|speed| motion(&(*speed, 0.0, 0.0))).collect();
            samples.extend(straight.map_err(ModelError::Trim)?.iter().map(own));
            let plant = AxisPlant::fit(axes[i].clone(), &samples)?;
            let left = samples.iter().map(|sample| plant.residual(sample)).collect::<Result<_, Error>>()?;
            Ok((plant, left))
        };
        let [(one, own), (other, others)] = [plant(0)?, plant(1)?];
        let between = |i: usize, j: usize| -> Vec<Mat> {
            motions.iter().map(|(_, _, m)| part(m, &axes[i].rows, &axes[j].columns)).collect()
        };
        let controller =
            |i: usize| -> Result<Controller, Error> { Ok(controller_of(&turning.designs[i].lft)?) };
        Ok(Some(Self {
            added: [[own, between(0, 1)], [between(1, 0), others]],
            plants: [one, other],
            controllers: [controller(0)?, controller(1)?],
        }))
    }

    /// The loop of each axis from d to e.
    fn loops(&self) -> Result<[Loop; 2], Error> {
        let responses = [self.responses(0)?, self.responses(1)?];
        let rows = [0, 1].map(|i| self.plants[i].axis.rows.len());
        let added = [0, 1].map(|i| [0, 1].map(|j| self.added[i][j].as_slice()));
        let units = units(added, [&responses[0], &responses[1]], rows);
        // D_ij in those units: a row to which nothing is added is 0.
        let scaled = |i: usize, j: usize| -> Vec<Mat> {
            let inverse = units[i].iter().map(|unit| if *unit > 0.0 { 1.0 / unit } else { 0.0 });
            let inverse = Mat::from_diagonal(&DVector::from_iterator(rows[i], inverse));
            self.added[i][j].iter().map(|m| &inverse * m).collect()
        };
        let parts = [0, 1].map(|i| {
            let columns = self.plants[i].axis.columns.len();
            let [f, g] = [1 - i, i].map(|j| cover(&scaled(j, i), columns));
            let used: Vec<usize> = (0..rows[i]).filter(|row| units[i][*row] > 0.0).collect();
            let u = Mat::from_diagonal(&DVector::from_vec(units[i].clone())).select_columns(&used);
            let [to_other, to_itself] = [&f, &g].map(|c| {
                let size = |one: &Response| largest_complex_singular_value(&(complex(c) * one * complex(&u)));
                responses[i].iter().map(size).fold(f64::MIN_POSITIVE, f64::max)
            });
            (u, [f, g], [to_other, to_itself])
        });
        // b of each axis: what it gives to itself by what the other gives to it.
        let b = [0, 1].map(|i| (parts[i].2[1] / parts[1 - i].2[0]).clamp(LEAST_B, 1.0 / LEAST_B));
        let of_axis = |i: usize| -> Result<Loop, Error> {
            let (u, [f, g], _) = &parts[i];
            let c = block(&[&[&(f * (1.0 + b[1 - i]).sqrt())], &[&(g * (1.0 + 1.0 / b[i]).sqrt())]]);
            let plant = self.plants[i].plant(u, &c)?;
            let controller = in_parameters_of(&plant, &self.controllers[i]);
            Ok(Loop { plant, controller })
        };
        Ok([of_axis(0)?, of_axis(1)?])
    }

    /// Certificates of gains below 1.
    fn proved(&self) -> Result<Option<[Proof; 2]>, Error> {
        let [one, other] = self.loops()?;
        let (one, other) = rayon::join(|| one.proved(), || other.proved());
        Ok(one?.zip(other?).map(|(one, other)| [one, other]))
    }

    /// The responses of the frozen loops of an axis from \[x'; y\] to \[x; T\].
    fn responses(&self, axis: usize) -> Result<Vec<Response>, Error> {
        let plant = &self.plants[axis];
        let [rows, columns] = [&plant.axis.rows, &plant.axis.columns].map(Vec::len);
        let plant = plant.plant(&Mat::identity(rows, rows), &Mat::identity(columns, columns))?;
        let closed = plant.close(&self.controllers[axis]);
        let mut all = vec![];
        for theta in [[-1.0, -1.0], [-1.0, 1.0], [0.0, -1.0], [0.0, 1.0], [1.0, -1.0], [1.0, 1.0]] {
            let frozen = closed.frozen(&theta)?;
            let frequencies = (0..FREQUENCIES)
                .map(|i| 10f64.powf(SLOWEST + (FASTEST - SLOWEST) * i as f64 / (FREQUENCIES - 1) as f64));
            all.extend(frequencies.filter_map(|omega| frozen.response(Complex::new(0.0, omega))));
        }
        Ok(all)
    }
}

/// The loop of an axis from d to e.
struct Loop {
    plant: GeneralisedPlant,
    controller: Controller,
}

impl Loop {
    /// A certificate of a gain below 1.
    fn proved(&self) -> Result<Option<Proof>, Error> {
        let Ok(bound) = given_loop(&self.plant.close(&self.controller)) else { return Ok(None) };
        if bound.gamma >= 1.0 {
            return Ok(None);
        }
        let certificate = nominal(&self.plant, &self.controller, &bound);
        let theorem = certificate.prove().map_err(ProofError::from)?;
        Ok(Some(Proof { certificate, theorem, model_error: None }))
    }
}

type Response = DMatrix<Complex<f64>>;

/// The frequencies of the responses by which units are chosen: their number, and the powers of ten of the ends, rad/s.
const FREQUENCIES: usize = 40;
const SLOWEST: f64 = -3.0;
const FASTEST: f64 = 2.0;

/// The least b; the largest is its inverse.
const LEAST_B: f64 = 0.01;

fn complex(m: &Mat) -> Response {
    m.map(|entry| Complex::new(entry, 0.0))
}
