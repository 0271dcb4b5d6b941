//! `squid simulate`: flights in this process.

use crate::cli::{Which, read_sea};
use crate::error::Error;
use crate::output::{answer, say};
use crate::progress::show;
use crate::verbs::design::load_or_design;
use auv::Current;
use base::files::check_directory;
use base::progress::Progress;
use serde_json::{Value, json};
use squid_design::inputs::Inputs;
use squid_flight::metrics::StepFigures;
use squid_report::at_sea::{self, Figures};
use squid_report::simulate;
use squid_report::turning::{self, Both, Turns};
use std::path::Path;

/// Flies a design, at sea if a file says one, and writes records and plots.
///
/// # Errors
/// Those of the files, the design and the flights.
pub fn run(which: &Which, sea: Option<&Path>) -> Result<(), Error> {
    let (inputs, directory) = which.read_to_write()?;
    let sea = sea.map(|path| read_sea(path, &inputs)).transpose()?;
    let stored = load_or_design(&inputs, &directory)?;
    stored.unproved(&inputs).iter().for_each(|words| say(words));
    let running = Progress::new(&show).begin("simulate", "flying");
    let found = if let Some((sea, _)) = &sea {
        let flown = at_sea::run(&inputs, &stored, sea, &directory)?;
        drop(running);
        say(flown.words.trim_end());
        let [at_sea, still] = [flown.at_sea, flown.still].map(|figures| errors(&inputs, &figures));
        let surfacing = flown.surfacing;
        json!({ "directory": directory, "at_sea": at_sea, "still_water": still, "surfacing": surfacing })
    } else {
        let flown = simulate::run(&inputs, &stored, &directory)?;
        drop(running);
        say(flown.words.trim_end());
        let steps: Vec<Value> = flown.steps.iter().map(step).collect();
        json!({ "directory": directory, "steps": steps })
    };
    Ok(answer(&found)?)
}

/// Flies a design of pitch or depth and one of heading together, by a turn \[deg\] in a current \[m/s\], at sea if a
/// file says one.
///
/// # Errors
/// Those of the files, the designs and the flights.
pub fn with_heading(
    which: &Which,
    heading: &str,
    turn: f64,
    (current, sea): (Option<[f64; 2]>, Option<&Path>),
) -> Result<(), Error> {
    if !turn.is_finite() || turn == 0.0 || turn.abs() >= HALF_A_TURN {
        let allowed = "other than 0 and below 180 deg in size".into();
        return Err(Error::Argument { name: "--turn", found: turn.to_string(), allowed });
    }
    let (inputs, directory) = which.read_to_write()?;
    let (turning, its) = which.beside(&inputs, heading)?;
    check_directory(&its)?;
    let sea = sea.map(|path| read_sea(path, &inputs)).transpose()?;
    let stored = load_or_design(&inputs, &directory)?;
    let own = load_or_design(&turning, &its)?;
    stored.unproved(&inputs).into_iter().chain(own.unproved(&turning)).for_each(|words| say(&words));
    let [horizontal, east] = current.unwrap_or_default();
    let current = Current { horizontal, east, ..Current::default() };
    let running = Progress::new(&show).begin("simulate", "flying");
    let both = Both { level: (&inputs, &stored), heading: (&turning, &own) };
    let around = (current, sea.as_ref().map(|(sea, _)| sea));
    let Turns { turned, coupling, words } = turning::run(both, turn.to_radians(), around, &directory)?;
    drop(running);
    say(words.trim_end());
    let coupling = coupling.map(|found| {
        let [low, high] = found.rates.map(f64::to_degrees);
        json!({ "gains": found.gains(), "rates_deg": [low, high], "taken": found.taken })
    });
    Ok(answer(&json!({ "directory": directory, "turns": turned, "coupling": coupling }))?)
}

/// A turn by as much is as short to either side, deg.
const HALF_A_TURN: f64 = 180.0;

/// The figures of a flight, in rad or m, m/s and fractions.
fn errors(inputs: &Inputs, figures: &Figures) -> Value {
    let error = format!("{}_error", inputs.design.interface.signals[inputs.design.stepped()].name);
    json!({
        error: figures.error,
        "speed_error": figures.speed_error,
        "actuator_use": figures.actuator_use,
    })
}

/// The metrics of a step, in m/s, s and fractions; what is unknown, or never settles, is null.
fn step((speed, figures): &(f64, StepFigures)) -> Value {
    let mut value = json!(figures);
    value["speed"] = json!(speed);
    value
}
