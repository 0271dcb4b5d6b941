//! Vehicle in the vertical plane, without the parts that move it out of the plane.

#![allow(non_snake_case, reason = "the field's symbols keep their capitals: Z is a force, z a length")]

use crate::vehicle::Vehicle;
use crate::vehicle::actuator::{Actuator, Effect};
use crate::vehicle::coefficients::COEFFICIENTS;

impl Vehicle {
    /// Returns the vehicle in the vertical plane: without the coefficients of sway, roll and yaw, without the actuators
    /// that act in these only, and without the lateral forces of the others. A thruster with an azimuth becomes a group
    /// of one.
    #[must_use]
    pub fn in_plane(&self) -> Self {
        let mut plane = self.clone();
        let lateral = || COEFFICIENTS.iter().filter(|spec| spec.acts_out_of_plane());
        for spec in lateral() {
            (spec.set)(&mut plane.coefficients, 0.0);
        }
        let all = || self.actuators.iter().chain(&self.others);
        plane.actuators = all().filter(|one| one.acts_in_plane()).map(Actuator::in_plane).collect();
        plane.others.clear();
        let of_plane = |key: &str| match key.split_once('.') {
            // Source of an actuator, or of a thruster in its group.
            Some((name, number)) => {
                let number = number.rsplit('.').next().unwrap_or(number);
                let removed = all().any(|one| one.name == name && !one.acts_in_plane());
                !(removed || Effect::acts_out_of_plane(number))
            }
            None => lateral().all(|spec| spec.key != key),
        };
        let sources = self.sources.iter().filter(|(key, _)| of_plane(key));
        plane.sources = sources.map(|(key, source)| (key.clone(), source.clone())).collect();
        plane
    }

    /// Returns the outputs of all actuators from those of the vehicle in the `plane`; 0 for the others.
    pub fn outputs_of_plane(&self, plane: &Self, outputs: &[f64]) -> Vec<f64> {
        let of = |one: &Actuator| plane.actuators.iter().position(|other| other.name == one.name);
        let output = |one| of(one).and_then(|index| outputs.get(index)).copied().unwrap_or_default();
        self.actuators.iter().map(output).collect()
    }

    /// Returns the lateral coefficients, with their values, that the vehicle file does not contain, so that they are
    /// those of an axisymmetric hull or zero; none for a vehicle that stays in the vertical plane.
    pub fn supposed(&self) -> Vec<(&'static str, f64)> {
        let c = &self.coefficients;
        let missing = COEFFICIENTS
            .iter()
            .filter(|spec| spec.acts_out_of_plane() && !self.sources.contains_key(spec.key));
        let all = missing.map(|spec| (spec.key, (spec.get)(c)));
        if c.leaves_plane() { all.collect() } else { vec![] }
    }
}

impl Actuator {
    /// Returns `true` if the actuator moves the vehicle in the vertical plane, or has no effect at all.
    pub fn acts_in_plane(&self) -> bool {
        let alone = self.effect.map(|key, value| if key == "X_uu_delta2" { 0.0 } else { value });
        alone.force(1.0, 1.0) != [0.0; 3] || !self.effect.leaves_plane()
    }

    /// Returns `true` if the actuator has a sway force, roll moment or yaw moment.
    pub fn acts_out_of_plane(&self) -> bool {
        self.effect.leaves_plane()
    }

    /// Returns `true` if the actuator yaws the vehicle without effect in the vertical plane.
    pub(crate) fn yaws_alone(&self) -> bool {
        !self.acts_in_plane() && self.lateral_force(1.0, 1.0)[2] != 0.0
    }

    /// Returns `true` if the actuator has a roll moment only.
    pub(crate) fn rolls_alone(&self) -> bool {
        let [sway, roll, yaw] = self.lateral_force(1.0, 1.0);
        !self.acts_in_plane() && roll != 0.0 && sway == 0.0 && yaw == 0.0
    }

    fn in_plane(&self) -> Self {
        let effect = match self.effect {
            Effect::Thruster { azimuth, .. } if azimuth != 0.0 => {
                let [X_T, Z_T, M_T] = self.effect.force(0.0, 1.0);
                Effect::thruster_group(X_T, Z_T, M_T)
            }
            _ => self.effect.map(|key, value| if Effect::acts_out_of_plane(key) { 0.0 } else { value }),
        };
        Self { effect, ..self.clone() }
    }
}
