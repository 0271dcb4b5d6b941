//! Simulations in six degrees of freedom of a vehicle with a design of pitch or depth and one of heading.

use crate::error::Error;
use crate::page::{Chart, Curve, Figure, Key, Part, Section, Table, capital, draw, known};
use crate::record::panels;
use crate::simulate::early_end;
use crate::threads::in_parallel;
use serde::Serialize;
use squid_auv::{Current, State};
use squid_base::files::Files;
use squid_design::check::coupled::frozen::largest_real_part;
use squid_design::check::coupled::gain::{CERTIFICATES, Coupling, coupling};
use squid_design::check::coupled::turn::Turning;
use squid_design::inputs::Inputs;
use squid_design::inputs::together::common_speeds;
use squid_design::store::Stored;
use squid_flight::flight::{Row, Surfacing, TemporaryDisturbance, Variations};
use squid_flight::record::Record;
use squid_flight::sea::Sea;
use squid_flight::whole::{SixDofFlight, fly_six_dof};
use squid_proof::claim::text;
use squid_scheduled::Manoeuvre;
use std::path::Path;

/// Number of speeds.
const SPEEDS: usize = 6;

/// Time of the steps of all axes, and duration of a flight after them (s).
const STEP_TIME: f64 = 10.0;
const FLOWN: f64 = 90.0;

/// Settling band about the commanded heading, relative to the turn.
const SETTLED: f64 = 0.02;

/// Turn at a speed, during the step of the other axis.
#[derive(Debug, Clone, Serialize)]
pub struct Turned {
    /// Speed along the path, m/s.
    pub speed: f64,
    /// Settling time of heading within 2 % of the turn, s; `None` if it does not settle.
    pub settling_time: Option<f64>,
    /// Overshoot of heading, relative to the turn.
    pub overshoot: f64,
    /// Largest difference of depth from the same flight without the turn, m.
    pub depth_by_turn: f64,
    /// Largest loss of speed against the flight without the turn, m/s.
    pub speed_by_turn: f64,
    /// Largest roll, rad.
    pub roll: f64,
    /// Largest rate of a steady turn up to which the linear loop of both autopilots is stable, rad/s, of eleven rates
    /// from the limit of the reference to port to that to starboard.
    pub stable_to: f64,
    /// Limit of the rate of the reference, rad/s.
    pub fastest: f64,
    /// Total variation of the commands of heading during the flight, relative to their reach, sum over all actuators.
    pub travel: f64,
    /// Time at which the vehicle reached the surface and the flight, with or without the turn, ended, s.
    pub surfacing: Option<f64>,
}

/// Results of the simulated turns.
#[derive(Debug, Clone)]
pub struct Turns {
    /// Turns, at increasing speeds.
    pub turned: Vec<Turned>,
    /// Proof of two axes together; `None` if no bound was found, and for more axes.
    pub coupling: Option<Coupling>,
    /// Turn, rad.
    turn: f64,
    /// Record of the flight on the speed ramp.
    record: Record,
    surfacing: Option<Surfacing>,
    is_at_sea: bool,
    has_waves: bool,
}

/// Axes of a vehicle, each with its stored design; one of them controls pitch or depth, and one heading.
#[derive(Debug, Clone, Copy)]
pub struct Axes<'a> {
    all: &'a [(&'a Inputs, &'a Stored)],
    /// Index of the axis of heading; the axis of pitch or depth is the first.
    heading: usize,
}

impl<'a> Axes<'a> {
    /// Returns the axes of an autopilot; `None` if it does not control heading and pitch or depth.
    pub fn of(all: &'a [(&'a Inputs, &'a Stored)]) -> Option<Self> {
        let heading = all.iter().position(|(inputs, _)| inputs.design.tracks("heading").is_some())?;
        (!all[0].0.design.view().is_level_held).then_some(Self { all, heading })
    }

    fn level(&self) -> (&'a Inputs, &'a Stored) {
        self.all[0]
    }

    /// Returns the linear motion in turns under two axes; `None` for more axes, which have no common proof.
    fn turning(&self) -> Result<Option<Turning<'a>>, Error> {
        let [(inputs, level), (_, heading)] = self.all else { return Ok(None) };
        let designs = [&level.controller, &heading.controller];
        Ok(Some(Turning::new(&inputs.six_dof, inputs.design.level(), designs)?))
    }

    /// Returns the record of a flight.
    fn record(&self, flight: &SixDofFlight) -> Record {
        let axes = self.all.iter();
        let axes: Vec<_> =
            axes.map(|(inputs, stored)| (&inputs.vehicle.actuators[..], &stored.controller)).collect();
        Record::of_six_dof(flight, &self.level().0.six_dof.actuators, &axes)
    }

    /// Returns the name of each axis.
    fn names(&self) -> Vec<String> {
        self.all.iter().map(|(_, stored)| stored.controller.steered_signal()).collect()
    }
}

/// Simulates a turn \[rad\] in six degrees of freedom in a steady current and a sea, during the step of the other axis,
/// at several speeds and once on the speed ramp of the default flight; bounds the coupling of the axes in turns.
///
/// # Errors
/// [`Error::Flight`].
pub fn turns(axes: Axes<'_>, turn: f64, water: Around<'_>) -> Result<Turns, Error> {
    let each = in_parallel(common(axes).iter(), |speed| at(axes, *speed, turn, water));
    let turned: Vec<Turned> = each.into_iter().collect::<Result<_, Error>>()?;
    let flight = fly(axes, &flown(axes, None, turn), water)?;
    Ok(Turns {
        turned,
        coupling: axes.turning()?.map(|turning| coupling(&turning)).transpose()?.flatten(),
        turn,
        record: axes.record(&flight),
        surfacing: flight.surfacing(),
        is_at_sea: water.1.is_some(),
        has_waves: water.1.is_some_and(|sea| sea.waves.is_some()),
    })
}

impl Turns {
    /// Writes record and plot of the flight on the speed ramp, and the certificates of both axes, to a directory;
    /// returns the text for a terminal.
    ///
    /// # Errors
    /// [`Error::Plot`]; errors of the files.
    pub fn save(&self, axes: Axes<'_>, directory: &Path) -> Result<String, Error> {
        let inputs = axes.level().0;
        let title = format!(
            "{}, {}: in six degrees of freedom{}",
            inputs.vehicle.name,
            inputs.design.file,
            self.at_sea()
        );
        let panels = panels(&self.record, &inputs.six_dof.actuators);
        let mut files = Files::default();
        files.add(directory.join("turn.svg"), draw(&directory.join("turn.svg"), &title, &panels)?);
        files.add(directory.join("turn.csv"), self.record.csv());
        for (axis, name) in CERTIFICATES.iter().enumerate() {
            let path = directory.join(name);
            match &self.coupling {
                Some(found) => files.add(path.clone(), text(&found.axes[axis].certificate, &path)?),
                None => files.remove(path),
            }
        }
        files.save(directory)?;
        let files = directory.join("{turn.csv,turn.svg}").display().to_string();
        Ok(format!("{}Record and plot: {files}\n", self.text(axes)))
    }

    /// Returns the section of a report.
    pub fn section(&self, axes: Axes<'_>) -> Section {
        let mut table = Table::new(HEAD);
        table.rows = self.turned.iter().map(|one| one.cells().to_vec()).collect();
        let mut text = self.notes();
        text.insert(0, format!("{}. {NOTES}", self.title(axes)));
        let mut parts: Vec<Part> = vec![Part::Table(table)];
        parts.extend(text.into_iter().map(Part::Text));
        parts.push(Part::Text(self.proved(axes)));
        let curve = |name: &str, factor: f64, key: usize| {
            let values = self.record.get("time").into_iter().flatten().zip(self.record.get(name)?);
            Some(Curve { key, points: values.map(|(time, value)| (*time, factor * value)).collect() })
        };
        let deg = 1f64.to_degrees();
        let shown =
            [("heading", "deg", deg), ("roll", "deg", deg), ("speed", "m/s", 1.0), ("depth", "m", 1.0)];
        let mut charts: Vec<Chart> = shown
            .iter()
            .map(|(name, unit, factor)| {
                let reference = curve(&format!("{name}_reference_used"), *factor, 1);
                let curves = reference.into_iter().chain(curve(name, *factor, 0)).collect();
                Chart::over_time("", format!("{name} ({unit})"), curves)
            })
            .collect();
        let track = self.record.get("east").zip(self.record.get("north"));
        let points = track.map(|(east, north)| east.iter().copied().zip(north.iter().copied()).collect());
        charts.push(Chart::from_above(
            "track",
            points.map(|points| Curve { key: 0, points }).into_iter().collect(),
        ));
        let caption = format!(
            "A turn by {} deg at {STEP_TIME} s, together with the other steps, during the speed ramp{}.",
            squid_auv::rounded(self.turn.to_degrees()),
            self.at_sea()
        );
        let keys = vec![Key::nth(0, "flown"), Key::reference("reference")];
        parts.push(Part::Figure(Figure { name: "turn".into(), caption, keys, charts }));
        Section::new("turns", "Turns in six degrees of freedom", parts)
    }

    /// Returns the suffix of the name of a flight at sea; empty in still water.
    fn at_sea(&self) -> &'static str {
        if self.is_at_sea { ", at sea" } else { "" }
    }

    /// Returns the title of the table.
    fn title(&self, axes: Axes<'_>) -> String {
        let all = axes.all.iter().flat_map(|(_, stored)| stored.manoeuvre.steps.keys());
        let steps: Vec<&str> = all.map(String::as_str).filter(|name| *name != "heading").collect();
        format!(
            "Turns by {} deg in six degrees of freedom{}, each with the default step of {}",
            squid_auv::rounded(self.turn.to_degrees()),
            self.at_sea(),
            steps.join(" and ")
        )
    }

    /// Returns notes on flights that end at the surface, and on the waves.
    fn notes(&self) -> Vec<String> {
        let early = early_end("the simulation with the speed ramp", self.surfacing);
        let mut out: Vec<String> = early.iter().map(|found| capital(&found.why)).collect();
        out.extend(self.turned.iter().filter_map(|one| {
            Some(format!(
                "At {:.2} m/s the vehicle reaches the surface at {:.2} s; the figures apply to the simulation up to \
                    this time.",
                one.speed, one.surfacing?
            ))
        }));
        let waves = "The simulation without the turn encounters the waves at other positions.".to_owned();
        out.extend(self.has_waves.then_some(waves));
        out
    }

    /// Returns the text on the proof of the axes together.
    fn proved(&self, axes: Axes<'_>) -> String {
        let names = axes.names();
        match (&self.coupling, &names[..]) {
            (Some(found), [level, heading]) => format!("PROVED: {}.", found.claim([level, heading])),
            (_, [_, _]) => "Nothing is proved about the axes together in turns.".to_owned(),
            _ => "For more than two axes nothing is proved about turns, and no largest stable turn rate is computed."
                .to_owned(),
        }
    }

    fn text(&self, axes: Axes<'_>) -> String {
        let mut out: String = self.notes().iter().map(|line| format!("{line}\n")).collect();
        out += &format!(
            "{}\n\n\
             \x20 speed   settled (2 %)   overshoot   depth moved   speed lost    roll       travel   stable to\n\
             \x20   m/s               s           %             m          m/s     deg   % of reach       deg/s\n",
            self.title(axes)
        );
        for one in &self.turned {
            let [speed, settled, overshoot, depth, lost, roll, travel, stable] = one.cells();
            out += &format!(
                "  {speed:>5}   {settled:>13}   {overshoot:>9}   {depth:>11}   {lost:>10}   {roll:>5}   {travel:>10}   \
                 {stable:>9}\n"
            );
        }
        out + &format!("\n{NOTES}\n{}\n", self.proved(axes))
    }
}

impl Turned {
    /// Returns the row of the table, in the units of its head.
    fn cells(&self) -> [String; 8] {
        [
            format!("{:.2}", self.speed),
            known(self.settling_time.unwrap_or(f64::INFINITY), 2),
            known(100.0 * self.overshoot, 2),
            known(self.depth_by_turn, 4),
            known(self.speed_by_turn, 3),
            known(self.roll.to_degrees(), 2),
            known(100.0 * self.travel, 0),
            known(self.stable_to.to_degrees(), 2),
        ]
    }
}

/// Head of the table of turns.
const HEAD: [&str; 8] = [
    "speed m/s",
    "settled (2 %) s",
    "overshoot %",
    "depth moved m",
    "speed lost m/s",
    "roll deg",
    "travel % of reach",
    "stable to deg/s",
];

/// Explanation of the columns.
const NOTES: &str = "Depth moved and speed lost are relative to the same simulation without the turn; travel is the \
                     sum of the magnitudes of all changes of the heading commands, relative to the largest output of \
                     each actuator. Stable to: the linear loop of both autopilots in steady turns, at eleven rates \
                     up to the limit of the reference.";

/// Steady current, and an optional sea.
pub type Around<'a> = (Current, Option<&'a Sea>);

/// Returns speeds in the common range of all designs.
fn common(axes: Axes<'_>) -> Vec<f64> {
    let [low, high] = common_speeds(axes.all.iter().map(|(inputs, _)| &inputs.design));
    (0..SPEEDS).map(|i| low + (high - low) * i as f64 / (SPEEDS - 1) as f64).collect()
}

/// Returns the manoeuvre with the steps of all axes: at a constant speed, or on the speed ramp of the default flight.
fn flown(axes: Axes<'_>, speed: Option<f64>, turn: f64) -> Manoeuvre {
    let own = &axes.level().1.manoeuvre;
    let mut steps = own.steps.clone();
    axes.all.iter().for_each(|(_, stored)| steps.extend(stored.manoeuvre.steps.clone()));
    steps.insert("heading".into(), turn);
    let common = common(axes);
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

fn fly(axes: Axes<'_>, manoeuvre: &Manoeuvre, (current, sea): Around<'_>) -> Result<SixDofFlight, Error> {
    let (inputs, _) = axes.level();
    let designs: Vec<_> = axes.all.iter().map(|(_, stored)| &stored.controller).collect();
    let varied =
        Variations { sea, disturbances: &[TemporaryDisturbance::steady(current)], ..Variations::default() };
    Ok(fly_six_dof(&inputs.six_dof, &designs, inputs.design.level(), manoeuvre, &varied)?)
}

fn at(axes: Axes<'_>, speed: f64, turn: f64, water: Around<'_>) -> Result<Turned, Error> {
    let turning = fly(axes, &flown(axes, Some(speed), turn), water)?;
    let other = fly(axes, &flown(axes, Some(speed), 0.0), water)?;
    let surfacing = turning.surfacing().or(other.surfacing()).map(|surfacing| surfacing.time);
    let (turned, straight, steered) = (&turning.states, &other.states, &turning.axes[axes.heading].rows);
    let start = turned.first().map_or(0.0, |state| state.heading);
    let off = |state: &State| (state.heading - start) / turn - 1.0;
    let late = turned.iter().rposition(|state| off(state).abs() > SETTLED);
    let to_the_end = |last: &usize| last + 1 < turned.len() && surfacing.is_none();
    let settling_time = late.filter(to_the_end).map(|last| steered[last].time - STEP_TIME);
    let pairs = || turned.iter().zip(straight);
    let most = |of: &dyn Fn(&State, &State) -> f64| pairs().map(|(a, b)| of(a, b)).fold(0.0, f64::max);
    let actuators = &axes.all[axes.heading].0.vehicle.actuators;
    let moved = |pair: &[Row]| -> f64 {
        let commands = pair[0].commands.iter().zip(&pair[1].commands).zip(actuators);
        commands.map(|((from, to), actuator)| (to - from).abs() / actuator.reach()).sum()
    };
    let (stable_to, fastest) = stable(axes, speed)?;
    Ok(Turned {
        speed,
        settling_time,
        overshoot: turned.iter().map(off).fold(0.0, f64::max),
        depth_by_turn: most(&|a, b| (a.depth - b.depth).abs()),
        speed_by_turn: most(&|a, b| b.motion.u - a.motion.u),
        roll: most(&|a, _| a.motion.phi.abs()),
        travel: steered.windows(2).map(moved).sum(),
        stable_to,
        fastest,
        surfacing,
    })
}

/// Returns the largest rate of turn up to which the linear loop is stable at a speed, and the largest rate of the
/// reference.
fn stable(axes: Axes<'_>, speed: f64) -> Result<(f64, f64), Error> {
    let Some(turning) = axes.turning()? else { return Ok((f64::NAN, f64::NAN)) };
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

/// Number of rates to each side at which the loop is checked, in addition to straight flight.
const RATES: u32 = 5;
