//! `squid lpv mu`: upper and lower bounds on mu for a problem file.

use crate::error::Error;
use crate::mu_file::{MuProblem, Perturbed, mu_problem};
use crate::source::Source;
use serde::{Serialize, Serializer};
use squid_base::numbers::digits;
use squid_lpv::bilinear::Bilinear;
use squid_lpv::mu::lower::{LowerBound, SINGULAR_RESIDUAL, lower_bound_below};
use squid_lpv::mu::over_frequency::{FrequencyMu, mu_over_frequency};
use squid_lpv::mu::sweep::{SweepError, response};
use squid_lpv::mu::upper::upper_bound;
use squid_lpv::mu::worst_case::{Perturbable, WorstCaseError, worst_case_gain};
use squid_lpv::mu::{CMat, Structure};
use squid_lpv::state_space::StateSpace;
use std::time::Instant;

/// The result, as `--json` prints it.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Report {
    /// `bounded` or `error`.
    pub status: &'static str,
    /// Upper bound of mu; for a system, over all frequencies from 0 to infinity.
    pub upper: Option<f64>,
    /// Lower bound of mu; 0 if no perturbation was found.
    pub lower: Option<f64>,
    /// Frequency of the largest upper bound, rad/s; `None` for a matrix.
    #[serde(serialize_with = "frequency")]
    pub frequency: Option<f64>,
    /// Frequency of the pole that the perturbation puts on the imaginary axis, rad/s.
    #[serde(serialize_with = "frequency")]
    pub lower_frequency: Option<f64>,
    /// Perturbation of the lower bound: rows of `[re, im]`.
    pub delta: Option<Vec<Vec<[f64; 2]>>>,
    /// Smallest singular value of `I - M Delta`, relative to the largest.
    pub residual: Option<f64>,
    /// Number of frequency intervals from 0 to infinity, each with its scalings.
    pub intervals: Option<usize>,
    /// Robust performance and the worst-case gain, if the problem has performance inputs and outputs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub performance: Option<Performance>,
    /// Wall-clock time.
    pub seconds: Option<f64>,
    /// Reason why there are no bounds.
    pub reason: Option<String>,
    /// Highest frequency, rad/s: in discrete time pi over the sample time.
    #[serde(skip)]
    pub fastest: f64,
}

/// Robust performance and the worst-case gain.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Performance {
    /// Upper bound of mu with a full block from z to w. The gain is below it for every perturbation smaller than its
    /// inverse.
    pub upper: f64,
    /// Lower bound of this mu; 0 if no perturbation was found.
    pub lower: f64,
    /// Size of the perturbations for the worst-case gain.
    pub size: f64,
    /// Upper bound of the gain for perturbations of that size; `None` if stability is not shown.
    pub gain_upper: Option<f64>,
    /// Gain with the worst perturbation of that size found.
    pub gain_lower: Option<f64>,
    /// Frequency of `gain_lower`, rad/s.
    #[serde(serialize_with = "frequency")]
    pub gain_frequency: Option<f64>,
    /// Worst perturbation found: rows of `[re, im]`.
    pub gain_delta: Option<Vec<Vec<[f64; 2]>>>,
}

/// Serialises an infinite frequency as a word, since JSON has no infinity.
fn frequency<S: Serializer>(omega: &Option<f64>, out: S) -> Result<S::Ok, S::Error> {
    match omega {
        Some(w) if w.is_infinite() => out.serialize_str("infinity"),
        other => other.serialize(out),
    }
}

/// Bounds mu of the problem of a file.
///
/// # Errors
/// Errors of the file; [`Error::Mu`] if the system is unstable or the sweep fails.
pub fn run(source: &Source) -> Result<Report, Error> {
    let MuProblem { perturbed, structure, discrete } = mu_problem(source)?;
    let wrong = |reason| Error::Mu { file: source.name.clone(), reason };
    let begin = Instant::now();
    let mut report = Report { status: "bounded", fastest: f64::INFINITY, ..Report::default() };
    let lower = match perturbed {
        Perturbed::Matrix(m) => {
            let upper = upper_bound(&m, &structure).map_err(|e| wrong(e.into()))?;
            report.upper = Some(upper.value);
            lower_bound_below(&m, &structure, Some(&upper)).map_err(|e| wrong(e.into()))?
        }
        Perturbed::System(system) => report.over_frequency(&system, &structure).map_err(wrong)?,
        Perturbed::WithPerformance(system, size) => {
            let augmented = Perturbable { system, structure, size };
            let lower = report.over_frequency(&augmented.stability(), &augmented.structure).map_err(wrong)?;
            report.performance = Some(performance(&augmented).map_err(wrong)?);
            lower
        }
    };
    report.set_lower(lower);
    if let Some(transform) = discrete {
        report.frequencies_to_discrete(&transform);
    }
    report.seconds = Some(begin.elapsed().as_secs_f64());
    Ok(report)
}

fn performance(augmented: &Perturbable) -> Result<Performance, SweepError> {
    let both = mu_over_frequency(&augmented.system, &augmented.with_performance()?)?;
    let mut out = Performance {
        upper: both.upper.upper,
        lower: both.lower.map_or(0.0, |bound| bound.value * (1.0 - SINGULAR_RESIDUAL)),
        size: augmented.size,
        ..Performance::default()
    };
    match worst_case_gain(augmented) {
        Ok(gain) => {
            out.gain_upper = Some(gain.upper);
            out.gain_lower = Some(gain.worst.gain);
            out.gain_frequency = Some(gain.worst.frequency);
            out.gain_delta = Some(pairs(&gain.worst.delta));
        }
        Err(WorstCaseError::Sweep(reason)) => return Err(reason),
        Err(_) => {}
    }
    Ok(out)
}

fn pairs(delta: &CMat) -> Vec<Vec<[f64; 2]>> {
    delta.row_iter().map(|row| row.iter().map(|v| [v.re, v.im]).collect()).collect()
}

/// Relative gap between the bounds below which the lower bound is taken to be at the peak.
const CLOSED_GAP: f64 = 2e-4;

/// Frequency ratio that the golden-section search for the peak covers on each side.
const SEARCH_RATIO: f64 = 1.1;
/// Number of steps of the golden-section search.
const SEARCH_STEPS: usize = 24;

/// Estimates the frequency of the largest mu \[rad/s\]: that of the lower bound if the bounds meet, else the maximum of
/// the upper bound by golden-section search around the largest value of the sweep.
fn peak(system: &StateSpace, structure: &Structure, mu: &FrequencyMu) -> f64 {
    let near = mu.upper.frequency;
    if let Some(lower) = mu.lower.as_ref().filter(|l| l.value >= mu.upper.upper * (1.0 - CLOSED_GAP))
        && let Some(omega) = lower.frequency
        && structure.is_real()
    {
        return omega;
    }
    if near == 0.0 || near.is_infinite() {
        return near;
    }
    let bound = |log: f64| {
        let m = response(system, log.exp());
        m.and_then(|m| upper_bound(&m, structure).ok()).map_or(0.0, |bound| bound.value)
    };
    let golden = 0.5 * (5f64.sqrt() - 1.0);
    let (mut low, mut high) = (near.ln() - SEARCH_RATIO.ln(), near.ln() + SEARCH_RATIO.ln());
    let (mut left, mut right) = (high - golden * (high - low), low + golden * (high - low));
    let (mut at_left, mut at_right) = (bound(left), bound(right));
    for _ in 0..SEARCH_STEPS {
        if at_left > at_right {
            (high, right, at_right) = (right, left, at_left);
            left = high - golden * (high - low);
            at_left = bound(left);
        } else {
            (low, left, at_left) = (left, right, at_right);
            right = low + golden * (high - low);
            at_right = bound(right);
        }
    }
    let refined = 0.5 * (low + high);
    if bound(refined) >= bound(near.ln()) { refined.exp() } else { near }
}

impl Report {
    /// Returns the report of an error.
    pub fn refused(error: &Error) -> Self {
        Self { status: "error", reason: Some(error.to_string()), ..Self::default() }
    }

    /// Sets the upper bound for a system, and returns the lower bound.
    fn over_frequency(
        &mut self,
        system: &StateSpace,
        structure: &Structure,
    ) -> Result<Option<LowerBound>, SweepError> {
        let mu = mu_over_frequency(system, structure)?;
        self.upper = Some(mu.upper.upper);
        self.frequency = Some(peak(system, structure, &mu));
        self.intervals = Some(mu.upper.pieces.len());
        Ok(mu.lower)
    }

    fn set_lower(&mut self, lower: Option<LowerBound>) {
        // I - M Delta is singular up to SINGULAR_RESIDUAL, which is subtracted.
        self.lower = Some(lower.as_ref().map_or(0.0, |l| l.value * (1.0 - SINGULAR_RESIDUAL)));
        let Some(lower) = lower else { return };
        self.lower_frequency = lower.frequency;
        self.residual = Some(lower.residual);
        self.delta = Some(pairs(&lower.delta));
    }

    /// Converts the frequencies to discrete time.
    fn frequencies_to_discrete(&mut self, transform: &Bilinear) {
        self.fastest = transform.frequency(0.0).max(transform.frequency(f64::INFINITY));
        let gain = self.performance.as_mut().map(|found| &mut found.gain_frequency);
        for omega in [&mut self.frequency, &mut self.lower_frequency].into_iter().chain(gain) {
            *omega = omega.map(|omega| transform.frequency(omega));
        }
    }

    /// Returns the text for a terminal, with conservatively rounded bounds.
    pub fn text(&self) -> String {
        let (upper, lower) = (self.upper.unwrap_or(f64::INFINITY), self.lower.unwrap_or(0.0));
        let (most, size) = (digits(upper, f64::ceil), digits(1.0 / lower, f64::ceil));
        let fastest = if self.fastest.is_infinite() { "infinity".into() } else { rads(self.fastest) };
        let (below, safe) = match self.frequency {
            Some(w) => (
                format!("mu <= {most} at every frequency from 0 to {fastest}, largest near {}", rads(w)),
                "the loop is stable for every perturbation of this structure",
            ),
            None => (
                format!("mu <= {most}"),
                "I - M Delta has an inverse for every perturbation of this structure",
            ),
        };
        let least = digits(lower, f64::floor);
        let above = match (lower > 0.0, self.lower_frequency) {
            (false, _) => "No perturbation was found that gives a lower bound.".into(),
            (true, None) => {
                format!("mu >= {least}: a perturbation of size {size} makes I - M Delta singular.")
            }
            (true, Some(w)) => format!(
                "mu >= {least}: a perturbation of size {size} places a pole on the imaginary axis, at {}.",
                rads(w)
            ),
        };
        let margin = if upper > 0.0 {
            format!("{safe} smaller than {}", digits(1.0 / upper, f64::floor))
        } else {
            format!("{safe} of any size")
        };
        let intervals =
            self.intervals.map_or_else(String::new, |n| format!(" {n} intervals cover the frequency axis."));
        let seconds = self.seconds.unwrap_or(0.0);
        let performance = self.performance.as_ref().map_or_else(String::new, Performance::text);
        format!("{below}.{intervals}\n{above}\nMargin 1/mu: {margin}.\n{performance}{seconds:.2} s")
    }
}

impl Performance {
    fn text(&self) -> String {
        let up = |v: f64| digits(v, f64::ceil);
        let mut out = format!(
            "Robust performance: mu with performance block <= {0}, so that the gain from w to z is below {0} for \
                every perturbation smaller than {1}; mu >= {2}.\n",
            up(self.upper),
            digits(1.0 / self.upper, f64::floor),
            digits(self.lower, f64::floor)
        );
        out += &match (self.gain_upper, self.gain_lower) {
            (Some(upper), Some(lower)) => format!(
                "Worst-case gain for perturbations of size {}: below {} at every frequency, and at least {} for \
                    one of them, at {}.\n",
                self.size,
                up(upper),
                digits(lower, f64::floor),
                rads(self.gain_frequency.unwrap_or(0.0))
            ),
            _ => format!(
                "Worst-case gain: no bound, because stability is not shown for perturbations of size {}.\n",
                self.size
            ),
        };
        out
    }
}

fn rads(omega: f64) -> String {
    if omega.is_infinite() {
        "infinite frequency".into()
    } else {
        format!("{} rad/s", digits(omega, f64::round))
    }
}
