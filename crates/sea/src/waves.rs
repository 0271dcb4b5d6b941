//! A long-crested sea: components with random phases, and the motion of the water under them.
//!
//! Linear theory in deep water: the component `E = a exp(-k z + i (k (x cos(heading) + y sin(heading)) - w t +
//! phase))`, `w^2 = g k`, with x north, y east and the depth z, has the elevation Re E at depth 0, upward, the pressure
//! `density g Re E`, the gradient `i k n E` with `n = [cos(heading), sin(heading), i]`, and the velocity `Re(w n E)`,
//! north, east and down. Source: Newman, Marine Hydrodynamics (1977), chapter 6.

use crate::GRAVITY;
use crate::error::{SeaError, check};
use crate::random::Purpose;
use crate::spectrum::Spectrum;
use num_complex::Complex64;
use rand_distr::{Distribution, StandardUniform};
use std::f64::consts::TAU;
use std::sync::Arc;

/// The components lie between these frequencies, in units of that of the peak: 1.3e-4 of the energy lies outside.
const FREQUENCIES: [f64; 2] = [0.5, 10.0];

/// The numbers of components: fewer repeat too soon and have no shape of the peak, more only take time.
const COMPONENTS: std::ops::RangeInclusive<usize> = 20..=1000;

/// Components with a larger product of wave number and depth are left out: `exp(-40)` of them is below rounding.
const DEEPEST: f64 = 40.0;

/// A place in the water at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// s.
    pub time: f64,
    /// m.
    pub north: f64,
    /// m.
    pub east: f64,
    /// Below the still water \[m\].
    pub depth: f64,
}

/// How the water moves at a place: each \[north, east, down\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WaterMotion {
    /// m/s.
    pub velocity: [f64; 3],
    /// Its derivative by time, at the place \[m/s2\].
    pub by_time: [f64; 3],
    /// Its derivatives by the way north, by that east and by depth \[1/s\].
    pub by_place: [[f64; 3]; 3],
}

/// One wave of a sea.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Component {
    /// m.
    pub amplitude: f64,
    /// rad/s.
    pub frequency: f64,
    /// The wave number k \[rad/m\].
    pub number: f64,
    /// At the origin and time 0 \[rad\].
    pub phase: f64,
}

/// A long-crested sea.
#[derive(Clone, Debug, PartialEq)]
pub struct Waves {
    components: Arc<[Component]>,
    /// The way they go: north and east.
    direction: [f64; 2],
}

impl Waves {
    /// The usual number of components.
    pub const USUAL: usize = 100;

    /// A sea of a spectrum, the same for the same seed.
    ///
    /// `heading` \[rad\] is where the waves go, clockwise from north: for a vehicle that goes north, pi is a head sea
    /// and 0 a following one. The frequencies from half to ten times that of the peak are cut at constant ratios into
    /// `components` intervals. Each has one wave, with the energy of its interval, of a frequency drawn in it, so that
    /// the sea does not repeat, and of a phase drawn from all.
    ///
    /// # Errors
    /// [`SeaError::NotAllowed`] of the heading and the number of components.
    pub fn new(spectrum: &Spectrum, heading: f64, components: usize, seed: u64) -> Result<Self, SeaError> {
        check("heading", heading, true, "a finite number")?;
        check("components", components as f64, COMPONENTS.contains(&components), "from 20 to 1000")?;
        let [low, high] = FREQUENCIES.map(|relative| relative * spectrum.peak());
        let edge = |i: usize| low * (high / low).powf(i as f64 / components as f64);
        let mut numbers = Purpose::Waves.stream(seed);
        let mut part = || -> f64 { StandardUniform.sample(&mut numbers) };
        let component = |i: usize| {
            let (from, to) = (edge(i), edge(i + 1));
            let frequency = from * (to / from).powf(part());
            Component {
                amplitude: (2.0 * spectrum.between(from, to)).sqrt(),
                frequency,
                number: frequency * frequency / GRAVITY,
                phase: TAU * part(),
            }
        };
        Ok(Self::of((0..components).map(component).collect(), heading))
    }

    /// A sea of these components, the longest waves first.
    pub fn of(components: Vec<Component>, heading: f64) -> Self {
        Self { components: components.into(), direction: [heading.cos(), heading.sin()] }
    }

    /// The waves that it is made of.
    pub fn components(&self) -> &[Component] {
        &self.components
    }

    /// The gradient of E by `i k E`, north, east and down: n.
    pub(crate) fn gradient(&self) -> [Complex64; 3] {
        let [north, east] = self.direction;
        [north.into(), east.into(), Complex64::I]
    }

    /// The components that reach a place, with E of each.
    pub(crate) fn at(&self, place: Place) -> impl Iterator<Item = (&Component, Complex64)> {
        let Place { time, north, east, depth } = place;
        let along = north * self.direction[0] + east * self.direction[1];
        let felt = self.components.iter().take_while(move |wave| wave.number * depth < DEEPEST);
        felt.map(move |wave| {
            let angle = wave.number * along - wave.frequency * time + wave.phase;
            (wave, Complex64::from_polar(wave.amplitude * (-wave.number * depth).exp(), angle))
        })
    }

    /// Returns how far the surface is above the still water at a place north and east, and a time \[m\].
    pub fn elevation(&self, time: f64, [north, east]: [f64; 2]) -> f64 {
        self.at(Place { time, north, east, depth: 0.0 }).map(|(_, wave)| wave.re).sum()
    }

    /// Returns the orbital motion of the water at a place. Above the still water it is that of linear theory continued,
    /// and too large.
    pub fn motion(&self, place: Place) -> WaterMotion {
        let mut orbits = Orbits::default();
        self.at(place).for_each(|(wave, value)| orbits.add(wave, value));
        orbits.motion(self)
    }
}

/// Returns the frequency `|w - k U cos(heading)|` at which a vehicle that makes U over ground \[m/s\] meets waves of
/// the frequency w \[rad/s\] and a heading \[rad\].
pub fn encounter_frequency(frequency: f64, heading: f64, speed: f64) -> f64 {
    (frequency - frequency * frequency / GRAVITY * speed * heading.cos()).abs()
}

/// The sums of `w E`, `w^2 E` and `w k E` over the components: all that a long-crested sea moves the water by.
#[derive(Default)]
pub(crate) struct Orbits([Complex64; 3]);

impl Orbits {
    pub(crate) fn add(&mut self, wave: &Component, value: Complex64) {
        let moved = wave.frequency * value;
        let parts = [moved, wave.frequency * moved, wave.number * moved];
        self.0.iter_mut().zip(parts).for_each(|(sum, part)| *sum += part);
    }

    /// The velocity grows by `-i w` in time and by `i k n` over the place.
    pub(crate) fn motion(&self, waves: &Waves) -> WaterMotion {
        let (Self([moved, by_time, by_place]), n) = (self, waves.gradient());
        WaterMotion {
            velocity: n.map(|part| (part * moved).re),
            by_time: n.map(|part| (part * by_time).im),
            by_place: n.map(|way| n.map(|part| -(way * part * by_place).im)),
        }
    }
}
