//! Attitudes near the vertical.
//!
//! With the bow straight up or down, roll and heading are undefined and their rates unbounded. The Euler angles of the
//! same attitude about earth axes rotated by 90 deg about east are regular there: two charts cover every attitude.

use std::f64::consts::TAU;

use crate::simulation::water::Pose;

/// Roll, pitch and heading \[rad\].
pub(crate) type Angles = [f64; 3];

/// Least |cos(pitch)| at which the usual angles are integrated: pitch within 78.5 deg.
pub(crate) const LEAST_COSINE: f64 = 0.2;

/// Returns the angles of an attitude about the rotated axes, of which the first points down and the third south.
pub(crate) fn rotated(usual: Angles) -> Angles {
    angles(axes(usual).map(|[north, east, down]| [down, east, -north]))
}

/// Returns the usual angles of an attitude from its angles about the rotated axes: pitch within 90 deg, roll and
/// heading within half a turn of their last values.
pub(crate) fn usual(rotated: Angles, last: Angles) -> Angles {
    let [roll, pitch, heading] = angles(axes(rotated).map(|[down, east, south]| [-south, east, down]));
    let unwrapped = |angle: f64, last: f64| angle + TAU * ((last - angle) / TAU).round();
    [unwrapped(roll, last[0]), pitch, unwrapped(heading, last[2])]
}

fn axes([roll, pitch, heading]: Angles) -> [[f64; 3]; 3] {
    Pose { roll, pitch, heading, ..Pose::default() }.axes()
}

/// Returns the angles of a body from its axes forward, to starboard and down. Roll is computed from the heading, so
/// that both together are exact even where neither is defined.
fn angles([forward, starboard, below]: [[f64; 3]; 3]) -> Angles {
    let heading = forward[1].atan2(forward[0]);
    let (sin, cos) = heading.sin_cos();
    let across = |axis: [f64; 3]| axis[1] * cos - axis[0] * sin;
    let level = forward[0] * cos + forward[1] * sin;
    [(-across(below)).atan2(across(starboard)), (-forward[2]).atan2(level), heading]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    proptest! {
        /// Angles in either chart describe the same attitude, to the last bit also with the bow straight up or down.
        #[test]
        fn both_charts_describe_the_same_attitude(
            roll in -PI..PI, heading in -9.0..9.0f64, pitch in -FRAC_PI_2..FRAC_PI_2, exponent in -17.0..0.0f64,
        ) {
            let near = FRAC_PI_2 - 10f64.powf(exponent);
            for pitch in [pitch, FRAC_PI_2, -FRAC_PI_2, near, -near] {
                let before = axes([roll, pitch, heading]);
                let after = axes(usual(rotated([roll, pitch, heading]), [roll, pitch, heading]));
                for (before, after) in before.iter().flatten().zip(after.iter().flatten()) {
                    prop_assert!((before - after).abs() < 2e-15, "{} and {} at {}", before, after, pitch);
                }
            }
        }
    }
}
