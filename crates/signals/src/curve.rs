//! The curve of a thruster: from the command that it takes to the thrust that it gives, and back.

use serde::{Deserialize, Serialize};

/// The units of a command that a table of points may have.
pub const COMMAND_UNITS: [&str; 5] = ["1", "%", "us", "rpm", "rad/s"];

/// What the points of a curve must be.
pub const POINTS: &str = "two pairs [command, thrust] or more: commands rise, thrusts never fall, and one is zero or \
                          the first is below zero and the last above";

/// Thrust T \[N\] over command c, a table of points or a square law; both pass through zero thrust.
///
/// `T(c)` is linear between the points and constant beyond them, or `k c|c|`. It is continuous, so that every thrust
/// between its ends is given by some command: `T(command(T)) = T`. Where commands of a whole interval give no thrust,
/// the dead band, the command jumps as the thrust changes its sign.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Stored", into = "Stored")]
pub struct Curve {
    unit: String,
    law: Law,
}

/// How the thrust of a curve depends on the command.
#[derive(Debug, Clone, PartialEq)]
pub enum Law {
    /// Linear between points \[command, thrust\].
    Points(Vec<[f64; 2]>),
    /// This factor times c|c|.
    Square(f64),
}

/// Why a curve is none.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CurveError {
    /// The points are not [`POINTS`].
    #[error("the points of a curve must be {POINTS}")]
    Points,
    /// The factor of a square law is not above zero.
    #[error("the square law of a curve has the factor {0}, and it must be above zero")]
    Square(f64),
    /// A unit that is not known.
    #[error("the commands of a curve are in '{found}', and must be in one of: {}", COMMAND_UNITS.join(", "))]
    #[allow(missing_docs, reason = "the message says what the field is")]
    Unit { found: String },
    /// Neither points nor a factor, or both.
    #[error("a curve must have either `points` or `square`")]
    Law,
}

impl Curve {
    /// A curve through points \[command, thrust\].
    ///
    /// # Errors
    /// [`CurveError::Points`], [`CurveError::Unit`].
    pub fn through(points: Vec<[f64; 2]>, unit: &str) -> Result<Self, CurveError> {
        let finite = points.iter().flatten().all(|number| number.is_finite());
        let rise = points.windows(2).all(|pair| pair[0][0] < pair[1][0] && pair[0][1] <= pair[1][1]);
        let ends = points.first().zip(points.last());
        let thrusts =
            ends.is_some_and(|(first, last)| first[1] <= 0.0 && last[1] >= 0.0 && first[1] < last[1]);
        if finite && rise && thrusts { Self::of(Law::Points(points), unit) } else { Err(CurveError::Points) }
    }

    /// The square law `T = k c|c|`.
    ///
    /// # Errors
    /// [`CurveError::Square`], [`CurveError::Unit`].
    pub fn square(k: f64, unit: &str) -> Result<Self, CurveError> {
        if k.is_finite() && k > 0.0 { Self::of(Law::Square(k), unit) } else { Err(CurveError::Square(k)) }
    }

    fn of(law: Law, unit: &str) -> Result<Self, CurveError> {
        if COMMAND_UNITS.contains(&unit) {
            Ok(Self { unit: unit.to_owned(), law })
        } else {
            Err(CurveError::Unit { found: unit.to_owned() })
        }
    }

    /// The points, or the factor of the square law.
    pub fn law(&self) -> &Law {
        &self.law
    }

    /// The unit of the command.
    pub fn unit(&self) -> &str {
        &self.unit
    }

    /// The least and the greatest thrust \[N\]; those of a square law have no end.
    pub fn ends(&self) -> [f64; 2] {
        match &self.law {
            Law::Points(points) => [points[0][1], points[points.len() - 1][1]],
            Law::Square(_) => [f64::NEG_INFINITY, f64::INFINITY],
        }
    }

    /// Returns the thrust of a command \[N\] and its slope, at a corner the right-hand one; a command that is not
    /// finite comes back as it is.
    pub fn thrust(&self, command: f64) -> (f64, f64) {
        match &self.law {
            _ if !command.is_finite() => (command, 0.0),
            Law::Square(k) => (k * command * command.abs(), 2.0 * k * command.abs()),
            Law::Points(points) => {
                let above = points.partition_point(|point| point[0] <= command);
                if above == 0 || above == points.len() {
                    return (points[above.saturating_sub(1)][1], 0.0);
                }
                line([points[above - 1], points[above]], command)
            }
        }
    }

    /// Returns the command for a thrust \[N\] and its slope, at a corner the right-hand one.
    ///
    /// Of several commands with this thrust it is the one nearest to those without thrust, for no thrust the middle of
    /// the dead band; beyond the ends, the command of the end. The slope is zero where there is none: in a dead band,
    /// beyond the ends, and of a square law at rest.
    pub fn command(&self, thrust: f64) -> (f64, f64) {
        match &self.law {
            Law::Square(k) => {
                let command = (thrust.abs() / k).sqrt().copysign(thrust);
                (command, if command == 0.0 { 0.0 } else { 0.5 / (k * command.abs()) })
            }
            Law::Points(points) => {
                let [least, most] = self.ends();
                if thrust < least || thrust > most {
                    return (self.command(thrust.clamp(least, most)).0, 0.0);
                }
                let without = |point: &&[f64; 2]| point[1] == 0.0;
                let band = points.iter().find(without).zip(points.iter().rfind(without));
                let (greatest, slope) = inverse(points, |at| at <= thrust, thrust);
                match band.filter(|_| thrust == 0.0) {
                    Some((first, last)) if first == last => (first[0], slope),
                    Some((first, last)) => (0.5 * (first[0] + last[0]), 0.0),
                    None if thrust > 0.0 => (inverse(points, |at| at < thrust, thrust).0, slope),
                    None => (greatest, slope),
                }
            }
        }
    }
}

/// The command for a thrust on the line from the last point whose thrust is `below` to the next, and the slope; at the
/// last point of all the slope is zero.
fn inverse(points: &[[f64; 2]], below: impl Fn(f64) -> bool, thrust: f64) -> (f64, f64) {
    let above = points.partition_point(|point| below(point[1]));
    if above == 0 || above == points.len() {
        return (points[above.saturating_sub(1)][0], 0.0);
    }
    let turned = [points[above - 1], points[above]].map(|[command, thrust]| [thrust, command]);
    line(turned, thrust)
}

/// The height at x and the slope of the line through two points, exact at both.
fn line([[x0, y0], [x1, y1]]: [[f64; 2]; 2], x: f64) -> (f64, f64) {
    let height = if x == x1 { y1 } else { y0 + (y1 - y0) * ((x - x0) / (x1 - x0)) };
    (height, (y1 - y0) / (x1 - x0))
}

/// A curve as it is stored.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Stored {
    unit: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    points: Option<Vec<[f64; 2]>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    square: Option<f64>,
}

impl TryFrom<Stored> for Curve {
    type Error = CurveError;

    fn try_from(Stored { unit, points, square }: Stored) -> Result<Self, CurveError> {
        match (points, square) {
            (Some(points), None) => Self::through(points, &unit),
            (None, Some(k)) => Self::square(k, &unit),
            _ => Err(CurveError::Law),
        }
    }
}

impl From<Curve> for Stored {
    fn from(Curve { unit, law }: Curve) -> Self {
        match law {
            Law::Points(points) => Self { unit, points: Some(points), square: None },
            Law::Square(k) => Self { unit, points: None, square: Some(k) },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A dead band from -0.1 to 0.3, flat from 2 to 3, other slopes ahead than astern.
    fn banded() -> Curve {
        let points =
            vec![[-1.0, -20.0], [-0.1, 0.0], [0.1, 0.0], [0.3, 0.0], [1.0, 7.0], [2.0, 30.0], [3.0, 30.0]];
        Curve::through(points, "1").unwrap()
    }

    #[test]
    fn a_table_is_linear_between_its_points() {
        let curve = banded();
        for (command, thrust, slope) in [
            (-2.0, -20.0, 0.0),
            (-1.0, -20.0, 20.0 / 0.9),
            (-0.55, -10.0, 20.0 / 0.9),
            (-0.1, 0.0, 0.0),
            (0.2, 0.0, 0.0),
            (1.0, 7.0, 23.0),
            (1.5, 18.5, 23.0),
            (2.0, 30.0, 0.0),
            (9.0, 30.0, 0.0),
        ] {
            let (found, sloped) = curve.thrust(command);
            assert!((found - thrust).abs() < 1e-12 && (sloped - slope).abs() < 1e-12, "{command}: {found}");
        }
    }

    #[test]
    fn the_command_is_the_nearest_to_the_dead_band_and_its_middle_for_no_thrust() {
        let curve = banded();
        for (thrust, command, slope) in [
            (-25.0, -1.0, 0.0),
            (-20.0, -1.0, 0.045),
            (-10.0, -0.55, 0.045),
            (0.0, 0.1, 0.0),
            (7.0, 1.0, 1.0 / 23.0),
            (18.5, 1.5, 1.0 / 23.0),
            (30.0, 2.0, 0.0),
            (31.0, 2.0, 0.0),
        ] {
            let (found, sloped) = curve.command(thrust);
            assert!((found - command).abs() < 1e-12 && (sloped - slope).abs() < 1e-12, "{thrust}: {found}");
        }
        let (ahead, astern) = (curve.command(1e-12).0, curve.command(-1e-12).0);
        assert!((ahead - 0.3).abs() < 1e-9 && (astern + 0.1).abs() < 1e-9, "the jump is across the band");

        let plain = Curve::through(vec![[-2.0, -10.0], [2.0, 10.0]], "rpm").unwrap();
        assert_eq!((plain.command(0.0), plain.unit()), ((0.0, 0.2), "rpm"));
        let ahead_alone = Curve::through(vec![[0.0, 0.0], [0.2, 0.0], [1.0, 8.0]], "%").unwrap();
        assert_eq!((ahead_alone.command(0.0), ahead_alone.command(-1.0)), ((0.1, 0.0), (0.1, 0.0)));
    }

    #[test]
    fn a_square_law_goes_both_ways() {
        let curve = Curve::square(2.0, "rad/s").unwrap();
        assert_eq!((curve.thrust(3.0), curve.thrust(-3.0)), ((18.0, 12.0), (-18.0, 12.0)));
        assert_eq!((curve.command(18.0), curve.command(-18.0)), ((3.0, 1.0 / 12.0), (-3.0, 1.0 / 12.0)));
        assert_eq!((curve.command(0.0), curve.thrust(0.0)), ((0.0, 0.0), (0.0, 0.0)));
    }

    #[test]
    fn what_is_no_curve_is_refused() {
        for points in [
            vec![],
            vec![[0.0, 0.0]],
            vec![[0.0, -1.0], [0.0, 1.0]],
            vec![[0.0, -1.0], [1.0, 1.0], [2.0, 0.9]],
            vec![[0.0, 1.0], [1.0, 2.0]],
            vec![[0.0, -2.0], [1.0, -1.0]],
            vec![[0.0, 0.0], [1.0, 0.0]],
            vec![[0.0, -1.0], [1.0, f64::NAN]],
        ] {
            assert_eq!(Curve::through(points.clone(), "1"), Err(CurveError::Points), "{points:?}");
        }
        assert_eq!(Curve::square(0.0, "rpm"), Err(CurveError::Square(0.0)));
        assert_eq!(Curve::square(1.0, "knots"), Err(CurveError::Unit { found: "knots".to_owned() }));
        assert!(banded().thrust(f64::NAN).0.is_nan() && banded().thrust(f64::INFINITY).0.is_infinite());
    }

    proptest! {
        /// Thrust of the command of a thrust: the same thrust, to rounding, of any table and any square law.
        #[test]
        fn every_thrust_within_the_ends_is_given(
            steps in proptest::collection::vec((1e-3..10.0f64, prop_oneof![Just(0.0), 1e-3..50.0f64]), 1..20),
            start in -1000.0..1000.0f64,
            part in 0.0..=1.0f64,
            k in 1e-7..1e3f64,
        ) {
            let height: f64 = steps.iter().map(|step| step.1).sum();
            let mut points = vec![[start, -part * height]];
            for (wide, high) in steps {
                let [command, thrust] = points[points.len() - 1];
                points.push([command + wide, thrust + high]);
            }
            let end = points[points.len() - 1][1];
            prop_assume!(height > 0.0 && end >= 0.0);
            let curves = [Curve::through(points, "us").unwrap(), Curve::square(k, "rpm").unwrap()];
            for thrust in (0..=40).map(|n| -part * height + f64::from(n) / 40.0 * (end + part * height)) {
                for curve in &curves {
                    let (found, _) = curve.thrust(curve.command(thrust).0);
                    // The least step is 1e-3 wide at up to 1200: some 1e-10 of its height.
                    prop_assert!((found - thrust).abs() <= 1e-8, "{thrust} became {found}");
                }
            }
        }
    }
}
