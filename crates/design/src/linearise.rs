//! Trims over the range of speed, and the linear model at each.

pub mod envelope;
pub mod sensors;
pub mod turning;

use crate::axis::{Linearisation, OperatingPoint, VehicleModel};
use crate::error::ModelError;
use crate::inputs::design_file::{DesignFile, UncertainParameter};
use serde_json::{Map, Value, json};
use squid_auv::{
    Actuator, Dynamics, Pitch, Speed, State, Status, Trim, Vehicle, View, linearise, linearise_with,
    trim_with, trims,
};
use squid_lpv::matrix::{Mat, block, to_rows};
use squid_scheduled::{ReferenceLimits, Sensor};
use squid_signals::{Interface, States};
use std::collections::BTreeMap;

/// Number of speeds of a trim table, evenly spaced over the range of a design; its trims lie on one branch.
pub const TRIM_ROWS: usize = 101;

/// Vehicle in the level flight of a design file, reduced to one axis.
#[derive(Debug, Clone, Copy)]
pub struct LevelFlight<'a> {
    /// Vehicle reduced to the axis.
    pub vehicle: &'a Vehicle,
    /// Vehicle in the vertical plane, which is in trim: the same for surge, heave and pitch.
    pub plane: &'a Vehicle,
    /// Design file: its depth, its pitch in trim, its waves, and its measurements.
    pub file: &'a DesignFile,
    /// Uncertain coefficients of the design.
    pub uncertain: &'a [UncertainParameter],
}

impl VehicleModel for LevelFlight<'_> {
    fn name(&self) -> &str {
        &self.vehicle.name
    }

    fn status(&self) -> Status {
        self.vehicle.status
    }

    fn interface(&self) -> &'static Interface {
        self.file.interface
    }

    fn states(&self) -> States {
        (self.file.view().states)(self.vehicle, &|index| self.file.uses(index))
    }

    fn actuators(&self) -> &[Actuator] {
        &self.vehicle.actuators
    }

    /// Lateral axes do not control the speed; that is the task of the axis of level flight.
    fn is_speed_given(&self) -> bool {
        self.file.view().is_level_held || self.vehicle.coefficients.surge.is_given()
    }

    fn trims(&self, speeds: &[f64]) -> Result<Vec<OperatingPoint>, ModelError> {
        Ok(self.level(speeds)?.iter().map(|trim| operating_point(trim, self.states())).collect())
    }

    fn trim_slopes(&self, speeds: &[f64]) -> Result<Vec<Mat>, ModelError> {
        let slope = |trim: &Trim| {
            let l = linearise_with(self.vehicle, trim, self.states())?;
            Ok(column(&l.trim_slope(&self.vehicle.actuators)))
        };
        self.level(speeds)?.iter().map(slope).collect()
    }

    fn envelope(&self, speeds: &[f64]) -> Result<BTreeMap<String, ReferenceLimits>, ModelError> {
        let trims = self.level(speeds)?;
        if self.file.tracks("heading").is_some() {
            turning::envelope(self.vehicle, self.file, self.uncertain, &trims)
        } else if self.file.view().is_level_held {
            Ok(BTreeMap::new())
        } else {
            envelope::envelope(self.vehicle, self.file, &trims)
        }
    }

    fn sensors(&self, speeds: &[f64]) -> Result<BTreeMap<String, Sensor>, ModelError> {
        sensors::sensors([self.vehicle, self.plane], self.file, &self.level(speeds)?)
    }

    fn linearise(&self, speed: f64) -> Result<Linearisation, ModelError> {
        Ok(Linearisation::of(&self.at(speed)?, &self.vehicle.actuators))
    }
}

impl LevelFlight<'_> {
    /// Returns the ends of the envelope at increasing speeds, nose down and up, for references of pitch or of depth.
    ///
    /// # Errors
    /// [`ModelError::Trim`].
    pub fn ends(&self, speeds: &[f64], depth: bool) -> Result<Vec<[envelope::End; 2]>, ModelError> {
        let both = |trim: &Trim| envelope::End::both(self.vehicle, &self.file.envelope, trim, depth);
        Ok(self.level(speeds)?.iter().map(both).collect())
    }

    /// Returns the level trims at increasing speeds, on one branch.
    ///
    /// # Errors
    /// [`ModelError::Trim`]: no trim at a speed, or trims that do not lie on one branch.
    pub fn level(&self, speeds: &[f64]) -> Result<Vec<Trim>, ModelError> {
        let (depth, pitch) = self.file.level();
        let found = trims(self.plane, depth, speeds, pitch).map_err(ModelError::Trim)?;
        Ok(found.into_iter().map(|trim| self.axis_trim(trim)).collect())
    }

    /// Adapts a trim to the actuators of the axis: those of a lateral axis are at 0.
    fn axis_trim(&self, trim: Trim) -> Trim {
        if self.file.view().is_level_held {
            Trim { actuators: vec![0.0; self.vehicle.actuators.len()], ..trim }
        } else {
            trim
        }
    }

    /// Linearises the vehicle about the level trim at a speed V along the path \[m/s\]: `x' = A x + B u`, with the
    /// states of the axis in SI units and one input per actuator, as deviations from the trim. If the design has a
    /// `[sea]`, the linearisation includes its waves.
    ///
    /// # Errors
    /// [`ModelError::Trim`] with the speed and the reason; [`ModelError::Waves`].
    pub fn at(&self, speed: f64) -> Result<squid_auv::Linearisation, ModelError> {
        let (depth, pitch) = self.file.level();
        let level = trim_with(self.plane, Speed::Path(speed), depth, pitch).map_err(ModelError::Trim)?;
        let still = linearise_with(self.vehicle, &self.axis_trim(level), self.states())?;
        match self.file.sea.as_ref().zip(self.vehicle.geometry) {
            None => Ok(still),
            Some((sea, geometry)) => {
                Ok(still.in_waves(&Dynamics::new(&self.vehicle.coefficients)?, geometry, &sea.regular())?)
            }
        }
    }
}

impl Linearisation {
    /// Returns the motion of a vehicle with these actuators.
    pub fn of(l: &squid_auv::Linearisation, actuators: &[Actuator]) -> Self {
        Self {
            a: l.a.clone(),
            b: l.b.clone(),
            states: l.states,
            trim: operating_point(&l.trim, l.states),
            trim_slope: column(&l.trim_slope(actuators)),
            by_waves: l.by_waves.clone(),
        }
    }
}

fn operating_point(trim: &Trim, states: States) -> OperatingPoint {
    let view = View::of_states(states);
    let level = State::in_plane(trim.motion(), 0.0, trim.depth);
    let signals = view.sensed.iter().map(|one| (one.value)(&level)).collect();
    OperatingPoint { speed: trim.speed, signals, actuators: trim.actuators.clone() }
}

fn column(vector: &nalgebra::DVector<f64>) -> Mat {
    Mat::from_column_slice(vector.len(), 1, vector.as_slice())
}

/// Linearises a vehicle without a design, about the level trim at a depth \[m\].
///
/// # Errors
/// [`ModelError::Trim`].
pub fn linearise_vehicle(
    vehicle: &Vehicle,
    depth: f64,
    speed: f64,
) -> Result<squid_auv::Linearisation, ModelError> {
    let pitch = Pitch::over(vehicle, depth, &[speed], None);
    let level = trim_with(vehicle, Speed::Path(speed), depth, &pitch).map_err(ModelError::Trim)?;
    Ok(linearise(vehicle, &level)?)
}

/// Returns trim, A, B and eigenvalues at one speed as JSON.
pub fn to_json(vehicle: &Vehicle, l: &squid_auv::Linearisation) -> Value {
    let t = &l.trim;
    let outputs = vehicle.actuators.iter().zip(&t.actuators);
    let actuators: Map<String, Value> = outputs.map(|(a, output)| (a.name.clone(), json!(output))).collect();
    json!({
        "trim": {
            "speed": t.speed,
            "depth": t.depth,
            "pitch": t.pitch,
            "forward_speed": t.forward_speed,
            "heave": t.heave,
            "actuators": actuators,
        },
        "states": l.states.iter().map(|state| state.symbol).collect::<Vec<_>>(),
        "A": to_rows(&l.a),
        "B": to_rows(&l.b),
        "eigenvalues": l.eigenvalues().iter().map(|v| [v.re, v.im]).collect::<Vec<_>>(),
    })
}

/// Returns `[A B]`.
pub fn stacked(a: &Mat, b: &Mat) -> Mat {
    block(&[&[a, b]])
}

/// Splits `[A B]` into A and B.
pub fn split(stacked: &Mat) -> (Mat, Mat) {
    let (n, columns) = stacked.shape();
    (stacked.columns(0, n).into_owned(), stacked.columns(n, columns - n).into_owned())
}

/// Scales `[A B]`, or other rows with columns for states and inputs, to inputs in units of their reach.
pub fn scaled(actuators: &[Actuator], mut stacked: Mat) -> Mat {
    let n = stacked.ncols() - actuators.len();
    for (j, actuator) in actuators.iter().enumerate() {
        stacked.column_mut(n + j).scale_mut(actuator.reach());
    }
    stacked
}
