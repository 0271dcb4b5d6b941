//! Linear loop at a frozen speed: true linearisation and frozen controller, sampled as in flight or in continuous time
//! as in the synthesis.

use crate::error::Error;
use crate::subject::Subject;
use nalgebra::{Complex, DMatrix};
use squid_design::axis::Linearisation;
use squid_design::check::sampled::{Interconnection, trapezoidal};
use squid_lpv::controller::Controller;
use squid_lpv::matrix::largest_complex_singular_value;
use squid_lpv::state_space::StateSpace;
use squid_lpv::weights::ReferenceModel;
use std::f64::consts::PI;

/// Approximate time between the points of a plotted response (s).
const INTERVAL: f64 = 0.02;

/// Loop from the references to the tracked outputs and the controls, all in units of their scales.
#[derive(Debug, Clone)]
pub struct FrozenLoop {
    system: StateSpace,
    tracked: usize,
    /// T_ref of each tracked output, if it has a reference model.
    models: Vec<Option<ReferenceModel>>,
    /// Sensitivity at the measurement of each tracked output.
    sensitivities: Vec<Option<StateSpace>>,
    /// Sample time (s) of a discrete-time loop; `None` in continuous time.
    sample_time: Option<f64>,
}

impl FrozenLoop {
    /// Closes the true linearisation `l` with the controller frozen at the speed of its trim, in continuous time and
    /// with the actuator lags of the design.
    ///
    /// ```text
    /// x' = A x + B u,  y = r - C x or [r; C x],  u = K(rho) y
    /// ```
    ///
    /// # Errors
    /// [`ModelError::System`](squid_design::error::ModelError::System) if the controller is not well posed there.
    pub fn ideal(subject: &Subject, controller: &Controller, l: &Linearisation) -> Result<Self, Error> {
        Ok(Self::of(subject, &subject.sampling().ideal(l), &subject.frozen(controller, l)?, None))
    }

    /// Closes the loop as flown: a sampled controller, held commands, and actuators with their lags.
    ///
    /// # Errors
    /// Errors of [`Self::ideal`];
    /// [`CertifyError::ModeAtTwiceTheRate`](squid_design::error::CertifyError::ModeAtTwiceTheRate).
    pub fn flying(subject: &Subject, controller: &Controller, l: &Linearisation) -> Result<Self, Error> {
        let tick = subject.inputs.design.sample_time;
        let sampled = trapezoidal(&subject.frozen(controller, l)?, tick)?;
        Ok(Self::of(subject, &subject.sampling().held(l), &sampled, Some(tick)))
    }

    fn of(subject: &Subject, wired: &Interconnection, k: &StateSpace, sample_time: Option<f64>) -> Self {
        let design = &subject.inputs.design;
        let outputs = 0..design.tracked.len();
        Self {
            system: wired.closed(k),
            tracked: outputs.len(),
            models: design.tracked.iter().map(|t| t.model).collect(),
            sensitivities: outputs.map(|i| Some(wired.sensitivity(k, design.feedback_row(i)?))).collect(),
            sample_time,
        }
    }

    /// Returns s or z at a frequency (rad/s).
    fn at(&self, omega: f64) -> Complex<f64> {
        let s = Complex::new(0.0, omega);
        self.sample_time.map_or(s, |t| (s * t).exp())
    }

    fn response(&self, omega: f64) -> Option<DMatrix<Complex<f64>>> {
        self.system.response(self.at(omega))
    }

    /// Returns the highest frequency (rad/s) of a response: the Nyquist frequency, or infinity in continuous time.
    pub fn highest(&self) -> f64 {
        self.sample_time.map_or(f64::INFINITY, |t| PI / t)
    }

    /// Returns T of one tracked output at a frequency (rad/s); `None` at a pole.
    pub fn closed(&self, i: usize, omega: f64) -> Option<Complex<f64>> {
        Some(self.response(omega)?[(i, i)])
    }

    /// Returns `L = 1/S - 1` at the measurement of one tracked output at a frequency (rad/s); `None` at a pole or if
    /// the output is not measured.
    pub fn open(&self, i: usize, omega: f64) -> Option<Complex<f64>> {
        let s = self.sensitivities[i].as_ref()?.response(self.at(omega))?[(0, 0)];
        Some(1.0 / s - 1.0)
    }

    /// Returns |T| of one tracked output at a frequency (rad/s); NaN at a pole.
    pub fn tracking(&self, i: usize, omega: f64) -> f64 {
        self.closed(i, omega).map_or(f64::NAN, |t| t.norm())
    }

    /// Returns `|T_ref - T|` of one tracked output at a frequency (rad/s), with T_ref = 1 without a reference model;
    /// NaN at a pole.
    pub fn error(&self, i: usize, omega: f64) -> f64 {
        let reference = self.models[i].map_or(Complex::new(1.0, 0.0), |model| model.response(omega));
        self.response(omega).map_or(f64::NAN, |g| (reference - g[(i, i)]).norm())
    }

    /// Returns the largest |S| at the measurement of one tracked output over all frequencies; infinite for an unstable
    /// loop, NaN if a mode is at the Nyquist frequency or the output is not measured.
    ///
    /// A sampled loop is transformed to continuous time, see [`StateSpace::from_circle_to_axis`].
    pub fn peak(&self, i: usize) -> f64 {
        let Some(s) = &self.sensitivities[i] else { return f64::NAN };
        let continuous = match self.sample_time {
            None => Some(s.clone()),
            Some(_) => s.from_circle_to_axis(),
        };
        continuous.map_or(f64::NAN, |s| s.hinf_norm().value)
    }

    /// Returns the largest singular value from all references to all controls, each times its relative weight, at a
    /// frequency (rad/s).
    pub fn control(&self, relative: &[f64], omega: f64) -> f64 {
        let largest = |g: DMatrix<Complex<f64>>| {
            let mut controls = g.rows(self.tracked, g.nrows() - self.tracked).into_owned();
            for (mut row, weight) in controls.row_iter_mut().zip(relative) {
                row *= Complex::from(*weight);
            }
            largest_complex_singular_value(&controls)
        };
        self.response(omega).map_or(f64::NAN, largest)
    }

    /// Returns the bandwidth of one tracked output: the highest frequency (rad/s) at which |T| is 1/sqrt(2); NaN if
    /// there is none from 0.001 to 1000 rad/s or [`Self::highest`].
    ///
    /// Source: S. Skogestad, I. Postlethwaite, Multivariable Feedback Control, 2005, section 2.4.5.
    pub fn bandwidth(&self, i: usize) -> f64 {
        let level = std::f64::consts::FRAC_1_SQRT_2;
        let above = |exponent: f64| self.tracking(i, 10f64.powf(exponent)) >= level;
        let end = self.highest().log10();
        let grid: Vec<f64> = (0..=300).map(|k| -3.0 + f64::from(k) / 50.0).take_while(|e| *e < end).collect();
        let Some(last) = grid.iter().rposition(|e| above(*e)) else { return f64::NAN };
        if last + 1 == grid.len() {
            return f64::NAN;
        }
        let (mut low, mut high) = (grid[last], grid[last + 1]);
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            if above(middle) { low = middle } else { high = middle }
        }
        10f64.powf(0.5 * (low + high))
    }

    /// Returns the response of one tracked output to a unit impulse of its reference over a time (s), in 1/s; for a
    /// sampled loop, to a reference of one over the sample time during the first tick. It is exact in continuous time,
    /// by the matrix exponential.
    pub fn impulse(&self, i: usize, duration: f64) -> Vec<(f64, f64)> {
        let (transition, mut x, interval) = match self.sample_time {
            None => ((&self.system.a * INTERVAL).exp(), self.system.b.column(i).into_owned(), INTERVAL),
            Some(t) => {
                let ticks = (INTERVAL / t).round().max(1.0);
                (self.system.a.pow(ticks as u32), self.system.b.column(i) / t, ticks * t)
            }
        };
        let start = self.sample_time.unwrap_or(0.0);
        let c = self.system.c.row(i);
        let mut out = vec![];
        for k in 0..(duration / interval) as u32 {
            out.push((start + f64::from(k) * interval, c.transpose().dot(&x)));
            x = &transition * x;
        }
        out
    }

    /// Returns the smallest damping ratio of the modes, and the frequency (rad/s) of that mode; a mode z of a sampled
    /// loop is converted to `ln z / T`.
    pub fn least_damping(&self) -> (f64, f64) {
        let mode = |p: Complex<f64>| self.sample_time.map_or(p, |t| p.ln() / t);
        // A mode that decays within a tick has no meaningful damping ratio.
        let lasting = |p: &Complex<f64>| self.sample_time.is_none() || p.norm() > GONE;
        let ratios =
            self.system.poles().into_iter().filter(lasting).map(mode).map(|p| (-p.re / p.norm(), p.norm()));
        ratios.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::NAN, f64::NAN))
    }
}

/// Modulus of a mode z below which it is ignored.
const GONE: f64 = 1e-2;

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dmatrix;
    use squid_lpv::matrix::Mat;

    /// Returns a loop with one output and error feedback, so that S = 1 - T.
    fn of_first_output(system: StateSpace, sample_time: Option<f64>) -> FrozenLoop {
        let sensitivity = StateSpace {
            a: system.a.clone(),
            b: system.b.clone(),
            c: -system.c.rows(0, 1),
            d: Mat::identity(1, 1) - system.d.rows(0, 1),
        };
        FrozenLoop {
            system,
            tracked: 1,
            models: vec![None],
            sensitivities: vec![Some(sensitivity)],
            sample_time,
        }
    }

    /// T = 1/(s + 1), and the control is 2 T: bandwidth 1 rad/s, impulse response exp(-t).
    #[test]
    fn first_order_loop_matches_closed_forms() {
        let system =
            StateSpace { a: dmatrix![-1.0], b: dmatrix![1.0], c: dmatrix![1.0; 2.0], d: dmatrix![0.0; 0.0] };
        let one = of_first_output(system, None);
        assert!((one.bandwidth(0) - 1.0).abs() < 1e-9);
        assert!((one.tracking(0, 1.0) - 0.5f64.sqrt()).abs() < 1e-12);
        assert!((one.error(0, 1.0) - 0.5f64.sqrt()).abs() < 1e-12);
        assert!((one.control(&[3.0], 0.0) - 6.0).abs() < 1e-12);
        assert!((one.peak(0) - 1.0).abs() < 1e-9);
        for (t, h) in one.impulse(0, 5.0) {
            assert!((h - (-t).exp()).abs() < 1e-12);
        }
        assert_eq!(one.least_damping(), (1.0, 1.0));
    }

    /// y+ = a y + (1 - a) r, sampled at 0.5 s: T(z) = (1 - a)/(z - a), one mode ln a / 0.5, the impulse response (1 -
    /// a)/0.5 a^k from the first tick on.
    #[test]
    fn sampled_loop_matches_closed_forms() {
        let a: f64 = 0.6;
        let system =
            StateSpace { a: dmatrix![a], b: dmatrix![1.0 - a], c: dmatrix![1.0; 0.0], d: dmatrix![0.0; 0.0] };
        let one = of_first_output(system, Some(0.5));
        let z = Complex::from_polar(1.0, 0.5 * 1.3);
        let t = (1.0 - a) / (z - a);
        assert!((one.tracking(0, 1.3) - t.norm()).abs() < 1e-12);
        assert!((one.error(0, 1.3) - (1.0 - t).norm()).abs() < 1e-12);
        for (k, (time, h)) in one.impulse(0, 5.0).into_iter().enumerate() {
            assert!((time - 0.5 * (k + 1) as f64).abs() < 1e-12);
            assert!((h - (1.0 - a) / 0.5 * a.powi(k as i32)).abs() < 1e-12);
        }
        // S = (z - 1)/(z - a) is largest at z = -1.
        assert!((one.peak(0) - 2.0 / (1.0 + a)).abs() < 1e-9);
        let (damping, frequency) = one.least_damping();
        assert!((damping - 1.0).abs() < 1e-12 && (frequency + a.ln() / 0.5).abs() < 1e-12);
        // |e^(j x) - a| = sqrt(2) (1 - a): cos x = (1 + a^2 - 2 (1 - a)^2)/(2 a).
        let x = ((1.0 + a * a - 2.0 * (1.0 - a).powi(2)) / (2.0 * a)).acos();
        assert!((one.bandwidth(0) - x / 0.5).abs() < 1e-9);
    }

    #[test]
    fn bandwidth_without_crossing_is_nan() {
        let system = StateSpace { a: dmatrix![-1.0], b: dmatrix![1.0], c: dmatrix![0.1], d: dmatrix![0.0] };
        assert!(of_first_output(system, None).bandwidth(0).is_nan());
    }
}
