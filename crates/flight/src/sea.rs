//! A sea: waves, current and sensors of a flight.

use crate::error::Error;
use auv::{Coefficients, Current, Geometry, Vehicle, Water, WaterMotion};
use signals::{Each, SIGNALS};
use squid_sea::{
    GRAVITY, GaussMarkov, Layers, Place, SeaError, Sensor, SensorErrors, Spectrum, Spheroid, Wandering, Waves,
};
use std::f64::consts::PI;
use std::sync::Arc;

/// Where the length of a hull is looked at, in halves of it from its middle: its ends are points below the surface.
const STATIONS: [f64; 5] = [-0.9, -0.5, 0.0, 0.5, 0.9];

/// A sea as its file says it: nothing random is drawn yet.
#[derive(Debug, Clone, PartialEq)]
pub struct Sea {
    /// Of all that is random.
    pub seed: u64,
    /// The depth at which flights begin \[m\]; that of the design where it is `None`.
    pub depth: Option<f64>,
    /// The waves.
    pub waves: Option<Swell>,
    /// The current along the way the vehicle faces.
    pub layers: Layers,
    /// The vertical current \[m/s\], positive down.
    pub vertical: f64,
    /// What wanders about the current along the way the vehicle faces.
    pub wandering: Option<Wandering>,
    /// The errors of each sensor.
    pub sensors: Each<SensorErrors>,
}

/// What the waves of a sea are drawn from.
#[derive(Debug, Clone, PartialEq)]
pub struct Swell {
    /// Their spectrum.
    pub spectrum: Spectrum,
    /// Where they go, from the way the vehicle faces \[rad\].
    pub heading: f64,
    /// How many there are.
    pub components: usize,
}

/// A sea as it is for one vehicle.
#[derive(Debug)]
pub(crate) struct Conditions {
    water: Arc<Moving>,
    wandering: Option<GaussMarkov>,
    sensors: Vec<Sensor>,
}

impl Sea {
    /// Checks that a vehicle can be flown in it: waves need its `[geometry]`.
    ///
    /// # Errors
    /// [`Error::NoGeometry`].
    pub fn check(&self, vehicle: &Vehicle) -> Result<(), Error> {
        match self.waves.is_none() || vehicle.geometry.is_some() {
            true => Ok(()),
            false => Err(Error::NoGeometry { vehicle: vehicle.name.clone() }),
        }
    }

    /// Draws what is random, for a vehicle and an autopilot of this sample time \[s\].
    ///
    /// # Errors
    /// As [`Sea::check`]; [`Error::Sea`].
    pub(crate) fn draw(&self, vehicle: &Vehicle, tick: f64) -> Result<Conditions, Error> {
        self.check(vehicle)?;
        let waves = self.waves.as_ref().zip(vehicle.geometry).map(|(swell, geometry)| {
            let waves = Waves::new(&swell.spectrum, swell.heading, swell.components, self.seed)?;
            Ok::<_, SeaError>((waves, hull(geometry, &vehicle.coefficients)?))
        });
        let Coefficients { x_B, z_B, .. } = vehicle.coefficients;
        let layers = self.layers.clone();
        let wandering = self.wandering.map(|numbers| GaussMarkov::new(numbers, self.seed));
        let sensor = |(number, errors): (u32, &SensorErrors)| Sensor::new(*errors, tick, self.seed, number);
        Ok(Conditions {
            water: Arc::new(Moving {
                waves: waves.transpose()?,
                centre: [x_B, z_B],
                layers,
                vertical: self.vertical,
            }),
            wandering: wandering.transpose()?,
            sensors: (0..).zip(&self.sensors).map(sensor).collect::<Result<_, _>>()?,
        })
    }
}

impl Conditions {
    /// The water, for a plant.
    pub(crate) fn water(&self) -> Arc<dyn Water> {
        self.water.clone()
    }

    /// The part of the current that wanders, now.
    pub(crate) fn wandering(&self) -> Current {
        let horizontal = self.wandering.as_ref().map_or(0.0, GaussMarkov::value);
        Current { horizontal, vertical: 0.0 }
    }

    /// Lets it wander for a time \[s\].
    pub(crate) fn advance(&mut self, step: f64) {
        self.wandering.iter_mut().for_each(|process| process.advance(step));
    }

    /// What the sensors read of the signals at the next tick.
    pub(crate) fn read(&mut self, signals: &Each<f64>) -> Each<f64> {
        let mut read = *signals;
        read.iter_mut().zip(&mut self.sensors).for_each(|(value, sensor)| *value = sensor.read(*value));
        read
    }

    /// The surface above the still water, over the middle of the vehicle \[m\].
    pub(crate) fn elevation(&self, time: f64, x: f64) -> f64 {
        self.water.waves.as_ref().map_or(0.0, |(waves, _)| waves.elevation(time, x))
    }

    /// How deep the hull is below the surface where it is nearest \[m\], negative out of it; where no waves are, that
    /// is the depth.
    pub(crate) fn clearance(&self, time: f64, x: f64, depth: f64, pitch: f64) -> f64 {
        let Some((waves, hull)) = &self.water.waves else { return depth };
        let [x, depth] = self.water.centre_at([x, depth], pitch);
        let below = |station: f64| {
            let [along, top] = hull.top(station, pitch);
            depth - top + waves.elevation(time, x + along)
        };
        STATIONS.into_iter().map(below).fold(f64::INFINITY, f64::min)
    }
}

/// Waves about a hull, and a current in layers.
#[derive(Debug)]
struct Moving {
    waves: Option<(Waves, Spheroid)>,
    /// The centre of buoyancy, in the axes of the body \[m\].
    centre: [f64; 2],
    layers: Layers,
    vertical: f64,
}

impl Moving {
    /// The centre of buoyancy of a vehicle whose origin is at \[x, depth\].
    fn centre_at(&self, [x, depth]: [f64; 2], pitch: f64) -> [f64; 2] {
        let ([along, down], (sin, cos)) = (self.centre, pitch.sin_cos());
        [x + along * cos + down * sin, depth - along * sin + down * cos]
    }
}

impl Water for Moving {
    /// The waves are those at the centre of buoyancy, whose way differs from that of the origin by the turning alone.
    fn at(&self, time: f64, x: f64, depth: f64, pitch: f64) -> WaterMotion {
        let pair = |[horizontal, vertical]: [f64; 2]| Current { horizontal, vertical };
        let (velocity, slope) = self.layers.at(depth);
        let mut all = WaterMotion {
            velocity: pair([velocity, self.vertical]),
            by_depth: pair([slope, 0.0]),
            ..WaterMotion::default()
        };
        if let Some((waves, hull)) = &self.waves {
            let [x, depth] = self.centre_at([x, depth], pitch);
            let (motion, [surge, heave, moment]) = hull.in_waves(waves, Place { time, x, depth }, pitch);
            all.velocity = all.velocity + pair(motion.velocity);
            all.by_time = pair(motion.by_time);
            all.by_x = pair(motion.by_x);
            all.by_depth = all.by_depth + pair(motion.by_depth);
            let [along, down] = self.centre;
            all.load = [surge, heave, moment + down * surge - along * heave];
        }
        all
    }
}

/// The spheroid as slender as the hull that displaces what the vehicle does, with the added mass of the vehicle.
fn hull(geometry: Geometry, c: &Coefficients) -> Result<Spheroid, SeaError> {
    let slenderness = geometry.length / geometry.diameter;
    let volume = c.buoyancy / (c.density * GRAVITY);
    let radius = (3.0 * volume / (4.0 * PI * slenderness)).cbrt();
    let added_mass = [[-c.X_u_dot, 0.0, 0.0], [0.0, -c.Z_w_dot, -c.Z_q_dot], [0.0, -c.M_w_dot, -c.M_q_dot]];
    Spheroid::new(slenderness * radius, radius, c.density, added_mass)
}

/// Sensors without errors.
pub(crate) const PERFECT: Each<SensorErrors> = [SensorErrors::NONE; SIGNALS.len()];
