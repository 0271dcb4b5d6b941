//! Waves as parameters of the plant.

use std::f64::consts::PI;
use std::sync::Arc;

use squid_auv::{Surroundings, Vehicle};
use squid_fmi2::{SavedState, StateError};
use squid_sea::{SeaError, Spectrum, Waves};

use crate::PlantError;

/// Names of the wave parameters.
pub const WAVES: [&str; 5] = ["wave_height", "wave_period", "wave_gamma", "wave_heading", "wave_seed"];

/// A sea with the JONSWAP spectrum; calm if the height is 0.
#[derive(Debug, Clone, PartialEq)]
pub struct WaveParameters {
    /// Significant wave height \[m\].
    pub height: f64,
    /// Peak period \[s\].
    pub period: f64,
    /// Peak enhancement factor gamma: ratio of the peak to that of a fully developed sea.
    pub gamma: f64,
    /// Direction of propagation, clockwise from north; in the vertical plane relative to the direction of travel
    /// \[rad\].
    pub heading: f64,
    /// Seed of the random frequencies and phases.
    pub seed: i32,
}

impl Default for WaveParameters {
    /// Returns a calm sea; once a height is set, head waves with a peak period of 8 s and the mean gamma of JONSWAP.
    fn default() -> Self {
        Self { height: 0.0, period: 8.0, gamma: 3.3, heading: PI, seed: 1 }
    }
}

impl WaveParameters {
    /// Returns the water about a vehicle; `None` without waves.
    ///
    /// # Errors
    /// [`PlantError::Waves`].
    pub(crate) fn about(&self, vehicle: &Vehicle) -> Result<Option<Arc<Surroundings>>, PlantError> {
        let Some(geometry) = vehicle.geometry.filter(|_| self.height != 0.0) else { return Ok(None) };
        let of_seed = |_| {
            let (found, allowed) = (f64::from(self.seed), "at least 0");
            SeaError::NotAllowed { key: "seed", found, allowed }
        };
        let seed = u64::try_from(self.seed).map_err(of_seed)?;
        let spectrum = Spectrum::jonswap(self.height, self.period, self.gamma)?;
        let waves = Waves::new(&spectrum, self.heading, Waves::USUAL, seed)?;
        let coefficients = &vehicle.coefficients;
        Ok(Some(Arc::new(Surroundings::still(coefficients).with_waves(waves, geometry, coefficients)?)))
    }

    pub(crate) fn pass(&mut self, state: &mut dyn SavedState) -> Result<(), StateError> {
        let mut seed = f64::from(self.seed);
        let Self { height, period, gamma, heading, .. } = self;
        state.each(&mut [height, period, gamma, heading, &mut seed])?;
        self.seed = seed as i32;
        Ok(())
    }
}
