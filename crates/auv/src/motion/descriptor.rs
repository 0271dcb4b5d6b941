//! The linear motion before the mass matrix is inverted, and its derivatives with respect to the vehicle's
//! coefficients and its trim.
//!
//! Dual numbers of second and third order differentiate the code that simulates; there are no finite differences.

use crate::longitudinal::STATES;
use nalgebra::DMatrix;
use num_dual::{Dual64, HyperDual64, HyperHyperDual64};

use crate::motion::dynamics::{Motion, add};
use crate::motion::parameter::Parameter;
use crate::motion::trim::Trim;
use crate::scalar::Scalar;
use crate::vehicle::Vehicle;
use crate::vehicle::coefficients::Coefficients;

/// `M x' = C x + D (T - T0)` about a trim, with x = \[u w q theta z\] less its trim: without u at a given speed, and
/// without z where the depth is no state.
///
/// For n states M and C are n x n and D is n x m; the rows are surge force \[N\], heave force \[N\], pitch moment
/// \[N.m\], theta' = q, and z'. A is `M^-1 C` and B is `M^-1 D`. M, C and D are affine in most coefficients, and no
/// coefficient divides another.
///
/// Source: A. Sutarto, A. Budiyono, Indian J. Geo-Marine Sci. 40(2), 2011, section 3A.
#[derive(Clone, Debug, PartialEq)]
pub struct Descriptor {
    /// M.
    pub mass: DMatrix<f64>,
    /// C.
    pub state: DMatrix<f64>,
    /// D.
    pub input: DMatrix<f64>,
}

impl Descriptor {
    /// Returns M, C and D at a trim, which may be that of another vehicle with the same actuators.
    pub fn at(vehicle: &Vehicle, trim: &Trim, depth: bool) -> Self {
        differentiate((vehicle, trim, depth), &[], Dual64::new(0.0, 1.0), |d| d.re, |d| d.eps)
    }

    /// Returns the derivatives of M, C and D with respect to a parameter; all others and the trim are held.
    pub fn derivative(vehicle: &Vehicle, trim: &Trim, depth: bool, by: Parameter) -> Self {
        let zero = HyperDual64::from(0.0);
        let seeds = [(by, zero.derivative2())];
        differentiate((vehicle, trim, depth), &seeds, zero.derivative1(), |d| d.eps2, |d| d.eps1eps2)
    }

    /// Returns the second derivatives of M, C and D with respect to two parameters; all others and the trim are held.
    pub fn second_derivative(vehicle: &Vehicle, trim: &Trim, depth: bool, by: [Parameter; 2]) -> Self {
        let zero = HyperHyperDual64::from(0.0);
        let seeds = [(by[0], zero.derivative2()), (by[1], zero.derivative3())];
        let unit = zero.derivative1();
        differentiate((vehicle, trim, depth), &seeds, unit, |d| d.eps2eps3, |d| d.eps1eps2eps3)
    }

    /// Returns `[M C D]`, n x (2 n + m).
    pub fn stacked(&self) -> DMatrix<f64> {
        let (n, inputs) = self.input.shape();
        let mut whole = DMatrix::zeros(n, 2 * n + inputs);
        whole.columns_mut(0, n).copy_from(&self.mass);
        whole.columns_mut(n, n).copy_from(&self.state);
        whole.columns_mut(2 * n, inputs).copy_from(&self.input);
        whole
    }
}

/// Evaluates the forces with `seeds` added to the parameters and `unit` added to each state and input in turn;
/// `mass_part` and `part` extract the derivatives wanted.
fn differentiate<D: Scalar>(
    (vehicle, trim, depth): (&Vehicle, &Trim, bool),
    seeds: &[(Parameter, D)],
    unit: D,
    mass_part: impl Fn(&D) -> f64,
    part: impl Fn(&D) -> f64,
) -> Descriptor {
    let point = Point::new(vehicle, trim, seeds);
    let inputs = point.outputs.len();
    let all = STATES.len();
    let mut jacobian = DMatrix::zeros(all, all + inputs);
    for column in 0..all + inputs {
        let force = point.force(column, unit);
        (0..all).for_each(|row| jacobian[(row, column)] = part(&force[row]));
    }
    let inertia = point.coefficients.mass_matrix();
    let mut mass = DMatrix::zeros(all, all);
    (0..3).for_each(|i| (0..3).for_each(|j| mass[(i, j)] = mass_part(&inertia[(i, j)])));
    (3..all).for_each(|i| mass[(i, i)] = mass_part(&D::from(1.0)));
    let surge = vehicle.coefficients.surge;
    let (first, n) = (surge.first(), surge.states(depth).len());
    Descriptor {
        mass: mass.view((first, first), (n, n)).into_owned(),
        state: jacobian.view((first, first), (n, n)).into_owned(),
        input: jacobian.view((first, all), (n, inputs)).into_owned(),
    }
}

/// A vehicle and its trim over scalars that carry derivatives.
struct Point<D> {
    coefficients: Coefficients<D>,
    effects: Vec<crate::vehicle::actuator::Effect<D>>,
    motion: Motion<D>,
    depth: D,
    outputs: Vec<D>,
}

impl<D: Scalar> Point<D> {
    fn new(vehicle: &Vehicle, trim: &Trim, seeds: &[(Parameter, D)]) -> Self {
        let seeded = |parameter: Parameter, value: f64| {
            let start = D::from(value);
            seeds.iter().filter(|(p, _)| *p == parameter).fold(start, |sum, (_, seed)| sum + *seed)
        };
        let incidence = seeded(Parameter::Incidence, trim.incidence);
        let (sin, cos) = incidence.sin_cos();
        let actuators = vehicle.actuators.iter().enumerate();
        Self {
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

    /// Surge force, heave force, pitch moment, theta' and z', with `unit` added to the state or input with index
    /// `column`.
    fn force(&self, column: usize, unit: D) -> [D; STATES.len()] {
        let added = |place: usize, value: D| if place == column { value + unit } else { value };
        let Motion { u, w, q, theta, .. } = self.motion;
        let motion = Motion::in_plane(added(0, u), added(1, w), added(2, q), added(3, theta));
        let zero = [D::from(0.0); 3];
        let pairs = self.effects.iter().zip(&self.outputs).enumerate();
        let actuators = pairs.fold(zero, |sum, (i, (effect, output))| {
            add(sum, effect.force(motion.u, added(STATES.len() + i, *output)))
        });
        let [x, z, m] = self.coefficients.force(&motion, added(4, self.depth), actuators);
        [x, z, m, motion.q, motion.sinking()]
    }
}
