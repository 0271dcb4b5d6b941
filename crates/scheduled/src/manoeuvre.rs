//! The default manoeuvre: a pitch or depth step during a speed ramp.

use std::f64::consts::FRAC_PI_2;

use serde::{Deserialize, Serialize};
use signals::{DEPTH, EachTracked, PITCH, only};

use crate::design::is_default;

/// The manoeuvre in `resources/`.
pub const MANOEUVRE_RESOURCE: &str = "manoeuvre.json";

/// The `format` of the files that this version reads and writes.
pub const MANOEUVRE_FORMAT: &str = "squid-manoeuvre/1";

/// A step takes effect this much earlier \[s\], so that rounding of `k Ts` cannot delay it by a tick.
const ROUNDING_OF_TIME: f64 = 1e-9;

/// A step of pitch, of depth or of both, during a speed ramp.
///
/// ```text
/// V(t)     = speed_from + (speed_to - speed_from) clamp((t - ramp_start)/ramp_duration, 0, 1)
/// theta(t) = theta_trim(V(t)) + pitch_step   for step_time <= t < step_end
///            theta_trim(V(t))                otherwise
/// ```
///
/// The depth reference steps likewise, from the initial depth.
///
/// ```
/// use scheduled::Manoeuvre;
/// let manoeuvre = Manoeuvre::from_json(
///     r#"{"format": "squid-manoeuvre/1", "pitch_step": 0.17, "step_time": 5.0, "step_end": 100.0,
///         "speed_from": 0.5, "speed_to": 3.0, "ramp_start": 10.0, "ramp_duration": 20.0, "duration": 60.0}"#,
/// )?;
/// assert_eq!((manoeuvre.speed_reference(20.0), manoeuvre.above_trim(20.0)), (1.75, [0.17, 0.0, 0.0]));
/// # Ok::<(), scheduled::ManoeuvreError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manoeuvre {
    /// [`MANOEUVRE_FORMAT`].
    pub format: String,
    /// Height of the step above the trim pitch \[rad\].
    pub pitch_step: f64,
    /// Height of the depth step, positive down \[m\].
    #[serde(default, skip_serializing_if = "is_default")]
    pub depth_step: f64,
    /// Start of the step \[s\].
    pub step_time: f64,
    /// End of the step \[s\]; beyond the end of the flight for a lasting step.
    pub step_end: f64,
    /// Speed V along the path through the water before the ramp \[m/s\], negative astern.
    pub speed_from: f64,
    /// Speed V after the ramp \[m/s\].
    pub speed_to: f64,
    /// Start of the ramp \[s\].
    pub ramp_start: f64,
    /// Duration of the ramp \[s\].
    pub ramp_duration: f64,
    /// Default duration of the flight \[s\].
    pub duration: f64,
}

/// Why a manoeuvre is invalid; `key` is the key in the JSON file and the name of the FMU's parameter.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum ManoeuvreError {
    /// Not JSON, or a key that is missing, unknown or of another type.
    #[error("the manoeuvre cannot be read: {0}")]
    Json(#[from] serde_json::Error),
    /// Another format or version.
    #[error("format is '{found}', but only '{MANOEUVRE_FORMAT}' can be read")]
    WrongFormat { found: String },
    /// A number that is not allowed.
    #[error("{key} is {value}, but must be {allowed}")]
    BadNumber { key: &'static str, value: f64, allowed: &'static str },
    /// A step that ends before it starts.
    #[error("step_end is {step_end} s, before step_time at {step_time} s")]
    StepEndsBeforeItStarts { step_time: f64, step_end: f64 },
}

fn check_number(
    key: &'static str,
    value: f64,
    valid: bool,
    allowed: &'static str,
) -> Result<(), ManoeuvreError> {
    if value.is_finite() && valid { Ok(()) } else { Err(ManoeuvreError::BadNumber { key, value, allowed }) }
}

impl Manoeuvre {
    /// Reads and checks a manoeuvre.
    ///
    /// # Errors
    /// [`ManoeuvreError`] with the key at fault.
    #[inline]
    pub fn from_json(text: &str) -> Result<Self, ManoeuvreError> {
        let manoeuvre: Self = serde_json::from_str(text)?;
        manoeuvre.check()?;
        Ok(manoeuvre)
    }

    /// Writes the manoeuvre as JSON, with numbers that read back to the same `f64`.
    ///
    /// # Errors
    /// [`ManoeuvreError`] as for [`Manoeuvre::check`].
    #[inline]
    pub fn to_json(&self) -> Result<String, ManoeuvreError> {
        self.check()?;
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }

    /// Checks format and numbers.
    ///
    /// # Errors
    /// The first [`ManoeuvreError`].
    #[inline]
    pub fn check(&self) -> Result<(), ManoeuvreError> {
        if self.format != MANOEUVRE_FORMAT {
            return Err(ManoeuvreError::WrongFormat { found: self.format.clone() });
        }
        let valid = self.pitch_step.abs() < FRAC_PI_2;
        check_number("pitch_step", self.pitch_step, valid, "above -pi/2 and below pi/2")?;
        for (key, value) in [
            ("depth_step", self.depth_step),
            ("step_time", self.step_time),
            ("step_end", self.step_end),
            ("speed_from", self.speed_from),
            ("speed_to", self.speed_to),
            ("ramp_start", self.ramp_start),
        ] {
            check_number(key, value, true, "finite")?;
        }
        for (key, value) in [("ramp_duration", self.ramp_duration), ("duration", self.duration)] {
            check_number(key, value, value > 0.0, "finite and above 0")?;
        }
        if self.step_end < self.step_time {
            let Self { step_time, step_end, .. } = *self;
            return Err(ManoeuvreError::StepEndsBeforeItStarts { step_time, step_end });
        }
        Ok(())
    }

    /// Checks that the vehicle moves ahead: its speeds are above 0.
    ///
    /// # Errors
    /// [`ManoeuvreError::BadNumber`].
    #[inline]
    pub fn check_ahead(&self) -> Result<(), ManoeuvreError> {
        for (key, value) in [("speed_from", self.speed_from), ("speed_to", self.speed_to)] {
            check_number(key, value, value > 0.0, "finite and above 0")?;
        }
        Ok(())
    }

    /// The nine numbers of the manoeuvre.
    pub fn numbers(&mut self) -> [&mut f64; 9] {
        [
            &mut self.pitch_step,
            &mut self.depth_step,
            &mut self.step_time,
            &mut self.step_end,
            &mut self.speed_from,
            &mut self.speed_to,
            &mut self.ramp_start,
            &mut self.ramp_duration,
            &mut self.duration,
        ]
    }

    /// Speed reference V along the path through the water \[m/s\] at a time \[s\].
    pub fn speed_reference(&self, time: f64) -> f64 {
        let progress = ((time - self.ramp_start) / self.ramp_duration).clamp(0.0, 1.0);
        // Exact at both ends.
        (1.0 - progress) * self.speed_from + progress * self.speed_to
    }

    /// The step of each reference \[SI\]; 0 for the speed, which has a ramp.
    pub fn steps(&self) -> EachTracked<f64> {
        let mut steps = EachTracked::default();
        (steps[PITCH], steps[DEPTH]) = (self.pitch_step, self.depth_step);
        steps
    }

    /// This manoeuvre with a single step, in the reference at a place in [`signals::SIGNALS`].
    #[must_use]
    pub fn with_step(&self, place: usize, step: f64) -> Self {
        let steps = only(place, step);
        Self { pitch_step: steps[PITCH], depth_step: steps[DEPTH], ..self.clone() }
    }

    /// References minus their trim values, the depth minus the initial depth \[SI\], at a time \[s\].
    pub fn above_trim(&self, time: f64) -> EachTracked<f64> {
        let time = time + ROUNDING_OF_TIME;
        if time >= self.step_time && time < self.step_end { self.steps() } else { EachTracked::default() }
    }
}
