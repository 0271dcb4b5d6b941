//! One flight of a campaign.

use crate::plan::{Drawn, Plan};
use signals::{PITCH, SPEED};
use squid_design::uncertain::gradients::perturbed;
use squid_design::uncertain::model::Uncertain;
use squid_flight::error::Error as FlightError;
use squid_flight::flight::{Flight, fly_varied};
use squid_flight::metrics::StepFigures;
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
pub const FIGURES: [(&str, &str); 10] = [
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

/// The figures of a flight without any.
const UNKNOWN: [f64; FIGURES.len()] = [f64::NAN; FIGURES.len()];

/// What is drawn beside the uncertain numbers, with units.
pub const DRAWN: [(&str, &str); 3] = [("speed_from", "m/s"), ("speed_to", "m/s"), ("pitch_step", "rad")];

/// A row of the results.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// The number of the flight.
    pub flight: u64,
    /// How it ended.
    pub outcome: Outcome,
    /// As [`DRAWN`], then each uncertain number in its unit.
    pub drawn: Vec<f64>,
    /// As [`FIGURES`].
    pub figures: [f64; FIGURES.len()],
}

impl Plan<'_> {
    /// Names and units of what is drawn for a row.
    pub fn drawn(&self) -> Vec<(String, &'static str)> {
        let beside = DRAWN.iter().map(|(name, unit)| ((*name).to_owned(), *unit));
        beside.chain(self.uncertain.iter().map(|block| (block.name.clone(), block.unit))).collect()
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
        let Drawn { delta, manoeuvre, .. } = &drawn;
        let values = self.uncertain.iter().zip(delta).map(|(block, d)| block.value + block.half_range * d);
        let beside = [manoeuvre.speed_from, manoeuvre.speed_to, manoeuvre.pitch_step];
        let drawn = beside.into_iter().chain(values).collect();
        Ok((Row { flight: number, outcome, drawn, figures }, flight))
    }

    fn flown(&self, drawn: &Drawn) -> Result<Flight, FlightError> {
        let Drawn { delta, manoeuvre, sea_seed } = drawn;
        let vehicle = perturbed(&self.inputs.vehicle, &self.uncertain, delta);
        let mut gains = vec![1.0; vehicle.actuators.len()];
        for (block, d) in self.uncertain.iter().zip(delta) {
            if let Uncertain::Gain(actuator) = block.uncertain {
                gains[actuator] += block.half_range * d;
            }
        }
        let sea = self.sea.as_ref().map(|sea| Sea { seed: *sea_seed, ..sea.clone() });
        let level = self.inputs.design.level();
        fly_varied(&vehicle, &self.stored.controller, level, manoeuvre, sea.as_ref(), &gains)
    }

    fn judged(&self, flight: &Flight, drawn: &Drawn) -> (Outcome, [f64; FIGURES.len()]) {
        let rows = &flight.rows;
        let limits: Vec<(f64, f64)> = self.inputs.vehicle.actuators.iter().map(|a| (a.min, a.max)).collect();
        let step = (drawn.manoeuvre.step_time, drawn.manoeuvre.pitch_step);
        let mut figures = StepFigures::of(rows, step.0, step.1, &limits);
        if flight.surfacing.is_some() {
            figures = figures.cut_short();
        }
        let rms =
            |place| (rows.iter().map(|row| row.error(place).powi(2)).sum::<f64>() / rows.len() as f64).sqrt();
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
            rms(PITCH),
            rms(SPEED),
            saturated,
        ];
        (outcome, figures)
    }
}
