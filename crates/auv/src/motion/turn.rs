//! Steady turns at constant depth, and the linear motion about them.
//!
//! In a steady turn with the heading rate Omega the angular velocity of the body is
//!
//! ```text
//! p = -Omega sin(theta)   q = Omega cos(theta) sin(phi)   r = Omega cos(theta) cos(phi)
//! ```
//!
//! The unknowns are u, v, w, phi, theta and the outputs of the actuators; the equations are `u' = v' = w' = 0`, `p' =
//! q' = r' = 0`, `z' = 0` and `u^2 + v^2 + w^2 = V^2`.

use nalgebra::{DMatrix, DVector};
use num_dual::Dual64;

use crate::motion::dynamics::{Dynamics, Motion, actuator_force, lateral_actuator_force};
use crate::motion::level::{Pitch, Speed};
use crate::motion::trim::trim_with;
use crate::motion::trim_error::TrimError;
use crate::scalar::Scalar;
use crate::vehicle::Vehicle;
use crate::vehicle::actuator::Actuator;

/// Steady turn at constant depth; straight flight if its rate is 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Turn {
    /// Motion through the water.
    pub motion: Motion,
    /// Speed along the path through the water, V \[m/s\].
    pub speed: f64,
    /// Rate of the heading \[rad/s\], positive to starboard.
    pub rate: f64,
    /// Depth \[m\].
    pub depth: f64,
    /// Output of each actuator \[N or rad\], without regard to its limits.
    pub actuators: Vec<f64>,
    /// Largest remaining acceleration \[m/s2 or rad/s2\], or z' \[m/s\].
    pub residual: f64,
}

impl Turn {
    /// Returns the radius of the path \[m\]; infinite for straight flight.
    pub fn radius(&self) -> f64 {
        self.speed / self.rate.abs()
    }
}

/// Largest step in which the rate is raised to that of a turn \[rad/s\].
const RATE_STEP: f64 = 0.05;
const MAX_ITERATIONS: usize = 50;
/// Convergence tolerance of Newton's method for the accelerations.
const RESIDUAL_TOLERANCE: f64 = 1e-9;
/// Singular values below this fraction of the largest one count as zero.
const RANK_TOLERANCE: f64 = 1e-9;
/// Number of the states u, v, w, phi, theta.
const STATES: usize = 5;
const EQUATIONS: usize = 8;

/// Returns the steady turn at a speed V \[m/s\] along the path, a rate of the heading \[rad/s\] and a depth \[m\],
/// continued from straight level trim. A held pitch is also held in the turn if the outputs can do so. Among several
/// solutions it is one near the trim. If an actuator yaws the vehicle without acting in the vertical plane, the other
/// actuators do not work against one another for the turn: they change only as far as the vertical plane requires.
///
/// # Errors
/// [`TrimError`]: those of [`trim_with`]; no such turn; a vehicle that stays in the vertical plane.
pub fn turn(vehicle: &Vehicle, speed: f64, rate: f64, depth: f64, pitch: &Pitch) -> Result<Turn, TrimError> {
    if !vehicle.coefficients.leaves_plane() {
        return Err(TrimError::NoLateral);
    }
    let level = trim_with(vehicle, Speed::Path(speed), depth, pitch)?;
    let dynamics = Dynamics::new(&vehicle.coefficients)?.lifted();
    let steps = (rate.abs() / RATE_STEP).ceil().max(1.0);
    if !steps.is_finite() {
        return Err(TrimError::RateNotFinite { rate });
    }
    let solve = |is_held: bool| {
        let directions = directions(vehicle, level.forward_speed, is_held);
        let balance = Balance { vehicle, dynamics: dynamics.clone(), speed, depth, directions };
        let start = [level.forward_speed, 0.0, level.heave, 0.0, level.pitch];
        let all = start.into_iter().chain(level.actuators.iter().copied());
        let mut unknown = DVector::from_iterator(STATES + level.actuators.len(), all);
        let mut residual = f64::INFINITY;
        for step in 1..=steps as usize {
            let at = rate * (step as f64 / steps);
            residual = balance.newton(at, &mut unknown);
            if residual.is_nan() || residual >= RESIDUAL_TOLERANCE {
                return Err(TrimError::NoTurn { speed, depth, rate_deg: at.to_degrees(), residual });
            }
        }
        let motion = motion([0, 1, 2, 3, 4].map(|i| unknown[i]), rate);
        let actuators = unknown.iter().skip(STATES).copied().collect();
        Ok(Turn { motion, speed, rate, depth, actuators, residual })
    };
    match pitch {
        Pitch::Held(_) => solve(true).or_else(|_| solve(false)),
        _ => solve(false),
    }
}

/// Returns the motion of a steady turn.
fn motion<D: Scalar>([u, v, w, phi, theta]: [D; STATES], rate: f64) -> Motion<D> {
    let ((sin_phi, cos_phi), (sin, cos)) = (phi.sin_cos(), theta.sin_cos());
    Motion { u, v, w, p: -(sin * rate), q: cos * sin_phi * rate, r: cos * cos_phi * rate, phi, theta }
}

/// Equations of a steady turn.
struct Balance<'a> {
    vehicle: &'a Vehicle,
    dynamics: Dynamics<Dual64>,
    speed: f64,
    depth: f64,
    /// Directions in which the unknowns may change, one per column.
    directions: DMatrix<f64>,
}

/// Returns the directions in which the unknowns of a turn may change, one per column: outputs in units of their reach,
/// theta unless it is held. If another actuator yaws the vehicle, the outputs of the vertical plane are restricted to
/// changes of least norm for their effect there at the surge speed `u`.
fn directions(vehicle: &Vehicle, u: f64, is_held: bool) -> DMatrix<f64> {
    let reach = vehicle.actuators.iter().map(Actuator::reach);
    let held = if is_held { 0.0 } else { 1.0 };
    let scale = [1.0, 1.0, 1.0, 1.0, held].into_iter().chain(reach);
    let mut directions =
        DMatrix::from_diagonal(&DVector::from_iterator(STATES + vehicle.actuators.len(), scale));
    let all = || vehicle.actuators.iter().enumerate();
    let plane: Vec<usize> = all().filter(|(_, one)| one.acts_in_plane()).map(|(index, _)| index).collect();
    if plane.is_empty() || !vehicle.actuators.iter().any(Actuator::yaws_alone) {
        return directions;
    }
    let effects = DMatrix::from_fn(3, plane.len(), |row, column| {
        let one = &vehicle.actuators[plane[column]];
        let per_output = one.effect.map(|key, value| if key == "X_uu_delta2" { 0.0 } else { value });
        per_output.force(u, one.reach())[row]
    });
    let svd = effects.svd(false, true);
    let Some(right_singular) = svd.v_t else { return directions };
    let least = RANK_TOLERANCE * svd.singular_values.max();
    let effective: Vec<usize> =
        (0..svd.singular_values.len()).filter(|i| svd.singular_values[*i] > least).collect();
    if effective.len() < plane.len() {
        let effective = right_singular.select_rows(&effective);
        let projection = effective.tr_mul(&effective);
        for (i, row) in plane.iter().enumerate() {
            for (j, column) in plane.iter().enumerate() {
                directions[(STATES + row, STATES + column)] =
                    vehicle.actuators[*row].reach() * projection[(i, j)];
            }
        }
    }
    directions
}

impl Balance<'_> {
    fn equations(&self, rate: f64, unknown: &[Dual64]) -> [Dual64; EQUATIONS] {
        let motion = motion([0, 1, 2, 3, 4].map(|i| unknown[i]), rate);
        let all = acceleration(self.vehicle, &self.dynamics, &motion, self.depth.into(), &unknown[STATES..]);
        let [du, dv, dw, dp, dq, dr] = all;
        let Motion { u, v, w, .. } = motion;
        let square = u * u + v * v + w * w - self.speed * self.speed;
        [du, dv, dw, dp, dq, dr, motion.depth_rate(), square]
    }

    /// Runs Newton's method from `unknown` with steps of least norm in units of the reach of the actuators; returns the
    /// largest residual.
    fn newton(&self, rate: f64, unknown: &mut DVector<f64>) -> f64 {
        let n = unknown.len();
        let mut residual = f64::INFINITY;
        for _ in 0..MAX_ITERATIONS {
            let mut jacobian = DMatrix::zeros(EQUATIONS, n);
            let mut error = DVector::zeros(EQUATIONS);
            for seed in 0..n {
                let part = |i: usize| Dual64::new(unknown[i], self.directions[(i, seed)]);
                let seeded: Vec<Dual64> = (0..n).map(part).collect();
                for (row, one) in self.equations(rate, &seeded).into_iter().enumerate() {
                    jacobian[(row, seed)] = one.eps;
                    error[row] = one.re;
                }
            }
            residual = error.amax();
            if !jacobian.iter().all(|one| one.is_finite()) || residual < 1e-3 * RESIDUAL_TOLERANCE {
                break;
            }
            let svd = jacobian.svd(true, true);
            let threshold = RANK_TOLERANCE * svd.singular_values.max();
            let Ok(change) = svd.solve(&error, threshold) else { break };
            *unknown -= &self.directions * change;
        }
        residual
    }
}

/// Returns \[u' v' w' p' q' r'\] under the outputs of the actuators.
fn acceleration(
    vehicle: &Vehicle,
    dynamics: &Dynamics<Dual64>,
    motion: &Motion<Dual64>,
    depth: Dual64,
    outputs: &[Dual64],
) -> [Dual64; 6] {
    let given = || outputs.iter().copied();
    let force = actuator_force(&vehicle.actuators, motion.u, given());
    let lateral = lateral_actuator_force(&vehicle.actuators, motion.u, given());
    let [du, dw, dq] = dynamics.acceleration(motion, depth, force);
    let [dv, dp, dr] = dynamics.lateral_acceleration(motion, depth, lateral);
    [du, dv, dw, dp, dq, dr]
}

/// Linearises about a steady turn: `x' = A (x - x0) + B (T - T0)` with x = \[u w q theta v p r phi\] (m/s, m/s, rad/s,
/// rad, m/s, rad/s, rad/s, rad), and T the outputs of the actuators (N or rad).
///
/// In straight level flight without propeller torque the first four states and the last four are decoupled. Shapes: A 8
/// x 8, B 8 x m.
///
/// # Errors
/// [`TrimError`] if the vehicle's coefficients are not allowed.
pub fn linearise_turn(vehicle: &Vehicle, turn: &Turn) -> Result<(DMatrix<f64>, DMatrix<f64>), TrimError> {
    let dynamics = Dynamics::new(&vehicle.coefficients)?.lifted();
    let Motion { u, v, w, p, q, r, phi, theta } = turn.motion;
    let start = [u, w, q, theta, v, p, r, phi];
    let (n, inputs) = (start.len(), turn.actuators.len());
    let mut jacobian = DMatrix::zeros(n, n + inputs);
    for seed in 0..n + inputs {
        let part = |i: usize, value: f64| Dual64::new(value, if i == seed { 1.0 } else { 0.0 });
        let at: [Dual64; 8] = std::array::from_fn(|i| part(i, start[i]));
        let [u, w, q, theta, v, p, r, phi] = at;
        let motion = Motion { u, v, w, p, q, r, phi, theta };
        let outputs: Vec<Dual64> =
            turn.actuators.iter().enumerate().map(|(i, output)| part(n + i, *output)).collect();
        let [du, dv, dw, dp, dq, dr] = acceleration(vehicle, &dynamics, &motion, turn.depth.into(), &outputs);
        let [roll, pitch, _] = motion.turning();
        for (row, one) in [du, dw, dq, pitch, dv, dp, dr, roll].into_iter().enumerate() {
            jacobian[(row, seed)] = one.eps;
        }
    }
    Ok((jacobian.columns(0, n).into_owned(), jacobian.columns(n, inputs).into_owned()))
}
