//! The augmented plant of a tracking problem: model, weight on the tracking error, weight on the control.
//!
//! ```text
//!   r --(+)--> e --[W_e]--> z_e          W_e = (s/M_s + w_b) / (s + w_b eps)
//!        ^-        |
//!        |         v y = e
//!        |        [K]--> u --[W_u]--> z_u
//!   C x  |         |
//!        +--[model]+<-- beta d           d: disturbance at the input
//! ```
//!
//! Source: A. Sutarto, A. Budiyono, Indian J. Geo-Marine Sci. 40(2), 2011, section 3B and Fig. 2 (the paper prints
//! 1/W_e); S. Skogestad, I. Postlethwaite, Multivariable Feedback Control, 2005, eq. 2.105.

use crate::error::{AugmentError, ShapeError};
use crate::matrix::{Mat, block, diagonal_blocks};
use crate::system::lft::Lft;
use crate::system::partition::Group::{T, U, W, X, Y, Z};
use crate::system::plant::GeneralisedPlant;
use nalgebra::DVector;

/// `W_e(s) = (s/M_s + w_b)/(s + w_b eps)`, a bound on the inverse of the sensitivity.
///
/// It is proper for every M_s that is not 0: 1/M_s is its gain at high frequency. No other weight can be asked for,
/// and W_u is a constant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackingWeight {
    /// M_s: the peak that the sensitivity may have.
    pub peak: f64,
    /// eps: the steady tracking error that is allowed, relative.
    pub steady_error: f64,
    /// w_b: the bandwidth asked for, rad/s.
    pub bandwidth: f64,
}

/// A tracking problem for a model `x' = A(theta) x + B(theta) v`.
#[derive(Debug, Clone, PartialEq)]
pub struct TrackingProblem {
    /// The LFT of `[A B]`, n x (n + m).
    pub model: Lft,
    /// Repetitions of the parameters in the model's channels, which stand in that order.
    pub blocks: Vec<usize>,
    /// The rows of C of the tracked outputs, p x n.
    pub outputs: Mat,
    /// What counts as 1 in each tracked output: its largest reference.
    pub output_scale: Vec<f64>,
    /// What counts as 1 in each input: its limit.
    pub input_scale: Vec<f64>,
    /// W_e of each tracked output.
    pub tracking: Vec<TrackingWeight>,
    /// W_u of each input, in units of its scale.
    pub control: Vec<f64>,
    /// Size of the disturbance at each input, in units of its scale.
    pub disturbance: f64,
}

impl TrackingProblem {
    /// The generalised plant.
    ///
    /// States: the model's, then one of each W_e. `w = [r; d]`, `z = [W_e e; W_u u]`, `y = e`, all in units
    /// of their scales.
    ///
    /// # Errors
    /// The first part whose size does not fit, or the first number that makes a weight improper, unstable or infinite.
    pub fn augment(&self) -> Result<GeneralisedPlant, AugmentError> {
        let n = self.model.constant.nrows();
        let (m, p) = (self.input_scale.len(), self.outputs.nrows());
        self.check(n, m, p)?;
        self.check_numbers()?;
        let diagonal = |v: &[f64]| Mat::from_diagonal(&DVector::from_row_slice(v));
        let scale_u = diagonal(&self.input_scale);
        let inverse_scale: Vec<f64> = self.output_scale.iter().map(|s| 1.0 / s).collect();
        let c = diagonal(&inverse_scale) * &self.outputs;
        let a = self.model.constant.columns(0, n).into_owned();
        let b = self.model.constant.columns(n, m) * &scale_u;
        let (rx, ru) =
            (self.model.right.columns(0, n).into_owned(), self.model.right.columns(n, m) * &scale_u);
        let weights: Vec<[f64; 3]> = self.tracking.iter().map(TrackingWeight::realise).collect();
        let column = |i: usize| diagonal(&weights.iter().map(|w| w[i]).collect::<Vec<_>>());
        let (pole, gain, direct) = (column(0), column(1), column(2));
        let r = self.model.size();
        let zero = Mat::zeros;
        let blocks = [
            (X, X, block(&[&[&a, &zero(n, p)], &[&-(&gain * &c), &pole]])),
            (X, T, block(&[&[&self.model.left], &[&zero(p, r)]])),
            (X, W, block(&[&[&zero(n, p), &(&b * self.disturbance)], &[&gain, &zero(p, m)]])),
            (X, U, block(&[&[&b], &[&zero(p, m)]])),
            (T, X, block(&[&[&rx, &zero(r, p)]])),
            (T, T, self.model.inner.clone()),
            (T, W, block(&[&[&zero(r, p), &(&ru * self.disturbance)]])),
            (T, U, ru),
            (Z, X, block(&[&[&-(&direct * &c), &gain], &[&zero(m, n), &zero(m, p)]])),
            (Z, W, diagonal_blocks(&[&direct, &zero(m, m)])),
            (Z, U, block(&[&[&zero(p, m)], &[&diagonal(&self.control)]])),
            (Y, X, block(&[&[&-c, &zero(p, p)]])),
            (Y, W, block(&[&[&Mat::identity(p, p), &zero(p, m)]])),
        ];
        Ok(GeneralisedPlant::new(self.blocks.clone(), &blocks)?)
    }

    fn check_numbers(&self) -> Result<(), AugmentError> {
        let positive = |name, v: &f64| (name, *v, invertible(*v), "above 0 and finite");
        let finite = |name, v: &f64| (name, *v, v.is_finite(), "finite");
        let number = |index: usize, (name, found, good, allowed)| match good {
            true => Ok(()),
            false => Err(AugmentError::Number { name, index: index + 1, found, allowed }),
        };
        for (i, weight) in self.tracking.iter().enumerate() {
            weight.checks().into_iter().try_for_each(|check| number(i, check))?;
        }
        for (i, scale) in self.output_scale.iter().enumerate() {
            number(i, positive("the scale of output", scale))?;
        }
        for (i, scale) in self.input_scale.iter().enumerate() {
            number(i, positive("the scale of input", scale))?;
        }
        for (i, weight) in self.control.iter().enumerate() {
            number(i, finite("W_u of input", weight))?;
        }
        number(0, finite("the disturbance at input", &self.disturbance))
    }

    fn check(&self, n: usize, m: usize, p: usize) -> Result<(), ShapeError> {
        let lists: [(&'static str, usize, usize); 4] = [
            ("output_scale", self.output_scale.len(), p),
            ("tracking weights", self.tracking.len(), p),
            ("control weights", self.control.len(), m),
            ("model channels", self.model.size(), self.blocks.iter().sum()),
        ];
        for (name, found, expected) in lists {
            if found != expected {
                return Err(ShapeError { name, found: (found, 1), expected: (expected, 1) });
            }
        }
        let shape = self.model.constant.shape();
        if shape != (n, n + m) {
            return Err(ShapeError { name: "model [A B]", found: shape, expected: (n, n + m) });
        }
        if self.outputs.ncols() != n {
            return Err(ShapeError { name: "outputs", found: self.outputs.shape(), expected: (p, n) });
        }
        Ok(())
    }
}

/// Finite, above 0, and with a finite inverse.
fn invertible(v: f64) -> bool {
    v > 0.0 && v.is_finite() && v.recip().is_finite()
}

impl TrackingWeight {
    /// Name, value, whether it is allowed, and what is.
    fn checks(&self) -> [(&'static str, f64, bool, &'static str); 3] {
        let within = (0.0..=self.peak).contains(&self.steady_error);
        [
            ("the peak of W_e", self.peak, invertible(self.peak), "above 0, or W_e is not proper"),
            ("the steady error of W_e", self.steady_error, within, "from 0 to the peak, or W_e is no bound"),
            (
                "the bandwidth of W_e",
                self.bandwidth,
                invertible(self.bandwidth),
                "above 0 and finite (rad/s)",
            ),
        ]
    }

    /// `[pole, gain, direct]` of `x' = pole x + gain e, z = gain x + direct e`.
    fn realise(&self) -> [f64; 3] {
        let direct = 1.0 / self.peak;
        let residue = self.bandwidth * (1.0 - self.steady_error / self.peak);
        [-self.bandwidth * self.steady_error, residue.sqrt(), direct]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::system::state_space::StateSpace;
    use nalgebra::{Complex, dmatrix};

    /// A model with one state, one input and no parameter.
    fn problem() -> TrackingProblem {
        let none = |rows, columns| Mat::zeros(rows, columns);
        TrackingProblem {
            model: Lft {
                constant: dmatrix![-1.0, 1.0],
                left: none(1, 0),
                inner: none(0, 0),
                right: none(0, 2),
                channels: vec![],
            },
            blocks: vec![],
            outputs: dmatrix![1.0],
            output_scale: vec![1.0],
            input_scale: vec![1.0],
            tracking: vec![TrackingWeight { peak: 2.0, steady_error: 0.01, bandwidth: 0.46 }],
            control: vec![0.5],
            disturbance: 0.1,
        }
    }

    #[test]
    fn a_weight_that_is_not_proper_is_refused_by_name() {
        assert!(problem().augment().is_ok());
        type Spoil = fn(&mut TrackingProblem);
        let spoilt: [(Spoil, &str); 6] = [
            (
                |p| p.tracking[0].peak = 0.0,
                "the peak of W_e 1 is 0; it must be above 0, or W_e is not proper",
            ),
            (|p| p.tracking[0].steady_error = 3.0, "the steady error of W_e 1 is 3"),
            (|p| p.tracking[0].bandwidth = f64::INFINITY, "the bandwidth of W_e 1 is inf"),
            (|p| p.output_scale[0] = 0.0, "the scale of output 1 is 0"),
            (|p| p.control[0] = f64::NAN, "W_u of input 1 is NaN"),
            (|p| p.disturbance = f64::INFINITY, "the disturbance at input 1 is inf"),
        ];
        for (spoil, words) in spoilt {
            let mut problem = problem();
            spoil(&mut problem);
            let message = problem.augment().unwrap_err().to_string();
            assert!(message.starts_with(words), "{message}");
        }
    }

    #[test]
    fn weight_has_the_printed_form() {
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
