//! A plant integrated by the trapezoidal rule, as a plant in continuous time.
//!
//! ```text
//! (x_(k+1) - x_k)/T = A m_k + Bt wt_k + B1 w_k + B2 u_k,   m_k = (x_k + x_(k+1))/2,   wt_k = Theta_k zt_k
//! ```
//!
//! with zt and z evaluated at m_k. With m_k for x and `(x_(k+1) - x_k)/T` for x' these are the equations of the plant
//! in continuous time, and since `x_(k+1)' X x_(k+1) - x_k' X x_k = 2 T m_k' X (x_(k+1) - x_k)/T`, an inequality that
//! bounds the gain of one for every trajectory of the parameters bounds that of the other for every sequence of them. A
//! controller discretised by the trapezoidal rule, as by `squid_scheduled::Lft::discretise`, is unchanged in this form.
//!
//! There are two differences. The measured state is that at the tick, `x_k = m_k - T/2 x'`, half a sample before m_k.
//! And z is not constant on the straight line from x_k to x_(k+1): its mean square is `|z|^2 + T^2/12 |C1 x'|^2`.
//!
//! Source of the bilinear map: K. Zhou, J. C. Doyle, K. Glover, Robust and Optimal Control, 1996, chapter 21.

use crate::error::SystemError;
use crate::matrix::{Mat, block};
use crate::system::Group::{T, U, W, X, Y, Z};
use crate::system::{Controller, GeneralisedPlant, Sizes};

/// A plant at the ticks, with its direct path from u to y.
#[derive(Debug, Clone, PartialEq)]
pub struct AtTicks {
    /// The plant without the direct path; `T/sqrt(12) C1 x'` is appended to z.
    pub plant: GeneralisedPlant,
    /// The direct path `-T/2 C2 B2`, for [`crate::direct_path`].
    pub d22: Mat,
}

impl GeneralisedPlant {
    /// Returns the plant integrated by the trapezoidal rule with the sample time T (s), with w, u and Theta held
    /// between ticks, as a plant in continuous time.
    ///
    /// ```text
    /// C2 (I - A T/2),  -C2 Bt T/2,  D21 - C2 B1 T/2,  -C2 B2 T/2   in place of   C2, D2t, D21, D22
    /// ```
    ///
    /// Source: see the module.
    ///
    /// # Errors
    /// Returns [`SystemError::SampleTime`]; [`SystemError::DirectPath`] if u or a parameter affects y directly.
    pub fn at_ticks(&self, sample_time: f64) -> Result<AtTicks, SystemError> {
        if !(sample_time > 0.0 && sample_time.is_finite()) {
            return Err(SystemError::SampleTime { found: sample_time });
        }
        if [T, U].iter().any(|column| self.parts.block(Y, *column).iter().any(|v| *v != 0.0)) {
            return Err(SystemError::DirectPath);
        }
        let z = self.sizes().z;
        let mut parts = self.parts.resized(Z, 2 * z);
        let (half, ripple) = (self.c2() * (-0.5 * sample_time), self.c1() * (sample_time / 12f64.sqrt()));
        for column in [X, T, W, U] {
            let rate = self.parts.block(X, column);
            parts.block_mut(Z, column).rows_mut(z, z).copy_from(&(&ripple * &rate));
            let mut measured = parts.block_mut(Y, column);
            measured += &half * &rate;
        }
        let d22 = parts.block(Y, U);
        parts.block_mut(Y, U).fill(0.0);
        Ok(AtTicks { plant: GeneralisedPlant { parts, blocks: self.blocks.clone() }, d22 })
    }
}

impl Controller {
    /// Returns the controller with its commands delayed by `ticks` ticks of T (s): one all-pass `(2/T - s)/(2/T + s)`
    /// per tick, which the trapezoidal rule converts to `z^-1`.
    #[must_use]
    pub fn delayed_at_ticks(&self, ticks: usize, sample_time: f64) -> Self {
        (0..ticks).fold(self.clone(), |k, _| {
            let Sizes { x, y, u, .. } = k.parts.sizes();
            let rate = 2.0 / sample_time;
            let (zero, now) = (Mat::zeros, |column| k.parts.block(U, column));
            let one = Mat::identity(u, u);
            let (a, by, bt) = (k.a(), k.by(), k.bt());
            let matrix = block(&[
                &[&a, &zero(x, u), &by, &bt],
                &[&(now(X) * rate), &(&one * -rate), &(now(Y) * rate), &(now(T) * rate)],
                &[&-now(X), &(one * 2.0), &-now(Y), &-now(T)],
                &[&k.ct(), &zero(k.ct().nrows(), u), &k.dty(), &k.dtt()],
            ]);
            Self::from_matrix(&matrix, x + u, y, u, k.blocks.clone())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::direct_path::around;
    use crate::matrix::solve;
    use crate::system::state_space::StateSpace;
    use nalgebra::{Complex, dmatrix};

    const TICK: f64 = 0.2;

    /// Returns x' = (-1 + theta) x + w + u, z = x + u, y = x + w and a controller with one state, delayed by two ticks.
    fn plant() -> GeneralisedPlant {
        let blocks = [
            (X, X, dmatrix![-1.0]),
            (X, T, dmatrix![1.0]),
            (X, W, dmatrix![1.0]),
            (X, U, dmatrix![1.0]),
            (T, X, dmatrix![1.0]),
            (Z, X, dmatrix![1.0]),
            (Z, U, dmatrix![1.0]),
            (Y, X, dmatrix![1.0]),
            (Y, W, dmatrix![1.0]),
        ];
        GeneralisedPlant::new(vec![1], &blocks).unwrap()
    }

    fn trapezoidal(s: &StateSpace) -> StateSpace {
        let n = s.a.nrows();
        let half = &s.a * (0.5 * TICK);
        let p = solve(&(Mat::identity(n, n) - &half), &Mat::identity(n, n)).unwrap();
        StateSpace {
            a: &p * (Mat::identity(n, n) + half),
            b: &p * &s.b * TICK,
            c: &s.c * &p,
            d: &s.d + &s.c * p * &s.b * (0.5 * TICK),
        }
    }

    /// The loop at a frozen parameter and on the unit circle equals the simulated one: plant and controller by the
    /// trapezoidal rule, the measurement at the tick, the command delayed by two ticks.
    #[test]
    fn the_response_on_the_unit_circle_is_that_of_the_sampled_loop() {
        let k = Controller::from_matrix(
            &dmatrix![-2.0, 1.0, 0.5; 0.3, -0.4, 0.2; 1.0, 0.5, 0.1],
            1,
            1,
            1,
            vec![1],
        );
        let (plant, theta) = (plant(), 0.6);
        let AtTicks { plant: ticks, d22 } = plant.at_ticks(TICK).unwrap();
        let inner = around(&k.delayed_at_ticks(2, TICK), &-&d22).unwrap();
        let found = ticks.close(&inner).frozen(&[theta]).unwrap();
        assert!(found.is_stable());
        let flown = trapezoidal(&k.frozen(&[theta]).unwrap()).delayed(2);
        let (a, h) = (-1.0 + theta, TICK);
        for angle in [0.05, 0.7, 2.5] {
            let z = Complex::from_polar(1.0, angle);
            let s = (z - 1.0) / (z + 1.0) * (2.0 / h);
            // x_(k+1) = x_k + h (a (x_k + x_(k+1))/2 + w + u), u = K(z) (x + w), w = 1.
            let g = Complex::new(h, 0.0) / (z * (1.0 - 0.5 * h * a) - (1.0 + 0.5 * h * a));
            let gain = flown.response(z).unwrap()[0];
            let u = gain * (g + 1.0) / (1.0 - gain * g);
            let x = g * (u + 1.0);
            let (mean, rate) = (x * (z + 1.0) * 0.5, x * (z - 1.0) / h);
            let response = found.response(s).unwrap();
            assert!((response[0] - (mean + u)).norm() < 1e-12, "{angle}: {} {}", response[0], mean + u);
            assert!((response[1] - rate * (h / 12f64.sqrt())).norm() < 1e-12);
        }
    }

    #[test]
    fn direct_effects_on_a_measurement_are_rejected() {
        let mut parts = plant().parts;
        parts.block_mut(Y, T)[0] = 0.1;
        let direct = GeneralisedPlant { parts, blocks: vec![1] };
        assert_eq!(direct.at_ticks(TICK), Err(SystemError::DirectPath));
        assert_eq!(plant().at_ticks(0.0), Err(SystemError::SampleTime { found: 0.0 }));
    }
}
