//! Response to a moment that the actuators cannot hold.

use crate::error::Error;
use crate::page::{Figure, Part, capital};
use crate::sections::steps;
use crate::subject::{STEP_TIME, Subject};
use squid_auv::Actuator;
use squid_design::verdict::held::{AFTER, FACTOR, HELD, RISE, fly, load};
use squid_flight::flight::Flight;
use squid_scheduled::Autopilot;

/// Duration of the flights, s.
const SHOWN: f64 = STEP_TIME + HELD + RISE + AFTER;

/// Returns the section on a sustained moment beyond the actuators; empty if no actuator turns the vehicle.
///
/// # Errors
/// Errors of the flights.
pub fn held(subject: &Subject) -> Result<Vec<Part>, Error> {
    let (inputs, controller) = (subject.inputs, &subject.stored.controller);
    let trims = Autopilot::new(controller)?.trim().clone();
    let loads = subject.speeds.iter().map(|speed| load(inputs, &trims, trims.forward_speed(*speed), 1.0));
    let Some(loads) = loads.collect::<Option<Vec<_>>>() else { return Ok(vec![]) };
    let flown =
        |(speed, (_, load)): (&f64, (usize, squid_auv::Load))| fly(inputs, controller, (*speed, SHOWN), load);
    let flights: Vec<Option<Flight>> =
        subject.speeds.iter().zip(loads).map(flown).collect::<Result<_, _>>()?;
    let steering = |(_, one): &(&Actuator, &squid_scheduled::Actuator)| !one.steers.is_empty();
    let all = inputs.vehicle.actuators.iter().zip(&controller.actuators).filter(steering);
    let names: Vec<&str> = all.map(|(one, _)| one.name.as_str()).collect();
    let text = format!(
        "A moment increases within {RISE:.0} s to {FACTOR} times the moment that the actuators can hold at unchanged \
         thrust along the hull, acts for {HELD:.0} s and decreases within {RISE:.0} s; a pitch moment exceeds that \
         of the actuators by at most half the righting moment of the hull. While {} stays at its limit, the \
         reference moves towards the measured value.",
        names.join(" or ")
    );
    let lost = subject.speeds.iter().zip(&flights).filter(|(_, flight)| flight.is_none());
    let lost: Vec<String> = lost.map(|(speed, _)| format!("{speed:.2}")).collect();
    let Some(flights) = flights.into_iter().collect::<Option<Vec<Flight>>>() else {
        let text = format!("{text} At {} m/s the simulation fails.", lost.join(", "));
        return Ok(vec![Part::Text(text)]);
    };
    let figure = Figure {
        name: "held-responses".into(),
        caption: format!(
            "{} under a moment that exceeds the actuators, at six speeds.",
            capital(&subject.name())
        ),
        ..steps::figure(subject, subject.speed_keys(), &flights, SHOWN)
    };
    Ok(vec![Part::Text(text), Part::Figure(figure)])
}
