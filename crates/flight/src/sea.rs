//! A sea: waves, current and sensors of a flight.

use crate::error::Error;
use auv::{Current, Surroundings, Vehicle, Water};
use signals::{Each, SIGNALS};
use squid_sea::{GaussMarkov, Layers, Sensor, SensorErrors, Spectrum, Wandering, Waves};
use std::sync::Arc;

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
    water: Arc<Surroundings>,
    wandering: Option<GaussMarkov>,
    sensors: Vec<Sensor>,
}

impl Sea {
    /// Waves alone, in still water and with sensors without errors, for a flight that begins at a depth \[m\].
    ///
    /// # Errors
    /// [`Error::Sea`].
    pub fn of_waves(waves: Swell, depth: f64, seed: u64) -> Result<Self, Error> {
        Ok(Self {
            seed,
            depth: Some(depth),
            waves: Some(waves),
            layers: Layers::new(&[[0.0, 0.0]])?,
            vertical: 0.0,
            wandering: None,
            sensors: PERFECT,
        })
    }

    /// Checks that a vehicle can be flown in it: waves need its `[geometry]`.
    ///
    /// # Errors
    /// [`Error::NoGeometry`].
    pub fn check(&self, vehicle: &Vehicle) -> Result<(), Error> {
        if self.waves.is_none() || vehicle.geometry.is_some() {
            Ok(())
        } else {
            Err(Error::NoGeometry { vehicle: vehicle.name.clone() })
        }
    }

    /// What it has beside waves of the usual number of components and a steady current, in words.
    pub fn beyond_steady(&self) -> Option<String> {
        let components = self.waves.as_ref().map_or(Waves::USUAL, |swell| swell.components);
        let erring = SIGNALS.iter().zip(&self.sensors).find(|(_, errors)| **errors != SensorErrors::NONE);
        match (self.layers.steady(), &self.wandering, erring) {
            (None, ..) => Some("a current in layers".into()),
            (_, Some(_), _) => Some("a Gauss-Markov current".into()),
            (.., Some((signal, _))) => Some(format!("errors of the sensor of {}", signal.name)),
            _ if components != Waves::USUAL => {
                Some(format!("waves of {components} components, only of {}", Waves::USUAL))
            }
            _ => None,
        }
    }

    /// The water about a vehicle, but for the current that wanders.
    ///
    /// # Errors
    /// As [`Sea::check`]; [`Error::Sea`].
    pub fn about(&self, vehicle: &Vehicle) -> Result<Surroundings, Error> {
        self.check(vehicle)?;
        let coefficients = &vehicle.coefficients;
        let water = Surroundings::still(coefficients).with_current(self.layers.clone(), self.vertical);
        let Some((swell, geometry)) = self.waves.as_ref().zip(vehicle.geometry) else { return Ok(water) };
        let waves = Waves::new(&swell.spectrum, swell.heading, swell.components, self.seed)?;
        Ok(water.with_waves(waves, geometry, coefficients)?)
    }

    /// Draws what is random, for a vehicle and an autopilot of this sample time \[s\].
    ///
    /// # Errors
    /// As [`Sea::check`]; [`Error::Sea`].
    pub(crate) fn draw(&self, vehicle: &Vehicle, tick: f64) -> Result<Conditions, Error> {
        let water = self.about(vehicle)?;
        let wandering = self.wandering.map(|numbers| GaussMarkov::new(numbers, self.seed));
        let sensor = |(number, errors): (u32, &SensorErrors)| Sensor::new(*errors, tick, self.seed, number);
        Ok(Conditions {
            water: Arc::new(water),
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

    /// The waves and the layers of the current.
    pub(crate) fn surroundings(&self) -> &Surroundings {
        &self.water
    }
}

/// Sensors without errors.
pub(crate) const PERFECT: Each<SensorErrors> = [SensorErrors::NONE; SIGNALS.len()];
