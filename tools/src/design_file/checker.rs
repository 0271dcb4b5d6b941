//! Checks the values of a design file, and says where a wrong one stands.

use super::{BANDWIDTH, DesignFileError, Output, PEAK, Range, RawManoeuvre, RawTrack, SCALE, Tracked};
use fmu_squid::{MANOEUVRE_FORMAT, Manoeuvre};
use toml::Spanned;

/// How long after the end of the flight the step of the default manoeuvre lasts, s.
const NEVER: f64 = 1e6;

/// Knows where a key stands in the text.
pub(super) struct Checker<'a> {
    pub(super) text: &'a str,
    pub(super) file: &'a str,
}

impl Checker<'_> {
    /// A number that is finite and allowed.
    pub(super) fn number<T: Copy + std::fmt::Display>(
        &self,
        key: &str,
        value: &Spanned<T>,
        allowed: impl Fn(T) -> bool,
        words: &'static str,
    ) -> Result<T, DesignFileError> {
        let found = *value.get_ref();
        if allowed(found) && !["inf", "-inf", "NaN"].contains(&found.to_string().as_str()) {
            Ok(found)
        } else {
            Err(self.out_of_range(key, value.span().start, found.to_string(), words))
        }
    }

    /// A number in a range.
    pub(super) fn within(
        &self,
        key: &str,
        value: &Spanned<f64>,
        range: Range,
    ) -> Result<f64, DesignFileError> {
        self.number(key, value, |v| range.allows(v), range.words)
    }

    pub(super) fn out_of_range(
        &self,
        key: &str,
        at: usize,
        found: String,
        allowed: &'static str,
    ) -> DesignFileError {
        let line = self.line(at);
        DesignFileError::OutOfRange { file: self.file.into(), line, key: key.into(), found, allowed }
    }

    /// The line, counted from 1, of a place in the text.
    pub(super) fn line(&self, at: usize) -> usize {
        self.text[..at].bytes().filter(|b| *b == b'\n').count() + 1
    }

    /// A factor from the unit that is named to SI.
    fn angle(&self, key: &str, unit: &Spanned<String>) -> Result<f64, DesignFileError> {
        match unit.get_ref().as_str() {
            "deg" => Ok(1f64.to_radians()),
            "rad" => Ok(1.0),
            other => {
                Err(self.out_of_range(key, unit.span().start, format!("\"{other}\""), "\"deg\" or \"rad\""))
            }
        }
    }

    /// The default manoeuvre.
    pub(super) fn manoeuvre(&self, raw: &RawManoeuvre) -> Result<Manoeuvre, DesignFileError> {
        let positive = |key: &str, v: &Spanned<f64>| self.number(key, v, |v| v > 0.0, "above 0");
        let time = |key: &str, v: &Spanned<f64>| self.number(key, v, |v| v >= 0.0, "0 or more (s)");
        let factor = self.angle("manoeuvre.unit", &raw.unit)?;
        let step = self.number(
            "manoeuvre.pitch_step",
            &raw.pitch_step,
            |v| v != 0.0 && (v * factor).abs() < std::f64::consts::FRAC_PI_2,
            "other than 0 and below a right angle",
        )?;
        let duration = positive("manoeuvre.duration", &raw.duration)?;
        Ok(Manoeuvre {
            format: MANOEUVRE_FORMAT.into(),
            pitch_step: factor * step,
            step_time: time("manoeuvre.step_time", &raw.step_time)?,
            step_end: duration + NEVER,
            speed_from: positive("manoeuvre.speed_from", &raw.speed_from)?,
            speed_to: positive("manoeuvre.speed_to", &raw.speed_to)?,
            ramp_start: time("manoeuvre.ramp_start", &raw.ramp_start)?,
            ramp_duration: positive("manoeuvre.ramp_duration", &raw.ramp_duration)?,
            duration,
        })
    }

    /// The tracked outputs.
    pub(super) fn tracked(&self, raw: &[RawTrack]) -> Result<Vec<Tracked>, DesignFileError> {
        let mut out: Vec<Tracked> = Vec::new();
        for track in raw {
            let output = *track.output.get_ref();
            if out.iter().any(|t| t.output == output) {
                let found = format!("\"{}\" a second time", output.name());
                return Err(self.out_of_range(
                    "track.output",
                    track.output.span().start,
                    found,
                    "named once",
                ));
            }
            let factor = match (output, track.unit.get_ref().as_str()) {
                (Output::Pitch, _) => self.angle("track.unit", &track.unit)?,
                (Output::Speed, "m/s") => 1.0,
                (Output::Speed, other) => {
                    let found = format!("\"{other}\"");
                    return Err(self.out_of_range(
                        "track.unit",
                        track.unit.span().start,
                        found,
                        "\"m/s\" for speed",
                    ));
                }
            };
            out.push(Tracked {
                output,
                scale: factor * self.within("track.scale", &track.scale, SCALE)?,
                weight: lpv::tracking::TrackingWeight {
                    peak: self.within("track.peak", &track.peak, PEAK)?,
                    steady_error: self.number(
                        "track.steady_error",
                        &track.steady_error,
                        |v| v > 0.0 && v < 1.0,
                        "above 0 and below 1",
                    )?,
                    bandwidth: self.within("track.bandwidth", &track.bandwidth, BANDWIDTH)?,
                },
            });
        }
        Ok(out)
    }
}
