//! The loop at a frozen speed: true linearisation and frozen controller, linear and in continuous time, without actuator lags.

use super::subject::Subject;
use crate::error::Error;
use auv::Linearisation;
use lpv::controller::Controller;
use lpv::matrix::{Mat, block, complex_singular_values};
use lpv::state_space::StateSpace;
use nalgebra::{Complex, DMatrix};

/// From the references to the tracked outputs and the controls, all in units of their scales.
#[derive(Debug, Clone)]
pub struct FrozenLoop {
    system: StateSpace,
    tracked: usize,
}

impl FrozenLoop {
    /// Closes the true linearisation `l` with the controller frozen at the speed of its trim.
    ///
    /// ```text
    /// x' = A x + B u,  y = r - C x,  u = K(rho) y
    /// ```
    ///
    /// # Errors
    /// [`Error::Lft`] when the controller has no value there.
    pub fn new(subject: &Subject, controller: &Controller, l: &Linearisation) -> Result<Self, Error> {
        let (a, b, c) = subject.scaled(l);
        let theta = vec![subject.rho(l.trim.speed); controller.blocks.len()];
        let k = controller.frozen(&theta)?;
        let p = c.nrows();
        let none = Mat::zeros(p, k.a.nrows());
        let system = StateSpace {
            a: block(&[&[&(&a - &b * &k.d * &c), &(&b * &k.c)], &[&-(&k.b * &c), &k.a]]),
            b: block(&[&[&(&b * &k.d)], &[&k.b]]),
            c: block(&[&[&c, &none], &[&-(&k.d * &c), &k.c]]),
            d: block(&[&[&Mat::zeros(p, p)], &[&k.d]]),
        };
        Ok(Self { system, tracked: p })
    }

    fn response(&self, omega: f64) -> Option<DMatrix<Complex<f64>>> {
        self.system.response(Complex::new(0.0, omega))
    }

    /// |T| of one tracked output at a frequency (rad/s); not-a-number at a pole.
    pub fn tracking(&self, i: usize, omega: f64) -> f64 {
        self.response(omega).map_or(f64::NAN, |g| g[(i, i)].norm())
    }

    /// |S| of one tracked output at a frequency (rad/s); not-a-number at a pole.
    pub fn sensitivity(&self, i: usize, omega: f64) -> f64 {
        self.response(omega).map_or(f64::NAN, |g| (Complex::new(1.0, 0.0) - g[(i, i)]).norm())
    }

    /// The largest singular value from all references to all controls at a frequency (rad/s).
    pub fn control(&self, omega: f64) -> f64 {
        let largest = |g: DMatrix<Complex<f64>>| {
            let controls = g.rows(self.tracked, g.nrows() - self.tracked).into_owned();
            complex_singular_values(&controls).first().copied().unwrap_or(0.0)
        };
        self.response(omega).map_or(f64::NAN, largest)
    }

    /// The bandwidth of one tracked output: the highest frequency (rad/s) at which |T| is 1/sqrt(2); not-a-number when it is nowhere in
    /// 0.001 to 1000 rad/s.
    ///
    /// Source: S. Skogestad, I. Postlethwaite, Multivariable Feedback Control, 2005, section 2.4.5.
    pub fn bandwidth(&self, i: usize) -> f64 {
        let level = std::f64::consts::FRAC_1_SQRT_2;
        let above = |exponent: f64| self.tracking(i, 10f64.powf(exponent)) >= level;
        let grid: Vec<f64> = (0..=300).map(|k| -3.0 + f64::from(k) / 50.0).collect();
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

    /// The response of one tracked output to a unit impulse of its own reference, every `interval` (s), in 1/s. The matrix
    /// exponential makes it exact at these instants.
    pub fn impulse(&self, i: usize, interval: f64, count: usize) -> Vec<(f64, f64)> {
        let transition = (&self.system.a * interval).exp();
        let c = self.system.c.row(i);
        let mut x = self.system.b.column(i).into_owned();
        let mut out = Vec::with_capacity(count);
        for k in 0..count {
            out.push((k as f64 * interval, c.transpose().dot(&x)));
            x = &transition * x;
        }
        out
    }

    /// The least damping ratio of its modes, and the frequency (rad/s) of that mode.
    pub fn least_damping(&self) -> (f64, f64) {
        let ratios = self.system.poles().into_iter().map(|p| (-p.re / p.norm(), p.norm()));
        ratios.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::NAN, f64::NAN))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dmatrix;

    /// T = 1/(s + 1), and the control is 2 T: bandwidth 1 rad/s, impulse response exp(-t).
    #[test]
    fn a_first_order_loop_has_its_closed_forms() {
        let system =
            StateSpace { a: dmatrix![-1.0], b: dmatrix![1.0], c: dmatrix![1.0; 2.0], d: dmatrix![0.0; 0.0] };
        let one = FrozenLoop { system, tracked: 1 };
        assert!((one.bandwidth(0) - 1.0).abs() < 1e-9);
        assert!((one.tracking(0, 1.0) - 0.5f64.sqrt()).abs() < 1e-12);
        assert!((one.sensitivity(0, 1.0) - 0.5f64.sqrt()).abs() < 1e-12);
        assert!((one.control(0.0) - 2.0).abs() < 1e-12);
        for (t, h) in one.impulse(0, 0.1, 50) {
            assert!((h - (-t).exp()).abs() < 1e-12);
        }
        assert_eq!(one.least_damping(), (1.0, 1.0));
    }

    #[test]
    fn no_crossing_is_no_bandwidth() {
        let system = StateSpace { a: dmatrix![-1.0], b: dmatrix![1.0], c: dmatrix![0.1], d: dmatrix![0.0] };
        assert!(FrozenLoop { system, tracked: 1 }.bandwidth(0).is_nan());
    }
}
