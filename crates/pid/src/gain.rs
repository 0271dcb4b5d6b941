//! A gain over speed: its units, and its polynomial in the scheduling parameter rho.

use crate::refusal::refused;
use squid_auv::toml_file::{FileError, FileProblem};
use squid_lpv::matrix::{Mat, pseudo_inverse};

/// The highest power of rho.
pub(crate) const HIGHEST: usize = 2;

/// Dependence of a gain on speed.
#[derive(Debug, Clone, PartialEq)]
pub enum Law {
    /// Coefficients of 1, rho, rho^2.
    Polynomial(Vec<f64>),
    /// Gains at speeds \[m/s\], to be fitted by a polynomial.
    Table {
        /// Pairs of speed and gain, in increasing order of speed.
        points: Vec<[f64; 2]>,
        /// Degree of the fitted polynomial.
        degree: usize,
    },
}

/// A gain as given in a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Given {
    /// Full key in the file.
    pub key: String,
    /// Line in the file.
    pub line: usize,
    /// Unit as written.
    pub unit: String,
    /// Dependence on speed.
    pub law: Law,
}

/// Largest misfit of a polynomial against its table.
#[derive(Debug, Clone, PartialEq)]
pub struct Misfit {
    /// Key of the gain.
    pub key: String,
    /// Largest distance from the table, linearly interpolated, relative to the table's largest gain.
    pub relative: f64,
    /// Speed of the largest misfit, m/s.
    pub speed: f64,
}

/// A unit and its value in SI.
pub(crate) type Unit = (&'static str, f64);

const PER_DEGREE: f64 = 180.0 / std::f64::consts::PI;

/// Signal that a gain multiplies, which determines the gain's units.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Role {
    /// The error.
    Proportional,
    /// The integral of the error.
    Integral,
    /// The rate.
    Derivative,
    /// The acceleration of the reference model.
    Feedforward,
}

/// Returns the units of a gain from an angle to a deflection.
pub(crate) fn deflection_units(role: Role) -> Vec<Unit> {
    match role {
        Role::Proportional => vec![("rad/rad", 1.0), ("deg/deg", 1.0)],
        Role::Integral => vec![("rad/(rad.s)", 1.0), ("deg/(deg.s)", 1.0), ("1/s", 1.0)],
        Role::Derivative => vec![("rad.s/rad", 1.0), ("deg.s/deg", 1.0), ("s", 1.0)],
        Role::Feedforward => vec![("rad.s2/rad", 1.0), ("deg.s2/deg", 1.0), ("s2", 1.0)],
    }
}

/// Returns the units of a gain from an angle to a moment.
pub(crate) fn moment_units(role: Role) -> Vec<Unit> {
    match role {
        Role::Proportional => vec![("N.m/rad", 1.0), ("N.m/deg", PER_DEGREE)],
        Role::Integral => vec![("N.m/(rad.s)", 1.0), ("N.m/(deg.s)", PER_DEGREE)],
        Role::Derivative => vec![("N.m.s/rad", 1.0), ("N.m.s/deg", PER_DEGREE)],
        Role::Feedforward => vec![("N.m.s2/rad", 1.0), ("N.m.s2/deg", PER_DEGREE)],
    }
}

/// Returns the units of a gain from speed to a force.
pub(crate) fn force_units(role: Role) -> Vec<Unit> {
    if role == Role::Integral { vec![("N/m", 1.0)] } else { vec![("N.s/m", 1.0)] }
}

/// Returns the units of a gain from depth to pitch.
pub(crate) fn pitch_units(role: Role) -> Vec<Unit> {
    if role == Role::Integral {
        vec![("rad/(m.s)", 1.0), ("deg/(m.s)", 1.0 / PER_DEGREE)]
    } else {
        vec![("rad/m", 1.0), ("deg/m", 1.0 / PER_DEGREE)]
    }
}

impl Given {
    /// Returns the coefficients in rho = (V - centre)/half_range, in SI, and the misfit of a table.
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

    /// Returns the largest misfit between a table and its polynomial over a range of speeds.
    fn misfit(&self, points: &[[f64; 2]], (low, high): (f64, f64), at: impl Fn(f64) -> f64) -> Misfit {
        let largest = points.iter().map(|point| point[1].abs()).fold(f64::MIN_POSITIVE, f64::max);
        let sample_speed = |i: usize| low + (high - low) * i as f64 / (MISFIT_SAMPLES - 1) as f64;
        let misfit_at = |speed: f64| (speed, (at(speed) - interpolated(points, speed)).abs() / largest);
        let (speed, relative) = (0..MISFIT_SAMPLES)
            .map(sample_speed)
            .map(misfit_at)
            .fold((low, 0.0), |most, one| if one.1 > most.1 { one } else { most });
        Misfit { key: self.key.clone(), relative, speed }
    }
}

/// Number of speeds at which a polynomial is compared with its table.
const MISFIT_SAMPLES: usize = 101;

/// Interpolates a table linearly at a speed; constant outside its range.
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

/// Evaluates a polynomial at rho.
pub(crate) fn value(coefficients: &[f64], rho: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, one| sum * rho + one)
}
