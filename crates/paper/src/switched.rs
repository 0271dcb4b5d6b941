//! Flight under several controllers, one of which is selected by the measured speed.

use squid_design::check::sampled::trapezoidal;
use squid_design::error::CertifyError;
use squid_flight::flight::{Row, Variations};
use squid_lpv::matrix::Mat;
use squid_lpv::state_space::StateSpace;
use squid_report::error::Error;
use squid_report::peers::law::fly_instead;
use squid_report::subject::Subject;

/// Treatment of the controller states at a handover.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Handover {
    /// The new controller starts from zero.
    Reset,
    /// The new controller starts from the states of the old one, entry by entry.
    Carried,
    /// All controllers run all the time, each with its own states.
    Parallel,
}

/// Controllers with their states.
struct Bank {
    controllers: Vec<StateSpace>,
    states: Vec<Mat>,
    active: usize,
    handover: Handover,
}

impl Bank {
    /// Activates a controller and returns its output for the errors `y`; then all running controllers advance by a
    /// sample.
    fn tick(&mut self, chosen: usize, y: &Mat) -> Mat {
        if chosen != self.active {
            match self.handover {
                Handover::Reset => self.states[chosen].fill(0.0),
                Handover::Carried => {
                    let old = self.states[self.active].clone();
                    let rows = old.nrows().min(self.states[chosen].nrows());
                    self.states[chosen].fill(0.0);
                    self.states[chosen].rows_mut(0, rows).copy_from(&old.rows(0, rows));
                }
                Handover::Parallel => {}
            }
            self.active = chosen;
        }
        let k = &self.controllers[chosen];
        let u = &k.c * &self.states[chosen] + &k.d * y;
        for (i, (k, x)) in self.controllers.iter().zip(&mut self.states).enumerate() {
            if i == chosen || self.handover == Handover::Parallel {
                *x = &k.a * &*x + &k.b * y;
            }
        }
        u
    }
}

/// Flies the design's manoeuvre, like [`squid_flight::flight::fly`], under controllers designed for the speeds of the
/// subject.
///
/// # Errors
/// [`Error::Flight`], [`CertifyError::ModeAtTwiceTheRate`].
pub fn fly_switched(subject: &Subject, bank: &[StateSpace], handover: Handover) -> Result<Vec<Row>, Error> {
    let (vehicle, manoeuvre) = (&subject.inputs.vehicle, &subject.stored.manoeuvre);
    let sampled = |k: &StateSpace| trapezoidal(k, subject.stored.controller.sample_time);
    let controllers = bank.iter().map(sampled).collect::<Result<Vec<StateSpace>, CertifyError>>()?;
    let states = controllers.iter().map(|k| Mat::zeros(k.a.nrows(), 1)).collect();
    let mut bank = Bank { controllers, states, active: 0, handover };
    let law = |speed: f64, y: &Mat| bank.tick(nearest(&subject.speeds, speed), y);
    Ok(fly_instead(subject, vehicle, manoeuvre, &Variations::default(), law)?.rows)
}

fn nearest(speeds: &[f64], v: f64) -> usize {
    let distance = |i: &usize| (speeds[*i] - v).abs();
    (0..speeds.len()).min_by(|i, j| distance(i).total_cmp(&distance(j))).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dmatrix;

    /// Two integrators; the output of the second is the negative of its state.
    fn bank(handover: Handover) -> Bank {
        let integrator =
            |c: f64| StateSpace { a: dmatrix![1.0], b: dmatrix![1.0], c: dmatrix![c], d: dmatrix![0.0] };
        Bank {
            controllers: vec![integrator(1.0), integrator(-1.0)],
            states: vec![dmatrix![0.0], dmatrix![0.0]],
            active: 0,
            handover,
        }
    }

    #[test]
    fn handover_resets_carries_or_runs_states() {
        for (handover, expected) in
            [(Handover::Reset, 0.0), (Handover::Carried, -3.0), (Handover::Parallel, -3.0)]
        {
            let mut bank = bank(handover);
            for _ in 0..3 {
                bank.tick(0, &dmatrix![1.0]);
            }
            assert_eq!(bank.tick(1, &dmatrix![1.0])[0], expected, "{handover:?}");
        }
        // After the return the first controller's state is unchanged unless all run.
        for (handover, expected) in
            [(Handover::Carried, 2.0), (Handover::Parallel, 2.0), (Handover::Reset, 0.0)]
        {
            let mut bank = bank(handover);
            bank.tick(0, &dmatrix![1.0]);
            bank.tick(1, &dmatrix![1.0]);
            assert_eq!(bank.tick(0, &dmatrix![1.0])[0], expected, "{handover:?}");
        }
    }

    #[test]
    fn nearest_speed_is_active() {
        assert_eq!(nearest(&[0.5, 1.0, 1.5], 0.7), 0);
        assert_eq!(nearest(&[0.5, 1.0, 1.5], 0.8), 1);
        assert_eq!(nearest(&[0.5, 1.0, 1.5], 9.0), 2);
    }
}
