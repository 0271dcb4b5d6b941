//! Errors of the fits against the true linearisations as frequency responses (the paper's Fig. 4).

use crate::fit::Model;
use crate::inputs::design_file::Tracked;
use crate::linearise::{split, stacked};
use nalgebra::{Complex, DMatrix};
use squid_auv::Actuator;
use squid_auv::View;
use squid_auv::longitudinal::{SIGNALS, SPEED, turn_rate};
use squid_lpv::matrix::{Mat, largest_complex_singular_value as largest};
use squid_lpv::polynomial::MatrixPolynomial;
use squid_lpv::state_space::StateSpace;
use squid_signals::{Signal, States};

/// Returns 61 frequencies from 0.01 to 10 rad/s, evenly spaced on a logarithmic axis.
pub fn axis() -> Vec<f64> {
    (0..=60).map(|i| 10f64.powf(-2.0 + f64::from(i) / 20.0)).collect()
}

/// Returns the system `[A B]` from the actuators to [`outputs`], in SI units.
pub fn system(ab: &Mat, states: States) -> StateSpace {
    let outputs = outputs(states);
    to(ab, Mat::from_fn(outputs.len(), states.len(), |i, j| outputs[i].output(&states[j])))
}

/// System `[A B]` from the actuators to the outputs C x.
fn to(ab: &Mat, c: Mat) -> StateSpace {
    let (a, b) = split(ab);
    let d = Mat::zeros(c.nrows(), b.ncols());
    StateSpace { a, b, c, d }
}

/// Returns the outputs of [`system`]: speed and pitch, heading, or roll; the angle last.
pub fn outputs(states: States) -> Vec<&'static Signal> {
    let view = View::of_states(states);
    if view.is_level_held { vec![angle(states)] } else { vec![&SIGNALS[SPEED], angle(states)] }
}

/// Returns the angle of [`outputs`], the first signal of its view.
pub fn angle(states: States) -> &'static Signal {
    &View::of_states(states).interface.signals[0]
}

/// Largest errors of the fit of one order over the speeds of the grid and the frequencies.
#[derive(Debug, Clone, PartialEq)]
pub struct Errors {
    /// Order of the fit.
    pub order: usize,
    /// Error `|G_fit - G| / |G|` in the largest singular value, from all actuators in units of their reach to the
    /// tracked outputs in units of their scales.
    pub scaled: f64,
    /// Error `|g_fit - g| / |g|` from each actuator (columns) to each of [`outputs`] (rows); NaN for an actuator
    /// without effect on the output.
    pub channels: Mat,
}

impl Errors {
    /// Returns the error from an actuator to the [`angle`].
    pub fn of_angle(&self, actuator: usize) -> f64 {
        self.channels[(self.channels.nrows() - 1, actuator)]
    }
}

/// Returns the actuator with the largest effect on the [`angle`], at its reach, at the lowest speed of the model.
pub fn turning_actuator(actuators: &[Actuator], model: &Model) -> usize {
    let effect = |j: usize| {
        model.grid.first().map_or(0.0, |(_, l)| l.b[(turn_rate(l.states), j)].abs() * actuators[j].reach())
    };
    let most = (0..actuators.len()).max_by(|i, j| effect(*i).total_cmp(&effect(*j)).then(j.cmp(i)));
    most.unwrap_or(0)
}

/// Computes the errors for each order of the model's residuals.
pub fn errors(actuators: &[Actuator], tracked: &[Tracked], model: &Model) -> Vec<Errors> {
    let samples: Vec<(f64, Mat)> = model.grid.iter().map(|(rho, l)| (*rho, stacked(&l.a, &l.b))).collect();
    let fits = model
        .residuals
        .iter()
        .filter_map(|r| Some((r.order, MatrixPolynomial::fit(&samples, r.order).ok()?)));
    let Some((_, first)) = model.grid.first() else { return vec![] };
    fits.map(|(order, fit)| errors_of(actuators, tracked, order, &samples, first.states, &fit)).collect()
}

fn errors_of(
    actuators: &[Actuator],
    tracked: &[Tracked],
    order: usize,
    samples: &[(f64, Mat)],
    states: States,
    fit: &MatrixPolynomial,
) -> Errors {
    let reach: Vec<f64> = actuators.iter().map(Actuator::reach).collect();
    let outputs = Tracked::scaled_outputs(tracked, states);
    let scaled =
        |g: &DMatrix<Complex<f64>>| DMatrix::from_fn(g.nrows(), reach.len(), |i, j| g[(i, j)] * reach[j]);
    let mut errors = Errors {
        order,
        scaled: 0.0,
        channels: Mat::zeros(crate::fit::frequency::outputs(states).len(), reach.len()),
    };
    for (rho, truth) in samples {
        let fitted = fit.evaluate(*rho);
        let channels = (system(truth, states), system(&fitted, states));
        let tracked = (to(truth, outputs.clone()), to(&fitted, outputs.clone()));
        for omega in axis() {
            let s = Complex::new(0.0, omega);
            let (Some(g), Some(h)) = (tracked.0.response(s), tracked.1.response(s)) else { continue };
            errors.scaled = errors.scaled.max(largest(&scaled(&(&h - &g))) / largest(&scaled(&g)));
            let (Some(g), Some(h)) = (channels.0.response(s), channels.1.response(s)) else { continue };
            for (i, worst) in errors.channels.iter_mut().enumerate() {
                let error = (h[i] - g[i]).norm() / g[i].norm();
                *worst = if worst.is_nan() || error.is_nan() { f64::NAN } else { worst.max(error) };
            }
        }
    }
    errors
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inputs::Inputs;
    use crate::inputs::tests::shipped;
    use squid_auv::longitudinal::PITCH;

    /// The scales of the design change only the scaled error, not the errors of the channels. The channel of the
    /// paper's Fig. 4 has a much larger error than speed and pitch together in SI units, where speed dominates.
    #[test]
    fn errors_are_by_channel_and_in_the_scales_of_the_design() {
        let mut inputs = shipped("squid", "design");
        let model = Model::new(&inputs.axis(), &inputs.design).unwrap();
        let at = |inputs: &Inputs| {
            errors(&inputs.vehicle.actuators, &inputs.design.tracked, &model)
                .into_iter()
                .find(|e| e.order == 2)
                .unwrap()
        };
        let first = at(&inputs);
        let pitch = first.of_angle(turning_actuator(&inputs.vehicle.actuators, &model));
        assert!((pitch - 0.067).abs() < 0.003, "{pitch}");
        for track in &mut inputs.design.tracked {
            track.scale *= if track.index == PITCH { 1e-6 } else { 1.0 };
        }
        let second = at(&inputs);
        assert_eq!(first.channels, second.channels);
        // Pitch dominates in units of so small a scale.
        assert!(
            second.scaled > 2.0 * first.scaled || first.scaled > 0.02,
            "{} {}",
            first.scaled,
            second.scaled
        );
        assert!((second.scaled - first.scaled).abs() > 1e-4);
    }
}
