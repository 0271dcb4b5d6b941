//! Water around one vehicle: waves at its hull, and a current in layers.

use squid_sea::{Axes, GRAVITY, Layers, Position, SeaError, Spheroid, Waves};
use std::f64::consts::PI;

use crate::simulation::load::{Load, sum};
use crate::simulation::water::{Pose, Water, WaterMotion};
use crate::vehicle::coefficients::Coefficients;
use crate::vehicle::geometry::Geometry;

/// Stations along the hull for its clearance, in half lengths from the middle; the ends of a spheroid have no height.
const STATIONS: [f64; 5] = [-0.9, -0.5, 0.0, 0.5, 0.9];

/// Waves at a hull, and a current in layers.
#[derive(Clone, Debug)]
pub struct Surroundings {
    waves: Option<(Waves, Spheroid)>,
    /// Centre of buoyancy, forward and down in body axes \[m\].
    centre: [f64; 2],
    layers: Option<Layers>,
    vertical: f64,
}

impl Surroundings {
    /// Returns still water around a vehicle with these coefficients.
    pub fn still(coefficients: &Coefficients) -> Self {
        let Coefficients { x_B, z_B, .. } = *coefficients;
        Self { waves: None, centre: [x_B, z_B], layers: None, vertical: 0.0 }
    }

    /// Adds waves at a hull of this size: a spheroid of the same slenderness and displacement as the vehicle, with its
    /// added mass.
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

    /// Adds a current that changes over depth, and a vertical one \[m/s\], positive down.
    #[must_use]
    pub fn with_current(mut self, layers: Layers, vertical: f64) -> Self {
        (self.layers, self.vertical) = (Some(layers), vertical);
        self
    }

    /// Returns the elevation of the surface above the still water level at a position north and east \[m\].
    pub fn elevation(&self, time: f64, place: [f64; 2]) -> f64 {
        self.waves.as_ref().map_or(0.0, |(waves, _)| waves.elevation(time, place))
    }

    /// Returns the least depth of the hull below the surface \[m\], negative out of the water; without waves it is the
    /// depth of the vehicle.
    pub fn clearance(&self, time: f64, pose: &Pose) -> f64 {
        let Some((waves, hull)) = &self.waves else { return pose.depth };
        let Position { north, east, depth, .. } = self.centre_at(time, pose, &pose.axes());
        let (sin, cos) = pose.heading.sin_cos();
        let below = |station: f64| {
            let [along, top] = hull.top(station, pose.pitch);
            depth - top + waves.elevation(time, [north + along * cos, east + along * sin])
        };
        STATIONS.into_iter().map(below).fold(f64::INFINITY, f64::min)
    }

    /// Returns the position of the centre of buoyancy.
    fn centre_at(&self, time: f64, pose: &Pose, [ahead, _, below]: &Axes) -> Position {
        let [along, down] = self.centre;
        let at = |i: usize, origin: f64| origin + along * ahead[i] + down * below[i];
        Position { time, north: at(0, pose.north), east: at(1, pose.east), depth: at(2, pose.depth) }
    }

    /// Transfers a load from the centre of buoyancy to the origin.
    fn about_origin(&self, [x, y, z, k, m, n]: Load) -> Load {
        let [along, down] = self.centre;
        [x, y, z, k - down * y, m + down * x - along * z, n + along * y]
    }
}

impl Water for Surroundings {
    /// Returns the motion of the water, with the waves at the centre of buoyancy.
    fn at(&self, time: f64, pose: &Pose) -> WaterMotion {
        let (velocity, slope) = self.layers.as_ref().map_or((0.0, 0.0), |layers| layers.at(pose.depth));
        let mut all =
            WaterMotion { velocity: [velocity, 0.0, self.vertical].into(), ..WaterMotion::default() };
        all.by_place[2].horizontal = slope;
        if let Some((waves, hull)) = &self.waves {
            let axes = pose.axes();
            let centre = self.centre_at(time, pose, &axes);
            let (motion, load) = hull.in_waves(waves, centre, &axes);
            all.velocity = all.velocity + motion.velocity.into();
            all.by_time = motion.by_time.into();
            all.by_turn = displacements(pose, centre, &axes)
                .map(|displacement| along(displacement, motion.by_place).into());
            for (sum, slope) in all.by_place.iter_mut().zip(motion.by_place) {
                *sum = *sum + slope.into();
            }
            all.load = self.about_origin(load);
        }
        all
    }

    fn load_slopes(&self, time: f64, pose: &Pose) -> [Load; 7] {
        let Some((waves, hull)) = &self.waves else { return [[0.0; 6]; 7] };
        let axes = pose.axes();
        let centre = self.centre_at(time, pose, &axes);
        let mut slopes = hull.slopes_in_waves(waves, centre, &axes);
        let by_place = [slopes[1], slopes[2], slopes[3]];
        for (slope, displacement) in slopes[4..].iter_mut().zip(displacements(pose, centre, &axes)) {
            *slope = sum(*slope, along(displacement, by_place));
        }
        slopes.map(|slope| self.about_origin(slope))
    }
}

/// Returns the displacement of the centre of buoyancy per rotation of the body about each of its axes at a fixed
/// origin: north, east and down \[m/rad\].
fn displacements(pose: &Pose, centre: Position, axes: &Axes) -> Axes {
    let [x, y, z] = [centre.north - pose.north, centre.east - pose.east, centre.depth - pose.depth];
    axes.map(|[a, b, c]| [b * z - c * y, c * x - a * z, a * y - b * x])
}

/// Returns the directional derivative for a displacement north, east and down.
fn along<const N: usize>([north, east, down]: [f64; 3], slopes: [[f64; N]; 3]) -> [f64; N] {
    std::array::from_fn(|i| slopes[0][i] * north + slopes[1][i] * east + slopes[2][i] * down)
}

/// Returns the spheroid of the same slenderness and displacement as the vehicle, with its added mass.
fn hull(geometry: Geometry, c: &Coefficients) -> Result<Spheroid, SeaError> {
    let slenderness = geometry.length / geometry.diameter;
    let volume = c.buoyancy / (c.density * GRAVITY);
    let radius = (3.0 * volume / (4.0 * PI * slenderness)).cbrt();
    let added_mass = [
        [c.X_u_dot, 0.0, 0.0, 0.0, 0.0, 0.0],
        [0.0, c.Y_v_dot, 0.0, c.Y_p_dot, 0.0, c.Y_r_dot],
        [0.0, 0.0, c.Z_w_dot, 0.0, c.Z_q_dot, 0.0],
        [0.0, c.Y_p_dot, 0.0, c.K_p_dot, 0.0, c.K_r_dot],
        [0.0, 0.0, c.M_w_dot, 0.0, c.M_q_dot, 0.0],
        [0.0, c.Y_r_dot, 0.0, c.K_r_dot, 0.0, c.N_r_dot],
    ];
    let added_mass = added_mass.map(|row| row.map(|one| -one));
    Spheroid::new(slenderness * radius, radius, c.density, added_mass)
}
