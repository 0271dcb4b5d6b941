//! `squid simulate`: flights in this process.

use crate::cli::Which;
use crate::error::Error;
use crate::output::{answer, say};
use crate::progress::show;
use crate::verbs::design::load_or_design;
use serde_json::{Value, json};
use squid_design::progress::Progress;
use squid_flight::metrics::StepFigures;
use squid_report::simulate;

/// Flies a design, and writes records and plots.
///
/// # Errors
/// Those of the files, the design and the flights.
pub fn run(which: &Which) -> Result<(), Error> {
    let (inputs, directory) = which.read_to_write()?;
    let stored = load_or_design(&inputs, &directory)?;
    stored.unproved(&inputs).iter().for_each(|words| say(words));
    let running = Progress::new(&show).begin("simulate", "flying");
    let flown = simulate::run(&inputs, &stored, &directory)?;
    drop(running);
    say(flown.words.trim_end());
    let steps: Vec<Value> = flown.steps.iter().map(|(speed, figures)| step(*speed, figures)).collect();
    Ok(answer(&json!({ "directory": directory, "steps": steps }))?)
}

/// The figures of a pitch step, in m/s, s and fractions; what is not known, or never settles, is null.
fn step(speed: f64, figures: &StepFigures) -> Value {
    json!({
        "speed": speed,
        "overshoot": figures.overshoot,
        "rise_time": figures.rise_time,
        "settling_time": figures.settling_time,
        "steady_error": figures.steady_error,
        "speed_deviation": figures.speed_deviation,
        "actuator_use": figures.actuator_use,
    })
}
