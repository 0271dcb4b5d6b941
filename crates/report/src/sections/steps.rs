//! Simulated steps of the stepped output and of speed at six speeds: the tracked outputs, and every actuator.

pub mod held;
pub mod limits;

use crate::error::Error;
use crate::page::{Axis, Chart, Curve, Figure, Key, Part, extent};
use crate::peers::course::{speed_step, speed_stepped};
use crate::sections::envelope::Envelope;
use crate::subject::{FLOWN, STEP_TIME, Subject, shown};
use squid_auv::longitudinal::SPEED;
use squid_auv::readable;
use squid_flight::flight::{Flight, Row, fly};

/// Returns the section on steps of each reference.
///
/// # Errors
/// Errors of [`squid_flight::flight::fly`] and [`Subject::verdict`]; [`Error::NothingSteps`].
pub fn steps(subject: &Subject) -> Result<Vec<Part>, Error> {
    subject.output()?;
    let pitched = subject.fly_steps()?;
    // Another axis controls the speed for the axis of heading.
    let faster: &[f64] = if subject.inputs.design.view().is_level_held { &[] } else { &subject.speeds };
    let faster = faster.iter().map(|v| step_speed(subject, *v)).collect::<Result<Vec<Flight>, Error>>()?;
    let step = subject.step();
    let name = subject.name();
    let steps = &subject.verdict()?.found.steps;
    let limited = Envelope::new(subject)?.remark(subject.speeds.iter().map(|speed| (*speed, step.height)));
    let until = shown(steps.iter().map(|step| step.settling_time).fold(0.0, f64::max));
    let mut parts = vec![
        Part::Text(format!(
            "Simulations of the nonlinear vehicle with the sampled autopilot, lags and limits of the actuators, from \
                trim.{}{}",
            ends(subject, &pitched, step.name),
            ends(subject, &faster, "speed")
        )),
        Part::Figure(Figure {
            name: format!("{}-steps", step.name),
            caption: format!(
                "Steps of the {} reference of {name} by {} at six speeds.{limited}",
                step.name,
                step.text()
            ),
            ..figure(subject, subject.speed_keys(), &pitched, until)
        }),
    ];
    if !faster.is_empty() {
        parts.push(Part::Figure(Figure {
            name: "speed-steps".into(),
            caption: format!(
                "Steps of the {} of {name} by {} m/s, towards the middle of the speed range, at six speeds.",
                subject.speed_reference(),
                squid_auv::rounded(speed_step(subject, subject.speeds[0]))
            ),
            ..figure(subject, subject.speed_keys(), &faster, until)
        }));
    }
    Ok(parts)
}

/// Returns sentences on the flights that end at the surface.
fn ends(subject: &Subject, flown: &[Flight], what: &str) -> String {
    let ends = flown.iter().zip(&subject.speeds).filter_map(|(f, v)| Some((v, f.surfacing?)));
    ends.map(|(v, s)| format!(" In the step of {what} at {v:.2} m/s {s}, and the simulation ends.")).collect()
}

/// Simulates a step of the speed reference at [`STEP_TIME`].
fn step_speed(subject: &Subject, speed: f64) -> Result<Flight, Error> {
    let manoeuvre = speed_stepped(subject, speed, STEP_TIME, FLOWN);
    let (inputs, controller) = (subject.inputs, &subject.stored.controller);
    Ok(fly(&inputs.vehicle, controller, inputs.design.level(), &manoeuvre)?)
}

/// Smallest range of the axes of the stepped output (deg or m) and of speed (m/s); smaller motion is negligible.
const LEAST: [f64; 2] = [0.1, 0.002];

/// Largest factor by which a plotted limit extends the axis, so that it does not flatten the commands.
const FLATTER: f64 = 8.0;

/// Plots the stepped output, speed, and the command of each actuator with its limits over time (s), with one key per
/// flight.
pub fn figure(subject: &Subject, mut keys: Vec<Key>, flights: &[Flight], until: f64) -> Figure {
    let (references, limits) = (keys.len(), keys.len() + 1);
    keys.push(Key { dash: "7 3", ..Key::reference("reference") });
    keys.push(Key::reference("limits"));
    let curves = |of: &dyn Fn(&Row, &Row) -> f64| -> Vec<Curve> {
        let points = |rows: &[Row]| {
            rows.iter().filter(|r| r.time <= until).map(|r| (r.time, of(r, &rows[0]))).collect()
        };
        flights.iter().enumerate().map(|(key, f)| Curve { key, points: points(&f.rows) }).collect()
    };
    let followed = |index: usize, label: &str, factor: f64, least: f64| {
        let from_trim = |v: f64, start: &Row| factor * (v - start.measured(index));
        let mut drawn = curves(&|r, start| from_trim(r.measured(index), start));
        drawn.extend(different(curves(&|r, start| from_trim(r.reference(index), start)), references));
        Chart { y: Axis::linear(label).at_least(least), ..Chart::over_time("", "", drawn) }
    };
    let step = subject.step();
    let mut charts = vec![
        followed(step.index, &step.from_trim(), step.factor, LEAST[0]),
        followed(SPEED, "forward speed from trim (m/s)", 1.0, LEAST[1]),
    ];
    for (j, actuator) in subject.inputs.vehicle.actuators.iter().enumerate() {
        let (factor, unit) = readable(actuator.unit());
        let mut drawn = curves(&|r, _| factor * r.commands[j]);
        let (near, far) = limits_near(&drawn, [actuator.min, actuator.max].map(|limit| factor * limit));
        drawn.extend(near.into_iter().map(|v| Curve { key: limits, points: vec![(0.0, v), (until, v)] }));
        let beyond: Vec<String> = far.into_iter().map(squid_auv::rounded).collect();
        let beyond = match beyond.len() {
            0 => String::new(),
            1 => format!(", limit {}", beyond[0]),
            _ => format!(", limits {}", beyond.join(" and ")),
        };
        charts.push(Chart::over_time(actuator.name.as_str(), format!("command ({unit}){beyond}"), drawn));
    }
    if charts.iter().flat_map(|chart| &chart.curves).all(|curve| curve.key != limits) {
        keys.pop();
    }
    Figure { name: String::new(), caption: String::new(), keys, charts }
}

/// Returns the distinct curves, with a common key.
fn different(courses: Vec<Curve>, key: usize) -> Vec<Curve> {
    let mut out: Vec<Curve> = vec![];
    for course in courses {
        if out.iter().all(|other| other.points != course.points) {
            out.push(Curve { key, ..course });
        }
    }
    out
}

/// Returns the limits of an actuator that can be plotted with its commands, and those that would flatten them.
fn limits_near(commands: &[Curve], limits: [f64; 2]) -> (Vec<f64>, Vec<f64>) {
    let (low, high) = extent(commands.iter().flat_map(|curve| &curve.points).map(|p| p.1));
    limits.into_iter().partition(|limit| high.max(*limit) - low.min(*limit) <= FLATTER * (high - low))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Commands from 1 to 2 N are plotted with a limit of 8 N, but not with one of -30 N.
    #[test]
    fn distant_limits_are_not_plotted() {
        let commands = [Curve { key: 0, points: vec![(0.0, 1.0), (1.0, 2.0)] }];
        assert_eq!(limits_near(&commands, [-30.0, 8.0]), (vec![8.0], vec![-30.0]));
    }
}
