//! Comparison at sea of a controller designed for that sea with one of the same weights for still water.

use crate::error::Error;
use crate::page::{Axis, Chart, Curve, Figure, Key, Part, Table, capital};
use crate::sections::disturbances::sea::{DIGITS, FLOWN, SEAS, Squares, fly, quantities, roots};
use crate::subject::Subject;
use crate::threads::in_parallel;
use squid_auv::longitudinal::PITCH;
use squid_base::numbers::decimals;
use squid_base::progress::Progress;
use squid_design::augment::augment;
use squid_design::certify::lft_matrices;
use squid_design::fit::Model;
use squid_design::inputs::Inputs;
use squid_design::inputs::design_file::{DesignFile, WorkingSea};
use squid_design::linearise::LevelFlight;
use squid_design::store::freeze::{controller, gamma};
use squid_design::synthesise::anti_windup::anti_windup;
use squid_design::synthesise::synthesise;
use squid_flight::flight::{Row, fly_at_sea};
use squid_flight::sea::Sea;
use squid_lpv::matrix::to_rows;
use squid_scheduled::{ControllerDesign, Manoeuvre};

/// Seed of the seas.
const SEED: u64 = 1;
/// Initial depth of the climb (m), unless the working depth is larger, and its longest duration (s).
const DEEP: f64 = 50.0;
const LONGEST: f64 = 1000.0;
/// Start of the climb, and the plotted duration of its end (s).
const BEGINS: f64 = 5.0;
const DRAWN: f64 = 60.0;

/// Returns the section on the sea of a design, if it has one.
///
/// # Errors
/// Errors of the synthesis for still water and of the flights.
pub fn working_sea(subject: &Subject) -> Result<Vec<Part>, Error> {
    let Some(sea) = &subject.inputs.design.sea else { return Ok(vec![]) };
    let for_this_sea = &subject.stored.controller;
    let other = for_still_water(subject.inputs)?;
    let both = [for_this_sea, &other];
    let (names, squares): (Vec<String>, Vec<_>) = quantities(subject).into_iter().unzip();
    let waves = Sea::of_waves(sea.waves.clone(), sea.depth, SEED)?;
    let jobs = subject.speeds.iter().flat_map(|speed| [0, 1].map(|which| (*speed, which)));
    let found = in_parallel(jobs, |(speed, which)| {
        let flown = |k| -> Squares {
            let flight = fly(subject, both[which], &waves, speed, k).ok()?;
            let rows = flight.surfacing.is_none().then_some(flight.rows)?;
            Some(squares.iter().map(|square| square(&rows)).collect())
        };
        (speed, which, roots(flown))
    });
    let mut table = Table::new(["speed (m/s)", "designed for this sea"]);
    table.head.extend(names);
    for (speed, which, roots) in &found {
        let cell = |i: usize| roots.as_ref().map_or("-".into(), |roots| decimals(roots[i], DIGITS));
        let begin = [format!("{speed:.2}"), ["yes", "no"][*which].into()];
        table.rows.push(begin.into_iter().chain((0..squares.len()).map(cell)).collect());
    }
    let mut parts = vec![Part::Text(about(sea)), Part::Table(table)];
    // The climb is a pitch step.
    if subject.inputs.design.stepped() == PITCH {
        parts.push(Part::Figure(climb(subject, sea, both)?));
    }
    Ok(parts)
}

/// Designs a controller with the same weights for still water.
fn for_still_water(inputs: &Inputs) -> Result<ControllerDesign, Error> {
    let design = DesignFile { sea: None, ..inputs.design.clone() };
    let (actuators, vehicle) = (&inputs.vehicle.actuators, LevelFlight { file: &design, ..inputs.axis() });
    let model = Model::new(&vehicle, &design)?;
    let plant = augment(actuators, &design, model.linear())?;
    let found = synthesise(actuators, &design, &plant, &Progress::default())?;
    let lft = lft_matrices(&found.controller);
    let frozen = controller(&vehicle, &design, &inputs.hashes, lft, gamma(&found, false))?;
    let gain = if design.anti_windup {
        anti_windup(&vehicle, &design, &found.controller)?.first().map(to_rows)
    } else {
        None
    };
    Ok(ControllerDesign { anti_windup: gain, ..frozen })
}

/// Simulates a climb from deep water to the working depth.
fn climb(subject: &Subject, sea: &WorkingSea, both: [&ControllerDesign; 2]) -> Result<Figure, Error> {
    let (inputs, stored) = (subject.inputs, subject.stored);
    let from = DEEP.max(2.0 * sea.depth);
    let (speed, _) = inputs.design.scheduling();
    // The vehicle climbs with the bow down when it moves astern.
    let pitch = stored.manoeuvre.step("pitch").abs().copysign(speed);
    let takes = 1.5 * (from - sea.depth) / (speed * pitch.sin());
    let manoeuvre = Manoeuvre {
        speed_from: speed,
        speed_to: speed,
        step_time: BEGINS,
        duration: (BEGINS + takes).min(LONGEST),
        ..stored.manoeuvre.with_step("pitch", pitch)
    };
    let deep = Sea::of_waves(sea.waves.clone(), from, SEED)?;
    let (mut errors, mut depths) = (vec![], vec![]);
    for (key, controller) in both.into_iter().enumerate() {
        let level = inputs.design.level();
        let flight = fly_at_sea(&inputs.vehicle, controller, level, &manoeuvre, &deep)?;
        let rows = &flight.rows;
        let arrives =
            rows.iter().find(|row| row.depth <= sea.depth).or(rows.last()).map_or(0.0, |row| row.time);
        let last = || rows.iter().filter(|row| (arrives - DRAWN..=arrives).contains(&row.time));
        let curve = |of: fn(&Row) -> f64| Curve {
            key,
            points: last().map(|row| (row.time - arrives, of(row))).collect(),
        };
        errors.push(curve(|row| row.error(PITCH).to_degrees()));
        depths.push(curve(|row| row.depth));
    }
    let chart = |label: &str, curves| Chart {
        title: String::new(),
        x: Axis::linear("time relative to reaching the working depth (s)"),
        y: Axis::linear(label),
        curves,
    };
    Ok(Figure {
        name: "surfacing".into(),
        caption: format!(
            "{} climbs from {} m at {} m/s with a pitch of {} deg: the last minute before reaching the working \
                depth.",
            capital(&subject.name()),
            squid_auv::rounded(from),
            squid_auv::rounded(speed),
            squid_auv::rounded(pitch.to_degrees())
        ),
        keys: vec![Key::nth(0, "designed for this sea"), Key::nth(1, "the same weights without [sea]")],
        charts: vec![chart("error of the pitch (deg)", errors), chart("depth (m)", depths)],
    })
}

/// Returns the description of the simulated flights.
fn about(sea: &WorkingSea) -> String {
    format!(
        "The generalised plant of the design contains waves of Hs = {} m with peak at {:.3} rad/s, as encountered at \
             a depth of {} m, with a weight of {}. Its controller is compared with that of the same file without \
             [sea]. Level motion at constant speed: root mean squares over {SEAS} such seas of {FLOWN} s; `-` if the \
             hull breaks the surface. Simulated, not proved.",
        squid_auv::rounded(sea.waves.spectrum.height()),
        sea.waves.spectrum.peak(),
        squid_auv::rounded(sea.depth),
        squid_auv::rounded(sea.weight)
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use squid_design::run::run;
    use squid_design::store::{load, save};
    use squid_flight::sea::WaveParameters;
    use squid_sea::{Spectrum, Waves};
    use std::path::Path;

    /// The pitch error of REMUS 100 a metre below waves of 1 m is smaller by a sixth or more at both ends of the speed
    /// range.
    #[test]
    #[ignore = "night: flies hundreds of minutes at sea"]
    fn design_for_the_sea_reduces_pitch_error() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../vehicles/remus100");
        let mut inputs = Inputs::read(&folder, "pitch").unwrap();
        let spectrum = Spectrum::jonswap(1.0, 6.0, 3.3).unwrap();
        let waves = WaveParameters { spectrum, heading: std::f64::consts::PI, components: Waves::USUAL };
        let sea = Some(WorkingSea { depth: 1.0, waves, weight: 5.0 });
        let steep = inputs.design.manoeuvre.with_step("pitch", 0.08);
        inputs.design =
            DesignFile { sea, anti_windup: false, uncertainty: None, manoeuvre: steep, ..inputs.design };
        let directory = tempfile::tempdir().unwrap();
        let progress = Progress::default();
        save(directory.path(), &inputs, &run(&inputs, &progress).unwrap()).unwrap();
        let stored = load(directory.path(), &inputs).unwrap();
        let mut subject = Subject::new(&inputs, &stored, &progress).unwrap();
        subject.speeds = vec![1.4, 2.2];
        let parts = working_sea(&subject).unwrap();
        let [Part::Text(_), Part::Table(table), Part::Figure(figure)] = &parts[..] else {
            panic!("{parts:?}")
        };
        assert_eq!(table.rows.len(), 2 * subject.speeds.len());
        for pair in table.rows.chunks(2) {
            let [yes, no] = [0, 1].map(|i| pair[i][2].parse::<f64>().unwrap());
            assert!(yes < 5.0 / 6.0 * no, "{yes} against {no} deg at {} m/s", pair[0][0]);
        }
        let [errors, depths] = &figure.charts[..] else { panic!("{figure:?}") };
        assert_eq!(errors.curves.len(), 2);
        for curve in &depths.curves {
            let [(from, deep), .., (to, shallow)] = curve.points[..] else { panic!("{curve:?}") };
            assert!(
                (from + DRAWN).abs() < 0.1 && to == 0.0 && deep > 4.0 && shallow <= 1.0,
                "{deep} {shallow}"
            );
        }
        subject.proof().as_ref().unwrap();
    }
}
