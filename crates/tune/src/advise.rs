//! Advice on the key to change, and its direction, from sensitivities: the design is repeated with each key raised.
//!
//! ```text
//! change_i(k) = margin_i with key k raised - margin_i,   for each row i of the verdict; about its negative if lowered
//! gain = change of the missed row,   loss = the largest decrease of the margin of another row
//! best = max gain/(NEGLIGIBLE_LOSS + loss)
//! ```
//!
//! The design with a lowered key is computed before the advice is to lower it.

use crate::attempt::{ControllerKind, attempt, margin};
use crate::error::Error;
use crate::knob::Knob;
use rayon::prelude::*;
use squid_base::progress::Progress;
use squid_design::fit::Model;
use squid_design::inputs::Inputs;
use squid_design::verdict::Verdict;
use squid_design::verdict::row::{Advice, KeyChange, Outcome, Row};

/// Factor on a key.
const TURN: f64 = 1.1;

/// Smallest significant gain: the tolerance of the search for gamma causes changes of this size.
const NO_GAIN: f64 = 1e-3;

/// Largest negligible loss.
const NEGLIGIBLE_LOSS: f64 = 1e-2;

/// Effect of raising or lowering one key.
struct Change {
    knob: Knob,
    /// [`TURN`] or its inverse.
    factor: f64,
    /// Increase of the margin of each row; NaN if unknown.
    changes: Vec<f64>,
    /// Verdict of the design; `None` if the changes are the negative of those in the other direction.
    verdict: Option<Verdict>,
}

/// Adds advice to each missed row of the verdict of a controller of this kind.
///
/// # Errors
/// [`Error::Design`] if the design itself fails.
pub fn advise(
    inputs: &Inputs,
    kind: ControllerKind,
    verdict: &mut Verdict,
    progress: &Progress,
) -> Result<(), Error> {
    let model = Model::new(&inputs.axis(), &inputs.design)?;
    let knobs = Knob::all(&inputs.design);
    let long = match kind {
        ControllerKind::Robust => "; each is a robust design and takes many minutes",
        _ => "",
    };
    let what = format!("designing with each of {} keys changed{long}", knobs.len());
    let _running = progress.begin("advise", &what);
    let design = |turn: (Knob, f64)| attempt(inputs, &model, &[turn], kind).ok();
    let (base, raised) = rayon::join(
        || attempt(inputs, &model, &[], kind),
        || knobs.par_iter().map(|knob| design((*knob, TURN))).collect::<Vec<_>>(),
    );
    let base = base?;
    let missed: Vec<usize> = verdict
        .missed()
        .filter_map(|row| base.rows.iter().position(|other| other.name == row.name))
        .collect();
    let mut all = vec![];
    for (knob, verdict) in knobs.into_iter().zip(raised) {
        let changes = changes(&base, verdict.as_ref());
        let opposite = changes.iter().map(|change| -change).collect();
        all.push(Change { knob, factor: 1.0 / TURN, changes: opposite, verdict: None });
        all.push(Change { knob, factor: TURN, changes, verdict });
    }
    // The negative of an unknown change is unknown.
    let is_unclear = |turned: &Change| missed.iter().any(|row| turned.changes[*row].is_nan());
    let mut unverified: Vec<usize> =
        (0..all.len()).filter(|i| all[*i].verdict.is_none() && is_unclear(&all[*i])).collect();
    loop {
        let designed: Vec<Option<Verdict>> =
            unverified.par_iter().map(|i| design((all[*i].knob, all[*i].factor))).collect();
        for (i, verdict) in unverified.iter().zip(designed) {
            all[*i].changes = changes(&base, verdict.as_ref());
            all[*i].verdict = verdict;
        }
        unverified = missed.iter().filter_map(|row| best(*row, &all)).collect();
        unverified.retain(|i| all[*i].verdict.is_none());
        unverified.sort_unstable();
        unverified.dedup();
        if unverified.is_empty() {
            break;
        }
    }
    for row in verdict.rows.iter_mut().filter(|row| row.outcome == Outcome::Missed) {
        let index = base.rows.iter().position(|other| other.name == row.name);
        row.advice = index.map(|index| advice(inputs, &base, index, best(index, &all).map(|i| &all[i])));
    }
    Ok(())
}

/// Returns the index of the change with the best ratio of the gain in a row to the loss in others.
fn best(row: usize, all: &[Change]) -> Option<usize> {
    let merit = |turned: &Change| {
        let others = turned.changes.iter().enumerate().filter(|(i, change)| *i != row && change.is_finite());
        let loss = others.map(|(_, change)| -change).fold(0.0, f64::max);
        turned.changes[row] / (NEGLIGIBLE_LOSS + loss)
    };
    let gains = all.iter().enumerate().filter(|(_, turned)| turned.changes[row] > NO_GAIN);
    gains.max_by(|a, b| merit(a.1).total_cmp(&merit(b.1))).map(|(i, _)| i)
}

fn advice(inputs: &Inputs, base: &Verdict, index: usize, found: Option<&Change>) -> Advice {
    let Some((turned, verdict)) = found.and_then(|turned| Some((turned, turned.verdict.as_ref()?))) else {
        return Advice { change: None, text: "no weight improves it".into() };
    };
    let key = turned.knob.name(&inputs.design);
    let verb = if turned.factor > 1.0 { "raise" } else { "lower" };
    let after = |row: &Row| verdict.rows.iter().find(|other| other.name == row.name).map(Row::found);
    let moves = |row: &Row| format!("{} -> {}", row.found(), after(row).unwrap_or_default());
    let mut text =
        format!("{verb} {key} by {:.0} %: {}", 100.0 * (turned.factor - 1.0).abs(), moves(&base.rows[index]));
    let others = (0..base.rows.len()).filter(|i| *i != index && turned.changes[*i] < -NO_GAIN);
    if let Some(worst) = others.min_by(|a, b| turned.changes[*a].total_cmp(&turned.changes[*b])) {
        text += &format!("; the largest cost is in {}, {}", base.rows[worst].name, moves(&base.rows[worst]));
    }
    Advice { change: Some(KeyChange { key, factor: turned.factor }), text }
}

/// Returns the increase of the margin of each row in another verdict; NaN if unknown.
fn changes(base: &Verdict, after: Option<&Verdict>) -> Vec<f64> {
    base.rows.iter().map(|row| after.and_then(|after| change(row, after)).unwrap_or(f64::NAN)).collect()
}

/// Returns the increase of the margin of a row in another verdict; `None` if unknown.
fn change(row: &Row, after: &Verdict) -> Option<f64> {
    let after = after.rows.iter().find(|other| other.name == row.name)?;
    let base = row.achieved.value;
    // A value that was unknown before gains as much as its limit. Changes of small values without a limit are rounding.
    let gain =
        if base.is_finite() { margin(after, base) - margin(row, base) } else { 1.0 + margin(after, 1.0) };
    let negligible = row.outcome == Outcome::Reported && base.abs() < NEGLIGIBLE_LOSS;
    (gain.is_finite() && !negligible).then_some(gain)
}
