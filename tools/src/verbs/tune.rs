//! `squid tune`: searches the weights of a design, and writes them as a design file.

use crate::error::Error;
use crate::output::answer;
use crate::progress::show;
use auv::{Vehicle, read_text};
use serde_json::json;
use squid_design::error::InputError;
use squid_design::inputs::Inputs;
use squid_design::inputs::design_file::DesignFile;
use squid_design::progress::Progress;
use squid_design::store::files::{check_directory, write};
use squid_tune::search::{Budget, Tuned, search};
use squid_tune::start::start;
use squid_tune::tried::Tried;
use std::path::Path;
use std::time::Duration;

/// Rows of the table of the front.
const SHOWN: usize = 12;

/// The least and the most minutes of a search.
const MINUTES: (f64, f64) = (0.05, 600.0);

/// Searches, writes `TO.toml` beside the vehicle, and prints verdict and front.
///
/// # Errors
/// Those of the files and of the search; [`Error::Missed`] where what was found misses a requirement.
pub fn run(vehicle: &Path, design: &str, to: Option<&str>, budget: (f64, usize)) -> Result<(), Error> {
    let (minutes, designs) = budget;
    if !(MINUTES.0..=MINUTES.1).contains(&minutes) {
        let allowed = format!("from {} to {}", auv::number(MINUTES.0), auv::number(MINUTES.1));
        return Err(Error::Argument { name: "--minutes", found: auv::number(minutes), allowed });
    }
    if designs == 0 {
        let allowed = "at least 1".into();
        return Err(Error::Argument { name: "--designs", found: auv::number(0.0), allowed });
    }
    let (inputs, text, begun) = read(vehicle, design)?;
    // A file that people wrote is not overwritten unless they name it.
    let to = vehicle.join(format!("{}.toml", to.unwrap_or(if begun { design } else { "tuned" })));
    check_directory(vehicle)?;
    let progress = Progress::new(&show);
    let budget = Budget { time: Duration::from_secs_f64(60.0 * minutes), designs };
    let tuned = search(&inputs, &text, budget, &progress)?;
    write(&to, tuned.text.as_bytes())?;
    progress.done("verdict", &tuned.finished.verdict.to_string());
    progress.done("front", &front(&tuned));
    let proved = match &tuned.finished.proof {
        Ok(proof) => format!("PROVED: gain below {}", squid_design::certify::claims::bound(&proof.theorem)),
        Err(reason) => format!("NOT PROVED: {reason}"),
    };
    let best = match tuned.finished.verdict.missed().next().is_none() {
        true => format!("the fastest of {} designs that meets all requirements", tuned.tried),
        false => not_found(&tuned),
    };
    progress.done("tuned", &format!("{best}; {proved}\n{}", to.display()));
    let point = |p: &Tried| json!({ "rise": p.rise, "disk_margin": p.disk, "meets_all": p.meets_all() });
    answer(&json!({
        "file": to,
        "tried": tuned.tried,
        "proved": tuned.finished.proof.is_ok(),
        "verdict": tuned.finished.verdict,
        "front": tuned.front.iter().map(point).collect::<Vec<_>>(),
    }))?;
    let missed: Vec<String> = tuned.finished.verdict.missed().map(crate::verbs::design::missed).collect();
    if missed.is_empty() { Ok(()) } else { Err(Error::Missed { missed }) }
}

/// That no design meets all requirements, and what is known of the reason.
fn not_found(tuned: &Tuned) -> String {
    let mut words = format!(
        "none of {} designs meets all requirements, and the one that misses least is written; that is no proof that \
         there is none: search longer with --minutes, or ask for less in [require]",
        tuned.tried
    );
    for limit in &tuned.limits {
        words += &format!("\n{limit}");
    }
    words
}

/// The files; without a design file one that is begun from the vehicle.
fn read(directory: &Path, design: &str) -> Result<(Inputs, String, bool), Error> {
    if !directory.is_dir() {
        return Err(InputError::NoVehicle { directory: directory.display().to_string() }.into());
    }
    let path = directory.join(format!("{design}.toml"));
    if path.exists() {
        return Ok((Inputs::read(directory, design)?, read_text(&path)?, false));
    }
    let file = directory.join("vehicle.toml");
    let vehicle = Vehicle::parse(&read_text(&file)?, &file.display().to_string())?;
    let text = start(&vehicle)?;
    let parsed = DesignFile::parse(&text, &path.display().to_string(), design)?;
    let words = format!(
        "begun from the vehicle: {} to {} m/s, steps of {:.1} deg",
        auv::number(parsed.speed_min),
        auv::number(parsed.speed_max),
        parsed.manoeuvre.pitch_step.to_degrees()
    );
    Progress::new(&show).done("start", &words);
    Ok((Inputs::new(vehicle, parsed)?, text, true))
}

/// The front as a table: what margin costs in speed.
fn front(tuned: &Tuned) -> String {
    let every = tuned.front.len().div_ceil(SHOWN).max(1);
    let of = match tuned.front.iter().any(Tried::meets_all) {
        true => "the designs tried that meet all requirements",
        false => "all designs tried, none of which meets all requirements",
    };
    let mut lines = vec![
        format!("the Pareto front of rise time and disk margin: {of}, evaluated at a few speeds"),
        "rise s   disk margin deg".to_owned(),
    ];
    let rows = tuned.front.iter().step_by(every);
    lines.extend(rows.map(|point| format!("{:>6.2}   {:>15.1}", point.rise, point.disk)));
    lines.join("\n")
}
