//! Long-crested sea: components with random phases, and the motion of the water below them.
//!
//! Linear theory in deep water, with x north, y east, the depth z and `w^2 = g k`: the component `E = a exp(-k z + i (k
//! (x cos(heading) + y sin(heading)) - w t + phase))` has the elevation Re E at depth 0, positive upward, the pressure
//! `density g Re E`, the gradient `i k n E` with `n = [cos(heading), sin(heading), i]`, and the velocity `Re(w n E)` in
//! north, east and down. Source: Newman, Marine Hydrodynamics (1977), chapter 6.

use crate::GRAVITY;
use crate::error::{SeaError, check};
use crate::random::Purpose;
use crate::spectrum::Spectrum;
use num_complex::Complex64;
use rand_distr::{Distribution, StandardUniform};
use std::f64::consts::TAU;
use std::sync::Arc;

/// Frequency range of the components relative to the peak: 1.3e-4 of the energy lies outside.
const FREQUENCIES: [f64; 2] = [0.5, 10.0];

/// Allowed numbers of components: fewer repeat too soon and do not resolve the peak, more only take time.
const COMPONENTS: std::ops::RangeInclusive<usize> = 20..=1000;

/// Largest product of wave number and depth; deeper, a component is omitted: its factor `exp(-40)` is below rounding.
const DEEPEST: f64 = 40.0;

/// Position in the water and time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Position {
    /// Time \[s\].
    pub time: f64,
    /// Position north \[m\].
    pub north: f64,
    /// Position east \[m\].
    pub east: f64,
    /// Depth below the still water level \[m\].
    pub depth: f64,
}

/// Motion of the water at a position: vectors \[north, east, down\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WaterMotion {
    /// Velocity \[m/s\].
    pub velocity: [f64; 3],
    /// Derivative of the velocity with respect to time at a fixed position \[m/s2\].
    pub by_time: [f64; 3],
    /// Derivatives of the velocity with respect to north, east and depth \[1/s\].
    pub by_place: [[f64; 3]; 3],
}

/// Wave component of a sea.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Component {
    /// Amplitude \[m\].
    pub amplitude: f64,
    /// Frequency \[rad/s\].
    pub frequency: f64,
    /// Wave number k \[rad/m\].
    pub number: f64,
    /// Phase at the origin and time 0 \[rad\].
    pub phase: f64,
}

/// Long-crested sea.
#[derive(Clone, Debug, PartialEq)]
pub struct Waves {
    components: Arc<[Component]>,
    /// Direction of propagation: north and east.
    direction: [f64; 2],
}

impl Waves {
    /// Usual number of components.
    pub const USUAL: usize = 100;

    /// Returns a sea of a spectrum, reproducible by its seed.
    ///
    /// `heading` \[rad\] is the direction in which the waves travel, clockwise from north: for a vehicle that goes
    /// north, pi is a head sea and 0 a following sea. The frequencies from half to ten times the peak are divided at a
    /// constant ratio into `components` intervals. Each has one wave with the energy of its interval, with a random
    /// frequency within it, so that the sea does not repeat, and a random phase.
    ///
    /// # Errors
    /// [`SeaError::NotAllowed`] for the heading and the number of components.
    pub fn new(spectrum: &Spectrum, heading: f64, components: usize, seed: u64) -> Result<Self, SeaError> {
        check("heading", heading, true, "a finite number")?;
        check("components", components as f64, COMPONENTS.contains(&components), "from 20 to 1000")?;
        let [low, high] = FREQUENCIES.map(|relative| relative * spectrum.peak());
        let edge = |i: usize| low * (high / low).powf(i as f64 / components as f64);
        let mut stream = Purpose::Waves.stream(seed);
        let mut uniform = || -> f64 { StandardUniform.sample(&mut stream) };
        let component = |i: usize| {
            let (from, to) = (edge(i), edge(i + 1));
            let frequency = from * (to / from).powf(uniform());
            Component {
                amplitude: (2.0 * spectrum.integral(from, to)).sqrt(),
                frequency,
                number: frequency * frequency / GRAVITY,
                phase: TAU * uniform(),
            }
        };
        Ok(Self::of((0..components).map(component).collect(), heading))
    }

    /// Returns a sea of these components, the longest waves first.
    pub fn of(components: Vec<Component>, heading: f64) -> Self {
        Self { components: components.into(), direction: [heading.cos(), heading.sin()] }
    }

    /// Returns the wave components.
    pub fn components(&self) -> &[Component] {
        &self.components
    }

    /// Returns n, the gradient of E divided by `i k E`: north, east and down.
    pub(crate) fn gradient(&self) -> [Complex64; 3] {
        let [north, east] = self.direction;
        [north.into(), east.into(), Complex64::I]
    }

    /// Returns the components that reach a position, each with its E.
    pub(crate) fn at(&self, position: Position) -> impl Iterator<Item = (&Component, Complex64)> {
        let Position { time, north, east, depth } = position;
        let along = north * self.direction[0] + east * self.direction[1];
        let reaching = self.components.iter().take_while(move |wave| wave.number * depth < DEEPEST);
        reaching.map(move |wave| {
            let angle = wave.number * along - wave.frequency * time + wave.phase;
            (wave, Complex64::from_polar(wave.amplitude * (-wave.number * depth).exp(), angle))
        })
    }

    /// Returns the elevation of the surface above the still water level at a position north and east, and a time \[m\].
    pub fn elevation(&self, time: f64, [north, east]: [f64; 2]) -> f64 {
        self.at(Position { time, north, east, depth: 0.0 }).map(|(_, wave)| wave.re).sum()
    }

    /// Returns the orbital motion of the water at a position. Above the still water level, linear theory is
    /// extrapolated and gives too large a motion.
    pub fn motion(&self, position: Position) -> WaterMotion {
        let mut orbits = Orbits::default();
        self.at(position).for_each(|(wave, value)| orbits.add(wave, value));
        orbits.motion(self)
    }
}

/// Returns the encounter frequency `|w - k U cos(heading)|` of a vehicle with a speed over ground U \[m/s\] north, in
/// waves of frequency w \[rad/s\] and a heading \[rad\].
pub fn encounter_frequency(frequency: f64, heading: f64, speed: f64) -> f64 {
    (frequency - frequency * frequency / GRAVITY * speed * heading.cos()).abs()
}

/// Sums of `w E`, `w^2 E` and `w k E` over the components: they determine the motion of the water.
#[derive(Default)]
pub(crate) struct Orbits([Complex64; 3]);

impl Orbits {
    pub(crate) fn add(&mut self, wave: &Component, value: Complex64) {
        let velocity = wave.frequency * value;
        let parts = [velocity, wave.frequency * velocity, wave.number * velocity];
        self.0.iter_mut().zip(parts).for_each(|(sum, part)| *sum += part);
    }

    /// Returns the motion of the water; the derivative of the velocity brings a factor `-i w` in time and `i k n` in
    /// position.
    pub(crate) fn motion(&self, waves: &Waves) -> WaterMotion {
        let (Self([velocity, by_time, by_place]), n) = (self, waves.gradient());
        WaterMotion {
            velocity: n.map(|part| (part * velocity).re),
            by_time: n.map(|part| (part * by_time).im),
            by_place: n.map(|slope| n.map(|part| -(slope * part * by_place).im)),
        }
    }
}
