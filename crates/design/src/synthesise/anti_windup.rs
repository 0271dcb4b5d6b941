//! Anti-windup: the gain that feeds the saturated part of the commands back into the controller's states.
//!
//! One gain for the entire range is computed from the loops at some frozen speeds by [`lpv::anti_windup`], with the
//! lags and the delay of the design. It acts only beyond the limits. For what the certificate proves, and when another
//! gain replaces it, see [`crate::certify::limits`].

use crate::axis::{Linearisation, VehicleModel};
use crate::check::sampled::Sampling;
use crate::error::Error;
use crate::inputs::design_file::DesignFile;
use auv::Actuator;
use lpv::anti_windup::{Aim, LimitedLoop, anti_windup as least_gain, smallest_gains};
use lpv::controller::Controller;
use lpv::error::SynthesisError;
use lpv::matrix::{Mat, block, solve};
use signals::LargestStep;

/// The number of evenly spaced speeds: both ends of the range, where the limits differ most.
pub const SPEEDS: usize = 2;

/// Bound on the gain \[1/s\]: for a command that exceeds its limit by the limit itself, a state changes by at most its
/// own size in a tenth of a second, which is several ticks.
pub const FASTEST: f64 = 10.0;

/// The largest ratio of a step to one that the actuators can hold: references that cannot be held cause windup.
const BEYOND: f64 = 1.5;

/// The largest fraction used of the largest region of the inequalities: gamma grows without bound towards 1.
const REGION_FRACTION: f64 = 0.6;

/// How much slower than the quickest the recovery may be for a smaller gain, as a fraction of gamma.
const SLACKS: [f64; 2] = [0.02, 0.005];

/// Gains for a controller, n x m, in units of the actuators' reach, the smallest first: with the others the recovery is
/// slightly faster, and larger steps may be proved.
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
    Ok(found.into_iter().map(|found| found.gain).collect())
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
