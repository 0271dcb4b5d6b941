//! Sea for which a controller is designed: the table `[sea]`.

use crate::axis::Linearisation;
use squid_auv::RegularWaves;
use squid_flight::sea::WaveParameters;
use squid_lpv::matrix::Mat;
use squid_sea::ShapingFilter;

/// Sea for which a controller is designed.
#[derive(Debug, Clone, PartialEq)]
pub struct WorkingSea {
    /// Depth of the vehicle \[m\].
    pub depth: f64,
    /// Spectrum and heading of the waves.
    pub waves: WaveParameters,
    /// Factor on the wave amplitude.
    pub weight: f64,
}

impl WorkingSea {
    /// Returns the waves as filtered noise, in the encounter frequency at a speed \[m/s\]; `None` if the waves carry
    /// the vehicle along.
    pub fn filter(&self, speed: f64) -> Option<ShapingFilter> {
        ShapingFilter::met(&self.waves.spectrum, self.waves.heading, speed)
    }

    /// Returns the regular waves at the peak frequency.
    pub fn regular(&self) -> RegularWaves {
        let (frequency, heading) = (self.waves.spectrum.peak(), self.waves.heading);
        RegularWaves { frequency, heading, depth: self.depth }
    }

    /// Returns the effect of the waves on the linear motion about a trim: `[G 0; A_w B_w]`, (n + 2) x 3; see
    /// [`squid_lpv::tracking::TrackingProblem::coloured`]. Noise of 1 at the peak is a wave whose amplitude is half the
    /// significant height.
    pub fn acting(&self, l: &Linearisation) -> Option<Mat> {
        let (by_waves, filter) = (l.by_waves.as_ref()?, self.filter(l.trim.speed)?);
        let (n, height) = (by_waves.nrows(), self.waves.spectrum.height());
        let rates = filter.rates();
        let mut acting = Mat::from_fn(n + 2, 3, |i, j| i.checked_sub(n).map_or(0.0, |row| rates[row][j]));
        acting.view_mut((0, 0), by_waves.shape()).copy_from(&(by_waves * (0.5 * height * self.weight)));
        Some(acting)
    }
}
