//! Anti-windup: the gain that feeds the saturated part of the commands back into the controller's states.
//!
//! One gain for the entire range is computed from the loops at several frozen speeds by
//! [`squid_lpv::anti_windup`], with the lags and the delay of the design. It acts only beyond the limits. The proof in
//! the certificate, and the case in which another gain replaces it, are described in [`crate::certify::limits`].

use crate::axis::{Linearisation, VehicleModel};
use crate::check::sampled::Sampling;
use crate::error::Error;
use crate::inputs::design_file::DesignFile;
use nalgebra::DVector;
use squid_auv::Actuator;
use squid_lpv::anti_windup::{Aim, LimitedLoop, anti_windup as least_gain, smallest_gains};
use squid_lpv::controller::Controller;
use squid_lpv::error::SynthesisError;
use squid_lpv::matrix::{Mat, block, pseudo_inverse, solve};
use squid_signals::{LargestStep, Level};

/// The number of evenly spaced speeds: both ends of the range, where the limits differ most.
pub const SPEEDS: usize = 2;

/// Bound on the gain \[1/s\]: for a command that exceeds its limit by the limit itself, a state changes by at most its
/// own size in a tenth of a second, which is several ticks.
pub const FASTEST: f64 = 10.0;

/// The largest ratio of a step to one that the actuators can hold: references that cannot be held cause windup.
const BEYOND: f64 = 1.5;

/// The largest fraction used of the largest region of the inequalities: gamma grows without bound towards 1.
const REGION_FRACTION: f64 = 0.6;

/// Singular values below this part of the largest count as zero.
const RANK: f64 = 1e-12;

/// Allowed slowdown of the recovery relative to the quickest for a smaller gain, as a fraction of gamma.
const SLACKS: [f64; 2] = [0.02, 0.005];

/// Gains for a controller, n x m, in units of the actuators' reach, the smallest first: with the others the recovery is
/// slightly faster, and larger steps may be proved. The bound on the gain and the recovery are those before
/// [`keeping_speed`].
///
/// # Errors
/// The errors of trim and linearisation; [`Error::Synthesis`] if no gain was found.
pub fn anti_windup(
    vehicle: &dyn VehicleModel,
    design: &DesignFile,
    controller: &Controller,
) -> Result<Vec<Mat>, Error> {
    let loops = design.spread(SPEEDS).into_iter().map(|speed| {
        let l = vehicle.linearise(speed)?;
        let frozen = controller.frozen(&vec![design.rho(speed); controller.blocks.len()])?;
        let plant = Sampling::of(vehicle.actuators(), design).ideal(&l);
        let (n, nk) = (plant.a.nrows(), frozen.a.nrows());
        let closed = plant.injected(&frozen);
        let k = block(&[&[&(&frozen.d * &plant.measured), &frozen.c]]);
        let b = block(&[&[&plant.b], &[&Mat::zeros(nk, plant.b.ncols())]]);
        let c = block(&[&[&plant.c, &Mat::zeros(plant.c.nrows(), nk)]]);
        let limits = limits(vehicle.actuators(), &l);
        let shifts = solve(&closed.a, &-closed.b.columns(0, design.tracked.len()).into_owned())
            .ok_or_else(|| SynthesisError::numerical("anti-windup", "the loop has an integrator"))?;
        let held = &k * &shifts + &frozen.d * &plant.references;
        let mut region = Mat::zeros(n + nk, design.tracked.len());
        for (j, mut column) in region.column_iter_mut().enumerate() {
            let most = (0..limits.len()).map(|i| limits[i] / held[(i, j)].abs()).fold(f64::MAX, f64::min);
            let step = largest_step(design, j) / design.tracked[j].scale;
            column.copy_from(&(shifts.column(j) * step.min(BEYOND * most)));
        }
        Ok(LimitedLoop { a: closed.a, b, k, c, limits, region })
    });
    let mut loops = loops.collect::<Result<Vec<_>, Error>>()?;
    let states = controller.a().nrows();
    let fraction = REGION_FRACTION * least_gain(&loops, states, FASTEST, Aim::Region)?.region;
    loops.iter_mut().for_each(|each| each.region *= fraction.min(1.0));
    let found = smallest_gains(&loops, states, FASTEST, &SLACKS)?;
    found.into_iter().map(|found| keeping_speed(vehicle, design, controller, found.gain)).collect()
}

/// A gain E without what biases the speed while an actuator is at its limit for another reason than the speed.
///
/// While actuators stay at their limits with an excess phi, the state of a controller K(s) with slow integrals settles
/// where `0 = A x + B y + E phi`. An excess that moves the integral of the speed error is balanced there by an error of
/// the speed: the vehicle loses speed for as long as it is held. Let g = -C A^-1 B be the gain of K at zero frequency
/// from the errors of its tracked outputs, n the row of the pseudo-inverse of g that belongs to the speed, b the column
/// of B of the speed error, and p the forces along the hull of the actuators at their reach. E is replaced by
///
/// ```text
/// E - r (s - (s p) p'/(p'p))/(a r),   s = a E,   a = n C A^-1,   r = A^-1 b
/// ```
///
/// so that a E is a multiple of p': what is cut off of the force along the hull moves that integral, and nothing else.
/// A, B and C are those in the middle of the range; where A is singular, the gain stays as it is.
///
/// # Errors
/// Of a controller that is not well posed.
pub fn keeping_speed(
    vehicle: &dyn VehicleModel,
    design: &DesignFile,
    controller: &Controller,
    gain: Mat,
) -> Result<Mat, Error> {
    let Some(speed) = design.tracked.iter().position(|one| one.signal.level == Level::Scheduled) else {
        return Ok(gain);
    };
    let frozen = controller.frozen(&vec![0.0; controller.blocks.len()])?;
    let rows: Option<Vec<usize>> = (0..design.tracked.len()).map(|one| design.feedback_row(one)).collect();
    let Some(rows) = rows else { return Ok(gain) };
    let errors = frozen.b.select_columns(&rows);
    let Some(settled) = solve(&frozen.a, &errors) else { return Ok(gain) };
    let answer = pseudo_inverse(&(&frozen.c * &settled), RANK);
    let Some(states) = solve(&frozen.a.transpose(), &(answer.rows(speed, 1) * &frozen.c).transpose()) else {
        return Ok(gain);
    };
    let (a, r) = (states.column(0), settled.column(speed));
    let along = a.dot(&r);
    if along == 0.0 {
        return Ok(gain);
    }
    let actuators = vehicle.actuators().iter();
    let push =
        DVector::from_iterator(gain.ncols(), actuators.map(|one| one.force_per_output()[0] * one.reach()));
    let moved = gain.tr_mul(&a);
    let kept = &push * (moved.dot(&push) / push.norm_squared().max(f64::MIN_POSITIVE));
    Ok(&gain - r * (moved - kept).transpose() / along)
}

/// The largest step of a tracked output for which the gain is designed \[SI\], if the actuators hold most of it: in
/// pitch 30 deg, in speed the entire range, in depth up to the surface or at least the scale.
pub fn largest_step(design: &DesignFile, tracked: usize) -> f64 {
    let one = &design.tracked[tracked];
    match one.signal.largest_step {
        LargestStep::Of(size) => size,
        LargestStep::Depth => design.depth.max(one.scale),
        LargestStep::Range => design.speed_max - design.speed_min,
    }
}

/// The range of each command to either side of the trim, in units of its reach.
fn limits(actuators: &[Actuator], l: &Linearisation) -> Vec<f64> {
    let of = |(a, trim): (&Actuator, &f64)| (a.max - trim).min(trim - a.min) / a.reach();
    actuators.iter().zip(&l.trim.actuators).map(of).collect()
}
