//! The scheduled controller against controllers made for six speeds and switched, under the same ramp of speed.

use super::axis::Axis;
use super::chart::{Chart, Curve, Key};
use super::figure::Figure;
use super::section::{Part, Table};
use super::subject::Subject;
use super::switched::{Memory, fly_switched};
use super::verdict::{AT_REST, Ridden, Verdict, WORSE, switching_harms};
use crate::error::Error;
use crate::flight::{Row, fly};
use lpv::state_space::StateSpace;
use lpv::synthesis::{Options, synthesise};

/// The section.
///
/// # Errors
/// [`Error::Synthesis`] when a speed alone has no controller; as [`fly`].
pub fn switching(subject: &Subject) -> Result<Vec<Part>, Error> {
    let (inputs, stored) = (subject.inputs, subject.stored);
    let bank = bank(subject)?;
    let mut flights = vec![(
        "scheduled",
        fly(&inputs.vehicle, &stored.controller, inputs.design.depth, &stored.manoeuvre)?,
    )];
    for (memory, name) in [
        (Memory::Reset, "switched, states reset"),
        (Memory::Carried, "switched, states carried over"),
        (Memory::Parallel, "switched, all running"),
    ] {
        flights.push((name, fly_switched(subject, &bank, memory)?));
    }
    let ridden: Vec<Ridden> = flights.iter().map(|(_, rows)| ridden(subject, rows)).collect();
    let mut table = Table::new([
        "controller",
        "rms pitch error after the step, % of it",
        "error at the end, %",
        "largest jump of a command, % of its reach",
    ]);
    for ((name, _), r) in flights.iter().zip(&ridden) {
        table.rows.push(vec![
            (*name).into(),
            format!("{:.2}", 100.0 * r.error),
            format!("{:.2}", 100.0 * r.error_at_end),
            format!("{:.2}", 100.0 * r.jump),
        ]);
    }
    let names: Vec<String> = subject.speeds.iter().map(|v| format!("{v:.2}")).collect();
    let words = format!(
        "The same synthesis for the plant frozen at {} m/s gives {} controllers without parameters; the one made for the speed nearest to the \
         measured one is in charge. When it changes, the new one starts from zero ('reset'), or takes over the numbers in the old one's states \
         ('carried over'; the states of two syntheses do not mean the same), or all run all the time on the same errors and only \
         the output is switched ('all running'). Ramp, step, feedforward and vehicle are those of the manoeuvre above.",
        names.join(", "),
        bank.len()
    );
    Ok(vec![
        Part::Words(words),
        Part::Figure(figure(subject, &flights)),
        Part::Table(table),
        Part::Verdict(verdict(&ridden)),
    ])
}

/// One controller without parameters for each of the six speeds.
fn bank(subject: &Subject) -> Result<Vec<StateSpace>, Error> {
    let options = Options { back_off: subject.inputs.design.back_off, ..Options::default() };
    let made = |v: &f64| {
        let plant = subject.plant.frozen(&[subject.rho(*v)])?;
        Ok(synthesise(&plant, options)?.controller.frozen(&[])?)
    };
    subject.speeds.iter().map(made).collect()
}

fn ridden(subject: &Subject, rows: &[Row]) -> Ridden {
    let m = &subject.stored.manoeuvre;
    let after: Vec<&Row> = rows.iter().filter(|r| r.time >= m.step_time).collect();
    let rms = |rows: &[&Row]| {
        let squares = rows.iter().map(|r| ((r.pitch_reference - r.pitch) / m.pitch_step).powi(2));
        (squares.sum::<f64>() / rows.len() as f64).sqrt()
    };
    let tail = &after[after.len() - (after.len() / 10).clamp(1, after.len())..];
    // At the step every controller jumps.
    let quiet = |w: &&[Row]| w[1].time < m.step_time || w[0].time >= m.step_time;
    let actuators = &subject.inputs.vehicle.actuators;
    let jump = |w: &[Row]| {
        let each = actuators.iter().enumerate();
        each.map(|(j, a)| (w[1].commands[j] - w[0].commands[j]).abs() / a.reach()).fold(0.0, f64::max)
    };
    let jumps = rows.windows(2).filter(quiet).filter(|w| (w[1].time - m.step_time).abs() > 1e-6).map(jump);
    Ridden { error: rms(&after), error_at_end: rms(tail), jump: jumps.fold(0.0, f64::max) }
}

fn verdict(ridden: &[Ridden]) -> Verdict {
    let (scheduled, switched) = (ridden[0], &ridden[1..]);
    let largest = |of: fn(&Ridden) -> f64| switched.iter().map(of).fold(0.0, f64::max);
    let resting = switched.iter().filter(|r| r.error_at_end <= AT_REST).count();
    Verdict {
        claim: "instability may arise in switched linear systems, even if each controller alone is stable (introduction).",
        criterion: format!(
            "borne out, if a switched flight does not come to rest (an rms pitch error over the last tenth above {:.0} % of the step) where the \
             scheduled one does; partly, if all do but one has an rms error or a jump of a command more than {:.0} % above the scheduled \
             one's. One ramp cannot show that no other switching does harm.",
            100.0 * AT_REST,
            100.0 * (WORSE - 1.0)
        ),
        finding: switching_harms(scheduled, switched),
        because: format!(
            "{resting} of {} switched flights come to rest. The rms error is {:.2} % of the step scheduled and up to {:.2} % switched; the largest \
             jump of a command is {:.2} % of its reach scheduled and up to {:.2} % switched.",
            switched.len(),
            100.0 * scheduled.error,
            100.0 * largest(|r| r.error),
            100.0 * scheduled.jump,
            100.0 * largest(|r| r.jump)
        ),
    }
}

fn figure(subject: &Subject, flights: &[(&str, Vec<Row>)]) -> Figure {
    let (index, actuator) = subject.pitching_actuator();
    let (factor, unit) =
        if actuator.unit() == "rad" { (1f64.to_degrees(), "deg") } else { (1.0, actuator.unit()) };
    let curves = |of: &dyn Fn(&Row) -> f64| -> Vec<Curve> {
        let each = flights.iter().enumerate();
        each.map(|(key, (_, rows))| Curve { key, points: rows.iter().map(|r| (r.time, of(r))).collect() })
            .collect()
    };
    let chart = |label: String, curves| Chart {
        title: String::new(),
        x: Axis::linear("time (s)"),
        y: Axis::linear(label),
        curves,
    };
    let keys = flights.iter().enumerate().map(|(i, (name, _))| Key::nth(i, *name)).collect();
    Figure {
        name: "scheduled-and-switched".into(),
        caption: format!(
            "{} under one and the same ramp of speed.",
            super::open_loop::capital(&subject.name())
        ),
        keys,
        charts: vec![
            chart("pitch error (deg)".into(), curves(&|r| (r.pitch_reference - r.pitch).to_degrees())),
            chart("speed error (m/s)".into(), curves(&|r| r.speed_reference - r.speed)),
            chart(format!("{} ({unit})", actuator.name), curves(&|r| factor * r.commands[index])),
        ],
    }
}
