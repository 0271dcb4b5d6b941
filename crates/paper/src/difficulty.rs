//! Speed at which control is hardest.

use crate::claims::{Claim, Found, hardest_below, worst};
use squid_flight::metrics::StepFigures;
use squid_report::error::Error;
use squid_report::page::{Part, Table, known};
use squid_report::sections::frozen_loop::FrozenLoop;
use squid_report::subject::Subject;

/// Computes the section on the difficulty of control at six speeds, with the claim on low speed.
///
/// # Errors
/// The errors of [`squid_flight::flight::fly`].
pub fn difficulty(subject: &Subject) -> Result<Found, Error> {
    let flown = subject.fly_steps()?;
    let figures: Vec<StepFigures> = flown.iter().map(|flight| subject.figures(flight)).collect();
    let pitch = subject.pitch()?;
    let peak = |l| Ok(FrozenLoop::flying(subject, &subject.controller, l)?.peak(pitch));
    let peaks = subject.truth.iter().map(peak).collect::<Result<Vec<f64>, Error>>()?;
    let difficulty = measures(subject, &figures, &peaks);
    let mut table = Table { head: vec!["speed (m/s)".into()], rows: vec![] };
    table.head.extend(difficulty.iter().map(|(name, _)| (*name).to_owned()));
    for (i, v) in subject.speeds.iter().enumerate() {
        let mut row = vec![format!("{v:.2}")];
        row.extend(
            difficulty.iter().map(|(_, values)| known(values[i].1, if values[i].1 < 2.0 { 4 } else { 2 })),
        );
        table.rows.push(row);
    }
    Ok((vec![Part::Table(table)], vec![claim(subject, &difficulty)]))
}

type Measure = (&'static str, Vec<(f64, f64)>);

/// Difficulty of control at each speed, by four measures: larger is harder.
fn measures(subject: &Subject, figures: &[StepFigures], peaks: &[f64]) -> [Measure; 4] {
    let at = |of: &dyn Fn(usize) -> f64| -> Vec<(f64, f64)> {
        subject.speeds.iter().enumerate().map(|(i, v)| (*v, of(i))).collect()
    };
    let alone = |i: usize| subject.alone()[i].as_ref().map_or(f64::NAN, |design| design.gamma_optimum);
    let peak = |i: usize| peaks[i];
    [
        ("least gamma of a controller for this speed only (continuous time)", at(&alone)),
        ("peak of |S| of pitch, as implemented", at(&peak)),
        ("settling of a step (s)", at(&|i| figures[i].settling_time)),
        ("largest actuator use (%)", at(&|i| 100.0 * figures[i].actuator_use)),
    ]
}

fn claim(subject: &Subject, difficulty: &[Measure]) -> Claim {
    let (centre, _) = subject.inputs.design.scheduling();
    let each: Vec<String> = difficulty
        .iter()
        .map(|(name, values)| match worst(values) {
            Some(at) => format!("{name}: {at:.2} m/s"),
            None => format!("{name}: no single speed"),
        })
        .collect();
    let measures: Vec<Vec<(f64, f64)>> = difficulty.iter().map(|(_, values)| values.clone()).collect();
    Claim {
        claim: "it is more difficult to control the vehicle at low speed than at high speed (section 4).",
        criterion: format!(
            "the speed, of six, at which each of the four measures in the table is worst: confirmed if all are below \
                the middle of the range, {centre:.2} m/s, partly confirmed if some are."
        ),
        finding: hardest_below(centre, &measures),
        because: format!("The worst speeds are, for {}.", each.join("; by ")),
    }
}
