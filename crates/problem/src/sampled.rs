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
use crate::object::checked;
use crate::problem_file::sampled_loop;
use crate::source::Source;
use serde::Serialize;
use squid_base::numbers::digits;
use squid_lpv::analysis::{Exogenous, SampledGain, sampled_gain};
use squid_lpv::partition::Group::{U, Y};
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
    /// Reason why there are no bounds.
    pub reason: Option<String>,
}

/// Longest delay, in ticks, as in a design file.
const LONGEST: f64 = 10.0;

const SAMPLE_TIMES: &str = "a number above 0, in seconds";

/// Bounds the gain of the loop of a file.
///
/// # Errors
/// The errors of the file; [`Error::Problem`] if the gain cannot be computed.
pub fn run(source: &Source) -> Result<Report, Error> {
    let (mut plant, data) = sampled_loop(source)?;
    let k = data.k.ok_or_else(|| source.wrong("K", "(the controller) is missing"))?.state_space(source)?;
    let time = checked(source, "sample_time", data.sample_time, SAMPLE_TIMES, |v| v > 0.0)?;
    let missing = || source.wrong("sample_time", format!("is missing; it must be {SAMPLE_TIMES}"));
    let time = time.ok_or_else(missing)?;
    let is_delay = |v: f64| (0.0..=LONGEST).contains(&v) && v.fract() == 0.0;
    let ticks = checked(source, "delay", data.delay, "an integer from 0 to 10 (sample times)", is_delay)?;
    let ticks = ticks.unwrap_or(0.0);
    let w = if data.held == Some(true) { Exogenous::Held } else { Exogenous::Any };
    plant.plant.parts.block_mut(Y, U).copy_from(&plant.d22);
    let begin = Instant::now();
    let SampledGain { lower, upper } = sampled_gain(&plant.plant, &k.delayed(ticks as usize), time, w)
        .map_err(|reason| source.wrong("", reason))?;
    let status = if lower.is_finite() { "bounded" } else { "unstable" };
    let reason = (status == "unstable").then(|| "the sampled loop is unstable".to_owned());
    let [lower, upper] = [lower, upper].map(|v| Some(v).filter(|v| v.is_finite()));
    Ok(Report { status, lower, upper, seconds: Some(begin.elapsed().as_secs_f64()), reason })
}

impl Report {
    /// Returns the report of an error.
    pub fn refused(error: &Error) -> Self {
        Self { status: "error", reason: Some(error.to_string()), ..Self::default() }
    }

    /// Returns the text for a terminal.
    pub fn text(&self) -> String {
        match (self.lower, self.upper) {
            (Some(lower), Some(upper)) => {
                let (least, most) = (digits(lower, f64::floor), digits(upper, f64::ceil));
                let seconds = self.seconds.unwrap_or(0.0);
                format!(
                    "gain from {least} to {most}, including the behaviour between samples\n{seconds:.2} s"
                )
            }
            _ => self.reason.clone().unwrap_or_default(),
        }
    }
}
