//! Water that moves otherwise from place to place and from time to time, and pushes.

use std::fmt::Debug;

use crate::motion::dynamics::Motion;
use crate::simulation::current::Current;
use crate::simulation::load::Load;

/// Where a vehicle is and how it lies; in the vertical plane north is the way that it faces.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// The way made north \[m\].
    pub north: f64,
    /// The way made east \[m\].
    pub east: f64,
    /// m.
    pub depth: f64,
    /// Positive starboard down \[rad\].
    pub roll: f64,
    /// Positive bow up \[rad\].
    pub pitch: f64,
    /// Clockwise from north \[rad\].
    pub heading: f64,
}

impl Pose {
    /// In the vertical plane.
    pub fn in_plane(north: f64, depth: f64, pitch: f64) -> Self {
        Self { north, depth, pitch, ..Self::default() }
    }

    /// The axes of the body, forward, to starboard and down: each north, east and down.
    pub(crate) fn axes(&self) -> [[f64; 3]; 3] {
        let axis = |u, v, w| {
            let still = Motion::in_plane(u, w, 0.0, self.pitch);
            Motion { v, phi: self.roll, ..still }.velocity(self.heading)
        };
        [axis(1.0, 0.0, 0.0), axis(0.0, 1.0, 0.0), axis(0.0, 0.0, 1.0)]
    }
}

/// What the water does to a vehicle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WaterMotion {
    /// How it moves where the vehicle is \[m/s\].
    pub velocity: Current,
    /// The derivative of that by time, at the place \[m/s2\].
    pub by_time: Current,
    /// By the way north, by that east and by depth \[1/s\].
    pub by_place: [Current; 3],
    /// By a turn about each axis of the body, which moves the place that counts about the origin \[m/s\].
    pub by_turn: [Current; 3],
    /// The load of its pressure beyond buoyancy.
    pub load: Load,
}

impl WaterMotion {
    /// Returns how fast the velocity changes for who moves over ground, north, east and down, and turns about the axes
    /// of the body: `v_t + v_x x' + v_y y' + v_z z' + v_1 p + v_2 q + v_3 r`.
    pub(crate) fn along(&self, place: [f64; 3], turn: [f64; 3]) -> Current {
        let sum = |slopes: [Current; 3], rates: [f64; 3]| {
            let pairs = slopes.into_iter().zip(rates);
            pairs.fold(Current::default(), |sum, (slope, rate)| sum.after(rate, slope))
        };
        self.by_time + sum(self.by_place, place) + sum(self.by_turn, turn)
    }
}

/// Water that has a motion at each place and time, beside a steady current.
pub trait Water: Debug + Send + Sync {
    /// Returns what it does at a time \[s\] to a vehicle.
    fn at(&self, time: f64, pose: &Pose) -> WaterMotion;

    /// Returns the derivatives of the load there by time \[N/s, N m/s\], by the way north, that east and depth \[N/m,
    /// N\], and by a turn about each axis of the body \[N/rad, N m/rad\].
    fn load_slopes(&self, time: f64, pose: &Pose) -> [Load; 7];
}
