//! The environment of a flight: waves, current and sensor errors.

use crate::error::Error;
use auv::longitudinal::{Each, SIGNALS, SPEED};
use auv::{Current, Surroundings, Vehicle, Water, lateral};
use signals::Signal;
use squid_sea::{GaussMarkov, Layers, Sensor, SensorErrors, Spectrum, Wandering, Waves};
use std::array::from_fn;
use std::sync::Arc;

/// The environment as its file describes it; nothing random is drawn yet.
#[derive(Debug, Clone, PartialEq)]
pub struct Sea {
    /// Seed of everything random.
    pub seed: u64,
    /// The depth at which flights start \[m\]; `None` for the depth of the design.
    pub depth: Option<f64>,
    /// The waves.
    pub waves: Option<WaveParameters>,
    /// The current along the vehicle's heading, over depth.
    pub layers: Layers,
    /// The vertical current \[m/s\], positive down.
    pub vertical: f64,
    /// The Gauss-Markov part of the current along the vehicle's heading.
    pub gauss_markov: Option<Wandering>,
    /// The errors of each sensor, in the order of [`sensed`].
    pub sensors: Vec<SensorErrors>,
}

/// Parameters from which the waves are drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct WaveParameters {
    /// The wave spectrum.
    pub spectrum: Spectrum,
    /// Direction of propagation relative to the vehicle's heading \[rad\].
    pub heading: f64,
    /// Number of wave components.
    pub components: usize,
}

/// The environment drawn for one vehicle.
#[derive(Debug)]
pub(crate) struct Conditions {
    water: Arc<Surroundings>,
    gauss_markov: Option<GaussMarkov>,
    sensors: Vec<Sensor>,
}

impl Sea {
    /// Waves only, without current or sensor errors, for a flight that starts at a depth \[m\].
    ///
    /// # Errors
    /// [`Error::Sea`].
    pub fn of_waves(waves: WaveParameters, depth: f64, seed: u64) -> Result<Self, Error> {
        Ok(Self {
            seed,
            depth: Some(depth),
            waves: Some(waves),
            layers: Layers::new(&[[0.0, 0.0]])?,
            vertical: 0.0,
            gauss_markov: None,
            sensors: perfect(),
        })
    }

    /// Checks that the vehicle of a design can be simulated in this sea. Waves need its `[geometry]`; that of a design
    /// of heading alone, whose surge, heave and pitch are held, is refused.
    ///
    /// # Errors
    /// [`Error::NoGeometry`], [`Error::SeaOfHeading`].
    pub fn check(&self, vehicle: &Vehicle) -> Result<(), Error> {
        if vehicle.coefficients.leaves_plane() {
            return Err(Error::SeaOfHeading { vehicle: vehicle.name.clone() });
        }
        self.check_geometry(vehicle)
    }

    /// Checks that a vehicle in six degrees of freedom can be simulated in this sea.
    ///
    /// # Errors
    /// [`Error::NoGeometry`].
    pub fn check_geometry(&self, vehicle: &Vehicle) -> Result<(), Error> {
        if self.waves.is_none() || vehicle.geometry.is_some() {
            Ok(())
        } else {
            Err(Error::NoGeometry { vehicle: vehicle.name.clone() })
        }
    }

    /// The first feature, in words, other than a steady current and waves of the default number of components.
    pub fn beyond_steady(&self) -> Option<String> {
        let components = self.waves.as_ref().map_or(Waves::USUAL, |waves| waves.components);
        let erring = sensed().zip(&self.sensors).find(|(_, errors)| **errors != SensorErrors::NONE);
        match (self.layers.steady(), &self.gauss_markov, erring) {
            (None, ..) => Some("a current in layers".into()),
            (_, Some(_), _) => Some("a Gauss-Markov current".into()),
            (.., Some((signal, _))) => Some(format!("errors of the sensor of {}", signal.name)),
            _ if components != Waves::USUAL => {
                Some(format!("waves of {components} components, only of {}", Waves::USUAL))
            }
            _ => None,
        }
    }

    /// The water around a vehicle, without the Gauss-Markov current.
    ///
    /// # Errors
    /// [`Error::NoGeometry`], [`Error::Sea`].
    pub fn about(&self, vehicle: &Vehicle) -> Result<Surroundings, Error> {
        self.check_geometry(vehicle)?;
        let coefficients = &vehicle.coefficients;
        let water = Surroundings::still(coefficients).with_current(self.layers.clone(), self.vertical);
        let Some((drawn_from, geometry)) = self.waves.as_ref().zip(vehicle.geometry) else {
            return Ok(water);
        };
        let waves = Waves::new(&drawn_from.spectrum, drawn_from.heading, drawn_from.components, self.seed)?;
        Ok(water.with_waves(waves, geometry, coefficients)?)
    }

    /// Draws everything random, for a vehicle and the sample time of its autopilot \[s\].
    ///
    /// # Errors
    /// As [`Sea::about`].
    pub(crate) fn draw(&self, vehicle: &Vehicle, sample_time: f64) -> Result<Conditions, Error> {
        let water = self.about(vehicle)?;
        let gauss_markov = self.gauss_markov.map(|numbers| GaussMarkov::new(numbers, self.seed));
        let sensor =
            |(number, errors): (u32, &SensorErrors)| Sensor::new(*errors, sample_time, self.seed, number);
        Ok(Conditions {
            water: Arc::new(water),
            gauss_markov: gauss_markov.transpose()?,
            sensors: (0..).zip(&self.sensors).map(sensor).collect::<Result<_, _>>()?,
        })
    }
}

impl Conditions {
    /// The water, as a plant needs it.
    pub(crate) fn water(&self) -> Arc<dyn Water> {
        self.water.clone()
    }

    /// The present Gauss-Markov part of the current.
    pub(crate) fn gauss_markov(&self) -> Current {
        let horizontal = self.gauss_markov.as_ref().map_or(0.0, GaussMarkov::value);
        Current { horizontal, vertical: 0.0, ..Current::default() }
    }

    /// Advances the Gauss-Markov process by a time \[s\].
    pub(crate) fn advance(&mut self, step: f64) {
        self.gauss_markov.iter_mut().for_each(|process| process.advance(step));
    }

    /// The sensor readings, at the next tick, of the signals of surge, heave and pitch.
    pub(crate) fn read(&mut self, level: &Each<f64>) -> Each<f64> {
        let mut read = *level;
        read.iter_mut().zip(&mut self.sensors).for_each(|(value, sensor)| *value = sensor.read(*value));
        read
    }

    /// The sensor readings, at the next tick, of the signals of both axes; the sensor of the speed is one.
    pub(crate) fn read_both(&mut self, [level, lateral]: &[Each<f64>; 2]) -> [Each<f64>; 2] {
        let level = self.read(level);
        let mut others = self.sensors[SIGNALS.len()..].iter_mut();
        let lateral = from_fn(|place| match place {
            SPEED => level[SPEED],
            _ => others.next().map_or(f64::NAN, |sensor| sensor.read(lateral[place])),
        });
        [level, lateral]
    }

    /// The waves and the layers of the current.
    pub(crate) fn surroundings(&self) -> &Surroundings {
        &self.water
    }
}

/// The signals that have a sensor: those of surge, heave and pitch, then those that only the axis of heading has.
pub fn sensed() -> impl Iterator<Item = &'static Signal> {
    let turning = lateral::SIGNALS.iter().enumerate().filter(|(place, _)| *place != SPEED);
    SIGNALS.iter().chain(turning.map(|(_, signal)| signal))
}

/// No errors in any sensor.
pub(crate) fn perfect() -> Vec<SensorErrors> {
    sensed().map(|_| SensorErrors::NONE).collect()
}
