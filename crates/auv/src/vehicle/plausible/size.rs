//! Inconsistent thrust, drag and lengths.

use crate::motion::dynamics::actuator_force;
use crate::text::rounded;
use crate::vehicle::Vehicle;
use squid_finding::Finding;

/// Speed above which it is unusual \[m/s\].
const FAST: f64 = 15.0;
/// Usual lengths of a hull, in edges of a cube of its displaced volume: 1.24 for a ball, 5 for a slenderness of 8.
const SLENDER: std::ops::RangeInclusive<f64> = 1.0..=20.0;
/// Standard gravity, as in the check of vehicle files \[m/s2\].
const GRAVITY: f64 = 9.81;

impl Vehicle {
    /// Returns findings on a hull without drag, on thrust that exceeds the drag at a high speed, and on lengths in
    /// another unit.
    pub(super) fn size(&self) -> Vec<Finding> {
        let drag = if self.coefficients.surge.is_given() { None } else { self.thrust_and_drag() };
        drag.into_iter().chain(self.lengths()).collect()
    }

    fn thrust_and_drag(&self) -> Option<Finding> {
        let c = &self.coefficients;
        let drag = -(c.axial_drag(FAST) + c.X_u * FAST);
        if drag <= 0.0 {
            let why = "the hull has no drag along its axis, so any thrust would accelerate the vehicle without end: \
                       give 'X_uu', or 'wetted_area' and 'length', or 'drag_area' in [drag], or 'X_u' in [damping]";
            return Some(Finding::new("no_drag", "drag", why).value(drag, "N").limit(0.0).speed(FAST));
        }
        let thrusters = self.actuators.iter().chain(&self.others).filter(|one| one.unit() == "N");
        let most_ahead = |one| {
            let ahead = |output| actuator_force(std::slice::from_ref(one), 0.0, [output])[0];
            f64::max(ahead(one.min), ahead(one.max)).max(0.0)
        };
        let thrust: f64 = thrusters.map(most_ahead).sum();
        (thrust > drag).then(|| {
            let why = format!(
                "the thrusters push ahead with up to {} N ('max'), more than the drag of {} N at {FAST} m/s; a higher \
                 speed than that is unusual: check the units of the thrusts and of [drag]",
                rounded(thrust),
                rounded(drag)
            );
            Finding::new("thrust_above_drag", "max", why).value(thrust, "N").limit(drag).speed(FAST)
        })
    }

    fn lengths(&self) -> Vec<Finding> {
        let c = &self.coefficients;
        let side = (c.buoyancy / (c.density * GRAVITY)).cbrt();
        let stations = c.hull.stations();
        let span = stations.first().zip(stations.last()).map(|([aft, _], [fore, _])| fore - aft);
        let all = [
            ("geometry.length", self.geometry.map(|hull| hull.length)),
            ("drag.length", (c.wetted_area > 0.0).then_some(c.length)),
            ("hull.stations", span),
        ];
        let unusual = |(key, length): (&str, Option<f64>)| {
            let length = length.filter(|length| !SLENDER.contains(&(length / side)))?;
            let why = format!(
                "'{key}' is {} m long, {} times the side of the cube of water that the vehicle displaces, {} m; {} to \
                 {} times is usual: check its unit",
                rounded(length),
                rounded(length / side),
                rounded(side),
                SLENDER.start(),
                SLENDER.end()
            );
            let limit = side * if length < side { SLENDER.start() } else { SLENDER.end() };
            Some(Finding::new("unusual_length", key, why).value(length, "m").limit(limit))
        };
        all.into_iter().filter_map(unusual).collect()
    }
}
