//! LPV model of a vehicle: A and B as polynomials in speed, with the trim table.

use crate::states::longitudinal as states;
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::motion::level::Pitch;
use crate::motion::trim::Trim;

/// Value of `format` in the files that this version reads and writes.
pub const LPV_MODEL_FORMAT: &str = "auv-lpv-model/1";

/// Row of the trim table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrimPoint {
    /// Speed along the path through the water, V \[m/s\].
    pub speed: f64,
    /// Surge velocity \[m/s\].
    pub forward_speed: f64,
    /// Heave velocity \[m/s\].
    pub heave: f64,
    /// Pitch \[rad\].
    pub pitch: f64,
    /// Output of each actuator \[N or rad\].
    pub actuators: Vec<f64>,
}

impl From<&Trim> for TrimPoint {
    fn from(trim: &Trim) -> Self {
        let Trim { speed, forward_speed, heave, pitch, .. } = *trim;
        Self { speed, forward_speed, heave, pitch, actuators: trim.actuators.clone() }
    }
}

/// Linear model that varies with speed: `x' = A(rho) (x - x_trim(V)) + B(rho) (T - T_trim(V))`.
///
/// `A(rho) = sum_k rho^k A_k`, B likewise, with `rho = (V - speed_centre) / speed_half_range` clamped to \[-1, 1\]; the
/// state is x = \[u w q theta\], the inputs T are the outputs of the actuators. Shapes: each A_k 4 x 4, each B_k 4 x m,
/// as lists of rows. The trim table has increasing speeds and is interpolated linearly, constant beyond its ends. A
/// model of \[w q theta\] has zeros in the row and the column of u, which is then the given speed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LpvModel {
    /// File format, [`LPV_MODEL_FORMAT`].
    pub format: String,
    /// Name of the vehicle.
    pub vehicle: String,
    /// Depth at which the vehicle was linearised \[m\].
    pub depth: f64,
    /// Speed at rho = 0 \[m/s\].
    pub speed_centre: f64,
    /// Speed between rho = 0 and rho = 1 \[m/s\].
    pub speed_half_range: f64,
    /// Coefficient matrices A_0, A_1, ...
    pub a: Vec<Vec<Vec<f64>>>,
    /// Coefficient matrices B_0, B_1, ...
    pub b: Vec<Vec<Vec<f64>>>,
    /// Trim over speed.
    pub trim: Vec<TrimPoint>,
    /// Pitch rule of the trims; omitted if the pitch is free.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trim_pitch: Option<TrimPitch>,
}

/// Pitch rule in a file, if the pitch is not free; see [`Pitch`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum TrimPitch {
    /// Held pitch \[rad\]: [`Pitch::Held`].
    Held(f64),
    /// Branch along the trim table: [`Pitch::Followed`].
    Followed,
}

/// Error in an LPV model.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum LpvModelError {
    /// Text that is not the JSON of an LPV model.
    #[error("{file}: not an LPV model: {message}")]
    NotJson { file: String, message: String },
    /// A file of another format or version.
    #[error("`format` is \"{found}\"; it must be \"{LPV_MODEL_FORMAT}\"")]
    Format { found: String },
    /// A matrix of wrong shape.
    #[error("`{matrix}[{order}]` is {found}; it must be {rows} x {columns}")]
    Shape { matrix: &'static str, order: usize, found: String, rows: usize, columns: usize },
    /// A missing coefficient matrix.
    #[error("`{matrix}` is empty; it must contain at least one matrix")]
    Empty { matrix: &'static str },
    /// A number that is not finite.
    #[error("`{key}` contains {found}; all its numbers must be finite")]
    NotFinite { key: &'static str, found: f64 },
    /// A half range of speed that is not positive.
    #[error("`speed_half_range` is {found} m/s; it must be above zero")]
    HalfRange { found: f64 },
    /// A trim table whose speeds do not increase.
    #[error("`trim[{row}].speed` is {found} m/s after {previous} m/s; speeds must increase")]
    SpeedsNotRising { row: usize, found: f64, previous: f64 },
    /// A model for a vehicle with another number of actuators.
    #[error("the number of actuators in `{key}` is {found}; the vehicle has {expected}")]
    Actuators { key: &'static str, found: usize, expected: usize },
}

impl LpvModel {
    /// Builds a model from coefficient matrices of the states of the vehicle, without the depth, and from trims, and
    /// checks it.
    ///
    /// # Errors
    /// [`LpvModelError`] as for [`LpvModel::check`].
    pub fn new(
        vehicle: &str,
        depth: f64,
        (speed_centre, speed_half_range): (f64, f64),
        a: &[DMatrix<f64>],
        b: &[DMatrix<f64>],
        trims: &[Trim],
    ) -> Result<Self, LpvModelError> {
        let whole = states(false, false).len();
        let missing = |m: &DMatrix<f64>| whole - m.nrows().min(whole);
        let rows = |m: &DMatrix<f64>| m.row_iter().map(|row| row.iter().copied().collect()).collect();
        let square = |m: &DMatrix<f64>| {
            let zeros = missing(m);
            rows(&m.clone().insert_rows(0, zeros, 0.0).insert_columns(0, zeros, 0.0))
        };
        let tall = |m: &DMatrix<f64>| rows(&m.clone().insert_rows(0, missing(m), 0.0));
        let model = Self {
            format: LPV_MODEL_FORMAT.to_string(),
            vehicle: vehicle.to_string(),
            depth,
            speed_centre,
            speed_half_range,
            a: a.iter().map(square).collect(),
            b: b.iter().map(tall).collect(),
            trim: trims.iter().map(TrimPoint::from).collect(),
            trim_pitch: trims.first().and_then(|trim| match trim.rule {
                Pitch::Free => None,
                Pitch::Held(pitch) => Some(TrimPitch::Held(pitch)),
                Pitch::Followed(_) => Some(TrimPitch::Followed),
            }),
        };
        model.check()?;
        Ok(model)
    }

    /// Reads a model from JSON and checks it; `file` is its name in messages.
    ///
    /// # Errors
    /// [`LpvModelError`]: not JSON, another format, wrong shapes, numbers that are not finite.
    #[inline]
    pub fn from_json(text: &str, file: &str) -> Result<Self, LpvModelError> {
        let model: Self = serde_json::from_str(text)
            .map_err(|error| LpvModelError::NotJson { file: file.to_string(), message: error.to_string() })?;
        model.check()?;
        Ok(model)
    }

    /// Returns the model as JSON, with numbers that read back to the same `f64`.
    ///
    /// # Errors
    /// [`LpvModelError`] as for [`LpvModel::check`]: JSON cannot represent a number that is not finite.
    pub fn to_json(&self) -> Result<String, LpvModelError> {
        self.check()?;
        serde_json::to_string_pretty(self).map(|text| text + "\n").map_err(|error| LpvModelError::NotJson {
            file: self.vehicle.clone(),
            message: error.to_string(),
        })
    }

    /// Returns the pitch rule of the trim table.
    pub fn pitch(&self) -> Pitch {
        match self.trim_pitch {
            None => Pitch::Free,
            Some(TrimPitch::Held(pitch)) => Pitch::Held(pitch),
            Some(TrimPitch::Followed) => {
                Pitch::Followed(self.trim.iter().map(|point| (point.speed, point.pitch)).collect())
            }
        }
    }

    /// Returns the number of actuators.
    pub fn inputs(&self) -> usize {
        self.trim.first().map_or(0, |point| point.actuators.len())
    }

    /// Returns `true` if theta' depends on q and the operating speed only. In the equations of motion it equals q.
    pub fn turns_with_pitch_rate_alone(&self) -> bool {
        let by_state = self.a.iter().all(|term| [0, 1, 3].iter().all(|&column| term[3][column] == 0.0));
        by_state && self.b.iter().all(|term| term[3].iter().all(|entry| *entry == 0.0))
    }

    /// Returns rho at a speed \[m/s\], clamped to \[-1, 1\].
    pub fn rho(&self, speed: f64) -> f64 {
        ((speed - self.speed_centre) / self.speed_half_range).clamp(-1.0, 1.0)
    }

    /// Checks format, shapes, finiteness and the order of the trim table.
    ///
    /// # Errors
    /// The first [`LpvModelError`].
    pub fn check(&self) -> Result<(), LpvModelError> {
        if self.format != LPV_MODEL_FORMAT {
            return Err(LpvModelError::Format { found: self.format.clone() });
        }
        for (key, found) in [
            ("depth", self.depth),
            ("speed_centre", self.speed_centre),
            ("speed_half_range", self.speed_half_range),
        ] {
            finite(key, [found])?;
        }
        if self.speed_half_range <= 0.0 {
            return Err(LpvModelError::HalfRange { found: self.speed_half_range });
        }
        if self.trim.is_empty() {
            return Err(LpvModelError::Empty { matrix: "trim" });
        }
        if let Some(TrimPitch::Held(pitch)) = self.trim_pitch {
            finite("trim_pitch", [pitch])?;
        }
        shape("a", &self.a, 4)?;
        shape("b", &self.b, self.inputs())?;
        self.check_trim()
    }

    fn check_trim(&self) -> Result<(), LpvModelError> {
        for (row, point) in self.trim.iter().enumerate() {
            finite("trim", [point.speed, point.forward_speed, point.heave, point.pitch])?;
            finite("trim", point.actuators.iter().copied())?;
            let (found, expected) = (point.actuators.len(), self.inputs());
            if found != expected {
                return Err(LpvModelError::Actuators { key: "trim", found, expected });
            }
            let previous = if row > 0 { self.trim[row - 1].speed } else { f64::NEG_INFINITY };
            if point.speed <= previous {
                return Err(LpvModelError::SpeedsNotRising { row, found: point.speed, previous });
            }
        }
        Ok(())
    }

    /// Returns the rows of the trim table on either side of a speed, and the weight of the second.
    pub(crate) fn bracket(&self, speed: f64) -> (&TrimPoint, &TrimPoint, f64) {
        let last = self.trim.len() - 1;
        let upper = self.trim.partition_point(|point| point.speed <= speed).min(last);
        let (below, above) = (&self.trim[upper.saturating_sub(1)], &self.trim[upper]);
        let span = above.speed - below.speed;
        let weight = if span > 0.0 { ((speed - below.speed) / span).clamp(0.0, 1.0) } else { 0.0 };
        (below, above, weight)
    }
}

fn finite(key: &'static str, numbers: impl IntoIterator<Item = f64>) -> Result<(), LpvModelError> {
    match numbers.into_iter().find(|number| !number.is_finite()) {
        Some(found) => Err(LpvModelError::NotFinite { key, found }),
        None => Ok(()),
    }
}

fn shape(matrix: &'static str, terms: &[Vec<Vec<f64>>], columns: usize) -> Result<(), LpvModelError> {
    if terms.is_empty() {
        return Err(LpvModelError::Empty { matrix });
    }
    for (order, term) in terms.iter().enumerate() {
        if term.len() != 4 || term.iter().any(|row| row.len() != columns) {
            let lengths: Vec<usize> = term.iter().map(Vec::len).collect();
            let found = format!("{} rows of lengths {lengths:?}", term.len());
            return Err(LpvModelError::Shape { matrix, order, found, rows: 4, columns });
        }
        finite(matrix, term.iter().flatten().copied())?;
    }
    Ok(())
}
