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
use squid_tune::search::{Tried, Tuned, search};
use squid_tune::start::start;
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
pub fn run(vehicle: &Path, design: &str, to: Option<&str>, minutes: f64) -> Result<(), Error> {
    if !(MINUTES.0..=MINUTES.1).contains(&minutes) {
        let allowed = format!("from {} to {}", auv::number(MINUTES.0), auv::number(MINUTES.1));
        return Err(Error::Argument { name: "--minutes", found: auv::number(minutes), allowed });
    }
    let (inputs, text, begun) = read(vehicle, design)?;
    // A file that people wrote is not overwritten unless they name it.
    let to = vehicle.join(format!("{}.toml", to.unwrap_or(if begun { design } else { "tuned" })));
    check_directory(vehicle)?;
    let progress = Progress::new(&show);
    let tuned = search(&inputs, &text, Duration::from_secs_f64(60.0 * minutes), &progress)?;
    write(&to, tuned.text.as_bytes())?;
    progress.done("verdict", &tuned.finished.verdict.to_string());
    progress.done("front", &front(&tuned));
    let proved = match &tuned.finished.proof {
        Ok(proof) => format!("PROVED: gain below {}", squid_design::numbers::above(proof.theorem.gamma)),
        Err(reason) => format!("NOT PROVED: {reason}"),
    };
    progress.done("tuned", &format!("the best of {} designs; {proved}\n{}", tuned.tried, to.display()));
    let point = |p: &Tried| json!({ "rise": p.rise, "disk_margin": p.disk, "meets_all": p.worst() >= 0.0 });
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
        "begun from the vehicle: {:.1} to {:.1} m/s, steps of {:.1} deg",
        parsed.speed_min,
        parsed.speed_max,
        parsed.manoeuvre.pitch_step.to_degrees()
    );
    Progress::new(&show).done("start", &words);
    Ok((Inputs::new(vehicle, parsed)?, text, true))
}

/// The front as a table: what margin costs in speed.
fn front(tuned: &Tuned) -> String {
    let every = tuned.front.len().div_ceil(SHOWN).max(1);
    let mut lines = vec![
        "what speed costs in margin, of all designs tried those that none beats in both".to_owned(),
        "rise s   disk margin deg".to_owned(),
    ];
    lines.extend(tuned.front.iter().step_by(every).map(|point| {
        let met = if point.worst() >= 0.0 { "meets all" } else { "misses some" };
        format!("{:>6.2}   {:>15.1}   {met}", point.rise, point.disk)
    }));
    lines.join("\n")
}
