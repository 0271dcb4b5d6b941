//! `squid design`: designs a controller and prints the result.

use crate::cli::{Asked, Design, Which};
use crate::error::Error;
use crate::output::{answer, say};
use crate::progress::{Later, show};
use rayon::prelude::*;
use serde::Serialize;
use serde_json::{Value, json};
use squid_base::files::read;
use squid_base::numbers::percent;
use squid_base::progress::{Event, Progress};
use squid_campaign::flight::Outcome;
use squid_campaign::plan::{Plan, Points};
use squid_design::certify::constant::{CERTIFICATE as CONSTANT_CERTIFICATE, constant};
use squid_design::error::{Error as DesignError, StoreError};
use squid_design::inputs::Inputs;
use squid_design::numbers::above;
use squid_design::run::{Finished, run_with};
use squid_design::store::place::{check_owner, is_source_outdated, outdated};
use squid_design::store::{self, Stored, source_directory};
use squid_design::synthesise::ladder;
use squid_design::synthesise::robust::stored::CERTIFICATE;
use squid_design::verdict::row::Row;
use squid_tune::advise::advise;
use squid_tune::attempt::ControllerKind;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Designs a controller, writes the files of the design, and prints the result.
///
/// # Errors
/// Those of the files and of the stages; [`Error::NotProved`]; [`Error::Missed`] with `strict`.
pub fn run(which: &Which, asked: &Design) -> Result<(), Error> {
    let Asked { axes, directory } = which.read_to_write()?;
    let (mut of_axes, mut stored) = (vec![], vec![]);
    if axes.len() > 1 {
        say(&format!("Axis of {}", axes[0].0.design.steered()));
    }
    let finished =
        side_by_side(&axes, |inputs, directory, progress| designed(inputs, directory, asked, progress));
    for (index, (later, finished)) in finished.into_iter().enumerate() {
        let (inputs, directory) = &axes[index];
        if axes.len() > 1 && index > 0 {
            say(&format!("\nAxis of {}", inputs.design.steered()));
        }
        later.show();
        of_axes.push(finished.and_then(|finished| {
            stored.push((inputs, Stored::of(&finished.frozen, inputs)));
            of_axis((inputs, directory), finished, asked)
        }));
    }
    // After all of them were shown.
    let of_axes = of_axes.into_iter().collect::<Result<Vec<_>, Error>>()?;
    let (figures, missed): (Vec<Value>, Vec<Vec<String>>) = of_axes.into_iter().unzip();
    let mut missed = missed.concat();
    if let [one] = &figures[..] {
        answer(one)?;
    } else {
        say("\nAll axes");
        // The design stands where the flights cannot be flown, as with a coefficient that is uncertain in the vertical
        // plane alone: the reason is said.
        let whole = whole(&stored).map_err(|reason| say(&format!("not flown: {reason}"))).ok();
        missed.extend(whole.iter().filter_map(Whole::missed));
        answer(&json!({ "directory": directory, "axes": figures, "whole": whole }))?;
    }
    if asked.strict && !missed.is_empty() { Err(Error::Missed { missed }) } else { Ok(()) }
}

/// Does something for all axes at once, with progress; that of the others is kept until the first is shown.
fn side_by_side<T: Send>(
    axes: &[(Inputs, PathBuf)],
    each: impl Fn(&Inputs, &Path, &Progress<'_>) -> T + Sync,
) -> Vec<(Later, T)> {
    let one = |(place, (inputs, directory)): (usize, &(Inputs, PathBuf))| {
        let later = Later::default();
        let keep = |event: Event| later.keep(event);
        let progress = if place == 0 { Progress::new(&show) } else { Progress::new(&keep) };
        let done = each(inputs, directory, &progress);
        (later, done)
    };
    axes.par_iter().enumerate().map(one).collect()
}

/// Flights of all axes in six degrees of freedom at random corners of what is uncertain of any of them.
#[derive(Debug, Serialize)]
struct Whole {
    flights: usize,
    /// Those that end at their references.
    flown: usize,
    /// The largest overshoot of each axis, relative to its step; `None` if no flight has one.
    overshoot: BTreeMap<&'static str, Option<f64>>,
}

impl Whole {
    fn missed(&self) -> Option<String> {
        let lost = self.flights - self.flown;
        (lost > 0).then(|| {
            format!("MISSED: {lost} of {} flights of all axes do not end at their references", self.flights)
        })
    }
}

/// The corners that are flown.
const CORNERS: u64 = 24;

/// Flies all axes, and says how the flights end.
fn whole(stored: &[(&Inputs, Stored)]) -> Result<Whole, Error> {
    let progress = Progress::new(&show);
    let designs: Vec<(&Inputs, &Stored)> = stored.iter().map(|(inputs, stored)| (*inputs, stored)).collect();
    let plan = Plan::of_axes(&designs, None, 1, Points::Corners)?;
    let fly = || (0..CORNERS).into_par_iter().map(|flight| plan.row(flight)).collect::<Result<Vec<_>, _>>();
    let rows = progress.timed("whole", "flying all axes in six degrees of freedom", fly).0?;
    let figures = plan.figures();
    let largest = |name: &str| {
        let index = figures.iter().position(|(figure, _)| *figure == format!("{name}_overshoot"))?;
        rows.iter().map(|row| row.figures[index]).filter(|figure| figure.is_finite()).reduce(f64::max)
    };
    let names: Vec<&str> = plan.axes.iter().map(|axis| axis.steered().name).collect();
    let found = Whole {
        flights: rows.len(),
        flown: rows.iter().filter(|row| row.outcome == Outcome::Flown).count(),
        overshoot: names.iter().map(|name| (*name, largest(name))).collect(),
    };
    let of = |name: &&str| {
        let overshoot = found.overshoot.get(name).copied().flatten();
        format!("{} of {name}", overshoot.map_or_else(|| "unknown".to_owned(), |part| percent(part, 2)))
    };
    let words = format!(
        "{} of {} flights end at their references: steps of {} in six degrees of freedom,\nat corners of all that is \
         uncertain; overshoot at most {}",
        found.flown,
        found.flights,
        names.join(" and "),
        names.iter().map(of).collect::<Vec<_>>().join(" and ")
    );
    progress.done("whole", &words);
    Ok(found)
}

/// Shows what else is asked for of the design of an axis; returns the figures that were written, for programs, and the
/// requirements that are missed.
fn of_axis(
    (inputs, directory): (&Inputs, &Path),
    finished: Finished,
    asked: &Design,
) -> Result<(Value, Vec<String>), Error> {
    let progress = Progress::new(&show);
    if let Some(robust_design) = &finished.robust {
        say(&format!(
            "\n{}PROVED in exact arithmetic: {}",
            robust_design.figures.words(),
            directory.join(CERTIFICATE).display()
        ));
    }
    if asked.ladder {
        let climb = || ladder::climb(&inputs.design, &finished.plant, &finished.design);
        let words = progress.timed("ladder", "solving for each assumption about the speed", climb).0?;
        say(&format!("\n{}", words.trim_end()));
    }
    if let Some(rate) = asked.constant {
        let (k, gamma) = (&finished.design.controller, finished.design.certified.gamma);
        let found = constant(inputs, &finished.model, k, gamma, rate, &progress)?;
        found.save(directory)?;
        say(&format!(
            "\nThe gain of the uncertain model is below {} for every constant combination of the declared coefficients \
             within\n\
             {:.1} % of their declared ranges, for any trajectory of speed{},\n\
             and for every error of the model within balls around it. PROVED in exact arithmetic: {}\n\
             That the balls contain the vehicle is a computation at points of the declared ranges, and not proved.",
            above(found.gamma),
            100.0 * found.share,
            no_faster(rate),
            directory.join(CONSTANT_CERTIFICATE).display()
        ));
    }
    let shown = directory.display().to_string();
    finished.proof.map_err(|reason| Error::NotProved { directory: shown, reason })?;
    let mut figures = figures(directory)?;
    if inputs.design.axis.is_some() {
        figures["axis"] = json!(inputs.design.steered());
    }
    Ok((figures, finished.verdict.missed().map(missed).collect()))
}

/// A bound on the rate of the speed, m/s^2, in words.
pub(crate) fn no_faster(rate: Option<f64>) -> String {
    rate.map(|rate| format!(" that changes by at most {rate} m/s^2")).unwrap_or_default()
}

/// The figures that were written, for programs.
fn figures(directory: &Path) -> Result<Value, Error> {
    let written = |name: &str| {
        let path = directory.join(name);
        let text = path.is_file().then(|| read(&path)).transpose()?;
        Ok::<_, Error>(text.and_then(|text| serde_json::from_str::<Value>(&text).ok()))
    };
    Ok(json!({
        "directory": directory,
        "design": written("design.json")?,
        "robust": written("robust.json")?,
        "constant_certificate": directory.join(CONSTANT_CERTIFICATE).is_file().then_some(CONSTANT_CERTIFICATE),
    }))
}

/// A row that is missed, in words.
pub(crate) fn missed(row: &Row) -> String {
    format!("MISSED: {} is {}; 'require.{}' asks for {}", row.what, row.found(), row.key, row.required())
}

/// A new design, written; where it misses something, with what to turn.
fn designed(
    inputs: &Inputs,
    directory: &Path,
    asked: &Design,
    progress: &Progress,
) -> Result<Finished, Error> {
    check_owner(directory, inputs)?;
    let mut finished = run_with(inputs, progress, asked.robust)?;
    let outdated = outdated(directory, inputs, &finished)?;
    let source = source_directory(directory, inputs);
    let is_outdated = is_source_outdated(&source, &finished)?;
    store::save(directory, inputs, &finished)?;
    progress.done("freeze", &format!("{}", directory.display()));
    for path in outdated {
        progress.done("removed", &format!("{}: it was of an earlier design", path.display()));
    }
    if is_outdated {
        let words = format!("{} is of an earlier design; `squid export` writes it again", source.display());
        progress.done("outdated", &words);
    }
    // No weight changes a given controller.
    let given = inputs.design.controller.is_some();
    if finished.verdict.missed().next().is_none() || asked.no_advise || given {
        return Ok(finished);
    }
    let wanted = if asked.robust { ControllerKind::Robust } else { ControllerKind::Nominal };
    match advise(inputs, wanted, &mut finished.verdict, progress) {
        Ok(()) => {
            store::save(directory, inputs, &finished)?;
            progress.done("advice", &finished.verdict.advice());
        }
        Err(reason) => progress.done("advice", &format!("none: {reason}")),
    }
    Ok(finished)
}

/// Returns the stored design of each axis, or a new one if there is none or the files changed since; new ones are made
/// side by side. The caller reports whether they are proved.
///
/// # Errors
/// Those of the files and of the stages. [`StoreError::Stale`] where a new design would not have all of the old one.
pub fn load_or_design(axes: &[(Inputs, PathBuf)]) -> Result<Vec<Stored>, Error> {
    let one = |(later, stored): (Later, Result<Stored, Error>)| {
        later.show();
        stored
    };
    side_by_side(axes, load_or_design_one).into_iter().map(one).collect()
}

fn load_or_design_one(inputs: &Inputs, directory: &Path, progress: &Progress<'_>) -> Result<Stored, Error> {
    match store::load(directory, inputs) {
        Err(DesignError::Store(StoreError::NotDesigned { .. })) => {}
        Err(DesignError::Store(StoreError::Stale { what, .. })) if !has_more(directory) => {
            progress
                .done("again", &format!("{}: {what} changed since this was designed", directory.display()));
        }
        other => return Ok(other?),
    }
    designed(inputs, directory, &Design::default(), progress)?;
    Ok(store::load(directory, inputs)?)
}

/// Whether a directory has more than a design without options writes.
fn has_more(directory: &Path) -> bool {
    ["robust.json", CONSTANT_CERTIFICATE].iter().any(|name| directory.join(name).exists())
}
