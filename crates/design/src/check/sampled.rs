//! Sampled loop: the controller at its sample time, the vehicle and its actuators in continuous time.
//!
//! The gain bound holds for the controller in continuous time. This module discretises the frozen controller by the
//! trapezoidal rule, as in the FMU, and closes it with the true linearisation and the actuator lags under a zero-order
//! hold.

use crate::axis::Linearisation;
use crate::error::CertifyError;
use crate::inputs::design_file::{DesignFile, Measured, Tracked};
use nalgebra::DVector;
use squid_auv::Actuator;
use squid_lpv::matrix::{Mat, block, largest, solve};
use squid_lpv::state_space::StateSpace;
use squid_signals::Signal;

/// Data of a sampled loop: its actuators, the signals of its controller, and the sample time.
#[derive(Debug, Clone, Copy)]
pub struct Sampling<'a> {
    /// Actuators, with their lags.
    pub actuators: &'a [Actuator],
    /// Design file, with the tracked and the measured outputs.
    pub design: &'a DesignFile,
    /// Sample time, s.
    pub sample_time: f64,
}

/// Plant seen by a controller: the vehicle at a trim, its actuators, and the trim that follows the speed reference.
///
/// ```text
/// x' = A x + B u + Br r,   y = Cy x + Dr r,   outputs C x      (x+ in place of x' if sampled)
/// ```
///
/// States \[u w q theta\], without u for a vehicle with a given speed, with the depth z for a design that tracks or
/// measures it; then those of the actuators and of the filtered reference, as deviations from the trim at the frozen
/// speed. u is the controller's command relative to the trim. u, r, y and the outputs are in units of their scales.
#[derive(Debug, Clone)]
pub struct Interconnection {
    /// Matrix A.
    pub a: Mat,
    /// Matrix B.
    pub b: Mat,
    /// Matrix Br.
    pub from_references: Mat,
    /// Matrix C of the tracked outputs.
    pub c: Mat,
    /// Matrix Cy.
    pub measured: Mat,
    /// Matrix Dr.
    pub references: Mat,
}

impl Interconnection {
    /// Returns the sensitivity at one measurement, with the loop closed at all others: from a signal added to it to the
    /// controller's input.
    pub fn sensitivity(&self, k: &StateSpace, row: usize) -> StateSpace {
        let output = self.c.nrows() + row;
        self.injected(k).part(output, self.references.ncols() + row)
    }

    /// Closes the loop with a controller `(k', u) = K(k, y)`: from r to the outputs and u.
    pub fn closed(&self, k: &StateSpace) -> StateSpace {
        let injected = self.injected(k);
        let (p, y) = (self.c.nrows(), self.measured.nrows());
        let controls = injected.parts(p + y..p + y + self.b.ncols(), 0..self.references.ncols());
        let outputs = injected.parts(0..p, 0..self.references.ncols());
        StateSpace {
            c: block(&[&[&outputs.c], &[&controls.c]]),
            d: block(&[&[&outputs.d], &[&controls.d]]),
            ..controls
        }
    }

    /// Closes the loop with n added to the controller's inputs and d to the commands: from \[r; n; d\] to \[C x; y + n;
    /// u + d\].
    pub fn injected(&self, k: &StateSpace) -> StateSpace {
        let Self { a, b, from_references, c, measured, references } = self;
        let (p, q, m, n) = (c.nrows(), measured.nrows(), b.ncols(), k.a.nrows());
        let (zero, one) = (Mat::zeros, Mat::identity);
        let r = references.ncols();
        StateSpace {
            a: block(&[&[&(a + b * &k.d * measured), &(b * &k.c)], &[&(&k.b * measured), &k.a]]),
            b: block(&[
                &[&(from_references + b * &k.d * references), &(b * &k.d), b],
                &[&(&k.b * references), &k.b, &zero(n, m)],
            ]),
            c: block(&[&[c, &zero(p, n)], &[measured, &zero(q, n)], &[&(&k.d * measured), &k.c]]),
            d: block(&[
                &[&zero(p, r), &zero(p, q), &zero(p, m)],
                &[references, &one(q, q), &zero(q, m)],
                &[&(&k.d * references), &k.d, &one(m, m)],
            ]),
        }
    }
}

impl<'a> Sampling<'a> {
    /// Returns the sampling of a design.
    pub fn of(actuators: &'a [Actuator], design: &'a DesignFile) -> Self {
        Self { actuators, design, sample_time: design.sample_time }
    }

    /// Returns the largest modulus of the modes of the sampled loop; NaN if it cannot be formed.
    pub fn spectral_radius(&self, l: &Linearisation, frozen: &StateSpace) -> f64 {
        let radius = |closed: StateSpace| largest(0.0, closed.poles().iter().map(|v| v.norm()));
        self.closed(l, frozen).map_or(f64::NAN, radius)
    }

    /// Closes the sampled loop from the references to the tracked outputs and the commands, at the ticks and in units
    /// of their scales; `None` if the controller has a mode at 2/T.
    pub fn closed(&self, l: &Linearisation, frozen: &StateSpace) -> Option<StateSpace> {
        Some(self.held(l).closed(&trapezoidal(frozen, self.sample_time).ok()?))
    }

    /// Discretises vehicle, actuators and filtered reference over one sample, with held commands.
    pub fn held(&self, l: &Linearisation) -> Interconnection {
        let m = self.actuators.len();
        let states = l.states.len();
        let n = states + m;
        let mut generator = Mat::zeros(n + m, n + m);
        generator.view_mut((0, 0), (n, n)).copy_from(&self.lagged(l, |_| true));
        for (j, actuator) in self.actuators.iter().enumerate() {
            generator[(states + j, n + j)] = 1.0 / self.lag(actuator);
        }
        let transition = (generator * self.sample_time).exp();
        let (phi, gamma) = (transition.view((0, 0), (n, n)), transition.view((0, n), (n, m)));
        let (a, b) = with_input_delay(phi.into_owned(), gamma.into_owned(), self.delay_ticks());
        self.interconnection(l, a, &b, |w| {
            let decay = (-w * self.sample_time).exp();
            [decay, 1.0 - decay]
        })
    }

    /// Returns vehicle, actuators and filtered reference in continuous time, with the lags of the design.
    pub fn ideal(&self, l: &Linearisation) -> Interconnection {
        let has_lag = |actuator: &Actuator| self.design.lags && actuator.lag > 0.0;
        let (states, m) = (l.states.len(), self.actuators.len());
        let all = self.lagged(l, has_lag);
        let selected: Vec<usize> =
            (0..states).chain((0..m).filter(|j| has_lag(&self.actuators[*j])).map(|j| states + j)).collect();
        let mut b = Mat::zeros(states + m, m);
        for (j, actuator) in self.actuators.iter().enumerate() {
            if has_lag(actuator) {
                b[(states + j, j)] = 1.0 / actuator.lag
            } else {
                b.view_mut((0, j), (states, 1)).copy_from(&l.b.column(j))
            }
        }
        let (a, b) = (all.select_rows(&selected).select_columns(&selected), b.select_rows(&selected));
        if self.design.delay <= 0.0 {
            return self.interconnection(l, a, &b, |w| [-w, w]);
        }
        // The delayed commands are 2 p - u, with p' = 2/T (u - p).
        let rate = Mat::identity(m, m) * (2.0 / self.design.delay);
        let a = block(&[&[&a, &(&b * 2.0)], &[&Mat::zeros(m, a.ncols()), &-&rate]]);
        self.interconnection(l, a, &block(&[&[&-b], &[&rate]]), |w| [-w, w])
    }

    /// Returns the delay of the commands in ticks.
    pub(super) fn delay_ticks(&self) -> usize {
        (self.design.delay / self.sample_time).round() as usize
    }

    /// Lag of an actuator; if it has none, a lag much shorter than the sample time.
    fn lag(&self, actuator: &Actuator) -> f64 {
        actuator.lag.max(1e-3 * self.sample_time)
    }

    /// Matrix A of the vehicle states, then the actuators; an actuator without lag has a zero row and column.
    fn lagged(&self, l: &Linearisation, has_lag: impl Fn(&Actuator) -> bool) -> Mat {
        let (states, m) = (l.states.len(), self.actuators.len());
        let mut a = Mat::zeros(states + m, states + m);
        a.view_mut((0, 0), (states, states)).copy_from(&l.a);
        for (j, actuator) in self.actuators.iter().enumerate().filter(|(_, actuator)| has_lag(actuator)) {
            a.view_mut((0, states + j), (states, 1)).copy_from(&l.b.column(j));
            a[(states + j, states + j)] = -1.0 / self.lag(actuator);
        }
        a
    }

    /// Adds the trim that follows the speed reference, and the measurements. The state v of the reference filter has
    /// the derivative, or the next value, `pole v + gain r`.
    fn interconnection(
        &self,
        l: &Linearisation,
        a: Mat,
        b: &Mat,
        filter: impl Fn(f64) -> [f64; 2],
    ) -> Interconnection {
        let DesignFile { tracked, measured, .. } = self.design;
        let (n, p, q) = (a.nrows(), tracked.len(), measured.len());
        let slope = &l.trim_slope;
        let by_trim = b * slope.rows(l.states.len(), self.actuators.len());
        let by_trim = Mat::from_column_slice(n, 1, by_trim.as_slice());
        let reach = self.actuators.iter().map(Actuator::reach);
        let reach = Mat::from_diagonal(&DVector::from_iterator(b.ncols(), reach));
        let follows = self.design.tracked_speed();
        let speed = Mat::from_fn(1, p, |_, i| if Some(i) == follows { tracked[i].scale } else { 0.0 });
        let of_states = |c: Mat| block(&[&[&c, &Mat::zeros(c.nrows(), n - l.states.len())]]);
        let c = of_states(Tracked::scaled_outputs(tracked, l.states));
        let (one, zero) = (Mat::identity(p, p), Mat::zeros);
        let (y, references) = if measured.is_empty() {
            (-&c, one)
        } else {
            let y = of_states(Measured::scaled_outputs(measured, l.states));
            (block(&[&[&zero(p, n)], &[&y]]), block(&[&[&one], &[&zero(q, p)]]))
        };
        let fixed = Interconnection {
            a,
            b: b * reach,
            from_references: &by_trim * &speed,
            c,
            measured: y,
            references,
        };
        let Some(w) = self.design.reference_filter() else { return fixed };
        let [pole, gain] = filter(w);
        // Effect of the trim on each reference and measurement, in its scale.
        let moves = |(signal, scale): (&Signal, f64)| {
            -l.states.iter().zip(slope.iter()).map(|(state, x)| signal.output(state) * x).sum::<f64>() / scale
        };
        let all =
            tracked.iter().map(|t| (t.signal, t.scale)).chain(measured.iter().map(|m| (m.signal, m.scale)));
        let moves = Mat::from_iterator(p + q, 1, all.map(moves));
        Interconnection {
            a: block(&[&[&fixed.a, &by_trim], &[&zero(1, n), &Mat::from_element(1, 1, pole)]]),
            b: block(&[&[&fixed.b], &[&zero(1, fixed.b.ncols())]]),
            from_references: block(&[&[&zero(n, p)], &[&(speed * gain)]]),
            c: block(&[&[&fixed.c, &zero(p, 1)]]),
            measured: block(&[&[&fixed.measured, &moves]]),
            references: fixed.references,
        }
    }
}

/// Delays the inputs of a sampled system `[a b]` by `ticks` ticks; the states of the delay come last.
fn with_input_delay(a: Mat, b: Mat, ticks: usize) -> (Mat, Mat) {
    let m = b.ncols();
    (0..ticks).fold((a, b), |(a, b), _| {
        let rest = Mat::zeros(m, a.ncols());
        let enters = block(&[&[&Mat::zeros(a.nrows(), m)], &[&Mat::identity(m, m)]]);
        (block(&[&[&a, &b], &[&rest, &Mat::zeros(m, m)]]), enters)
    })
}

/// Returns `Dtt` of the discretised controller: `Dtt + Ct (I - A T/2)^-1 Bt T/2`; `None` if it has a mode at 2/T.
pub fn sampled_dtt(k: &squid_lpv::controller::Controller, sample_time: f64) -> Option<Mat> {
    let n = k.a().nrows();
    let inner = solve(&(Mat::identity(n, n) - &k.a() * (0.5 * sample_time)), &k.bt())?;
    Some(&k.dtt() + &k.ct() * inner * (0.5 * sample_time))
}

/// Discretises a controller by the trapezoidal rule with sample time T \[s\], like `squid_scheduled::Lft::discretise`
/// at a frozen parameter: `K_d(z) = K(2/T (z - 1)/(z + 1))`.
///
/// # Errors
/// [`CertifyError::ModeAtTwiceTheRate`].
pub fn trapezoidal(k: &StateSpace, sample_time: f64) -> Result<StateSpace, CertifyError> {
    let n = k.a.nrows();
    let half = &k.a * (0.5 * sample_time);
    let identity = Mat::identity(n, n);
    let p = solve(&(&identity - &half), &identity).ok_or(CertifyError::ModeAtTwiceTheRate)?;
    Ok(StateSpace {
        a: &p * (&identity + &half),
        b: &p * &k.b * sample_time,
        c: &k.c * &p,
        d: &k.d + &k.c * &p * &k.b * (0.5 * sample_time),
    })
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::augment::{LinearModel, augment};
    use crate::axis::VehicleModel;
    use crate::inputs::design_file::relative_weight::RelativeWeight;
    use crate::inputs::tests::shipped;
    use nalgebra::Complex;
    use squid_auv::longitudinal::PITCH;
    use squid_lpv::controller::Controller;
    use squid_lpv::partition::Group::{U, X, Y};

    /// Matrix of arbitrary numbers below 0.3 in magnitude.
    pub(crate) fn arbitrary(rows: usize, columns: usize, seed: f64) -> Mat {
        Mat::from_fn(rows, columns, |i, j| 0.3 * (seed + 1.7 * i as f64 + 2.9 * j as f64).sin())
    }

    /// The generalised plant has deviations from a moving trim, the flown controller has deviations from a fixed one;
    /// both describe the same loop: `z = [W_e (T_ref R r - C x); W_u u]`.
    #[test]
    fn plant_of_design_is_flown_loop() {
        for (name, design, speed, delay) in [
            ("squid", "design", 0.7, 0.0),
            ("squid", "design", 2.6, 0.04),
            ("remus100", "pitch", 1.6, 0.1),
            ("squid", "paper", 1.0, 0.0),
            ("squid", "paper", 1.0, 0.1),
        ] {
            let mut inputs = shipped(name, design);
            inputs.design.delay = delay;
            let actuator = inputs.vehicle.actuators[0].name.clone();
            inputs.design.relative_weights = vec![RelativeWeight { actuator, factor: 3.0, line: 0 }];
            let (actuators, file) = (&inputs.vehicle.actuators, &inputs.design);
            let l = inputs.axis().linearise(speed).unwrap();
            let (p, m, y) = (file.tracked.len(), actuators.len(), file.tracked.len() + file.measured.len());
            let parts = [
                (X, X, arbitrary(3, 3, 0.0) - Mat::identity(3, 3)),
                (X, Y, arbitrary(3, y, 1.0)),
                (U, X, arbitrary(m, 3, 2.0)),
                (U, Y, arbitrary(m, y, 3.0)),
            ];
            let k = Controller::new(vec![], &parts).unwrap();
            let plant = augment(actuators, file, LinearModel::at(&l, file)).unwrap();
            let designed = plant.close(&k).frozen(&[]).unwrap();
            let flown = Sampling::of(actuators, file).ideal(&l).closed(&k.frozen(&[]).unwrap());
            let slope = &l.trim_slope;
            let pitch = file.tracked.iter().position(|t| t.index == PITCH).unwrap();
            for omega in [0.01, 0.3, 2.0, 20.0] {
                let s = Complex::new(0.0, omega);
                let (z, t) = (designed.response(s).unwrap(), flown.response(s).unwrap());
                for j in 0..p {
                    let models: Vec<_> = file
                        .tracked
                        .iter()
                        .map(|t| t.model.map_or(Complex::new(1.0, 0.0), |model| model.response(omega)))
                        .collect();
                    // Effect of the speed reference on the trimmed pitch, relative to which the plant has its pitch
                    // reference.
                    let moves = Some(j) == file.tracked_speed() && file.reference_filter().is_some();
                    let moved = if moves {
                        models[j] * (slope[3] * file.tracked[j].scale / file.tracked[pitch].scale)
                    } else {
                        Complex::new(0.0, 0.0)
                    };
                    let column = |i: usize, j: usize| z[(i, j)] / file.tracked[j].references.response(omega);
                    let from_plant = |i: usize| column(i, j) - column(i, pitch) * moved;
                    for (i, tracked) in file.tracked.iter().enumerate() {
                        let relative = if i == pitch { moved } else { Complex::new(0.0, 0.0) };
                        let reference = if i == j { Complex::new(1.0, 0.0) } else { -relative };
                        let error = models[i] * reference - (t[(i, j)] - relative);
                        let weight = &tracked.weight;
                        let expected = error * (s / weight.peak + weight.bandwidth)
                            / (s + weight.bandwidth * weight.steady_error);
                        let difference = (from_plant(i) - expected).norm();
                        assert!(
                            difference < 1e-9 * expected.norm().max(1.0),
                            "{name} {design} {omega} {i} {j}"
                        );
                    }
                    for i in 0..m {
                        let (found, u) = (from_plant(p + i).norm(), t[(p + i, j)].norm());
                        let expected = file.weight_on(&inputs.vehicle.actuators[i].name).gain(omega) * u;
                        assert!(
                            (found - expected).abs() < 1e-9 * expected.max(1.0),
                            "{name} {design} {omega}"
                        );
                    }
                }
            }
        }
    }

    /// The sampled loop approximates the continuous one with all lags if the sample time is short.
    #[test]
    fn fast_sampled_loop_approximates_continuous_loop() {
        let mut inputs = shipped("squid", "design");
        inputs.design.delay = 5e-4;
        let (actuators, file) = (&inputs.vehicle.actuators, &inputs.design);
        let l = inputs.axis().linearise(1.3).unwrap();
        let y = file.tracked.len() + file.measured.len();
        let gain = StateSpace {
            a: Mat::zeros(0, 0),
            b: Mat::zeros(0, y),
            c: Mat::zeros(actuators.len(), 0),
            d: arbitrary(actuators.len(), y, 4.0),
        };
        let fast = Sampling { sample_time: 1e-5, ..Sampling::of(actuators, file) };
        let (sampled, continuous) = (fast.held(&l).closed(&gain), fast.ideal(&l).closed(&gain));
        for omega in [0.05, 0.5, 5.0] {
            let at = |s: &StateSpace, point| s.response(point).unwrap();
            let found = at(&sampled, Complex::from_polar(1.0, omega * 1e-5));
            let expected = at(&continuous, Complex::new(0.0, omega));
            assert!((&found - &expected).norm() < 1e-3 * expected.norm(), "{omega}: {found} {expected}");
        }
    }
}
