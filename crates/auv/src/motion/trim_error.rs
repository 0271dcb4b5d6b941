//! Errors of trim, each as one sentence.

use thiserror::Error;

use crate::text::Rounded;
use crate::vehicle::coefficients::CoefficientError;

/// Reason why there is no trim.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum TrimError {
    /// Coefficients that are not allowed.
    #[error(transparent)]
    Coefficients(#[from] CoefficientError),
    /// A speed that is not finite.
    #[error("the trim speed is {} m/s; it must be a finite number", Rounded(*speed))]
    SpeedNotFinite { speed: f64 },
    /// A depth that is not finite.
    #[error("the trim depth is {} m; it must be a finite number", Rounded(*depth))]
    DepthNotFinite { depth: f64 },
    /// A pitch that is not finite.
    #[error("the pitch of a climb is {} deg; it must be a finite number", Rounded(pitch.to_degrees()))]
    PitchNotFinite { pitch: f64 },
    /// A rate of turn that is not finite.
    #[error("the turn rate is {} deg/s; it must be a finite number", Rounded(rate.to_degrees()))]
    RateNotFinite { rate: f64 },
    /// A vehicle without inertia in roll.
    #[error(
        "the vehicle file describes motion in the vertical plane only, so that no turn can be computed: add \
            'mass.I_xx' and the coefficients that are then reported as missing"
    )]
    NoLateral,
    /// No steady turn.
    #[error(
        "no steady turn of {} deg/s at {} m/s and a depth of {} m: no actuator outputs balance it at constant depth \
            (smallest residual {} m/s2 or rad/s2)",
        Rounded(*rate_deg), Rounded(*speed), Rounded(*depth), Rounded(*residual)
    )]
    NoTurn { speed: f64, depth: f64, rate_deg: f64, residual: f64 },
    /// No incidence and outputs that balance the forces.
    #[error(
        "no level trim at {} m/s and a depth of {} m: lift and actuators do not balance a weight of {} N, a buoyancy \
            of {} N and the moments (at best, at an incidence of {incidence_deg:.1} deg, {} m/s2 or rad/s2 remain); \
            a higher speed, more equal weight and buoyancy, or a vertical thruster may help",
        Rounded(*speed), Rounded(*depth), Rounded(*weight), Rounded(*buoyancy), Rounded(*residual)
    )]
    NotFound { speed: f64, depth: f64, weight: f64, buoyancy: f64, incidence_deg: f64, residual: f64 },
    /// No level trim, and no thruster along the hull.
    #[error(
        "no level trim at {} m/s and a depth of {} m: {}; add a thruster along the hull, or set [surge] speed = \
            \"given\" in the vehicle file if the speed is imposed from outside",
        Rounded(*speed), Rounded(*depth), unbalanced(*drag)
    )]
    NoThrust { speed: f64, depth: f64, drag: f64 },
    /// No outputs that balance the forces at the held pitch.
    #[error(
        "no trim at {} m/s and a depth of {} m with the pitch held at {} deg: {} N of surge force, {} N of heave \
            force and {} N.m of pitch moment cannot be balanced by the actuators; set 'trim.pitch' to \"free\" in \
            the design file, or add a thruster in that direction",
        Rounded(*speed), Rounded(*depth), Rounded(*pitch_deg), part(*surge, [*heave, *moment]),
        part(*heave, [*surge, *moment]), part(*moment, [*surge, *heave])
    )]
    NotHeld { speed: f64, depth: f64, pitch_deg: f64, surge: f64, heave: f64, moment: f64 },
    /// Trims at neighbouring speeds on different branches.
    #[error(
        "the level trim is discontinuous at {} m/s: {quantity} jumps from {} to {} {unit}; hold the pitch with \
            'trim.pitch' in the design file (\"level\" or an angle), or choose a speed range on one side of the jump",
        Rounded(*speed), Rounded(*before), Rounded(*after)
    )]
    Jump { speed: f64, quantity: String, before: f64, after: f64, unit: &'static str },
    /// A forward speed, the scheduling parameter of an autopilot, that does not increase with the speed along the path.
    #[error(
        "at {} m/s along the path the pitch in level trim is {} deg and changes so fast with the speed that the \
            forward speed decreases while the speed along the path increases; an autopilot that measures the forward \
            speed cannot distinguish these trims: choose a speed range on one side of this speed, or hold the pitch \
            with 'trim.pitch' in the design file (\"level\" or an angle)",
        Rounded(*speed), Rounded(*pitch_deg)
    )]
    ForwardSpeedFalls { speed: f64, pitch_deg: f64 },
    /// An output beyond the limits of an actuator, angles in degrees.
    #[error(
        "level trim at {} m/s and a depth of {} m requires {} {unit} from {actuator}, which is {} {unit} beyond its \
            limits of {} to {} {unit}",
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

/// Returns the cause of a missing balance along a hull without axial thruster.
fn unbalanced(drag: f64) -> String {
    match drag {
        0.0 => "neither a thruster nor drag acts on the surge speed".into(),
        _ => format!("no thruster balances the drag of {} N along the hull", Rounded(drag)),
    }
}

/// Returns a component of the remaining force, set to zero if it is rounding relative to the other two.
fn part(value: f64, others: [f64; 2]) -> Rounded {
    let largest = others.into_iter().fold(value.abs(), |most, other| most.max(other.abs()));
    Rounded(if value.abs() < ROUNDING * largest { 0.0 } else { value })
}

/// Ratio to the other components below which a component of a force is not shown.
const ROUNDING: f64 = 1e-9;
