//! Comparison with other designs of the vehicle: check of their course, sizes, proofs and verdicts.

use crate::error::Error;
use crate::subject::{Step, Subject};
use squid_design::certify::claims::bound;
use squid_design::inputs::Inputs;
use squid_design::inputs::design_file::Tracked;
use squid_design::verdict::row::{Outcome, Row};

/// Cell for a figure that a law does not have.
pub(crate) const NOTHING: &str = "-";

/// Key of the rows that depend on the declared uncertainty.
const MU: &str = "mu";

/// Checks that another design of the vehicle can fly the course of the first: both must track the same outputs besides
/// the speed, with the same speeds, depth and manoeuvre.
///
/// # Errors
/// [`Error::NotBeside`].
pub fn check(first: &Inputs, other: &Inputs) -> Result<(), Error> {
    let file = first.design.source();
    let refused = |what| Err(Error::NotBeside { file: other.design.source(), what });
    let [steered, own] = [first, other].map(|inputs| {
        let besides_speed = |one: &&Tracked| Some(one.index) != inputs.design.interface.scheduled();
        let names = inputs.design.tracked.iter().filter(besides_speed).map(|one| one.signal.name);
        names.collect::<Vec<_>>().join(" and ")
    });
    if own != steered || own.is_empty() {
        let [steered, own] = [steered, own].map(|one| if one.is_empty() { "nothing".into() } else { one });
        return refused(format!("it steers {own}, but {file} steers {steered}"));
    }
    let differs = |((key, ours, unit), (_, theirs, _)): ((String, f64, &str), (String, f64, &str))| {
        let [shown, other] = [ours, theirs].map(squid_auv::rounded);
        (ours != theirs).then(|| format!("'{key}' is {other} {unit}, but {shown} {unit} in {file}"))
    };
    let different: Vec<String> = course(first).into_iter().zip(course(other)).filter_map(differs).collect();
    if different.is_empty() { Ok(()) } else { refused(different.join("; ")) }
}

/// Returns the keys of a design file that determine its flights, with values and units.
fn course(inputs: &Inputs) -> Vec<(String, f64, &'static str)> {
    let (design, manoeuvre) = (&inputs.design, &inputs.design.manoeuvre);
    let Step { name, height, factor, unit, .. } = Step::of(inputs, manoeuvre);
    let keys = [
        ("speed_min", design.speed_min, "m/s"),
        ("speed_max", design.speed_max, "m/s"),
        ("depth", design.depth, "m"),
        ("step_time", manoeuvre.step_time, "s"),
        ("speed_from", manoeuvre.speed_from, "m/s"),
        ("speed_to", manoeuvre.speed_to, "m/s"),
        ("ramp_start", manoeuvre.ramp_start, "s"),
        ("ramp_duration", manoeuvre.ramp_duration, "s"),
        ("duration", manoeuvre.duration, "s"),
    ];
    let keys = keys.into_iter().map(|(key, value, unit)| (key.to_owned(), value, unit));
    keys.chain([(format!("{name}_step"), factor * height, unit)]).collect()
}

/// Returns the description of a table with other designs; empty without any.
pub(crate) fn explanation(subject: &Subject) -> String {
    if subject.beside.is_empty() {
        return String::new();
    }
    let own = subject.inputs.design.source();
    format!(
        "Other designs of the same vehicle are simulated with their own filters, sample time, delay and anti-windup, \
            in the box declared by {own}. The first rows give the sizes and proved bounds of each design, with the \
            weights of its own file; the last rows give the worst values of the verdicts, with MISSED if the \
            requirement in the design's own file is missed; this requirement is shown if it differs from that of \
            {own}. A dash means that a design has no such figure, does not track the speed, or declares another \
            uncertainty."
    )
}

/// Returns rows of states and channels, and of the proved gains.
pub(crate) fn proofs(designs: &[&Subject]) -> Vec<Vec<String>> {
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
        row("proved gain", &|subject| match subject.proof() {
            Ok(theorem) if subject.stored.controller.gamma.certified => bound(theorem),
            _ => "NO".into(),
        }),
        row("proved gain of the sampled loop", &|subject| {
            subject
                .stored
                .prove_sampled(subject.inputs)
                .map_or_else(|_| "NO".into(), |theorem| bound(&theorem))
        }),
    ]
}

/// Returns the rows of the verdicts.
pub(crate) fn verdicts(designs: &[&Subject]) -> Result<Vec<Vec<String>>, Error> {
    let verdicts = designs
        .iter()
        .map(|subject| Ok(subject.verdict()?.rows.as_slice()))
        .collect::<Result<Vec<_>, Error>>()?;
    let mut order: Vec<&str> = vec![];
    for row in verdicts.iter().copied().flatten() {
        if !order.contains(&row.name.as_str()) {
            order.push(&row.name);
        }
    }
    let box_of = |subject: &Subject| (subject.inputs.uncertain.clone(), subject.inputs.actuator_gain());
    let row = |what: &str| {
        let found: Vec<Option<&Row>> =
            verdicts.iter().map(|rows| rows.iter().find(|row| row.name == what)).collect();
        let required = found[0].map(Row::required).unwrap_or_default();
        let cells = found.iter().zip(designs).map(|(row, subject)| match row {
            Some(row) if row.key != MU || box_of(subject) == box_of(designs[0]) => cell(row, &required),
            _ => NOTHING.to_owned(),
        });
        [what.to_owned(), required.clone()].into_iter().chain(cells).collect()
    };
    Ok(order.into_iter().map(row).collect())
}

/// Returns a figure as text, with its own requirement if that is not `required`, and marked if it misses its own.
fn cell(row: &Row, required: &str) -> String {
    let mut text = row.found();
    match row.required() {
        own if own == required => {}
        own if own.is_empty() => text += " (none required)",
        own => text += &format!(" ({own})"),
    }
    if row.outcome == Outcome::Missed {
        text += " MISSED";
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use squid_design::inputs::design_file::Sense;
    use squid_design::verdict::row::Figure;
    use std::path::Path;

    #[test]
    fn cell_uses_requirement_of_its_own_file() {
        let row = |limit, outcome| Row {
            key: "phase_margin",
            name: "phase margin".into(),
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
    fn refuses_designs_on_other_courses() {
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
        insta::assert_snapshot!(check(&first, &slow).unwrap_err());
        let remus = vehicles.join("remus100");
        let depth = Inputs::read_axis(&remus, "design", Some("depth")).unwrap();
        let pitch = read("remus100", "pitch");
        for (first, other) in [(&pitch, &depth), (&depth, &pitch)] {
            let Error::NotBeside { what, .. } = check(first, other).unwrap_err() else { panic!() };
            let [steered, own] = [first, other].map(|inputs| inputs.design.steered_signal());
            assert!(what.find(own) < what.rfind(steered), "{what}");
        }
    }
}
