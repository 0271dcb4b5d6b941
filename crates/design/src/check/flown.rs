//! Figures of the loop in flight, linear and frozen at a speed: the sampled controller, held commands, actuators with
//! lags, the trim that follows the speed reference, and the true linearisation.

use crate::axis::Linearisation;
use crate::check::margins::{Margins, Opened};
use crate::check::sampled::{Sampling, trapezoidal};
use nalgebra::Complex;
use squid_lpv::matrix::{Mat, eigenvalues, largest};
use squid_lpv::state_space::StateSpace;
use squid_signals::Signal;

/// Step of the speed of the water in a gust, vertical or lateral, m/s.
pub const GUST: f64 = 0.3;

/// Duration of a simulated response, s.
pub const DURATION: f64 = 60.0;

/// Band around the reference, relative to the step, for the settling time.
const SETTLED: f64 = 0.02;

/// Returns the rms of the white noise of a sensor at each sample: 0.05 deg, 0.05 deg/s, 0.01 m/s, 0.01 m.
pub fn noise(signal: &Signal) -> f64 {
    match signal.unit {
        "m/s" | "m" => 0.01,
        _ => 0.05f64.to_radians(),
    }
}

/// Response of a tracked output to a step of its own reference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// Largest excursion beyond the reference, relative to the step.
    pub overshoot: f64,
    /// Time from 10 % to 90 % of the step, s; infinite if the response does not reach 90 %.
    pub rise_time: f64,
    /// Time from the step until the output stays within 2 % of the reference, s; infinite if it never does.
    pub settling_time: f64,
    /// `|1 - T(z = 1)|`: the steady-state error, relative to the step.
    pub steady_error: f64,
    /// Error after [`DURATION`], relative to the step; slow modes may not have settled.
    pub remaining_error: f64,
}

/// Figures at one speed.
#[derive(Debug, Clone, PartialEq)]
pub struct Flown {
    /// Margins with the loop opened at one measurement, or tracking error, at a time, in the order of the controller's
    /// inputs.
    pub at_measurements: Vec<Margins>,
    /// Margins with the loop opened at one command at a time.
    pub at_commands: Vec<Margins>,
    /// Largest |S| at all these points.
    pub peak: f64,
    /// Smallest common delay of all commands that makes the loop unstable, s.
    pub common_delay: f64,
    /// Step response of each tracked output.
    pub steps: Vec<Step>,
    /// Largest absolute pitch, or heading, after a gust, rad: the water starts to move by [`GUST`] vertically, or
    /// laterally, so the heave or sway speed relative to the water jumps by as much.
    pub gust: f64,
    /// Rms of each command under [`noise`], N or rad.
    pub noise_rms: Vec<f64>,
}

impl Flown {
    /// Computes the figures of the loop with a controller frozen at the speed of a trim; `None` if the controller has a
    /// mode at 2/T or the loop is unstable.
    pub fn of(sampling: &Sampling, l: &Linearisation, frozen: &StateSpace) -> Option<Self> {
        let plant = sampling.held(l);
        let k = trapezoidal(frozen, sampling.sample_time).ok()?;
        Self::of_sampled(sampling, &plant.injected(&k))
    }

    /// Computes the figures of a loop with the inputs and outputs of
    /// [`Interconnection::injected`](crate::check::sampled::Interconnection::injected).
    pub fn of_sampled(sampling: &Sampling, system: &StateSpace) -> Option<Self> {
        let (opened, noise_rms) = opened(sampling, system)?;
        let (tracked, m, time) = (&sampling.design.tracked, sampling.actuators.len(), sampling.sample_time);
        let measurements = sampling.design.fed_back().len();
        let turned = ["pitch", "heading"].into_iter().find_map(|name| sampling.design.tracks(name));
        let across =
            sampling.design.states.iter().position(|state| ["v", "w"].contains(&state.symbol)).unwrap_or(0);
        Some(Self {
            at_measurements: (0..measurements).map(|i| opened.margins(i)).collect(),
            at_commands: (0..m).map(|j| opened.margins(measurements + j)).collect(),
            peak: opened.peak_of_sensitivity(),
            common_delay: opened.common_delay(measurements..measurements + m),
            steps: (0..tracked.len()).map(|i| Step::of(&system.part(i, i), time)).collect(),
            gust: turned.map_or(f64::NAN, |i| tracked[i].scale * gust(system, i, across, time)),
            noise_rms,
        })
    }

    /// Returns all margins, each with the loop opened at one point.
    pub fn margins(&self) -> impl Iterator<Item = &Margins> {
        self.at_measurements.iter().chain(&self.at_commands)
    }
}

/// Returns the loop opened at measurements and commands, and the rms of each command under [`noise`] \[N or rad\];
/// `None` if it is unstable. The inputs and outputs are those of
/// [`Interconnection::injected`](crate::check::sampled::Interconnection::injected).
pub fn opened(sampling: &Sampling, system: &StateSpace) -> Option<(Opened, Vec<f64>)> {
    let radius = largest(0.0, eigenvalues(&system.a).iter().map(|v| v.norm()));
    if radius.is_nan() || radius >= 1.0 {
        return None;
    }
    let (fed_back, m) = (sampling.design.fed_back(), sampling.actuators.len());
    let commands = system.b.ncols() - m;
    let open = commands - fed_back.len();
    let points = open..commands + m;
    let opened = Opened::new(system.parts(points.clone(), points), sampling.sample_time);
    let mut noisy = system.parts(commands..commands + m, open..commands);
    for (j, (signal, scale)) in fed_back.iter().enumerate() {
        noisy.b.column_mut(j).scale_mut(noise(signal) / scale);
        noisy.d.column_mut(j).scale_mut(noise(signal) / scale);
    }
    let rms = rms(&noisy).iter().zip(sampling.actuators).map(|(rms, a)| rms * a.reach()).collect();
    Some((opened, rms))
}

impl Step {
    /// Computes the figures of the step response of a stable sampled system with one input and one output.
    pub fn of(system: &StateSpace, sample_time: f64) -> Self {
        let StateSpace { a, b, c, d } = system;
        let mut x = Mat::zeros(a.nrows(), 1);
        let ticks = (DURATION / sample_time) as usize;
        let mut response = Vec::with_capacity(ticks);
        for _ in 0..ticks {
            response.push((c * &x)[0] + d[0]);
            x = a * x + b;
        }
        let time = |tick: usize| tick as f64 * sample_time;
        let first = |level: f64| response.iter().position(|v| *v >= level).map_or(f64::INFINITY, time);
        let end = system.response(Complex::new(1.0, 0.0)).map_or(f64::NAN, |g| g[(0, 0)].re);
        let last_outside = response.iter().rposition(|v| (v - 1.0).abs() > SETTLED);
        Self {
            overshoot: response.iter().map(|v| v - 1.0).fold(0.0, f64::max),
            rise_time: if first(0.9).is_finite() { first(0.9) - first(0.1) } else { f64::INFINITY },
            settling_time: match last_outside.map_or(0, |last| last + 1) {
                settled if settled < response.len() => time(settled),
                _ => f64::INFINITY,
            },
            steady_error: (1.0 - end).abs(),
            remaining_error: response.last().map_or(f64::NAN, |v| (1.0 - v).abs()),
        }
    }
}

/// Largest absolute value of an output, in its scale, after a gust into the state of the transverse speed.
fn gust(system: &StateSpace, output: usize, across: usize, sample_time: f64) -> f64 {
    let mut x = Mat::zeros(system.a.nrows(), 1);
    x[across] = GUST;
    let c = system.c.rows(output, 1);
    let mut most = 0f64;
    for _ in 0..(DURATION / sample_time) as usize {
        most = most.max((c * &x)[0].abs());
        x = &system.a * x;
    }
    most
}

/// Returns the rms of each output of a stable sampled system under white noise of rms 1 at each input and sample, from
/// the covariance `P = A P A' + B B'`: the square roots of the diagonal of `C P C' + D D'`.
///
/// P is computed by doubling, `P <- P + A P A', A <- A^2`: R. A. Smith, SIAM J. Applied Mathematics 16(1), 1968.
pub fn rms(system: &StateSpace) -> Vec<f64> {
    let StateSpace { a, b, c, d } = system;
    let (mut a, mut p) = (a.clone(), b * b.transpose());
    for _ in 0..DOUBLINGS {
        let more = &a * &p * a.transpose();
        p += &more;
        a = &a * &a;
        if more.amax() <= f64::EPSILON * p.amax() {
            break;
        }
    }
    let covariance = c * p * c.transpose() + d * d.transpose();
    covariance.diagonal().iter().map(|v| v.sqrt()).collect()
}

/// Maximum number of doublings: 2^60 samples.
const DOUBLINGS: u32 = 60;

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dmatrix;

    /// y+ = a y + (1 - a) r has the step response y = 1 - a^k.
    #[test]
    fn a_first_order_step_has_its_closed_form() {
        let (a, time) = (0.93f64, 0.1);
        let system = StateSpace { a: dmatrix![a], b: dmatrix![1.0 - a], c: dmatrix![1.0], d: dmatrix![0.0] };
        let found = Step::of(&system, time);
        let ticks = |left: f64| (left.ln() / a.ln()).ceil();
        assert_eq!(found.overshoot, 0.0);
        assert!((found.rise_time - time * (ticks(0.1) - ticks(0.9))).abs() < 1e-9, "{found:?}");
        assert!((found.settling_time - time * ticks(0.02)).abs() < 1e-9, "{found:?}");
        assert!(found.steady_error < 1e-12);
        let weak = Step::of(&StateSpace { c: dmatrix![0.95], ..system }, time);
        assert!((weak.steady_error - 0.05).abs() < 1e-12 && weak.settling_time == f64::INFINITY);
    }

    /// The rms of y+ = a y + b n is b/sqrt(1 - a^2); two such states driven by the same noise have E y1 y2 = b1 b2/(1 -
    /// a1 a2). One mode takes 1e6 samples to decay.
    #[test]
    fn rms_of_a_filter_has_its_closed_form() {
        for slow in [0.5, 1.0 - 1e-6] {
            let (a, b) = ([0.8, slow], [2.0, 0.3]);
            let system = StateSpace {
                a: dmatrix![a[0], 0.0; 0.0, a[1]],
                b: dmatrix![b[0]; b[1]],
                c: dmatrix![1.0, 0.0; 0.0, 1.0; 1.0, -1.0],
                d: dmatrix![0.0; 0.0; 0.5],
            };
            let covariance = |i: usize, j: usize| b[i] * b[j] / (1.0 - a[i] * a[j]);
            let difference = covariance(0, 0) + covariance(1, 1) - 2.0 * covariance(0, 1) + 0.25;
            let expected = [covariance(0, 0).sqrt(), covariance(1, 1).sqrt(), difference.sqrt()];
            for (found, expected) in rms(&system).iter().zip(expected) {
                assert!((found - expected).abs() < 1e-9 * expected, "{found} {expected}");
            }
        }
    }
}
