//! Single flight of a campaign.

use crate::error::Error;
use crate::plan::{Axis, Drawn, Plan};
use squid_auv::longitudinal::{PITCH, SPEED};
use squid_auv::{Pose, Speed, Surroundings, Vehicle, trim_with};
use squid_design::uncertain::gradients::perturbed;
use squid_design::uncertain::model::Block;
use squid_design::uncertain::vehicle::gains;
use squid_flight::error::Error as FlightError;
use squid_flight::flight::{Flight, Row as Tick, Surfacing, Variations, fly_varied, out_of_water};
use squid_flight::metrics::{StepFigures, rms};
use squid_flight::record::Record;
use squid_flight::sea::Sea;
use squid_flight::whole::{SixDofFlight, fly_six_dof};
use squid_scheduled::Manoeuvre;
use squid_signals::Signal;

/// Largest mean error, relative to the step, over the last tenth of the time after the step; beyond it a flight counts
/// as lost.
const LOST: f64 = 0.1;

/// Outcome of a flight.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Outcome {
    /// Flight that ended as planned, at the reference.
    Flown,
    /// Flight that ended away from the reference, or diverged.
    Lost,
    /// Flight that ended at the surface.
    Surfaced,
    /// Flight that did not start: the actuators cannot hold the vehicle in trim at the initial speed.
    NoTrim,
}

impl Outcome {
    /// All outcomes.
    pub const ALL: [Self; 4] = [Self::Flown, Self::Lost, Self::Surfaced, Self::NoTrim];

    /// Returns the name in the results.
    pub fn word(self) -> &'static str {
        match self {
            Self::Flown => "flown",
            Self::Lost => "lost",
            Self::Surfaced => "surfaced",
            Self::NoTrim => "no_trim",
        }
    }
}

/// First figure of a row, with its unit: the duration of the flight.
pub const TIME: (&str, &str) = ("time", "s");

/// Names and units of the further figures of an axis, in order; `error_rms` is the error of the controlled signal. A
/// figure is NaN if unknown, a time infinite if never reached. See [`Plan::figures`].
const FIGURES: [(&str, &str); 9] = [
    ("overshoot", "1"),
    ("rise_time", "s"),
    ("settling_time", "s"),
    ("steady_error", "1"),
    (SPEED_DEVIATION, "m/s"),
    ("actuator_use", "1"),
    ("error_rms", "rad"),
    (SPEED_ERROR, "m/s"),
    ("saturated", "1"),
];

/// Figures of the speed, given for the first axis only.
const SPEED_DEVIATION: &str = "speed_deviation";
const SPEED_ERROR: &str = "speed_error_rms";

/// Index of the RMS error of the signal controlled by the first axis.
pub const ERROR: usize = 7;

/// Drawn speeds, with units.
const SPEEDS: [(&str, &str); 2] = [("speed_from", "m/s"), ("speed_to", "m/s")];

/// Row of the results.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Number of the flight.
    pub flight: u64,
    /// Outcome of the flight.
    pub outcome: Outcome,
    /// Drawn numbers: the two speeds, the steps, the initial deviations from trim, and the uncertain parameters, in
    /// their units.
    pub drawn: Vec<f64>,
    /// Figures, as in [`Plan::figures`].
    pub figures: Vec<f64>,
}

impl Row {
    /// Returns the largest difference between two rows of a flight, relative to the larger of 1 and the number; 0 if
    /// all bits are equal, infinite if the outcomes differ or a number is missing in one of them.
    pub fn differs_from(&self, other: &Self) -> f64 {
        let numbers = |row: &Self| row.drawn.iter().chain(&row.figures).copied().collect::<Vec<f64>>();
        let (ours, others) = (numbers(self), numbers(other));
        if self.outcome != other.outcome || ours.len() != others.len() {
            return f64::INFINITY;
        }
        let difference = |(a, b): (&f64, &f64)| {
            let relative = (a - b).abs() / a.abs().max(1.0);
            if a.to_bits() == b.to_bits() {
                0.0
            } else if relative.is_nan() {
                f64::INFINITY
            } else {
                // A difference in the sign of zero only counts as the least positive number.
                relative.max(f64::MIN_POSITIVE)
            }
        };
        ours.iter().zip(&others).map(difference).fold(0.0, f64::max)
    }
}

impl Plan<'_> {
    /// Returns the row of a flight in this process.
    ///
    /// # Errors
    /// Errors of [`Plan::fly`].
    pub fn row(&self, number: u64) -> Result<Row, Error> {
        Ok(self.fly(number)?.0)
    }

    /// Returns the row of a flight that was simulated elsewhere, from its ticks and the distance \[m\] at each. A
    /// flight that could not start has no ticks, one that diverged has too few. Ticks after the hull broke the surface
    /// are ignored.
    /// # Errors
    /// All errors of the sea.
    pub fn judge(&self, number: u64, mut rows: Vec<Tick>, distance: &[f64]) -> Result<Row, Error> {
        let drawn = self.draw(number);
        let vehicle = self.vehicle_of(&drawn);
        let water = self.sea_of(&drawn).map(|sea| sea.about(&vehicle)).transpose()?;
        let water = water.unwrap_or_else(|| Surroundings::still(&vehicle.coefficients));
        let clearance = |row: &Tick, x: f64| {
            water.clearance(row.time, &Pose::in_plane(x, row.depth, row.measured(PITCH)))
        };
        let end = rows.iter().zip(distance).position(|(row, x)| out_of_water(clearance(row, *x)));
        let surfacing = end.map(|k| Surfacing { time: rows[k].time, speed: rows[k].measured(SPEED) });
        rows.truncate(end.unwrap_or(rows.len()));
        let sample_time = self.first().stored.controller.sample_time;
        let ticks = (drawn.manoeuvre.duration / sample_time).round() as usize + 1;
        let (outcome, figures) = match (rows.len(), surfacing) {
            (0, None) if self.starts_out_of_water(&vehicle, &drawn) => (Outcome::Surfaced, self.unknown()),
            (0, None) => (Outcome::NoTrim, self.unknown()),
            (0, Some(_)) => (Outcome::Surfaced, self.unknown()),
            (found, None) if found < ticks => (Outcome::Lost, self.unknown()),
            _ => self.evaluate(&[Flight { rows, surfacing, sea: Vec::new() }], &drawn),
        };
        Ok(self.row_of(number, &drawn, outcome, figures))
    }

    /// Returns `true` if a flight could not start because of the waves, although the vehicle has a trim.
    fn starts_out_of_water(&self, vehicle: &Vehicle, drawn: &Drawn) -> bool {
        let (depth, rule) = self.first().inputs.design.level();
        let speed = Speed::Path(drawn.manoeuvre.speed_reference(0.0));
        let sea = self.sea.as_ref().filter(|sea| sea.waves.is_some());
        sea.is_some_and(|sea| trim_with(&vehicle.in_plane(), speed, sea.depth.unwrap_or(depth), rule).is_ok())
    }

    /// Returns names and units of the figures of a row. With several axes, all names but those of the speed start with
    /// the controlled signal; `error_rms`, the error of that signal, always does.
    pub fn figures(&self) -> Vec<(String, &'static str)> {
        let mut all = vec![(TIME.0.to_owned(), TIME.1)];
        for (index, axis) in self.axes.iter().enumerate() {
            let steered = axis.steered_signal();
            for (name, unit) in FIGURES.into_iter().filter(|(name, _)| index == 0 || !is_of_speed(name)) {
                all.push(match name {
                    "error_rms" => (format!("{}_error_rms", steered.name), steered.unit),
                    _ if self.axes.len() == 1 || is_of_speed(name) => (name.to_owned(), unit),
                    _ => (format!("{}_{name}", steered.name), unit),
                });
            }
        }
        all
    }

    /// Returns unknown figures.
    fn unknown(&self) -> Vec<f64> {
        vec![f64::NAN; self.figures().len()]
    }

    /// Returns names and units of the drawn numbers of a row.
    pub fn drawn(&self) -> Vec<(String, &'static str)> {
        let steps = self
            .axes
            .iter()
            .map(|axis| (format!("{}_step", axis.steered_signal().name), axis.steered_signal().unit));
        let speeds_and_steps = SPEEDS.iter().map(|(name, unit)| ((*name).to_owned(), *unit)).chain(steps);
        let starts = self.identity.starts.off();
        let starts = starts.map(|(_, signal)| (format!("{}_off_trim", signal.name), signal.unit));
        speeds_and_steps
            .chain(starts)
            .chain(self.uncertain.iter().map(|block| (block.name.clone(), block.unit)))
            .collect()
    }

    /// Simulates a flight.
    ///
    /// # Errors
    /// Errors in the inputs only; the failure of a vehicle is an [`Outcome`].
    pub fn fly(&self, number: u64) -> Result<(Row, Option<SixDofFlight>), FlightError> {
        let drawn = self.draw(number);
        let (outcome, figures, flight) = match self.simulate(&drawn) {
            Ok(flight) => {
                let (outcome, figures) = self.evaluate(&flight.axes, &drawn);
                (outcome, figures, Some(flight))
            }
            Err(FlightError::Trim { .. }) => (Outcome::NoTrim, self.unknown(), None),
            Err(FlightError::AtTheSurface { .. }) => (Outcome::Surfaced, self.unknown(), None),
            Err(FlightError::Simulation(_) | FlightError::Tick(_)) => (Outcome::Lost, self.unknown(), None),
            Err(reason) => return Err(reason),
        };
        Ok((self.row_of(number, &drawn, outcome, figures), flight))
    }

    fn row_of(&self, flight: u64, drawn: &Drawn, outcome: Outcome, figures: Vec<f64>) -> Row {
        let Manoeuvre { speed_from, speed_to, .. } = drawn.manoeuvre;
        let steps = self.axes.iter().map(|axis| drawn.manoeuvre.step(axis.steered_signal().name));
        let values = self.values(drawn).map(|(_, value)| value);
        let starts = self.identity.starts.off().map(|(index, _)| drawn.off_trim[index]);
        let drawn = [speed_from, speed_to].into_iter().chain(steps).chain(starts).chain(values).collect();
        Row { flight, outcome, drawn, figures }
    }

    /// Returns the uncertain parameters with their values in a flight.
    pub fn values<'p>(&'p self, drawn: &'p Drawn) -> impl Iterator<Item = (&'p Block, f64)> {
        let pairs = self.uncertain.iter().zip(&drawn.delta);
        pairs.map(|(block, d)| (block, block.value + block.half_range * d))
    }

    /// Returns the gain from command to output of each actuator.
    pub fn gains(&self, drawn: &Drawn) -> Vec<f64> {
        gains(self.vehicle.actuators.len(), &self.uncertain, &drawn.delta)
    }

    /// Returns the sea of a flight.
    pub fn sea_of(&self, drawn: &Drawn) -> Option<Sea> {
        self.sea.as_ref().map(|sea| Sea { seed: drawn.sea_seed, ..sea.clone() })
    }

    fn vehicle_of(&self, drawn: &Drawn) -> Vehicle {
        perturbed(self.vehicle, &self.uncertain, &drawn.delta)
    }

    fn simulate(&self, drawn: &Drawn) -> Result<SixDofFlight, FlightError> {
        let (vehicle, gains, sea) = (self.vehicle_of(drawn), self.gains(drawn), self.sea_of(drawn));
        let Axis { inputs, stored, .. } = self.first();
        let level = inputs.design.level();
        let variations =
            Variations { sea: sea.as_ref(), gains: &gains, off_trim: drawn.off_trim, disturbances: &[] };
        if self.axes.len() > 1 {
            let designs: Vec<_> = self.axes.iter().map(|axis| &axis.stored.controller).collect();
            return fly_six_dof(&vehicle, &designs, level, &drawn.manoeuvre, &variations);
        }
        let flight = fly_varied(&vehicle, &stored.controller, level, &drawn.manoeuvre, &variations)?;
        Ok(SixDofFlight { states: Vec::new(), axes: vec![flight], held: Vec::new() })
    }

    /// Returns the record of a flight.
    pub fn record(&self, flight: &SixDofFlight) -> Record {
        let designs: Vec<_> = self
            .axes
            .iter()
            .map(|axis| (&axis.inputs.vehicle.actuators[..], &axis.stored.controller))
            .collect();
        match (&flight.axes[..], &designs[..]) {
            ([alone], [(actuators, design)]) => Record::of(alone, actuators, design),
            _ => Record::of_six_dof(flight, &self.vehicle.actuators, &designs),
        }
    }

    fn evaluate(&self, flights: &[Flight], drawn: &Drawn) -> (Outcome, Vec<f64>) {
        let time = flights.first().and_then(|flight| flight.rows.last()).map_or(0.0, |row| row.time);
        let (mut all, mut outcome) = (vec![time], Outcome::Flown);
        for (index, (axis, flight)) in self.axes.iter().zip(flights).enumerate() {
            let (axis_outcome, figures) = axis.evaluate(flight, &drawn.manoeuvre);
            outcome = outcome.max(axis_outcome);
            let named = FIGURES.iter().zip(figures).filter(|((name, _), _)| index == 0 || !is_of_speed(name));
            all.extend(named.map(|(_, figure)| figure));
        }
        (outcome, all)
    }
}

/// Returns `true` for a figure of the speed.
fn is_of_speed(name: &str) -> bool {
    [SPEED_DEVIATION, SPEED_ERROR].contains(&name)
}

impl Axis<'_> {
    /// Returns the controlled signal.
    pub fn steered_signal(&self) -> &'static Signal {
        &self.inputs.design.interface.signals[self.inputs.design.stepped()]
    }

    fn evaluate(&self, flight: &Flight, manoeuvre: &Manoeuvre) -> (Outcome, [f64; FIGURES.len()]) {
        let (rows, limits, stepped) = (&flight.rows, self.inputs.limits(), self.inputs.design.stepped());
        let step = (manoeuvre.step_time, manoeuvre.step(self.steered_signal().name));
        let figures = StepFigures::of_flight(flight, stepped, step, &limits);
        let at_limit =
            |commands: &[f64]| commands.iter().zip(&limits).any(|(c, (low, high))| c <= low || c >= high);
        let saturated = rows.iter().filter(|row| at_limit(&row.commands)).count() as f64 / rows.len() as f64;
        let outcome = match () {
            () if flight.surfacing.is_some() => Outcome::Surfaced,
            () if figures.steady_error.abs() <= LOST => Outcome::Flown,
            () => Outcome::Lost,
        };
        let StepFigures { overshoot, rise_time, settling_time, steady_error, speed_deviation, actuator_use } =
            figures;
        let figures = [
            overshoot,
            rise_time,
            settling_time,
            steady_error,
            speed_deviation,
            actuator_use,
            rms(rows, stepped),
            rms(rows, SPEED),
            saturated,
        ];
        (outcome, figures)
    }
}
