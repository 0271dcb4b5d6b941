//! Rates of the measured signals, and estimates for lost sensors.
//!
//! ```text
//! u, w, q, v, r, p:  the acceleration from trim with the actuators at their limits,
//!                    sum over j of |B_ij| max(max_j - u0_j, u0_j - min_j)
//! theta, psi, phi:   the change of q, r, p in a second
//! z:                 the largest speed
//! ```
//!
//! the largest over the speeds. The signal of a lost sensor departs from its estimate more slowly: the vehicle flies
//! level, or near its trim, or the sensor of its rate is off by its bias. An angle is estimated from the sensor of its
//! rate, depth from pitch and speed, and the speed from the thrust at the fastest speed,
//!
//! ```text
//! u' = sum over j of B_uj (u_j - u0_j) + A_uu (u - u0)
//! ```

use crate::error::ModelError;
use crate::inputs::design_file::DesignFile;
use squid_auv::longitudinal::{PITCH, SIGNALS};
use squid_auv::{Trim, Vehicle, View, linearise, linearise_with};
use squid_base::numbers::decimals;
use squid_scheduled::{ControllerDesign, Sensor, Source, Without};
use std::collections::BTreeMap;

/// Sine of a path angle that is level within the errors of trim.
const LEVEL: f64 = 0.1;

/// Fraction of the largest speed by which the speed without its sensor may depart from V_r each second.
const CREEP: f64 = 0.003;

/// Largest bias of a sensor of a rate, rad/s.
const BIAS: f64 = 0.5 * std::f64::consts::PI / 180.0;

/// Resolution of a sensor relative to its error: its noise alone changes its values.
const RESOLUTION: f64 = 0.1;

/// Returns the sensors of the signals of a vehicle, reduced to its axis and in the vertical plane, at the speeds of
/// these level trims.
///
/// # Errors
/// [`ModelError::Trim`].
pub fn sensors(
    [vehicle, plane]: [&Vehicle; 2],
    file: &DesignFile,
    trims: &[Trim],
) -> Result<BTreeMap<String, Sensor>, ModelError> {
    let own = |trim: &Trim| linearise_with(vehicle, trim, file.states);
    let mut all = trims.iter().map(own).collect::<Result<Vec<_>, _>>()?;
    if file.view().is_level_held {
        // The speed is controlled by the other axis.
        let speeds: Vec<f64> = trims.iter().map(|trim| trim.speed).collect();
        let (depth, rule) = file.level();
        let plane_trims = squid_auv::trims(plane, depth, &speeds, rule).map_err(ModelError::Trim)?;
        let other = plane_trims.iter().map(|trim| linearise(plane, trim)).collect::<Result<Vec<_>, _>>()?;
        all.extend(other);
    }
    let largest_rate = |symbol: &str| {
        let of = |l: &squid_auv::Linearisation| {
            let Some(row) = l.states.iter().position(|state| state.symbol == symbol) else { return 0.0 };
            let actuators =
                if View::of_states(l.states).is_level_held { &vehicle.actuators } else { &plane.actuators };
            let reach = |(one, trim): (&squid_auv::Actuator, &f64)| (one.max - trim).max(trim - one.min);
            let each = actuators.iter().zip(&l.trim.actuators).map(reach);
            each.enumerate().map(|(j, reach)| l.b[(row, j)].abs() * reach).sum()
        };
        all.iter().map(of).fold(0.0, f64::max)
    };
    let fastest = trims.iter().map(|trim| trim.speed.abs()).fold(0.0, f64::max);
    let rate_source = |state: &str| {
        let rate = file.interface.signals.iter().find(|signal| signal.state() == state)?;
        Some(Source::Rate(rate.name.to_owned()))
    };
    let by_thrust = all[..trims.len()].last().and_then(|linear| {
        let row = linear.states.iter().position(|state| state.symbol == "u")?;
        let gains = (0..linear.b.ncols()).map(|column| linear.b[(row, column)]).collect();
        let time = -1.0 / linear.a[(row, row)];
        (time > 0.0).then_some(Source::Commands { gains, time })
    });
    let sensor = |signal: &squid_signals::Signal| {
        let rate = match signal.state() {
            "theta" => largest_rate("q"),
            "psi" => largest_rate("r"),
            "phi" => largest_rate("p"),
            "z" => fastest,
            symbol => largest_rate(symbol),
        };
        // Only a state itself is estimated: altitude, for example, is not depth.
        let is_state = signal.row.first().is_some_and(|(_, entry)| *entry == 1.0);
        let from = match signal.state() {
            _ if !is_state => None,
            "theta" => rate_source("q"),
            "psi" => rate_source("r"),
            "z" => Some(Source::Path(SIGNALS[PITCH].name.to_owned())),
            "u" => by_thrust.clone(),
            _ => None,
        };
        let drift = match (signal.state(), &from) {
            ("z", Some(_)) => LEVEL * fastest,
            ("u", _) => CREEP * fastest,
            (_, Some(_)) => BIAS,
            (_, None) => rate,
        };
        // A value without an estimate that shows when it should have moved is assumed to change by its noise. Thrust
        // alone does not reveal a stuck speed log: on Squid at 0.75 m/s a step of pitch cost 65 % of the speed.
        let is_estimated = from.is_some() && signal.state() != "u";
        let resolution = if is_estimated { RESOLUTION * signal.error } else { 0.0 };
        let sensor = Sensor { error: signal.error, rate, drift, resolution, period: 0.0, from };
        (signal.name.to_owned(), sensor)
    };
    Ok(file.interface.signals.iter().map(sensor).collect())
}

/// Describes when a sensor counts as lost, and the actuator outputs after the loss of an indispensable one.
pub fn summary(controller: &ControllerDesign) -> Option<String> {
    let failsafe = controller.failsafe.as_ref()?;
    let degrees = |unit: &str| if unit == "rad" { (1f64.to_degrees(), "deg") } else { (1.0, "N") };
    let each = controller.actuators.iter().zip(&failsafe.safe).map(|(one, safe)| {
        let (factor, unit) = degrees(&one.unit);
        format!("{} {} {unit}", one.name, decimals(factor * safe, 2))
    });
    let after = match failsafe.stale_after {
        0.0 => "constant sensor values are never taken as a fault".to_owned(),
        after => format!(
            "a sensor counts as lost if its value is constant for {after} s although it should have \
            changed"
        ),
    };
    let needed = |name: &&str| {
        let index = controller.index(name);
        index.is_some_and(|index| controller.without(index) == Without::Nothing)
    };
    let needed: Vec<&str> = failsafe.sensors.keys().map(String::as_str).filter(needed).collect();
    Some(format!(
        "{after}; after the loss of {} the outputs are {}",
        needed.join(" or "),
        each.collect::<Vec<_>>().join(", ")
    ))
}
