//! Campaigns simulated with FMUs: the random values for the simulating program, and the evaluation of its records.

use crate::error::Error;
use crate::verbs::plot::{read_record, record_error, rows};
use serde_json::{Map, Value, json};
use squid_auv::longitudinal;
use squid_campaign::flight::Row;
use squid_campaign::plan::{Drawn, Plan};
use squid_design::uncertain::model::{Block, Uncertain};
use std::path::Path;

/// Returns the random values of a flight: the manoeuvre; start values of coefficients and sea by their names in the
/// vehicle's FMU; and for each actuator the ratio of output to command.
pub(super) fn drawn(plan: &Plan<'_>, flight: u64) -> Value {
    let drawn = plan.draw(flight);
    let parameter = |(block, _): &(&Block, f64)| matches!(block.uncertain, Uncertain::Parameter(_));
    let named = |(block, value): (&Block, f64)| (block.name.clone(), value.into());
    let coefficients = plan.values(&drawn).filter(parameter).map(named);
    let start: Map<String, Value> = coefficients.chain(sea(plan, &drawn)).collect();
    let actuators = plan.vehicle.actuators.iter().map(|actuator| actuator.name.clone());
    let gains: Map<String, Value> = actuators.zip(plan.gains(&drawn).into_iter().map(Value::from)).collect();
    json!({ "flight": flight, "manoeuvre": drawn.manoeuvre, "start": start, "gains": gains })
}

/// Returns waves and steady current of a flight, the only sea that FMUs support, and the initial depth.
fn sea(plan: &Plan<'_>, drawn: &Drawn) -> Vec<(String, Value)> {
    let Some(sea) = plan.sea_of(drawn) else { return Vec::new() };
    let depth = sea.depth.map(|depth| ("initial_depth", depth.into()));
    let current =
        [("current_horizontal", sea.layers.at(0.0).0.into()), ("current_vertical", sea.vertical.into())];
    let waves = sea.waves.iter().flat_map(|swell| {
        [
            ("wave_height", swell.spectrum.height().into()),
            ("wave_period", swell.spectrum.period().into()),
            ("wave_gamma", swell.spectrum.gamma().into()),
            ("wave_heading", swell.heading.into()),
            ("wave_seed", Value::from(sea.seed)),
        ]
    });
    depth.into_iter().chain(current).chain(waves).map(|(name, value)| (name.to_owned(), value)).collect()
}

/// Evaluates the record of a flight.
///
/// # Errors
/// [`Error::Record`], and errors of the sea.
pub(super) fn evaluate_record(plan: &Plan<'_>, records: &Path, flight: u64) -> Result<Row, Error> {
    let path = records.join(format!("flight-{flight}.csv"));
    let record = read_record(&path)?;
    let actuators = &plan.vehicle.actuators;
    let rows =
        rows(&record, actuators, &longitudinal::SIGNALS).map_err(|reason| record_error(&path, reason))?;
    let distance =
        record.get("distance").ok_or_else(|| record_error(&path, "there is no column 'distance'"))?;
    Ok(plan.judge(flight, rows, distance)?)
}
