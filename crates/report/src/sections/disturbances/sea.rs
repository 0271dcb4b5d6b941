//! Effect of the waves, the current and the sensor errors of a sea on the loop.

use crate::error::Error;
use crate::page::{Axis, Chart, Curve, Figure, Part, Table, capital};
use crate::subject::Subject;
use crate::threads::in_parallel;
use squid_auv::longitudinal::{SPEED, index};
use squid_base::numbers::decimals;
use squid_flight::flight::{Flight, Row, fly_at_sea};
use squid_flight::sea::Sea;
use squid_scheduled::{ControllerDesign, Manoeuvre};

/// Number of realisations of the sea at each speed and depth, and the duration of a flight (s).
pub(super) const SEAS: u64 = 3;
pub(super) const FLOWN: f64 = 60.0;
/// Depths, relative to that of the sea.
const DEPTHS: [f64; 4] = [0.5, 1.0, 2.0, 4.0];
/// Decimals of an RMS value.
pub(super) const DIGITS: usize = 3;

/// Mean square over the rows of a flight.
pub(super) type MeanSquare = Box<dyn Fn(&[Row]) -> f64 + Sync>;

/// Mean squares of a flight; `None` if it ends at the surface or cannot start near it.
pub(super) type Squares = Option<Vec<f64>>;

/// Returns the section on the sea of a file, if there is one: flights at six speeds, and the effect of waves at other
/// depths.
///
/// # Errors
/// Errors of [`fly_at_sea`], for flights at the depth of the sea.
pub fn sea(subject: &Subject) -> Result<Vec<Part>, Error> {
    let Some((sea, _)) = &subject.sea else { return Ok(vec![]) };
    let depth = sea.depth.unwrap_or(subject.inputs.design.depth);
    let (names, squares): (Vec<String>, Vec<MeanSquare>) = quantities(subject).into_iter().unzip();
    let flown = |depth: f64, speed: f64, k: u64| -> Result<Squares, Error> {
        let sea = Sea { depth: Some(depth), ..sea.clone() };
        let flight = fly(subject, &subject.stored.controller, &sea, speed, k)?;
        Ok(flight.surfacing.is_none().then(|| squares.iter().map(|square| square(&flight.rows)).collect()))
    };
    // Only an error of the first flight is reported.
    flown(depth, subject.speeds[0], 0)?;
    let is_flown = |part: &f64| *part == 1.0 || sea.waves.is_some();
    let depths: Vec<f64> = DEPTHS.into_iter().filter(is_flown).map(|part| part * depth).collect();
    let conditions = depths.iter().flat_map(|depth| subject.speeds.iter().map(move |speed| (*depth, *speed)));
    let mut found = in_parallel(conditions, |(depth, speed)| {
        let roots = roots(|k| flown(depth, speed, k).ok().flatten());
        (depth, speed, roots)
    });
    found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut table = Table::new(["speed (m/s)"]);
    table.head.extend(names.iter().cloned());
    for (_, speed, roots) in found.iter().filter(|found| found.0 == depth) {
        let cell = |i: usize| roots.as_ref().map_or("-".into(), |roots| decimals(roots[i], DIGITS));
        table.rows.push(std::iter::once(format!("{speed:.2}")).chain((0..names.len()).map(cell)).collect());
    }
    let chart = |(i, name): (usize, &String)| {
        let curve = |(key, speed): (usize, &f64)| {
            let own = found.iter().filter(|found| found.1 == *speed);
            Curve {
                key,
                points: own.filter_map(|(depth, _, roots)| Some((*depth, roots.as_ref()?[i]))).collect(),
            }
        };
        Chart {
            title: String::new(),
            x: Axis::logarithmic("initial depth (m)"),
            y: Axis::logarithmic(format!("rms of {name}")),
            curves: subject.speeds.iter().enumerate().map(curve).collect(),
        }
    };
    let figure = Figure {
        name: "at-sea".into(),
        caption: format!(
            "{} in these seas over depth, at six speeds; points are missing where the hull breaks the surface in one \
                 of them.",
            capital(&subject.name())
        ),
        keys: subject.speed_keys(),
        charts: names.iter().enumerate().map(chart).collect(),
    };
    let mut parts = vec![Part::Text(about(sea, depth)), Part::Table(table)];
    parts.extend((depths.len() > 1 && depth > 0.0).then_some(Part::Figure(figure)));
    Ok(parts)
}

/// Returns RMS values over all realisations of a sea; `None` if one flight has none.
pub(super) fn roots(flown: impl Fn(u64) -> Squares) -> Squares {
    let all: Vec<Vec<f64>> = (0..SEAS).map(flown).collect::<Option<_>>()?;
    let root = |i: usize| (all.iter().map(|one| one[i]).sum::<f64>() / SEAS as f64).sqrt();
    Some((0..all[0].len()).map(root).collect())
}

/// Simulates level flight at a constant speed (m/s), in the k-th realisation of a sea.
pub(super) fn fly(
    subject: &Subject,
    controller: &ControllerDesign,
    sea: &Sea,
    speed: f64,
    k: u64,
) -> Result<Flight, Error> {
    let (inputs, stored) = (subject.inputs, subject.stored);
    let level =
        Manoeuvre { speed_from: speed, speed_to: speed, duration: FLOWN, ..stored.manoeuvre.without_steps() };
    let sea = Sea { seed: sea.seed.wrapping_add(k), ..sea.clone() };
    Ok(fly_at_sea(&inputs.vehicle, controller, inputs.design.level(), &level, &sea)?)
}

/// Returns mean squares of the errors of the stepped output and of speed, and of heave and each command about their
/// means, with the names of their RMS values.
pub(super) fn quantities(subject: &Subject) -> Vec<(String, MeanSquare)> {
    fn mean(rows: &[Row], of: impl Fn(&Row) -> f64) -> f64 {
        rows.iter().map(of).sum::<f64>() / rows.len() as f64
    }
    fn about_mean(of: impl Fn(&Row) -> f64 + Sync + 'static) -> MeanSquare {
        Box::new(move |rows| {
            let middle = mean(rows, &of);
            mean(rows, |row| (of(row) - middle).powi(2))
        })
    }
    let error = |index: usize, factor: f64| -> MeanSquare {
        Box::new(move |rows| mean(rows, |row| (factor * row.error(index)).powi(2)))
    };
    let heave = index("heave").unwrap_or_default();
    let step = subject.step();
    let mut all = vec![
        (format!("{} error ({})", step.name, step.unit), error(step.index, step.factor)),
        ("speed error (m/s)".to_owned(), error(SPEED, 1.0)),
        ("heave (m/s)".to_owned(), about_mean(move |row| row.measured(heave))),
    ];
    for (j, actuator) in subject.inputs.vehicle.actuators.iter().enumerate() {
        let scale = 100.0 / actuator.reach();
        let name = format!("{} (% of reach)", actuator.name);
        all.push((name, about_mean(move |row| scale * row.commands[j])));
    }
    all
}

/// Returns the description of the simulated flights.
fn about(sea: &Sea, depth: f64) -> String {
    let waves = sea.waves.as_ref().map_or("no waves".into(), |swell| {
        format!(
            "waves of Hs = {} m with peak at {:.3} rad/s, {:.0} deg from the heading of the vehicle",
            squid_auv::rounded(swell.spectrum.height()),
            swell.spectrum.peak(),
            swell.heading.to_degrees()
        )
    });
    let wanders = if sea.gauss_markov.is_some() { ", with a Gauss-Markov part" } else { "" };
    format!(
        "Level motion at constant speed, from {} m below still water: {waves}; a current of {} m/s at this \
         depth{wanders}; sensors with the errors of the file. The table contains root mean squares over {SEAS} such \
         seas of {FLOWN} s, with seeds from {}: true errors relative to the references, heave relative to the water, \
         and commands about their means; `-` if the hull breaks the surface. Simulated, not proved.",
        squid_auv::rounded(depth),
        squid_auv::rounded(sea.layers.at(depth).0),
        sea.seed
    )
}
