//! Actuators: from command to output, and from output to force on the hull.

#![allow(non_snake_case, reason = "the field's symbols keep their capitals: Z is a force, z a length")]

use squid_signals::{Curve, Force};

use crate::scalar::Scalar;
use crate::vehicle::allowed::Allowed;

/// Force of an actuator on the hull.
#[derive(Clone, Debug, PartialEq)]
pub enum Effect<D = f64> {
    /// Thruster; its output is a thrust T \[N\] along `e = (cos(direction) cos(azimuth), cos(direction) sin(azimuth),
    /// sin(direction))`.
    ///
    /// `(X, Y, Z) = T e`, `(K, M, N) = T ((x, y, z) x e + torque e)`; in the vertical plane `X = T cos(direction)`,
    /// `Z = T sin(direction)`, `M = z X - x Z`.
    Thruster {
        /// Position forward of the origin \[m\].
        x: D,
        /// Position to starboard of the origin \[m\].
        y: D,
        /// Position below the origin \[m\].
        z: D,
        /// Direction of positive thrust in the vertical plane \[rad\]: forward for 0, down for pi/2.
        direction: D,
        /// Rotation of this direction to starboard \[rad\]: pi/2 pushes the vehicle to starboard.
        azimuth: D,
        /// Propeller torque about the direction per thrust \[m\].
        torque: D,
    },
    /// Several thrusters under one command, for instance a couple. The output T is the thrust of one with a share of 1
    /// \[N\]; each number is the sum over the thrusters, weighted by their shares.
    ThrusterGroup {
        /// Surge force per output \[1\].
        X_T: D,
        /// Sway force per output \[1\].
        Y_T: D,
        /// Heave force per output \[1\].
        Z_T: D,
        /// Roll moment per output \[m\].
        K_T: D,
        /// Pitch moment per output \[m\].
        M_T: D,
        /// Yaw moment per output \[m\].
        N_T: D,
    },
    /// Control surface; its output is a deflection delta \[rad\].
    ///
    /// `Z = Z_uu_delta u|u| delta`, and the same with M, Y, K and N; `X = X_uu_delta2 u|u| delta^2`. Published models
    /// print u^2; u|u| is the same ahead and has the right sign astern.
    ControlSurface {
        /// Heave force per u|u| delta \[kg/(m.rad)\].
        Z_uu_delta: D,
        /// Pitch moment per u|u| delta \[kg/rad\].
        M_uu_delta: D,
        /// Surge force per u|u| delta^2 \[kg/(m.rad2)\], zero or negative.
        X_uu_delta2: D,
        /// Sway force per u|u| delta \[kg/(m.rad)\].
        Y_uu_delta: D,
        /// Roll moment per u|u| delta \[kg/rad\].
        K_uu_delta: D,
        /// Yaw moment per u|u| delta \[kg/rad\].
        N_uu_delta: D,
    },
}

/// Actuator: thruster curve (if any), saturation, first-order lag, and the force on the hull.
///
/// Commands are outputs; for a thruster with a curve, [`Actuator::requested_output`] converts its input to a thrust.
/// The lag acts on the thrust, and a limit r on the rate saturates its derivative: `T' = clamp((sat(command) - T)/tau,
/// -r, r)` (R. A. Hess, S. A. Snell, "Flight control system design with rate saturating actuators", J. Guidance,
/// Control, and Dynamics 20(1), 1997).
#[derive(Clone, Debug, PartialEq)]
pub struct Actuator {
    /// Name, unique on the vehicle.
    pub name: String,
    /// Least output \[N or rad\].
    pub min: f64,
    /// Greatest output \[N or rad\].
    pub max: f64,
    /// Time constant of the lag \[s\]; 0 for no lag.
    pub lag: f64,
    /// Rate limit of the output in both directions \[N/s or rad/s\], above zero, requires a lag; `None` for no limit.
    pub rate: Option<f64>,
    /// Curve from the input of a thruster to its thrust; `None` if its input is the thrust.
    pub curve: Option<Curve>,
    /// Force on the hull.
    pub effect: Effect,
}

/// Returns half the difference of the first and the second force: the slope from the forces at 1 and -1.
fn slope([forward, backward]: [Force; 2]) -> Force {
    std::array::from_fn(|i| 0.5 * (forward[i] - backward[i]))
}

impl Actuator {
    /// Returns the unit of the output: `N` for a thruster or a group, `rad` for a control surface.
    pub fn unit(&self) -> &'static str {
        match self.effect {
            Effect::Thruster { .. } | Effect::ThrusterGroup { .. } => "N",
            Effect::ControlSurface { .. } => "rad",
        }
    }

    /// Returns the unit of the input: that of the curve, or of the output.
    pub fn input_unit(&self) -> &str {
        self.curve.as_ref().map_or(self.unit(), Curve::unit)
    }

    /// Returns the output requested by an input, before limits and lag, and the slope, the right-hand one at a corner.
    pub fn requested_output(&self, command: f64) -> (f64, f64) {
        self.curve.as_ref().map_or((command, 1.0), |curve| curve.thrust(command))
    }

    /// Returns the input for an output, by the inverse of the curve, and the slope; see [`Curve::command`].
    pub fn input_for(&self, output: f64) -> (f64, f64) {
        self.curve.as_ref().map_or((output, 1.0), |curve| curve.command(output))
    }

    /// Returns surge force, heave force and pitch moment of an output at a surge speed `u` through the water.
    pub fn force<D: Scalar>(&self, u: D, output: D) -> [D; 3] {
        self.effect.map(|_, value| D::from(value)).force(u, output)
    }

    /// Returns sway force, roll moment and yaw moment of an output at a surge speed `u` through the water.
    pub fn lateral_force<D: Scalar>(&self, u: D, output: D) -> [D; 3] {
        self.effect.map(|_, value| D::from(value)).lateral_force(u, output)
    }

    /// Returns the force \[X Z M\] per output, at zero output; for a control surface at a surge speed of 1 m/s.
    pub fn force_per_output(&self) -> Force {
        slope([1.0, -1.0].map(|output| self.force(1.0, output)))
    }

    /// Returns the force \[Y K N\] per output across the vertical plane.
    pub fn lateral_force_per_output(&self) -> Force {
        slope([1.0, -1.0].map(|output| self.lateral_force(1.0, output)))
    }

    /// Returns the effect of a positive output, as text.
    pub fn effect_of_sign(&self) -> Option<String> {
        squid_signals::effect_of_sign(self.force_per_output(), self.lateral_force_per_output(), self.unit())
    }

    /// Returns the output at a time `elapsed` \[s\] after `start`, under a held command within or beyond the limits.
    ///
    /// `tau T' = sat(command) - T` has the solution `T = sat + (start - sat) exp(-elapsed / tau)`. With a rate limit r,
    /// T first changes linearly, until `|sat - T|` equals `r tau`.
    pub fn output_after(&self, elapsed: f64, start: f64, command: f64) -> f64 {
        self.output_with(&mut f64::exp, elapsed, start, command)
    }

    /// Returns the output of [`Actuator::output_after`], computed with the given exponential function.
    pub(crate) fn output_with(
        &self,
        exp: &mut impl FnMut(f64) -> f64,
        elapsed: f64,
        start: f64,
        command: f64,
    ) -> f64 {
        let target = command.clamp(self.min, self.max);
        if self.lag <= 0.0 {
            return target;
        }
        let (time, start) = self.at_full_rate(elapsed, start, target, 0.0);
        target + (start - target) * exp(-(elapsed - time) / self.lag)
    }

    /// Returns the time \[s\], up to `elapsed`, for which the output runs at its rate limit after a command `command +
    /// slope t` within the limits, and the output then.
    pub(crate) fn at_full_rate(&self, elapsed: f64, start: f64, command: f64, slope: f64) -> (f64, f64) {
        let error = command - start;
        let Some(rate) = self.rate.filter(|rate| error.abs() > rate * self.lag) else { return (0.0, start) };
        let closing_rate = rate - slope * error.signum();
        let saturated_time = (error.abs() - rate * self.lag) / closing_rate;
        let time = if closing_rate > 0.0 { saturated_time.min(elapsed) } else { elapsed };
        (time, start + rate.copysign(error) * time)
    }

    /// Returns the largest size of the output \[N or rad\], used to scale outputs of different actuators for
    /// comparison.
    pub fn reach(&self) -> f64 {
        self.min.abs().max(self.max.abs())
    }
}

impl<D: Scalar> Effect<D> {
    /// Returns surge force, heave force and pitch moment of an output at a surge speed `u` through the water.
    pub(crate) fn force(&self, u: D, output: D) -> [D; 3] {
        match *self {
            Self::Thruster { x, z, direction, azimuth, torque, .. } => {
                let [ahead, across, down] = axis(direction, azimuth);
                [output * ahead, output * down, output * (z * ahead - x * down + torque * across)]
            }
            Self::ThrusterGroup { X_T, Z_T, M_T, .. } => [output * X_T, output * Z_T, output * M_T],
            Self::ControlSurface { Z_uu_delta, M_uu_delta, X_uu_delta2, .. } => {
                let deflection = u * u.abs() * output;
                [deflection * output * X_uu_delta2, deflection * Z_uu_delta, deflection * M_uu_delta]
            }
        }
    }

    /// Returns sway force, roll moment and yaw moment of an output at a surge speed `u` through the water.
    pub(crate) fn lateral_force(&self, u: D, output: D) -> [D; 3] {
        match *self {
            Self::Thruster { x, y, z, direction, azimuth, torque } => {
                let [ahead, across, down] = axis(direction, azimuth);
                let roll = y * down - z * across + torque * ahead;
                let yaw = x * across - y * ahead + torque * down;
                [output * across, output * roll, output * yaw]
            }
            Self::ThrusterGroup { Y_T, K_T, N_T, .. } => [output * Y_T, output * K_T, output * N_T],
            Self::ControlSurface { Y_uu_delta, K_uu_delta, N_uu_delta, .. } => {
                let deflection = u * u.abs() * output;
                [deflection * Y_uu_delta, deflection * K_uu_delta, deflection * N_uu_delta]
            }
        }
    }
}

/// Forces of an actuator for simulation, with the directions of thrusters computed once.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ActuatorForces {
    /// Force \[X Z M Y K N\] per output, for a control surface at a surge speed of 1 m/s; without `drag`.
    per_output: [f64; 6],
    /// Surge force X per output squared, for a control surface at 1 m/s.
    drag: f64,
    is_surface: bool,
}

impl ActuatorForces {
    pub(crate) fn of(actuator: &Actuator) -> Self {
        let ([ahead, heave, pitch], [sway, roll, yaw]) =
            (actuator.effect.force(1.0, 1.0), actuator.effect.lateral_force(1.0, 1.0));
        let is_surface = matches!(actuator.effect, Effect::ControlSurface { .. });
        let (surge, drag) = if is_surface { (0.0, ahead) } else { (ahead, 0.0) };
        Self { per_output: [surge, heave, pitch, sway, roll, yaw], drag, is_surface }
    }

    /// Returns the first N of the total forces \[X Z M Y K N\] at a surge speed `u` through the water.
    pub(crate) fn all<D: Scalar, const N: usize>(
        all_forces: &[Self],
        u: D,
        outputs: impl Iterator<Item = D>,
    ) -> [D; N] {
        let pressure = u * u.abs();
        all_forces.iter().zip(outputs).fold([D::from(0.0); N], |mut sum, (forces, output)| {
            let scaled = if forces.is_surface { pressure * output } else { output };
            for (sum, per_output) in sum.iter_mut().zip(forces.per_output) {
                *sum += scaled * per_output;
            }
            if forces.is_surface {
                sum[0] += scaled * output * forces.drag;
            }
            sum
        })
    }
}

/// Returns the direction of a thrust.
fn axis<D: Scalar>(direction: D, azimuth: D) -> [D; 3] {
    let ((sin, cos), (to_starboard, ahead)) = (direction.sin_cos(), azimuth.sin_cos());
    [cos * ahead, cos * to_starboard, sin]
}

/// Coefficients of all kinds of actuators: key in a vehicle file, SI unit, `true` if it acts in sway, roll and yaw
/// only.
const NUMBERS: [(&str, &str, bool); 18] = [
    ("x", "m", false),
    ("y", "m", true),
    ("z", "m", false),
    ("direction", "rad", false),
    ("azimuth", "rad", true),
    ("torque", "m", true),
    ("X_T", "1", false),
    ("Y_T", "1", true),
    ("Z_T", "1", false),
    ("K_T", "m", true),
    ("M_T", "m", false),
    ("N_T", "m", true),
    ("Z_uu_delta", "kg/(m.rad)", false),
    ("M_uu_delta", "kg/rad", false),
    ("X_uu_delta2", "kg/(m.rad2)", false),
    ("Y_uu_delta", "kg/(m.rad)", true),
    ("K_uu_delta", "kg/rad", true),
    ("N_uu_delta", "kg/rad", true),
];

impl Effect {
    /// Returns a thruster in the vertical plane.
    pub const fn thruster(x: f64, z: f64, direction: f64) -> Self {
        Self::Thruster { x, y: 0.0, z, direction, azimuth: 0.0, torque: 0.0 }
    }

    /// Returns a group of thrusters in the vertical plane, or symmetric to port and starboard.
    pub const fn thruster_group(X_T: f64, Z_T: f64, M_T: f64) -> Self {
        Self::ThrusterGroup { X_T, Y_T: 0.0, Z_T, K_T: 0.0, M_T, N_T: 0.0 }
    }

    /// Returns stern planes.
    pub const fn planes(Z_uu_delta: f64, M_uu_delta: f64, X_uu_delta2: f64) -> Self {
        let (Y_uu_delta, K_uu_delta, N_uu_delta) = (0.0, 0.0, 0.0);
        Self::ControlSurface { Z_uu_delta, M_uu_delta, X_uu_delta2, Y_uu_delta, K_uu_delta, N_uu_delta }
    }

    /// All kinds, with every number zero.
    pub(crate) const ALL: [Self; 3] =
        [Self::thruster(0.0, 0.0, 0.0), Self::thruster_group(0.0, 0.0, 0.0), Self::planes(0.0, 0.0, 0.0)];

    /// Returns `true` if there is a sway force, roll moment or yaw moment.
    pub(crate) fn leaves_plane(&self) -> bool {
        self.lateral_force(1.0, 1.0).into_iter().any(|one| one != 0.0)
    }

    /// Returns `true` if a number acts in sway, roll and yaw only, by its key in a vehicle file.
    pub(crate) fn acts_out_of_plane(key: &str) -> bool {
        NUMBERS.iter().any(|(one, _, sideways)| *one == key && *sideways)
    }

    /// Returns the SI unit of a number, by its key in a vehicle file.
    pub(crate) fn unit_of(key: &str) -> &'static str {
        NUMBERS.iter().find(|(one, ..)| *one == key).map_or("1", |(_, unit, _)| unit)
    }

    /// Returns `true` if the force does not depend on the speed, as for a thruster.
    pub(crate) fn works_at_rest(&self) -> bool {
        !matches!(self, Self::ControlSurface { .. })
    }

    /// Returns `true` if there may be a surge force.
    pub(crate) fn acts_along(&self) -> bool {
        match self {
            Self::ControlSurface { X_uu_delta2, .. } => *X_uu_delta2 != 0.0,
            Self::Thruster { .. } | Self::ThrusterGroup { .. } => true,
        }
    }

    /// Returns the name of the kind in a vehicle file.
    pub(crate) fn kind(&self) -> &'static str {
        match self {
            Self::Thruster { .. } => "thruster",
            Self::ThrusterGroup { .. } => "thruster_group",
            Self::ControlSurface { .. } => "control_surface",
        }
    }

    /// Returns the numbers with their keys in a vehicle file.
    pub(crate) fn numbers(&self) -> [(&'static str, f64); 6] {
        match self.map(|key, value| (key, value)) {
            Effect::Thruster { x, y, z, direction, azimuth, torque } => [x, y, z, direction, azimuth, torque],
            Effect::ThrusterGroup { X_T, Y_T, Z_T, K_T, M_T, N_T } => [X_T, Y_T, Z_T, K_T, M_T, N_T],
            Effect::ControlSurface {
                Z_uu_delta,
                M_uu_delta,
                X_uu_delta2,
                Y_uu_delta,
                K_uu_delta,
                N_uu_delta,
            } => [Z_uu_delta, M_uu_delta, X_uu_delta2, Y_uu_delta, K_uu_delta, N_uu_delta],
        }
    }
}

/// Condition on the lag of an actuator with a rate limit.
pub(crate) const LAG_WITH_RATE: &str =
    "above zero if a rate is given, because the rate limit is part of the lag";

/// Returns the allowed values of a number of an actuator.
pub(crate) fn allowed(key: &str) -> Allowed {
    match key {
        "lag" => Allowed::NonNegative,
        "rate" => Allowed::Positive,
        "X_uu_delta2" => Allowed::NonPositive,
        _ => Allowed::Any,
    }
}

/// Returns `true` if a name may be part of the name of a variable.
pub(crate) fn is_actuator_name(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

impl<C: Copy> Effect<C> {
    /// Returns the effect with every number replaced by `f(key, value)`, with the key of the vehicle file.
    pub fn map<D>(&self, f: impl Fn(&'static str, C) -> D) -> Effect<D> {
        match *self {
            Self::Thruster { x, y, z, direction, azimuth, torque } => Effect::Thruster {
                x: f("x", x),
                y: f("y", y),
                z: f("z", z),
                direction: f("direction", direction),
                azimuth: f("azimuth", azimuth),
                torque: f("torque", torque),
            },
            Self::ThrusterGroup { X_T, Y_T, Z_T, K_T, M_T, N_T } => Effect::ThrusterGroup {
                X_T: f("X_T", X_T),
                Y_T: f("Y_T", Y_T),
                Z_T: f("Z_T", Z_T),
                K_T: f("K_T", K_T),
                M_T: f("M_T", M_T),
                N_T: f("N_T", N_T),
            },
            Self::ControlSurface {
                Z_uu_delta,
                M_uu_delta,
                X_uu_delta2,
                Y_uu_delta,
                K_uu_delta,
                N_uu_delta,
            } => Effect::ControlSurface {
                Z_uu_delta: f("Z_uu_delta", Z_uu_delta),
                M_uu_delta: f("M_uu_delta", M_uu_delta),
                X_uu_delta2: f("X_uu_delta2", X_uu_delta2),
                Y_uu_delta: f("Y_uu_delta", Y_uu_delta),
                K_uu_delta: f("K_uu_delta", K_uu_delta),
                N_uu_delta: f("N_uu_delta", N_uu_delta),
            },
        }
    }
}
