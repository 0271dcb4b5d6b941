//! Other designs of the vehicle beside that of the report: sizes, proofs, flights and verdicts, a column each.

use crate::error::Error;
use crate::page::{Part, Table};
use crate::peers::law::{Law, Scheduled};
use crate::peers::line::{DRAW, DRAWN, LOST, Line, WON, score};
use crate::peers::survival::fleet;
use crate::peers::{ON_THE_PAGE, at_speed, on_ramp, on_the_page, speeds};
use crate::subject::Subject;
use crate::threads::in_parallel;
use squid_auv::longitudinal::{DEPTH, PITCH, SPEED};
use squid_design::certify::claims::bound;
use squid_design::inputs::Inputs;
use squid_design::verdict::row::{Outcome, Row};
use std::iter::once;

/// The column of the PID, and the PID in words.
const PID: [&str; 2] = ["PID tuned in flight", "the PID"];
/// A cell of what a design does not have.
const NOTHING: &str = "-";
/// The key of the rows that depend on the declared uncertainty.
const MU: &str = "mu";

/// Checks that another design of the vehicle can fly the course of the first: both track pitch and no depth; speeds,
/// depth and manoeuvre are the same.
///
/// # Errors
/// [`Error::NotBeside`].
pub fn check(first: &Inputs, other: &Inputs) -> Result<(), Error> {
    let tracks = |inputs: &Inputs, index| inputs.design.tracked.iter().any(|t| t.index == index);
    let refused = |file: &Inputs, what| Err(Error::NotBeside { file: file.design.source(), what });
    for inputs in [first, other] {
        if !tracks(inputs, PITCH) || tracks(inputs, DEPTH) {
            return refused(inputs, "it must track pitch, and no depth".into());
        }
    }
    let differs = |((key, ours, unit), (_, theirs, _)): ((&str, f64, &str), (&str, f64, &str))| {
        let [shown, other] = [ours, theirs].map(squid_auv::rounded);
        let file = first.design.source();
        (ours != theirs).then(|| format!("'{key}' is {other} {unit}, and {shown} {unit} in {file}"))
    };
    let different: Vec<String> = course(first).into_iter().zip(course(other)).filter_map(differs).collect();
    if different.is_empty() { Ok(()) } else { refused(other, different.join("; ")) }
}

/// The keys of a design file that determine its flights, with their units.
fn course(inputs: &Inputs) -> [(&'static str, f64, &'static str); 10] {
    let (design, manoeuvre) = (&inputs.design, &inputs.design.manoeuvre);
    [
        ("speed_min", design.speed_min, "m/s"),
        ("speed_max", design.speed_max, "m/s"),
        ("depth", design.depth, "m"),
        ("pitch_step", manoeuvre.step("pitch").to_degrees(), "deg"),
        ("step_time", manoeuvre.step_time, "s"),
        ("speed_from", manoeuvre.speed_from, "m/s"),
        ("speed_to", manoeuvre.speed_to, "m/s"),
        ("ramp_start", manoeuvre.ramp_start, "s"),
        ("ramp_duration", manoeuvre.ramp_duration, "s"),
        ("duration", manoeuvre.duration, "s"),
    ]
}

/// The section on other designs; empty if none was asked for.
///
/// # Errors
/// The errors of trim, linearisation and the uncertain model, and of the verdicts.
pub fn beside(subject: &Subject) -> Result<Vec<Part>, Error> {
    if subject.beside.is_empty() {
        return Ok(vec![]);
    }
    let designs: Vec<&Subject> = once(subject).chain(&subject.beside).collect();
    let (lines, unfit) = flown(subject)?;
    let mut names: Vec<&str> = designs.iter().map(|of| of.inputs.design.name.as_str()).collect();
    let mut table = Table::new(["", "m/s; required"]);
    let pid = unfit.is_none().then_some(PID);
    table.head.extend(names.iter().copied().chain(pid.map(|[column, _]| column)).map(str::to_owned));
    table.head.extend(["best", "outcome"].map(str::to_owned));
    names.extend(pid.map(|[_, words]| words));
    table.rows = proofs(&designs);
    table.rows.extend(lines.iter().map(|line| row(line, &names)));
    table.rows.extend(verdicts(&designs)?);
    let width = table.head.len();
    for row in table.rows.iter_mut().filter(|row| row.len() < width) {
        // The PID has neither proof nor verdict.
        row.resize(2 + names.len(), NOTHING.into());
        row.resize(width, String::new());
    }
    let own = format!("the design '{}'", names[0]);
    let scores = (1..names.len()).map(|i| {
        let other = if i < designs.len() { format!("'{}'", names[i]) } else { names[i].into() };
        score(&lines, i, &other, &own)
    });
    let scores = scores.collect::<Vec<_>>().join(" ");
    Ok(once(words(subject, &own))
        .chain(unfit)
        .map(Part::Words)
        .chain([Part::Table(table), Part::Words(scores)])
        .collect())
}

fn words(subject: &Subject, own: &str) -> String {
    format!(
        "Designs of the same vehicle. First their sizes and what is proved of each, in the weights of its own file. \
            Then the flights of the section before, each design with its own filters, sample time, delay and \
            anti-windup; the vehicles of the box are those that {} declares. Best: who has the best figure, or one \
            within {:.0} % of it. Outcome: of {own} against all others. Last the worst values of the verdicts: MISSED \
            where the requirement of the design's own file is missed, which is given where it is not that of {own}. A \
            dash stands where a design has no such figure, does not track the speed, or declares another uncertainty.",
        subject.inputs.design.source(),
        100.0 * DRAW
    )
}

/// States and channels, and the proved gains.
fn proofs(designs: &[&Subject]) -> Vec<Vec<String>> {
    let row = |what: &str, of: &dyn Fn(&Subject) -> String| {
        [what.to_owned(), String::new()]
            .into_iter()
            .chain(designs.iter().map(|subject| of(subject)))
            .collect()
    };
    vec![
        row("states, channels of rho", &|subject| {
            let sizes = subject.controller.parts.sizes();
            format!("{}, {}", sizes.x, sizes.t)
        }),
        row("gain proved", &|subject| match subject.proof() {
            Ok(theorem) if subject.stored.controller.gamma.certified => bound(theorem),
            _ => "NO".into(),
        }),
        row("gain proved of the sampled loop", &|subject| {
            subject
                .stored
                .prove_sampled(subject.inputs)
                .map_or_else(|_| "NO".into(), |theorem| bound(&theorem))
        }),
    ]
}

/// The flights of all designs and of the PID; also, in words, why there is no PID.
fn flown(subject: &Subject) -> Result<(Vec<Line>, Option<String>), Error> {
    let others = in_parallel(subject.beside.iter(), |other| flown_alone(subject, other));
    let others = others.into_iter().collect::<Result<Vec<_>, Error>>()?;
    let (mut lines, unfit) = match on_the_page(subject)? {
        Ok((_, lines)) => (lines.clone(), None),
        Err(reason) => (flown_alone(subject, subject)?, Some(reason.clone())),
    };
    for (i, line) in lines.iter_mut().enumerate() {
        // The controller of the design, and the PID.
        line.values.truncate(2);
        line.values[0] = known(subject, line, line.values[0]);
        line.values.splice(1..1, others.iter().map(|other| other[i].values[0]));
    }
    lines.retain(|line| line.values.iter().any(|v| !v.is_nan()));
    Ok((lines, unfit))
}

/// The flights of a design on the course of the first.
fn flown_alone(first: &Subject, subject: &Subject) -> Result<Vec<Line>, Error> {
    let law = Scheduled(subject);
    let laws: [(&str, &dyn Law); 1] = [("", &law)];
    let mut lines = vec![];
    for speed in speeds(first) {
        lines.extend(at_speed(subject, &laws, speed, &fleet(first, speed, ON_THE_PAGE.points)?)?);
    }
    lines.extend(on_ramp(subject, &laws));
    lines.iter_mut().for_each(|line| line.values[0] = known(subject, line, line.values[0]));
    first.progress.done("report", &format!("  flown beside: {}", subject.inputs.design.name));
    Ok(lines)
}

/// The value of a line for a design; NaN for the speed of a design that does not track it.
fn known(subject: &Subject, line: &Line, value: f64) -> f64 {
    let tracked = subject.inputs.design.tracked.iter().any(|t| t.index == SPEED);
    if line.is_of_speed() && !tracked { f64::NAN } else { value }
}

/// A line of flights, with its best columns and the outcome of the first.
fn row(line: &Line, names: &[&str]) -> Vec<String> {
    let outcomes: Vec<&str> =
        (1..names.len()).map(|i| line.outcome(i)).filter(|outcome| !outcome.is_empty()).collect();
    let outcome = match () {
        () if outcomes.contains(&LOST) => LOST,
        () if outcomes.is_empty() => "",
        () if outcomes.iter().all(|outcome| *outcome == WON) => WON,
        () => DRAWN,
    };
    let best = match line.best() {
        best if best.len() > 1 && best.len() == names.len() => "all".to_owned(),
        best => best.into_iter().map(|i| names[i]).collect::<Vec<_>>().join(", "),
    };
    let cells = line.cells().chain([best, outcome.to_owned()]);
    [line.name.to_owned(), line.at.clone()].into_iter().chain(cells).collect()
}

/// The rows of the verdicts.
fn verdicts(designs: &[&Subject]) -> Result<Vec<Vec<String>>, Error> {
    let verdicts = designs
        .iter()
        .map(|subject| Ok(subject.verdict()?.rows.as_slice()))
        .collect::<Result<Vec<_>, Error>>()?;
    let mut order: Vec<&str> = vec![];
    for row in verdicts.iter().copied().flatten() {
        if !order.contains(&row.what.as_str()) {
            order.push(&row.what);
        }
    }
    let box_of = |subject: &Subject| (subject.inputs.uncertain.clone(), subject.inputs.actuator_gain());
    let row = |what: &str| {
        let found: Vec<Option<&Row>> =
            verdicts.iter().map(|rows| rows.iter().find(|row| row.what == what)).collect();
        let required = found[0].map(Row::required).unwrap_or_default();
        let cells = found.iter().zip(designs).map(|(row, subject)| match row {
            Some(row) if row.key != MU || box_of(subject) == box_of(designs[0]) => cell(row, &required),
            _ => NOTHING.to_owned(),
        });
        [what.to_owned(), required.clone()].into_iter().chain(cells).collect()
    };
    Ok(order.into_iter().map(row).collect())
}

/// A figure, with its own requirement if that is not `required`, and marked if it misses its own.
fn cell(row: &Row, required: &str) -> String {
    let mut words = row.found();
    match row.required() {
        own if own == required => {}
        own if own.is_empty() => words += " (none required)",
        own => words += &format!(" ({own})"),
    }
    if row.outcome == Outcome::Missed {
        words += " MISSED";
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;
    use squid_design::inputs::design_file::Sense;
    use squid_design::verdict::row::Figure;
    use std::path::Path;

    #[test]
    fn a_row_says_who_is_best_and_what_the_first_loses() {
        let names = ["design", "tuned", "paper"];
        for (values, best, outcome) in [
            ([2.0, 1.0, 3.0], "tuned", "lost"),
            ([1.0, 2.0, f64::NAN], "design", "won"),
            ([1.0, 1.0, 3.0], "design, tuned", "drawn"),
            ([1.0, 1.0, 1.0], "all", "drawn"),
            ([f64::NAN, 1.0, f64::NAN], "tuned", ""),
        ] {
            let row = row(&Line::new("rise (s)", "0.50", 1, 0.0, values.to_vec()), &names);
            assert_eq!(row[..2], ["rise (s)", "0.50"]);
            assert_eq!(row[2..5], values.map(|v| if v.is_nan() { "-".into() } else { format!("{v:.1}") }));
            assert_eq!(row[5..], [best, outcome]);
        }
    }

    #[test]
    fn a_cell_is_judged_by_the_requirement_of_its_own_file() {
        let row = |limit, outcome| Row {
            key: "phase_margin",
            what: "phase margin".into(),
            unit: "deg",
            sense: Sense::Above,
            limit,
            achieved: Figure { value: 50.0, speed: None, frequency: None, remark: None },
            outcome,
            advice: None,
        };
        assert_eq!(cell(&row(Some(45.0), Outcome::Met), "> 45 deg"), "50.0 deg");
        assert_eq!(cell(&row(Some(60.0), Outcome::Missed), "> 60 deg"), "50.0 deg MISSED");
        assert_eq!(cell(&row(Some(60.0), Outcome::Missed), "> 45 deg"), "50.0 deg (> 60 deg) MISSED");
        assert_eq!(cell(&row(None, Outcome::Reported), "> 45 deg"), "50.0 deg (none required)");
    }

    #[test]
    fn only_designs_on_the_same_course_stand_side_by_side() {
        let vehicles = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../vehicles");
        let read = |vehicle: &str, name: &str| Inputs::read(&vehicles.join(vehicle), name).unwrap();
        let first = read("squid", "design");
        for name in ["paper", "proved"] {
            assert!(check(&first, &read("squid", name)).is_ok(), "{name}");
        }
        let mut slow = first.clone();
        "slow.toml".clone_into(&mut slow.design.file);
        "slow".clone_into(&mut slow.design.name);
        "slow".clone_into(&mut slow.design.autopilot);
        slow.design.speed_min = 0.75;
        slow.design.manoeuvre.duration = 50.0;
        assert_eq!(
            check(&first, &slow).unwrap_err().to_string(),
            "slow.toml: 'speed_min' is 0.75 m/s, and 0.5 m/s in design.toml; 'duration' is 50 s, and 60 s in \
             design.toml; designs side by side (--beside) fly the same course"
        );
        let remus = vehicles.join("remus100");
        let depth = Inputs::read_axis(&remus, "design", Some("depth")).unwrap();
        let pitch = read("remus100", "pitch");
        for (first, other) in [(&pitch, &depth), (&depth, &pitch)] {
            let said = check(first, other).unwrap_err().to_string();
            assert!(said.starts_with("depth of design.toml: it must track pitch, and no depth"), "{said}");
        }
    }
}
