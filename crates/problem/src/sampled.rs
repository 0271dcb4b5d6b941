//! `squid lpv sampled`: bounds on the gain of the sampled-data loop of a problem file.
//!
//! ```json
//! {"kind": "sampled", "data": {"P": {"A": [[..]], "B1": .., ..}, "blocks": [],
//!  "K": {"A": .., "B": .., "C": .., "D": ..}, "sample_time": 0.02, "delay": 0, "held": false}}
//! ```
//!
//! P is a plant without parameters in continuous time, K a controller in discrete time from y to u. `delay` is in
//! ticks; with `held`, w is constant between ticks.

use crate::error::Error;
use crate::matrices::{Reader, find};
use crate::mu_file::system;
use crate::problem_file::sampled_loop_plant;
use crate::source::Source;
use base::numbers::digits;
use certificate::Json;
use lpv::analysis::{Exogenous, SampledGain, sampled_gain};
use lpv::partition::Group::{U, Y};
use serde::Serialize;
use std::time::Instant;

/// The result, as `--json` prints it.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Report {
    /// `bounded`, `unstable` or `error`.
    pub status: &'static str,
    /// Lower bound of the gain; `None` if the loop is unstable.
    pub lower: Option<f64>,
    /// Upper bound of the gain; `None` if the loop is unstable.
    pub upper: Option<f64>,
    /// Wall-clock time.
    pub seconds: Option<f64>,
    /// Why there are no bounds.
    pub reason: Option<String>,
}

/// The longest delay, in ticks, as in a design file.
const LONGEST: f64 = 10.0;

const SAMPLE_TIMES: &str = "a number above 0, in seconds";

/// Bounds the gain of the loop of a file.
///
/// # Errors
/// The errors of the file; [`Error::Problem`] if the gain cannot be computed.
pub fn run(source: &Source) -> Result<Report, Error> {
    let mut plant = sampled_loop_plant(source)?;
    let (reader, value) = Reader::open(source)?;
    let data = reader.data(&value)?;
    let k = find(data, "K").ok_or_else(|| reader.wrong("K", "is missing; it is the controller".into()))?;
    let k = system(&reader, reader.object(k, "K")?, "K")?;
    let time = reader.optional_number(data, "sample_time", SAMPLE_TIMES, |v| v > 0.0)?;
    let missing = || reader.wrong("sample_time", format!("is missing; it must be {SAMPLE_TIMES}"));
    let time = time.ok_or_else(missing)?;
    let is_delay = |v: f64| (0.0..=LONGEST).contains(&v) && v.fract() == 0.0;
    let ticks = reader.optional_number(data, "delay", "a whole number of ticks from 0 to 10", is_delay)?;
    let ticks = ticks.unwrap_or(0.0);
    let w = match find(data, "held") {
        None | Some(Json::Bool(false)) => Exogenous::Any,
        Some(Json::Bool(true)) => Exogenous::Held,
        Some(other) => {
            return Err(reader.wrong("held", format!("is {}; it must be true or false", other.describe())));
        }
    };
    plant.plant.parts.block_mut(Y, U).copy_from(&plant.d22);
    let begin = Instant::now();
    let SampledGain { lower, upper } = sampled_gain(&plant.plant, &k.delayed(ticks as usize), time, w)
        .map_err(|reason| reader.wrong("", reason.to_string()))?;
    let status = if lower.is_finite() { "bounded" } else { "unstable" };
    let reason = (status == "unstable").then(|| "the loop is not stable from tick to tick".to_owned());
    let [lower, upper] = [lower, upper].map(|v| Some(v).filter(|v| v.is_finite()));
    Ok(Report { status, lower, upper, seconds: Some(begin.elapsed().as_secs_f64()), reason })
}

impl Report {
    /// The report of an error.
    pub fn refused(error: &Error) -> Self {
        Self { status: "error", reason: Some(error.to_string()), ..Self::default() }
    }

    /// The text for a terminal.
    pub fn words(&self) -> String {
        match (self.lower, self.upper) {
            (Some(lower), Some(upper)) => {
                let (least, most) = (digits(lower, f64::floor), digits(upper, f64::ceil));
                let seconds = self.seconds.unwrap_or(0.0);
                format!("gain from {least} to {most}, between the ticks too\n{seconds:.2} s")
            }
            _ => self.reason.clone().unwrap_or_default(),
        }
    }
}
