//! Longitudinal motion held at trim, for an axis of heading.

use crate::error::Error;
use squid_auv::{Pitch, Speed, Trim, TrimError, Vehicle, trim_with};
use std::collections::BTreeMap;

/// Level flight held at the reference speed.
pub(crate) struct HeldTrim {
    plane: Vehicle,
    rule: Pitch,
    trim: Trim,
    /// Cached trims at multiples of [`GRID`]; `None` where no trim exists.
    cache: BTreeMap<i64, Option<Trim>>,
}

/// Spacing of the speeds along the path between which trims are interpolated, m/s; the error is of fourth order in it.
const GRID: f64 = 0.01;

impl HeldTrim {
    /// Starts with a trim of a vehicle in the vertical plane with a pitch rule.
    pub(crate) fn new(plane: Vehicle, rule: Pitch, trim: Trim) -> Self {
        Self { plane, rule, trim, cache: BTreeMap::new() }
    }

    /// Returns the current trim.
    pub(crate) fn trim(&self) -> &Trim {
        &self.trim
    }

    /// Returns the trim at a speed along the path; while the speed changes, by cubic interpolation of four trims
    /// nearby.
    pub(crate) fn at(&mut self, speed: f64) -> Result<&Trim, Error> {
        if speed != self.trim.speed {
            let trim = match self.interpolate(speed) {
                Some(trim) => trim,
                None => self.solve(speed).map_err(|reason| Error::Trim { speed, reason })?,
            };
            self.trim = trim;
        }
        Ok(&self.trim)
    }

    fn solve(&self, speed: f64) -> Result<Trim, TrimError> {
        let (depth, actuators) = (self.trim.depth, self.trim.actuators.len());
        let trim = trim_with(&self.plane, Speed::Path(speed), depth, &self.rule)?;
        Ok(Trim { actuators: vec![0.0; actuators], ..trim })
    }

    /// Returns the interpolated trim; `None` near the limits of the speeds with a trim.
    fn interpolate(&mut self, speed: f64) -> Option<Trim> {
        if !speed.is_finite() {
            return None;
        }
        let below = (speed / GRID).floor();
        let fraction = speed / GRID - below;
        for index in below as i64 - 1..=below as i64 + 2 {
            if !self.cache.contains_key(&index) {
                let trim = self.solve(index as f64 * GRID).ok();
                self.cache.insert(index, trim);
            }
        }
        let near: Vec<&Trim> =
            (-1..=2).map(|step| self.cache[&(below as i64 + step)].as_ref()).collect::<Option<_>>()?;
        let weights = [
            -fraction * (fraction - 1.0) * (fraction - 2.0) / 6.0,
            (fraction + 1.0) * (fraction - 1.0) * (fraction - 2.0) / 2.0,
            -(fraction + 1.0) * fraction * (fraction - 2.0) / 2.0,
            (fraction + 1.0) * fraction * (fraction - 1.0) / 6.0,
        ];
        let mean =
            |value: fn(&Trim) -> f64| near.iter().zip(weights).map(|(one, weight)| weight * value(one)).sum();
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

    /// Interpolated trims agree with the exact ones.
    #[test]
    fn interpolated_trims_match_exact_ones() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../vehicles/remus100");
        let inputs = Inputs::read_axis(&folder, "design", Some("heading")).unwrap();
        let (plane, (depth, rule)) = (inputs.vehicle.in_plane(), inputs.design.level());
        let trim = trim_with(&plane, Speed::Path(1.5), depth, rule).unwrap();
        let mut held = HeldTrim::new(plane, rule.clone(), trim);
        for speed in [1.5, 1.5001, 1.7777, 1.78, 2.0949, inputs.design.speed_min, inputs.design.speed_max] {
            let exact = held.solve(speed).unwrap();
            let found = held.at(speed).unwrap();
            for value in [|one: &Trim| one.forward_speed, |one: &Trim| one.heave, |one: &Trim| one.pitch] {
                assert!((value(found) - value(&exact)).abs() < 1e-9, "{speed}: {found:?} {exact:?}");
            }
        }
    }
}
