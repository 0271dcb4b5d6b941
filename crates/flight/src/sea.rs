//! Environment of a flight: waves, current and sensor errors.

use crate::error::Error;
use squid_auv::{Bottom, Current, PerSignal, Surroundings, VIEWS, Vehicle, View, Water};
use squid_sea::{GaussMarkov, Layers, Sensor, SensorErrors, Spectrum, Wandering, Waves};
use squid_signals::Signal;
use std::sync::Arc;

/// Environment as described by its file, before any random draw.
#[derive(Debug, Clone, PartialEq)]
pub struct Sea {
    /// Seed of all random numbers.
    pub seed: u64,
    /// Depth at the start of a flight \[m\]; `None` for the depth of the design.
    pub depth: Option<f64>,
    /// Waves.
    pub waves: Option<WaveParameters>,
    /// Current along the vehicle's heading, over depth.
    pub layers: Layers,
    /// Vertical current \[m/s\], positive down.
    pub vertical: f64,
    /// Gauss-Markov component of the current along the vehicle's heading.
    pub gauss_markov: Option<Wandering>,
    /// Errors of each sensor, in the order of [`sensed`].
    pub sensors: Vec<SensorErrors>,
    /// Bottom.
    pub bottom: Bottom,
}

/// Parameters from which the waves are drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct WaveParameters {
    /// Wave spectrum.
    pub spectrum: Spectrum,
    /// Direction of propagation relative to the vehicle's heading \[rad\].
    pub heading: f64,
    /// Number of wave components.
    pub components: usize,
}

/// Environment drawn for one vehicle.
#[derive(Debug)]
pub(crate) struct Conditions {
    water: Arc<Surroundings>,
    gauss_markov: Option<GaussMarkov>,
    sensors: Vec<Sensor>,
    /// Sensor of each signal of each view, as returned by [`indices`].
    indices: Vec<(usize, usize, usize)>,
    bottom: Bottom,
}

impl Sea {
    /// Returns a sea with waves only, without current or sensor errors, for a flight that starts at a depth \[m\].
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
            sensors: perfect_sensors(),
            bottom: Bottom::default(),
        })
    }

    /// Checks that the vehicle of a design can be simulated in this sea: waves need its `[geometry]`; a design of
    /// heading only, with surge, heave and pitch held, is refused.
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

    /// Returns, as text, the first feature other than a steady current and waves of the default number of components.
    pub fn beyond_steady(&self) -> Option<String> {
        let components = self.waves.as_ref().map_or(Waves::USUAL, |waves| waves.components);
        let imperfect = sensed().zip(&self.sensors).find(|(_, errors)| **errors != SensorErrors::NONE);
        match (self.layers.steady(), &self.gauss_markov, imperfect) {
            (None, ..) => Some("a current in layers".into()),
            (_, Some(_), _) => Some("a Gauss-Markov current".into()),
            (.., Some((signal, _))) => Some(format!("errors of the {} sensor", signal.name)),
            _ if components != Waves::USUAL => {
                Some(format!("waves with {components} components, only with {}", Waves::USUAL))
            }
            _ => None,
        }
    }

    /// Returns the water around a vehicle, without the Gauss-Markov current.
    ///
    /// # Errors
    /// [`Error::NoGeometry`], [`Error::Sea`].
    pub fn about(&self, vehicle: &Vehicle) -> Result<Surroundings, Error> {
        self.check_geometry(vehicle)?;
        let coefficients = &vehicle.coefficients;
        let water = Surroundings::still(coefficients).with_current(self.layers.clone(), self.vertical);
        let Some((waves, geometry)) = self.waves.as_ref().zip(vehicle.geometry) else {
            return Ok(water);
        };
        let waves = Waves::new(&waves.spectrum, waves.heading, waves.components, self.seed)?;
        Ok(water.with_waves(waves, geometry, coefficients)?)
    }

    /// Draws all random numbers, for a vehicle and the sample time of its autopilot \[s\].
    ///
    /// # Errors
    /// Errors of [`Sea::about`].
    pub(crate) fn draw(&self, vehicle: &Vehicle, sample_time: f64) -> Result<Conditions, Error> {
        let water = self.about(vehicle)?;
        let gauss_markov = self.gauss_markov.map(|parameters| GaussMarkov::new(parameters, self.seed));
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
    /// Returns the water for a plant.
    pub(crate) fn water(&self) -> Arc<dyn Water> {
        self.water.clone()
    }

    /// Returns the bottom.
    pub(crate) fn bottom(&self) -> Bottom {
        self.bottom
    }

    /// Returns the present Gauss-Markov component of the current.
    pub(crate) fn gauss_markov(&self) -> Current {
        let horizontal = self.gauss_markov.as_ref().map_or(0.0, GaussMarkov::value);
        Current { horizontal, vertical: 0.0, ..Current::default() }
    }

    /// Advances the Gauss-Markov process by a time step \[s\].
    pub(crate) fn advance(&mut self, step: f64) {
        self.gauss_markov.iter_mut().for_each(|process| process.advance(step));
    }

    /// Returns the sensor readings at the next tick for the signals of the first of [`VIEWS`].
    pub(crate) fn read(&mut self, measured: &PerSignal<f64>) -> PerSignal<f64> {
        let mut readings = *measured;
        let own = self.sensors.iter_mut().take(VIEWS[0].sensed.len());
        readings.iter_mut().zip(own).for_each(|(value, sensor)| *value = sensor.read(*value));
        readings
    }

    /// Returns the sensor readings at the next tick for the signals of each of [`VIEWS`]; a signal of several views has
    /// one sensor.
    pub(crate) fn read_all(
        &mut self,
        measured: &[PerSignal<f64>; VIEWS.len()],
    ) -> [PerSignal<f64>; VIEWS.len()] {
        let mut readings = *measured;
        for (index, sensor) in self.sensors.iter_mut().enumerate() {
            let mut value = None;
            let own = self.indices.iter().filter(|(of, ..)| *of == index);
            for (_, view, signal) in own {
                let one = &mut readings[*view][*signal];
                *one = *value.get_or_insert_with(|| sensor.read(*one));
            }
        }
        readings
    }

    /// Returns the waves and the layers of the current.
    pub(crate) fn surroundings(&self) -> &Surroundings {
        &self.water
    }
}

/// Returns the signals that have a sensor: those of all [`VIEWS`], without duplicates.
pub fn sensed() -> impl Iterator<Item = &'static Signal> {
    VIEWS.iter().enumerate().flat_map(|(index, view)| {
        let before = &VIEWS[..index];
        let is_new = |one: &&Signal| before.iter().all(|other| other.interface.index(one.name).is_none());
        view.interface.signals.iter().filter(is_new)
    })
}

/// Returns the sensor of each signal of each view: the indices of the sensor, the view, and the signal in it.
fn indices() -> Vec<(usize, usize, usize)> {
    let of = |(sensor, signal): (usize, &'static Signal)| {
        let indices =
            move |(index, view): (usize, &&View)| Some((sensor, index, view.interface.index(signal.name)?));
        VIEWS.iter().enumerate().filter_map(indices).collect::<Vec<_>>()
    };
    sensed().enumerate().flat_map(of).collect()
}

/// Returns sensors without errors.
pub(crate) fn perfect_sensors() -> Vec<SensorErrors> {
    sensed().map(|_| SensorErrors::NONE).collect()
}
