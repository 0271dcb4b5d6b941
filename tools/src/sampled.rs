//! The loop as it will run: the controller at its sample time, the vehicle and its actuators in between.
//!
//! The gain bound is about the controller in continuous time. Here the frozen controller is discretised by the trapezoidal rule, as
//! the FMU does it, and closed with the true linearisation and the lags of the actuators under a zero-order hold.

use crate::inputs::Inputs;
use crate::model::STATES;
use auv::Linearisation;
use lpv::matrix::{Mat, block, eigenvalues, largest, solve};
use lpv::state_space::StateSpace;

/// The largest modulus of the sampled loop's modes; not-a-number when it cannot be formed.
pub fn spectral_radius(inputs: &Inputs, l: &Linearisation, frozen: &StateSpace) -> f64 {
    let (phi, gamma) = held(inputs, l);
    let Some(k) = trapezoidal(frozen, inputs.design.sample_time) else { return f64::NAN };
    let measured = Mat::from_fn(inputs.design.tracked.len(), phi.nrows(), |i, j| {
        let tracked = &inputs.design.tracked[i];
        if tracked.output.state() == j { -1.0 / tracked.scale } else { 0.0 }
    });
    let closed =
        block(&[&[&(&phi + &gamma * &k.d * &measured), &(&gamma * &k.c)], &[&(&k.b * &measured), &k.a]]);
    largest(0.0, eigenvalues(&closed).iter().map(|v| v.norm()))
}

/// `Dtt` of the discretised controller: `Dtt + Ct (I - A T/2)^-1 Bt T/2`.
pub fn sampled_dtt(k: &lpv::controller::Controller, sample_time: f64) -> Option<Mat> {
    let n = k.a.nrows();
    let inner = solve(&(Mat::identity(n, n) - &k.a * (0.5 * sample_time)), &k.bt)?;
    Some(&k.dtt + &k.ct * inner * (0.5 * sample_time))
}

/// Vehicle and actuators over one sample with the commands held: states \[u w q theta, actuators\], inputs in units of their scale.
fn held(inputs: &Inputs, l: &Linearisation) -> (Mat, Mat) {
    let actuators = &inputs.vehicle.actuators;
    let m = actuators.len();
    let n = STATES + m;
    let mut generator = Mat::zeros(n + m, n + m);
    generator.view_mut((0, 0), (STATES, STATES)).copy_from(&l.a);
    generator.view_mut((0, STATES), (STATES, m)).copy_from(&l.b);
    for (j, actuator) in actuators.iter().enumerate() {
        // An actuator without lag is one that is much faster than the sample.
        let rate = 1.0 / actuator.lag.max(1e-3 * inputs.design.sample_time);
        generator[(STATES + j, STATES + j)] = -rate;
        generator[(STATES + j, n + j)] = rate * actuator.reach();
    }
    let transition = (generator * inputs.design.sample_time).exp();
    (transition.view((0, 0), (n, n)).into_owned(), transition.view((0, n), (n, m)).into_owned())
}

/// The trapezoidal rule, as `scheduled::Lft::discretise` at a frozen parameter; `None` where a mode lies at 2/T.
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
