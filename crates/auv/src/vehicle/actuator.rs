//! Actuators: the output that follows a command, and the force of an output on the hull.

#![allow(non_snake_case, reason = "the field's symbols keep their capitals: Z is a force, z a length")]

use signals::{Curve, Force};

use crate::scalar::Scalar;
use crate::vehicle::allowed::Allowed;

/// What an actuator does to the hull.
#[derive(Clone, Debug, PartialEq)]
pub enum Effect<D = f64> {
    /// A thruster; its output is a thrust T \[N\].
    ///
    /// `X = T cos(direction)`, `Z = T sin(direction)`, `M = z X - x Z`.
    Thruster {
        /// Position forward of the origin \[m\].
        x: D,
        /// Position below the origin \[m\].
        z: D,
        /// Direction of positive thrust \[rad\]: 0 pushes the vehicle forward, pi/2 pushes it down.
        direction: D,
    },
    /// Several thrusters under one command, for instance a couple; its output T is the thrust of one with a share of 1
    /// \[N\].
    ///
    /// `X = X_T T`, `Z = Z_T T`, `M = M_T T`, with the sums over the thrusters `X_T = sum share cos(direction)`,
    /// `Z_T = sum share sin(direction)`, `M_T = sum share (z cos(direction) - x sin(direction))`.
    ThrusterGroup {
        /// Surge force per output \[1\].
        X_T: D,
        /// Heave force per output \[1\].
        Z_T: D,
        /// Pitch moment per output \[m\].
        M_T: D,
    },
    /// A control surface; its output is a deflection delta \[rad\].
    ///
    /// `Z = Z_uu_delta u|u| delta`, `M = M_uu_delta u|u| delta`, `X = X_uu_delta2 u|u| delta^2`. Published models
    /// print u^2; u|u| is the same ahead and has the right sign astern.
    ControlSurface {
        /// Heave force per u|u| delta \[kg/(m.rad)\].
        Z_uu_delta: D,
        /// Pitch moment per u|u| delta \[kg/rad\].
        M_uu_delta: D,
        /// Surge force per u|u| delta^2 \[kg/(m.rad2)\], zero or negative.
        X_uu_delta2: D,
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

    /// Returns the force per output about zero, that of a control surface at a surge speed of 1 m/s.
    pub fn force_per_output(&self) -> Force {
        let [there, back] = [1.0, -1.0].map(|output| self.force(1.0, output));
        std::array::from_fn(|i| 0.5 * (there[i] - back[i]))
    }

    /// Returns what a positive output does, in words.
    pub fn sign_in_words(&self) -> Option<String> {
        signals::sign_in_words(self.force_per_output(), self.unit())
    }

    /// Returns the output a time `elapsed` \[s\] after it was `start`, under a held command within or beyond the
    /// limits.
    ///
    /// `tau T' = sat(command) - T` has the solution `T = sat + (start - sat) exp(-elapsed / tau)`. With a limit r on
    /// the rate T is a straight line before, until `|sat - T|` is `r tau`.
    pub fn output_after(&self, elapsed: f64, start: f64, command: f64) -> f64 {
        let target = command.clamp(self.min, self.max);
        if self.lag <= 0.0 {
            return target;
        }
        let (time, start) = self.at_full_rate(elapsed, start, target, 0.0);
        target + (start - target) * (-(elapsed - time) / self.lag).exp()
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
            Self::Thruster { x, z, direction } => {
                let (sin, cos) = direction.sin_cos();
                [output * cos, output * sin, output * (z * cos - x * sin)]
            }
            Self::ThrusterGroup { X_T, Z_T, M_T } => [output * X_T, output * Z_T, output * M_T],
            Self::ControlSurface { Z_uu_delta, M_uu_delta, X_uu_delta2 } => {
                let deflection = u * u.abs() * output;
                [deflection * output * X_uu_delta2, deflection * Z_uu_delta, deflection * M_uu_delta]
            }
        }
    }
}

impl Effect {
    /// One of each kind, with every number zero.
    pub(crate) const ALL: [Self; 3] = [
        Self::Thruster { x: 0.0, z: 0.0, direction: 0.0 },
        Self::ThrusterGroup { X_T: 0.0, Z_T: 0.0, M_T: 0.0 },
        Self::ControlSurface { Z_uu_delta: 0.0, M_uu_delta: 0.0, X_uu_delta2: 0.0 },
    ];

    /// Its name in a vehicle file.
    pub(crate) fn kind(&self) -> &'static str {
        match self {
            Self::Thruster { .. } => "thruster",
            Self::ThrusterGroup { .. } => "thruster_group",
            Self::ControlSurface { .. } => "control_surface",
        }
    }

    /// Its numbers with their keys in a vehicle file.
    pub(crate) fn numbers(&self) -> [(&'static str, f64); 3] {
        match self.map(|key, value| (key, value)) {
            Effect::Thruster { x, z, direction } => [x, z, direction],
            Effect::ThrusterGroup { X_T, Z_T, M_T } => [X_T, Z_T, M_T],
            Effect::ControlSurface { Z_uu_delta, M_uu_delta, X_uu_delta2 } => {
                [Z_uu_delta, M_uu_delta, X_uu_delta2]
            }
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
            Self::Thruster { x, z, direction } => {
                Effect::Thruster { x: f("x", x), z: f("z", z), direction: f("direction", direction) }
            }
            Self::ThrusterGroup { X_T, Z_T, M_T } => {
                Effect::ThrusterGroup { X_T: f("X_T", X_T), Z_T: f("Z_T", Z_T), M_T: f("M_T", M_T) }
            }
            Self::ControlSurface { Z_uu_delta, M_uu_delta, X_uu_delta2 } => Effect::ControlSurface {
                Z_uu_delta: f("Z_uu_delta", Z_uu_delta),
                M_uu_delta: f("M_uu_delta", M_uu_delta),
                X_uu_delta2: f("X_uu_delta2", X_uu_delta2),
            },
        }
    }
}
