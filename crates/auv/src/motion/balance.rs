//! The equations of level trim, and Newton's method for them.

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
/// Incidences from which Newton's method starts \[rad\].
const STARTS: [f64; 5] = [0.0, -0.15, 0.15, -0.4, 0.4];
/// Beyond this incidence an iteration is given up \[rad\].
const LARGEST_INCIDENCE: f64 = 1.2;
/// The iteration ends at a smaller change of the incidence \[rad\] ...
const INCIDENCE_TOLERANCE: f64 = 1e-15;
/// ... and of the outputs, in units of their reach.
const OUTPUT_TOLERANCE: f64 = 1e-14;
/// Largest acceleration that counts as zero \[m/s2 or rad/s2\].
const RESIDUAL_TOLERANCE: f64 = 1e-11;
/// Singular values below this part of the largest one count as zero.
const RANK_TOLERANCE: f64 = 1e-9;
/// Convergence threshold of the SVD.
const SVD_TOLERANCE: f64 = 5.0 * f64::EPSILON;
/// Limit of the SVD's iterations, far above what a 3 x m matrix needs; without a limit the iteration may never end.
const SVD_ITERATIONS: usize = 1000;

/// Where an iteration ended.
#[derive(Clone, Debug)]
pub(crate) struct Attempt {
    pub(crate) incidence: f64,
    pub(crate) outputs: Vec<f64>,
    pub(crate) residual: f64,
    /// \[u' w' q'\].
    left: Vector3<f64>,
}

/// The equations of level trim.
pub(crate) struct Balance<'a> {
    pub(crate) dynamics: Dynamics,
    pub(crate) vehicle: &'a Vehicle,
    pub(crate) speed: Speed,
    pub(crate) depth: f64,
    pub(crate) pitch: &'a Pitch,
    /// The pitch \[rad\] of a climb or a dive; in level flight it is the incidence.
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

    /// Returns the accelerations, their derivative with respect to the incidence, and those with respect to each output
    /// in units of its reach.
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

    /// Tries Newton's method from one or several incidences: where the pitch is free, near the speed at which fins and
    /// weight cancel, one start is not enough.
    ///
    /// Returns the first trim within the limits, or else the first trim at all.
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
        Err(self.refusal(nearest))
    }

    /// Why there is no trim; `nearest` is where the forces are least out of balance.
    fn refusal(&self, nearest: Option<&Attempt>) -> TrimError {
        let (speed, depth) = (self.speed.value(), self.depth);
        let coefficients = self.dynamics.coefficients();
        if !coefficients.surge.is_given() && !self.is_pushed() {
            let drag = (self.dynamics.axial_drag(speed) + coefficients.X_u * speed).abs();
            return TrimError::NoThrust { speed, depth, drag };
        }
        if let (Pitch::Held(pitch), Some(nearest)) = (self.pitch, nearest) {
            let [[surge, heave, moment]] = (coefficients.mass_matrix() * nearest.left).data.0;
            let pitch_deg = pitch.to_degrees();
            return TrimError::NotHeld { speed, depth, pitch_deg, surge, heave, moment };
        }
        let (incidence, residual) = nearest.map_or((0.0, f64::INFINITY), |a| (a.incidence, a.residual));
        let (weight, buoyancy) = (coefficients.weight, coefficients.buoyancy_at(depth));
        let incidence_deg = incidence.to_degrees();
        TrimError::NotFound { speed, depth, weight, buoyancy, incidence_deg, residual }
    }

    /// Whether a thruster pushes along the hull.
    fn is_pushed(&self) -> bool {
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
            left: Vector3::zeros(),
        };
        let is_held = matches!(self.pitch, Pitch::Held(_));
        let mut is_redundant = None;
        let equations = 3 - self.vehicle.coefficients.surge.first();
        for _ in 0..MAX_ITERATIONS {
            let outputs: Vec<f64> = scaled.component_mul(&reach).iter().copied().collect();
            let (error, by_incidence, by_outputs) = self.linearised(incidence, &outputs);
            let by_incidence = if is_held { Vector3::zeros() } else { by_incidence };
            let residual = error.amax();
            // Where the effort chooses among many trims, balanced forces alone are not the end.
            let is_nearer = residual < RESIDUAL_TOLERANCE
                && *is_redundant.get_or_insert_with(|| !is_held && reaches_all(&by_outputs, equations));
            if residual < best.residual || is_nearer {
                best = Attempt { incidence, outputs, residual, left: error };
            }
            let Some((turn, change)) = newton_step(error, by_incidence, &by_outputs, &scaled) else { break };
            let shortened = (LARGEST_STEP / turn.abs()).min(1.0);
            incidence += shortened * turn;
            scaled += &change * shortened;
            let settled = turn.abs() < INCIDENCE_TOLERANCE && change.amax() < OUTPUT_TOLERANCE;
            if settled || !incidence.is_finite() || incidence.abs() > LARGEST_INCIDENCE {
                break;
            }
        }
        best
    }
}

/// Whether outputs reach surge, heave and pitch by themselves, or as many of these `equations` as there are.
pub(crate) fn reaches_all(by_outputs: &DMatrix<f64>, equations: usize) -> bool {
    let values = by_outputs.singular_values();
    values.iter().filter(|value| **value > RANK_TOLERANCE * values.max()).count() == equations
}

/// Returns the change of incidence and of the scaled outputs that solves the linearised equations.
///
/// The equations are projected on the plane that the incidence does not reach; there the outputs are the solution of
/// least norm, and the incidence takes up the rest. At the fixed point the outputs satisfy the first-order condition
/// of the least norm over all trims. An incidence that is held, or changes nothing, has the derivative zero and does
/// not turn.
fn newton_step(
    error: Vector3<f64>,
    by_incidence: Vector3<f64>,
    by_outputs: &DMatrix<f64>,
    scaled: &DVector<f64>,
) -> Option<(f64, DVector<f64>)> {
    let slope = by_incidence.norm();
    let turns = slope > 0.0;
    let normal = if turns { by_incidence / slope } else { by_incidence };
    let project = |v: Vector3<f64>| v - normal * normal.dot(&v);
    let reached = |outputs: &DVector<f64>| Vector3::from_iterator((by_outputs * outputs).iter().copied());
    let target = project(reached(scaled) - error);
    let mut projected = by_outputs.clone();
    for mut column in projected.column_iter_mut() {
        let inside = project(Vector3::new(column[0], column[1], column[2]));
        column.copy_from(&inside);
    }
    // Products of large coefficients may overflow, and a matrix with entries that are not finite has no SVD.
    if !projected.iter().all(|entry| entry.is_finite()) {
        return None;
    }
    let svd = projected.try_svd(true, true, SVD_TOLERANCE, SVD_ITERATIONS)?;
    let threshold = svd.singular_values.max() * RANK_TOLERANCE;
    let solution = svd.solve(&DVector::from_column_slice(target.as_slice()), threshold).ok()?;
    let change = solution - scaled;
    let turn = if turns { -normal.dot(&(error + reached(&change))) / slope } else { 0.0 };
    (turn.is_finite() && change.iter().all(|c| c.is_finite())).then_some((turn, change))
}
