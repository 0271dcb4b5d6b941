//! Linear motion before the mass matrix is inverted, and its derivatives with respect to the coefficients of the
//! vehicle and to its trim.
//!
//! Dual numbers of second and third order differentiate the simulation code itself; there are no finite differences.

use crate::states::{LATERAL, LONGITUDINAL, are_lateral};
use nalgebra::DMatrix;
use num_dual::{Dual64, HyperDual64, HyperHyperDual64};
use squid_signals::States;

use crate::motion::dynamics::{Motion, add};
use crate::motion::parameter::Parameter;
use crate::motion::trim::Trim;
use crate::scalar::Scalar;
use crate::vehicle::Vehicle;
use crate::vehicle::coefficients::Coefficients;

/// Linear motion `M x' = C x + D (T - T0)` about a trim, with a selection of the states x = \[u w q theta z\], or of x
/// = \[p phi v r psi\], as deviations from trim; all other states are held at trim.
///
/// For n states M and C are n x n and D is n x m; the rows are surge force \[N\], heave force \[N\], pitch moment
/// \[N.m\], theta' = q, and z'; or roll moment \[N.m\], phi', sway force \[N\], yaw moment \[N.m\], and psi' = r, where
/// r is the rate of heading. A is `M^-1 C` and B is `M^-1 D`. M, C and D are affine in most coefficients; no
/// coefficient divides another.
///
/// Source: A. Sutarto, A. Budiyono, Indian J. Geo-Marine Sci. 40(2), 2011, section 3A.
#[derive(Clone, Debug, PartialEq)]
pub struct Descriptor {
    /// Mass matrix M.
    pub mass: DMatrix<f64>,
    /// State matrix C.
    pub state: DMatrix<f64>,
    /// Input matrix D.
    pub input: DMatrix<f64>,
}

impl Descriptor {
    /// Returns M, C and D at a trim, which may belong to another vehicle with the same actuators.
    pub fn at(vehicle: &Vehicle, trim: &Trim, states: States) -> Self {
        differentiate((vehicle, trim, states), &[], Dual64::new(0.0, 1.0), |d| d.re, |d| d.eps)
    }

    /// Returns the derivatives of M, C and D with respect to a parameter; all others and the trim are held.
    pub fn derivative(vehicle: &Vehicle, trim: &Trim, states: States, by: Parameter) -> Self {
        let zero = HyperDual64::from(0.0);
        let seeds = [(by, zero.derivative2())];
        differentiate((vehicle, trim, states), &seeds, zero.derivative1(), |d| d.eps2, |d| d.eps1eps2)
    }

    /// Returns the second derivatives of M, C and D with respect to two parameters; all others and the trim are held.
    pub fn second_derivative(vehicle: &Vehicle, trim: &Trim, states: States, by: [Parameter; 2]) -> Self {
        let zero = HyperHyperDual64::from(0.0);
        let seeds = [(by[0], zero.derivative2()), (by[1], zero.derivative3())];
        let unit = zero.derivative1();
        differentiate((vehicle, trim, states), &seeds, unit, |d| d.eps2eps3, |d| d.eps1eps2eps3)
    }

    /// Returns `[M C D]`, n x (2 n + m).
    pub fn stacked(&self) -> DMatrix<f64> {
        let (n, inputs) = self.input.shape();
        let mut stacked_matrix = DMatrix::zeros(n, 2 * n + inputs);
        stacked_matrix.columns_mut(0, n).copy_from(&self.mass);
        stacked_matrix.columns_mut(n, n).copy_from(&self.state);
        stacked_matrix.columns_mut(2 * n, inputs).copy_from(&self.input);
        stacked_matrix
    }
}

/// Evaluates the forces with `seeds` added to the parameters and `unit` added to each state and input in turn;
/// `mass_part` and `part` extract the requested derivatives.
fn differentiate<D: Scalar>(
    (vehicle, trim, states): (&Vehicle, &Trim, States),
    seeds: &[(Parameter, D)],
    unit: D,
    mass_part: impl Fn(&D) -> f64,
    part: impl Fn(&D) -> f64,
) -> Descriptor {
    let lateral = are_lateral(states);
    let point = Point::new(vehicle, trim, lateral, seeds);
    let all: States = if lateral { &LATERAL } else { &LONGITUDINAL };
    // The states of a model are contiguous among all states.
    let first = all.iter().position(|state| Some(state) == states.first()).unwrap_or_default();
    let (n, inputs) = (states.len(), point.outputs.len());
    let (mut state, mut input) = (DMatrix::zeros(n, n), DMatrix::zeros(n, inputs));
    for column in 0..n + inputs {
        let seeded = if column < n { first + column } else { all.len() + column - n };
        let force = point.force(seeded, unit);
        for row in 0..n {
            let entry = if column < n { &mut state[(row, column)] } else { &mut input[(row, column - n)] };
            *entry = part(&force[first + row]);
        }
    }
    let mass = point.mass();
    let mass = DMatrix::from_fn(n, n, |i, j| mass_part(&mass[first + i][first + j]));
    Descriptor { mass, state, input }
}

/// Number of all states of longitudinal or lateral motion.
const ALL: usize = LONGITUDINAL.len();

/// Vehicle and trim over scalars that carry derivatives.
struct Point<D> {
    /// `true` for sway, roll and yaw; `false` for surge, heave and pitch.
    lateral: bool,
    coefficients: Coefficients<D>,
    effects: Vec<crate::vehicle::actuator::Effect<D>>,
    motion: Motion<D>,
    depth: D,
    outputs: Vec<D>,
}

impl<D: Scalar> Point<D> {
    fn new(vehicle: &Vehicle, trim: &Trim, lateral: bool, seeds: &[(Parameter, D)]) -> Self {
        let seeded = |parameter: Parameter, value: f64| {
            let start = D::from(value);
            seeds.iter().filter(|(p, _)| *p == parameter).fold(start, |sum, (_, seed)| sum + *seed)
        };
        let incidence = seeded(Parameter::Incidence, trim.incidence);
        let (sin, cos) = incidence.sin_cos();
        let actuators = vehicle.actuators.iter().enumerate();
        Self {
            lateral,
            coefficients: vehicle.coefficients.map(|key, value| seeded(Parameter::Coefficient(key), value)),
            effects: actuators
                .map(|(actuator, a)| {
                    a.effect.map(|key, value| seeded(Parameter::Effect { actuator, key }, value))
                })
                .collect(),
            motion: Motion::in_plane(cos * trim.speed, sin * trim.speed, D::from(0.0), incidence),
            depth: D::from(trim.depth),
            outputs: trim
                .actuators
                .iter()
                .enumerate()
                .map(|(i, t)| seeded(Parameter::Output(i), *t))
                .collect(),
        }
    }

    /// Returns the rates of all states times the mass matrix, with `unit` added to the state or input of index
    /// `column`.
    fn force(&self, column: usize, unit: D) -> [D; ALL] {
        let added = |index: usize, value: D| if index == column { value + unit } else { value };
        let pairs = self.effects.iter().zip(&self.outputs).enumerate();
        let outputs = pairs.map(|(i, (effect, output))| (effect, added(ALL + i, *output)));
        let zero = D::from(0.0);
        let Motion { u, w, q, theta, .. } = self.motion;
        if self.lateral {
            let [p, phi, v, heading_rate] = [0, 1, 2, 3].map(|index| added(index, zero));
            let r = heading_rate * theta.cos();
            let motion = Motion { p, phi, v, r, ..self.motion };
            let actuators = outputs
                .fold([zero; 3], |sum, (effect, output)| add(sum, effect.lateral_force(motion.u, output)));
            let [y, k, n] =
                self.coefficients.lateral_force(&motion, &motion.attitude(), self.depth, actuators);
            let [roll, ..] = motion.turning();
            return [k, roll, y, n, heading_rate];
        }
        let motion = Motion::in_plane(added(0, u), added(1, w), added(2, q), added(3, theta));
        let actuators =
            outputs.fold([zero; 3], |sum, (effect, output)| add(sum, effect.force(motion.u, output)));
        let [x, z, m] = self.coefficients.force(&motion, &motion.attitude(), added(4, self.depth), actuators);
        [x, z, m, motion.q, motion.depth_rate()]
    }

    /// Returns the mass matrix of all states.
    fn mass(&self) -> [[D; ALL]; ALL] {
        let (zero, one) = (D::from(0.0), D::from(1.0));
        let mut mass = [[zero; ALL]; ALL];
        (0..ALL).for_each(|i| mass[i][i] = one);
        // Indices of u, w, q, or of v, p, r.
        let (inertia, indices) = if self.lateral {
            (self.coefficients.lateral_mass_matrix(), [2, 0, 3])
        } else {
            (self.coefficients.mass_matrix(), [0, 1, 2])
        };
        let yaw = if self.lateral { self.motion.theta.cos() } else { one };
        for (i, row) in indices.into_iter().enumerate() {
            for (j, column) in indices.into_iter().enumerate() {
                mass[row][column] =
                    if self.lateral && j == 2 { inertia[(i, j)] * yaw } else { inertia[(i, j)] };
            }
        }
        mass
    }
}
