//! Linearisation about a trim, by dual numbers: exact derivatives of the code that simulates.

use crate::states::{LONGITUDINAL as STATES, are_lateral, turning};
use nalgebra::{Complex, DMatrix, DVector};
use num_dual::Dual64;
use squid_signals::States;

use crate::motion::balance::reaches_all;
use crate::motion::descriptor::Descriptor;
use crate::motion::dynamics::{Dynamics, Motion, actuator_force};
use crate::motion::level::{Pitch, Speed};
use crate::motion::trim::{Trim, trim_with};
use crate::vehicle::Vehicle;
use crate::vehicle::actuator::Actuator;
use crate::vehicle::coefficients::CoefficientError;

/// The linear motion about a trim: `x' = A (x - x0) + B (T - T0)`.
///
/// The state is x = \[u w q theta\] (m/s, m/s, rad/s, rad), or \[w q theta\] at a speed that is given, and behind them
/// the depth z (m) where it is asked for, `z' = w cos(theta) - u sin(theta)`; the inputs T are the outputs of the
/// actuators (N or rad), without their lag. Shapes for n states: A n x n, B n x m. The states may as well be those of
/// [`lateral`](crate::lateral), \[v r psi\] with or without \[p phi\].
#[derive(Clone, Debug)]
pub struct Linearisation {
    /// State matrix, n x n.
    pub a: DMatrix<f64>,
    /// Input matrix, n x m.
    pub b: DMatrix<f64>,
    /// The states.
    pub states: States,
    /// The trim.
    pub trim: Trim,
    /// What waves add to x', n x 2, in s^-1 times the units of x per metre of elevation: for its part above the
    /// vehicle, and for that of a quarter of a period ago. `None` in still water; see [`Linearisation::in_waves`].
    pub by_waves: Option<DMatrix<f64>>,
    /// The slope of the trim where the actuators alone could balance it at any pitch, so that least effort chooses the
    /// pitch; see [`Linearisation::trim_slope`].
    chosen_slope: Option<DVector<f64>>,
    /// The derivative of x' by a speed that is given.
    by_given: Option<DVector<f64>>,
}

impl Linearisation {
    /// Returns the eigenvalues of A \[1/s\], in rising order of the real part.
    pub fn eigenvalues(&self) -> Vec<Complex<f64>> {
        let mut values: Vec<_> = self.a.complex_eigenvalues().iter().copied().collect();
        values.sort_by(|a, b| a.re.total_cmp(&b.re).then(a.im.total_cmp(&b.im)));
        values
    }

    /// Returns how states and actuators change in trim with the forward speed: `[x0'; u0']`, n + m, per m/s.
    ///
    /// With x0 = \[u, u tan(alpha), 0, alpha\] it solves `A x0' + B u0' = 0`, the derivative of the equations of trim;
    /// that by a given speed is added.
    /// Where several u0' do, it is the least in units of reach; the others differ by what moves nothing. Where least
    /// effort chooses the pitch, it is a central difference of trims.
    #[must_use]
    pub fn trim_slope(&self, actuators: &[Actuator]) -> DVector<f64> {
        if let Some(slope) = &self.chosen_slope {
            return slope.clone();
        }
        let (tan, u) = (self.trim.incidence.tan(), self.trim.forward_speed);
        // x0' = ahead + turned alpha'.
        let n = self.a.nrows();
        let first = 1 - turning(self.states)[0];
        let own = |x: [f64; STATES.len()]| DVector::from_column_slice(&x[first..first + n]);
        let ahead = own([1.0, tan, 0.0, 0.0, 0.0]);
        let turned = own([0.0, u * (1.0 + tan * tan), 0.0, 1.0, 0.0]);
        let reach = DMatrix::from_diagonal(&DVector::from_iterator(
            actuators.len(),
            actuators.iter().map(Actuator::reach),
        ));
        let (missing, by_turning, by_actuators) = (&self.a * &ahead, &self.a * &turned, &self.b * &reach);
        let missing = self.by_given.iter().fold(missing, |sum, column| sum + column);
        // What turning alone can do is left to it; a pitch that is held, or changes nothing, does not turn.
        let size = by_turning.norm();
        let turns = size > 0.0 && !matches!(self.trim.rule, Pitch::Held(_));
        let direction = if turns { by_turning.normalize() } else { DVector::zeros(n) };
        let rest = |m: DMatrix<f64>| &m - &direction * (direction.transpose() * &m);
        let svd = rest(by_actuators.clone()).svd(true, true);
        let largest = svd.singular_values.iter().copied().fold(0.0, f64::max);
        let wanted = -rest(DMatrix::from_column_slice(n, 1, missing.as_slice()));
        let outputs =
            svd.solve(&wanted, RANK_TOLERANCE * largest).unwrap_or_else(|_| DMatrix::zeros(reach.nrows(), 1));
        let turn =
            if turns { -direction.dot(&(missing + (by_actuators * &outputs).column(0))) / size } else { 0.0 };
        let (states, outputs) = (ahead + turned * turn, reach * outputs);
        DVector::from_iterator(n + outputs.len(), states.iter().chain(outputs.iter()).copied())
    }
}

/// Singular values below this part of the largest one count as zero.
const RANK_TOLERANCE: f64 = 1e-9;

/// A step of the speed for a central difference \[m/s\]: its error is of the order of the square.
const STEP: f64 = 1e-4;

/// By how much limits of actuators are widened, so that a trim at a limit has neighbours.
const WIDENED: f64 = 2.0;

/// Whether the actuators reach surge, heave and pitch by themselves, as far as these are states, while the pitch is
/// free.
fn is_redundant(vehicle: &Vehicle, trim: &Trim, b: &DMatrix<f64>) -> bool {
    let reach = vehicle.actuators.iter().map(Actuator::reach);
    let equations = 3 - vehicle.coefficients.surge.first();
    let scaled = b.rows(0, equations) * DMatrix::from_diagonal(&DVector::from_iterator(b.ncols(), reach));
    !matches!(trim.rule, Pitch::Held(_)) && reaches_all(&scaled, equations)
}

/// The slope of the trim from its neighbours on the same branch, `[x0'; u0']` per m/s of forward speed.
fn difference(vehicle: &Vehicle, trim: &Trim, states: usize) -> Option<DVector<f64>> {
    let mut free = vehicle.clone();
    for actuator in &mut free.actuators {
        (actuator.min, actuator.max) = (WIDENED * actuator.min, WIDENED * actuator.max);
    }
    let here = Pitch::Followed([(trim.speed, trim.pitch)].into_iter().collect());
    let beside = |step: f64| trim_with(&free, Speed::Path(trim.speed + step), trim.depth, &here).ok();
    let values = |t: &Trim| {
        let all = [t.forward_speed, t.heave, 0.0, t.pitch, t.depth];
        let own = all.iter().skip(vehicle.coefficients.surge.first()).take(states);
        DVector::from_iterator(states + t.actuators.len(), own.chain(&t.actuators).copied())
    };
    let (before, after) = (beside(-STEP)?, beside(STEP)?);
    Some((values(&after) - values(&before)) / (after.forward_speed - before.forward_speed))
}

/// Linearises the equations of motion about a trim, at the trim's depth, without the depth as a state.
///
/// # Errors
/// As [`linearise_with`].
pub fn linearise(vehicle: &Vehicle, trim: &Trim) -> Result<Linearisation, CoefficientError> {
    linearise_with(vehicle, trim, vehicle.coefficients.surge.states(false))
}

/// The same with some states, one after the other in [`longitudinal::STATES`](STATES) or in
/// [`lateral::STATES`](crate::lateral::STATES); what is no state does not move.
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
        let column = [du.eps, dw.eps, dq.eps, motion.q.eps, motion.sinking().eps];
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

/// Sway, roll and yaw, whose trim is zero at every speed. The mass matrix is positive definite.
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
