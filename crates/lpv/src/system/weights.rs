//! The weights of a tracking problem, and reference models.
//!
//! Source of W_e: A. Sutarto, A. Budiyono, Indian J. Geo-Marine Sci. 40(2), 2011, section 3B (the paper prints 1/W_e);
//! S. Skogestad, I. Postlethwaite, Multivariable Feedback Control, 2005, eq. 2.105.

use nalgebra::Complex;

/// `W_e(s) = (s/M_s + w_b)/(s + w_b eps)`, a bound on the inverse of the sensitivity.
///
/// It is proper for every nonzero M_s: 1/M_s is its gain at high frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackingWeight {
    /// M_s: the largest allowed peak of the sensitivity.
    pub peak: f64,
    /// eps: the allowed steady tracking error, relative.
    pub steady_error: f64,
    /// w_b: the required bandwidth, rad/s.
    pub bandwidth: f64,
}

impl TrackingWeight {
    /// Returns the checks of the numbers: name, value, `true` if it is allowed, allowed values.
    pub(super) fn checks(&self) -> [(&'static str, f64, bool, &'static str); 3] {
        let within = (0.0..=self.peak).contains(&self.steady_error);
        [
            ("the peak of W_e", self.peak, invertible(self.peak), "above 0, so that W_e is proper"),
            ("the steady error of W_e", self.steady_error, within, "from 0 to the peak"),
            (
                "the bandwidth of W_e",
                self.bandwidth,
                invertible(self.bandwidth),
                "finite and above 0 (rad/s)",
            ),
        ]
    }

    /// Returns `[pole, gain, direct]` of `x' = pole x + gain e, z = gain x + direct e`.
    pub(super) fn realise(&self) -> [f64; 3] {
        let direct = 1.0 / self.peak;
        let residue = self.bandwidth * (1.0 - self.steady_error / self.peak);
        [-self.bandwidth * self.steady_error, residue.sqrt(), direct]
    }
}

/// A weight that rises with frequency: `W(s) = low + (high - low) s/(s + corner)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RisingWeight {
    /// Gain at frequency 0.
    pub low: f64,
    /// Gain at high frequency, at least `low`.
    pub high: f64,
    /// Corner frequency, rad/s.
    pub corner: f64,
}

impl RisingWeight {
    /// Returns a weight that is the same at every frequency.
    pub fn constant(value: f64) -> Self {
        Self { low: value, high: value, corner: 1.0 }
    }

    /// Returns `|W(j omega)|`; omega in rad/s.
    pub fn gain(&self, omega: f64) -> f64 {
        let s = Complex::new(0.0, omega);
        (s / (s + self.corner) * (self.high - self.low) + self.low).norm()
    }

    pub(super) fn rises(&self) -> bool {
        self.high > self.low
    }

    pub(super) fn check(&self, name: &'static str) -> (&'static str, f64, bool, &'static str) {
        let good = self.low.is_finite() && self.high.is_finite() && self.high >= self.low;
        let good = good && invertible(self.corner);
        (name, self.low, good, "finite, no smaller at high frequency, and with a corner frequency above 0")
    }
}

/// Emphasis on slow references: `R(s) = (s + follow corner)/(s + corner)`.
///
/// A controller with one gamma for references, disturbances and noise follows its model only as closely as gamma
/// requires. A larger weight on a reference improves tracking at no cost to the feedback from the measurements.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReferenceWeight {
    /// R(0), at least 1.
    pub follow: f64,
    /// Corner frequency, rad/s.
    pub corner: f64,
}

impl ReferenceWeight {
    /// Returns `R(j omega)`; omega in rad/s.
    pub fn response(&self, omega: f64) -> Complex<f64> {
        let s = Complex::new(0.0, omega);
        (s + self.follow * self.corner) / (s + self.corner)
    }
}

/// The model that a tracked output must follow: `w^2/(s^2 + 2 zeta w s + w^2)`, or `w/(s + w)` without damping.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReferenceModel {
    /// Frequency w, rad/s.
    pub frequency: f64,
    /// Damping ratio zeta.
    pub damping: Option<f64>,
}

impl ReferenceModel {
    /// Returns the time by which the output of the model lags behind a ramp, s.
    pub fn lag(&self) -> f64 {
        self.damping.map_or(1.0, |damping| 2.0 * damping) / self.frequency
    }
}

impl ReferenceModel {
    /// Returns `T_ref(j omega)`; omega in rad/s.
    pub fn response(&self, omega: f64) -> Complex<f64> {
        let s = Complex::new(0.0, omega / self.frequency);
        match self.damping {
            None => (s + 1.0).inv(),
            Some(damping) => (s * s + s * (2.0 * damping) + 1.0).inv(),
        }
    }
}

/// Returns `true` if `v` is finite, above 0, and has a finite inverse.
pub(super) fn invertible(v: f64) -> bool {
    v > 0.0 && v.is_finite() && v.recip().is_finite()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::system::StateSpace;
    use nalgebra::dmatrix;

    #[test]
    fn the_weight_has_the_published_form() {
        let w = TrackingWeight { peak: 2.0, steady_error: 0.01, bandwidth: 0.46 };
        let [pole, gain, direct] = w.realise();
        let system =
            StateSpace { a: dmatrix![pole], b: dmatrix![gain], c: dmatrix![gain], d: dmatrix![direct] };
        for omega in [0.0, 1e-3, 0.46, 30.0] {
            let s = Complex::new(0.0, omega);
            let printed = (s / 2.0 + 0.46) / (s + 0.46 * 0.01);
            assert!((system.response(s).unwrap()[(0, 0)] - printed).norm() < 1e-12 * printed.norm());
        }
    }
}
