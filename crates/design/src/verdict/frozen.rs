//! Frozen, sampled loop at one speed.

use crate::augment::{LinearModel, augment};
use crate::axis::VehicleModel;
use crate::check::flown::Flown;
use crate::check::frozen_controller;
use crate::check::margins::Margins;
use crate::check::sampled::Sampling;
use crate::error::Error;
use crate::inputs::Inputs;
use serde::{Serialize, Serializer};
use squid_lpv::analysis::{Exogenous, SampledGain};
use squid_lpv::controller::Controller;
use squid_lpv::matrix::eigenvalues;
use squid_lpv::state_space::HinfNorm;

/// Figures of the loop at a speed. A file has the least margins of [`Flown`], as null if they are infinite or the loop
/// is unstable.
#[derive(Debug, Clone, PartialEq)]
pub struct AtSpeed {
    /// Speed along the path, m/s.
    pub speed: f64,
    /// All figures of the sampled loop; `None` if it is unstable.
    pub flown: Option<Flown>,
    /// Gain from w to z with the true linearisation, in continuous time.
    pub gain: HinfNorm,
    /// Bounds on the gain from w to z of the sampled loop, including between the ticks, for w that is held between
    /// ticks; `None` if not requested.
    pub sampled_gain: Option<SampledGain>,
    /// The same bounds for arbitrarily fast disturbances, which are aliased by sampling.
    pub aliased_gain: Option<SampledGain>,
    /// Fastest mode of the controller, rad/s.
    pub fastest_mode: f64,
}

impl AtSpeed {
    pub(super) fn of(inputs: &Inputs, k: &Controller, speed: f64, sampled: bool) -> Result<Self, Error> {
        let (actuators, design) = (&inputs.vehicle.actuators, &inputs.design);
        let l = inputs.axis().linearise(speed)?;
        let frozen = frozen_controller(k, design.rho(speed))?;
        let plant = augment(actuators, design, LinearModel::at(&l, design))?;
        let sampling = Sampling::of(actuators, design);
        let system = frozen.frozen(&[])?;
        let continuous = plant.close(&frozen).frozen(&[])?.hinf_norm();
        let gain =
            |w: Exogenous, guess: f64| sampled.then(|| sampling.gain(&l, &system, w, guess)).transpose();
        let held = gain(Exogenous::Held, continuous.value)?;
        let any = gain(Exogenous::Any, held.map_or(f64::NAN, |held| held.upper))?;
        Ok(Self {
            speed,
            flown: Flown::of(&sampling, &l, &system),
            sampled_gain: held,
            aliased_gain: any,
            gain: continuous,
            fastest_mode: eigenvalues(&frozen.a()).iter().map(|p| p.norm()).fold(0.0, f64::max),
        })
    }

    /// Returns the least margin over all points at which the loop can be opened; NaN if the loop is unstable.
    pub fn least(&self, of: impl Fn(&Margins) -> f64) -> f64 {
        self.flown.as_ref().map_or(f64::NAN, |f| f.margins().map(of).fold(f64::INFINITY, f64::min))
    }

    /// Returns the least delay \[s\] at one point or in all commands at once that makes the loop unstable.
    pub fn delay(&self) -> f64 {
        let common = self.flown.as_ref().map_or(f64::NAN, |f| f.common_delay);
        self.least(|m| m.delay).min(common)
    }
}

/// Returns the gain margin in decibels, the lesser of increase and decrease.
pub fn gain_margin(m: &Margins) -> f64 {
    20.0 * m.gain_up.min(1.0 / m.gain_down).log10()
}

impl Serialize for AtSpeed {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        struct Shown {
            speed: f64,
            gain: f64,
            /// Lower and upper bound; null if the loop is unstable.
            sampled_gain: Option<[f64; 2]>,
            aliased_gain: Option<[f64; 2]>,
            gain_margin_db: f64,
            phase_margin_deg: f64,
            disk_margin_deg: f64,
            delay_margin: f64,
        }
        let both = |gain: Option<SampledGain>| gain.map(|gain| [gain.lower, gain.upper]);
        let shown = Shown {
            speed: self.speed,
            gain: self.gain.value,
            sampled_gain: both(self.sampled_gain),
            aliased_gain: both(self.aliased_gain),
            gain_margin_db: self.least(gain_margin),
            phase_margin_deg: self.least(|m| m.phase.to_degrees()),
            disk_margin_deg: self.least(|m| m.disk_phase().to_degrees()),
            delay_margin: self.delay(),
        };
        shown.serialize(serializer)
    }
}
