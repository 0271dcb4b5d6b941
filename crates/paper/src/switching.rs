//! Scheduled controller against controllers designed for six speeds and switched, under the same ramp of speed.

use crate::alternation::{Alternation, Loop, worst_alternation};
use crate::claims::{AT_REST, Claim, Found, RampFigures, WORSE, switching_harms};
use crate::switched::{Handover, fly_switched};
use squid_auv::longitudinal::{PITCH, SPEED};
use squid_auv::readable;
use squid_flight::flight::{Row, fly};
use squid_lpv::error::SynthesisError;
use squid_lpv::state_space::StateSpace;
use squid_lpv::synthesis::Design;
use squid_report::error::Error;
use squid_report::page::{Chart, Curve, Figure, Key, Part, Table, capital};
use squid_report::subject::Subject;

/// Time after the step in which jumps are not counted (s).
const IGNORED_AFTER_STEP: f64 = 1.0;

const HANDOVERS: [(Handover, &str); 3] = [
    (Handover::Reset, "switched, states reset"),
    (Handover::Carried, "switched, states carried over"),
    (Handover::Parallel, "switched, all running"),
];

/// Computes the section on the scheduled controller against six switched ones.
///
/// # Errors
/// [`Error::PitchNotTracked`]; [`Error::Design`] if a speed alone has no controller; the errors of [`fly`].
pub fn switching(subject: &Subject) -> Result<Found, Error> {
    subject.pitch()?;
    let (inputs, stored) = (subject.inputs, subject.stored);
    let bank = bank(subject)?;
    let mut flights = vec![(
        "scheduled",
        fly(&inputs.vehicle, &stored.controller, inputs.design.level(), &stored.manoeuvre)?.rows,
    )];
    let mut alternations = Vec::new();
    for (handover, name) in HANDOVERS {
        flights.push((name, fly_switched(subject, &bank, handover)?));
        let worst = |which| worst_alternation(subject, &bank, handover, which);
        alternations.push(WorstAlternations {
            name,
            flying: worst(Loop::Flying)?,
            ideal: worst(Loop::Ideal)?,
        });
    }
    let ramp_figures: Vec<RampFigures> =
        flights.iter().map(|(_, rows)| ramp_figures(subject, rows)).collect();
    let mut table = Table::new([
        "controller",
        "rms pitch error after the step, % of the step",
        "error at the end, %",
        "largest jump of a command, % of its range",
    ]);
    for ((name, _), r) in flights.iter().zip(&ramp_figures) {
        table.rows.push(vec![
            (*name).into(),
            format!("{:.2}", 100.0 * r.error),
            format!("{:.2}", 100.0 * r.error_at_end),
            format!("{:.2}", 100.0 * r.jump),
        ]);
    }
    let names: Vec<String> = subject.speeds.iter().map(|v| format!("{v:.2}")).collect();
    let text = format!(
        "The same synthesis for the plant frozen at {} m/s gives {} controllers without parameters; the one designed \
            for the speed nearest to the measured speed is active. When it changes, the new one starts from zero \
            ('reset'), or takes over the numbers in the states of the old one ('carried over'; the states of two \
            syntheses have different meanings), or all run continuously on the same errors and only the output is \
            switched ('all running'). Ramp, step, feedforward and vehicle are those of the manoeuvre above. A ramp \
            is one switching signal; in addition, at the speed midway between two neighbours, the two controllers \
            alternate, each active for the same time, from 0.05 to 20 s: the second table contains the fastest \
            growth of the linear loop as implemented, sampled and with the lags of the actuators; it is unstable \
            above 0 (a controller that is reset many times a second is little more than its direct term). For the \
            scheduled controller the theorem above, if proved, excludes instability for every signal.",
        names.join(", "),
        bank.len()
    );
    let parts = vec![
        Part::Text(text),
        Part::Figure(figure(subject, &flights)),
        Part::Table(table),
        Part::Table(alternations_table(&alternations)),
    ];
    Ok((parts, vec![claim(&ramp_figures, &alternations)]))
}

/// Controllers without parameters, one for each of the six speeds.
fn bank(subject: &Subject) -> Result<Vec<StateSpace>, Error> {
    let frozen = |design: &Result<Design, SynthesisError>| {
        Ok(design.as_ref().map_err(Clone::clone)?.controller.frozen(&[])?)
    };
    subject.alone().iter().map(frozen).collect()
}

fn ramp_figures(subject: &Subject, rows: &[Row]) -> RampFigures {
    let m = &subject.stored.manoeuvre;
    let after: Vec<&Row> = rows.iter().filter(|r| r.time >= m.step_time).collect();
    let rms = |rows: &[&Row]| {
        let squares = rows.iter().map(|r| (r.error(PITCH) / m.step("pitch")).powi(2));
        (squares.sum::<f64>() / rows.len() as f64).sqrt()
    };
    let tail = &after[after.len() - (after.len() / 10).max(1).min(after.len())..];
    // Every controller jumps at the step.
    let quiet = |w: &&[Row]| !(m.step_time - 1e-6..m.step_time + IGNORED_AFTER_STEP).contains(&w[1].time);
    let actuators = &subject.inputs.vehicle.actuators;
    let jump = |w: &[Row]| {
        let each = actuators.iter().enumerate();
        each.map(|(j, a)| (w[1].commands[j] - w[0].commands[j]).abs() / a.reach()).fold(0.0, f64::max)
    };
    let jumps = rows.windows(2).filter(quiet).map(jump);
    RampFigures { error: rms(&after), error_at_end: rms(tail), jump: jumps.fold(0.0, f64::max) }
}

/// Worst alternation for the sampled loop and for the loop in continuous time.
struct WorstAlternations {
    name: &'static str,
    flying: Option<Alternation>,
    ideal: Option<Alternation>,
}

fn alternations_table(alternations: &[WorstAlternations]) -> Table {
    let mut table = Table::new([
        "two alternating",
        "fastest growth (1/s)",
        "at speed (m/s)",
        "each active for (s)",
        "grows up to (s)",
        "each separately",
        "growth in continuous time (1/s)",
    ]);
    for pair in alternations {
        if let Some(w) = pair.flying {
            let alone = if w.each_stable { "stable" } else { "unstable" };
            table.rows.push(vec![
                pair.name.into(),
                format!("{:+.4}", w.rate),
                format!("{:.2}", w.speed),
                format!("{:.2}", w.dwell),
                w.longest.map_or_else(|| "none".into(), |l| format!("{l:.2}")),
                alone.into(),
                pair.ideal.map_or_else(|| "none".into(), |w| format!("{:+.4}", w.rate)),
            ]);
        }
    }
    table
}

fn claim(ramp_figures: &[RampFigures], alternations: &[WorstAlternations]) -> Claim {
    let (scheduled, switched) = (ramp_figures[0], &ramp_figures[1..]);
    let largest = |of: fn(&RampFigures) -> f64| switched.iter().map(of).fold(0.0, f64::max);
    let resting = switched.iter().filter(|r| r.error_at_end <= AT_REST).count();
    let stable =
        || alternations.iter().filter_map(|t| Some((t.name, t.flying?))).filter(|(_, w)| w.each_stable);
    let rates: Vec<f64> = stable().map(|(_, w)| w.rate).collect();
    let unstable: Vec<&str> = stable().filter(|(_, w)| w.rate > 0.0).map(|(name, _)| name).collect();
    let signal = match unstable.as_slice() {
        [] => "No tested signal makes the loop of two stable controllers unstable.".to_owned(),
        names => format!("Alternation makes the loop unstable: {}.", names.join("; ")),
    };
    Claim {
        claim: "switching may degrade performance, up to instability, even between controllers each of which is \
            stable (introduction).",
        criterion: format!(
            "confirmed if two controllers, each stable separately, make the loop as implemented unstable by \
                alternation, or if a switched simulation does not settle (an rms pitch error over the last tenth \
                above {:.0} % of the step) although the scheduled one does; partly confirmed if neither, but an rms \
                error or a jump of a command (except in the {IGNORED_AFTER_STEP} s after the step) is more than \
                {:.0} % above that of the scheduled controller.",
            100.0 * AT_REST,
            100.0 * (WORSE - 1.0)
        ),
        finding: switching_harms(scheduled, switched, &rates),
        because: format!(
            "{resting} of {} switched simulations settle. The rms error is {:.2} % of the step scheduled and up to \
                {:.2} % switched; the largest jump of a command is {:.2} % of its range scheduled and up to {:.2} % \
                switched. {signal}",
            switched.len(),
            100.0 * scheduled.error,
            100.0 * largest(|r| r.error),
            100.0 * scheduled.jump,
            100.0 * largest(|r| r.jump)
        ),
    }
}

fn figure(subject: &Subject, flights: &[(&str, Vec<Row>)]) -> Figure {
    let (index, actuator) = subject.turning_actuator();
    let (factor, unit) = readable(actuator.unit());
    let curves = |of: &dyn Fn(&Row) -> f64| -> Vec<Curve> {
        let each = flights.iter().enumerate();
        each.map(|(key, (_, rows))| Curve { key, points: rows.iter().map(|r| (r.time, of(r))).collect() })
            .collect()
    };
    let keys = flights.iter().enumerate().map(|(i, (name, _))| Key::nth(i, *name)).collect();
    Figure {
        name: "scheduled-and-switched".into(),
        caption: format!("{} during the same speed ramp.", capital(&subject.name())),
        keys,
        charts: vec![
            Chart::over_time("", "pitch error (deg)", curves(&|r| r.error(PITCH).to_degrees())),
            Chart::over_time("", "speed error (m/s)", curves(&|r| r.error(SPEED))),
            Chart::over_time(
                "",
                format!("{} ({unit})", actuator.name),
                curves(&|r| factor * r.commands[index]),
            ),
        ],
    }
}
