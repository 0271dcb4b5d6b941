//! Full evaluation and proof of the best candidates of a search.

use crate::candidate::{Candidate, merit};
use crate::error::Error;
use crate::knob::Knob;
use squid_base::progress::Progress;
use squid_design::inputs::Inputs;
use squid_design::run::{Finished, run};
use squid_design::verdict::row::Row;
use toml_edit::DocumentMut;

/// Number of candidates that are fully evaluated.
const FINALISTS: usize = 4;

/// Candidate that was fully evaluated.
pub(crate) struct Finalist {
    /// Logarithms of the factors.
    pub x: Vec<f64>,
    /// Reason of the rejection; `None` for the chosen candidate.
    pub rejected: Option<String>,
}

/// Text of a design file, and its finished design.
type Chosen = (String, Finished);

/// Evaluates the best candidates fully. Returns them, and the first that meets all requirements and is proved, or else
/// the one that misses the fewest. If no candidate meets the requirements, only the best is fully evaluated: more
/// speeds cannot improve it.
pub(crate) fn finals(
    inputs: &Inputs,
    text: &str,
    knobs: &[Knob],
    mut known: Vec<&Candidate>,
    progress: &Progress,
) -> Result<(Vec<Finalist>, Chosen), Error> {
    known.sort_by(|a, b| merit(a).total_cmp(&merit(b)));
    known.dedup_by(|a, b| a.x == b.x);
    let file = &inputs.design.file;
    let mut judged: Vec<Finalist> = vec![];
    let mut nearest: Option<(usize, usize, Chosen)> = None;
    let mut failed = None;
    for tried in known.iter().take(FINALISTS) {
        let mut document: DocumentMut =
            text.parse().map_err(|_| Error::NotATable { file: file.clone(), key: "track".into() })?;
        for (knob, x) in knobs.iter().zip(&tried.x) {
            knob.write(&mut document, x.exp(), &inputs.design)?;
        }
        let written = document.to_string();
        let design = inputs.design.parse_again(&written)?;
        let inputs = inputs.redesigned(design)?;
        let what = "evaluating in full, and proving";
        let finished = match progress.timed("tune", what, || run(&inputs, &Progress::default())).0 {
            Ok(finished) => finished,
            Err(reason) => {
                judged.push(Finalist {
                    x: tried.x.clone(),
                    rejected: Some(format!("evaluated in full: {reason}")),
                });
                failed = Some(reason);
                continue;
            }
        };
        let why = misses(&finished);
        let missed = why.len();
        if nearest.as_ref().is_none_or(|(least, ..)| missed < *least) {
            nearest = Some((missed, judged.len(), (written, finished)));
        }
        judged.push(Finalist {
            x: tried.x.clone(),
            rejected: Some(format!("evaluated in full: {}", why.join(", "))),
        });
        if missed == 0 || !tried.meets_all() {
            break;
        }
    }
    match (nearest, failed) {
        (Some((_, index, chosen)), _) => {
            judged[index].rejected = None;
            Ok((judged, chosen))
        }
        (None, Some(reason)) => Err(reason.into()),
        (None, None) => Err(Error::NoDesign { tried: 0, reason: String::new() }),
    }
}

/// Returns the requirements that a finished design misses.
fn misses(finished: &Finished) -> Vec<String> {
    let row = |row: &Row| format!("{} is {}, required {}", row.name, row.found(), row.required());
    let missed = finished.verdict.missed().map(row);
    missed.chain(finished.proof.is_err().then(|| "not proved".to_owned())).collect()
}
