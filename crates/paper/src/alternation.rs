//! Alternation of two controllers at a constant speed: can switching make a loop of two stable controllers unstable?

use crate::switched::Handover;
use nalgebra::DVector;
use squid_design::axis::VehicleModel;
use squid_design::check::sampled::{Interconnection, trapezoidal};
use squid_lpv::matrix::{Mat, block, eigenvalues, largest};
use squid_lpv::state_space::StateSpace;
use squid_report::error::Error;
use squid_report::subject::Subject;

/// Largest growth under alternation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Alternation {
    /// Constant speed, midway between the design speeds of the two controllers (m/s).
    pub speed: f64,
    /// Time for which each controller is active (s).
    pub dwell: f64,
    /// Growth rate of the loop (1/s): unstable above 0.
    pub rate: f64,
    /// Longest time for which each is active at which any pair grows (s), if one does.
    pub longest: Option<f64>,
    /// `true` if each controller alone makes a stable loop at this speed.
    pub each_stable: bool,
}

/// Loop in which the controllers alternate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Loop {
    /// Sampled loop with the lags of the actuators.
    Flying,
    /// Loop in continuous time.
    Ideal,
}

/// Returns the worst case over all pairs of neighbours and all times for which each is active, with the true
/// linearisation; `None` if there is no pair.
///
/// # Errors
/// [`ModelError::Trim`](squid_design::error::ModelError::Trim);
/// [`CertifyError::ModeAtTwiceTheRate`](squid_design::error::CertifyError::ModeAtTwiceTheRate).
pub fn worst_alternation(
    subject: &Subject,
    bank: &[StateSpace],
    handover: Handover,
    which: Loop,
) -> Result<Option<Alternation>, Error> {
    let tick = subject.inputs.design.sample_time;
    let (mut worst, mut longest): (Option<Alternation>, Option<f64>) = (None, None);
    for (k, v) in bank.windows(2).zip(subject.speeds.windows(2)) {
        let speed = 0.5 * (v[0] + v[1]);
        let model = subject.inputs.axis().linearise(speed)?;
        let pair = match which {
            Loop::Flying => {
                let [one, two] = [trapezoidal(&k[0], tick)?, trapezoidal(&k[1], tick)?];
                SwitchedPair::new(&subject.sampling().held(&model), &one, &two, handover)
            }
            Loop::Ideal => {
                SwitchedPair::new(&subject.sampling().ideal(&model), &k[0], &k[1], handover).over(tick)
            }
        };
        for dwell in (0..=52).map(|i| 0.05 * 10f64.powf(f64::from(i) / 20.0)) {
            let ticks = (dwell / tick).round().max(1.0);
            let dwell = ticks * tick;
            let rate = pair.growth(ticks as u32).ln() / (2.0 * dwell);
            if rate > 0.0 {
                longest = Some(longest.map_or(dwell, |l: f64| l.max(dwell)));
            }
            if rate.is_finite() && worst.is_none_or(|w| rate > w.rate) {
                let each_stable = pair.each_stable();
                worst = Some(Alternation { speed, dwell, rate, longest: None, each_stable });
            }
        }
    }
    Ok(worst.map(|w| Alternation { longest, ..w }))
}

/// Two controllers on one plant, states \[x, k1, k2\]: the matrices of the motion while each is active (and without the
/// idle controller's states), and the jump at the handover.
struct SwitchedPair {
    motions: [Mat; 2],
    alone: [Mat; 2],
    jumps: [Mat; 2],
    /// Factors on the states of a controller that does not run.
    idle: [Mat; 2],
}

impl SwitchedPair {
    fn new(plant: &Interconnection, one: &StateSpace, two: &StateSpace, handover: Handover) -> Self {
        let Interconnection { a, b, measured: c, .. } = plant;
        let (n, n1, n2) = (a.nrows(), one.a.nrows(), two.a.nrows());
        let zeros = Mat::zeros;
        let running = if handover == Handover::Parallel { 1.0 } else { 0.0 };
        let first = block(&[
            &[&(a + b * &one.d * c), &(b * &one.c), &zeros(n, n2)],
            &[&(&one.b * c), &one.a, &zeros(n1, n2)],
            &[&(&two.b * c * running), &zeros(n2, n1), &(&two.a * running)],
        ]);
        let second = block(&[
            &[&(a + b * &two.d * c), &zeros(n, n1), &(b * &two.c)],
            &[&(&one.b * c * running), &(&one.a * running), &zeros(n1, n2)],
            &[&(&two.b * c), &zeros(n2, n1), &two.a],
        ]);
        let jump = |from: usize, to: usize, rows: usize| {
            let mut jump = Mat::identity(n + n1 + n2, n + n1 + n2);
            if handover != Handover::Parallel {
                jump.rows_mut(to, rows).fill(0.0);
            }
            if handover == Handover::Carried {
                (0..n1.min(n2)).for_each(|i| jump[(to + i, from + i)] = 1.0);
            }
            jump
        };
        let (at_one, at_two) = (n, n + n1);
        let idle = |from: usize, size: usize| {
            let held = if running > 0.0 { 0.0 } else { 1.0 };
            let diagonal = |i: usize| if (from..from + size).contains(&i) { held } else { 0.0 };
            Mat::from_diagonal(&DVector::from_fn(n + n1 + n2, |i, _| diagonal(i)))
        };
        Self {
            motions: [first, second],
            alone: [one, two].map(|k| plant.closed(k).a),
            jumps: [jump(at_one, at_two, n2), jump(at_two, at_one, n1)],
            idle: [idle(at_two, n2), idle(at_one, n1)],
        }
    }

    /// Discretises a motion in continuous time from tick to tick.
    fn over(mut self, tick: f64) -> Self {
        let step = |m: Mat| (m * tick).exp();
        (self.motions, self.alone) = (self.motions.map(step), self.alone.map(step));
        // The exponential preserves constant states.
        self.idle.iter_mut().for_each(|m| m.fill(0.0));
        self
    }

    /// Returns `true` if each controller alone makes a stable loop.
    fn each_stable(&self) -> bool {
        self.alone.iter().all(|a| largest(0.0, eigenvalues(a).iter().map(|v| v.norm())) < 1.0)
    }

    /// Largest modulus of the modes of `J21 A2^ticks J12 A1^ticks`.
    fn growth(&self, ticks: u32) -> f64 {
        let [one, two] = [0, 1].map(|i| &self.jumps[i] * (&self.motions[i] + &self.idle[i]).pow(ticks));
        largest(0.0, eigenvalues(&(two * one)).iter().map(|v| v.norm()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dmatrix;

    fn gain(d: Mat) -> StateSpace {
        let (u, y) = d.shape();
        StateSpace { a: Mat::zeros(0, 0), b: Mat::zeros(0, y), c: Mat::zeros(u, 0), d }
    }

    /// Plant whose controller measures y = r - C x.
    fn plant(a: Mat, b: Mat, c: Mat) -> Interconnection {
        let p = c.nrows();
        Interconnection {
            from_references: Mat::zeros(a.nrows(), p),
            measured: -&c,
            references: Mat::identity(p, p),
            a,
            b,
            c,
        }
    }

    /// Two stable oscillators with crossing ellipses: switching at the right moments makes the state grow (D. Liberzon,
    /// Switching in Systems and Control, 2003, section 3.1). The loop is A itself with K = -A and B = C = I.
    #[test]
    fn alternation_of_stable_loops_can_be_unstable() {
        let (one, two) = (dmatrix![-0.1, 1.0; -10.0, -0.1], dmatrix![-0.1, 10.0; -1.0, -0.1]);
        let plant = plant(Mat::zeros(2, 2), Mat::identity(2, 2), Mat::identity(2, 2));
        let quarter = std::f64::consts::FRAC_PI_2 / 10f64.sqrt();
        let pair =
            SwitchedPair::new(&plant, &gain(-&one), &gain(-&two), Handover::Carried).over(quarter / 50.0);
        assert!(pair.each_stable());
        assert!(pair.growth(50) > 5.0, "{}", pair.growth(50));
        // Alternation of one loop with itself only decays: exp(-0.1 2 quarter).
        let pair =
            SwitchedPair::new(&plant, &gain(-&one), &gain(-&one), Handover::Reset).over(quarter / 50.0);
        assert!((pair.growth(50) - (-0.2 * quarter).exp()).abs() < 1e-9);
    }

    /// Two alternating integrators with x' = -u: if reset, each starts without the other's state; if carried over, they
    /// are the same loop.
    #[test]
    fn handover_changes_growth() {
        let integrator =
            StateSpace { a: dmatrix![0.0], b: dmatrix![1.0], c: dmatrix![1.0], d: dmatrix![1.0] };
        let plant = plant(dmatrix![0.0], dmatrix![1.0], dmatrix![1.0]);
        let growth =
            |handover| SwitchedPair::new(&plant, &integrator, &integrator, handover).over(0.02).growth(50);
        // x' = -x + k, k' = -x: modes (-1 +- j sqrt 3)/2, so over two seconds they decay by exp(-1).
        assert!((growth(Handover::Carried) - (-1f64).exp()).abs() < 1e-9);
        assert!((growth(Handover::Reset) - growth(Handover::Carried)).abs() > 0.1);
    }

    /// Three ticks of each controller: x+ = 0.5 x + u with u = k y, y = -x, so that K = -0.4 and K = 0.2 give modes 0.9
    /// and 0.3.
    #[test]
    fn growth_counts_ticks() {
        let plant = plant(dmatrix![0.5], dmatrix![1.0], dmatrix![1.0]);
        for handover in [Handover::Reset, Handover::Carried, Handover::Parallel] {
            let pair = SwitchedPair::new(&plant, &gain(dmatrix![-0.4]), &gain(dmatrix![0.2]), handover);
            assert!(pair.each_stable());
            assert!((pair.growth(3) - (0.9f64 * 0.3).powi(3)).abs() < 1e-12, "{handover:?}");
        }
    }
}
