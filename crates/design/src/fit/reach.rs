//! Controllability by the actuators and observability from the measurements, at each speed of the range, of every
//! motion of the vehicle that is not asymptotically stable.
//!
//! Otherwise there is no controller, whatever the requirements. The test is that of [`squid_lpv::system::modes`]; this
//! module also names the motion, and the missing actuator or measurement.

use crate::axis::Linearisation;
use crate::error::ModelError;
use crate::fit::Model;
use crate::inputs::design_file::{DesignFile, scaled_outputs};
use crate::linearise::{scaled, split, stacked};
use nalgebra::Complex;
use squid_auv::Actuator;
use squid_lpv::matrix::Mat;
use squid_lpv::system::modes::unreachable_mode;
use squid_signals::State;

/// Checks every linearisation of a model.
///
/// # Errors
/// [`ModelError::Uncontrollable`], [`ModelError::Unobservable`], with the speed and the motion.
pub fn check(actuators: &[Actuator], file: &DesignFile, model: &Model) -> Result<(), ModelError> {
    let outputs = scaled_outputs(file.fed_back(), file.states);
    for (_, l) in &model.grid {
        let (a, b) = scaled_system(actuators, l);
        let speed = l.trim.speed;
        if let Some(mode) = unreachable_mode(&a, &b) {
            let State { name, actuation_hint, .. } = file.states[dominant_state(&a, &b, mode)];
            return Err(ModelError::Uncontrollable { speed, motion: name, actuation_hint });
        }
        let (a, c) = (a.transpose(), outputs.transpose());
        if let Some(mode) = unreachable_mode(&a, &c) {
            let State { name, measurement_hint, .. } = file.states[dominant_state(&a, &c, mode)];
            return Err(ModelError::Unobservable { speed, motion: name, measurement_hint });
        }
    }
    Ok(())
}

/// Matrices A, and B with inputs in units of their reach.
fn scaled_system(actuators: &[Actuator], l: &Linearisation) -> (Mat, Mat) {
    split(&scaled(actuators, stacked(&l.a, &l.b)))
}

/// Dominant state of a mode that is not controllable through B: the largest entry of the left singular vector x of the
/// smallest singular value of `[A - mode I, B]`, for which `x* [A - mode I, B] = 0`.
fn dominant_state(a: &Mat, b: &Mat, mode: Complex<f64>) -> usize {
    let n = a.nrows();
    let pencil = nalgebra::DMatrix::from_fn(n, n + b.ncols(), |i, j| {
        let entry = if j < n { a[(i, j)] } else { b[(i, j - n)] };
        Complex::new(entry, 0.0) - if i == j { mode } else { Complex::new(0.0, 0.0) }
    });
    let svd = pencil.svd(true, false);
    let least = svd.singular_values.imin();
    svd.u.map_or(0, |u| u.column(least).map(|entry| entry.norm()).imax())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inputs::Inputs;
    use crate::inputs::tests::shipped;

    fn squid() -> (Inputs, Model) {
        let inputs = shipped("squid", "design");
        let model = Model::new(&inputs.axis(), &inputs.design).unwrap();
        (inputs, model)
    }

    /// Error message for a model whose linearisation is changed at the fourth speed.
    fn refusal((inputs, model): &(Inputs, Model), change: impl Fn(&mut Linearisation)) -> String {
        let mut model = model.clone();
        change(&mut model.grid[3].1);
        check(&inputs.vehicle.actuators, &inputs.design, &model).unwrap_err().to_string()
    }

    #[test]
    fn names_uncontrollable_motion_and_speed() {
        let squid = squid();
        assert!(check(&squid.0.vehicle.actuators, &squid.0.design, &squid.1).is_ok());
        let speed = squid.1.grid[3].1.trim.speed;
        for (state, motion) in squid.0.design.states.iter().enumerate() {
            let found = refusal(&squid, |l| {
                l.a.row_mut(state).fill(0.0);
                l.b.row_mut(state).fill(0.0);
            });
            let expected = ModelError::Uncontrollable {
                speed,
                motion: motion.name,
                actuation_hint: motion.actuation_hint,
            }
            .to_string();
            assert_eq!(found, expected);
        }
    }

    /// Pitch, speed and pitch rate do not observe a constant heave that has no effect on the other states.
    #[test]
    fn names_unobservable_motion_and_speed() {
        let squid = squid();
        let found = refusal(&squid, |l| l.a.column_mut(1).fill(0.0));
        let (speed, State { name, measurement_hint, .. }) =
            (squid.1.grid[3].1.trim.speed, squid.0.design.states[1]);
        assert_eq!(found, ModelError::Unobservable { speed, motion: name, measurement_hint }.to_string());
    }
}
