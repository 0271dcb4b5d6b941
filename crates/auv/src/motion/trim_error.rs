//! Why there is no trim, each as one sentence.

use thiserror::Error;

use crate::vehicle::coefficients::CoefficientError;
use crate::words::Rounded;

/// Why there is no trim.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum TrimError {
    /// The coefficients are not allowed.
    #[error(transparent)]
    Coefficients(#[from] CoefficientError),
    /// The speed is not a number.
    #[error("the trim speed is {} m/s, and must be a finite number", Rounded(*speed))]
    SpeedNotFinite { speed: f64 },
    /// The depth is not a number.
    #[error("the trim depth is {} m, and must be a finite number", Rounded(*depth))]
    DepthNotFinite { depth: f64 },
    /// The pitch is not a number.
    #[error("the pitch of a climb is {} deg, and must be a finite number", Rounded(pitch.to_degrees()))]
    PitchNotFinite { pitch: f64 },
    /// The rate of a turn is not a number that can be reached.
    #[error("the rate of the turn is {} deg/s, and must be a finite number", Rounded(rate.to_degrees()))]
    RateNotFinite { rate: f64 },
    /// The vehicle has no inertia in roll.
    #[error(
        "the vehicle moves in the vertical plane alone, and does not turn: give 'mass.I_xx' and what it says is \
            missing then in the vehicle file"
    )]
    NoLateral,
    /// No motion and outputs make a steady turn.
    #[error(
        "no steady turn of {} deg/s at {} m/s and {} m: no outputs of the actuators balance it at constant depth \
            (nearest with {} m/s2 or rad/s2 left)",
        Rounded(*rate_deg), Rounded(*speed), Rounded(*depth), Rounded(*residual)
    )]
    NoTurn { speed: f64, depth: f64, rate_deg: f64, residual: f64 },
    /// No incidence and outputs balance the forces.
    #[error(
        "no level trim at {} m/s and {} m: lift and actuators do not balance a weight of {} N, a buoyancy of \
            {} N and the moments (nearest at an incidence of {incidence_deg:.1} deg, with {} m/s2 or rad/s2 \
            left); what may help: more speed, weight and buoyancy closer together, a vertical thruster",
        Rounded(*speed), Rounded(*depth), Rounded(*weight), Rounded(*buoyancy), Rounded(*residual)
    )]
    NotFound { speed: f64, depth: f64, weight: f64, buoyancy: f64, incidence_deg: f64, residual: f64 },
    /// No level trim, and no thruster that pushes along the hull.
    #[error(
        "no level trim at {} m/s and {} m: {}; add a thruster that pushes along the hull, or say [surge] speed = \
            \"given\" in the vehicle file of a vehicle whose speed is given from outside",
        Rounded(*speed), Rounded(*depth), unbalanced(*drag)
    )]
    NoThrust { speed: f64, depth: f64, drag: f64 },
    /// No outputs balance the forces at the pitch that is held.
    #[error(
        "no trim at {} m/s and {} m with the pitch held at {} deg: at best {} N of surge force, {} N of heave force \
            and {} N.m of pitching moment are left, which no actuator takes up; set 'trim.pitch' to \"free\" in the \
            design file, or add a thruster that pushes there",
        Rounded(*speed), Rounded(*depth), Rounded(*pitch_deg), part(*surge, [*heave, *moment]),
        part(*heave, [*surge, *moment]), part(*moment, [*surge, *heave])
    )]
    NotHeld { speed: f64, depth: f64, pitch_deg: f64, surge: f64, heave: f64, moment: f64 },
    /// Trims at neighbouring speeds lie on different branches.
    #[error(
        "the level trim jumps at {} m/s: {quantity} goes from {} to {} {unit} at once, however close the speeds; hold \
            the pitch by 'trim.pitch' in the design file (\"level\", or an angle), or choose a range of speeds to one \
            side of the jump",
        Rounded(*speed), Rounded(*before), Rounded(*after)
    )]
    Jump { speed: f64, quantity: String, before: f64, after: f64, unit: &'static str },
    /// The forward speed, by which an autopilot looks up the trim, does not rise with the speed along the path.
    #[error(
        "at {} m/s along the path, where the pitch in level trim is {} deg, that pitch changes so fast with the speed \
            that the forward speed falls while the speed along the path rises; an autopilot that knows the forward \
            speed cannot tell these trims apart: choose a range of speeds on one side of that, or hold the pitch by \
            'trim.pitch' in the design file (\"level\", or an angle)",
        Rounded(*speed), Rounded(*pitch_deg)
    )]
    ForwardSpeedFalls { speed: f64, pitch_deg: f64 },
    /// The trim needs an output beyond the limits of an actuator, angles in degrees.
    #[error(
        "level trim at {} m/s and {} m needs {} {unit} of {actuator}, {} {unit} beyond its limits {} .. {} {unit}",
        Rounded(*speed), Rounded(*depth), Rounded(*needed), Rounded(*excess), Rounded(*min), Rounded(*max)
    )]
    BeyondLimits {
        speed: f64,
        depth: f64,
        actuator: String,
        needed: f64,
        excess: f64,
        min: f64,
        max: f64,
        unit: &'static str,
    },
}

/// What is wrong along a hull that no thruster pushes.
fn unbalanced(drag: f64) -> String {
    match drag {
        0.0 => "nothing acts on the surge speed: no thruster, no drag".into(),
        _ => format!("no thruster pushes against the drag along the hull, {} N", Rounded(drag)),
    }
}

/// A part of a remaining force, without what is rounding beside the other two.
fn part(value: f64, others: [f64; 2]) -> Rounded {
    let largest = others.into_iter().fold(value.abs(), |most, other| most.max(other.abs()));
    Rounded(if value.abs() < ROUNDING * largest { 0.0 } else { value })
}

/// A part of a force smaller than this beside the others is not shown.
const ROUNDING: f64 = 1e-9;
