//! Linearisation about a trim, by dual numbers: exact derivatives of the simulation code.

use crate::states::{LONGITUDINAL as STATES, are_lateral, turning};
use nalgebra::{Complex, DMatrix, DVector};
use num_dual::Dual64;
use squid_signals::States;

use crate::motion::balance::span_all_equations;
use crate::motion::descriptor::Descriptor;
use crate::motion::dynamics::{Dynamics, Motion, actuator_force};
use crate::motion::level::{Pitch, Speed};
use crate::motion::trim::{Trim, trim_with};
use crate::vehicle::Vehicle;
use crate::vehicle::actuator::Actuator;
use crate::vehicle::coefficients::CoefficientError;

/// Linear motion about a trim: `x' = A (x - x0) + B (T - T0)`.
///
/// The state is x = \[u w q theta\] (m/s, m/s, rad/s, rad), or \[w q theta\] for a given speed, followed by the depth z
/// (m) if requested, `z' = w cos(theta) - u sin(theta)`; the inputs T are the outputs of the actuators (N or rad),
/// without their lag. Shapes for n states: A n x n, B n x m. The states may also be those of
/// [`lateral`](crate::lateral), \[v r psi\] with or without \[p phi\].
#[derive(Clone, Debug)]
pub struct Linearisation {
    /// State matrix, n x n.
    pub a: DMatrix<f64>,
    /// Input matrix, n x m.
    pub b: DMatrix<f64>,
    /// States.
    pub states: States,
    /// Trim.
    pub trim: Trim,
    /// Effect of waves on x', n x 2, in s^-1 times the units of x per metre of elevation: for the present elevation
    /// above the vehicle, and for its quadrature component, a quarter of a period earlier. `None` in still water; see
    /// [`Linearisation::in_waves`].
    pub by_waves: Option<DMatrix<f64>>,
    /// Slope of the trim if the actuators alone could balance it at any pitch, so that least effort determines the
    /// pitch; see [`Linearisation::trim_slope`].
    chosen_slope: Option<DVector<f64>>,
    /// Derivative of x' with respect to a given speed.
    by_given: Option<DVector<f64>>,
}

impl Linearisation {
    /// Returns the eigenvalues of A \[1/s\], by increasing real part.
    pub fn eigenvalues(&self) -> Vec<Complex<f64>> {
        let mut values: Vec<_> = self.a.complex_eigenvalues().iter().copied().collect();
        values.sort_by(|a, b| a.re.total_cmp(&b.re).then(a.im.total_cmp(&b.im)));
        values
    }

    /// Returns the derivatives of states and outputs in trim with respect to the forward speed: `[x0'; u0']`, n + m,
    /// per m/s.
    ///
    /// With x0 = \[u, u tan(alpha), 0, alpha\] it solves `A x0' + B u0' = 0`, the derivative of the trim equations,
    /// plus that with respect to a given speed. If several u0' solve it, the one of least norm in units of reach is
    /// returned. If least effort determines the pitch, it is a central difference of trims.
    #[must_use]
    pub fn trim_slope(&self, actuators: &[Actuator]) -> DVector<f64> {
        if let Some(slope) = &self.chosen_slope {
            return slope.clone();
        }
        let (tan, u) = (self.trim.incidence.tan(), self.trim.forward_speed);
        // x0' = ahead + by_incidence alpha'.
        let n = self.a.nrows();
        let first = 1 - turning(self.states)[0];
        let selected = |x: [f64; STATES.len()]| DVector::from_column_slice(&x[first..first + n]);
        let ahead = selected([1.0, tan, 0.0, 0.0, 0.0]);
        let by_incidence = selected([0.0, u * (1.0 + tan * tan), 0.0, 1.0, 0.0]);
        let reach = DMatrix::from_diagonal(&DVector::from_iterator(
            actuators.len(),
            actuators.iter().map(Actuator::reach),
        ));
        let (imbalance, by_incidence_states, by_actuators) =
            (&self.a * &ahead, &self.a * &by_incidence, &self.b * &reach);
        let imbalance = self.by_given.iter().fold(imbalance, |sum, column| sum + column);
        // The incidence balances its own direction; a held or ineffective incidence does not change.
        let size = by_incidence_states.norm();
        let turns = size > 0.0 && !matches!(self.trim.rule, Pitch::Held(_));
        let direction = if turns { by_incidence_states.normalize() } else { DVector::zeros(n) };
        let rest = |m: DMatrix<f64>| &m - &direction * (direction.transpose() * &m);
        let svd = rest(by_actuators.clone()).svd(true, true);
        let largest = svd.singular_values.iter().copied().fold(0.0, f64::max);
        let target = -rest(DMatrix::from_column_slice(n, 1, imbalance.as_slice()));
        let outputs =
            svd.solve(&target, RANK_TOLERANCE * largest).unwrap_or_else(|_| DMatrix::zeros(reach.nrows(), 1));
        let turn = if turns {
            -direction.dot(&(imbalance + (by_actuators * &outputs).column(0))) / size
        } else {
            0.0
        };
        let (states, outputs) = (ahead + by_incidence * turn, reach * outputs);
        DVector::from_iterator(n + outputs.len(), states.iter().chain(outputs.iter()).copied())
    }
}

/// Singular values below this fraction of the largest one count as zero.
const RANK_TOLERANCE: f64 = 1e-9;

/// Step of the speed for a central difference \[m/s\], whose error is quadratic in it.
const STEP: f64 = 1e-4;

/// Factor by which actuator limits are widened, so that a trim at a limit has neighbours.
const WIDENING: f64 = 2.0;

/// Returns `true` if the pitch is free and the actuators alone control surge, heave and pitch, as far as these are
/// states.
fn is_redundant(vehicle: &Vehicle, trim: &Trim, b: &DMatrix<f64>) -> bool {
    let reach = vehicle.actuators.iter().map(Actuator::reach);
    let equations = 3 - vehicle.coefficients.surge.first();
    let scaled = b.rows(0, equations) * DMatrix::from_diagonal(&DVector::from_iterator(b.ncols(), reach));
    !matches!(trim.rule, Pitch::Held(_)) && span_all_equations(&scaled, equations)
}

/// Returns the slope of the trim from its neighbours on the same branch, `[x0'; u0']` per m/s of forward speed.
fn difference(vehicle: &Vehicle, trim: &Trim, states: usize) -> Option<DVector<f64>> {
    let mut free = vehicle.clone();
    for actuator in &mut free.actuators {
        (actuator.min, actuator.max) = (WIDENING * actuator.min, WIDENING * actuator.max);
    }
    let here = Pitch::Followed([(trim.speed, trim.pitch)].into_iter().collect());
    let neighbour = |step: f64| trim_with(&free, Speed::Path(trim.speed + step), trim.depth, &here).ok();
    let values = |t: &Trim| {
        let all = [t.forward_speed, t.heave, 0.0, t.pitch, t.depth];
        let selected = all.iter().skip(vehicle.coefficients.surge.first()).take(states);
        DVector::from_iterator(states + t.actuators.len(), selected.chain(&t.actuators).copied())
    };
    let (before, after) = (neighbour(-STEP)?, neighbour(STEP)?);
    Some((values(&after) - values(&before)) / (after.forward_speed - before.forward_speed))
}

/// Linearises the equations of motion about a trim, at its depth, without the depth as a state.
///
/// # Errors
/// Errors of [`linearise_with`].
pub fn linearise(vehicle: &Vehicle, trim: &Trim) -> Result<Linearisation, CoefficientError> {
    linearise_with(vehicle, trim, vehicle.coefficients.surge.states(false))
}

/// Linearises with a selection of states, contiguous in [`longitudinal::STATES`](STATES) or in
/// [`lateral::STATES`](crate::lateral::STATES); all other states are held at trim.
///
/// # Errors
/// [`CoefficientError`] if the vehicle's coefficients are not allowed.
pub fn linearise_with(
    vehicle: &Vehicle,
    trim: &Trim,
    states: States,
) -> Result<Linearisation, CoefficientError> {
    let dynamics = Dynamics::new(&vehicle.coefficients)?.lifted();
    if are_lateral(states) {
        return Ok(lateral(vehicle, trim, states));
    }
    let inputs = vehicle.actuators.len();
    let all = STATES.len();
    let mut jacobian = DMatrix::zeros(all, all + inputs);
    for seed in 0..all + inputs {
        let part = |i: usize, value: f64| Dual64::new(value, if i == seed { 1.0 } else { 0.0 });
        let Motion { u, w, q, theta, .. } = trim.motion();
        let motion = Motion::in_plane(part(0, u), part(1, w), part(2, q), part(3, theta));
        let outputs = trim.actuators.iter().enumerate().map(|(i, &output)| part(all + i, output));
        let force = actuator_force(&vehicle.actuators, motion.u, outputs);
        let [du, dw, dq] = dynamics.acceleration(&motion, part(4, trim.depth), force);
        let column = [du.eps, dw.eps, dq.eps, motion.q.eps, motion.depth_rate().eps];
        (0..all).for_each(|i| jacobian[(i, seed)] = column[i]);
    }
    let surge = vehicle.coefficients.surge;
    let (first, n) = (surge.first(), states.len());
    let a = jacobian.view((first, first), (n, n)).into_owned();
    let b = jacobian.view((first, all), (n, inputs)).into_owned();
    let by_given = surge.is_given().then(|| jacobian.column(0).rows(first, n).into_owned());
    let chosen_slope = is_redundant(vehicle, trim, &b).then(|| difference(vehicle, trim, n)).flatten();
    Ok(Linearisation { a, b, states, trim: trim.clone(), by_waves: None, chosen_slope, by_given })
}

/// Returns the model in sway, roll and yaw, whose trim is zero at every speed. The mass matrix is positive definite.
fn lateral(vehicle: &Vehicle, trim: &Trim, states: States) -> Linearisation {
    let Descriptor { mass, state, input } = Descriptor::at(vehicle, trim, states);
    let (n, inputs) = input.shape();
    let inverse = mass.try_inverse().unwrap_or_else(|| DMatrix::zeros(n, n));
    Linearisation {
        a: &inverse * state,
        b: inverse * input,
        states,
        trim: trim.clone(),
        by_waves: None,
        chosen_slope: Some(DVector::zeros(n + inputs)),
        by_given: None,
    }
}
