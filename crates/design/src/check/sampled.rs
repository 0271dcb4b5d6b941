//! The loop as it will run: the controller at its sample time, the vehicle and its actuators in between.
//!
//! The gain bound is about the controller in continuous time. Here the frozen controller is discretised by the
//! trapezoidal rule, as the FMU does it, and closed with the true linearisation and the lags of the actuators under a
//! zero-order hold.

use crate::error::ProofError;
use crate::inputs::Inputs;
use crate::inputs::design_file::Tracked;
use crate::linearise::STATES;
use auv::{Actuator, Linearisation};
use lpv::matrix::{Mat, block, largest, solve};
use lpv::state_space::StateSpace;

/// How a loop is sampled: its actuators, its tracked outputs, and the time between two ticks \[s\].
#[derive(Debug, Clone, Copy)]
pub struct Sampling<'a> {
    /// The actuators, with their lags.
    pub actuators: &'a [Actuator],
    /// The tracked outputs.
    pub tracked: &'a [Tracked],
    /// s.
    pub sample_time: f64,
}

impl<'a> Sampling<'a> {
    /// That of a design.
    pub fn of(inputs: &'a Inputs) -> Self {
        let Inputs { vehicle, design, .. } = inputs;
        Self { actuators: &vehicle.actuators, tracked: &design.tracked, sample_time: design.sample_time }
    }

    /// The largest modulus of the sampled loop's modes; not-a-number when it cannot be formed.
    pub fn spectral_radius(&self, l: &Linearisation, frozen: &StateSpace) -> f64 {
        let radius = |closed: StateSpace| largest(0.0, closed.poles().iter().map(|v| v.norm()));
        self.closed(l, frozen).map_or(f64::NAN, radius)
    }

    /// The sampled loop from the references to the tracked outputs and the controls, at the ticks and in units of their
    /// scales; `None` where a mode of the controller is at 2/T.
    ///
    /// ```text
    /// x+ = Phi x + Gamma u,  y = r - C x,  (k+, u) = K(k, y),  states [x, k]
    /// ```
    pub fn closed(&self, l: &Linearisation, frozen: &StateSpace) -> Option<StateSpace> {
        let (phi, gamma, c) = self.held(l);
        Some(closed(&phi, &gamma, &c, &trapezoidal(frozen, self.sample_time)?))
    }

    /// Vehicle and actuators over one sample with the commands held: states \[u w q theta, actuators\], inputs and
    /// tracked outputs in units of their scales.
    pub fn held(&self, l: &Linearisation) -> (Mat, Mat, Mat) {
        let Self { actuators, tracked, sample_time } = *self;
        let m = actuators.len();
        let n = STATES + m;
        let mut generator = Mat::zeros(n + m, n + m);
        generator.view_mut((0, 0), (STATES, STATES)).copy_from(&l.a);
        generator.view_mut((0, STATES), (STATES, m)).copy_from(&l.b);
        for (j, actuator) in actuators.iter().enumerate() {
            // An actuator without lag is one that is much faster than the sample.
            let rate = 1.0 / actuator.lag.max(1e-3 * sample_time);
            generator[(STATES + j, STATES + j)] = -rate;
            generator[(STATES + j, n + j)] = rate * actuator.reach();
        }
        let transition = (generator * sample_time).exp();
        let measured =
            Mat::from_fn(tracked.len(), n, |i, j| tracked[i].signal().output(j) / tracked[i].scale);
        (transition.view((0, 0), (n, n)).into_owned(), transition.view((0, n), (n, m)).into_owned(), measured)
    }
}

/// The error when [`Sampling::closed`] or [`trapezoidal`] returns `None`.
pub fn cannot() -> ProofError {
    ProofError::Mismatch { what: "the sample time, with a mode of the controller".into() }
}

/// Closes the loop of a plant without direct term and a controller, from the references to the outputs and the
/// controls: `x+ = A x + B u`, `y = r - C x`, `u = K y`, states [x, k].
pub fn closed(a: &Mat, b: &Mat, c: &Mat, k: &StateSpace) -> StateSpace {
    let p = c.nrows();
    StateSpace {
        a: block(&[&[&(a - b * &k.d * c), &(b * &k.c)], &[&-(&k.b * c), &k.a]]),
        b: block(&[&[&(b * &k.d)], &[&k.b]]),
        c: block(&[&[c, &Mat::zeros(p, k.a.nrows())], &[&-(&k.d * c), &k.c]]),
        d: block(&[&[&Mat::zeros(p, p)], &[&k.d]]),
    }
}

/// `Dtt` of the discretised controller: `Dtt + Ct (I - A T/2)^-1 Bt T/2`.
pub fn sampled_dtt(k: &lpv::controller::Controller, sample_time: f64) -> Option<Mat> {
    let n = k.a().nrows();
    let inner = solve(&(Mat::identity(n, n) - &k.a() * (0.5 * sample_time)), &k.bt())?;
    Some(&k.dtt() + &k.ct() * inner * (0.5 * sample_time))
}

/// Discretises a controller by the trapezoidal rule with sample time T \[s\], as `scheduled::Lft::discretise` at a frozen
/// parameter: `K_d(z) = K(2/T (z - 1)/(z + 1))`; `None` where a mode is at 2/T.
pub fn trapezoidal(k: &StateSpace, sample_time: f64) -> Option<StateSpace> {
    let n = k.a.nrows();
    let half = &k.a * (0.5 * sample_time);
    let identity = Mat::identity(n, n);
    let p = solve(&(&identity - &half), &identity)?;
    Some(StateSpace {
        a: &p * (&identity + &half),
        b: &p * &k.b * sample_time,
        c: &k.c * &p,
        d: &k.d + &k.c * &p * &k.b * (0.5 * sample_time),
    })
}
