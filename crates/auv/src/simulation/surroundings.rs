//! The water about one vehicle: waves about its hull, and a current in layers.

use squid_sea::{Axes, GRAVITY, Layers, Place, SeaError, Spheroid, Waves};
use std::f64::consts::PI;

use crate::simulation::load::{Load, sum};
use crate::simulation::water::{Pose, Water, WaterMotion};
use crate::vehicle::coefficients::Coefficients;
use crate::vehicle::geometry::Geometry;

/// Where the length of a hull is looked at, in halves of it from its middle: its ends are points below the surface.
const STATIONS: [f64; 5] = [-0.9, -0.5, 0.0, 0.5, 0.9];

/// Waves about a hull, and a current in layers.
#[derive(Clone, Debug)]
pub struct Surroundings {
    waves: Option<(Waves, Spheroid)>,
    /// The centre of buoyancy, forward and down in the body \[m\].
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

    /// The surface above the still water at a place north and east \[m\].
    pub fn elevation(&self, time: f64, place: [f64; 2]) -> f64 {
        self.waves.as_ref().map_or(0.0, |(waves, _)| waves.elevation(time, place))
    }

    /// How deep the hull is below the surface where it is nearest \[m\], negative out of it; where no waves are, that
    /// is the depth.
    pub fn clearance(&self, time: f64, pose: &Pose) -> f64 {
        let Some((waves, hull)) = &self.waves else { return pose.depth };
        let Place { north, east, depth, .. } = self.centre_at(time, pose, &pose.axes());
        let (sin, cos) = pose.heading.sin_cos();
        let below = |station: f64| {
            let [along, top] = hull.top(station, pose.pitch);
            depth - top + waves.elevation(time, [north + along * cos, east + along * sin])
        };
        STATIONS.into_iter().map(below).fold(f64::INFINITY, f64::min)
    }

    /// Where the centre of buoyancy is.
    fn centre_at(&self, time: f64, pose: &Pose, [ahead, _, below]: &Axes) -> Place {
        let [along, down] = self.centre;
        let at = |i: usize, origin: f64| origin + along * ahead[i] + down * below[i];
        Place { time, north: at(0, pose.north), east: at(1, pose.east), depth: at(2, pose.depth) }
    }

    /// A load about the centre of buoyancy, about the origin.
    fn about_origin(&self, [x, y, z, k, m, n]: Load) -> Load {
        let [along, down] = self.centre;
        [x, y, z, k - down * y, m + down * x - along * z, n + along * y]
    }
}

impl Water for Surroundings {
    /// The waves are those at the centre of buoyancy.
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
            all.by_turn = turning(pose, centre, &axes).map(|moved| along(moved, motion.by_place).into());
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
        for (slope, moved) in slopes[4..].iter_mut().zip(turning(pose, centre, &axes)) {
            *slope = sum(*slope, along(moved, by_place));
        }
        slopes.map(|slope| self.about_origin(slope))
    }
}

/// How the centre of buoyancy moves as the body turns about each of its axes, and the origin stays: north, east and
/// down by rad.
fn turning(pose: &Pose, centre: Place, axes: &Axes) -> Axes {
    let [x, y, z] = [centre.north - pose.north, centre.east - pose.east, centre.depth - pose.depth];
    axes.map(|[a, b, c]| [b * z - c * y, c * x - a * z, a * y - b * x])
}

/// What changes by the place, for who moves north, east and down.
fn along<const N: usize>([north, east, down]: [f64; 3], slopes: [[f64; N]; 3]) -> [f64; N] {
    std::array::from_fn(|i| slopes[0][i] * north + slopes[1][i] * east + slopes[2][i] * down)
}

/// The spheroid as slender as the hull that displaces what the vehicle does, with the added mass of the vehicle.
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
