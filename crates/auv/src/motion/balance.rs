//! Equations of level trim, and Newton's method for them.

use nalgebra::{DMatrix, DVector, Vector3};
use num_dual::Dual64;

use crate::motion::dynamics::{Dynamics, actuator_force};
use crate::motion::level::{Pitch, Speed};
use crate::motion::trim_error::TrimError;
use crate::scalar::Scalar;
use crate::vehicle::Vehicle;
use crate::vehicle::actuator::Actuator;

/// Newton steps from each start; a few suffice near a solution.
const MAX_ITERATIONS: usize = 60;
/// Largest change of the incidence in one step \[rad\].
const LARGEST_STEP: f64 = 0.2;
/// Initial incidences of Newton's method \[rad\].
const STARTS: [f64; 5] = [0.0, -0.15, 0.15, -0.4, 0.4];
/// Incidence beyond which an iteration is abandoned \[rad\].
const LARGEST_INCIDENCE: f64 = 1.2;
/// Convergence tolerance of the incidence \[rad\].
const INCIDENCE_TOLERANCE: f64 = 1e-15;
/// Convergence tolerance of the outputs, in units of their reach.
const OUTPUT_TOLERANCE: f64 = 1e-14;
/// Largest acceleration that counts as zero \[m/s2 or rad/s2\].
const RESIDUAL_TOLERANCE: f64 = 1e-11;
/// Singular values below this fraction of the largest one count as zero.
const RANK_TOLERANCE: f64 = 1e-9;
/// Convergence threshold of the SVD.
const SVD_TOLERANCE: f64 = 5.0 * f64::EPSILON;
/// Iteration limit of the SVD, far above the need of a 3 x m matrix; without a limit it may never end.
const SVD_ITERATIONS: usize = 1000;

/// Result of an iteration.
#[derive(Clone, Debug)]
pub(crate) struct Attempt {
    pub(crate) incidence: f64,
    pub(crate) outputs: Vec<f64>,
    pub(crate) residual: f64,
    /// Remaining acceleration \[u' w' q'\].
    acceleration: Vector3<f64>,
}

/// Equations of level trim.
pub(crate) struct Balance<'a> {
    pub(crate) dynamics: Dynamics,
    pub(crate) vehicle: &'a Vehicle,
    pub(crate) speed: Speed,
    pub(crate) depth: f64,
    pub(crate) pitch: &'a Pitch,
    /// Pitch \[rad\] of a climb or a dive; in level flight it equals the incidence.
    pub(crate) climb: Option<f64>,
}

impl Balance<'_> {
    fn acceleration<D: Scalar>(&self, incidence: D, outputs: impl Iterator<Item = D>) -> [D; 3] {
        let mut motion = self.speed.level_motion(incidence);
        if let Some(pitch) = self.climb {
            motion.theta = D::from(pitch);
        }
        let force = actuator_force(&self.vehicle.actuators, motion.u, outputs);
        self.dynamics.lifted().acceleration(&motion, D::from(self.depth), force)
    }

    /// Returns the accelerations, and their derivatives with respect to the incidence and to each output in units of
    /// its reach.
    fn linearised(&self, incidence: f64, outputs: &[f64]) -> (Vector3<f64>, Vector3<f64>, DMatrix<f64>) {
        let constant = || outputs.iter().map(|&output| Dual64::from(output));
        let by_incidence = self.acceleration(Dual64::new(incidence, 1.0), constant());
        let mut by_outputs = DMatrix::zeros(3, outputs.len());
        for (j, actuator) in self.vehicle.actuators.iter().enumerate() {
            let seeded = constant()
                .enumerate()
                .map(|(i, output)| if i == j { Dual64::new(output.re, actuator.reach()) } else { output });
            let column = self.acceleration(Dual64::from(incidence), seeded);
            (0..3).for_each(|i| by_outputs[(i, j)] = column[i].eps);
        }
        (Vector3::from(by_incidence.map(|a| a.re)), Vector3::from(by_incidence.map(|a| a.eps)), by_outputs)
    }

    /// Runs Newton's method from one or several incidences: with free pitch, near the speed at which fin forces and
    /// weight cancel, one start does not suffice.
    ///
    /// Returns the first trim within the limits, or else the first trim.
    pub(crate) fn solve(&self) -> Result<Attempt, TrimError> {
        let attempts: Vec<Attempt> = match self.pitch {
            Pitch::Free => STARTS.iter().map(|&start| self.newton(start)).collect(),
            Pitch::Held(incidence) => vec![self.newton(*incidence)],
            Pitch::Followed(branch) => vec![self.newton(branch.pitch_at(self.speed.value()))],
        };
        let mut trims = attempts.iter().filter(|attempt| attempt.residual < RESIDUAL_TOLERANCE);
        let first = trims.clone().next();
        if let Some(attempt) = trims.find(|attempt| self.within_limits(attempt)).or(first) {
            return Ok(attempt.clone());
        }
        let nearest = attempts.iter().min_by(|a, b| a.residual.total_cmp(&b.residual));
        Err(self.no_trim_error(nearest))
    }

    /// Returns the reason why there is no trim; `nearest` has the smallest residual.
    fn no_trim_error(&self, nearest: Option<&Attempt>) -> TrimError {
        let (speed, depth) = (self.speed.value(), self.depth);
        let coefficients = self.dynamics.coefficients();
        if !coefficients.surge.is_given() && !self.has_axial_thruster() {
            let drag = (self.dynamics.axial_drag(speed) + coefficients.X_u * speed).abs();
            return TrimError::NoThrust { speed, depth, drag };
        }
        if let (Pitch::Held(pitch), Some(nearest)) = (self.pitch, nearest) {
            let [[surge, heave, moment]] = (coefficients.mass_matrix() * nearest.acceleration).data.0;
            let pitch_deg = pitch.to_degrees();
            return TrimError::NotHeld { speed, depth, pitch_deg, surge, heave, moment };
        }
        let (incidence, residual) = nearest.map_or((0.0, f64::INFINITY), |a| (a.incidence, a.residual));
        let (weight, buoyancy) = (coefficients.weight, coefficients.buoyancy_at(depth));
        let incidence_deg = incidence.to_degrees();
        TrimError::NotFound { speed, depth, weight, buoyancy, incidence_deg, residual }
    }

    /// Returns `true` if a thruster has a force along the hull.
    fn has_axial_thruster(&self) -> bool {
        let pushes = |a: &Actuator| a.unit() == "N" && a.force(0.0, 1.0_f64)[0].abs() > RANK_TOLERANCE;
        self.vehicle.actuators.iter().any(pushes)
    }

    fn within_limits(&self, attempt: &Attempt) -> bool {
        let mut pairs = self.vehicle.actuators.iter().zip(&attempt.outputs);
        pairs.all(|(actuator, output)| (actuator.min..=actuator.max).contains(output))
    }

    /// Newton's method; each step solves the linearised equations with the outputs of least norm.
    fn newton(&self, start: f64) -> Attempt {
        let actuators = &self.vehicle.actuators;
        let reach = DVector::from_iterator(actuators.len(), actuators.iter().map(Actuator::reach));
        let mut incidence = start;
        let mut scaled = DVector::zeros(reach.len());
        let mut best = Attempt {
            incidence,
            outputs: vec![0.0; reach.len()],
            residual: f64::INFINITY,
            acceleration: Vector3::zeros(),
        };
        let is_held = matches!(self.pitch, Pitch::Held(_));
        let mut is_redundant = None;
        let equations = 3 - self.vehicle.coefficients.surge.first();
        for _ in 0..MAX_ITERATIONS {
            let outputs: Vec<f64> = scaled.component_mul(&reach).iter().copied().collect();
            let (error, by_incidence, by_outputs) = self.linearised(incidence, &outputs);
            let by_incidence = if is_held { Vector3::zeros() } else { by_incidence };
            let residual = error.amax();
            // If the least effort selects one of many trims, zero acceleration alone does not end the iteration.
            let is_nearer = residual < RESIDUAL_TOLERANCE
                && *is_redundant
                    .get_or_insert_with(|| !is_held && span_all_equations(&by_outputs, equations));
            if residual < best.residual || is_nearer {
                best = Attempt { incidence, outputs, residual, acceleration: error };
            }
            let Some((incidence_change, change)) = newton_step(error, by_incidence, &by_outputs, &scaled)
            else {
                break;
            };
            let step_scale = (LARGEST_STEP / incidence_change.abs()).min(1.0);
            incidence += step_scale * incidence_change;
            scaled += &change * step_scale;
            let settled = incidence_change.abs() < INCIDENCE_TOLERANCE && change.amax() < OUTPUT_TOLERANCE;
            if settled || !incidence.is_finite() || incidence.abs() > LARGEST_INCIDENCE {
                break;
            }
        }
        best
    }
}

/// Returns `true` if the outputs alone control all `equations`: surge, heave and pitch, or heave and pitch.
pub(crate) fn span_all_equations(by_outputs: &DMatrix<f64>, equations: usize) -> bool {
    let values = by_outputs.singular_values();
    values.iter().filter(|value| **value > RANK_TOLERANCE * values.max()).count() == equations
}

/// Returns the change of the incidence and of the scaled outputs that solves the linearised equations.
///
/// The equations are projected on the plane orthogonal to the derivative with respect to the incidence; there the
/// outputs are the solution of least norm, and the incidence balances the remaining component. At the fixed point the
/// outputs satisfy the first-order condition of the least norm over all trims. A held or ineffective incidence has
/// derivative zero and does not change.
fn newton_step(
    error: Vector3<f64>,
    by_incidence: Vector3<f64>,
    by_outputs: &DMatrix<f64>,
    scaled: &DVector<f64>,
) -> Option<(f64, DVector<f64>)> {
    let slope = by_incidence.norm();
    let is_free = slope > 0.0;
    let normal = if is_free { by_incidence / slope } else { by_incidence };
    let project = |v: Vector3<f64>| v - normal * normal.dot(&v);
    let effect = |outputs: &DVector<f64>| Vector3::from_iterator((by_outputs * outputs).iter().copied());
    let target = project(effect(scaled) - error);
    let mut projected = by_outputs.clone();
    for mut column in projected.column_iter_mut() {
        let inside = project(Vector3::new(column[0], column[1], column[2]));
        column.copy_from(&inside);
    }
    // Products of large coefficients may overflow, and a matrix with non-finite entries has no SVD.
    if !projected.iter().all(|entry| entry.is_finite()) {
        return None;
    }
    let svd = projected.try_svd(true, true, SVD_TOLERANCE, SVD_ITERATIONS)?;
    let threshold = svd.singular_values.max() * RANK_TOLERANCE;
    let solution = svd.solve(&DVector::from_column_slice(target.as_slice()), threshold).ok()?;
    let change = solution - scaled;
    let incidence_change = if is_free { -normal.dot(&(error + effect(&change))) / slope } else { 0.0 };
    (incidence_change.is_finite() && change.iter().all(|c| c.is_finite()))
        .then_some((incidence_change, change))
}
