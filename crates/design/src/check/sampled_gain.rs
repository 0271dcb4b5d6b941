//! Gain from w to z of the sampled loop, frozen at a speed.
//!
//! In the plant of the design the commands are deviations from the trim, which continuously follows the filtered speed
//! reference V_r. The flown autopilot holds the trim between ticks, like the rest of the command, and filters the
//! reference of the last tick:
//!
//! ```text
//! u(t) = u_k + u0'(V_r(t_k) - V_r(t)),   V_r' = w_r (r(t_k) - V_r)
//! ```
//!
//! V_r is therefore sampled, too, and r(t_k) is held like a command.

use crate::augment::{LinearModel, augment};
use crate::axis::Linearisation;
use crate::check::sampled::{Sampling, trapezoidal};
use crate::error::{Error, ModelError};
use crate::inputs::design_file::DesignFile;
use nalgebra::DVector;
use squid_auv::Actuator;
use squid_lpv::analysis::{Exogenous, SampledGain, sampled_gain_near};
use squid_lpv::matrix::{Mat, block};
use squid_lpv::partition::Group::{U, W, X, Y, Z};
use squid_lpv::plant::GeneralisedPlant;
use squid_lpv::state_space::StateSpace;

impl Sampling<'_> {
    /// Bounds the gain from w to z, including between the ticks, of the true linearisation with the actuator lags and a
    /// frozen sampled controller with held, delayed commands; both bounds are infinite for an unstable loop. References
    /// and noise, which enter the controller directly, are held between ticks; disturbances are as given by `w`. The
    /// search starts at a `guess`.
    ///
    /// # Errors
    /// [`ModelError`]; a controller that cannot be sampled.
    pub fn gain(
        &self,
        l: &Linearisation,
        frozen: &StateSpace,
        w: Exogenous,
        guess: f64,
    ) -> Result<SampledGain, Error> {
        let (plant, k) = self.lifted(l, frozen)?;
        Ok(sampled_gain_near(&plant, &k, self.sample_time, w, guess).map_err(ModelError::System)?)
    }

    /// Returns the plant in continuous time and the controller in discrete time.
    fn lifted(
        &self,
        l: &Linearisation,
        frozen: &StateSpace,
    ) -> Result<(GeneralisedPlant, StateSpace), Error> {
        // The delay of the commands is in the controller.
        let design = DesignFile { delay: 0.0, lags: true, ..self.design.clone() };
        let plant = augment(self.actuators, &design, LinearModel::at(l, &design))?;
        let k = trapezoidal(frozen, self.sample_time)?;
        let ticks = self.delay_ticks();
        let Some(speed) = design.tracked_speed().filter(|_| design.reference_filter().is_some()) else {
            return Ok((plant, k.delayed(ticks)));
        };
        let slope = l.trim_slope.rows(l.states.len(), self.actuators.len()) * design.tracked[speed].scale;
        let reach = self.actuators.iter().map(|a| 1.0 / a.reach());
        let slope = Mat::from_diagonal(&DVector::from_iterator(self.actuators.len(), reach)) * slope;
        let level = trim_state_index(l, self.actuators, &design);
        let held = Held { speed, level, slope };
        Ok((held.plant(&plant), held.controller(k, ticks)))
    }
}

/// Index of V_r among the states of the plant; see [`squid_lpv::tracking::TrackingProblem::augment`].
fn trim_state_index(l: &Linearisation, actuators: &[Actuator], design: &DesignFile) -> usize {
    let lags = actuators.iter().filter(|a| design.lags && a.lag > 0.0).count();
    let slow = design.tracked.iter().filter(|t| t.references.follow > 1.0).count();
    l.states.len() + lags + design.tracked.len() + slow
}

/// Trim that is held between ticks.
struct Held {
    /// Row of y with r - V_r.
    speed: usize,
    /// Index of the state V_r.
    level: usize,
    /// Slope u0' in the units of the plant, m x 1.
    slope: Mat,
}

impl Held {
    /// Plant with the commands `[u + u0' V_r; r]` of the last tick, and with V_r as the last measurement.
    fn plant(&self, plant: &GeneralisedPlant) -> GeneralisedPlant {
        let sizes = plant.sizes();
        let mut now = Mat::zeros(1, sizes.x);
        now[(0, self.level)] = 1.0;
        // The plant contains V_r' = w_r (r - V_r) and its effects, so V_r enters as -r.
        let by_reference = -plant.a().column(self.level);
        let from = |column| plant.parts.block(Y, column).rows(self.speed, 1).into_owned();
        let reference = from(X) + &now;
        let moved = &self.slope * &now;
        let mut all = plant.parts.resized(U, sizes.u + 1).resized(Y, sizes.y + 1);
        for (row, column, change) in [
            (X, X, -&by_reference * reference - plant.b2() * &moved),
            (X, W, -&by_reference * from(W)),
            (Z, X, -plant.d12() * moved),
        ] {
            let mut block = all.block_mut(row, column);
            block += change;
        }
        all.block_mut(X, U).set_column(sizes.u, &by_reference);
        all.block_mut(Y, X).set_row(sizes.y, &now.row(0));
        GeneralisedPlant { parts: all, blocks: vec![] }
    }

    /// Controller from `[y; V_r]` to `[u + u0' V_r; r]`; only the commands are delayed.
    fn controller(&self, k: StateSpace, ticks: usize) -> StateSpace {
        let (n, y) = (k.a.nrows(), k.d.ncols());
        let b = block(&[&[&k.b, &Mat::zeros(n, 1)]]);
        let delayed = StateSpace { b, d: block(&[&[&k.d, &self.slope]]), ..k }.delayed(ticks);
        let mut reference = Mat::zeros(1, y + 1);
        (reference[(0, self.speed)], reference[(0, y)]) = (1.0, 1.0);
        StateSpace {
            c: block(&[&[&delayed.c], &[&Mat::zeros(1, delayed.a.nrows())]]),
            d: block(&[&[&delayed.d], &[&reference]]),
            ..delayed
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::axis::VehicleModel;
    use crate::check::sampled::tests::arbitrary;
    use crate::inputs::tests::shipped;

    /// The plant with its trim held between ticks has the modes of the flown loop, and those of the weights.
    #[test]
    fn lifted_loop_has_modes_of_flown_loop() {
        for (name, design, speed, delay) in [
            ("squid", "design", 0.7, 0.0),
            ("squid", "design", 2.6, 0.06),
            ("remus100", "pitch", 1.6, 0.1),
            ("squid", "paper", 1.0, 0.04),
        ] {
            let mut inputs = shipped(name, design);
            inputs.design.delay = delay;
            let (actuators, file) = (&inputs.vehicle.actuators, &inputs.design);
            let l = inputs.axis().linearise(speed).unwrap();
            let (m, y) = (actuators.len(), file.tracked.len() + file.measured.len());
            let k = StateSpace {
                a: arbitrary(3, 3, 0.0) - Mat::identity(3, 3),
                b: arbitrary(3, y, 1.0),
                c: arbitrary(m, 3, 2.0),
                d: arbitrary(m, y, 3.0),
            };
            let sampling = Sampling::of(actuators, file);
            let (plant, sampled) = sampling.lifted(&l, &k).unwrap();
            let (n, u) = (plant.sizes().x, plant.sizes().u);
            let generator = block(&[&[&plant.a(), &plant.b2()], &[&Mat::zeros(u, n), &Mat::zeros(u, u)]])
                * file.sample_time;
            let step = generator.exp();
            let held = step.view((0, n), (n, u));
            let closed = StateSpace {
                a: block(&[
                    &[&(step.view((0, 0), (n, n)) + held * &sampled.d * plant.c2()), &(held * &sampled.c)],
                    &[&(&sampled.b * plant.c2()), &sampled.a],
                ]),
                b: Mat::zeros(0, 0),
                c: Mat::zeros(0, 0),
                d: Mat::zeros(0, 0),
            };
            let mut modes = closed.poles();
            let flown = sampling.closed(&l, &k).unwrap().poles();
            assert!(modes.len() >= flown.len());
            // The modes of the delay are at 0 with multiplicity, so rounding disturbs them by a root of its size.
            for mode in flown.into_iter().filter(|mode| mode.norm() > 0.05) {
                let (at, nearest) = modes
                    .iter()
                    .enumerate()
                    .map(|(at, other)| (at, (other - mode).norm()))
                    .min_by(|a, b| a.1.total_cmp(&b.1))
                    .unwrap();
                assert!(nearest < 1e-9, "{name} {design} {speed} {delay}: {mode}, off by {nearest}");
                modes.swap_remove(at);
            }
        }
    }
}
