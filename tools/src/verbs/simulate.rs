//! `squid simulate`: simulations in this process.

use crate::cli::{Selected, Which, read_sea};
use crate::error::Error;
use crate::output::{answer, say, warn};
use crate::progress::show;
use crate::verbs::design::{load_or_design, proved};
use serde_json::{Value, json};
use squid_auv::Current;
use squid_base::progress::Progress;
use squid_design::axis::several;
use squid_design::inputs::Inputs;
use squid_design::store::Stored;
use squid_flight::metrics::StepFigures;
use squid_flight::sea::Sea;
use squid_report::at_sea::{self, Figures};
use squid_report::simulate;
use squid_report::turning::{Axes, Turns, turns};
use std::path::Path;

/// Simulates each axis of a design, in a sea if a file is given, and writes records and plots; with a heading axis in
/// addition to pitch or depth also turns \[deg\] in a current \[m/s\].
///
/// # Errors
/// Errors of the files, the design and the simulations.
pub fn run(
    which: &Which,
    turn: Option<f64>,
    (current, sea): (Option<[f64; 2]>, Option<&Path>),
) -> Result<(), Error> {
    if let Some(found) = turn.filter(|turn| !turn.is_finite() || *turn == 0.0 || turn.abs() >= HALF_A_TURN) {
        let allowed = "other than 0 and of a magnitude below 180 deg".into();
        return Err(Error::Argument { name: "--turn", found: found.to_string(), allowed });
    }
    let Selected { axes, directory } = which.read_to_write()?;
    let both = several::level_and_heading(&axes.iter().map(|(inputs, _)| inputs).collect::<Vec<_>>());
    let given = [("--turn", turn.is_some()), ("--current", current.is_some())];
    if let Some((name, _)) = given.into_iter().find(|(_, given)| *given && both.is_none()) {
        let (found, allowed) =
            ("given".to_owned(), "omitted for a design without a heading axis in addition to another axis");
        return Err(Error::Argument { name, found, allowed: allowed.into() });
    }
    let sea = sea.map(|path| read_sea(path, &axes[0].0)).transpose()?;
    let stored = load_or_design(&axes)?;
    let unproved: Vec<_> =
        axes.iter().zip(&stored).map(|((inputs, _), stored)| stored.unproved(inputs)).collect();
    unproved.iter().flatten().for_each(warn);
    let mut found = vec![];
    for (((inputs, directory), stored), unproved) in axes.iter().zip(&stored).zip(&unproved) {
        // The heading axis alone is simulated in still water only.
        let is_alone = both.is_none() || sea.is_none() || !inputs.design.view().is_level_held;
        let sea = sea.as_ref().map(|(sea, _)| sea);
        let flown = is_alone.then(|| simulate_axis((inputs, stored), sea, directory)).transpose()?;
        let mut flown = flown.unwrap_or_else(|| json!({ "directory": directory }));
        if axes.len() > 1 {
            flown["axis"] = json!(inputs.design.steered_signal());
        }
        proved(unproved.as_ref()).into_iter().for_each(|(key, value)| flown[key] = value);
        found.push(flown);
    }
    if let ([one], 1) = (&found[..], axes.len()) {
        return Ok(answer(one)?);
    }
    let mut answer_json = json!({ "directory": directory, "axes": found });
    let designs: Vec<_> = axes.iter().map(|(inputs, _)| inputs).zip(&stored).collect();
    if let Some(turning) = Axes::of(&designs) {
        let [north, east] = current.unwrap_or_default();
        let current = Current { horizontal: north, east, ..Current::default() };
        let running = Progress::new(&show).begin("simulate", "flying");
        let around = (current, sea.as_ref().map(|(sea, _)| sea));
        let turn = turn.unwrap_or(TURN).to_radians();
        let turns = turns(turning, turn, around)?;
        let text = turns.save(turning, &directory)?;
        drop(running);
        say(text.trim_end());
        let Turns { turned, coupling, .. } = turns;
        answer_json["turns"] = json!(turned);
        answer_json["coupling"] = json!(coupling.map(|found| {
            let [low, high] = found.rates.map(f64::to_degrees);
            json!({ "gains": found.gains(), "rates_deg": [low, high], "taken": found.taken })
        }));
    }
    Ok(answer(&answer_json)?)
}

/// Simulates an axis alone; returns the figures.
fn simulate_axis(
    (inputs, stored): (&Inputs, &Stored),
    sea: Option<&Sea>,
    directory: &Path,
) -> Result<Value, Error> {
    let running = Progress::new(&show).begin("simulate", "flying");
    if let Some(sea) = sea {
        let flown = at_sea::run(inputs, stored, sea, directory)?;
        drop(running);
        flown.findings.iter().for_each(warn);
        say(flown.summary.trim_end());
        let [at_sea, still] = [flown.at_sea, flown.still].map(|figures| errors(inputs, &figures));
        let surfacing = flown.surfacing;
        return Ok(
            json!({ "directory": directory, "at_sea": at_sea, "still_water": still, "surfacing": surfacing }),
        );
    }
    let flown = simulate::run(inputs, stored, directory)?;
    drop(running);
    flown.findings.iter().for_each(warn);
    say(flown.summary.trim_end());
    let steps: Vec<Value> = flown.steps.iter().map(step).collect();
    Ok(json!({ "directory": directory, "steps": steps }))
}

/// Default turn angle, deg.
pub const TURN: f64 = 60.0;

/// Turn angle that is equally short to either side, deg.
const HALF_A_TURN: f64 = 180.0;

/// Returns the figures of a simulation, in rad or m, m/s and fractions.
fn errors(inputs: &Inputs, figures: &Figures) -> Value {
    let error = format!("{}_error", inputs.design.interface.signals[inputs.design.stepped()].name);
    json!({
        error: figures.error,
        "speed_error": figures.speed_error,
        "actuator_use": figures.actuator_use,
    })
}

/// Returns the metrics of a step, in m/s, s and fractions; null if unknown or never settled.
fn step((speed, figures): &(f64, StepFigures)) -> Value {
    let mut value = json!(figures);
    value["speed"] = json!(speed);
    value
}
