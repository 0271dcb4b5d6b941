//! Actuators: the output that follows a command, and the force of an output on the hull.

#![allow(non_snake_case, reason = "the field's symbols keep their capitals: Z is a force, z a length")]

use squid_signals::{Curve, Force};

use crate::scalar::Scalar;
use crate::vehicle::allowed::Allowed;

/// What an actuator does to the hull.
#[derive(Clone, Debug, PartialEq)]
pub enum Effect<D = f64> {
    /// A thruster; its output is a thrust T \[N\] along `e = (cos(direction) cos(azimuth), cos(direction)
    /// sin(azimuth), sin(direction))`.
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
        /// Direction of positive thrust in the vertical plane \[rad\]: 0 pushes the vehicle forward, pi/2 pushes it
        /// down.
        direction: D,
        /// How far this is turned to starboard \[rad\]: pi/2 pushes the vehicle to starboard.
        azimuth: D,
        /// Moment about the direction per thrust \[m\], by the torque of the propeller.
        torque: D,
    },
    /// Several thrusters under one command, for instance a couple; its output T is the thrust of one with a share of 1
    /// \[N\], and each number the sum over the thrusters of their shares times that of a thruster.
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
    /// A control surface; its output is a deflection delta \[rad\].
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

/// An actuator: the curve of a thruster that has one, saturation and first-order lag, then its effect on the hull.
///
/// What is commanded is an output: that of a thruster with a curve is the thrust [`Actuator::asked`] by what it takes.
/// The lag acts on that thrust, and a limit r on the rate cuts off its speed: `T' = clamp((sat(command) - T)/tau, -r,
/// r)` (R. A. Hess, S. A. Snell, "Flight control system design with rate saturating actuators", J. Guidance, Control,
/// and Dynamics 20(1), 1997).
#[derive(Clone, Debug, PartialEq)]
pub struct Actuator {
    /// Its name, unique on the vehicle.
    pub name: String,
    /// Least output \[N or rad\].
    pub min: f64,
    /// Greatest output \[N or rad\].
    pub max: f64,
    /// Time constant of the lag \[s\]; 0 follows the command at once.
    pub lag: f64,
    /// Fastest change of the output either way \[N/s or rad/s\], above zero, with a lag; `None` without such a limit.
    pub rate: Option<f64>,
    /// From what a thruster takes to the thrust that it gives; `None` where it takes the output itself.
    pub curve: Option<Curve>,
    /// What it does to the hull.
    pub effect: Effect,
}

/// What changes from the second to the first, by half: of the forces of 1 and -1.
fn slope([there, back]: [Force; 2]) -> Force {
    std::array::from_fn(|i| 0.5 * (there[i] - back[i]))
}

impl Actuator {
    /// Returns the unit of its output: `N` of a thruster or a group of them, `rad` of a control surface.
    pub fn unit(&self) -> &'static str {
        match self.effect {
            Effect::Thruster { .. } | Effect::ThrusterGroup { .. } => "N",
            Effect::ControlSurface { .. } => "rad",
        }
    }

    /// Returns the unit of what it takes: that of its curve, or of its output.
    pub fn taken_unit(&self) -> &str {
        self.curve.as_ref().map_or(self.unit(), Curve::unit)
    }

    /// Returns the output that is asked for by what it takes, and the slope, at a corner the right-hand one; limits and
    /// lag come after.
    pub fn asked(&self, command: f64) -> (f64, f64) {
        self.curve.as_ref().map_or((command, 1.0), |curve| curve.thrust(command))
    }

    /// Returns what it takes for an output, by the inverse of its curve, and the slope as [`Curve::command`] does.
    pub fn taken(&self, output: f64) -> (f64, f64) {
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

    /// Returns the force per output about zero, that of a control surface at a surge speed of 1 m/s: \[X Z M\].
    pub fn force_per_output(&self) -> Force {
        slope([1.0, -1.0].map(|output| self.force(1.0, output)))
    }

    /// Returns the same across the vertical plane: \[Y K N\].
    pub fn lateral_force_per_output(&self) -> Force {
        slope([1.0, -1.0].map(|output| self.lateral_force(1.0, output)))
    }

    /// Returns what a positive output does, in words.
    pub fn sign_in_words(&self) -> Option<String> {
        squid_signals::sign_in_words(self.force_per_output(), self.lateral_force_per_output(), self.unit())
    }

    /// Returns the output a time `elapsed` \[s\] after it was `start`, under a held command within or beyond the
    /// limits.
    ///
    /// `tau T' = sat(command) - T` has the solution `T = sat + (start - sat) exp(-elapsed / tau)`. With a limit r on
    /// the rate T is a straight line before, until `|sat - T|` is `r tau`.
    pub fn output_after(&self, elapsed: f64, start: f64, command: f64) -> f64 {
        self.output_with(&mut f64::exp, elapsed, start, command)
    }

    /// Returns the output as [`Actuator::output_after`] does, by a given exponential function.
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

    /// Returns how long \[s\], of a time `elapsed`, it runs at the limit of its rate after a command `command + slope
    /// t` within the limits, from the start on, and its output then.
    pub(crate) fn at_full_rate(&self, elapsed: f64, start: f64, command: f64, slope: f64) -> (f64, f64) {
        let error = command - start;
        let Some(rate) = self.rate.filter(|rate| error.abs() > rate * self.lag) else { return (0.0, start) };
        let closing = rate - slope * error.signum();
        let late = (error.abs() - rate * self.lag) / closing;
        let time = if closing > 0.0 { late.min(elapsed) } else { elapsed };
        (time, start + rate.copysign(error) * time)
    }

    /// Returns the largest size of its output \[N or rad\], by which outputs of different actuators are scaled for
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

    /// Returns sway force, roll moment and yaw moment.
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

/// The forces of an actuator as numbers of their own, for simulation: directions of thrusters are worked out once.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Push {
    /// \[X Z M Y K N\] per output, of a control surface at a surge speed of 1 m/s, without the next.
    per_output: [f64; 6],
    /// X per output squared, of a control surface at 1 m/s.
    drag: f64,
    is_surface: bool,
}

impl Push {
    pub(crate) fn of(actuator: &Actuator) -> Self {
        let ([ahead, heave, pitch], [sway, roll, yaw]) =
            (actuator.effect.force(1.0, 1.0), actuator.effect.lateral_force(1.0, 1.0));
        let is_surface = matches!(actuator.effect, Effect::ControlSurface { .. });
        let (surge, drag) = if is_surface { (0.0, ahead) } else { (ahead, 0.0) };
        Self { per_output: [surge, heave, pitch, sway, roll, yaw], drag, is_surface }
    }

    /// Returns the first N of the forces \[X Z M Y K N\] of outputs at a surge speed `u` through the water.
    pub(crate) fn all<D: Scalar, const N: usize>(
        pushes: &[Self],
        u: D,
        outputs: impl Iterator<Item = D>,
    ) -> [D; N] {
        let pressure = u * u.abs();
        pushes.iter().zip(outputs).fold([D::from(0.0); N], |mut sum, (push, output)| {
            let of = if push.is_surface { pressure * output } else { output };
            for (sum, per_output) in sum.iter_mut().zip(push.per_output) {
                *sum += of * per_output;
            }
            if push.is_surface {
                sum[0] += of * output * push.drag;
            }
            sum
        })
    }
}

/// The direction of a thrust.
fn axis<D: Scalar>(direction: D, azimuth: D) -> [D; 3] {
    let ((sin, cos), (to_starboard, ahead)) = (direction.sin_cos(), azimuth.sin_cos());
    [cos * ahead, cos * to_starboard, sin]
}

/// The numbers of all kinds by their keys in a vehicle file, with their SI units, and whether they act in sway, roll
/// and yaw alone.
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
    /// A thruster in the vertical plane.
    pub const fn thruster(x: f64, z: f64, direction: f64) -> Self {
        Self::Thruster { x, y: 0.0, z, direction, azimuth: 0.0, torque: 0.0 }
    }

    /// A group of thrusters in the vertical plane, or alike to port and starboard.
    pub const fn thruster_group(X_T: f64, Z_T: f64, M_T: f64) -> Self {
        Self::ThrusterGroup { X_T, Y_T: 0.0, Z_T, K_T: 0.0, M_T, N_T: 0.0 }
    }

    /// Stern planes.
    pub const fn planes(Z_uu_delta: f64, M_uu_delta: f64, X_uu_delta2: f64) -> Self {
        let (Y_uu_delta, K_uu_delta, N_uu_delta) = (0.0, 0.0, 0.0);
        Self::ControlSurface { Z_uu_delta, M_uu_delta, X_uu_delta2, Y_uu_delta, K_uu_delta, N_uu_delta }
    }

    /// One of each kind, with every number zero.
    pub(crate) const ALL: [Self; 3] =
        [Self::thruster(0.0, 0.0, 0.0), Self::thruster_group(0.0, 0.0, 0.0), Self::planes(0.0, 0.0, 0.0)];

    /// Returns whether it has a sway force, roll moment or yaw moment.
    pub(crate) fn leaves_plane(&self) -> bool {
        self.lateral_force(1.0, 1.0).into_iter().any(|one| one != 0.0)
    }

    /// Returns whether a number acts in sway, roll and yaw alone, by its key in a vehicle file.
    pub(crate) fn acts_out_of_plane(key: &str) -> bool {
        NUMBERS.iter().any(|(one, _, sideways)| *one == key && *sideways)
    }

    /// Returns the SI unit of a number, by its key in a vehicle file.
    pub(crate) fn unit_of(key: &str) -> &'static str {
        NUMBERS.iter().find(|(one, ..)| *one == key).map_or("1", |(_, unit, _)| unit)
    }

    /// Returns whether its force does not depend on the speed: that of a thruster.
    pub(crate) fn works_at_rest(&self) -> bool {
        !matches!(self, Self::ControlSurface { .. })
    }

    /// Returns whether it pushes or brakes along the hull.
    pub(crate) fn acts_along(&self) -> bool {
        match self {
            Self::ControlSurface { X_uu_delta2, .. } => *X_uu_delta2 != 0.0,
            Self::Thruster { .. } | Self::ThrusterGroup { .. } => true,
        }
    }

    /// Its name in a vehicle file.
    pub(crate) fn kind(&self) -> &'static str {
        match self {
            Self::Thruster { .. } => "thruster",
            Self::ThrusterGroup { .. } => "thruster_group",
            Self::ControlSurface { .. } => "control_surface",
        }
    }

    /// Its numbers with their keys in a vehicle file.
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

/// What a lag must be where the rate is limited.
pub(crate) const NEEDED_BY_RATE: &str = "above zero where a rate is given: the rate limit is that of the lag";

/// The values that a number of an actuator may take.
pub(crate) fn allowed(key: &str) -> Allowed {
    match key {
        "lag" => Allowed::NonNegative,
        "rate" => Allowed::Positive,
        "X_uu_delta2" => Allowed::NonPositive,
        _ => Allowed::Any,
    }
}

/// Whether a name may be part of the name of a variable.
pub(crate) fn is_actuator_name(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

impl<C: Copy> Effect<C> {
    /// Turns every number into `f(key, value)`, with the key of the vehicle file.
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
