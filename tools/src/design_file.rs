//! The design file: what is asked of the controller.
//!
//! Every key is explained in the design files that come with the vehicles.
//!
//! Weights are given by numbers that mean something, not by polynomials: `W_e = (s/peak + bandwidth)/(s + bandwidth steady_error)` and a
//! constant W_u. Both are proper for every value in the ranges below; a value that would make them improper or infinite (peak = 0,
//! bandwidth = inf) is refused with file, line and key.

mod checker;
mod uncertainty;

use checker::Checker;
use fmu_squid::Manoeuvre;
use serde::Deserialize;
use std::path::Path;
use thiserror::Error;
use toml::Spanned;
pub use uncertainty::{HalfRange, UncertainCoefficient, UncertainParameter, Uncertainty};

/// A quantity that the controller can track.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Output {
    /// Pitch angle.
    Pitch,
    /// Forward speed through the water.
    Speed,
}

impl Output {
    /// Its name in files and on screen.
    pub fn name(self) -> &'static str {
        match self {
            Output::Pitch => "pitch",
            Output::Speed => "speed",
        }
    }

    /// Its SI unit.
    pub fn unit(self) -> &'static str {
        match self {
            Output::Pitch => "rad",
            Output::Speed => "m/s",
        }
    }

    /// Its place in the state x = [u w q theta].
    pub fn state(self) -> usize {
        match self {
            Output::Pitch => 3,
            Output::Speed => 0,
        }
    }
}

/// A range of numbers, in words that a message can hold.
#[derive(Debug, Clone, Copy)]
pub struct Range {
    least: f64,
    most: f64,
    /// What is allowed.
    pub words: &'static str,
}

impl Range {
    /// Whether a number lies in it; not-a-number does not.
    pub fn allows(&self, v: f64) -> bool {
        (self.least..=self.most).contains(&v)
    }
}

/// w_b of W_e.
pub const BANDWIDTH: Range = Range { least: 1e-6, most: 1e6, words: "from 1e-6 to 1e6 (rad/s)" };

/// M_s of W_e. Towards 0 the gain 1/M_s at high frequency grows; at 0 the weight is not proper.
const PEAK: Range = Range {
    least: 1.0 + f64::EPSILON,
    most: 100.0,
    words: "above 1, at most 100; 1/peak is the gain of W_e at high frequency, and with 0 W_e would not be proper",
};

/// Scales of references, by which is divided.
const SCALE: Range = Range { least: 1e-6, most: 1e6, words: "from 1e-6 to 1e6" };

/// W_u.
const CONTROL_WEIGHT: Range = Range {
    least: 1e-6,
    most: 1e6,
    words: "from 1e-6 to 1e6; without a weight on the actuators their gains grow without limit",
};

/// A tracked output with its weight.
#[derive(Debug, Clone, PartialEq)]
pub struct Tracked {
    /// Which.
    pub output: Output,
    /// The reference that counts as 1, SI.
    pub scale: f64,
    /// W_e.
    pub weight: lpv::tracking::TrackingWeight,
}

/// A design file, checked.
#[derive(Debug, Clone, PartialEq)]
pub struct DesignFile {
    /// The file's name without its ending.
    pub name: String,
    /// One sentence for people.
    pub description: String,
    /// Lowest speed, m/s.
    pub speed_min: f64,
    /// Highest speed, m/s.
    pub speed_max: f64,
    /// Number of speeds at which the vehicle is linearised.
    pub speeds: usize,
    /// Depth, m.
    pub depth: f64,
    /// Order of the polynomials in speed.
    pub order: usize,
    /// Singular values of the LFT below this fraction of the largest are dropped.
    pub drop: f64,
    /// The tracked outputs.
    pub tracked: Vec<Tracked>,
    /// W_u, in units of each actuator's limit.
    pub control_weight: f64,
    /// Disturbance at the input, in units of each actuator's limit.
    pub disturbance: f64,
    /// Relative back-off from the least gamma.
    pub back_off: f64,
    /// Sample time of the autopilot, s.
    pub sample_time: f64,
    /// What the FMU of the whole loop flies by default.
    pub manoeuvre: Manoeuvre,
    /// Which numbers of the vehicle are uncertain; `None` without the section.
    pub uncertainty: Option<Uncertainty>,
}

/// What is wrong with a design file.
#[derive(Debug, Error)]
pub enum DesignFileError {
    /// The file cannot be read.
    #[error("{file}: cannot be read: {reason}")]
    Unreadable {
        /// The file.
        file: String,
        /// The system's reason.
        reason: std::io::Error,
    },
    /// It is not TOML, or a key is unknown, missing or of the wrong type.
    #[error("{file}: {reason}")]
    Malformed {
        /// The file.
        file: String,
        /// The parser's words, with the line.
        reason: String,
    },
    /// A value is out of its range.
    #[error("{file}, line {line}: '{key}' is {found}; it must be {allowed}")]
    OutOfRange {
        /// The file.
        file: String,
        /// The line.
        line: usize,
        /// The key.
        key: String,
        /// The value found.
        found: String,
        /// What is allowed.
        allowed: &'static str,
    },
    /// A coefficient is named that the vehicle does not have.
    #[error("{file}, line {line}: [{section}]: {reason}")]
    UnknownCoefficient {
        /// The file.
        file: String,
        /// The line.
        line: usize,
        /// The section.
        section: &'static str,
        /// The name, and the nearest that there is.
        reason: Box<auv::UnknownParameter>,
    },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Raw {
    description: String,
    model: RawModel,
    track: Vec<RawTrack>,
    control: RawControl,
    synthesis: RawSynthesis,
    autopilot: RawAutopilot,
    manoeuvre: RawManoeuvre,
    uncertainty: Option<uncertainty::RawUncertainty>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawModel {
    speed_min: Spanned<f64>,
    speed_max: Spanned<f64>,
    speeds: Spanned<usize>,
    depth: Spanned<f64>,
    order: Spanned<usize>,
    drop: Spanned<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawTrack {
    output: Spanned<Output>,
    scale: Spanned<f64>,
    unit: Spanned<String>,
    peak: Spanned<f64>,
    steady_error: Spanned<f64>,
    bandwidth: Spanned<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawControl {
    weight: Spanned<f64>,
    disturbance: Spanned<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawSynthesis {
    back_off: Spanned<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawAutopilot {
    sample_time: Spanned<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawManoeuvre {
    pitch_step: Spanned<f64>,
    unit: Spanned<String>,
    step_time: Spanned<f64>,
    speed_from: Spanned<f64>,
    speed_to: Spanned<f64>,
    ramp_start: Spanned<f64>,
    ramp_duration: Spanned<f64>,
    duration: Spanned<f64>,
}

impl DesignFile {
    /// Reads and checks a design file.
    ///
    /// # Errors
    /// [`DesignFileError`], which names file, line and key.
    pub fn read(path: &Path) -> Result<Self, DesignFileError> {
        let file = path.display().to_string();
        let text = std::fs::read_to_string(path)
            .map_err(|reason| DesignFileError::Unreadable { file: file.clone(), reason })?;
        let name = path.file_stem().map_or_else(|| file.clone(), |s| s.to_string_lossy().into_owned());
        Self::parse(&text, &file, &name)
    }

    /// Checks the text of a design file; `file` is for messages.
    ///
    /// # Errors
    /// [`DesignFileError`], which names file, line and key.
    pub fn parse(text: &str, file: &str, name: &str) -> Result<Self, DesignFileError> {
        let raw: Raw = toml::from_str(text).map_err(|e| DesignFileError::Malformed {
            file: file.into(),
            reason: e.to_string().trim_end().replace("TOML parse error at ", ""),
        })?;
        let check = Checker { text, file };
        let m = &raw.model;
        let speed_min = check.number("model.speed_min", &m.speed_min, |v| v > 0.0, "above 0 (m/s)")?;
        let order = check.number("model.order", &m.order, |v| (1..=5).contains(&v), "from 1 to 5")?;
        if raw.track.is_empty() {
            return Err(DesignFileError::Malformed {
                file: file.into(),
                reason: "there is no [[track]] table".into(),
            });
        }
        Ok(Self {
            name: name.into(),
            description: raw.description,
            speed_min,
            speed_max: check.number(
                "model.speed_max",
                &m.speed_max,
                |v| v > speed_min,
                "above speed_min (m/s)",
            )?,
            speeds: check.number(
                "model.speeds",
                &m.speeds,
                |v| v > order && v <= 1000,
                "more than the order and at most 1000",
            )?,
            depth: check.number("model.depth", &m.depth, |v| v >= 0.0, "0 or more (m)")?,
            order,
            drop: check.number("model.drop", &m.drop, |v| (0.0..0.5).contains(&v), "from 0 to below 0.5")?,
            tracked: check.tracked(&raw.track)?,
            control_weight: check.within("control.weight", &raw.control.weight, CONTROL_WEIGHT)?,
            disturbance: check.number(
                "control.disturbance",
                &raw.control.disturbance,
                |v| (0.0..=1e6).contains(&v),
                "from 0 to 1e6",
            )?,
            back_off: check.number(
                "synthesis.back_off",
                &raw.synthesis.back_off,
                |v| (0.001..=1.0).contains(&v),
                "from 0.001 to 1",
            )?,
            sample_time: check.number(
                "autopilot.sample_time",
                &raw.autopilot.sample_time,
                |v| (1e-4..=1.0).contains(&v),
                "from 0.0001 to 1 (s)",
            )?,
            manoeuvre: check.manoeuvre(&raw.manoeuvre)?,
            uncertainty: raw.uncertainty.as_ref().map(|raw| check.uncertainty(raw)).transpose()?,
        })
    }

    /// The scheduling parameter rho = (V - centre)/half_range: centre and half range, m/s.
    pub fn scheduling(&self) -> (f64, f64) {
        (0.5 * (self.speed_min + self.speed_max), 0.5 * (self.speed_max - self.speed_min))
    }

    /// The same design with another bandwidth of every W_e, as the paper tunes it in its Fig. 5.
    #[must_use]
    pub fn with_bandwidth(mut self, bandwidth: f64) -> Self {
        for tracked in &mut self.tracked {
            tracked.weight.bandwidth = bandwidth;
        }
        self.name = format!("{}-bandwidth-{bandwidth}", self.name);
        self
    }
}
