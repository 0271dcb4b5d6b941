//! Thrust of a thruster over its command, and the inverse.

use serde::{Deserialize, Serialize};

/// Command units that a table of points may have.
pub const COMMAND_UNITS: [&str; 5] = ["1", "%", "us", "rpm", "rad/s"];

/// Condition on the points of a curve, for messages.
pub const POINTS: &str = "at least two pairs [command, thrust]: commands increase, thrusts do not decrease, and one \
                          thrust is zero or the first is negative and the last positive";

/// Thrust T \[N\] over command c: a table of points or a square law, each with zero thrust within its range.
///
/// `T(c)` is `k c|c|`, or linear between the points and constant beyond them. It is continuous: every thrust between
/// its ends has a command, `T(command(T)) = T`. In the dead band, the interval of commands without thrust, the inverse
/// jumps where the thrust changes its sign.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Stored", into = "Stored")]
pub struct Curve {
    unit: String,
    law: Law,
}

/// Law from command to thrust.
#[derive(Debug, Clone, PartialEq)]
pub enum Law {
    /// Linear between points \[command, thrust\].
    Points(Vec<[f64; 2]>),
    /// Factor k of `k c|c|`.
    Square(f64),
}

/// Error in the definition of a curve.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CurveError {
    /// Points that do not meet [`POINTS`].
    #[error("the points of a curve must be {POINTS}")]
    Points,
    /// Factor of a square law that is not above zero.
    #[error("the factor of the square law of a curve is {0}; it must be above zero")]
    Square(f64),
    /// Unknown unit of the command.
    #[error("the unit of the commands of a curve is '{found}'; it must be one of: {}", COMMAND_UNITS.join(", "))]
    #[allow(missing_docs, reason = "the message says what the field is")]
    Unit { found: String },
    /// Both `points` and `square`, or neither.
    #[error("a curve must have either `points` or `square`")]
    Law,
}

impl Curve {
    /// Returns the curve through points \[command, thrust\].
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

    /// Returns the square law `T = k c|c|`.
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

    /// Returns the points, or the factor of the square law.
    pub fn law(&self) -> &Law {
        &self.law
    }

    /// Returns the unit of the command.
    pub fn unit(&self) -> &str {
        &self.unit
    }

    /// Least and greatest thrust \[N\]; infinite for a square law.
    pub fn ends(&self) -> [f64; 2] {
        match &self.law {
            Law::Points(points) => [points[0][1], points[points.len() - 1][1]],
            Law::Square(_) => [f64::NEG_INFINITY, f64::INFINITY],
        }
    }

    /// Returns the thrust \[N\] at a command and its slope, the right-hand one at a corner; a non-finite command is
    /// returned unchanged.
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

    /// Returns the command for a thrust \[N\] and its slope, the right-hand one at a corner.
    ///
    /// Among several commands with this thrust, the one nearest to the dead band is chosen; for zero thrust, the middle
    /// of the dead band; beyond the ends, the command at the end. The slope is zero where it is undefined: in a dead
    /// band, beyond the ends, and at zero thrust of a square law.
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
                let has_no_thrust = |point: &&[f64; 2]| point[1] == 0.0;
                let band = points.iter().find(has_no_thrust).zip(points.iter().rfind(has_no_thrust));
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

/// Returns the command for a thrust on the segment from the last point whose thrust is `below` to the next, and the
/// slope; at the very last point the slope is zero.
fn inverse(points: &[[f64; 2]], below: impl Fn(f64) -> bool, thrust: f64) -> (f64, f64) {
    let above = points.partition_point(|point| below(point[1]));
    if above == 0 || above == points.len() {
        return (points[above.saturating_sub(1)][0], 0.0);
    }
    let swapped = [points[above - 1], points[above]].map(|[command, thrust]| [thrust, command]);
    line(swapped, thrust)
}

/// Returns the ordinate at x and the slope of the line through two points; exact at both points.
fn line([[x0, y0], [x1, y1]]: [[f64; 2]; 2], x: f64) -> (f64, f64) {
    let height = if x == x1 { y1 } else { y0 + (y1 - y0) * ((x - x0) / (x1 - x0)) };
    (height, (y1 - y0) / (x1 - x0))
}

/// Serialised form of a curve.
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

    /// Returns a curve with a dead band from -0.1 to 0.3, flat from 2 to 3, steeper astern than ahead near zero thrust.
    fn dead_band_curve() -> Curve {
        let points =
            vec![[-1.0, -20.0], [-0.1, 0.0], [0.1, 0.0], [0.3, 0.0], [1.0, 7.0], [2.0, 30.0], [3.0, 30.0]];
        Curve::through(points, "1").unwrap()
    }

    #[test]
    fn table_is_linear_between_points() {
        let curve = dead_band_curve();
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
            let (value, found_slope) = curve.thrust(command);
            assert!(
                (value - thrust).abs() < 1e-12 && (found_slope - slope).abs() < 1e-12,
                "{command}: {value}"
            );
        }
    }

    #[test]
    fn command_is_nearest_to_the_dead_band() {
        let curve = dead_band_curve();
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
            let (value, found_slope) = curve.command(thrust);
            assert!(
                (value - command).abs() < 1e-12 && (found_slope - slope).abs() < 1e-12,
                "{thrust}: {value}"
            );
        }
        let (ahead, astern) = (curve.command(1e-12).0, curve.command(-1e-12).0);
        assert!((ahead - 0.3).abs() < 1e-9 && (astern + 0.1).abs() < 1e-9, "the jump is across the band");

        let plain = Curve::through(vec![[-2.0, -10.0], [2.0, 10.0]], "rpm").unwrap();
        assert_eq!((plain.command(0.0), plain.unit()), ((0.0, 0.2), "rpm"));
        let forward_only = Curve::through(vec![[0.0, 0.0], [0.2, 0.0], [1.0, 8.0]], "%").unwrap();
        assert_eq!((forward_only.command(0.0), forward_only.command(-1.0)), ((0.1, 0.0), (0.1, 0.0)));
    }

    #[test]
    fn square_law_is_odd_and_invertible() {
        let curve = Curve::square(2.0, "rad/s").unwrap();
        assert_eq!((curve.thrust(3.0), curve.thrust(-3.0)), ((18.0, 12.0), (-18.0, 12.0)));
        assert_eq!((curve.command(18.0), curve.command(-18.0)), ((3.0, 1.0 / 12.0), (-3.0, 1.0 / 12.0)));
        assert_eq!((curve.command(0.0), curve.thrust(0.0)), ((0.0, 0.0), (0.0, 0.0)));
    }

    #[test]
    fn rejects_invalid_curves() {
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
        assert!(
            dead_band_curve().thrust(f64::NAN).0.is_nan()
                && dead_band_curve().thrust(f64::INFINITY).0.is_infinite()
        );
    }

    proptest! {
        /// The thrust at the command for a thrust is that thrust to rounding, for any table and any square law.
        #[test]
        fn command_inverts_thrust(
            steps in proptest::collection::vec((1e-3..10.0f64, prop_oneof![Just(0.0), 1e-3..50.0f64]), 1..20),
            start in -1000.0..1000.0f64,
            part in 0.0..=1.0f64,
            k in 1e-7..1e3f64,
        ) {
            let height: f64 = steps.iter().map(|step| step.1).sum();
            let mut points = vec![[start, -part * height]];
            for (width, height_step) in steps {
                let [command, thrust] = points[points.len() - 1];
                points.push([command + width, thrust + height_step]);
            }
            let end = points[points.len() - 1][1];
            prop_assume!(height > 0.0 && end >= 0.0);
            let curves = [Curve::through(points, "us").unwrap(), Curve::square(k, "rpm").unwrap()];
            for thrust in (0..=40).map(|n| -part * height + f64::from(n) / 40.0 * (end + part * height)) {
                for curve in &curves {
                    let (value, _) = curve.thrust(curve.command(thrust).0);
                    // The narrowest segment is 1e-3 wide at commands up to 1200: rounding is some 1e-10 of its height.
                    prop_assert!((value - thrust).abs() <= 1e-8, "{thrust} became {value}");
                }
            }
        }
    }
}
