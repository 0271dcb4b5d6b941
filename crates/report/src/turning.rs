//! Simulations in six degrees of freedom: a design of pitch or depth and one of heading, in one vehicle.

use crate::error::Error;
use crate::page::{draw, known};
use crate::record::panels;
use crate::simulate::early_end;
use crate::threads::in_parallel;
use auv::Current;
use auv::longitudinal::SPEED;
use base::files::Files;
use proof::claim::text;
use scheduled::Manoeuvre;
use serde::Serialize;
use squid_design::check::coupled::frozen::largest_real_part;
use squid_design::check::coupled::gain::{CERTIFICATES, Coupling, coupling};
use squid_design::check::coupled::turn::Turning;
use squid_design::inputs::Inputs;
use squid_design::store::Stored;
use squid_flight::flight::Surfacing;
use squid_flight::record::Record;
use squid_flight::sea::Sea;
use squid_flight::whole::{WholeFlight, WholeRow, fly_whole};
use std::path::Path;

/// The number of speeds.
const SPEEDS: usize = 6;

/// When the steps of both axes come, and how long a flight lasts after them (s).
const STEP_TIME: f64 = 10.0;
const FLOWN: f64 = 90.0;

/// The band about the wanted heading in which it has settled, relative to the turn.
const SETTLED: f64 = 0.02;

/// A turn at a speed, while the other axis makes its step.
#[derive(Debug, Clone, Serialize)]
pub struct Turned {
    /// Speed along the path, m/s.
    pub speed: f64,
    /// Until heading stays within 2 % of the turn, s; `None` if it does not.
    pub settling_time: Option<f64>,
    /// Excursion of heading beyond the turn, relative to it.
    pub overshoot: f64,
    /// The largest difference of depth from the same flight without the turn, m.
    pub depth_by_turn: f64,
    /// The largest loss of speed against that flight, m/s.
    pub speed_by_turn: f64,
    /// The largest roll, rad.
    pub roll: f64,
    /// Up to which rate of a steady turn the linear loop of both autopilots is stable, rad/s: at eleven rates from the
    /// limit of the reference to port to that to starboard.
    pub stable_to: f64,
    /// The limit of the reference, rad/s.
    pub fastest: f64,
    /// How much of their reach the commands of heading move in the whole flight, the sum over all actuators.
    pub travel: f64,
    /// When the vehicle reached the surface and the flight, with the turn or without, ended, s.
    pub surfacing: Option<f64>,
}

/// What was flown and computed.
#[derive(Debug, Clone)]
pub struct Turns {
    /// The turns, at increasing speeds.
    pub turned: Vec<Turned>,
    /// What is proved of both axes together; `None` if no bound was found.
    pub coupling: Option<Coupling>,
    /// The text for a terminal.
    pub words: String,
}

/// The two designs, each with its inputs: of pitch or depth, and of heading.
#[derive(Debug, Clone, Copy)]
pub struct Both<'a> {
    /// The design of pitch or depth.
    pub level: (&'a Inputs, &'a Stored),
    /// The design of heading.
    pub heading: (&'a Inputs, &'a Stored),
}

impl<'a> Both<'a> {
    fn turning(&self) -> Result<Turning<'a>, Error> {
        let (inputs, stored) = self.level;
        let designs = [&stored.controller, &self.heading.1.controller];
        Ok(Turning::new(&inputs.whole, inputs.design.level(), designs)?)
    }

    /// What each axis is called.
    fn names(&self) -> [String; 2] {
        [self.level.1, self.heading.1].map(|stored| stored.controller.steered())
    }
}

/// Simulates a turn \[rad\] at several speeds in a steady current and a sea, in six degrees of freedom, while the other
/// axis makes the step of its default flight, and once on the ramp of speed of that; bounds what turns couple. Writes a
/// record and a plot of this to `directory`, and the certificates of the bounds.
///
/// # Errors
/// [`Error::NoCommonSpeed`], [`Error::Flight`], [`Error::Plot`].
pub fn run(both: Both<'_>, turn: f64, water: Around<'_>, directory: &Path) -> Result<Turns, Error> {
    let (inputs, stored) = both.level;
    let speeds = common(both);
    if speeds[0] > speeds[SPEEDS - 1] {
        let [one, other] = [inputs, both.heading.0].map(|inputs| inputs.design.source());
        return Err(Error::NoCommonSpeed { one, other });
    }
    let each = in_parallel(speeds.iter(), |speed| at(both, *speed, turn, water));
    let turned: Vec<Turned> = each.into_iter().collect::<Result<_, Error>>()?;
    let flight = fly(both, &flown(both, None, turn), water)?;
    let record = record(both, &flight.rows, water.1.is_some());
    let title = format!(
        "{}, {} and {}: in six degrees of freedom{}",
        inputs.vehicle.name,
        inputs.design.source(),
        both.heading.0.design.source(),
        at_sea(water)
    );
    let svg = draw(&directory.join("turn.svg"), &title, &panels(&record, &inputs.whole.actuators))?;
    let mut files = Files::default();
    files.add(directory.join("turn.svg"), svg);
    files.add(directory.join("turn.csv"), record.csv());
    let coupling = coupling(&both.turning()?)?;
    for (axis, name) in CERTIFICATES.iter().enumerate() {
        let path = directory.join(name);
        match &coupling {
            Some(found) => files.add(path.clone(), text(&found.axes[axis].certificate, &path)?),
            None => files.remove(path),
        }
    }
    files.save(directory)?;
    let names = both.names();
    let coupled = coupling.as_ref().map(|coupling| coupling.words(names.each_ref().map(String::as_str)));
    let words = words(&turned, (turn, water), (&stored.manoeuvre, flight.surfacing), coupled, directory);
    Ok(Turns { turned, coupling, words })
}

/// A steady current, and a sea beside it.
pub type Around<'a> = (Current, Option<&'a Sea>);

/// Speeds in the range of both designs.
fn common(both: Both<'_>) -> Vec<f64> {
    let [one, other] = [both.level.0, both.heading.0].map(|inputs| &inputs.design);
    let (low, high) = (one.speed_min.max(other.speed_min), one.speed_max.min(other.speed_max));
    (0..SPEEDS).map(|i| low + (high - low) * i as f64 / (SPEEDS - 1) as f64).collect()
}

/// The flight with the steps of both axes: at a constant speed, or on the ramp of the default flight.
fn flown(both: Both<'_>, speed: Option<f64>, turn: f64) -> Manoeuvre {
    let own = &both.level.1.manoeuvre;
    let mut steps = own.steps.clone();
    steps.insert("heading".into(), turn);
    let common = common(both);
    let within = |speed: f64| speed.clamp(common[0], common[common.len() - 1]);
    let ends = speed.map_or([own.speed_from, own.speed_to].map(within), |speed| [speed; 2]);
    let [speed_from, speed_to] = ends;
    let duration = STEP_TIME + FLOWN;
    let ramp_duration = if speed.is_some() { 1.0 } else { own.ramp_duration };
    Manoeuvre {
        steps,
        step_time: STEP_TIME,
        step_end: 2.0 * duration,
        speed_from,
        speed_to,
        ramp_duration,
        duration,
        ..own.clone()
    }
}

fn fly(both: Both<'_>, manoeuvre: &Manoeuvre, water: Around<'_>) -> Result<WholeFlight, Error> {
    let (inputs, stored) = both.level;
    let designs = [&stored.controller, &both.heading.1.controller];
    Ok(fly_whole(&inputs.whole, designs, inputs.design.level(), manoeuvre, water)?)
}

fn at(both: Both<'_>, speed: f64, turn: f64, water: Around<'_>) -> Result<Turned, Error> {
    let WholeFlight { rows: turned, surfacing } = fly(both, &flown(both, Some(speed), turn), water)?;
    let WholeFlight { rows: straight, surfacing: other } = fly(both, &flown(both, Some(speed), 0.0), water)?;
    let surfacing = surfacing.or(other).map(|surfacing| surfacing.time);
    let start = turned.first().map_or(0.0, |row| row.state.heading);
    let off = |row: &WholeRow| (row.state.heading - start) / turn - 1.0;
    let late = turned.iter().rposition(|row| off(row).abs() > SETTLED);
    let to_the_end = |last: &usize| last + 1 < turned.len() && surfacing.is_none();
    let settling_time = late.filter(to_the_end).map(|last| turned[last].time - STEP_TIME);
    let pairs = || turned.iter().zip(&straight);
    let most = |of: &dyn Fn(&WholeRow, &WholeRow) -> f64| pairs().map(|(a, b)| of(a, b)).fold(0.0, f64::max);
    let own = |name: &String| both.level.0.whole.actuators.iter().position(|one| one.name == *name);
    let places: Vec<usize> =
        both.heading.1.controller.actuators.iter().filter_map(|one| own(&one.name)).collect();
    let moved = |pair: &[WholeRow]| -> f64 {
        let by = |place: &usize| (pair[1].commands[*place] - pair[0].commands[*place]).abs();
        places.iter().map(|place| by(place) / both.level.0.whole.actuators[*place].reach()).sum()
    };
    let (stable_to, fastest) = stable(both, speed)?;
    Ok(Turned {
        speed,
        settling_time,
        overshoot: turned.iter().map(off).fold(0.0, f64::max),
        depth_by_turn: most(&|a, b| (a.state.depth - b.state.depth).abs()),
        speed_by_turn: most(&|a, b| b.state.motion.u - a.state.motion.u),
        roll: most(&|a, _| a.state.motion.phi.abs()),
        travel: turned.windows(2).map(moved).sum(),
        stable_to,
        fastest,
        surfacing,
    })
}

/// Up to which rate of turn the linear loop is stable, and the largest rate of the reference, at a speed.
fn stable(both: Both<'_>, speed: f64) -> Result<(f64, f64), Error> {
    let turning = both.turning()?;
    let fastest = turning.fastest(speed);
    let is_stable = |rate: f64| -> Result<bool, Error> {
        Ok(largest_real_part(&turning, speed, rate)?.is_some_and(|largest| largest < 0.0))
    };
    let mut stable_to = f64::NAN;
    for step in 0..=RATES {
        let rate = fastest * f64::from(step) / f64::from(RATES);
        if !(is_stable(rate)? && is_stable(-rate)?) {
            break;
        }
        stable_to = rate;
    }
    Ok((stable_to, fastest))
}

/// The number of rates to each side at which the loop is checked, besides straight flight.
const RATES: u32 = 5;

/// The record of a flight; its columns are named as those of `flight.csv`. At sea there are also the elevation, the
/// velocity of the water and the readings.
fn record(both: Both<'_>, flight: &[WholeRow], is_at_sea: bool) -> Record {
    let mut columns: Vec<(String, Vec<f64>)> = vec![];
    let mut add = |heading: String, of: &dyn Fn(&WholeRow) -> f64| {
        columns.push((heading, flight.iter().map(of).collect()));
    };
    add("time [s]".into(), &|row| row.time);
    add("pitch [rad]".into(), &|row| row.state.motion.theta);
    add("roll [rad]".into(), &|row| row.state.motion.phi);
    add("heading [rad]".into(), &|row| row.state.heading);
    add("speed [m/s]".into(), &|row| row.state.motion.u);
    add("sway [m/s]".into(), &|row| row.state.motion.v);
    add("heave [m/s]".into(), &|row| row.state.motion.w);
    add("depth [m]".into(), &|row| row.state.depth);
    add("north [m]".into(), &|row| row.state.x);
    add("east [m]".into(), &|row| row.state.east);
    for (axis, (_, stored)) in [both.level, both.heading].into_iter().enumerate() {
        let design = &stored.controller;
        for (place, (signal, reference)) in design.references().enumerate() {
            // The reference of the speed is that of both.
            if design.has_reference(place) && (axis == 0 || place != SPEED) {
                add(format!("{}_used [{}]", reference.name, signal.unit), &|row| row.used[axis][place]);
            }
        }
    }
    for (place, actuator) in both.level.0.whole.actuators.iter().enumerate() {
        let taken = |row: &WholeRow| actuator.taken(row.commands[place]).0;
        add(format!("{} [{}]", actuator.name, actuator.taken_unit()), &taken);
    }
    if is_at_sea {
        add("wave_elevation [m]".into(), &|row| row.elevation);
        add("current_north [m/s]".into(), &|row| row.water.horizontal);
        add("current_east [m/s]".into(), &|row| row.water.east);
        add("current_vertical [m/s]".into(), &|row| row.water.vertical);
        for (axis, (_, stored)) in [both.level, both.heading].into_iter().enumerate() {
            for (place, signal) in stored.controller.signals.iter().enumerate() {
                // The sensor of the speed is that of both.
                if axis == 0 || place != SPEED {
                    add(format!("{}_read [{}]", signal.name, signal.unit), &|row| row.read[axis][place]);
                }
            }
        }
    }
    Record::new(columns)
}

/// What a flight in a sea is called.
fn at_sea((_, sea): Around<'_>) -> &'static str {
    if sea.is_some() { ", at sea" } else { "" }
}

fn words(
    turned: &[Turned],
    (turn, water): (f64, Around<'_>),
    (manoeuvre, surfacing): (&Manoeuvre, Option<Surfacing>),
    coupled: Option<String>,
    directory: &Path,
) -> String {
    let steps: Vec<String> = manoeuvre.steps.keys().cloned().collect();
    let mut out = early_end("the flight on the ramp of speed", surfacing);
    for one in turned {
        if let Some(time) = one.surfacing {
            out += &format!(
                "At {:.2} m/s the vehicle reaches the surface at {time:.2} s; the figures are of the flight up to \
                 there.\n",
                one.speed
            );
        }
    }
    out += &format!(
        "Turns by {} deg in six degrees of freedom{}, each with the default step of {}\n\n\
         \x20 speed   settled (2 %)   overshoot   depth moved   speed lost    roll       travel   stable to\n\
         \x20   m/s               s           %             m          m/s     deg   % of reach       deg/s\n",
        auv::rounded(turn.to_degrees()),
        at_sea(water),
        steps.join(" and ")
    );
    for one in turned {
        out += &format!(
            "  {:>5.2}   {:>13}   {:>9}   {:>11}   {:>10}   {:>5}   {:>10}   {:>9}\n",
            one.speed,
            known(one.settling_time.unwrap_or(f64::INFINITY), 2),
            known(100.0 * one.overshoot, 2),
            known(one.depth_by_turn, 4),
            known(one.speed_by_turn, 3),
            known(one.roll.to_degrees(), 2),
            known(100.0 * one.travel, 0),
            known(one.stable_to.to_degrees(), 2)
        );
    }
    let waves = water.1.is_some_and(|sea| sea.waves.is_some());
    let elsewhere = if waves { ", which meets the waves elsewhere" } else { "" };
    out += &format!(
        "\nDepth moved and speed lost are against the same flight without the turn{elsewhere}; travel is the sum of \
         all changes of the commands of heading, back and forth, relative to the largest output of each actuator.\n"
    );
    out += "Stable to: the linear loop of both autopilots in steady turns, at eleven rates up to the limit \
            of the reference.\n";
    out += &match coupled {
        Some(proved) => format!("PROVED: {proved}\n"),
        None => "Nothing is proved of both axes together in turns.\n".to_owned(),
    };
    out + &format!("Record and plot: {}\n", directory.join("{turn.csv,turn.svg}").display())
}
