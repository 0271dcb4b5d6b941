//! `squid design`: designs a controller and prints the result.

use crate::cli::{Design, Selected, Which};
use crate::error::Error;
use crate::output::{answer, say};
use crate::progress::show;
use rayon::prelude::*;
use serde::Serialize;
use serde_json::{Map, Value, json};
use squid_base::files::read;
use squid_base::numbers::above;
use squid_base::numbers::percent;
use squid_base::progress::{Progress, Results};
use squid_campaign::flight::Outcome;
use squid_campaign::plan::{Plan, Points};
use squid_design::certify::constant::{CERTIFICATE as CONSTANT_CERTIFICATE, constant};
use squid_design::error::{Error as DesignError, StoreError};
use squid_design::inputs::Inputs;
use squid_design::run::{Finished, run_with};
use squid_design::store::owner::{check_owner, is_source_outdated, outdated};
use squid_design::store::{self, Stored, source_directory};
use squid_design::synthesise::ladder;
use squid_design::synthesise::robust::stored::CERTIFICATE;
use squid_design::verdict::row::Row;
use squid_finding::Finding;
use squid_tune::advise::advise;
use squid_tune::attempt::ControllerKind;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Designs a controller, writes the files of the design, and prints the result.
///
/// # Errors
/// Errors of the files and of the stages; [`Error::NotProved`]; [`Error::Missed`] with `strict`.
pub fn run(which: &Which, options: &Design) -> Result<(), Error> {
    let Selected { axes, directory } = which.read_to_write()?;
    let (mut results, mut stored) = (vec![], vec![]);
    if axes.len() > 1 {
        say(&format!("Axis of {}", axes[0].0.design.steered_signal()));
    }
    let finished =
        side_by_side(&axes, |inputs, directory, progress| design_axis(inputs, directory, options, progress));
    for (index, (reported, finished)) in finished.into_iter().enumerate() {
        let (inputs, directory) = &axes[index];
        if axes.len() > 1 && index > 0 {
            say(&format!("\nAxis of {}", inputs.design.steered_signal()));
        }
        reported.report(&Progress::new(&show));
        results.push(finished.and_then(|finished| {
            stored.push((inputs, Stored::of(&finished.frozen, inputs)));
            report_axis((inputs, directory), finished, options)
        }));
    }
    // Errors are returned only after all axes have been shown.
    let results = results.into_iter().collect::<Result<Vec<_>, Error>>()?;
    let (figures, missed): (Vec<Value>, Vec<Vec<String>>) = results.into_iter().unzip();
    let mut missed = missed.concat();
    if let [one] = &figures[..] {
        answer(one)?;
    } else {
        say("\nAll axes");
        // The design is valid even if all axes cannot be simulated together, as with a coefficient that is uncertain in
        // the vertical plane only; the reason is printed.
        let whole = fly_all_axes(&stored).map_err(|reason| say(&format!("not simulated: {reason}"))).ok();
        missed.extend(whole.iter().filter_map(SixDofFlights::missed));
        answer(&json!({ "directory": directory, "axes": figures, "whole": whole }))?;
    }
    if options.strict && !missed.is_empty() { Err(Error::Missed { missed }) } else { Ok(()) }
}

/// Runs a function for all axes in parallel, with progress; that of later axes is stored until it can be shown.
fn side_by_side<T: Send>(
    axes: &[(Inputs, PathBuf)],
    each: impl Fn(&Inputs, &Path, &Progress<'_>) -> T + Sync,
) -> Vec<(Results, T)> {
    let one = |(index, (inputs, directory)): (usize, &(Inputs, PathBuf))| match index {
        0 => (Results::default(), each(inputs, directory, &Progress::new(&show))),
        _ => {
            let (done, results) = Results::collect(|progress| each(inputs, directory, progress));
            (results, done)
        }
    };
    axes.par_iter().enumerate().map(one).collect()
}

/// Simulations of all axes in six degrees of freedom at random corners of the combined uncertainty.
#[derive(Debug, Serialize)]
struct SixDofFlights {
    flights: usize,
    /// Number of flights that end at their references.
    flown: usize,
    /// Largest overshoot of each axis, relative to its step; `None` if unknown for all flights.
    overshoot: BTreeMap<&'static str, Option<f64>>,
}

impl SixDofFlights {
    fn missed(&self) -> Option<String> {
        let lost = self.flights - self.flown;
        (lost > 0).then(|| {
            format!(
                "MISSED: {lost} of {} simulations of all axes do not end at their references",
                self.flights
            )
        })
    }
}

/// Number of simulated corners.
const CORNERS: u64 = 24;

/// Simulates all axes together, and reports how the flights end.
fn fly_all_axes(stored: &[(&Inputs, Stored)]) -> Result<SixDofFlights, Error> {
    let progress = Progress::new(&show);
    let designs: Vec<(&Inputs, &Stored)> = stored.iter().map(|(inputs, stored)| (*inputs, stored)).collect();
    let plan = Plan::of_axes(&designs, None, 1, Points::Corners)?;
    let fly = || (0..CORNERS).into_par_iter().map(|flight| plan.row(flight)).collect::<Result<Vec<_>, _>>();
    let rows = progress.timed("whole", "simulating all axes in six degrees of freedom", fly).0?;
    let figures = plan.figures();
    let largest = |name: &str| {
        let index = figures.iter().position(|(figure, _)| *figure == format!("{name}_overshoot"))?;
        rows.iter().map(|row| row.figures[index]).filter(|figure| figure.is_finite()).reduce(f64::max)
    };
    let names: Vec<&str> = plan.axes.iter().map(|axis| axis.steered_signal().name).collect();
    let found = SixDofFlights {
        flights: rows.len(),
        flown: rows.iter().filter(|row| row.outcome == Outcome::Flown).count(),
        overshoot: names.iter().map(|name| (*name, largest(name))).collect(),
    };
    let of = |name: &&str| {
        let overshoot = found.overshoot.get(name).copied().flatten();
        format!("{} of {name}", overshoot.map_or_else(|| "unknown".to_owned(), |part| percent(part, 2)))
    };
    let summary = format!(
        "{} of {} simulations end at their references: steps of {} in six degrees of freedom,\nat corners of the \
         declared uncertainty; overshoot at most {}",
        found.flown,
        found.flights,
        names.join(" and "),
        names.iter().map(of).collect::<Vec<_>>().join(" and ")
    );
    progress.done("whole", &summary);
    Ok(found)
}

/// Prints the further results requested for an axis; returns the written figures for JSON, and the missed requirements.
fn report_axis(
    (inputs, directory): (&Inputs, &Path),
    finished: Finished,
    options: &Design,
) -> Result<(Value, Vec<String>), Error> {
    let progress = Progress::new(&show);
    if let Some(robust_design) = &finished.robust {
        say(&format!(
            "\n{}PROVED in exact arithmetic: {}",
            robust_design.figures.text(),
            directory.join(CERTIFICATE).display()
        ));
    }
    if options.ladder {
        let climb = || ladder::climb(&inputs.design, &finished.plant, &finished.design);
        let summary = progress.timed("ladder", "solving for each assumption about the speed", climb).0?;
        say(&format!("\n{}", summary.trim_end()));
    }
    if let Some(rate) = options.constant {
        let (k, gamma) = (&finished.design.controller, finished.design.certified.gamma);
        let found = constant(inputs, &finished.model, k, gamma, rate, &progress)?;
        found.save(directory)?;
        say(&format!(
            "\n\
             The gain of the uncertain model is below {} for all constant values of the declared coefficients \
             within\n\
             {:.1} % of their declared ranges, for any trajectory of speed{},\n\
             and for every model error within balls around it. PROVED in exact arithmetic: {}\n\
             Not proved: that the balls contain the vehicle (computed at points of the declared ranges).",
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
        figures["axis"] = json!(inputs.design.steered_signal());
    }
    Ok((figures, finished.verdict.missed().map(missed).collect()))
}

/// Returns a bound on the rate of the speed, m/s^2, as text.
pub(crate) fn no_faster(rate: Option<f64>) -> String {
    rate.map(|rate| format!(" that changes by at most {rate} m/s^2")).unwrap_or_default()
}

/// Returns for JSON whether a stored design is proved, and if not, why.
pub(crate) fn proved(unproved: Option<&Finding>) -> Map<String, Value> {
    let why = unproved.map(|found| found.why.strip_prefix("NOT PROVED: ").unwrap_or(&found.why));
    let reason = why.map(|why| ("not_proved_because".to_owned(), json!(why)));
    [("proved".to_owned(), json!(unproved.is_none()))].into_iter().chain(reason).collect()
}

/// Returns the written figures for JSON.
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

/// Returns a missed requirement as text.
pub(crate) fn missed(row: &Row) -> String {
    format!("MISSED: {} is {}; 'require.{}' is {}", row.name, row.found(), row.key, row.required())
}

/// Designs a controller and writes it; if it misses a requirement, searches for the key to change.
fn design_axis(
    inputs: &Inputs,
    directory: &Path,
    options: &Design,
    progress: &Progress,
) -> Result<Finished, Error> {
    check_owner(directory, inputs)?;
    let mut finished = run_with(inputs, progress, options.robust)?;
    let outdated = outdated(directory, inputs, &finished)?;
    let source = source_directory(directory, inputs);
    let is_outdated = is_source_outdated(&source, &finished)?;
    store::save(directory, inputs, &finished)?;
    progress.done("freeze", &format!("{}", directory.display()));
    for path in outdated {
        progress.done("removed", &format!("{}, which belonged to an earlier design", path.display()));
    }
    if is_outdated {
        let summary = format!("{} belongs to an earlier design; run `squid export` again", source.display());
        progress.done("outdated", &summary);
    }
    // Weights do not affect a given controller.
    let given = inputs.design.controller.is_some();
    if finished.verdict.missed().next().is_none() || options.no_advise || given {
        return Ok(finished);
    }
    let kind = if options.robust { ControllerKind::Robust } else { ControllerKind::Nominal };
    match advise(inputs, kind, &mut finished.verdict, progress) {
        Ok(()) => {
            store::save(directory, inputs, &finished)?;
            progress.done("advice", &finished.verdict.advice());
        }
        Err(reason) => progress.done("advice", &format!("none: {reason}")),
    }
    Ok(finished)
}

/// Returns the stored design of each axis, or a new one if there is none or the files changed since; new ones are
/// designed in parallel. The caller reports whether they are proved.
///
/// # Errors
/// Errors of the files and of the stages; [`StoreError::Stale`] if a new design would lack results of the old one.
pub fn load_or_design(axes: &[(Inputs, PathBuf)]) -> Result<Vec<Stored>, Error> {
    let one = |(results, stored): (Results, Result<Stored, Error>)| {
        results.report(&Progress::new(&show));
        stored
    };
    side_by_side(axes, load_or_design_one).into_iter().map(one).collect()
}

fn load_or_design_one(inputs: &Inputs, directory: &Path, progress: &Progress<'_>) -> Result<Stored, Error> {
    match store::load(directory, inputs) {
        Err(DesignError::Store(StoreError::NotDesigned { .. })) => {}
        Err(DesignError::Store(StoreError::Stale { what, .. })) if !has_more(directory) => {
            progress.done("again", &format!("{}: {what} changed after this design", directory.display()));
        }
        other => return Ok(other?),
    }
    design_axis(inputs, directory, &Design::default(), progress)?;
    Ok(store::load(directory, inputs)?)
}

/// Returns `true` if a directory has results of a design with options.
fn has_more(directory: &Path) -> bool {
    ["robust.json", CONSTANT_CERTIFICATE].iter().any(|name| directory.join(name).exists())
}
