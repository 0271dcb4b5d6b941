//! The slope of the trim as a rational function of rho.
//!
//! Level flight needs a lift that does not depend on speed, so that incidence and thrust go with inverse powers of the
//! speed: with one common denominator a fit has the poles that a polynomial lacks, for as many channels.

use crate::error::ModelError;
use crate::inputs::design_file::DesignFile;
use crate::linearise;
use auv::{Actuator, Linearisation, Trim, Vehicle};
use lpv::lft::Lft;
use lpv::matrix::{Mat, eigenvalues, largest, largest_singular_value};
use lpv::rational::MatrixRational;
use proof::same_plant::NEAREST_POLE;

/// The error, relative to the largest slope, that calls for a pole: below it the ball costs little, and poles near the
/// range would cost more, for the controller has them, too.
const CLOSE: f64 = 0.02;

/// By what factor a further pole must bring a fit nearer.
const NEARER: f64 = 0.5;

/// The LFT of the slope of the trim, `[x0'; u0']` per m/s of forward speed, (n + m) x 1.
///
/// The fits ([`MatrixRational::fit`]) have a numerator of the design's order, and no more poles than that, all of them
/// at least [`NEAREST_POLE`] from 0. Without poles it is a polynomial. While the largest error at the speeds of `trims`
/// is above a fiftieth of the largest slope, a further pole is taken where it halves that error. Inputs count in units
/// of their reach.
///
/// # Errors
/// [`ModelError::Fit`]; [`ModelError::Coefficient`].
pub fn trim_slope(
    vehicle: &Vehicle,
    design: &DesignFile,
    grid: &[(f64, Linearisation)],
    trims: &[Trim],
) -> Result<Lft, ModelError> {
    let actuators = &vehicle.actuators;
    let states = design.states.len();
    let of_states = std::iter::repeat_n(1.0, states);
    let units: Vec<f64> = of_states.chain(actuators.iter().map(Actuator::reach)).collect();
    let in_units = |l: &Linearisation| {
        let slope = linearise::trim_slope(l, actuators);
        Mat::from_fn(units.len(), 1, |i, _| slope[i] / units[i])
    };
    let samples: Vec<(f64, Mat)> = grid.iter().map(|(rho, l)| (*rho, in_units(l))).collect();
    let checked = trims.iter().map(|trim| {
        Ok((design.rho(trim.speed), in_units(&auv::linearise_with(vehicle, trim, design.has_depth())?)))
    });
    let checked = checked.collect::<Result<Vec<(f64, Mat)>, ModelError>>()?;
    let error = |lft: &Lft| {
        let missed = |(rho, m): &(f64, Mat)| Ok(largest_singular_value(&(lft.evaluate(&[*rho])? - m)));
        Ok::<f64, ModelError>(largest(
            0.0,
            checked.iter().map(missed).collect::<Result<Vec<f64>, ModelError>>()?,
        ))
    };
    let fit = |poles: usize| {
        let rational = MatrixRational::fit(&samples, design.order, poles)?;
        Ok::<Lft, ModelError>(Lft::from_rational(&rational, design.drop))
    };
    let mut best = fit(0)?;
    let mut least = error(&best)?;
    // Each pole needs a further speed.
    let size = largest(0.0, checked.iter().map(|(_, m)| m.norm()));
    for poles in 1..=design.order.min(samples.len() - 1 - design.order) {
        if least <= CLOSE * size {
            break;
        }
        let lft = fit(poles)?;
        let poles_inverse = largest(0.0, eigenvalues(&lft.inner).iter().map(|value| value.norm()));
        if poles_inverse.is_nan() || poles_inverse * NEAREST_POLE > 1.0 {
            continue;
        }
        let error = error(&lft)?;
        if error < NEARER * least {
            (best, least) = (lft, error);
        }
    }
    Ok(Lft::constant(Mat::from_diagonal(&units.into())).multiply(&best))
}
