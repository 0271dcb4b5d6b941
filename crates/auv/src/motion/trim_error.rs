//! Errors of trim, each as one sentence.

use thiserror::Error;

use crate::vehicle::coefficients::CoefficientError;
use crate::words::Rounded;

/// Reason why there is no trim.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum TrimError {
    /// Coefficients that are not allowed.
    #[error(transparent)]
    Coefficients(#[from] CoefficientError),
    /// A speed that is not finite.
    #[error("the trim speed is {} m/s, and must be a finite number", Rounded(*speed))]
    SpeedNotFinite { speed: f64 },
    /// A depth that is not finite.
    #[error("the trim depth is {} m, and must be a finite number", Rounded(*depth))]
    DepthNotFinite { depth: f64 },
    /// A pitch that is not finite.
    #[error("the pitch of a climb is {} deg, and must be a finite number", Rounded(pitch.to_degrees()))]
    PitchNotFinite { pitch: f64 },
    /// A rate of turn that is not finite.
    #[error("the rate of the turn is {} deg/s, and must be a finite number", Rounded(rate.to_degrees()))]
    RateNotFinite { rate: f64 },
    /// A vehicle without inertia in roll.
    #[error(
        "the vehicle moves in the vertical plane alone, and does not turn: give 'mass.I_xx' and what it says is \
            missing then in the vehicle file"
    )]
    NoLateral,
    /// No steady turn.
    #[error(
        "no steady turn of {} deg/s at {} m/s and {} m: no outputs of the actuators balance it at constant depth \
            (nearest with {} m/s2 or rad/s2 left)",
        Rounded(*rate_deg), Rounded(*speed), Rounded(*depth), Rounded(*residual)
    )]
    NoTurn { speed: f64, depth: f64, rate_deg: f64, residual: f64 },
    /// No incidence and outputs that balance the forces.
    #[error(
        "no level trim at {} m/s and {} m: lift and actuators do not balance a weight of {} N, a buoyancy of \
            {} N and the moments (nearest at an incidence of {incidence_deg:.1} deg, with {} m/s2 or rad/s2 \
            left); what may help: more speed, weight and buoyancy closer together, a vertical thruster",
        Rounded(*speed), Rounded(*depth), Rounded(*weight), Rounded(*buoyancy), Rounded(*residual)
    )]
    NotFound { speed: f64, depth: f64, weight: f64, buoyancy: f64, incidence_deg: f64, residual: f64 },
    /// No level trim, and no thruster along the hull.
    #[error(
        "no level trim at {} m/s and {} m: {}; add a thruster that pushes along the hull, or say [surge] speed = \
            \"given\" in the vehicle file of a vehicle whose speed is given from outside",
        Rounded(*speed), Rounded(*depth), unbalanced(*drag)
    )]
    NoThrust { speed: f64, depth: f64, drag: f64 },
    /// No outputs that balance the forces at the held pitch.
    #[error(
        "no trim at {} m/s and {} m with the pitch held at {} deg: at best {} N of surge force, {} N of heave force \
            and {} N.m of pitching moment are left, which no actuator takes up; set 'trim.pitch' to \"free\" in the \
            design file, or add a thruster that pushes there",
        Rounded(*speed), Rounded(*depth), Rounded(*pitch_deg), part(*surge, [*heave, *moment]),
        part(*heave, [*surge, *moment]), part(*moment, [*surge, *heave])
    )]
    NotHeld { speed: f64, depth: f64, pitch_deg: f64, surge: f64, heave: f64, moment: f64 },
    /// Trims at neighbouring speeds on different branches.
    #[error(
        "the level trim jumps at {} m/s: {quantity} goes from {} to {} {unit} at once, however close the speeds; hold \
            the pitch by 'trim.pitch' in the design file (\"level\", or an angle), or choose a range of speeds to one \
            side of the jump",
        Rounded(*speed), Rounded(*before), Rounded(*after)
    )]
    Jump { speed: f64, quantity: String, before: f64, after: f64, unit: &'static str },
    /// A forward speed, the scheduling parameter of an autopilot, that does not increase with the speed along the path.
    #[error(
        "at {} m/s along the path, where the pitch in level trim is {} deg, that pitch changes so fast with the speed \
            that the forward speed falls while the speed along the path rises; an autopilot that knows the forward \
            speed cannot tell these trims apart: choose a range of speeds on one side of that, or hold the pitch by \
            'trim.pitch' in the design file (\"level\", or an angle)",
        Rounded(*speed), Rounded(*pitch_deg)
    )]
    ForwardSpeedFalls { speed: f64, pitch_deg: f64 },
    /// An output beyond the limits of an actuator, angles in degrees.
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

/// Returns the cause of a missing balance along a hull without axial thruster.
fn unbalanced(drag: f64) -> String {
    match drag {
        0.0 => "nothing acts on the surge speed: no thruster, no drag".into(),
        _ => format!("no thruster pushes against the drag along the hull, {} N", Rounded(drag)),
    }
}

/// Returns a component of the remaining force, set to zero if it is rounding relative to the other two.
fn part(value: f64, others: [f64; 2]) -> Rounded {
    let largest = others.into_iter().fold(value.abs(), |most, other| most.max(other.abs()));
    Rounded(if value.abs() < ROUNDING * largest { 0.0 } else { value })
}

/// Ratio to the other components below which a component of a force is not shown.
const ROUNDING: f64 = 1e-9;
