//! Level trim: the incidence and the actuator outputs at which nothing accelerates.
//!
//! Level flight has theta = alpha, u = V cos alpha, w = V sin alpha, q = 0, so that the depth is constant. The unknowns
//! are alpha and the outputs; the equations are u' = w' = q' = 0. They are solved by Newton's method. With more
//! actuators than equations, the outputs have the least Euclidean norm, each divided by its [`Actuator::reach`].

use nalgebra::{DMatrix, DVector, Vector3};
use num_dual::Dual64;
use thiserror::Error;

use crate::motion::dynamics::{Dynamics, Motion, actuator_force};
use crate::scalar::Scalar;
use crate::vehicle::Vehicle;
use crate::vehicle::actuator::Actuator;
use crate::vehicle::coefficients::CoefficientError;
use crate::words::Rounded;

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

/// The speed at which to trim.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Speed {
    /// Speed along the path through the water, V \[m/s\].
    Path(f64),
    /// Surge velocity, u \[m/s\].
    Forward(f64),
}

impl Speed {
    fn value(self) -> f64 {
        match self {
            Self::Path(speed) | Self::Forward(speed) => speed,
        }
    }

    /// Returns level motion at an incidence.
    fn level_motion<D: Scalar>(self, incidence: D) -> Motion<D> {
        let (sin, cos) = incidence.sin_cos();
        let (u, w) = match self {
            Self::Path(speed) => (cos * speed, sin * speed),
            Self::Forward(speed) => (D::from(speed), sin / cos * speed),
        };
        Motion { u, w, q: D::from(0.0), theta: incidence }
    }
}

/// A level, steady motion and the actuator outputs that balance it.
#[derive(Clone, Debug, PartialEq)]
pub struct Trim {
    /// Speed along the path through the water, V \[m/s\].
    pub speed: f64,
    /// Surge velocity, u \[m/s\].
    pub forward_speed: f64,
    /// Heave velocity, w \[m/s\].
    pub heave: f64,
    /// Incidence atan(w / u) \[rad\].
    pub incidence: f64,
    /// Pitch \[rad\], equal to the incidence.
    pub pitch: f64,
    /// Depth \[m\].
    pub depth: f64,
    /// Output of each actuator \[N or rad\].
    pub actuators: Vec<f64>,
    /// Largest remaining |u'|, |w'| \[m/s2\] or |q'| \[rad/s2\].
    pub residual: f64,
}

impl Trim {
    /// Returns the trimmed motion.
    pub fn motion(&self) -> Motion {
        Motion { u: self.forward_speed, w: self.heave, q: 0.0, theta: self.pitch }
    }
}

/// Why there is no trim.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum TrimError {
    /// The coefficients are not allowed.
    #[error(transparent)]
    Coefficients(#[from] CoefficientError),
    /// The speed is not a positive number.
    #[error("the trim speed is {} m/s, and must be a number above zero", Rounded(*speed))]
    SpeedNotPositive { speed: f64 },
    /// The depth is not a number.
    #[error("the trim depth is {} m, and must be a finite number", Rounded(*depth))]
    DepthNotFinite { depth: f64 },
    /// No incidence and outputs balance the forces.
    #[error(
        "no level trim at {} m/s and {} m: lift and actuators do not balance a weight of {} N, a buoyancy of \
            {} N and the moments (nearest at an incidence of {incidence_deg:.1} deg, with {} m/s2 or rad/s2 \
            left)",
        Rounded(*speed), Rounded(*depth), Rounded(*weight), Rounded(*buoyancy), Rounded(*residual)
    )]
    NotFound {
        /// The speed asked for \[m/s\].
        speed: f64,
        /// The depth asked for \[m\].
        depth: f64,
        /// The weight \[N\].
        weight: f64,
        /// The buoyancy at that depth \[N\].
        buoyancy: f64,
        /// The last incidence tried \[deg\].
        incidence_deg: f64,
        /// The largest remaining acceleration \[m/s2 or rad/s2\].
        residual: f64,
    },
    /// The trim needs an output beyond the limits of an actuator.
    #[error(
        "level trim at {} m/s and {} m needs {} {unit} of {actuator}, {} {unit} beyond its limits {} .. {} {unit}",
        Rounded(*speed), Rounded(*depth), Rounded(*needed), Rounded(*excess), Rounded(*min), Rounded(*max)
    )]
    BeyondLimits {
        /// The speed asked for \[m/s\].
        speed: f64,
        /// The depth asked for \[m\].
        depth: f64,
        actuator: String,
        needed: f64,
        excess: f64,
        min: f64,
        max: f64,
        unit: &'static str,
    },
}

/// Solves `[u' w' q'] = 0` for level trim at a speed \[m/s\] and a depth \[m\].
///
/// # Errors
/// [`TrimError`]: coefficients, speed or depth that are not allowed, no solution, or an actuator beyond its limits.
pub fn trim(vehicle: &Vehicle, speed: Speed, depth: f64) -> Result<Trim, TrimError> {
    if !(speed.value() > 0.0 && speed.value().is_finite()) {
        return Err(TrimError::SpeedNotPositive { speed: speed.value() });
    }
    if !depth.is_finite() {
        return Err(TrimError::DepthNotFinite { depth });
    }
    let balance = Balance { dynamics: Dynamics::new(&vehicle.coefficients)?, vehicle, speed, depth };
    let Attempt { incidence, outputs: actuators, residual } = balance.solve()?;
    let motion = speed.level_motion(incidence);
    let path_speed = match speed {
        Speed::Path(speed) => speed,
        Speed::Forward(_) => motion.u.hypot(motion.w),
    };
    let trim = Trim {
        speed: path_speed,
        forward_speed: motion.u,
        heave: motion.w,
        incidence,
        pitch: incidence,
        depth,
        actuators,
        residual,
    };
    check_limits(vehicle, &trim)?;
    Ok(trim)
}

/// Refuses a trim beyond the limits of an actuator; the error names the actuator that exceeds them most.
fn check_limits(vehicle: &Vehicle, trim: &Trim) -> Result<(), TrimError> {
    let excess = |(actuator, &output): (&Actuator, &f64)| (output - actuator.max).max(actuator.min - output);
    let pairs = || vehicle.actuators.iter().zip(&trim.actuators);
    let worst = pairs().max_by(|a, b| (excess(*a) / a.0.reach()).total_cmp(&(excess(*b) / b.0.reach())));
    match worst {
        Some((actuator, &needed)) if excess((actuator, &needed)) > 0.0 => Err(TrimError::BeyondLimits {
            speed: trim.speed,
            depth: trim.depth,
            actuator: actuator.name.clone(),
            needed,
            excess: excess((actuator, &needed)),
            min: actuator.min,
            max: actuator.max,
            unit: actuator.unit(),
        }),
        _ => Ok(()),
    }
}

/// Where an iteration ended.
#[derive(Clone, Debug)]
struct Attempt {
    incidence: f64,
    outputs: Vec<f64>,
    residual: f64,
}

/// The equations of level trim.
struct Balance<'a> {
    dynamics: Dynamics,
    vehicle: &'a Vehicle,
    speed: Speed,
    depth: f64,
}

impl Balance<'_> {
    fn acceleration<D: Scalar>(&self, incidence: D, outputs: impl Iterator<Item = D>) -> [D; 3] {
        let motion = self.speed.level_motion(incidence);
        let force = actuator_force(&self.vehicle.actuators, motion.u, outputs);
        self.dynamics.acceleration(&motion, D::from(self.depth), force)
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

    /// Tries Newton's method from several incidences: near the speed at which fins and weight cancel, one start is
    /// not enough.
    ///
    /// Returns the first trim within the limits, or else the first trim at all.
    fn solve(&self) -> Result<Attempt, TrimError> {
        let attempts: Vec<Attempt> = STARTS.iter().map(|&start| self.newton(start)).collect();
        let mut trims = attempts.iter().filter(|attempt| attempt.residual < RESIDUAL_TOLERANCE);
        let first = trims.clone().next();
        if let Some(attempt) = trims.find(|attempt| self.within_limits(attempt)).or(first) {
            return Ok(attempt.clone());
        }
        let nearest = attempts.iter().min_by(|a, b| a.residual.total_cmp(&b.residual));
        let (speed, depth) = (self.speed.value(), self.depth);
        let (incidence, residual) = nearest.map_or((0.0, f64::INFINITY), |a| (a.incidence, a.residual));
        let coefficients = &self.vehicle.coefficients;
        let (weight, buoyancy) = (coefficients.weight, coefficients.buoyancy_at(depth));
        let incidence_deg = incidence.to_degrees();
        Err(TrimError::NotFound { speed, depth, weight, buoyancy, incidence_deg, residual })
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
        let mut best = Attempt { incidence, outputs: vec![0.0; reach.len()], residual: f64::INFINITY };
        for _ in 0..MAX_ITERATIONS {
            let outputs: Vec<f64> = scaled.component_mul(&reach).iter().copied().collect();
            let (error, by_incidence, by_outputs) = self.linearised(incidence, &outputs);
            let residual = error.amax();
            if residual < best.residual {
                best = Attempt { incidence, outputs, residual };
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

/// Returns the change of incidence and of the scaled outputs that solves the linearised equations.
///
/// The equations are projected on the plane that the incidence does not reach; there the outputs are the solution of
/// least norm, and the incidence takes up the rest. At the fixed point the outputs satisfy the first-order condition
/// of the least norm over all trims.
fn newton_step(
    error: Vector3<f64>,
    by_incidence: Vector3<f64>,
    by_outputs: &DMatrix<f64>,
    scaled: &DVector<f64>,
) -> Option<(f64, DVector<f64>)> {
    let slope = by_incidence.norm();
    let normal = by_incidence / slope;
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
    let turn = -normal.dot(&(error + reached(&change))) / slope;
    (turn.is_finite() && change.iter().all(|c| c.is_finite())).then_some((turn, change))
}
