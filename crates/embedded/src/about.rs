//! The comment at the head of the header: use, limits, sensors and proof.

use crate::inputs::{references, steered_by};
use crate::real::Real;
use crate::text::{comment, library};
use squid_scheduled::{ControllerDesign, Gain, HELD};

/// The proof of a controller, as text for the header.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Standing {
    /// The claims proved, a sentence each, or the reason for which nothing is proved.
    pub claims: Vec<String>,
    /// SHA-256 of the certificate in hexadecimal, if there is one.
    pub certificate_sha256: Option<String>,
}

/// Returns the comment at the head of the header.
pub(crate) fn about(design: &ControllerDesign, standing: &Standing, real: Real) -> String {
    let [ts, from, to] = [design.sample_time, design.scheduling.minimum, design.scheduling.maximum];
    let library = library(design, real).map_or_else(
        || "The source needs no library.".to_owned(),
        |calls| format!("Of the mathematical library the source {calls}"),
    );
    let mut paragraphs = vec![
        format!(
            "Use: init once, reset where a flight begins, then step each {ts} s with the newest inputs. No function \
             allocates memory, waits, or keeps anything outside of the state that it is given; several states may be \
             stepped at once. How long a step takes does not depend on the numbers but for the branches of a few \
             comparisons. {}",
            library
        ),
        "A reference that is infinite or not a number: refused with BAD_INPUT, as is anything at a reset, and there an \
         angle beyond 2 pi rad, a rate beyond 2 pi rad/s, a depth above -5 m or below 12 km. Nothing is changed, and \
         the last commands hold, as if the tick were missed."
            .to_owned(),
        format!(
            "A measured speed outside {from} to {to} m/s along the path: rho is held at the end of its range, and the \
             status has OUT_OF_RANGE. For a wanted speed beyond the trim table the trim is that of its end. What is \
             proved does not hold there."
        ),
        "Taking over: while a pilot, another design or anything else commands the actuators, call follow with what \
         they get, and then step, each tick; call follow once more before the first step whose outputs are used. \
         The state is then such that the command is what was applied, as nearly as the controller can, and \
         references go on with the rate of the vehicle, and to what is asked through two lags of 1 s. An applied \
         command beyond its limits is taken to be at its limit, and one beyond ten times that is BAD_INPUT. To take \
         over after a reset: reset, follow, step. Where something limits the commands further while they are used, \
         call feed_back with what the actuators got before each step, and the anti-windup knows of it. What is proved \
         does not cover a loop that follows, nor limits that are not those of the outputs."
            .to_owned(),
        limits(design),
        sensors(design).to_owned(),
        "A missed tick: nothing runs by itself. The last commands hold, and the state stays as it is. To make up for k \
         missed ticks step k + 1 times with the newest inputs, as the FMU does in a long step; after a longer gap \
         reset. What is proved does not cover ticks that are missed."
            .to_owned(),
        "What is proved:".to_owned(),
    ];
    paragraphs.extend(standing.claims.iter().cloned());
    if !design.gains.is_empty() {
        let heading = "The gains of the control law, from which the matrices in the source follow; rho is -1 at the \
                     lowest and 1 at the highest speed:";
        paragraphs.push(heading.to_owned());
        paragraphs.extend(design.gains.iter().map(gain));
    }
    paragraphs.push(format!(
        "The SHA-256 of certificate.json is {}.",
        standing.certificate_sha256.as_deref().unwrap_or("not there: there is no certificate")
    ));
    comment(&paragraphs)
}

/// Formats a gain as a polynomial in rho.
fn gain(Gain { name, unit, coefficients }: &Gain) -> String {
    let powers = ["", " rho", " rho^2"];
    let terms: Vec<String> =
        coefficients.iter().zip(powers).map(|(value, power)| format!("{value:?}{power}")).collect();
    format!("{name} = {} ({unit})", terms.join(" + "))
}

/// Describes the behaviour with commands at their limits.
fn limits(design: &ControllerDesign) -> String {
    let yielding = references(design).into_iter().filter(|index| steered_by(design, *index) != 0);
    let signals: Vec<&str> = yielding.map(|index| design.signals[index].name.as_str()).collect();
    if signals.is_empty() {
        return "Commands are cut off at their limits, and the status has SATURATED and the bit of the actuator."
            .to_owned();
    }
    format!(
        "Commands are cut off at their limits, and the status has SATURATED and the bit of the actuator. While an \
         actuator that steers stays at its limit for longer than {HELD} s, the reference of {} yields to what is \
         measured, so that the speed is kept and nothing winds up; after that it returns to what is asked through \
         two lags of 1 s, within its rate. What is proved is of references as they are used.",
        signals.join(" and ")
    )
}

/// Describes the behaviour after the loss of a sensor.
fn sensors(design: &ControllerDesign) -> &'static str {
    if design.failsafe.is_none() {
        return "Measurements are taken as they come: this design has no limits to what its sensors may say.";
    }
    "Sensors: each measurement has an age, 0 if it is not given. A sensor is lost if its value is older than \
     STALE_AFTER and its period or of the future, is the same for so long and should have moved by several of its \
     steps, is not finite or out of its range, or moves faster than the vehicle can; the status has its bit. It is \
     believed again after half a second in which it was plausible; one that was stuck or elsewhere, and whose rate is \
     measured, has to agree while the vehicle moves by more than its error. Without the speed its loop is open; \
     without the depth it is reckoned from pitch and speed, and its reference held; pitch and heading are reckoned \
     from their measured rates; without anything else the commands go to the safe ones in half a second, FAILED, \
     whatever the references are. When a sensor comes back the first command is the last one. Nothing is proved of a \
     loop without a sensor."
}
