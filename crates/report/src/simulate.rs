//! Simulations: the default manoeuvre, steps over the speed range, and open-loop responses.

use crate::error::Error;
use crate::page::{Kind, Line, Panel, capital, draw, extent, known, tidy};
use crate::record::panels;
use crate::subject::{FLOWN, Step, shown};
use squid_auv::longitudinal::SPEED;
use squid_auv::readable;
use squid_base::files::Files;
use squid_base::numbers::decimals;
use squid_design::fit::frequency;
use squid_design::inputs::Inputs;
use squid_design::store::Stored;
use squid_finding::Finding;
use squid_flight::flight::{ActuatorStep, Flight, Row, Surfacing, fly, fly_open_loop};
use squid_flight::metrics::{SETTLED, StepFigures};
use squid_flight::record::Record;
use squid_scheduled::Manoeuvre;
use std::path::Path;

/// Number of speeds at which steps are simulated.
const STEP_SPEEDS: usize = 6;

/// Results of the simulations.
#[derive(Debug, Clone)]
pub struct Flown {
    /// Flights that end at the surface or leave the range of speed.
    pub findings: Vec<Finding>,
    /// Figures as text.
    pub summary: String,
    /// Speed of each step, m/s, and its figures.
    pub steps: Vec<(f64, StepFigures)>,
}

/// Simulates the manoeuvre, the steps and the open loop, writes records (CSV) and plots (SVG) to `directory`, and
/// returns the figures.
///
/// # Errors
/// [`Error::Flight`], [`Error::Plot`], [`Error::Design`].
pub fn run(inputs: &Inputs, stored: &Stored, directory: &Path) -> Result<Flown, Error> {
    let manoeuvre = &stored.manoeuvre;
    let mut files = Files::default();
    let mut plot = |name: &str, title: &str, panels: &[Panel]| {
        let path = directory.join(name);
        draw(&path, title, panels).map(|svg| files.add(path, svg))
    };
    let flight = fly(&inputs.vehicle, &stored.controller, inputs.design.level(), manoeuvre)?;
    let mut findings = of_flight("the default manoeuvre", &flight, inputs);
    let record = Record::of(&flight, &inputs.vehicle.actuators, &stored.controller);
    let title = format!("{}, {}: the default manoeuvre", heading(inputs), inputs.design.source());
    plot("flight.svg", &title, &panels(&record, &inputs.vehicle.actuators))?;
    let stepped = Step::of(inputs, manoeuvre);
    let mut out = format!(
        "{} step at constant speed, nonlinear vehicle and sampled autopilot\n",
        capital(stepped.name)
    );
    out += &format!(
        "  speed m/s   overshoot %   10-90 % s   settled ({:.0} %) s   steady error %   speed off \
            m/s   actuator use %\n",
        100.0 * SETTLED
    );
    let (mut responses, mut steps) = (Vec::new(), Vec::new());
    for speed in inputs.design.spread(STEP_SPEEDS) {
        let step = Manoeuvre {
            speed_from: speed,
            speed_to: speed,
            step_time: 2.0,
            duration: 2.0 + FLOWN,
            ..manoeuvre.with_step(stepped.name, stepped.height)
        };
        let flown = fly(&inputs.vehicle, &stored.controller, inputs.design.level(), &step)?;
        findings.extend(early_end(&format!("the step at {speed:.2} m/s"), flown.surfacing));
        let timed = (step.step_time, stepped.height);
        let figures = StepFigures::of_flight(&flown, stepped.index, timed, &inputs.limits());
        out += &figures_line(speed, &figures);
        steps.push((speed, figures));
        responses.push((speed, flown.rows));
    }
    let (heading, source) = (heading(inputs), inputs.design.source());
    let title = format!("{heading}, {source}: {} steps at constant speed", stepped.name);
    let until = shown(steps.iter().map(|(_, figures)| figures.settling_time).fold(0.0, f64::max));
    plot("steps.svg", &title, &step_panels(inputs, &stepped, &responses, until))?;
    let (title, panel) = open_loop(inputs, stored)?;
    plot("open_loop.svg", &title, &[panel])?;
    files.add(directory.join("flight.csv"), record.csv());
    files.save(directory)?;
    out += &format!(
        "\nRecords and plots: {}\n",
        directory.join("{flight.csv,flight.svg,steps.svg,open_loop.svg}").display()
    );
    Ok(Flown { findings, summary: out, steps })
}

/// Returns the findings on a flight: its end at the surface, and a speed outside the range of the design.
pub(crate) fn of_flight(name: &str, flight: &Flight, inputs: &Inputs) -> Vec<Finding> {
    early_end(name, flight.surfacing).into_iter().chain(out_of_range(name, &flight.rows, inputs)).collect()
}

/// Returns a finding if a flight ended at the surface.
pub(crate) fn early_end(flight: &str, surfacing: Option<Surfacing>) -> Option<Finding> {
    surfacing.map(|surfacing| {
        let why = format!(
            "in {flight} {surfacing}, and the simulation ends there, because the equations hold in deep water only; \
             the figures are those up to this time, - means unknown"
        );
        Finding::new("surfaced", flight, why).value(surfacing.time, "s")
    })
}

/// Returns a finding, with extent and duration, if the speed along the path was outside the range of the design.
fn out_of_range(flight: &str, rows: &[Row], inputs: &Inputs) -> Option<Finding> {
    let (low, high) = (inputs.design.speed_min, inputs.design.speed_max);
    let along = |row: &Row| {
        let heave = inputs.design.interface.index("heave");
        let (forward, heave) = (row.measured(SPEED), heave.map_or(0.0, |w| row.measured(w)));
        forward.hypot(heave).copysign(forward)
    };
    let outside: Vec<f64> = rows.iter().map(along).filter(|speed| !(low..=high).contains(speed)).collect();
    if outside.is_empty() {
        return None;
    }
    let share = 100.0 * outside.len() as f64 / rows.len() as f64;
    let (slowest, fastest) = extent(outside.iter().copied());
    let why = format!(
        "in {flight} the speed is outside the range of the design, {low} to {high} m/s, during {} % of the time: {} \
         to {} m/s; the proof holds inside the range only",
        decimals(share, 1),
        decimals(slowest, 2),
        decimals(fastest, 2)
    );
    let (value, limit) = if fastest > high { (fastest, high) } else { (slowest, low) };
    Some(Finding::new("outside_speed_range", flight, why).value(value, "m/s").limit(limit))
}

pub(crate) fn heading(inputs: &Inputs) -> String {
    let surrogate = if inputs.vehicle.status == squid_auv::Status::Surrogate { " (surrogate)" } else { "" };
    format!("{}{surrogate}", inputs.vehicle.name)
}

fn figures_line(speed: f64, f: &StepFigures) -> String {
    format!(
        "  {speed:>9.2}   {:>11}   {:>9}   {:>15}   {:>14}   {:>13}   {:>14}\n",
        known(100.0 * f.overshoot, 2),
        known(f.rise_time, 2),
        known(f.settling_time, 2),
        known(100.0 * f.steady_error, 2),
        known(f.speed_deviation, 3),
        known(100.0 * f.actuator_use, 0)
    )
}

/// Simulates the open-loop response to a small step of the first actuator at three speeds; returns the title and the
/// panel of its plot.
fn open_loop(inputs: &Inputs, stored: &Stored) -> Result<(String, Panel), Error> {
    let actuator = &inputs.vehicle.actuators[0];
    let height = 0.02 * actuator.reach();
    let step = ActuatorStep { actuator: 0, height };
    let mut lines = Vec::new();
    for speed in inputs.design.spread(STEP_SPEEDS).into_iter().take(3) {
        let (level, interval) = (inputs.design.level(), stored.controller.sample_time);
        let rows = fly_open_loop(&inputs.vehicle, inputs.design.view(), level, speed, step, interval, FLOWN)?;
        let points = rows.iter().map(|(t, pitch)| (*t, pitch.to_degrees())).collect();
        lines.push(line(inputs, speed, points));
    }
    let title = format!(
        "{}: open loop, step of {} by {height:.2} {}",
        heading(inputs),
        actuator.name,
        actuator.unit()
    );
    let angle = frequency::angle(inputs.design.states).name;
    Ok((title, Panel::over_time(format!("{angle} from trim (deg)"), lines)))
}

/// Returns the line of a flight at a speed.
fn line(inputs: &Inputs, speed: f64, points: Vec<(f64, f64)>) -> Line {
    let part = 0.5 * (inputs.design.rho(speed) + 1.0);
    Line { name: format!("{speed:.2} m/s"), points, kind: Kind::Along(part) }
}

fn step_panels(inputs: &Inputs, step: &Step, responses: &[(f64, Vec<Row>)], until: f64) -> Vec<Panel> {
    let drawn = |r: &&Row| r.time <= until;
    let each = |of: &dyn Fn(&Row, &Row) -> f64| -> Vec<Line> {
        let points = |rows: &[Row]| rows.iter().filter(drawn).map(|r| (r.time, of(r, &rows[0]))).collect();
        responses.iter().map(|(speed, rows)| line(inputs, *speed, points(rows))).collect()
    };
    let mut panels = vec![
        Panel::over_time(
            step.from_trim(),
            each(&|r, first| step.factor * (r.measured(step.index) - first.reference(step.index))),
        ),
        Panel::over_time("speed error (m/s)", each(&|r, _| -r.error(SPEED))),
    ];
    for (j, actuator) in inputs.vehicle.actuators.iter().enumerate() {
        let (factor, unit) = readable(actuator.unit());
        let [min, max] = [actuator.min, actuator.max].map(|limit| tidy(factor * limit, 1));
        let label = format!("{} ({unit}), from {min} to {max}", actuator.name);
        panels.push(Panel::over_time(label, each(&|r, _| factor * r.commands[j])));
    }
    panels
}
