//! The best of what a search tried, judged in full and proved.

use crate::error::Error;
use crate::knob::Knob;
use crate::tried::{Tried, merit};
use squid_design::inputs::Inputs;
use squid_design::inputs::design_file::DesignFile;
use squid_design::progress::Progress;
use squid_design::run::{Finished, run};
use toml_edit::DocumentMut;

/// How many of the attempts are judged in full.
const FINALISTS: usize = 4;

/// The first of the best attempts that meets everything when judged in full and proved; if none does, the one that
/// misses least. Where no attempt meets what is required, more speeds will not mend it: the best is enough.
pub(crate) fn best(
    inputs: &Inputs,
    text: &str,
    knobs: &[Knob],
    mut known: Vec<&Tried>,
    progress: &Progress,
) -> Result<(String, Finished), Error> {
    known.sort_by(|a, b| merit(a).total_cmp(&merit(b)));
    let file = &inputs.design.file;
    let mut nearest: Option<(usize, String, Finished)> = None;
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
                failed = Some(reason);
                continue;
            }
        };
        let missed = finished.verdict.missed().count() + usize::from(finished.proof.is_err());
        if nearest.as_ref().is_none_or(|(least, ..)| missed < *least) {
            nearest = Some((missed, written, finished));
        }
        if missed == 0 || !tried.meets_all() {
            break;
        }
    }
    match (nearest, failed) {
        (Some((_, text, finished)), _) => Ok((text, finished)),
        (None, Some(reason)) => Err(reason.into()),
        (None, None) => Err(Error::NoDesign { tried: 0, reason: String::new() }),
    }
}

fn not_toml(file: &str) -> Error {
    Error::NotATable { file: file.into(), key: "track".into() }
}
