//! Step beyond the actuators' limits, and back, with and without anti-windup.

use crate::error::Error;
use crate::page::{Figure, Key, Part, Table, capital, known, tidy};
use crate::sections::envelope::Envelope;
use crate::sections::steps::figure;
use crate::subject::{FLOWN, STEP_TIME, Subject};
use squid_design::synthesise::anti_windup::largest_step;
use squid_flight::flight::{Flight, Row, fly, unless_lost};
use squid_flight::metrics::StepFigures;
use squid_scheduled::{ControllerDesign, Manoeuvre};
use std::f64::consts::PI;

/// Duration of the step (s), long enough for windup.
const HELD: f64 = 39.0;

/// End of the step, and end of the flight (s).
const TIMES: [f64; 2] = [STEP_TIME + HELD, STEP_TIME + HELD + FLOWN];

/// Largest step of a circular angle (rad): a step of exactly half a turn has no direction.
const HALF_TURN: f64 = PI - 1e-6;

/// Depth of the flight below that of the design (m), so that no flight surfaces.
const DEEPER: f64 = 1000.0;

/// Number of speeds over the range.
const SPEEDS: usize = 3;

/// Flights with the controller, and without its anti-windup; `None` if the vehicle is lost.
struct Pair {
    speed: f64,
    /// Commanded step, and the step as limited by the autopilot, rad or m.
    height: f64,
    used: f64,
    with: Option<Flight>,
    without: Option<Flight>,
}

/// Returns the section on steps beyond the limits; empty for a controller without anti-windup, and if the stepped
/// output is not tracked. The step at each speed has the sign for which saturation without anti-windup lasts longer.
///
/// # Errors
/// Errors of [`fly`], except for divergence, which counts as lost.
pub fn limits(subject: &Subject) -> Result<Vec<Part>, Error> {
    let stored = &subject.stored.controller;
    let (Ok(output), Some(_)) = (subject.output(), &stored.anti_windup) else { return Ok(vec![]) };
    let plain = ControllerDesign { anti_windup: None, ..stored.clone() };
    let step = subject.step();
    let largest = largest_step(&subject.inputs.design, output);
    let circular = subject.inputs.design.tracked[output].signal.circular;
    let size = if circular { HALF_TURN.min(largest) } else { largest };
    let down = if step.name == "depth" { size } else { -size };
    let envelope = Envelope::new(subject)?;
    let mut pairs = vec![];
    for speed in subject.inputs.design.spread(SPEEDS) {
        let pair = |height: f64| {
            let flown = |controller| fly_held(subject, speed, height, controller);
            let used = envelope.used(speed, height);
            Ok(Pair { speed, height, used, with: flown(stored)?, without: flown(&plain)? })
        };
        let both_signs = [-down, down].map(pair);
        let both_signs = both_signs.into_iter().collect::<Result<Vec<Pair>, Error>>()?;
        pairs.extend(both_signs.into_iter().max_by(|a, b| a.limited(subject).total_cmp(&b.limited(subject))));
    }
    if pairs.iter().all(|pair| pair.limited(subject) == 0.0) {
        let (name, shown) = (step.name, tidy(step.factor * size, 1));
        let speeds = pairs.iter().map(|pair| format!("{:.2}", pair.speed)).collect::<Vec<_>>().join(", ");
        let both = pairs.iter().flat_map(|pair| [-size, size].map(|height| (pair.speed, height)));
        let text = format!(
            "At {speeds} m/s, steps of the {name} reference by {shown} {}, in either direction, saturate no \
                 command.{}",
            step.unit,
            envelope.remark(both)
        );
        return Ok(vec![Part::Text(text)]);
    }
    let mut table = Table::new(["speed (m/s)"]);
    let from = if ["depth", "heading"].contains(&step.name) { "start" } else { "trim" };
    table.head.extend([
        format!("requested step ({})", step.unit),
        format!("limited step ({})", step.unit),
        "anti-windup".into(),
        format!("{} from {from}, at most ({})", step.name, step.unit),
        "time with a saturated command (s)".into(),
        "settled to 2 % after removal (s)".into(),
        "overshoot after removal (%)".into(),
    ]);
    for pair in &pairs {
        for (flight, name) in [(&pair.with, "yes"), (&pair.without, "no")] {
            let [requested, used] = [pair.height, pair.used].map(|height| tidy(step.factor * height, 1));
            let mut row = vec![format!("{:.2}", pair.speed), requested, used, name.into()];
            let lost = || ["lost", "-", "-", "-"].map(Into::into);
            row.extend(flight.as_ref().map_or_else(lost, |flight| cells(subject, flight, pair.used)));
            table.rows.push(row);
        }
    }
    let text = format!(
        "A step of the {} reference by {} {} is removed after {HELD} s, and the simulation continues for {FLOWN} s, \
             in deep water; at each speed the direction is that in which a command saturates longer without \
             anti-windup. Anti-windup feeds the saturated part of the commands back into the states of the \
             controller; each simulation is also shown without it.{}",
        step.name,
        tidy(step.factor * size, 1),
        step.unit,
        envelope.remark(pairs.iter().map(|pair| (pair.speed, pair.height)))
    );
    let mut parts = vec![Part::Text(text), Part::Table(table)];
    let drawn = pairs.into_iter().filter(|pair| pair.with.is_some() || pair.without.is_some());
    let most = drawn.max_by(|a, b| a.limited(subject).total_cmp(&b.limited(subject)));
    if let Some(Pair { speed, with, without, .. }) = most {
        let both = [(with, "with anti-windup"), (without, "without")].into_iter().enumerate();
        let flown = both.filter_map(|(i, (flight, name))| Some((Key::nth(i, name), flight?)));
        let (keys, flights): (Vec<Key>, Vec<Flight>) = flown.unzip();
        parts.push(Part::Figure(Figure {
            name: "beyond-limits".into(),
            caption: format!(
                "{} at {speed:.2} m/s: a step that is removed at {} s.",
                capital(&subject.name()),
                TIMES[0]
            ),
            ..figure(subject, keys, &flights, TIMES[1])
        }));
    }
    Ok(parts)
}

impl Pair {
    /// Returns the time at a limit without anti-windup (s); infinite if the vehicle is lost.
    fn limited(&self, subject: &Subject) -> f64 {
        self.without.as_ref().map_or(f64::INFINITY, |flight| limited(subject, &flight.rows))
    }
}

/// Simulates the step at a speed (m/s) and back, [`DEEPER`]; the reference depth of the buoyancy is lowered as well.
/// `None` for a flight that diverges.
///
/// # Errors
/// Errors of [`fly`].
fn fly_held(
    subject: &Subject,
    speed: f64,
    height: f64,
    controller: &ControllerDesign,
) -> Result<Option<Flight>, Error> {
    let step = Manoeuvre {
        speed_from: speed,
        speed_to: speed,
        step_time: STEP_TIME,
        step_end: TIMES[0],
        duration: TIMES[1],
        ..subject.stored.manoeuvre.with_step(subject.step().name, height)
    };
    let mut vehicle = subject.inputs.vehicle.clone();
    let (depth, pitch) = subject.inputs.design.level();
    vehicle.coefficients.reference_depth += DEEPER;
    Ok(unless_lost(fly(&vehicle, controller, (depth + DEEPER, pitch), &step))?)
}

/// Returns the time with a command at a limit (s).
fn limited(subject: &Subject, rows: &[Row]) -> f64 {
    let limits = subject.inputs.limits();
    let at = |row: &&Row| row.commands.iter().zip(&limits).any(|(u, (low, high))| u <= low || u >= high);
    rows.iter().filter(at).count() as f64 * subject.inputs.design.sample_time
}

/// Returns the figures of a flight in the table.
fn cells(subject: &Subject, flight: &Flight, height: f64) -> [String; 4] {
    let (step, rows) = (subject.step(), &flight.rows);
    let from = rows.first().map_or(0.0, |row| row.measured(step.index));
    let most = rows.iter().map(|row| (row.measured(step.index) - from).abs()).fold(0.0, f64::max);
    let back = StepFigures::of(rows, step.index, (TIMES[0], -height), &subject.inputs.limits());
    let overshoot = if back.overshoot.is_finite() { tidy(100.0 * back.overshoot, 1) } else { "-".into() };
    [tidy(step.factor * most, 2), known(limited(subject, rows), 2), known(back.settling_time, 2), overshoot]
}

#[cfg(test)]
mod tests {
    use super::*;
    use squid_base::progress::Progress;
    use squid_design::inputs::Inputs;
    use squid_design::store::load;
    use squid_scheduled::OverSpeed;
    use std::path::Path;

    /// Steps of 30 deg are reported and evaluated at the limited size if references are limited to 5 deg from level.
    #[test]
    fn reports_and_evaluates_limited_steps() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../vehicles/squid");
        let inputs = Inputs::read(&folder, "design").unwrap();
        let mut stored = load(&folder.join("frozen"), &inputs).unwrap();
        let level = stored.controller.trim.signals["pitch"].clone();
        let off = |by: f64| OverSpeed::Table(level.iter().map(|pitch| pitch + by.to_radians()).collect());
        stored.controller.envelope.get_mut("pitch").unwrap().range = Some([-5.0, 5.0].map(off));
        let progress = Progress::default();
        let subject = Subject::new(&inputs, &stored, &progress).unwrap();
        let parts = limits(&subject).unwrap();
        let Part::Text(said) = &parts[0] else { panic!("{parts:?}") };
        insta::assert_snapshot!(said);
        if let Some(Part::Table(table)) = parts.get(1) {
            let used = |row: &Vec<String>| (row[1].ends_with("30"), row[2].trim_start_matches('-') == "5");
            assert!(table.rows.iter().all(|row| used(row) == (true, true)), "{table:?}");
        }
    }
}
