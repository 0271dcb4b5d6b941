//! What to turn, and which way: each key is turned both ways, and the design made again.
//!
//! Of all keys the one is named that gains most in what is missed for what it loses elsewhere:
//!
//! ```text
//! gain = room(missed row, turned) - room(missed row),   loss = the largest fall of the room of another row
//! best = max gain/(LITTLE + loss)
//! ```

use crate::attempt::{attempt, room};
use crate::error::Error;
use crate::knob::Knob;
use rayon::prelude::*;
use serde::Serialize;
use squid_design::fit::Model;
use squid_design::inputs::Inputs;
use squid_design::progress::Progress;
use squid_design::verdict::Verdict;
use squid_design::verdict::row::{Outcome, Row};
use std::fmt::{self, Display, Formatter};

/// By how much a key is turned.
const TURN: f64 = 1.1;

/// A gain that is none: what the search for gamma leaves open moves figures by as much.
const NO_GAIN: f64 = 1e-3;

/// A loss as small as this is none.
const LITTLE: f64 = 1e-2;

/// What to turn for a row that is missed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Advice {
    /// What is missed, and what is asked of it.
    #[serde(rename = "missed")]
    pub what: String,
    /// What to turn; `None` where no key moves it the right way.
    pub turn: Option<Turn>,
    /// The same for people.
    words: String,
}

/// A key, and by what factor it was turned.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Turn {
    /// The key.
    #[serde(skip)]
    pub knob: Knob,
    /// Its name, with the signal of its table.
    pub key: String,
    /// Above 1: raise it.
    pub factor: f64,
}

impl Display for Advice {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.what, self.words)
    }
}

/// What to turn for each row that a verdict misses.
///
/// # Errors
/// [`Error::Design`]: the design itself does not come out.
pub fn advise(inputs: &Inputs, verdict: &Verdict, progress: &Progress) -> Result<Vec<Advice>, Error> {
    let model = Model::new(&inputs.vehicle, &inputs.design)?;
    let knobs = Knob::all(&inputs.design);
    let turns: Vec<(Knob, f64)> = knobs.iter().flat_map(|k| [(*k, TURN), (*k, 1.0 / TURN)]).collect();
    let running = progress.begin("advise", &format!("designing {} times with a key turned", turns.len()));
    let base = attempt(inputs, &model, &[])?;
    let tried: Vec<((Knob, f64), Verdict)> = turns
        .into_par_iter()
        .filter_map(|turn| Some((turn, attempt(inputs, &model, &[turn]).ok()?)))
        .collect();
    drop(running);
    let missed = verdict.missed().filter_map(|row| base.rows.iter().find(|other| other.what == row.what));
    Ok(missed.map(|row| advice(inputs, row, &base, &tried)).collect())
}

fn advice(inputs: &Inputs, row: &Row, base: &Verdict, tried: &[((Knob, f64), Verdict)]) -> Advice {
    let what = format!("{} {} ({})", row.what, row.found(), row.asked());
    let judged = tried.iter().filter_map(|(turn, verdict)| {
        let (gain, after) = moved(row, verdict)?;
        let others =
            base.rows.iter().filter(|other| other.what != row.what && other.achieved.value.is_finite());
        let losses = others.filter_map(|other| {
            let (gain, after) = moved(other, verdict)?;
            Some((-gain, other, after))
        });
        let worst = losses.max_by(|a, b| a.0.total_cmp(&b.0));
        let loss = worst.as_ref().map_or(0.0, |worst| worst.0.max(0.0));
        (gain > NO_GAIN).then_some((gain / (LITTLE + loss), turn, after, worst))
    });
    let Some((_, (knob, factor), after, worst)) = judged.max_by(|a, b| a.0.total_cmp(&b.0)) else {
        return Advice { what, turn: None, words: "no key moves it the right way".into() };
    };
    let key = knob.name(&inputs.design);
    let way = if *factor > 1.0 { "raise" } else { "lower" };
    let mut words = format!(
        "{way} {key}: {:.0} % {} gives {}",
        100.0 * (TURN - 1.0),
        if *factor > 1.0 { "more" } else { "less" },
        after.found()
    );
    if let Some((_, other, after)) = worst.filter(|worst| worst.0 > NO_GAIN) {
        words += &format!("; it costs most in {}, {} -> {}", other.what, other.found(), after.found());
    }
    Advice { what, turn: Some(Turn { knob: *knob, key, factor: *factor }), words }
}

/// By how much the room of a row grows in another verdict, and the row there; `None` where it is not known.
fn moved<'v>(row: &Row, verdict: &'v Verdict) -> Option<(f64, &'v Row)> {
    let after = verdict.rows.iter().find(|other| other.what == row.what)?;
    let base = row.achieved.value;
    // What was not known before is a gain as large as its limit; small figures of which nothing is asked are rounding.
    let gain = match base.is_finite() {
        true => room(after, base) - room(row, base),
        false => 1.0 + room(after, 1.0),
    };
    let slight = row.outcome == Outcome::Reported && base.abs() < LITTLE;
    (gain.is_finite() && !slight).then_some((gain, after))
}
