//! A gain over speed: its units, and its polynomial in the scheduling parameter.

use crate::refusal::refused;
use squid_auv::toml_file::{FileError, FileProblem};
use squid_lpv::matrix::{Mat, pseudo_inverse};

/// The highest power of rho.
pub(crate) const HIGHEST: usize = 2;

/// How a gain depends on speed.
#[derive(Debug, Clone, PartialEq)]
pub enum Law {
    /// Coefficients of 1, rho, rho^2.
    Polynomial(Vec<f64>),
    /// Speeds \[m/s\] with gains, for a polynomial of this degree.
    Table {
        /// Increasing speeds, each with its gain.
        points: Vec<[f64; 2]>,
        /// The degree of the polynomial.
        degree: usize,
    },
}

/// A gain as a file gives it.
#[derive(Debug, Clone, PartialEq)]
pub struct Given {
    /// Its key.
    pub key: String,
    /// Its line.
    pub line: usize,
    /// Its unit.
    pub unit: String,
    /// Its dependence on speed.
    pub law: Law,
}

/// What a polynomial leaves of a table.
#[derive(Debug, Clone, PartialEq)]
pub struct Misfit {
    /// The key of the gain.
    pub key: String,
    /// The largest distance from the table, linear between its points, relative to its largest gain.
    pub relative: f64,
    /// Where it is, m/s.
    pub speed: f64,
}

/// A unit with its value in SI.
pub(crate) type Unit = (&'static str, f64);

const PER_DEGREE: f64 = 180.0 / std::f64::consts::PI;

/// What a gain multiplies: its units follow.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Role {
    /// On the error.
    Proportional,
    /// On its integral.
    Integral,
    /// On the rate.
    Derivative,
    /// On the acceleration of the reference model.
    Feedforward,
}

/// The units of a gain from pitch to a deflection.
pub(crate) fn of_deflection(role: Role) -> Vec<Unit> {
    match role {
        Role::Proportional => vec![("rad/rad", 1.0), ("deg/deg", 1.0)],
        Role::Integral => vec![("rad/(rad.s)", 1.0), ("deg/(deg.s)", 1.0), ("1/s", 1.0)],
        Role::Derivative => vec![("rad.s/rad", 1.0), ("deg.s/deg", 1.0), ("s", 1.0)],
        Role::Feedforward => vec![("rad.s2/rad", 1.0), ("deg.s2/deg", 1.0), ("s2", 1.0)],
    }
}

/// The units of a gain from pitch to a moment.
pub(crate) fn of_moment(role: Role) -> Vec<Unit> {
    match role {
        Role::Proportional => vec![("N.m/rad", 1.0), ("N.m/deg", PER_DEGREE)],
        Role::Integral => vec![("N.m/(rad.s)", 1.0), ("N.m/(deg.s)", PER_DEGREE)],
        Role::Derivative => vec![("N.m.s/rad", 1.0), ("N.m.s/deg", PER_DEGREE)],
        Role::Feedforward => vec![("N.m.s2/rad", 1.0), ("N.m.s2/deg", PER_DEGREE)],
    }
}

/// The units of a gain from speed to a force.
pub(crate) fn of_force(role: Role) -> Vec<Unit> {
    if role == Role::Integral { vec![("N/m", 1.0)] } else { vec![("N.s/m", 1.0)] }
}

/// The units of a gain from depth to pitch.
pub(crate) fn of_pitch(role: Role) -> Vec<Unit> {
    if role == Role::Integral {
        vec![("rad/(m.s)", 1.0), ("deg/(m.s)", 1.0 / PER_DEGREE)]
    } else {
        vec![("rad/m", 1.0), ("deg/m", 1.0 / PER_DEGREE)]
    }
}

impl Given {
    /// The coefficients over rho = (V - centre)/half_range, in SI, and what is left of a table.
    pub(crate) fn coefficients(
        &self,
        file: &str,
        units: &[Unit],
        (centre, half_range): (f64, f64),
    ) -> Result<(Vec<f64>, Option<Misfit>), FileError> {
        let Some((_, factor)) = units.iter().find(|(name, _)| *name == self.unit) else {
            let names: Vec<String> = units.iter().map(|(name, _)| format!("\"{name}\"")).collect();
            let (key, found) = (self.key.clone(), self.unit.clone());
            let problem = FileProblem::WrongUnit { key, found, expected: names.join(" or ") };
            return Err(refused(file, self.line, problem));
        };
        let (mut all, misfit) = match &self.law {
            Law::Polynomial(all) => (all.clone(), None),
            Law::Table { points, degree } => {
                let rho = |speed: f64| (speed - centre) / half_range;
                let powers = Mat::from_fn(points.len(), degree + 1, |i, j| rho(points[i][0]).powi(j as i32));
                let gains = Mat::from_fn(points.len(), 1, |i, _| points[i][1]);
                let all: Vec<f64> = (pseudo_inverse(&powers, 1e-12) * gains).iter().copied().collect();
                let ends = (centre - half_range, centre + half_range);
                (all.clone(), Some(self.misfit(points, ends, |speed| value(&all, rho(speed)))))
            }
        };
        while all.len() > 1 && all.last() == Some(&0.0) {
            all.pop();
        }
        Ok((all.into_iter().map(|one| one * factor).collect(), misfit))
    }

    /// The largest distance between a table and its polynomial over a range of speeds.
    fn misfit(&self, points: &[[f64; 2]], (low, high): (f64, f64), at: impl Fn(f64) -> f64) -> Misfit {
        let largest = points.iter().map(|point| point[1].abs()).fold(f64::MIN_POSITIVE, f64::max);
        let spread = |i: usize| low + (high - low) * i as f64 / (TRIED - 1) as f64;
        let off = |speed: f64| (speed, (at(speed) - interpolated(points, speed)).abs() / largest);
        let (speed, relative) = (0..TRIED)
            .map(spread)
            .map(off)
            .fold((low, 0.0), |most, one| if one.1 > most.1 { one } else { most });
        Misfit { key: self.key.clone(), relative, speed }
    }
}

/// The number of speeds at which a polynomial is compared with its table.
const TRIED: usize = 101;

/// A table at a speed, linear between its points and constant beyond them.
fn interpolated(points: &[[f64; 2]], speed: f64) -> f64 {
    let after = points.iter().position(|[at, _]| *at >= speed);
    match after {
        Some(0) => points[0][1],
        None => points.last().map_or(0.0, |[_, gain]| *gain),
        Some(i) => {
            let ([from, one], [to, other]) = (points[i - 1], points[i]);
            one + (other - one) * (speed - from) / (to - from)
        }
    }
}

/// A polynomial at rho.
pub(crate) fn value(coefficients: &[f64], rho: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, one| sum * rho + one)
}
