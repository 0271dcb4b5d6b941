//! Comparison of a flight at sea with the same flight in still water.

use crate::error::Error;
use crate::page::draw;
use crate::record::panels;
use crate::simulate::{heading, of_flight};
use crate::subject::Step;
use squid_auv::longitudinal::SPEED;
use squid_base::files::Files;
use squid_base::numbers::decimals;
use squid_design::inputs::Inputs;
use squid_design::store::Stored;
use squid_finding::Finding;
use squid_flight::flight::{Row, fly, fly_at_sea};
use squid_flight::metrics::{FlightFigures, rms};
use squid_flight::record::Record;
use squid_flight::sea::Sea;
use std::path::Path;

/// Figures of a flight, from true values instead of sensor readings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Figures {
    /// RMS error of the stepped output, rad or m.
    pub error: f64,
    /// RMS speed error, m/s.
    pub speed_error: f64,
    /// Largest use of an actuator, relative to its limits.
    pub actuator_use: f64,
}

/// Default manoeuvre at sea and in still water.
#[derive(Debug, Clone)]
pub struct Compared {
    /// Flights that end at the surface or leave the range of speed.
    pub findings: Vec<Finding>,
    /// Figures as text.
    pub summary: String,
    /// Flight at sea.
    pub at_sea: Figures,
    /// Flight in still water, over the same time.
    pub still: Figures,
    /// Time at which the vehicle reached the surface and the flight ended, s.
    pub surfacing: Option<f64>,
}

/// Simulates the default manoeuvre at sea and in still water, writes record and plot of the flight at sea, `sea.csv`
/// and `sea.svg`, to `directory`, and returns the figures of both.
///
/// # Errors
/// [`Error::Flight`], [`Error::Plot`], [`Error::Design`].
pub fn run(inputs: &Inputs, stored: &Stored, sea: &Sea, directory: &Path) -> Result<Compared, Error> {
    let (vehicle, manoeuvre) = (&inputs.vehicle, &stored.manoeuvre);
    let (depth, pitch) = inputs.design.level();
    let depth = sea.depth.unwrap_or(depth);
    let flown = fly_at_sea(vehicle, &stored.controller, (depth, pitch), manoeuvre, sea)?;
    let still = fly(vehicle, &stored.controller, (depth, pitch), manoeuvre)?;
    let record = Record::of(&flown, &vehicle.actuators, &stored.controller);
    let title = format!("{}, {}: at sea", heading(inputs), inputs.design.source());
    let path = directory.join("sea.svg");
    let svg = draw(&path, &title, &panels(&record, &vehicle.actuators))?;
    let mut files = Files::default();
    files.add(path, svg);
    files.add(directory.join("sea.csv"), record.csv());
    files.save(directory)?;

    let common = flown.rows.len().min(still.rows.len());
    let step = Step::of(inputs, &stored.manoeuvre);
    let figures = |rows: &[Row]| Figures::of(&rows[..common], step.index, &inputs.limits());
    let (at_sea, calm) = (figures(&flown.rows), figures(&still.rows));
    let duration = flown.rows[common - 1].time;
    let mut findings = of_flight("the simulation at sea", &flown, inputs);
    findings.extend(of_flight("still water", &still, inputs));
    let mut summary = format!("Default manoeuvre from a depth of {depth} m, over {duration:.2} s\n");
    summary += &waves_met(sea, [manoeuvre.speed_from, manoeuvre.speed_to]);
    summary += "                            still water       at sea\n";
    let line = |what: &str, of: &dyn Fn(&Figures) -> f64| {
        format!("  {what:<26}{:>11}  {:>11}\n", decimals(of(&calm), 3), decimals(of(&at_sea), 3))
    };
    let what = format!("{} error, rms ({})", step.name, step.unit);
    summary += &line(&what, &|f| step.factor * f.error);
    summary += &line("speed error, rms (m/s)", &|f| f.speed_error);
    summary += &line("largest actuator use (%)", &|f| 100.0 * f.actuator_use);
    summary += &format!("\nRecord and plot: {}\n", directory.join("{sea.csv,sea.svg}").display());
    let surfacing = flown.surfacing.map(|surfacing| surfacing.time);
    Ok(Compared { findings, summary, at_sea, still: calm, surfacing })
}

/// Returns the encounter frequency of the wave peak at the two speeds of the manoeuvre, as text.
fn waves_met(sea: &Sea, speeds: [f64; 2]) -> String {
    let Some(waves) = &sea.waves else { return String::new() };
    let peak = waves.spectrum.peak();
    let met = speeds.map(|speed| squid_sea::encounter_frequency(peak, waves.heading, speed));
    format!(
        "Waves of Hs = {} m with peak at {peak:.3} rad/s, encountered at {:.3} to {:.3} rad/s for {} to {} m/s\n",
        waves.spectrum.height(),
        met[0],
        met[1],
        speeds[0],
        speeds[1]
    )
}

impl Figures {
    fn of(rows: &[Row], index: usize, limits: &[(f64, f64)]) -> Self {
        Self {
            error: rms(rows, index),
            speed_error: rms(rows, SPEED),
            actuator_use: FlightFigures::of(rows, index, limits).actuator_use,
        }
    }
}
