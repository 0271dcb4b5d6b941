//! The actuators during the pitch steps at six speeds, and at which speed control is hardest.

use crate::error::Error;
use crate::page::chart::{Chart, Curve};
use crate::page::figure::Figure;
use crate::page::key::Key;
use crate::page::section::{Part, Table};
use crate::sections::frozen_loop::FrozenLoop;
use crate::sections::tuning::seconds;
use crate::subject::{SHOWN, Subject};
use crate::verdict::{Verdict, hardest_below, worst};
use squid_design::numbers::readable;
use squid_flight::flight::{Flight, Row};
use squid_flight::metrics::StepFigures;

/// The section on actuator use in the pitch steps, with the verdict on low speed.
///
/// # Errors
/// As [`squid_flight::flight::fly`].
pub fn effort(subject: &Subject) -> Result<Vec<Part>, Error> {
    let lft = &subject.stored.controller.lft;
    let flown =
        subject.speeds.iter().map(|v| subject.fly_step(*v, lft)).collect::<Result<Vec<Flight>, Error>>()?;
    let ends = flown.iter().zip(&subject.speeds).filter_map(|(f, v)| Some((v, f.surfacing?)));
    let ends: String =
        ends.map(|(v, s)| format!("In the step at {v:.2} m/s {s}, and the flight ends there. ")).collect();
    let figures: Vec<StepFigures> = flown.iter().map(|flight| subject.figures(flight)).collect();
    let flights: Vec<Vec<Row>> = flown.into_iter().map(|flight| flight.rows).collect();
    let pitch = subject.pitch()?;
    let peak = |l| Ok(FrozenLoop::flying(subject, &subject.controller, l)?.peak(pitch));
    let peaks = subject.truth.iter().map(peak).collect::<Result<Vec<f64>, Error>>()?;
    let difficulty = difficulty(subject, &figures, &peaks);
    let mut table = Table { head: vec!["speed (m/s)".into()], rows: vec![] };
    table.head.extend(difficulty.iter().map(|(name, _)| (*name).to_owned()));
    for (i, v) in subject.speeds.iter().enumerate() {
        let mut row = vec![format!("{v:.2}")];
        row.extend(difficulty.iter().map(|(_, values)| digits(values[i].1)));
        table.rows.push(row);
    }
    let words = (!ends.is_empty()).then(|| Part::Words(ends.trim_end().into()));
    Ok(words
        .into_iter()
        .chain([
            Part::Figure(figure(subject, &flights)),
            Part::Table(table),
            Part::Verdict(verdict(subject, &difficulty)),
        ])
        .collect())
}

fn digits(v: f64) -> String {
    if v.is_nan() {
        "unknown".into()
    } else if v < 2.0 {
        format!("{v:.4}")
    } else {
        seconds(v)
    }
}

type Measure = (&'static str, Vec<(f64, f64)>);

/// How hard control is at each speed, by four measures: larger is harder.
fn difficulty(subject: &Subject, figures: &[StepFigures], peaks: &[f64]) -> [Measure; 4] {
    let at = |of: &dyn Fn(usize) -> f64| -> Vec<(f64, f64)> {
        subject.speeds.iter().enumerate().map(|(i, v)| (*v, of(i))).collect()
    };
    let alone = |i: usize| subject.alone()[i].as_ref().map_or(f64::NAN, |design| design.gamma_optimum);
    let peak = |i: usize| peaks[i];
    [
        ("least gamma of a controller for this speed alone (continuous time)", at(&alone)),
        ("peak of |S| of pitch, as it flies", at(&peak)),
        ("settling of a step (s)", at(&|i| figures[i].settling_time)),
        ("largest actuator use (%)", at(&|i| 100.0 * figures[i].actuator_use)),
    ]
}

fn verdict(subject: &Subject, difficulty: &[Measure]) -> Verdict {
    let (centre, _) = subject.inputs.design.scheduling();
    let each: Vec<String> = difficulty
        .iter()
        .map(|(name, values)| match worst(values) {
            Some(at) => format!("{name}: {at:.2} m/s"),
            None => format!("{name}: no single speed"),
        })
        .collect();
    let measures: Vec<Vec<(f64, f64)>> = difficulty.iter().map(|(_, values)| values.clone()).collect();
    Verdict {
        claim: "it is more difficult to control the vehicle at low speed than at high speed (section 4).",
        criterion: format!(
            "at which of the six speeds each of the four measures in the table is worst: for all of them below \
                the middle of the range, {centre:.2} m/s, confirms it, for some of them partly."
        ),
        finding: hardest_below(centre, &measures),
        because: format!("Worst is, by {}.", each.join("; by ")),
    }
}

fn figure(subject: &Subject, flights: &[Vec<Row>]) -> Figure {
    let chart = |(j, actuator): (usize, &auv::Actuator)| {
        let (factor, unit) = readable(actuator.unit());
        let mut curves: Vec<Curve> = flights
            .iter()
            .enumerate()
            .map(|(key, rows)| {
                let shown = rows.iter().filter(|r| r.time <= SHOWN);
                Curve { key, points: shown.map(|r| (r.time, factor * r.commands[j])).collect() }
            })
            .collect();
        for limit in [actuator.min, actuator.max] {
            curves.push(Curve {
                key: flights.len(),
                points: vec![(0.0, factor * limit), (SHOWN, factor * limit)],
            });
        }
        Chart::over_time(actuator.name.as_str(), format!("command ({unit})"), curves)
    };
    let mut keys = subject.speed_keys();
    keys.push(Key::reference("limits"));
    Figure {
        name: "actuators-in-steps".into(),
        caption: format!(
            "Commands of {} during a pitch step of {:.0} deg at six speeds, nonlinear and sampled, with the \
                design's own weights.",
            subject.name(),
            subject.stored.manoeuvre.pitch_step.to_degrees()
        ),
        keys,
        charts: subject.inputs.vehicle.actuators.iter().enumerate().map(chart).collect(),
    }
}
