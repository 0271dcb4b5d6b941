//! How fast the vehicle can change what its sensors measure.
//!
//! ```text
//! u, w, q, v, r, p:  what the actuators give from trim to their limits,
//!                    sum over j of |B_ij| max(max_j - u0_j, u0_j - min_j)
//! theta, psi, phi:   the change of q, r, p in a second
//! z:                 the largest speed
//! ```
//!
//! the largest over the speeds. While a sensor is lost, what it measures leaves what is expected of it by less: the
//! vehicle flies level, or near its trim, or the sensor of its rate is off by its bias. What the rate of a signal
//! follows from: of an angle another sensor, of depth pitch and speed, of the speed the thrust at the fastest speed,
//!
//! ```text
//! u' = sum over j of B_uj (u_j - u0_j) + A_uu (u - u0)
//! ```

use crate::error::ModelError;
use crate::inputs::design_file::DesignFile;
use crate::numbers::decimals;
use squid_auv::longitudinal::{PITCH, SIGNALS};
use squid_auv::{Trim, Vehicle, View, linearise, linearise_with};
use squid_scheduled::{ControllerDesign, Sensor, Source, Without};
use std::collections::BTreeMap;

/// A path that is level within the errors of trim, as sine.
const LEVEL: f64 = 0.1;

/// Part of the largest speed by which the speed without its sensor may leave V_r each second.
const CREEP: f64 = 0.003;

/// The largest bias of a sensor of a rate, rad/s.
const BIAS: f64 = 0.5 * std::f64::consts::PI / 180.0;

/// The steps of a sensor are taken to be this part of its errors: its noise is what makes its values change.
const RESOLUTION: f64 = 0.1;

/// The sensors of each signal of a vehicle, as its axis has it and as it is in the vertical plane, at the speeds of
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
        // The speed is that of the other axis.
        let speeds: Vec<f64> = trims.iter().map(|trim| trim.speed).collect();
        let (depth, rule) = file.level();
        let plane_trims = squid_auv::trims(plane, depth, &speeds, rule).map_err(ModelError::Trim)?;
        let other = plane_trims.iter().map(|trim| linearise(plane, trim)).collect::<Result<Vec<_>, _>>()?;
        all.extend(other);
    }
    let given = |symbol: &str| {
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
    let named = |state: &str| {
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
            "theta" => given("q"),
            "psi" => given("r"),
            "phi" => given("p"),
            "z" => fastest,
            symbol => given(symbol),
        };
        // What is reckoned is a state itself: an altitude is no depth.
        let reckoned = signal.row.first().is_some_and(|(_, entry)| *entry == 1.0);
        let from = match signal.state() {
            _ if !reckoned => None,
            "theta" => named("q"),
            "psi" => named("r"),
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
        // Without anything to say that a value should have moved, its noise is taken to change it.
        // Thrust alone does not show a log that is stuck: on Squid at 0.75 m/s a step of pitch cost 65 % of the speed.
        let is_reckoned = from.is_some() && signal.state() != "u";
        let resolution = if is_reckoned { RESOLUTION * signal.error } else { 0.0 };
        let sensor = Sensor { error: signal.error, rate, drift, resolution, period: 0.0, from };
        (signal.name.to_owned(), sensor)
    };
    Ok(file.interface.signals.iter().map(sensor).collect())
}

/// What the actuators get without pitch, in words.
pub fn words(controller: &ControllerDesign) -> Option<String> {
    let failsafe = controller.failsafe.as_ref()?;
    let degrees = |unit: &str| if unit == "rad" { (1f64.to_degrees(), "deg") } else { (1.0, "N") };
    let each = controller.actuators.iter().zip(&failsafe.safe).map(|(one, safe)| {
        let (factor, unit) = degrees(&one.unit);
        format!("{} {} {unit}", one.name, decimals(factor * safe, 2))
    });
    let after = match failsafe.stale_after {
        0.0 => "a sensor may be the same for ever".to_owned(),
        after => format!("a sensor is lost that is the same for {after} s and should have moved"),
    };
    let needed = |name: &&str| {
        let place = controller.index(name);
        place.is_some_and(|place| controller.without(place) == Without::Nothing)
    };
    let needed: Vec<&str> = failsafe.sensors.keys().map(String::as_str).filter(needed).collect();
    Some(format!("{after}; without {} {}", needed.join(" or "), each.collect::<Vec<_>>().join(", ")))
}
