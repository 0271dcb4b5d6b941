//! Water that moves otherwise from place to place and from time to time, and pushes.

use std::fmt::Debug;

use crate::simulation::current::Current;

/// What the water does to a vehicle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WaterMotion {
    /// How it moves where the vehicle is \[m/s\].
    pub velocity: Current,
    /// The derivative of that by time, at the place \[m/s2\].
    pub by_time: Current,
    /// By the horizontal distance \[1/s\].
    pub by_x: Current,
    /// By depth \[1/s\].
    pub by_depth: Current,
    /// By pitch, which moves the place that counts about the origin \[m/s\].
    pub by_pitch: Current,
    /// The force and the moment \[X Z M\] of its pressure beyond buoyancy, along the body and about its origin \[N, N
    /// m\].
    pub load: [f64; 3],
}

impl WaterMotion {
    /// Returns how fast the velocity changes for who moves over ground and turns: `v_t + v_x x' + v_z z' + v_theta
    /// theta'`.
    pub(crate) fn along(&self, [x_rate, depth_rate, pitch_rate]: [f64; 3]) -> Current {
        let sum = |part: fn(&Current) -> f64| {
            let moved = part(&self.by_x) * x_rate + part(&self.by_depth) * depth_rate;
            part(&self.by_time) + moved + part(&self.by_pitch) * pitch_rate
        };
        Current { horizontal: sum(|v| v.horizontal), vertical: sum(|v| v.vertical), ..Current::default() }
    }
}

/// Water that has a motion at each place and time, beside a steady current.
pub trait Water: Debug + Send + Sync {
    /// Returns what it does at a time \[s\] to a vehicle at a distance x and a depth \[m\], with a pitch \[rad\].
    fn at(&self, time: f64, x: f64, depth: f64, pitch: f64) -> WaterMotion;

    /// Returns the derivatives of the load there by time \[N/s, N m/s\], x and depth \[N/m, N\], and pitch \[N/rad, N
    /// m/rad\].
    fn load_slopes(&self, time: f64, x: f64, depth: f64, pitch: f64) -> [[f64; 3]; 4];
}
