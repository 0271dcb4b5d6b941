//! A long-crested sea: components with random phases, and the motion of the water under them.
//!
//! Linear theory in deep water: the component `E = a exp(-k depth + i (k x cos(heading) - w t + phase))`, `w^2 = g k`,
//! has the elevation Re E at depth 0, upward, the pressure `density g Re E`, and the velocity `[w cos(heading) Re E, -w
//! Im E]`, \[forward, down\]. Source: Newman, Marine Hydrodynamics (1977), chapter 6.

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
    /// Horizontal, the way the vehicle faces \[m\].
    pub x: f64,
    /// Below the still water \[m\].
    pub depth: f64,
}

/// How the water moves at a place: each \[forward, down\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WaterMotion {
    /// m/s.
    pub velocity: [f64; 2],
    /// Its derivative by time, at the place \[m/s2\].
    pub by_time: [f64; 2],
    /// Its derivative by x \[1/s\].
    pub by_x: [f64; 2],
    /// Its derivative by depth \[1/s\].
    pub by_depth: [f64; 2],
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
    /// At x = 0 and time 0 \[rad\].
    pub phase: f64,
}

/// A long-crested sea.
#[derive(Clone, Debug, PartialEq)]
pub struct Waves {
    components: Arc<[Component]>,
    cos_heading: f64,
}

impl Waves {
    /// The usual number of components.
    pub const USUAL: usize = 100;

    /// A sea of a spectrum, the same for the same seed.
    ///
    /// `heading` \[rad\] is where the waves go, from the way the vehicle faces: pi for a head sea, 0 for a following
    /// one.
    /// The frequencies from half to ten times that of the peak are cut at constant ratios into `components` intervals.
    /// Each has one wave, with the energy of its interval, of a frequency drawn in it, so that the sea does not repeat,
    /// and of a phase drawn from all.
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
        Self { components: components.into(), cos_heading: heading.cos() }
    }

    /// The waves that it is made of.
    pub fn components(&self) -> &[Component] {
        &self.components
    }

    /// The cosine of the heading.
    pub(crate) fn cos_heading(&self) -> f64 {
        self.cos_heading
    }

    /// The components that reach a place, with E of each.
    pub(crate) fn at(&self, place: Place) -> impl Iterator<Item = (&Component, Complex64)> {
        let Place { time, x, depth } = place;
        let along = x * self.cos_heading;
        let felt = self.components.iter().take_while(move |wave| wave.number * depth < DEEPEST);
        felt.map(move |wave| {
            let angle = wave.number * along - wave.frequency * time + wave.phase;
            (wave, Complex64::from_polar(wave.amplitude * (-wave.number * depth).exp(), angle))
        })
    }

    /// Returns how far the surface is above the still water at x and a time \[m\].
    pub fn elevation(&self, time: f64, x: f64) -> f64 {
        self.at(Place { time, x, depth: 0.0 }).map(|(_, wave)| wave.re).sum()
    }

    /// Returns the orbital motion of the water at a place. Above the still water it is that of linear theory continued,
    /// and too large.
    pub fn motion(&self, place: Place) -> WaterMotion {
        let mut motion = WaterMotion::default();
        self.at(place).for_each(|(wave, value)| motion.add(wave, value, self.cos_heading));
        motion
    }
}

/// Returns the frequency `|w - k U cos(heading)|` at which a vehicle that makes U over ground \[m/s\] meets waves of
/// the frequency w \[rad/s\] and a heading \[rad\].
pub fn encounter_frequency(frequency: f64, heading: f64, speed: f64) -> f64 {
    (frequency - frequency * frequency / GRAVITY * speed * heading.cos()).abs()
}

impl WaterMotion {
    /// Adds that of a component with E at the place: the velocity grows by `-i w` in time, `i k cos(heading)` in x and
    /// `-k` in depth.
    pub(crate) fn add(&mut self, wave: &Component, value: Complex64, cos_heading: f64) {
        let Component { frequency, number, .. } = *wave;
        let forward = frequency * cos_heading * value;
        let down = frequency * Complex64::I * value;
        let along = Complex64::I * (number * cos_heading);
        for (i, velocity) in [forward, down].into_iter().enumerate() {
            self.velocity[i] += velocity.re;
            self.by_time[i] += frequency * velocity.im;
            self.by_x[i] += (along * velocity).re;
            self.by_depth[i] -= number * velocity.re;
        }
    }
}
