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
        |calls| format!("From the mathematical library the source {calls}"),
    );
    let mut paragraphs = vec![
        format!(
            "Use: call init once, reset at the start of a mission, then step every {ts} s with the latest inputs. No \
             function allocates memory, blocks, or keeps data outside the state that it is given; several states may \
             be stepped concurrently. The execution time of a step does not depend on the numbers, apart from the \
             branches of a few comparisons. {}",
            library
        ),
        "Invalid inputs: a reference that is infinite or not a number is rejected with BAD_INPUT. A reset rejects \
         any such input, and also angles beyond 2 pi rad, rates beyond 2 pi rad/s, and depths outside -5 m to 12 km. \
         The state is then unchanged and the last commands hold, as after a missed tick."
            .to_owned(),
        format!(
            "Speed out of range: if the measured speed is outside {from} to {to} m/s along the path, rho is held at \
             the end of its range, and the status contains OUT_OF_RANGE. For a speed reference beyond the trim table \
             the trim at its end is used. The proof does not hold there."
        ),
        "Bumpless transfer: while a pilot or another controller commands the actuators, call follow with the applied \
         commands, and then step, at each tick; call follow once more before the first step whose outputs are used. \
         The state is then such that the commands equal the applied ones, as closely as the controller allows, and \
         the references start at the rate of the vehicle and move to their inputs through two lags of 1 s. An \
         applied command beyond its limits is clamped, and one beyond ten times its limits returns BAD_INPUT. To \
         take over after a reset: reset, follow, step. If the commands are limited further downstream, call \
         feed_back with the applied commands before each step, for the anti-windup. The proof covers neither a loop \
         that follows nor limits other than those of the outputs."
            .to_owned(),
        limits(design),
        sensors(design).to_owned(),
        "Missed ticks: the last commands hold, and the state does not change. To make up for k missed ticks, step k \
         + 1 times with the latest inputs, as the FMU does in a long step; after a longer gap, reset. The proof does \
         not cover missed ticks."
            .to_owned(),
        "Proved:".to_owned(),
    ];
    paragraphs.extend(standing.claims.iter().cloned());
    if !design.gains.is_empty() {
        let heading = "Gains of the control law, from which the matrices in the source follow; rho is -1 at the \
                     lowest and 1 at the highest speed:";
        paragraphs.push(heading.to_owned());
        paragraphs.extend(design.gains.iter().map(gain));
    }
    paragraphs.push(format!(
        "SHA-256 of certificate.json: {}.",
        standing.certificate_sha256.as_deref().unwrap_or("none, because there is no certificate")
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
        return "Commands are clamped to their limits, and the status then contains SATURATED and the bit of the \
            actuator."
            .to_owned();
    }
    format!(
        "Commands are clamped to their limits, and the status then contains SATURATED and the bit of the actuator. \
         While a steering actuator stays at its limit for longer than {HELD} s, the reference of {} moves towards \
         the measured value, so that the speed is kept and no integrator winds up; afterwards it returns to its \
         input through two lags of 1 s, within its rate limit. The proof applies to the references as they are used.",
        signals.join(" and ")
    )
}

/// Describes the behaviour after the loss of a sensor.
fn sensors(design: &ControllerDesign) -> &'static str {
    if design.failsafe.is_none() {
        return "Sensors: measurements are used as they are, because this design declares no sensor checks.";
    }
    "Sensors: each measurement has an age, 0 if unknown. A sensor is lost if its value is older than STALE_AFTER \
     plus its period, or has a negative age; if the value is constant for that time although it should have changed \
     by several quantisation steps; if it is not finite or out of range; or if it changes faster than the vehicle \
     can move. The status then contains the bit of the sensor. The sensor is trusted again after it was plausible \
     for half a second; one that was stuck or offset, and whose rate is measured, must also agree with the estimate \
     while the vehicle moves by more than the error of the sensor. Without the speed its loop is open; without the \
     depth it is estimated from pitch and speed, and its reference is held; pitch and heading are estimated from \
     their measured rates; after the loss of any other sensor the commands ramp to the safe ones within half a \
     second (FAILED), whatever the references are. When a sensor recovers, the commands continue without a jump. \
     Nothing is proved about a loop without a sensor."
}
