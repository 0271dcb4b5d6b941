//! The best of what a search tried, judged in full and proved.

use crate::error::Error;
use crate::knob::Knob;
use crate::tried::{Tried, merit};
use base::progress::Progress;
use squid_design::inputs::Inputs;
use squid_design::inputs::design_file::DesignFile;
use squid_design::run::{Finished, run};
use squid_design::verdict::row::Row;
use toml_edit::DocumentMut;

/// How many of the attempts are judged in full.
const FINALISTS: usize = 4;

/// An attempt that was judged in full.
pub(crate) struct Final {
    /// The logarithms of the factors.
    pub x: Vec<f64>,
    /// Why it is not the one that is chosen; `None` of that one.
    pub fell_out: Option<String>,
}

/// The text of a design file, and its finished design.
type Chosen = (String, Finished);

/// The attempts that were judged in full, and of these the first that meets everything and is proved; if none does, the
/// one that misses least. Where no attempt meets what is required, more speeds will not mend it: the best is enough.
pub(crate) fn finals(
    inputs: &Inputs,
    text: &str,
    knobs: &[Knob],
    mut known: Vec<&Tried>,
    progress: &Progress,
) -> Result<(Vec<Final>, Chosen), Error> {
    known.sort_by(|a, b| merit(a).total_cmp(&merit(b)));
    known.dedup_by(|a, b| a.x == b.x);
    let file = &inputs.design.file;
    let mut judged: Vec<Final> = vec![];
    let mut nearest: Option<(usize, usize, Chosen)> = None;
    let mut failed = None;
    for tried in known.iter().take(FINALISTS) {
        let mut document: DocumentMut = text.parse().map_err(|_| not_toml(file))?;
        for (knob, x) in knobs.iter().zip(&tried.x) {
            knob.write(&mut document, x.exp(), file)?;
        }
        let written = document.to_string();
        let design = DesignFile::parse(&written, file, &inputs.design.name)?;
        let inputs = Inputs::new(inputs.vehicle.clone(), design)?;
        let what = "judging in full, and proving";
        let finished = match progress.timed("tune", what, || run(&inputs, &Progress::default())).0 {
            Ok(finished) => finished,
            Err(reason) => {
                judged
                    .push(Final { x: tried.x.clone(), fell_out: Some(format!("judged in full: {reason}")) });
                failed = Some(reason);
                continue;
            }
        };
        let why = fell_out(&finished);
        let missed = why.len();
        if nearest.as_ref().is_none_or(|(least, ..)| missed < *least) {
            nearest = Some((missed, judged.len(), (written, finished)));
        }
        judged.push(Final {
            x: tried.x.clone(),
            fell_out: Some(format!("judged in full: {}", why.join(", "))),
        });
        if missed == 0 || !tried.meets_all() {
            break;
        }
    }
    match (nearest, failed) {
        (Some((_, place, chosen)), _) => {
            judged[place].fell_out = None;
            Ok((judged, chosen))
        }
        (None, Some(reason)) => Err(reason.into()),
        (None, None) => Err(Error::NoDesign { tried: 0, reason: String::new() }),
    }
}

/// What a finished design misses.
fn fell_out(finished: &Finished) -> Vec<String> {
    let row = |row: &Row| format!("{} is {}, asked {}", row.what, row.found(), row.required());
    let missed = finished.verdict.missed().map(row);
    missed.chain(finished.proof.is_err().then(|| "not proved".to_owned())).collect()
}

fn not_toml(file: &str) -> Error {
    Error::NotATable { file: file.into(), key: "track".into() }
}
