//! `squid simulate`: flights in this process.

use crate::cli::{Which, read_sea};
use crate::error::Error;
use crate::output::{answer, say};
use crate::progress::show;
use crate::verbs::design::load_or_design;
use base::progress::Progress;
use serde_json::{Value, json};
use squid_design::inputs::Inputs;
use squid_flight::metrics::StepFigures;
use squid_report::at_sea::{self, Figures};
use squid_report::simulate;
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
