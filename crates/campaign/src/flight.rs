//! One flight of a campaign.

use crate::error::Error;
use crate::plan::{Drawn, Plan};
use auv::{Speed, Surroundings, Vehicle, trim_with};
use scheduled::Manoeuvre;
use signals::{DEPTH, PITCH, SIGNALS, SPEED};
use squid_design::uncertain::gradients::perturbed;
use squid_design::uncertain::model::Block;
use squid_design::uncertain::vehicle::gains;
use squid_flight::error::Error as FlightError;
use squid_flight::flight::{Flight, Row as Tick, Surfacing, Variations, fly_varied, out_of_water};
use squid_flight::metrics::{StepFigures, rms};
use squid_flight::sea::Sea;

/// A flight whose mean pitch error over the last tenth of the time after the step is above this part of the step is
/// lost.
const LOST: f64 = 0.1;

/// How a flight ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Outcome {
    /// At its time, with the pitch that was asked for.
    Flown,
    /// At its time, with another pitch, or before it, because numbers grew beyond all bounds.
    Lost,
    /// At the surface.
    Surfaced,
    /// It never began: the actuators of that vehicle do not hold it in trim at the first speed.
    NoTrim,
}

impl Outcome {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Flown, Self::Lost, Self::Surfaced, Self::NoTrim];

    /// Its word in the results.
    pub fn word(self) -> &'static str {
        match self {
            Self::Flown => "flown",
            Self::Lost => "lost",
            Self::Surfaced => "surfaced",
            Self::NoTrim => "no_trim",
        }
    }
}

/// Names and units of the figures of a row, in their order; NaN where one is not known, infinity where it never comes.
/// See [`Plan::figures`].
const FIGURES: [(&str, &str); FIGURES_OF_A_ROW] = [
    ("time", "s"),
    ("overshoot", "1"),
    ("rise_time", "s"),
    ("settling_time", "s"),
    ("steady_error", "1"),
    ("speed_deviation", "m/s"),
    ("actuator_use", "1"),
    ("pitch_error_rms", "rad"),
    ("speed_error_rms", "m/s"),
    ("saturated", "1"),
];

/// How many figures a row has.
pub const FIGURES_OF_A_ROW: usize = 10;

/// The place of the error of the output that steps.
pub const ERROR: usize = 7;

/// The figures of a flight without any.
const UNKNOWN: [f64; FIGURES_OF_A_ROW] = [f64::NAN; FIGURES_OF_A_ROW];

/// What is drawn of the speed, with units.
const SPEEDS: [(&str, &str); 2] = [("speed_from", "m/s"), ("speed_to", "m/s")];

/// A row of the results.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// The number of the flight.
    pub flight: u64,
    /// How it ended.
    pub outcome: Outcome,
    /// The two speeds, the step, then how far off its trim the flight began in each signal that was, then each
    /// uncertain number in its unit.
    pub drawn: Vec<f64>,
    /// As [`Plan::figures`].
    pub figures: [f64; FIGURES_OF_A_ROW],
}

impl Row {
    /// The largest difference of two rows of a flight, in parts of the larger of 1 and the number; 0 where they are the
    /// same to the bit, infinite where they end in other ways or one has a number that the other has not.
    pub fn differs_from(&self, other: &Self) -> f64 {
        let numbers = |row: &Self| row.drawn.iter().chain(&row.figures).copied().collect::<Vec<f64>>();
        let (own, others) = (numbers(self), numbers(other));
        if self.outcome != other.outcome || own.len() != others.len() {
            return f64::INFINITY;
        }
        let difference = |(a, b): (&f64, &f64)| {
            let off = (a - b).abs() / a.abs().max(1.0);
            if a.to_bits() == b.to_bits() {
                0.0
            } else if off.is_nan() {
                f64::INFINITY
            } else {
                // The least number above 0 where only the sign of a zero differs.
                off.max(f64::MIN_POSITIVE)
            }
        };
        own.iter().zip(&others).map(difference).fold(0.0, f64::max)
    }
}

impl Plan<'_> {
    /// The row of a flight in this process.
    ///
    /// # Errors
    /// As [`Plan::fly`].
    pub fn row(&self, number: u64) -> Result<Row, Error> {
        Ok(self.fly(number)?.0)
    }

    /// The row of a flight that something else flew with the numbers drawn for it, by its ticks and the distance \[m\]
    /// at each: none where it could not begin, and fewer than asked for where its numbers grew beyond all bounds. What
    /// it did after it broke the surface is left out.
    ///
    /// # Errors
    /// Those of the sea.
    pub fn judge(&self, number: u64, mut rows: Vec<Tick>, distance: &[f64]) -> Result<Row, Error> {
        let drawn = self.draw(number);
        let vehicle = self.vehicle_of(&drawn);
        let water = self.sea_of(&drawn).map(|sea| sea.about(&vehicle)).transpose()?;
        let water = water.unwrap_or_else(|| Surroundings::still(&vehicle.coefficients));
        let clearance = |row: &Tick, x: f64| water.clearance(row.time, x, row.depth, row.measured(PITCH));
        let end = rows.iter().zip(distance).position(|(row, x)| out_of_water(clearance(row, *x)));
        let surfacing = end.map(|k| Surfacing { time: rows[k].time, speed: rows[k].measured(SPEED) });
        rows.truncate(end.unwrap_or(rows.len()));
        let ticks = (drawn.manoeuvre.duration / self.stored.controller.sample_time).round() as usize + 1;
        let (outcome, figures) = match (rows.len(), surfacing) {
            (0, None) if self.begins_out_of_waves(&vehicle, &drawn) => (Outcome::Surfaced, UNKNOWN),
            (0, None) => (Outcome::NoTrim, UNKNOWN),
            (0, Some(_)) => (Outcome::Surfaced, UNKNOWN),
            (found, None) if found < ticks => (Outcome::Lost, UNKNOWN),
            _ => self.judged(&Flight { rows, surfacing, sea: Vec::new() }, &drawn),
        };
        Ok(self.row_of(number, &drawn, outcome, figures))
    }

    /// Of a flight that could not begin: whether that was for the waves, since the vehicle has a trim.
    fn begins_out_of_waves(&self, vehicle: &Vehicle, drawn: &Drawn) -> bool {
        let (depth, rule) = self.inputs.design.level();
        let speed = Speed::Path(drawn.manoeuvre.speed_reference(0.0));
        let sea = self.sea.as_ref().filter(|sea| sea.waves.is_some());
        sea.is_some_and(|sea| trim_with(vehicle, speed, sea.depth.unwrap_or(depth), rule).is_ok())
    }

    /// The place in [`SIGNALS`] of the output that steps.
    pub fn stepped(&self) -> usize {
        self.inputs.design.stepped()
    }

    /// Names and units of the figures of a row: the error is that of the output that steps.
    pub fn figures(&self) -> [(&'static str, &'static str); FIGURES_OF_A_ROW] {
        let mut figures = FIGURES;
        if self.stepped() == DEPTH {
            figures[ERROR] = ("depth_error_rms", "m");
        }
        figures
    }

    /// Names and units of what is drawn for a row.
    pub fn drawn(&self) -> Vec<(String, &'static str)> {
        let stepped = &SIGNALS[self.stepped()];
        let step = (format!("{}_step", stepped.name), stepped.unit);
        let beside = SPEEDS.iter().map(|(name, unit)| ((*name).to_owned(), *unit)).chain([step]);
        let starts = self.identity.starts.off();
        let starts = starts.map(|(_, signal)| (format!("{}_off_trim", signal.name), signal.unit));
        beside
            .chain(starts)
            .chain(self.uncertain.iter().map(|block| (block.name.clone(), block.unit)))
            .collect()
    }

    /// Flies a flight.
    ///
    /// # Errors
    /// That of a flight that cannot be flown at all; how a vehicle fails is an [`Outcome`].
    pub fn fly(&self, number: u64) -> Result<(Row, Option<Flight>), FlightError> {
        let drawn = self.draw(number);
        let (outcome, figures, flight) = match self.flown(&drawn) {
            Ok(flight) => {
                let (outcome, figures) = self.judged(&flight, &drawn);
                (outcome, figures, Some(flight))
            }
            Err(FlightError::Trim { .. }) => (Outcome::NoTrim, UNKNOWN, None),
            Err(FlightError::AtTheSurface { .. }) => (Outcome::Surfaced, UNKNOWN, None),
            Err(FlightError::Simulation(_) | FlightError::Tick(_)) => (Outcome::Lost, UNKNOWN, None),
            Err(reason) => return Err(reason),
        };
        Ok((self.row_of(number, &drawn, outcome, figures), flight))
    }

    fn row_of(&self, flight: u64, drawn: &Drawn, outcome: Outcome, figures: [f64; FIGURES_OF_A_ROW]) -> Row {
        let Manoeuvre { speed_from, speed_to, .. } = drawn.manoeuvre;
        let step = drawn.manoeuvre.steps()[self.stepped()];
        let values = self.values(drawn).map(|(_, value)| value);
        let starts = self.identity.starts.off().map(|(place, _)| drawn.off_trim[place]);
        let drawn = [speed_from, speed_to, step].into_iter().chain(starts).chain(values).collect();
        Row { flight, outcome, drawn, figures }
    }

    /// What is uncertain, with its value of a flight.
    pub fn values<'p>(&'p self, drawn: &'p Drawn) -> impl Iterator<Item = (&'p Block, f64)> {
        let pairs = self.uncertain.iter().zip(&drawn.delta);
        pairs.map(|(block, d)| (block, block.value + block.half_range * d))
    }

    /// What each actuator puts out, in multiples of what it is commanded.
    pub fn gains(&self, drawn: &Drawn) -> Vec<f64> {
        gains(self.inputs.vehicle.actuators.len(), &self.uncertain, &drawn.delta)
    }

    /// The sea of a flight.
    pub fn sea_of(&self, drawn: &Drawn) -> Option<Sea> {
        self.sea.as_ref().map(|sea| Sea { seed: drawn.sea_seed, ..sea.clone() })
    }

    fn vehicle_of(&self, drawn: &Drawn) -> Vehicle {
        perturbed(&self.inputs.vehicle, &self.uncertain, &drawn.delta)
    }

    fn flown(&self, drawn: &Drawn) -> Result<Flight, FlightError> {
        let (vehicle, gains, sea) = (self.vehicle_of(drawn), self.gains(drawn), self.sea_of(drawn));
        let level = self.inputs.design.level();
        let variations = Variations { sea: sea.as_ref(), gains: &gains, off_trim: drawn.off_trim };
        fly_varied(&vehicle, &self.stored.controller, level, &drawn.manoeuvre, &variations)
    }

    fn judged(&self, flight: &Flight, drawn: &Drawn) -> (Outcome, [f64; FIGURES_OF_A_ROW]) {
        let rows = &flight.rows;
        let limits: Vec<(f64, f64)> = self.inputs.vehicle.actuators.iter().map(|a| (a.min, a.max)).collect();
        let stepped = self.stepped();
        let step = (drawn.manoeuvre.step_time, drawn.manoeuvre.steps()[stepped]);
        let figures = StepFigures::of_flight(flight, stepped, step, &limits);
        let at_limit =
            |commands: &[f64]| commands.iter().zip(&limits).any(|(c, (low, high))| c <= low || c >= high);
        let saturated = rows.iter().filter(|row| at_limit(&row.commands)).count() as f64 / rows.len() as f64;
        let time = rows.last().map_or(0.0, |row| row.time);
        let outcome = match () {
            () if flight.surfacing.is_some() => Outcome::Surfaced,
            () if figures.steady_error.abs() <= LOST => Outcome::Flown,
            () => Outcome::Lost,
        };
        let StepFigures { overshoot, rise_time, settling_time, steady_error, speed_deviation, actuator_use } =
            figures;
        let figures = [
            time,
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
