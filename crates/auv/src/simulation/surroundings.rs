//! The water about one vehicle: waves about its hull, and a current in layers.

use squid_sea::{GRAVITY, Layers, Place, SeaError, Spheroid, Waves};
use std::f64::consts::PI;

use crate::simulation::current::Current;
use crate::simulation::water::{Water, WaterMotion};
use crate::vehicle::coefficients::Coefficients;
use crate::vehicle::geometry::Geometry;

/// Where the length of a hull is looked at, in halves of it from its middle: its ends are points below the surface.
const STATIONS: [f64; 5] = [-0.9, -0.5, 0.0, 0.5, 0.9];

/// Waves about a hull, and a current in layers.
#[derive(Clone, Debug)]
pub struct Surroundings {
    waves: Option<(Waves, Spheroid)>,
    /// The centre of buoyancy, in the axes of the body \[m\].
    centre: [f64; 2],
    layers: Option<Layers>,
    vertical: f64,
}

impl Surroundings {
    /// Still water about a vehicle of these coefficients.
    pub fn still(coefficients: &Coefficients) -> Self {
        let Coefficients { x_B, z_B, .. } = *coefficients;
        Self { waves: None, centre: [x_B, z_B], layers: None, vertical: 0.0 }
    }

    /// With waves about a hull of this size: a spheroid as slender that displaces what the vehicle does, with the added
    /// mass of the vehicle.
    ///
    /// # Errors
    /// [`SeaError`] of the hull.
    pub fn with_waves(
        mut self,
        waves: Waves,
        geometry: Geometry,
        coefficients: &Coefficients,
    ) -> Result<Self, SeaError> {
        self.waves = Some((waves, hull(geometry, coefficients)?));
        Ok(self)
    }

    /// With a current that changes over depth, and a vertical one \[m/s\], positive down.
    #[must_use]
    pub fn with_current(mut self, layers: Layers, vertical: f64) -> Self {
        (self.layers, self.vertical) = (Some(layers), vertical);
        self
    }

    /// The surface above the still water at a distance x \[m\].
    pub fn elevation(&self, time: f64, x: f64) -> f64 {
        self.waves.as_ref().map_or(0.0, |(waves, _)| waves.elevation(time, x))
    }

    /// How deep the hull is below the surface where it is nearest \[m\], negative out of it; where no waves are, that
    /// is the depth.
    pub fn clearance(&self, time: f64, x: f64, depth: f64, pitch: f64) -> f64 {
        let Some((waves, hull)) = &self.waves else { return depth };
        let [x, depth] = self.centre_at([x, depth], pitch);
        let below = |station: f64| {
            let [along, top] = hull.top(station, pitch);
            depth - top + waves.elevation(time, x + along)
        };
        STATIONS.into_iter().map(below).fold(f64::INFINITY, f64::min)
    }

    /// The centre of buoyancy of a vehicle whose origin is at \[x, depth\].
    fn centre_at(&self, [x, depth]: [f64; 2], pitch: f64) -> [f64; 2] {
        let ([along, down], (sin, cos)) = (self.centre, pitch.sin_cos());
        [x + along * cos + down * sin, depth - along * sin + down * cos]
    }

    /// A load about the centre of buoyancy, about the origin.
    fn about_origin(&self, [surge, heave, moment]: [f64; 3]) -> [f64; 3] {
        let [along, down] = self.centre;
        [surge, heave, moment + down * surge - along * heave]
    }
}

impl Water for Surroundings {
    /// The waves are those at the centre of buoyancy.
    fn at(&self, time: f64, x: f64, depth: f64, pitch: f64) -> WaterMotion {
        let pair = |[horizontal, vertical]: [f64; 2]| Current { horizontal, vertical, ..Current::default() };
        let (velocity, slope) = self.layers.as_ref().map_or((0.0, 0.0), |layers| layers.at(depth));
        let mut all = WaterMotion {
            velocity: pair([velocity, self.vertical]),
            by_depth: pair([slope, 0.0]),
            ..WaterMotion::default()
        };
        if let Some((waves, hull)) = &self.waves {
            let origin = [x, depth];
            let [x, depth] = self.centre_at(origin, pitch);
            let (motion, load) = hull.in_waves(waves, Place { time, x, depth }, pitch);
            all.velocity = all.velocity + pair(motion.velocity);
            all.by_time = pair(motion.by_time);
            all.by_x = pair(motion.by_x);
            all.by_depth = all.by_depth + pair(motion.by_depth);
            let [moved, sunk] = turning(origin, [x, depth]);
            all.by_pitch = pair([0, 1].map(|i| motion.by_x[i] * moved + motion.by_depth[i] * sunk));
            all.load = self.about_origin(load);
        }
        all
    }

    fn load_slopes(&self, time: f64, x: f64, depth: f64, pitch: f64) -> [[f64; 3]; 4] {
        let Some((waves, hull)) = &self.waves else { return [[0.0; 3]; 4] };
        let origin = [x, depth];
        let [x, depth] = self.centre_at(origin, pitch);
        let [by_time, by_x, by_depth, mut by_pitch] =
            hull.slopes_in_waves(waves, Place { time, x, depth }, pitch);
        let [moved, sunk] = turning(origin, [x, depth]);
        for (i, slope) in by_pitch.iter_mut().enumerate() {
            *slope += moved * by_x[i] + sunk * by_depth[i];
        }
        [by_time, by_x, by_depth, by_pitch].map(|slope| self.about_origin(slope))
    }
}

/// The derivatives of the centre of buoyancy \[x, depth\] by pitch: it turns about the origin.
fn turning(origin: [f64; 2], centre: [f64; 2]) -> [f64; 2] {
    [centre[1] - origin[1], origin[0] - centre[0]]
}

/// The spheroid as slender as the hull that displaces what the vehicle does, with the added mass of the vehicle.
fn hull(geometry: Geometry, c: &Coefficients) -> Result<Spheroid, SeaError> {
    let slenderness = geometry.length / geometry.diameter;
    let volume = c.buoyancy / (c.density * GRAVITY);
    let radius = (3.0 * volume / (4.0 * PI * slenderness)).cbrt();
    let added_mass = [[-c.X_u_dot, 0.0, 0.0], [0.0, -c.Z_w_dot, -c.Z_q_dot], [0.0, -c.M_w_dot, -c.M_q_dot]];
    Spheroid::new(slenderness * radius, radius, c.density, added_mass)
}
