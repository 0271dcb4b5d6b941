//! Effect of regular waves on the linear motion about a trim.

use nalgebra::DMatrix;
use squid_sea::{Component, GRAVITY, SeaError, Waves};
use std::f64::consts::FRAC_PI_2;

use crate::motion::dynamics::Dynamics;
use crate::motion::linearise::Linearisation;
use crate::simulation::load::in_plane;
use crate::simulation::surroundings::Surroundings;
use crate::simulation::water::{Pose, Water};
use crate::vehicle::geometry::Geometry;

/// Regular waves above a vehicle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RegularWaves {
    /// Wave frequency for a stationary observer \[rad/s\].
    pub frequency: f64,
    /// Direction of propagation relative to the vehicle's heading \[rad\].
    pub heading: f64,
    /// Depth of the vehicle \[m\].
    pub depth: f64,
}

impl Linearisation {
    /// Returns the linearisation with [`Linearisation::by_waves`]: the vehicle in trim, on a level path through the
    /// waves.
    ///
    /// The velocities are relative to the moving water: `v_r' = M^-1 load - R v_w'`.
    ///
    /// # Errors
    /// [`SeaError`] of the hull.
    pub fn in_waves(
        mut self,
        dynamics: &Dynamics,
        geometry: Geometry,
        waves: &RegularWaves,
    ) -> Result<Self, SeaError> {
        let (coefficients, trim) = (dynamics.coefficients(), &self.trim);
        let RegularWaves { frequency, heading, depth } = *waves;
        let mut columns = vec![];
        // A crest above the vehicle, and the same wave a quarter of a period later.
        for phase in [0.0, -FRAC_PI_2] {
            let wave =
                Component { amplitude: 1.0, frequency, number: frequency * frequency / GRAVITY, phase };
            let water = Surroundings::still(coefficients).with_waves(
                Waves::of(vec![wave], heading),
                geometry,
                coefficients,
            )?;
            let water_motion = water.at(0.0, &Pose::in_plane(0.0, depth, trim.pitch));
            let [du, dw, dq] = dynamics.load_acceleration(in_plane(water_motion.load));
            let (along, across) = water_motion.along([trim.speed, 0.0, 0.0], [0.0; 3]).along_body(trim.pitch);
            let all = [du - along, dw - across, dq, 0.0, water_motion.velocity.vertical];
            columns.extend(all.iter().skip(coefficients.surge.first()).take(self.states.len()));
        }
        self.by_waves = Some(DMatrix::from_vec(self.a.nrows(), 2, columns));
        Ok(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Plant, Speed, Vehicle, linearise, trim};
    use std::sync::Arc;

    /// Response of the nonlinear vehicle from trim, under a crest and a quarter of a period later, against the linear
    /// rates.
    #[test]
    fn columns_match_the_nonlinear_response() {
        for name in ["squid", "remus100", "lauv"] {
            let file = format!("{}/../../vehicles/{name}/vehicle.toml", env!("CARGO_MANIFEST_DIR"));
            let vehicle = Vehicle::parse(&std::fs::read_to_string(file).unwrap(), "vehicle.toml").unwrap();
            let vehicle = vehicle.in_plane();
            let (geometry, coefficients) = (vehicle.geometry.unwrap(), &vehicle.coefficients);
            let dynamics = Dynamics::new(coefficients).unwrap();
            for (frequency, heading) in [(1.1, 2.8), (1.9, 0.4)] {
                let level = trim(&vehicle, Speed::Path(1.8), 4.0).unwrap();
                let waves = RegularWaves { frequency, heading, depth: 4.0 };
                let linear =
                    linearise(&vehicle, &level).unwrap().in_waves(&dynamics, geometry, &waves).unwrap();
                for (column, phase) in [0.0, -FRAC_PI_2].into_iter().enumerate() {
                    let (h, amplitude) = (1e-4, 1e-3);
                    let after = |amplitude: f64| {
                        let number = frequency * frequency / GRAVITY;
                        let wave = Component { amplitude, frequency, number, phase };
                        let water = Surroundings::still(coefficients)
                            .with_waves(Waves::of(vec![wave], heading), geometry, coefficients)
                            .unwrap();
                        let mut plant = Plant::new(&vehicle).unwrap().with_water(Arc::new(water));
                        plant.start(0.0, &level).unwrap();
                        for (index, output) in level.actuators.iter().enumerate() {
                            plant.set_command(index, *output).unwrap();
                        }
                        plant.advance(h).unwrap();
                        let motion = plant.state().motion;
                        [motion.u, motion.w, motion.q, motion.theta]
                    };
                    let (up, down) = (after(amplitude), after(-amplitude));
                    let expected = linear.by_waves.as_ref().unwrap().column(column).into_owned();
                    let size = expected.amax();
                    for i in 0..4 {
                        let slope = (up[i] - down[i]) / (2.0 * amplitude * h);
                        assert!(
                            (slope - expected[i]).abs() < 1e-3 * size,
                            "{name}, state {i}: {slope} {}",
                            expected[i]
                        );
                    }
                }
            }
        }
    }
}
