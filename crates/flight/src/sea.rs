//! The environment of a flight: waves, current and sensor errors.

use crate::error::Error;
use squid_auv::{Bottom, Current, Each, Surroundings, VIEWS, Vehicle, View, Water};
use squid_sea::{GaussMarkov, Layers, Sensor, SensorErrors, Spectrum, Wandering, Waves};
use squid_signals::Signal;
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
    /// The bottom.
    pub bottom: Bottom,
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
    /// The sensor of each signal of each view, as [`places`] returns them.
    indices: Vec<(usize, usize, usize)>,
    bottom: Bottom,
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
            bottom: Bottom::default(),
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
            indices: indices(),
            bottom: self.bottom,
        })
    }
}

impl Conditions {
    /// The water, as a plant needs it.
    pub(crate) fn water(&self) -> Arc<dyn Water> {
        self.water.clone()
    }

    /// The bottom.
    pub(crate) fn bottom(&self) -> Bottom {
        self.bottom
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

    /// The sensor readings, at the next tick, of the signals of the first of [`VIEWS`].
    pub(crate) fn read(&mut self, measured: &Each<f64>) -> Each<f64> {
        let mut read = *measured;
        let own = self.sensors.iter_mut().take(VIEWS[0].sensed.len());
        read.iter_mut().zip(own).for_each(|(value, sensor)| *value = sensor.read(*value));
        read
    }

    /// The sensor readings, at the next tick, of the signals of each of [`VIEWS`]; a signal that several have has one
    /// sensor.
    pub(crate) fn read_all(&mut self, measured: &[Each<f64>; VIEWS.len()]) -> [Each<f64>; VIEWS.len()] {
        let mut read = *measured;
        for (index, sensor) in self.sensors.iter_mut().enumerate() {
            let mut value = None;
            let own = self.indices.iter().filter(|(of, ..)| *of == index);
            for (_, view, signal) in own {
                let one = &mut read[*view][*signal];
                *one = *value.get_or_insert_with(|| sensor.read(*one));
            }
        }
        read
    }

    /// The waves and the layers of the current.
    pub(crate) fn surroundings(&self) -> &Surroundings {
        &self.water
    }
}

/// The signals that have a sensor: those of each of [`VIEWS`] that no view before it has.
pub fn sensed() -> impl Iterator<Item = &'static Signal> {
    VIEWS.iter().enumerate().flat_map(|(index, view)| {
        let before = &VIEWS[..index];
        let is_new = |one: &&Signal| before.iter().all(|other| other.interface.index(one.name).is_none());
        view.interface.signals.iter().filter(is_new)
    })
}

/// The sensor of each signal of each view: the index of the sensor, of the view, and of the signal in it.
fn indices() -> Vec<(usize, usize, usize)> {
    let of = |(sensor, signal): (usize, &'static Signal)| {
        let place =
            move |(index, view): (usize, &&View)| Some((sensor, index, view.interface.index(signal.name)?));
        VIEWS.iter().enumerate().filter_map(place).collect::<Vec<_>>()
    };
    sensed().enumerate().flat_map(of).collect()
}

/// No errors in any sensor.
pub(crate) fn perfect() -> Vec<SensorErrors> {
    sensed().map(|_| SensorErrors::NONE).collect()
}
