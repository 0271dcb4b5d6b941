//! Slope of the trim as a rational function of rho.
//!
//! Level flight needs a lift that is independent of speed, so incidence and thrust vary with inverse powers of the
//! speed. A rational fit with one common denominator has the poles that a polynomial lacks, with the same number of
//! channels.

use crate::axis::{Linearisation, VehicleModel};
use crate::error::ModelError;
use crate::inputs::design_file::DesignFile;
use crate::linearise::TRIM_ROWS;
use squid_auv::Actuator;
use squid_lpv::lft::Lft;
use squid_lpv::matrix::{Mat, eigenvalues, largest, largest_singular_value};
use squid_lpv::rational::MatrixRational;
use squid_proof::same_plant::NEAREST_POLE;

/// Error, relative to the largest slope, above which a pole is added. A smaller error enlarges the ball little, while
/// poles near the range, which the controller has as well, would cost more.
const ACCEPTED_ERROR: f64 = 0.02;

/// Factor by which a further pole must reduce the error.
const REDUCTION: f64 = 0.5;

/// Returns the slopes of the trims of a design at [`TRIM_ROWS`] speeds, each with its rho.
///
/// # Errors
/// The errors of the trims.
pub fn trim_slopes(vehicle: &dyn VehicleModel, design: &DesignFile) -> Result<Vec<(f64, Mat)>, ModelError> {
    let speeds = design.spread(TRIM_ROWS);
    Ok(speeds.iter().map(|v| design.rho(*v)).zip(vehicle.trim_slopes(&speeds)?).collect())
}

/// Returns the LFT of the slope of the trim, `[x0'; u0']` per m/s of forward speed, (n + m) x 1.
///
/// The fits ([`MatrixRational::fit`]) have a numerator of the design's order and at most as many poles, all at least
/// [`NEAREST_POLE`] from 0; without poles the fit is a polynomial. A further pole is added while the largest error at
/// the speeds of `slopes` is above a fiftieth of the largest slope, provided that the pole halves the error. Inputs are
/// in units of their reach.
///
/// # Errors
/// [`ModelError::System`]; [`ModelError::Coefficient`].
pub fn trim_slope(
    actuators: &[Actuator],
    design: &DesignFile,
    grid: &[(f64, Linearisation)],
    slopes: &[(f64, Mat)],
) -> Result<Lft, ModelError> {
    let of_states = std::iter::repeat_n(1.0, design.states.len());
    let units: Vec<f64> = of_states.chain(actuators.iter().map(Actuator::reach)).collect();
    let in_units = |slope: &Mat| Mat::from_fn(units.len(), 1, |i, _| slope[i] / units[i]);
    let samples: Vec<(f64, Mat)> = grid.iter().map(|(rho, l)| (*rho, in_units(&l.trim_slope))).collect();
    let true_slopes: Vec<(f64, Mat)> = slopes.iter().map(|(rho, slope)| (*rho, in_units(slope))).collect();
    let error = |lft: &Lft| {
        let error_at = |(rho, m): &(f64, Mat)| Ok(largest_singular_value(&(lft.evaluate(&[*rho])? - m)));
        Ok::<f64, ModelError>(largest(
            0.0,
            true_slopes.iter().map(error_at).collect::<Result<Vec<f64>, ModelError>>()?,
        ))
    };
    let fit = |poles: usize| {
        let rational = MatrixRational::fit(&samples, design.order, poles)?;
        Ok::<Lft, ModelError>(Lft::from_rational(&rational, design.drop))
    };
    let mut best = fit(0)?;
    let mut least = error(&best)?;
    // Each pole needs one more speed.
    let size = largest(0.0, true_slopes.iter().map(|(_, m)| m.norm()));
    for poles in 1..=design.order.min(samples.len() - 1 - design.order) {
        if least <= ACCEPTED_ERROR * size {
            break;
        }
        let lft = fit(poles)?;
        let poles_inverse = largest(0.0, eigenvalues(&lft.inner).iter().map(|value| value.norm()));
        if poles_inverse.is_nan() || poles_inverse * NEAREST_POLE > 1.0 {
            continue;
        }
        let error = error(&lft)?;
        if error < REDUCTION * least {
            (best, least) = (lft, error);
        }
    }
    Ok(Lft::constant(Mat::from_diagonal(&units.into())).multiply(&best))
}
