//! What a campaign is made of, and what is drawn for each of its flights.

use crate::error::Error;
use crate::starts::Starts;
use auv::{Parameter, Speed, trim_with};
use rand::rngs::ChaCha8Rng;
use rand::{Rng, SeedableRng};
use scheduled::Manoeuvre;
use serde::{Deserialize, Serialize};
use signals::Each;
use sobol_burley::NUM_DIMENSIONS;
use squid_design::inputs::Inputs;
use squid_design::store::Stored;
use squid_design::uncertain::model::{Block, Uncertain};
use squid_design::uncertain::trim::blocks;
use squid_flight::sea::Sea;

/// Where in the box of the declared uncertainty the vehicles of a campaign are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Points {
    /// Anywhere, all places alike.
    Uniform,
    /// Anywhere, more evenly: on a Sobol sequence, scrambled by the seed, which has speeds and steps, too.
    Sobol,
    /// At its corners.
    Corners,
}

/// Points in a sequence of the library.
const SOBOL_LENGTH: u64 = 1 << 16;

/// What tells a campaign from every other: flights of two campaigns with the same identity are the same.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Identity {
    /// Of the vehicle file, SHA-256.
    pub vehicle: String,
    /// Of the design file, SHA-256.
    pub design: String,
    /// The text of the sea's file.
    pub sea: Option<String>,
    /// Of all that is drawn.
    pub seed: u64,
    /// Where the vehicles are.
    pub points: Points,
    /// How far off their trim its flights may begin.
    #[serde(default, skip_serializing_if = "Starts::in_trim")]
    pub starts: Starts,
    /// Whether the FMUs of the design flew it.
    pub fmus: bool,
    /// The version of squid.
    pub version: String,
}

impl Identity {
    /// The first part that differs, in words.
    pub fn differs_from(&self, other: &Self) -> Option<&'static str> {
        let parts = [
            ("the vehicle file", self.vehicle != other.vehicle),
            ("the design file", self.design != other.design),
            ("the sea", self.sea != other.sea),
            ("the seed", self.seed != other.seed),
            ("where in the uncertainty it flies", self.points != other.points),
            ("how far off trim flights begin", self.starts != other.starts),
            ("what flies, squid or FMUs,", self.fmus != other.fmus),
            ("the version of squid", self.version != other.version),
        ];
        parts.into_iter().find(|(_, differs)| *differs).map(|(what, _)| what)
    }
}

/// A campaign.
#[derive(Debug)]
pub struct Plan<'a> {
    /// The vehicle and its design.
    pub inputs: &'a Inputs,
    /// The finished design.
    pub stored: &'a Stored,
    /// The sea, drawn anew for each flight.
    pub sea: Option<Sea>,
    /// What tells it from others.
    pub identity: Identity,
    /// What is uncertain.
    pub uncertain: Vec<Block>,
}

/// What is drawn for a flight.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawn {
    /// Of each uncertain number, within \[-1, 1\] of its range.
    pub delta: Vec<f64>,
    /// The default manoeuvre between two speeds of its range, its step up or down.
    pub manoeuvre: Manoeuvre,
    /// How far off its trim the flight begins in each signal, SI.
    pub off_trim: Each<f64>,
    /// Of the waves, the current and the errors of sensors; at most [`i32::MAX`], as FMUs have it.
    pub sea_seed: u64,
}

impl<'a> Plan<'a> {
    /// A campaign of a design, in a sea by the text of its file.
    ///
    /// # Errors
    /// [`Error::Flight`]: waves, and a vehicle without size; [`Error::Design`].
    pub fn new(
        inputs: &'a Inputs,
        stored: &'a Stored,
        sea: Option<(Sea, String)>,
        seed: u64,
        points: Points,
    ) -> Result<Self, Error> {
        let (sea, text) = sea.unzip();
        sea.iter().try_for_each(|sea| sea.check(&inputs.vehicle))?;
        let (depth, rule) = inputs.design.level();
        let speed = stored.manoeuvre.speed_from;
        let uncertain = if !inputs.is_uncertain() {
            Vec::new()
        } else {
            let trim = trim_with(&inputs.vehicle, Speed::Path(speed), depth, rule)
                .map_err(|reason| squid_flight::error::Error::Trim { speed, reason })?;
            blocks(inputs, &trim, &[]).map_err(squid_design::error::Error::from)?
        };
        let identity = Identity {
            vehicle: inputs.hashes.vehicle_sha256.clone(),
            design: inputs.hashes.design_sha256.clone(),
            sea: text,
            seed,
            points,
            starts: Starts::default(),
            fmus: false,
            version: env!("CARGO_PKG_VERSION").to_owned(),
        };
        Ok(Self { inputs, stored, sea, identity, uncertain })
    }

    /// The same campaign with flights that begin off their trim.
    #[must_use]
    pub fn starting(mut self, starts: Starts) -> Self {
        self.identity.starts = starts;
        self
    }

    /// The same campaign, flown by the FMUs of the design.
    ///
    /// # Errors
    /// [`Error::NotOfFmus`]: FMUs begin in trim, have usual waves and a steady current, no parameters of actuators, and
    /// no thrust behind a curve to multiply.
    pub fn by_fmus(mut self) -> Result<Self, Error> {
        let effect =
            |block: &&Block| matches!(block.uncertain, Uncertain::Parameter(Parameter::Effect { .. }));
        let curve = |block: &&Block| match block.uncertain {
            Uncertain::Gain(actuator) => self.inputs.vehicle.actuators[actuator].curve.is_some(),
            Uncertain::Parameter(_) => false,
        };
        let uncertain = || self.uncertain.iter();
        let beyond = self.sea.as_ref().and_then(Sea::beyond_steady);
        let what = match (beyond, uncertain().find(effect), uncertain().find(curve)) {
            _ if !self.identity.starts.in_trim() => "starts off the trim".to_owned(),
            (Some(beyond), ..) => beyond,
            (_, Some(block), _) => {
                format!("an uncertain {}: it is no parameter of the vehicle's FMU", block.name)
            }
            (.., Some(block)) => {
                format!("an uncertain {}: the vehicle's FMU takes no thrust of it", block.name)
            }
            _ => {
                self.identity.fmus = true;
                return Ok(self);
            }
        };
        Err(Error::NotOfFmus { what })
    }

    /// What is drawn for a flight: by its number and the seed alone, whatever flies before, after or beside it.
    pub fn draw(&self, flight: u64) -> Drawn {
        let stream = |number| {
            let mut numbers = ChaCha8Rng::seed_from_u64(self.identity.seed);
            numbers.set_stream(number);
            numbers
        };
        let mut numbers = stream(flight);
        // Beyond its length another sequence begins, and beyond its dimensions a block of another.
        let sequence = stream(flight / SOBOL_LENGTH).next_u32();
        let mut dimension = 0;
        let mut uniform = |numbers: &mut ChaCha8Rng| match self.identity.points {
            Points::Uniform | Points::Corners => {
                /// 2^-53: the distance of the numbers.
                const STEP: f64 = f64::EPSILON / 2.0;
                (numbers.next_u64() >> 11) as f64 * STEP
            }
            Points::Sobol => {
                let (block, place) = (dimension / NUM_DIMENSIONS, dimension % NUM_DIMENSIONS);
                dimension += 1;
                let point = (flight % SOBOL_LENGTH) as u32;
                f64::from(sobol_burley::sample(point, place, sequence.wrapping_add(block)))
            }
        };
        let mut delta = || {
            let drawn = 2.0 * uniform(&mut numbers) - 1.0;
            match self.identity.points {
                Points::Uniform | Points::Sobol => drawn,
                Points::Corners => 1f64.copysign(drawn),
            }
        };
        let delta: Vec<f64> = self.uncertain.iter().map(|_| delta()).collect();
        let default = &self.stored.manoeuvre;
        let mut speed =
            || default.speed_from + uniform(&mut numbers) * (default.speed_to - default.speed_from);
        let (speed_from, speed_to) = (speed(), speed());
        let sign = if uniform(&mut numbers) < 0.5 { -1.0 } else { 1.0 };
        let (pitch_step, depth_step) = (sign * default.pitch_step, sign * default.depth_step);
        let manoeuvre = Manoeuvre { speed_from, speed_to, pitch_step, depth_step, ..default.clone() };
        let sea_seed = numbers.next_u64() >> 33;
        // Last, so that all else is drawn alike with starts and without.
        let mut off_trim = self.identity.starts.0;
        for (place, _) in self.identity.starts.off() {
            off_trim[place] *= 2.0 * uniform(&mut numbers) - 1.0;
        }
        Drawn { delta, manoeuvre, off_trim, sea_seed }
    }
}
