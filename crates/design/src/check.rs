//! Checks of a finished controller before it is written.
//!
//! The design's inequalities hold for the fit. These checks also close the controller, frozen at each speed, with the
//! true linearisations, at the speeds of the grid and between them.

pub mod coupled;
pub mod flown;
pub mod margins;
pub mod sampled;
pub mod sampled_gain;

use crate::augment::{LinearModel, augment};
use crate::axis::{Linearisation, VehicleModel};
use crate::check::sampled::{Sampling, sampled_dtt};
use crate::error::Error;
use crate::error::Refusal;
use crate::findings::fast_mode;
use crate::inputs::design_file::{DesignFile, SAMPLE_TIME};
use squid_finding::Finding;
use squid_lpv::controller::Controller;
use squid_lpv::matrix::{Mat, eigenvalues, spectral_abscissa};
use squid_lpv::plant::{GeneralisedPlant, channels};
use squid_lpv::state_space::StateSpace;
use std::f64::consts::TAU;

/// Number of speeds at which the closed loop is checked.
pub const CHECKED_SPEEDS: usize = 101;

/// Oversampling factor: a loop that is still unstable at this multiple of its rate counts as unstable without sampling.
const OVERSAMPLING: f64 = 50.0;

/// Results of the checks.
#[derive(Debug, Clone, PartialEq)]
pub struct Checks {
    /// Largest real part of the closed-loop modes with the fitted model.
    pub abscissa_fit: f64,
    /// Largest real part with the true linearisations.
    pub abscissa_truth: f64,
    /// Largest frozen gain with the fitted model.
    pub gain_fit: f64,
    /// Largest frozen gain with the true linearisations.
    pub gain_truth: f64,
    /// Largest modulus of the modes of the sampled loop, with true linearisations and actuator lags.
    pub sampled_radius: f64,
    /// Fastest mode of the frozen controller, rad/s.
    pub fastest_controller_mode: f64,
}

/// Fraction of the sampling rate 2 pi/T above which a controller mode is distorted by sampling. The trapezoidal rule
/// maps a frequency w to 2/T atan(w T/2): 11 % lower at a fifth of the rate, 36 % at half of it.
const SLOW_ENOUGH: f64 = 0.2;

/// Returns the fastest controller mode for which a sample time (s) is short enough, rad/s.
pub fn fastest_sampled(sample_time: f64) -> f64 {
    SLOW_ENOUGH * TAU / sample_time
}

impl Checks {
    /// Returns a finding if the fastest controller mode is too fast for the sample time (s); the advice quotes
    /// `control_weight`.
    pub fn finding(&self, sample_time: f64, control_weight: f64) -> Option<Finding> {
        let (fastest, most) = (self.fastest_controller_mode, fastest_sampled(sample_time));
        let short_enough = Some(SLOW_ENOUGH * TAU / fastest).filter(|time| SAMPLE_TIME.allows(*time));
        (fastest > most).then(|| fast_mode(fastest, most, sample_time, control_weight, short_enough))
    }
}

/// Checks a controller for the scheduled plant `plant` at frozen speeds. The loop must be stable with the fit, with the
/// true linearisation, and sampled with the actuator lags; the H-infinity norm must be at most `bound` with the fit,
/// and finite with the true linearisation.
/// # Errors
/// [`Error::Refused`] with the first failure; the errors of trim and linearisation.
pub fn check(
    vehicle: &dyn VehicleModel,
    design: &DesignFile,
    plant: &GeneralisedPlant,
    controller: &Controller,
    bound: f64,
) -> Result<Checks, Error> {
    well_posed(&controller.dtt())?;
    well_posed(&plant.dtt())?;
    let sampling = Sampling::of(vehicle.actuators(), design);
    well_posed(
        &sampled_dtt(controller, sampling.sample_time).unwrap_or_else(|| Mat::from_element(1, 1, f64::NAN)),
    )?;
    let closed = plant.close(controller);
    let mut checks = Checks {
        abscissa_fit: f64::NEG_INFINITY,
        abscissa_truth: f64::NEG_INFINITY,
        gain_fit: 0.0,
        gain_truth: 0.0,
        sampled_radius: 0.0,
        fastest_controller_mode: 0.0,
    };
    for speed in design.spread(CHECKED_SPEEDS) {
        let rho = design.rho(speed);
        let fitted = closed.frozen(&[rho])?;
        let real_part = spectral_abscissa(&fitted.a);
        if real_part.is_nan() || real_part >= 0.0 {
            return Err(Refusal::UnstableFit { speed, real_part }.into());
        }
        let gain = fitted.hinf_norm().value;
        if gain.is_nan() || gain > bound {
            return Err(Refusal::Gain { speed, gain, bound }.into());
        }
        let frozen = frozen_controller(controller, rho)?;
        let linearisation = vehicle.linearise(speed)?;
        let truth = augment(vehicle.actuators(), design, LinearModel::at(&linearisation, design))?;
        let true_loop = truth.close(&frozen).frozen(&[])?;
        let true_real_part = spectral_abscissa(&true_loop.a);
        if true_real_part.is_nan() || true_real_part >= 0.0 {
            return Err(Refusal::UnstableTruth { speed, real_part: true_real_part }.into());
        }
        // Instability of the continuous loop is not attributed to the lags or the sample time.
        let radius = sampled_radius(sampling, &linearisation, &controller.frozen(&[rho])?, speed)?;
        checks.abscissa_fit = checks.abscissa_fit.max(real_part);
        checks.abscissa_truth = checks.abscissa_truth.max(true_real_part);
        checks.gain_fit = checks.gain_fit.max(gain);
        let true_gain = true_loop.hinf_norm().value;
        if !true_gain.is_finite() {
            return Err(Refusal::TrueGain { speed, gain: true_gain }.into());
        }
        checks.gain_truth = checks.gain_truth.max(true_gain);
        checks.sampled_radius = checks.sampled_radius.max(radius);
        let fastest = eigenvalues(&frozen.a()).iter().map(|p| p.norm()).fold(0.0, f64::max);
        checks.fastest_controller_mode = checks.fastest_controller_mode.max(fastest);
    }
    Ok(checks)
}

/// Returns the spectral radius of the sampled loop; an error if it is unstable.
fn sampled_radius(
    sampling: Sampling,
    linearisation: &Linearisation,
    frozen: &StateSpace,
    speed: f64,
) -> Result<f64, Refusal> {
    let radius = sampling.spectral_radius(linearisation, frozen);
    if radius < 1.0 {
        return Ok(radius);
    }
    let sample_time = sampling.sample_time;
    let oversampled = Sampling { sample_time: sample_time / OVERSAMPLING, ..sampling };
    let growth = oversampled.spectral_radius(linearisation, frozen).ln();
    Err(if growth >= 0.0 {
        Refusal::UnstableWithLags { speed, real_part: growth / oversampled.sample_time }
    } else {
        Refusal::UnstableSampled { speed, sample_time, radius }
    })
}

/// Freezes the scheduled controller at rho, without parameters.
///
/// # Errors
/// [`ModelError::System`](crate::error::ModelError::System) if it is not well posed.
pub fn frozen_controller(k: &Controller, rho: f64) -> Result<Controller, Error> {
    let parts = k.parts.frozen(&channels(&k.blocks), &[rho])?;
    Ok(Controller { parts, blocks: vec![] })
}

/// Checks that `I - rho D` is regular for all |rho| <= 1: D has no real eigenvalue of modulus 1 or more.
fn well_posed(d: &Mat) -> Result<(), Refusal> {
    for value in eigenvalues(d) {
        let real = value.im.abs() <= 1e-12 * value.norm();
        if value.re.is_nan() || (real && value.re.abs() >= 1.0) {
            return Err(Refusal::NotWellPosed { rho: 1.0 / value.re });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn warns_of_modes_beyond_fifth_of_sampling_rate() {
        let checks = |fastest| Checks {
            abscissa_fit: -1.0,
            abscissa_truth: -1.0,
            gain_fit: 1.0,
            gain_truth: 1.0,
            sampled_radius: 0.9,
            fastest_controller_mode: fastest,
        };
        // 2 pi/0.02/5 = 62.83 rad/s.
        assert_eq!(checks(62.8).finding(0.02, 0.04), None);
        // 2 pi/5/112 = 0.01122 s.
        let [advised, too_fast] = [112.0, 1e6].map(|mode| checks(mode).finding(0.02, 0.04).unwrap());
        assert_eq!((advised.value, advised.limit), (Some(112.0), Some(fastest_sampled(0.02))));
        insta::assert_snapshot!(format!("{advised}\n\n{too_fast}"));
        assert_eq!(checks(112.0).finding(0.011, 0.04), None);
    }
}
