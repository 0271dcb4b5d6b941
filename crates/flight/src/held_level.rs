//! The level flight that is held beside an axis of heading.

use crate::error::Error;
use squid_auv::{Pitch, Speed, Trim, TrimError, Vehicle, trim_with};
use std::collections::BTreeMap;

/// The level flight of a vehicle at the speed that is wanted.
pub(crate) struct HeldLevel {
    plane: Vehicle,
    rule: Pitch,
    trim: Trim,
    /// Trims at multiples of [`GRID`], or `None` where there is none.
    known: BTreeMap<i64, Option<Trim>>,
}

/// The distance of speeds along the path between which trims are interpolated, m/s; their error is its fourth power.
const GRID: f64 = 0.01;

impl HeldLevel {
    /// Begins with a trim of a vehicle in the vertical plane, whose pitch follows a rule.
    pub(crate) fn new(plane: Vehicle, rule: Pitch, trim: Trim) -> Self {
        Self { plane, rule, trim, known: BTreeMap::new() }
    }

    /// The trim last asked for.
    pub(crate) fn trim(&self) -> &Trim {
        &self.trim
    }

    /// The trim at a speed along the path: of a speed that changes, by a cubic through trims at four speeds nearby.
    pub(crate) fn at(&mut self, speed: f64) -> Result<&Trim, Error> {
        if speed != self.trim.speed {
            let trim = match self.between(speed) {
                Some(trim) => trim,
                None => self.solved(speed).map_err(|reason| Error::Trim { speed, reason })?,
            };
            self.trim = trim;
        }
        Ok(&self.trim)
    }

    fn solved(&self, speed: f64) -> Result<Trim, TrimError> {
        let (depth, actuators) = (self.trim.depth, self.trim.actuators.len());
        let trim = trim_with(&self.plane, Speed::Path(speed), depth, &self.rule)?;
        Ok(Trim { actuators: vec![0.0; actuators], ..trim })
    }

    /// The interpolated trim; `None` near the end of the speeds at which there is one.
    fn between(&mut self, speed: f64) -> Option<Trim> {
        if !speed.is_finite() {
            return None;
        }
        let below = (speed / GRID).floor();
        let part = speed / GRID - below;
        for place in below as i64 - 1..=below as i64 + 2 {
            if !self.known.contains_key(&place) {
                let trim = self.solved(place as f64 * GRID).ok();
                self.known.insert(place, trim);
            }
        }
        let near: Vec<&Trim> =
            (-1..=2).map(|step| self.known[&(below as i64 + step)].as_ref()).collect::<Option<_>>()?;
        let weights = [
            -part * (part - 1.0) * (part - 2.0) / 6.0,
            (part + 1.0) * (part - 1.0) * (part - 2.0) / 2.0,
            -(part + 1.0) * part * (part - 2.0) / 2.0,
            (part + 1.0) * part * (part - 1.0) / 6.0,
        ];
        let mean = |of: fn(&Trim) -> f64| near.iter().zip(weights).map(|(one, by)| by * of(one)).sum();
        Some(Trim {
            speed,
            forward_speed: mean(|one| one.forward_speed),
            heave: mean(|one| one.heave),
            incidence: mean(|one| one.incidence),
            pitch: mean(|one| one.pitch),
            ..near[1].clone()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use squid_design::inputs::Inputs;
    use std::path::Path;

    /// Trims that are interpolated while the speed changes are those at each speed.
    #[test]
    fn level_flight_is_held_at_any_speed() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../vehicles/remus100");
        let inputs = Inputs::read_axis(&folder, "design", Some("heading")).unwrap();
        let (plane, (depth, rule)) = (inputs.vehicle.in_plane(), inputs.design.level());
        let trim = trim_with(&plane, Speed::Path(1.5), depth, rule).unwrap();
        let mut held = HeldLevel::new(plane, rule.clone(), trim);
        for speed in [1.5, 1.5001, 1.7777, 1.78, 2.0949, inputs.design.speed_min, inputs.design.speed_max] {
            let exact = held.solved(speed).unwrap();
            let found = held.at(speed).unwrap();
            for of in [|one: &Trim| one.forward_speed, |one: &Trim| one.heave, |one: &Trim| one.pitch] {
                assert!((of(found) - of(&exact)).abs() < 1e-9, "{speed}: {found:?} {exact:?}");
            }
        }
    }
}
