//! Water whose motion varies in space and time and loads the vehicle.

use std::fmt::Debug;

use crate::motion::dynamics::Motion;
use crate::simulation::current::Current;
use crate::simulation::load::Load;

/// Position and attitude of a vehicle; in the vertical plane, north is along its heading.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// Position north \[m\].
    pub north: f64,
    /// Position east \[m\].
    pub east: f64,
    /// Depth \[m\].
    pub depth: f64,
    /// Roll \[rad\], positive starboard down.
    pub roll: f64,
    /// Pitch \[rad\], positive bow up.
    pub pitch: f64,
    /// Heading \[rad\], clockwise from north.
    pub heading: f64,
}

impl Pose {
    /// Returns a pose in the vertical plane.
    pub fn in_plane(north: f64, depth: f64, pitch: f64) -> Self {
        Self { north, depth, pitch, ..Self::default() }
    }

    /// Returns the body axes, forward, to starboard and down: each as north, east and down.
    pub(crate) fn axes(&self) -> [[f64; 3]; 3] {
        let axis = |u, v, w| {
            let still = Motion::in_plane(u, w, 0.0, self.pitch);
            Motion { v, phi: self.roll, ..still }.velocity(self.heading)
        };
        [axis(1.0, 0.0, 0.0), axis(0.0, 1.0, 0.0), axis(0.0, 0.0, 1.0)]
    }
}

/// Motion of the water at a vehicle, and its load.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WaterMotion {
    /// Velocity at the vehicle \[m/s\].
    pub velocity: Current,
    /// Derivative of the velocity with respect to time at a fixed position \[m/s2\].
    pub by_time: Current,
    /// Derivatives of the velocity with respect to north, east and depth \[1/s\].
    pub by_place: [Current; 3],
    /// Derivatives of the velocity with respect to a rotation about each body axis, which moves the reference point
    /// about the origin \[m/s\].
    pub by_turn: [Current; 3],
    /// Load of the water pressure beyond hydrostatic buoyancy.
    pub load: Load,
}

impl WaterMotion {
    /// Returns the rate of the velocity along a motion over ground, north, east and down, and a rotation about the body
    /// axes: `v_t + v_x x' + v_y y' + v_z z' + v_1 p + v_2 q + v_3 r`.
    pub(crate) fn along(&self, place: [f64; 3], turn: [f64; 3]) -> Current {
        let sum = |slopes: [Current; 3], rates: [f64; 3]| {
            let pairs = slopes.into_iter().zip(rates);
            pairs.fold(Current::default(), |sum, (slope, rate)| sum.after(rate, slope))
        };
        self.by_time + sum(self.by_place, place) + sum(self.by_turn, turn)
    }
}

/// Water with a motion at each position and time, in addition to a steady current.
pub trait Water: Debug + Send + Sync {
    /// Returns the motion and load of the water at a time \[s\] for a pose.
    fn at(&self, time: f64, pose: &Pose) -> WaterMotion;

    /// Returns the derivatives of the load with respect to time \[N/s, N m/s\], to north, east and depth \[N/m, N\],
    /// and to a rotation about each body axis \[N/rad, N m/rad\].
    fn load_slopes(&self, time: f64, pose: &Pose) -> [Load; 7];
}
