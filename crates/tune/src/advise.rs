//! What to turn, and which way, from sensitivities that are computed: the design is made again with each key raised.
//!
//! ```text
//! change_i(k) = room_i with the key k raised - room_i,   of each row i of the verdict; lowered, about the opposite
//! gain = change of the row that is missed,   loss = the largest fall of the room of another row
//! best = max gain/(LITTLE + loss)
//! ```
//!
//! Before a key is named to be lowered, that is designed, too.

use crate::attempt::{Wanted, attempt, room};
use crate::error::Error;
use crate::knob::Knob;
use base::progress::Progress;
use rayon::prelude::*;
use squid_design::fit::Model;
use squid_design::inputs::Inputs;
use squid_design::verdict::Verdict;
use squid_design::verdict::row::{Advice, Outcome, Row, Turn};

/// By how much a key is turned.
const TURN: f64 = 1.1;

/// A gain that is none: what the search for gamma leaves open moves figures by as much.
const NO_GAIN: f64 = 1e-3;

/// A loss as small as this is none.
const LITTLE: f64 = 1e-2;

/// A key turned one way.
struct Turned {
    knob: Knob,
    /// [`TURN`] or its inverse.
    factor: f64,
    /// By how much the room of each row grows; not-a-number where that is not known.
    changes: Vec<f64>,
    /// What came out of the design; `None` for what is taken to be the opposite of the other way.
    verdict: Option<Verdict>,
}

/// Names what to turn for each row that a verdict misses, of the controller that was `wanted`.
///
/// # Errors
/// [`Error::Design`]: the design itself does not come out.
pub fn advise(
    inputs: &Inputs,
    wanted: Wanted,
    verdict: &mut Verdict,
    progress: &Progress,
) -> Result<(), Error> {
    let model = Model::new(&inputs.vehicle, &inputs.design)?;
    let knobs = Knob::all(&inputs.design);
    let long = match wanted {
        Wanted::Robust => "; each is a robust design: many minutes",
        _ => "",
    };
    let what = format!("designing again with each of {} keys turned{long}", knobs.len());
    let _running = progress.begin("advise", &what);
    let design = |turn: (Knob, f64)| attempt(inputs, &model, &[turn], wanted).ok();
    let (base, raised) = rayon::join(
        || attempt(inputs, &model, &[], wanted),
        || knobs.par_iter().map(|knob| design((*knob, TURN))).collect::<Vec<_>>(),
    );
    let base = base?;
    let missed: Vec<usize> = verdict
        .missed()
        .filter_map(|row| base.rows.iter().position(|other| other.what == row.what))
        .collect();
    let mut all = vec![];
    for (knob, verdict) in knobs.into_iter().zip(raised) {
        let changes = changes(&base, verdict.as_ref());
        let opposite = changes.iter().map(|change| -change).collect();
        all.push(Turned { knob, factor: 1.0 / TURN, changes: opposite, verdict: None });
        all.push(Turned { knob, factor: TURN, changes, verdict });
    }
    // The opposite of what is not known is not known.
    let is_unclear = |turned: &Turned| missed.iter().any(|row| turned.changes[*row].is_nan());
    let mut unsure: Vec<usize> =
        (0..all.len()).filter(|i| all[*i].verdict.is_none() && is_unclear(&all[*i])).collect();
    loop {
        let designed: Vec<Option<Verdict>> =
            unsure.par_iter().map(|i| design((all[*i].knob, all[*i].factor))).collect();
        for (i, verdict) in unsure.iter().zip(designed) {
            all[*i].changes = changes(&base, verdict.as_ref());
            all[*i].verdict = verdict;
        }
        unsure = missed.iter().filter_map(|row| best(*row, &all)).collect();
        unsure.retain(|i| all[*i].verdict.is_none());
        unsure.sort_unstable();
        unsure.dedup();
        if unsure.is_empty() {
            break;
        }
    }
    for row in verdict.rows.iter_mut().filter(|row| row.outcome == Outcome::Missed) {
        let place = base.rows.iter().position(|other| other.what == row.what);
        row.advice = place.map(|place| advice(inputs, &base, place, best(place, &all).map(|i| &all[i])));
    }
    Ok(())
}

/// Of the ways to turn a key, by its place, the one that gains most in a row for what it loses elsewhere.
fn best(row: usize, all: &[Turned]) -> Option<usize> {
    let merit = |turned: &Turned| {
        let others = turned.changes.iter().enumerate().filter(|(i, change)| *i != row && change.is_finite());
        let loss = others.map(|(_, change)| -change).fold(0.0, f64::max);
        turned.changes[row] / (LITTLE + loss)
    };
    let gains = all.iter().enumerate().filter(|(_, turned)| turned.changes[row] > NO_GAIN);
    gains.max_by(|a, b| merit(a.1).total_cmp(&merit(b.1))).map(|(i, _)| i)
}

fn advice(inputs: &Inputs, base: &Verdict, place: usize, found: Option<&Turned>) -> Advice {
    let Some((turned, verdict)) = found.and_then(|turned| Some((turned, turned.verdict.as_ref()?))) else {
        return Advice { turn: None, words: "no key of the weights moves it the right way".into() };
    };
    let key = turned.knob.name(&inputs.design);
    let (way, by) = if turned.factor > 1.0 { ("raise", "more") } else { ("lower", "less") };
    let after = |row: &Row| verdict.rows.iter().find(|other| other.what == row.what).map(Row::found);
    let moves = |row: &Row| format!("{} -> {}", row.found(), after(row).unwrap_or_default());
    let mut words = format!("{way} {key}: {:.0} % {by}, {}", 100.0 * (TURN - 1.0), moves(&base.rows[place]));
    let others = (0..base.rows.len()).filter(|i| *i != place && turned.changes[*i] < -NO_GAIN);
    if let Some(worst) = others.min_by(|a, b| turned.changes[*a].total_cmp(&turned.changes[*b])) {
        words += &format!("; it costs most in {}, {}", base.rows[worst].what, moves(&base.rows[worst]));
    }
    Advice { turn: Some(Turn { key, factor: turned.factor }), words }
}

/// By how much the room of each row grows in another verdict.
fn changes(base: &Verdict, after: Option<&Verdict>) -> Vec<f64> {
    base.rows.iter().map(|row| after.and_then(|after| change(row, after)).unwrap_or(f64::NAN)).collect()
}

/// By how much the room of a row grows in another verdict; `None` where it is not known.
fn change(row: &Row, after: &Verdict) -> Option<f64> {
    let after = after.rows.iter().find(|other| other.what == row.what)?;
    let base = row.achieved.value;
    // What was not known before is a gain as large as its limit; small figures of which nothing is asked are rounding.
    let gain = if base.is_finite() { room(after, base) - room(row, base) } else { 1.0 + room(after, 1.0) };
    let slight = row.outcome == Outcome::Reported && base.abs() < LITTLE;
    (gain.is_finite() && !slight).then_some(gain)
}
