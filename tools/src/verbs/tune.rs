//! `squid tune`: searches the weights of a design, and writes them as a design file.

use crate::cli::{Track, read_vehicle};
use crate::error::Error;
use crate::output::{answer, answer_each, say};
use crate::progress::show;
use serde_json::{Value, json};
use squid_base::files::{self, check_directory, write};
use squid_base::progress::Progress;
use squid_design::error::InputError;
use squid_design::inputs::Inputs;
use squid_design::run::Finished;
use squid_design::store::Stored;
use squid_report::peers::against_pid;
use squid_report::subject::Subject;
use squid_scheduled::DEFAULT_DESIGN;
use squid_tune::candidate::Candidate;
use squid_tune::gain::TunedGain;
use squid_tune::pid::tune_pid;
use squid_tune::search::{CandidateStatus, Tuned, search};
use squid_tune::start::{Beside, start, start_heading, start_whole};
use std::path::Path;

/// Number of rows in the table of the front.
const SHOWN: usize = 12;

/// Searches, writes `TO.toml` to the vehicle's directory, and prints verdict and front.
///
/// # Errors
/// Errors of the files and of the search; [`Error::Missed`] if the result misses a requirement.
pub fn run(
    (vehicle, design, axis): (&Path, &str, Option<&str>),
    created_for: Option<Track>,
    to: Option<&str>,
    designs: usize,
) -> Result<(), Error> {
    if designs == 0 {
        let allowed = "at least 1".into();
        return Err(Error::Argument { name: "--designs", found: squid_auv::number(0.0), allowed });
    }
    let (axes, text, created) = read(vehicle, (design, axis), created_for)?;
    if let Some(given) = axes.iter().find(|inputs| inputs.design.controller.is_some()) {
        let (file, what) = (given.design.file.clone(), "no weights to search");
        return Err(InputError::GivenController { file, what }.into());
    }
    let name = output_name(to, design, created);
    let written = vehicle.join(format!("{name}.toml"));
    check_directory(vehicle)?;
    let progress = Progress::new(&show);
    axes.iter().flat_map(Inputs::findings).for_each(|found| progress.warn(&found));
    let (mut text, mut figures, mut missed) = (text, vec![], vec![]);
    for inputs in &axes {
        if axes.len() > 1 {
            say(&format!("\nAxis of {}", inputs.design.steered_signal()));
        }
        let tuned = search(inputs, &text, designs, &progress)?;
        write(&written, tuned.text.as_bytes())?;
        let to = (vehicle, name, written.as_path(), created);
        figures.push(report_axis(inputs, &tuned, to, &progress)?);
        missed.extend(tuned.finished.verdict.missed().map(crate::verbs::design::missed));
        text = tuned.text;
    }
    answer_each(&figures)?;
    if missed.is_empty() { Ok(()) } else { Err(Error::Missed { missed }) }
}

/// Prints the result for an axis, and returns it for JSON.
fn report_axis(
    inputs: &Inputs,
    tuned: &Tuned,
    (vehicle, name, to, created): (&Path, &str, &Path, bool),
    progress: &Progress,
) -> Result<Value, Error> {
    progress.done("verdict", &tuned.finished.verdict.to_string());
    progress.done("front", &front(tuned));
    let proved = match &tuned.finished.proof {
        Ok(proof) => format!("PROVED: gain below {}", squid_design::certify::claims::bound(&proof.theorem)),
        Err(reason) => format!("NOT PROVED: {reason}"),
    };
    let best = if tuned.finished.verdict.missed().next().is_none() {
        format!(
            "the best of {} designs that meets all requirements in the full evaluation and is proved",
            tuned.tried
        )
    } else {
        no_design_found(tuned)
    };
    let comparison = comparison(inputs, &tuned.text, &tuned.finished, progress)?;
    let search_end = search_end(tuned, vehicle, name);
    let next_report = next_report(inputs, vehicle, name, created);
    progress.done(
        "tuned",
        &format!("{best}; {proved}\n{comparison}\n{search_end}\n{}\n{next_report}", to.display()),
    );
    let point = |(p, status): &(Candidate, CandidateStatus)| {
        let (rise, disk_margin, meets_all) = (p.rise, p.disk, p.meets_all());
        json!({ "rise": rise, "disk_margin": disk_margin, "meets_all": meets_all, "remark": remark(status) })
    };
    let mut found = json!({
        "file": to,
        "tried": tuned.tried,
        "ended": tuned.ended,
        "proved": tuned.finished.proof.is_ok(),
        "verdict": tuned.finished.verdict,
        "against_pid": comparison,
        "front": tuned.front.iter().map(point).collect::<Vec<_>>(),
    });
    if inputs.design.axis.is_some() {
        found["axis"] = json!(inputs.design.steered_signal());
    }
    Ok(found)
}

/// Returns the name of the design to write: an existing file is not overwritten unless `to` names it.
fn output_name<'a>(to: Option<&'a str>, design: &'a str, created: bool) -> &'a str {
    to.unwrap_or(if created { design } else { "tuned" })
}

/// Returns the next report to read: that of the initial design, compared with the new one; or that of the new one alone
/// if it replaced the initial design, or if there was none.
fn next_report(from: &Inputs, vehicle: &Path, name: &str, created: bool) -> String {
    let design = from.design.autopilot.as_str();
    let alone = created || name == design;
    let own = if alone { name } else { design };
    let design = if own == DEFAULT_DESIGN { String::new() } else { format!(" --design {own}") };
    let beside = if alone { String::new() } else { format!(" --beside {name}") };
    // A comparison is between designs of one axis.
    let axis = from.design.axis.filter(|_| !alone);
    let axis = axis.map(|_| format!(" --axis {}", from.design.steered_signal())).unwrap_or_default();
    format!("next: squid report {}{design}{axis}{beside}", vehicle.display())
}

/// Tunes the gains of a PID, writes `TO.toml` to the vehicle's directory, and prints gains, proof and verdict.
///
/// # Errors
/// Errors of the files and of the search; [`Error::Unproved`]; [`Error::Missed`] if the PID misses a requirement.
pub fn pid(
    (vehicle, design, axis): (&Path, &str, Option<&str>),
    to: Option<&str>,
    degree: usize,
) -> Result<(), Error> {
    let (axes, text, created) = read(vehicle, (design, axis), Some(Track::Pitch))?;
    let [inputs] = &axes[..] else {
        let steered: Vec<&str> = axes.iter().map(|one| one.design.steered_signal()).collect();
        let (file, axes) = (axes[0].design.file.clone(), steered.join(", "));
        return Err(InputError::SeveralAxes { file, axes }.into());
    };
    let name = output_name(to, design, created);
    let to = vehicle.join(format!("{name}.toml"));
    check_directory(vehicle)?;
    let progress = Progress::new(&show);
    let tuned = tune_pid(inputs, &text, degree, &progress)?;
    write(&to, tuned.text.as_bytes())?;
    let numbers = |gain: &TunedGain| {
        let all: Vec<String> = gain.coefficients.iter().map(|v| squid_auv::rounded(*v)).collect();
        let all = if all.len() > 1 { format!("[{}]", all.join(", ")) } else { all.concat() };
        let unit = if gain.unit == "1" { "" } else { &gain.unit };
        format!("{} = {all} {unit}", gain.name).trim_end().to_owned()
    };
    progress.done("gains", &tuned.gains.iter().map(numbers).collect::<Vec<_>>().join("\n"));
    progress.done("verdict", &tuned.finished.verdict.to_string());
    let proof = tuned.finished.proof.as_ref();
    let text = proof.map_or_else(
        |reason| format!("NOT PROVED: {reason}"),
        |proof| format!("PROVED: gain below {}", squid_design::certify::claims::bound(&proof.theorem)),
    );
    let comparison = comparison(inputs, &tuned.text, &tuned.finished, &progress)?;
    let next_report = next_report(inputs, vehicle, name, created);
    let lines = [text, comparison.clone(), to.display().to_string(), next_report];
    progress.done("tuned", &lines.join("\n"));
    let gain =
        |gain: &TunedGain| json!({ "name": gain.name, "unit": gain.unit, "coefficients": gain.coefficients });
    answer(&json!({
        "file": to,
        "gains": tuned.gains.iter().map(gain).collect::<Vec<_>>(),
        "frozen_gain": tuned.frozen_gain,
        "least_gain": tuned.least_gain,
        "gain": proof.ok().map(|proof| proof.theorem.gamma),
        "seconds": tuned.seconds,
        "against_pid": comparison,
        "verdict": tuned.finished.verdict,
    }))?;
    if let Err(reason) = &tuned.finished.proof {
        return Err(Error::Unproved { reason: reason.clone() });
    }
    missed(&tuned.finished)
}

/// Returns a comparison of the design with the PID that a practitioner would use instead.
fn comparison(
    inputs: &Inputs,
    text: &str,
    finished: &Finished,
    progress: &Progress,
) -> Result<String, Error> {
    let design = inputs.design.parse_again(text)?;
    let inputs = inputs.redesigned(design)?;
    let (stored, quiet) = (Stored::of(&finished.frozen, &inputs), Progress::default());
    let subject = Subject::new(&inputs, &stored, &quiet)?;
    let what = "the simulations of the report, compared with a PID tuned in simulation";
    Ok(progress.timed("compare", what, || against_pid(&subject)).0?)
}

/// Returns an error with the requirements that a design misses, if any.
fn missed(finished: &Finished) -> Result<(), Error> {
    let missed: Vec<String> = finished.verdict.missed().map(crate::verbs::design::missed).collect();
    if missed.is_empty() { Ok(()) } else { Err(Error::Missed { missed }) }
}

/// Returns a text that no design meets all requirements, with the known reasons.
fn no_design_found(tuned: &Tuned) -> String {
    let mut text = format!(
        "none of {} designs meets all requirements; the one that misses least is written (this does not prove that \
         none exists); relax [require]",
        tuned.tried
    );
    for limit in &tuned.limits {
        text += &format!("\n{limit}");
    }
    text
}

/// Reads the files of each axis, or creates a design file from the vehicle if there is none.
fn read(
    directory: &Path,
    (design, axis): (&str, Option<&str>),
    track: Option<Track>,
) -> Result<(Vec<Inputs>, String, bool), Error> {
    if !directory.is_dir() {
        return Err(InputError::NoVehicle { directory: directory.display().to_string() }.into());
    }
    let path = directory.join(format!("{design}.toml"));
    if path.exists() {
        let axes = match axis {
            Some(_) => vec![Inputs::read_axis(directory, design, axis)?],
            None => Inputs::read_axes(directory, design)?,
        };
        if track == Some(Track::Heading) && !axes.iter().any(|inputs| inputs.design.view().is_level_held) {
            let found = format!("heading, but {} tracks another quantity", path.display());
            return Err(Error::Argument {
                name: "--track",
                found,
                allowed: "the quantity that the file tracks".into(),
            });
        }
        return Ok((axes, files::read(&path)?, false));
    }
    let file = directory.join("vehicle.toml");
    let vehicle = read_vehicle(&file)?;
    let files = [&file, &path].map(|file| file.display().to_string());
    let named = files.each_ref().map(String::as_str);
    let progress = Progress::new(&show);
    let text = match track {
        Some(Track::Pitch) => start(&vehicle)?,
        Some(Track::Heading) => start_heading(&vehicle, named, level_settings(directory)?)?,
        None => {
            let (text, left_out) = start_whole(&vehicle, named)?;
            if let Some(reason) = left_out {
                progress.done("start", &format!("no heading axis: {reason}"));
            }
            text
        }
    };
    let axes = Inputs::parse_axes(&vehicle, &text, named, design)?;
    for Inputs { design, .. } in &axes {
        let step = design.manoeuvre.step(design.steered_signal()).to_degrees();
        let text = format!(
            "created from the vehicle: {}, {} to {} m/s, steps of {step:.1} deg",
            design.steered_signal(),
            squid_auv::number(design.speed_min),
            squid_auv::number(design.speed_max),
        );
        progress.done("start", &text);
    }
    Ok((axes, text, true))
}

/// Returns the settings that a heading design shares with the design of level flight, if there is one.
fn level_settings(directory: &Path) -> Result<Option<Beside>, Error> {
    if !directory.join(format!("{DEFAULT_DESIGN}.toml")).exists() {
        return Ok(None);
    }
    let design = Inputs::read_axes(directory, DEFAULT_DESIGN)?.remove(0).design;
    Ok(Some(Beside {
        speeds: [design.speed_min, design.speed_max],
        depth: design.depth,
        sample_time: design.sample_time,
    }))
}

/// Returns the Pareto front as a table: rise time against margin.
fn front(tuned: &Tuned) -> String {
    let stride = tuned.front.len().div_ceil(SHOWN).max(1);
    let of = if tuned.front.iter().any(|(tried, _)| tried.meets_all()) {
        "all evaluated designs that meet the requirements"
    } else {
        "all evaluated designs, none of which meets the requirements"
    };
    let mut lines = vec![
        format!("Pareto front of rise time and disk margin: {of}, at a few speeds"),
        "rise s   disk margin deg".to_owned(),
    ];
    // The written design, and the faster ones, are always shown.
    let written = tuned.front.iter().position(|(_, status)| *status == CandidateStatus::Written);
    let is_shown = |i: usize| i.is_multiple_of(stride) || written.is_some_and(|written| i <= written);
    let rows = tuned.front.iter().enumerate().filter(|(i, _)| is_shown(*i)).map(|(_, row)| row);
    lines.extend(rows.map(|(point, status)| {
        format!("{:>6.2}   {:>15.1}   {}", point.rise, point.disk, remark(status)).trim_end().to_owned()
    }));
    lines.join("\n")
}

/// Returns the status of a design of the front.
fn remark(status: &CandidateStatus) -> String {
    match status {
        CandidateStatus::Written => "written".into(),
        CandidateStatus::Rejected(why) => why.clone(),
        CandidateStatus::InsufficientMargin(key, room) => {
            format!("not evaluated in full: {key} has a margin of {room} %, too small for further speeds")
        }
        CandidateStatus::NotEvaluated => String::new(),
    }
}

/// Returns why the search ended, and how to continue.
fn search_end(tuned: &Tuned, vehicle: &Path, name: &str) -> String {
    let on = format!("squid tune {} --design {name} --to {name}", vehicle.display());
    if tuned.ended {
        format!(
            "the search converged after {} designs: the last round improved the best by less than 1 %; to continue \
             from the written design: {on}",
            tuned.tried
        )
    } else {
        format!(
            "the search stopped at the limit of --designs, {} designs; to continue from the written design: {on}",
            tuned.tried
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A design that was created or replaced has no other for comparison.
    #[test]
    fn suggests_a_report_that_can_be_made() {
        let vehicles = Path::new(env!("CARGO_MANIFEST_DIR")).join("../vehicles");
        let reports = [
            ("remus100", "pitch", "tuned", false),
            ("squid", "proved", "pid", false),
            ("squid", "design", "design", false),
            ("remus100", "pitch", "mine", true),
            ("remus100", "design", "tuned", false),
        ]
        .map(|(vehicle, from, name, created)| {
            let axis = (from, vehicle) == ("design", "remus100");
            let from = Inputs::read_axis(&vehicles.join(vehicle), from, axis.then_some("depth")).unwrap();
            next_report(&from, Path::new("v"), name, created)
        });
        insta::assert_snapshot!(reports.join("\n"));
    }
}
