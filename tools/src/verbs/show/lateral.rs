//! Sway, roll and yaw in `squid show`.

use super::tables::{modes, table};
use serde_json::{Value, json};
use squid_auv::readable;
use squid_auv::{Actuator, Lateral, Turn, Vehicle};
use squid_base::numbers::decimals;

/// Returns the actuators that act out of the vertical plane, with their indices.
fn steering(vehicle: &Vehicle) -> impl Iterator<Item = (usize, &Actuator)> {
    vehicle.actuators.iter().enumerate().filter(|(_, one)| one.acts_out_of_plane())
}

/// Returns as text the linear model, its poles, the effect of the actuators, and turns at constant depth.
pub fn text(vehicle: &Vehicle, found: &Lateral) -> String {
    let speed = found.straight.speed;
    let mut out = format!("Sway, roll and yaw about straight level flight at V = {speed:.3} m/s\n");
    if !vehicle.supposed().is_empty() {
        let keys: Vec<&str> = vehicle.supposed().into_iter().map(|(key, _)| key).collect();
        out += &format!(
            "  not in the vehicle file (taken from symmetry of the hull, or 0): {}\n",
            keys.join(", ")
        );
    }
    out += &format!("  roll               {:>9} deg\n", decimals(found.straight.motion.phi.to_degrees(), 4));
    let steering: Vec<(usize, &Actuator)> = steering(vehicle).collect();
    let names: Vec<&str> = steering.iter().map(|(_, one)| one.name.as_str()).collect();
    out += &format!("\nA, x = [{}] in m/s, rad/s, rad/s, rad\n", Lateral::STATES.join(" "));
    out += &table(&found.a, &Lateral::STATES, &Lateral::STATES);
    if names.is_empty() {
        return out + "\nNo actuator acts on sway, roll or yaw: the heading cannot be controlled.\n";
    }
    let indices: Vec<usize> = steering.iter().map(|(index, _)| *index).collect();
    out += "\nB, in x' per N or rad\n";
    out += &table(&found.b.select_columns(&indices), &Lateral::STATES, &names);
    out += &format!("\nEigenvalues of A (1/s)\n{}", modes(&found.eigenvalues()));
    if !found.is_stable() {
        out += "  Straight flight is unstable: a steady turn may require an output whose initial effect is \
            opposite.\n";
    }
    out += "\nYaw rate r in a slow steady turn by a single actuator\n";
    for (index, one) in &steering {
        let (factor, unit) = readable(one.unit());
        let gain = found.gain(*index).map(|gain| gain.to_degrees() / factor);
        let effect = gain.map_or("none".to_owned(), |gain| format!("{} deg/s per {unit}", decimals(gain, 4)));
        let first = if found.b[(2, *index)] < 0.0 { "port" } else { "starboard" };
        out += &format!("  {:<18} {effect}; a positive output initially turns to {first}\n", one.name);
    }
    out += "\nSteady turns to starboard at constant depth\n";
    let mut row = |name: &str, of: &dyn Fn(&Turn) -> String| {
        let cells: String = found.turns.iter().map(|turn| format!("{:>12}", of(turn))).collect();
        out += &format!("  {name:<24}{cells}\n");
    };
    row("rate, deg/s", &|turn| decimals(turn.rate.to_degrees(), 2));
    row("radius, m", &|turn| decimals(turn.radius(), 2));
    row("roll, deg", &|turn| decimals(turn.motion.phi.to_degrees(), 2));
    row("pitch, deg", &|turn| decimals(turn.motion.theta.to_degrees(), 2));
    let is_beyond = |one: &Actuator, output: f64| !(one.min..=one.max).contains(&output);
    for (index, one) in vehicle.actuators.iter().enumerate() {
        let (factor, unit) = readable(one.unit());
        row(&format!("{}, {unit}", one.name), &|turn| {
            let output = turn.actuators[index];
            let mark = if is_beyond(one, output) { "*" } else { "" };
            format!("{mark}{}", decimals(factor * output, 2))
        });
    }
    let mut all = found.turns.iter().flat_map(|turn| vehicle.actuators.iter().zip(&turn.actuators));
    let beyond = all.any(|(one, output)| is_beyond(one, *output));
    out + if beyond { "  * beyond the limits of the actuator\n" } else { "" }
}

/// Returns the same as JSON, in SI units.
pub fn to_json(vehicle: &Vehicle, found: &Lateral) -> Value {
    let rows = |m: &nalgebra::DMatrix<f64>| {
        m.row_iter().map(|row| row.iter().copied().collect::<Vec<f64>>()).collect::<Vec<_>>()
    };
    let turns = found.turns.iter().map(|turn| {
        let m = turn.motion;
        json!({
            "rate": turn.rate, "radius": turn.radius(), "actuators": turn.actuators,
            "u": m.u, "v": m.v, "w": m.w, "phi": m.phi, "theta": m.theta,
        })
    });
    let gains = steering(vehicle).map(|(place, one)| (one.name.clone(), json!(found.gain(place))));
    json!({
        "states": Lateral::STATES,
        "A": rows(&found.a),
        "B": rows(&found.b),
        "actuators": vehicle.actuators.iter().map(|one| &one.name).collect::<Vec<_>>(),
        "eigenvalues": found.eigenvalues().iter().map(|v| [v.re, v.im]).collect::<Vec<_>>(),
        "yaw_rate_per_output": gains.collect::<serde_json::Map<String, Value>>(),
        "supposed": vehicle.supposed().into_iter().map(|(key, v)| (key.to_owned(), json!(v)))
            .collect::<serde_json::Map<String, Value>>(),
        "turns": turns.collect::<Vec<_>>(),
    })
}
