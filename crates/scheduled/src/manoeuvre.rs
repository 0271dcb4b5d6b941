//! Default manoeuvre: steps of references during a speed ramp.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::f64::consts::PI;

use crate::ControllerDesign;

/// Name of the manoeuvre file in `resources/`.
pub const MANOEUVRE_RESOURCE: &str = "manoeuvre.json";

/// `format` of a manoeuvre file.
pub const MANOEUVRE_FORMAT: &str = "squid-manoeuvre/1";

/// Time \[s\] by which a step takes effect earlier, so that rounding of `k Ts` cannot delay it by a tick.
const ROUNDING_OF_TIME: f64 = 1e-9;

/// Step of one or more references during a speed ramp.
///
/// ```text
/// V(t)   = speed_from + (speed_to - speed_from) clamp((t - ramp_start)/ramp_duration, 0, 1)
/// r_i(t) = y0_i(V(t)) + steps[i]   for step_time <= t < step_end
///          y0_i(V(t))              otherwise
/// ```
///
/// y0 is the signal in trim; for the depth and other signals measured from the start, the initial value.
///
/// ```
/// use squid_scheduled::Manoeuvre;
/// let manoeuvre = Manoeuvre::from_json(
///     r#"{"format": "squid-manoeuvre/1", "steps": {"pitch": 0.17}, "step_time": 5.0, "step_end": 100.0,
///         "speed_from": 0.5, "speed_to": 3.0, "ramp_start": 10.0, "ramp_duration": 20.0, "duration": 60.0}"#,
/// )?;
/// assert_eq!((manoeuvre.speed_reference(20.0), manoeuvre.above_trim(20.0, "pitch")), (1.75, 0.17));
/// # Ok::<(), squid_scheduled::ManoeuvreError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manoeuvre {
    /// [`MANOEUVRE_FORMAT`].
    pub format: String,
    /// Height of the step of each signal that steps, SI.
    pub steps: BTreeMap<String, f64>,
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

/// Error of a manoeuvre; `key` is the key in the JSON file and the name of the FMU's parameter.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum ManoeuvreError {
    /// Invalid JSON, or a key that is missing, unknown or of another type.
    #[error("the manoeuvre cannot be read: {0}")]
    Json(#[from] serde_json::Error),
    /// Unsupported format or version.
    #[error("format is '{found}'; it must be '{MANOEUVRE_FORMAT}'")]
    WrongFormat { found: String },
    /// Number out of its allowed range.
    #[error("{key} is {value:?}; it must be {allowed}")]
    BadNumber { key: String, value: f64, allowed: String },
    /// Step that ends before it starts.
    #[error("step_end is {step_end:?} s, before step_time at {step_time:?} s")]
    StepEndsBeforeItStarts { step_time: f64, step_end: f64 },
}

fn check_number(key: &str, value: f64, valid: bool, allowed: &str) -> Result<(), ManoeuvreError> {
    let (key, allowed) = (key.to_owned(), allowed.to_owned());
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
        for (name, height) in &self.steps {
            check_number(&format!("{name}_step"), *height, true, "finite")?;
        }
        for (key, value) in [
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

    /// Checks that an autopilot has a reference for every step, and that each step is within the range of its signal,
    /// for a circular angle below half a turn, from where the shorter way is not unique.
    ///
    /// # Errors
    /// [`ManoeuvreError::BadNumber`].
    #[inline]
    pub fn check_steps(&self, design: &ControllerDesign) -> Result<(), ManoeuvreError> {
        self.check_steps_of(&[design])
    }

    /// Checks the same as [`check_steps`](Self::check_steps) for the autopilots of several axes, of which one has to
    /// have the reference of each step.
    ///
    /// # Errors
    /// [`ManoeuvreError::BadNumber`].
    pub fn check_steps_of(&self, designs: &[&ControllerDesign]) -> Result<(), ManoeuvreError> {
        for (name, height) in self.steps.iter().filter(|(_, height)| **height != 0.0) {
            let key = format!("{name}_step");
            let signal = designs.iter().find_map(|design| {
                let index = design.index(name).filter(|index| design.has_reference(*index))?;
                Some(&design.signals[index])
            });
            let Some(signal) = signal else {
                return check_number(&key, *height, false, "0, because the autopilot has no such reference");
            };
            let half_turn = if signal.circular { PI } else { f64::INFINITY };
            let [least, most] = signal.range.unwrap_or([-half_turn, half_turn]);
            let (valid, allowed) =
                (least < *height && *height < most, format!("above {least} and below {most}"));
            check_number(&key, *height, valid, &allowed)?;
        }
        Ok(())
    }

    /// Checks that the vehicle moves ahead, with speeds above 0.
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

    /// Returns the parameters of the manoeuvre except the steps.
    pub fn numbers(&mut self) -> [&mut f64; 7] {
        [
            &mut self.step_time,
            &mut self.step_end,
            &mut self.speed_from,
            &mut self.speed_to,
            &mut self.ramp_start,
            &mut self.ramp_duration,
            &mut self.duration,
        ]
    }

    /// Returns the speed reference V along the path through the water \[m/s\] at a time \[s\].
    pub fn speed_reference(&self, time: f64) -> f64 {
        let progress = ((time - self.ramp_start) / self.ramp_duration).clamp(0.0, 1.0);
        // Exact at both ends.
        (1.0 - progress) * self.speed_from + progress * self.speed_to
    }

    /// Returns the height of the step of a signal, SI; 0 without one.
    pub fn step(&self, signal: &str) -> f64 {
        self.steps.get(signal).copied().unwrap_or_default()
    }

    /// Returns this manoeuvre with a step of this signal only.
    #[must_use]
    pub fn with_step(&self, signal: &str, height: f64) -> Self {
        Self { steps: [(signal.to_owned(), height)].into(), ..self.clone() }
    }

    /// Returns this manoeuvre without steps.
    #[must_use]
    pub fn without_steps(&self) -> Self {
        Self { steps: BTreeMap::new(), ..self.clone() }
    }

    /// Returns the reference of a signal minus its value in trim, SI, at a time \[s\].
    pub fn above_trim(&self, time: f64, signal: &str) -> f64 {
        let time = time + ROUNDING_OF_TIME;
        if time >= self.step_time && time < self.step_end { self.step(signal) } else { 0.0 }
    }
}
