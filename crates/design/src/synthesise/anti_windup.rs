//! Anti-windup: the gain by which the commands that the limits cut off are fed back into the controller's states.
//!
//! One gain for the whole range, from the loops at some frozen speeds by [`lpv::anti_windup`], with the lags and the
//! delay of the design. It acts beyond the limits alone: what the certificate says of it, and where another gain takes
//! its place, is in [`crate::certify::limits`].

use crate::check::sampled::Sampling;
use crate::error::Error;
use crate::inputs::design_file::DesignFile;
use crate::linearise::linearise_at;
use auv::{Linearisation, Vehicle};
use lpv::anti_windup::{Aim, AntiWindup, LimitedLoop, anti_windup as least_gain};
use lpv::controller::Controller;
use lpv::error::SynthesisError;
use lpv::matrix::{Mat, block, solve};
use signals::{DEPTH, PITCH};

/// The number of speeds, evenly spread over the range: both ends, where the limits differ most.
pub const SPEEDS: usize = 2;

/// The largest pitch step \[rad\] (30 deg) that the gain is made for.
const PITCH_STEP: f64 = std::f64::consts::PI / 6.0;

/// Bound on the gain \[1/s\]: by a command that is cut off by its whole limit a state moves its own size in a tenth
/// of a second, several ticks, at most.
pub const FASTEST: f64 = 10.0;

/// Steps are at most this much larger than those that the actuators can hold: a reference that cannot be held is what
/// winds a controller up.
const BEYOND: f64 = 1.5;

/// The part of the largest region of the inequalities that is asked for at most: gamma grows without bound towards it.
const SHARE: f64 = 0.6;

/// The gain for a controller, n x m, in units of the actuators' reach.
///
/// # Errors
/// Those of trim and linearisation; [`Error::Synthesis`] where no gain was found.
pub fn anti_windup(
    vehicle: &Vehicle,
    design: &DesignFile,
    controller: &Controller,
) -> Result<AntiWindup, Error> {
    let loops = design.spread(SPEEDS).into_iter().map(|speed| {
        let l = linearise_at(vehicle, design, speed)?;
        let frozen = controller.frozen(&vec![design.rho(speed); controller.blocks.len()])?;
        let wired = Sampling::of(&vehicle.actuators, design).ideal(&l);
        let (n, nk) = (wired.a.nrows(), frozen.a.nrows());
        let closed = wired.injected(&frozen);
        let k = block(&[&[&(&frozen.d * &wired.measured), &frozen.c]]);
        let b = block(&[&[&wired.b], &[&Mat::zeros(nk, wired.b.ncols())]]);
        let c = block(&[&[&wired.c, &Mat::zeros(wired.c.nrows(), nk)]]);
        let limits = limits(vehicle, &l);
        let shifts = solve(&closed.a, &-closed.b.columns(0, design.tracked.len()).into_owned())
            .ok_or_else(|| SynthesisError::numerical("anti-windup", "the loop has an integrator"))?;
        let held = &k * &shifts + &frozen.d * &wired.references;
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
    let share = SHARE * least_gain(&loops, states, FASTEST, Aim::Region)?.region;
    loops.iter_mut().for_each(|each| each.region *= share.min(1.0));
    Ok(least_gain(&loops, states, FASTEST, Aim::Recovery)?)
}

/// The largest step of a tracked output that the gain is made for \[SI\], where the actuators hold most of it: in pitch
/// 30 deg, in speed the whole range, in depth up to the surface, and the scale at least.
pub fn largest_step(design: &DesignFile, tracked: usize) -> f64 {
    let one = &design.tracked[tracked];
    match one.place {
        PITCH => PITCH_STEP,
        DEPTH => design.depth.max(one.scale),
        _ => design.speed_max - design.speed_min,
    }
}

/// How far each command can go either way from the trim, in units of its reach.
fn limits(vehicle: &Vehicle, l: &Linearisation) -> Vec<f64> {
    let of = |(a, trim): (&auv::Actuator, &f64)| (a.max - trim).min(trim - a.min) / a.reach();
    vehicle.actuators.iter().zip(&l.trim.actuators).map(of).collect()
}
