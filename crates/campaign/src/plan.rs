//! Definition of a campaign, and the random numbers of each flight.

use crate::error::Error;
use crate::starts::Starts;
use rand::rngs::ChaCha8Rng;
use rand::{Rng, SeedableRng};
use serde::{Deserialize, Serialize};
use sobol_burley::NUM_DIMENSIONS;
use squid_auv::PerSignal;
use squid_auv::{Parameter, Speed, Vehicle, trim_with};
use squid_design::inputs::Inputs;
use squid_design::store::Stored;
use squid_design::uncertain::model::{Block, Uncertain};
use squid_design::uncertain::trim::blocks;
use squid_flight::sea::Sea;
use squid_scheduled::Manoeuvre;
use std::collections::BTreeMap;

/// Distribution of the vehicles over the box of the declared uncertainty.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Points {
    /// Uniform over the box.
    Uniform,
    /// Sobol sequence, scrambled by the seed, over the box, speeds and steps.
    Sobol,
    /// Vertices of the box.
    Corners,
}

/// Length of a Sobol sequence of the library.
const SOBOL_LENGTH: u64 = 1 << 16;

/// Identity of a campaign: campaigns with the same identity have the same flights.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Identity {
    /// SHA-256 of the vehicle file.
    pub vehicle: String,
    /// SHA-256 of the design file.
    pub design: String,
    /// Text of the sea file.
    pub sea: Option<String>,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Distribution of the vehicles.
    pub points: Points,
    /// Initial deviations from trim.
    #[serde(default, skip_serializing_if = "Starts::in_trim")]
    pub starts: Starts,
    /// `true` if the FMUs of the design are simulated.
    pub fmus: bool,
    /// Version of squid.
    pub version: String,
}

impl Identity {
    /// Returns the first part that differs, as text.
    pub fn differs_from(&self, other: &Self) -> Option<&'static str> {
        let parts = [
            ("the vehicle file", self.vehicle != other.vehicle),
            ("the design file", self.design != other.design),
            ("the sea", self.sea != other.sea),
            ("the seed", self.seed != other.seed),
            ("the distribution over the uncertainty", self.points != other.points),
            ("the initial deviations from trim", self.starts != other.starts),
            ("the simulator, squid or FMUs,", self.fmus != other.fmus),
            ("the version of squid", self.version != other.version),
        ];
        parts.into_iter().find(|(_, differs)| *differs).map(|(what, _)| what)
    }
}

/// Axis of a campaign.
#[derive(Debug)]
pub struct Axis<'a> {
    /// Vehicle and design.
    pub inputs: &'a Inputs,
    /// Stored result of the design.
    pub stored: &'a Stored,
    /// Uncertain parameters, with actuator indices of the axis.
    pub uncertain: Vec<Block>,
    /// Indices of these parameters in the plan.
    pub(crate) indices: Vec<usize>,
}

/// Campaign.
#[derive(Debug)]
pub struct Plan<'a> {
    /// Axes, at least one.
    pub axes: Vec<Axis<'a>>,
    /// Vehicle to simulate: that of the only axis, or the one in six degrees of freedom.
    pub vehicle: &'a Vehicle,
    /// Manoeuvre that gives the range of the drawn speeds.
    pub manoeuvre: Manoeuvre,
    /// Sea, drawn anew for each flight.
    pub sea: Option<Sea>,
    /// Identity of the campaign.
    pub identity: Identity,
    /// Uncertain parameters, with actuator indices of the vehicle.
    pub uncertain: Vec<Block>,
}

/// Random numbers of a flight.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawn {
    /// Normalised value of each uncertain parameter, from -1 to 1 over its range.
    pub delta: Vec<f64>,
    /// Manoeuvre of the design, between two speeds in its range and with the step up or down.
    pub manoeuvre: Manoeuvre,
    /// Initial deviation of each signal from trim, SI.
    pub off_trim: PerSignal<f64>,
    /// Seed of the waves, the current and the sensor errors; at most [`i32::MAX`], as FMUs require.
    pub sea_seed: u64,
}

/// Returns the uncertain parameters of an axis; none if it declares none.
fn uncertain_of(inputs: &Inputs, stored: &Stored) -> Result<Vec<Block>, Error> {
    if !inputs.is_uncertain() {
        return Ok(Vec::new());
    }
    let ((depth, rule), speed) = (inputs.design.level(), stored.manoeuvre.speed_from);
    let trim = trim_with(&inputs.plane, Speed::Path(speed), depth, rule)
        .map_err(|reason| squid_flight::error::Error::Trim { speed, reason })?;
    Ok(blocks(inputs, &trim, &[]).map_err(squid_design::error::Error::from)?)
}

/// Returns an uncertain parameter of an axis with the actuator index of the simulated vehicle.
fn of_vehicle(block: &Block, axis: &Vehicle, vehicle: &Vehicle) -> Result<Block, Error> {
    let plane_only = || Error::NotWhole { name: block.name.clone() };
    let index = |actuator: usize| {
        let name = &axis.actuators[actuator].name;
        vehicle.actuators.iter().position(|one| one.name == *name).ok_or_else(plane_only)
    };
    let uncertain = match block.uncertain {
        Uncertain::Gain(actuator) => Uncertain::Gain(index(actuator)?),
        Uncertain::Parameter(Parameter::Effect { actuator, key }) => {
            let parameter = Parameter::Effect { actuator: index(actuator)?, key };
            // A thruster that points sideways has other coefficients in the vertical plane.
            if parameter.coefficient(vehicle) != Some(block.value) {
                return Err(plane_only());
            }
            Uncertain::Parameter(parameter)
        }
        coefficient => coefficient,
    };
    Ok(Block { uncertain, ..block.clone() })
}

impl<'a> Plan<'a> {
    /// Returns the only axis, or the first.
    pub fn first(&self) -> &Axis<'a> {
        &self.axes[0]
    }

    /// Returns a campaign of a design with one axis, optionally in a sea, given with the text of its file.
    ///
    /// # Errors
    /// Errors of [`of_axes`](Self::of_axes).
    pub fn new(
        inputs: &'a Inputs,
        stored: &'a Stored,
        sea: Option<(Sea, String)>,
        seed: u64,
        points: Points,
    ) -> Result<Self, Error> {
        Self::of_axes(&[(inputs, stored)], sea, seed, points)
    }

    /// Returns a campaign of a design, optionally in a sea, given with the text of its file. A single axis flies alone,
    /// several fly in six degrees of freedom.
    ///
    /// # Errors
    /// [`Error::Flight`] for waves without the size of the hull; [`Error::Design`]; [`Error::NotWhole`];
    /// [`Error::NoAxis`].
    pub fn of_axes(
        axes: &[(&'a Inputs, &'a Stored)],
        sea: Option<(Sea, String)>,
        seed: u64,
        points: Points,
    ) -> Result<Self, Error> {
        let Some((inputs, _)) = axes.first() else { return Err(Error::NoAxis) };
        let (sea, text) = sea.unzip();
        let vehicle = if axes.len() > 1 { &inputs.six_dof } else { &inputs.vehicle };
        sea.iter().try_for_each(|sea| match axes.len() {
            1 => sea.check(vehicle),
            _ => sea.check_geometry(vehicle),
        })?;
        let (mut uncertain, mut planned_axes) = (Vec::<Block>::new(), vec![]);
        for (inputs, stored) in axes {
            let own = uncertain_of(inputs, stored)?;
            let mut indices = vec![];
            for block in &own {
                let block = of_vehicle(block, &inputs.vehicle, vehicle)?;
                let known = uncertain.iter().position(|other| other.uncertain == block.uncertain);
                indices.push(known.unwrap_or(uncertain.len()));
                uncertain.extend(known.is_none().then_some(block));
            }
            planned_axes.push(Axis { inputs, stored, uncertain: own, indices });
        }
        let mut manoeuvre = axes[0].1.manoeuvre.clone();
        for (inputs, stored) in &axes[1..] {
            manoeuvre.steps.extend(stored.manoeuvre.steps.clone());
            let within = |speed: f64| speed.clamp(inputs.design.speed_min, inputs.design.speed_max);
            (manoeuvre.speed_from, manoeuvre.speed_to) =
                (within(manoeuvre.speed_from), within(manoeuvre.speed_to));
        }
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
        Ok(Self { axes: planned_axes, vehicle, manoeuvre, sea, identity, uncertain })
    }

    /// Returns the campaign with initial deviations from trim.
    #[must_use]
    pub fn with_starts(mut self, starts: Starts) -> Self {
        self.identity.starts = starts;
        self
    }

    /// Returns the campaign with the FMUs of the design.
    ///
    /// # Errors
    /// [`Error::NotOfFmus`]: FMUs start in trim, have a default number of wave components, a steady current and no
    /// actuator parameters, and cannot scale the thrust of a thruster with a curve.
    pub fn with_fmus(mut self) -> Result<Self, Error> {
        let effect =
            |block: &&Block| matches!(block.uncertain, Uncertain::Parameter(Parameter::Effect { .. }));
        let curve = |block: &&Block| match block.uncertain {
            Uncertain::Gain(actuator) => self.vehicle.actuators[actuator].curve.is_some(),
            Uncertain::Parameter(_) => false,
        };
        let uncertain = || self.uncertain.iter();
        let beyond = self.sea.as_ref().and_then(Sea::beyond_steady);
        let what = match (beyond, uncertain().find(effect), uncertain().find(curve)) {
            _ if self.axes.len() > 1 => "several axes together (select one with --axis)".to_owned(),
            _ if !self.identity.starts.in_trim() => "initial deviations from trim".to_owned(),
            (Some(beyond), ..) => beyond,
            (_, Some(block), _) => {
                format!("an uncertain {}, which is no parameter of the vehicle's FMU", block.name)
            }
            (.., Some(block)) => {
                format!(
                    "an uncertain {}, because the corresponding input of the vehicle's FMU is not a thrust",
                    block.name
                )
            }
            _ => {
                self.identity.fmus = true;
                return Ok(self);
            }
        };
        Err(Error::NotOfFmus { what })
    }

    /// Returns the random numbers of a flight. They depend on its number and the seed only, not on the order of
    /// flights.
    pub fn draw(&self, flight: u64) -> Drawn {
        let stream = |number| {
            let mut numbers = ChaCha8Rng::seed_from_u64(self.identity.seed);
            numbers.set_stream(number);
            numbers
        };
        let mut numbers = stream(flight);
        // Flights beyond the length use another sequence, and dimensions beyond those of the library another block of
        // it.
        let sequence = stream(flight / SOBOL_LENGTH).next_u32();
        let mut dimension = 0;
        let mut uniform = |numbers: &mut ChaCha8Rng| match self.identity.points {
            Points::Uniform | Points::Corners => {
                /// Spacing of the random numbers, 2^-53.
                const STEP: f64 = f64::EPSILON / 2.0;
                (numbers.next_u64() >> 11) as f64 * STEP
            }
            Points::Sobol => {
                let (block, index) = (dimension / NUM_DIMENSIONS, dimension % NUM_DIMENSIONS);
                dimension += 1;
                let point = (flight % SOBOL_LENGTH) as u32;
                f64::from(sobol_burley::sample(point, index, sequence.wrapping_add(block)))
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
        let default = &self.manoeuvre;
        let mut speed =
            || default.speed_from + uniform(&mut numbers) * (default.speed_to - default.speed_from);
        let (speed_from, speed_to) = (speed(), speed());
        let mut steps = BTreeMap::new();
        for axis in &self.axes {
            let sign = if uniform(&mut numbers) < 0.5 { -1.0 } else { 1.0 };
            let own = axis.stored.manoeuvre.steps.iter().map(|(name, height)| (name.clone(), sign * height));
            steps.extend(own);
        }
        let manoeuvre = Manoeuvre { speed_from, speed_to, steps, ..default.clone() };
        let sea_seed = numbers.next_u64() >> 33;
        // Initial deviations are drawn last, so that the other numbers do not depend on them.
        let mut off_trim = self.identity.starts.0;
        for (index, _) in self.identity.starts.off() {
            off_trim[index] *= 2.0 * uniform(&mut numbers) - 1.0;
        }
        Drawn { delta, manoeuvre, off_trim, sea_seed }
    }
}
