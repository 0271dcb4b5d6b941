//! `squid report`: writes the report on a stored design.

use crate::cli::{Selected, Which, read_sea};
use crate::error::Error;
use crate::output::{answer, say, say_path};
use crate::progress::show;
use crate::verbs::design::load_or_design;
use crate::verbs::simulate::TURN;
use serde_json::json;
use squid_auv::Current;
use squid_base::files::check_directory;
use squid_base::progress::Progress;
use squid_design::inputs::Inputs;
use squid_design::store::{Stored, default_directory};
use squid_report::error::Error as ReportError;
use squid_report::peers::beside::check;
use squid_report::rendered::rendered;
use squid_report::report::{Report, report};
use squid_report::subject::Subject;
use squid_report::turning::{Axes, turns};
use std::path::{Path, PathBuf};

/// Writes the report on a design with all its axes on one page: with the paper's sections and claims if `paper`, with
/// simulations in a sea if a file is given, and with other designs for comparison.
///
/// # Errors
/// Errors of the files, the design and the figures; [`Error::Argument`] for options that require a single axis.
pub fn run(which: &Which, paper: bool, sea: Option<&Path>, beside: &[String]) -> Result<(), Error> {
    let Selected { axes, directory } = which.read_to_write()?;
    let sea = sea.map(|path| read_sea(path, &axes[0].0)).transpose()?;
    let first = &axes[0].0;
    if paper && axes.iter().any(|(inputs, _)| inputs.design.view().is_level_held) {
        let found = first.design.file.clone();
        let allowed = "used with a pitch design, or with --axis, because the paper has no heading".into();
        return Err(Error::Argument { name: "--paper", found, allowed });
    }
    if axes.len() > 1 && !beside.is_empty() {
        let (found, allowed) = ("given".into(), "used with one axis; select it with --axis".into());
        return Err(Error::Argument { name: "--beside", found, allowed });
    }
    let others = others(which, first, &directory, beside)?;
    let stored = load_or_design(&axes)?;
    let beside = load_or_design(&others)?;
    let progress = Progress::new(&show);
    let all: Vec<&Inputs> = axes.iter().map(|(inputs, _)| inputs).collect();
    let make = || {
        let mut reports = vec![];
        for (inputs, stored) in all.iter().zip(&stored) {
            let mut subject = Subject::new(inputs, stored, &progress)?;
            subject.sea.clone_from(&sea);
            for ((inputs, _), stored) in others.iter().zip(&beside) {
                let mut other = Subject::new(inputs, stored, &progress)?;
                other.brief = true;
                subject.beside.push(other);
            }
            let made = if paper { squid_paper::report(&subject) } else { report(&subject) };
            reports.push((inputs.design.steered_signal(), made));
        }
        let designs: Vec<(&Inputs, &Stored)> = all.iter().copied().zip(&stored).collect();
        let turned = Axes::of(&designs).map(|turning| {
            let around = (Current::default(), sea.as_ref().map(|(sea, _)| sea));
            let found =
                progress.timed("turns", "simulating turns", || turns(turning, TURN.to_radians(), around)).0?;
            Ok::<_, ReportError>(found.section(turning))
        });
        let sections = turned.transpose()?.into_iter().collect();
        Report::together(reports, sections).ok_or(ReportError::NoAxis)
    };
    let rest = axes[1..].iter().zip(&stored[1..]).chain(others.iter().zip(&beside));
    let rest: Vec<_> =
        rest.map(|((inputs, _), stored)| (&inputs.design.name, &inputs.hashes, stored)).collect();
    let found = rendered(first, &stored[0], &directory, &(paper, &sea, rest), make, &progress)?;
    say(&format!("\n{}", found.summary));
    let page = found.save(first, &directory)?;
    say_path(&page);
    Ok(answer(&json!({ "report": page, "verdict": found.summary }))?)
}

/// Reads the files of other designs of the vehicle, each with its directory: the default one, or one below `--out`.
///
/// # Errors
/// [`Error::Argument`] for a design that is named twice, errors of the files, or of a design that cannot be compared.
fn others(
    which: &Which,
    inputs: &Inputs,
    directory: &Path,
    beside: &[String],
) -> Result<Vec<(Inputs, PathBuf)>, Error> {
    let mut names = vec![inputs.design.name.clone()];
    let mut found = vec![];
    for name in beside {
        if names.contains(name) {
            let allowed = "the name of another design of the vehicle, without repetition".into();
            return Err(Error::Argument { name: "--beside", found: format!("'{name}'"), allowed });
        }
        names.push(name.clone());
        let other = Inputs::read_axis(&which.vehicle, name, which.axis.as_deref())?;
        check(inputs, &other)?;
        let to = which
            .out
            .as_ref()
            .map_or_else(|| default_directory(&other), |_| directory.join("beside").join(name));
        check_directory(&to)?;
        found.push((other, to));
    }
    Ok(found)
}
