//! States of the linear models of a vehicle.

use squid_signals::{State, States};

/// States of the longitudinal model, x = \[u w q theta z\], in order.
pub const LONGITUDINAL: [State; 5] = [
    State {
        symbol: "u",
        unit: "m/s",
        name: "surge speed",
        actuation_hint: "a thruster along the hull, or drag (X_uu, drag_area)",
        measurement_hint: "measure 'speed'",
    },
    State {
        symbol: "w",
        unit: "m/s",
        name: "heave speed",
        actuation_hint: "a vertical thruster, or damping (Z_w, Z_uw)",
        measurement_hint: "measure 'heave', or add damping (Z_w, Z_uw) to the vehicle",
    },
    State {
        symbol: "q",
        unit: "rad/s",
        name: "pitch rate",
        actuation_hint: "an actuator with a pitch moment, or damping (M_q, M_uq)",
        measurement_hint: "measure 'pitch_rate' or 'pitch'",
    },
    State {
        symbol: "theta",
        unit: "rad",
        name: "pitch",
        actuation_hint: "an actuator with a pitch moment (control surfaces have none at rest: raise \
               model.speed_min), or a centre of gravity farther below the centre of buoyancy (z_G)",
        measurement_hint: "measure 'pitch'",
    },
    State {
        symbol: "z",
        unit: "m",
        name: "depth",
        actuation_hint: "a nonzero speed",
        measurement_hint: "measure 'depth'",
    },
];

/// Returns the states of the longitudinal model of a vehicle: \[w q theta\], with u unless its speed is given, and with
/// z for designs that measure or track depth.
pub fn longitudinal(speed_given: bool, depth: bool) -> States {
    static ALL: [State; 5] = LONGITUDINAL;
    &ALL[usize::from(speed_given)..ALL.len() - usize::from(!depth)]
}

/// Returns the indices of w, q and theta among states, or of v, r and psi; these are contiguous.
pub fn turning(states: States) -> [usize; 3] {
    let first = states.iter().position(|state| ["w", "v"].contains(&state.symbol)).unwrap_or(0);
    [first, first + 1, first + 2]
}

/// Returns the index among states of the angular velocity of an axis: q, r, or p for roll alone.
pub fn turn_rate(states: States) -> usize {
    let index = |symbol| states.iter().position(|state| state.symbol == symbol);
    ["q", "r", "p"].into_iter().find_map(index).unwrap_or(0)
}

/// States of the lateral model, x = \[p phi v r psi\], in order. The r of an axis is the rate of heading, `psi' =
/// r/cos(theta)` at the pitch of the trim.
pub const LATERAL: [State; 5] = [
    State {
        symbol: "p",
        unit: "rad/s",
        name: "roll rate",
        actuation_hint: "fins or thrusters with a roll moment, or damping (K_up, K_p)",
        measurement_hint: "measure 'roll'",
    },
    State {
        symbol: "phi",
        unit: "rad",
        name: "roll",
        actuation_hint: "fins or thrusters with a roll moment, or a centre of gravity farther below the centre of \
            buoyancy (z_G)",
        measurement_hint: "measure 'roll'",
    },
    State {
        symbol: "v",
        unit: "m/s",
        name: "sway speed",
        actuation_hint: "a lateral thruster, or damping (Y_v, Y_uv)",
        measurement_hint: "measure 'sway', or add damping (Y_v, Y_uv) to the vehicle",
    },
    State {
        symbol: "r",
        unit: "rad/s",
        name: "heading rate",
        actuation_hint: "a rudder (no effect at rest: raise model.speed_min), or thrusters with a yaw moment",
        measurement_hint: "measure 'heading_rate' or 'heading'",
    },
    State {
        symbol: "psi",
        unit: "rad",
        name: "heading",
        actuation_hint: "a rudder (no effect at rest: raise model.speed_min), or thrusters with a yaw moment",
        measurement_hint: "measure 'heading'",
    },
];

/// Returns the states of the lateral model of an axis: \[v r psi\], preceded by p and phi for an axis that measures
/// roll.
pub fn lateral(roll: bool) -> States {
    static ALL: [State; 5] = LATERAL;
    if roll { &ALL } else { &ALL[2..] }
}

/// Returns `true` for states of sway, roll and yaw.
pub(crate) fn are_lateral(states: States) -> bool {
    states.iter().all(|state| LATERAL.contains(state))
}
