//! Search over the weights for a fast design with little noise that meets the requirements.
//!
//! ```text
//! min over x   mean of ln(rise time) of the tracked outputs + TRADE (ln(noise) - ln(delay margin))
//! subject to   margin_k(x) >= REQUIRED_MARGIN for every key of [require] with a limit
//! ```
//!
//! Noise is the largest rms of a command relative to its actuator's reach; the delay margin is the smallest of all. x
//! contains the logarithms of the factors on the keys ([`Knob`]). First all models are slowed down together, at one
//! design per step; if none of these meets the requirements and the best has a gamma above 1, also with less weight on
//! slow references. Then follow rounds of two parallel searches with COBYLA, one over groups of keys (`Direction`) and
//! then over single keys, the other in the reverse order; the first round starts from the two best of the first
//! designs, later ones from the best so far. The search ends after a round with too little improvement, or after a
//! number of designs. The best are fully evaluated and proved.
//!
//! The result does not depend on the clock or the number of processors: the same files give the same design.

use crate::attempt::attempt_until_missed;
use crate::candidate::{Attempt, Candidate, FAILED_COST, REQUIRED_MARGIN, SearchRecord, front, merit};
use crate::descent::{descend, margins, required};
use crate::direction::Direction;
use crate::error::Error;
use crate::finals::{Finalist, finals};
use crate::knob::Knob;
use rayon::prelude::*;
use squid_base::progress::Progress;
use squid_design::fit::Model;
use squid_design::fit::authority;
use squid_design::inputs::Inputs;
use squid_design::run::Finished;
use squid_design::verdict::Verdict;
use squid_finding::Finding;
use std::sync::{Mutex, PoisonError};

/// First step of the logarithm of a factor.
const FIRST_STEP: f64 = 0.3;
/// Last step of the logarithm of a factor.
const LAST_STEP: f64 = 0.02;
/// Smallest reduction of the merit in a round that continues the search: one hundredth of the rise time, or of a limit.
const GAIN: f64 = 0.01;
/// Factors on all frequencies and bandwidths of the first designs.
const FREQUENCY_FACTORS: [f64; 4] = [1.0, 0.65, 0.42, 0.27];
/// Factor on `follow` - 1 if none of these meets the requirements and the best has a gamma above 1: slow errors cannot
/// be as small as required, and demanding it costs margins.
const LESS_FOLLOW: f64 = 0.07;
/// Weight of noise and delay margin relative to the rise time: 10 % of one of them counts as much as 1 % of rise time.
const TRADE: f64 = 0.1;
/// Number of parallel searches, on any machine.
const SEARCHES: usize = 2;

/// Outcome of a search.
#[derive(Debug)]
pub struct Tuned {
    /// Text of the design file.
    pub text: String,
    /// Finished design of that text.
    pub finished: Finished,
    /// Number of designs tried.
    pub tried: usize,
    /// `true` if the search converged; `false` if it used the allowed number of designs.
    pub ended: bool,
    /// Pareto front of rise time and disk margin, the fastest first, with the status of each candidate; of those that
    /// meet the requirements, or of all if none does.
    pub front: Vec<(Candidate, CandidateStatus)>,
    /// Limits of the actuators on the written design that no controller can overcome, by the linear model.
    pub limits: Vec<Finding>,
}

/// Status of a candidate after a search.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum CandidateStatus {
    /// Written to the design file.
    Written,
    /// Fully evaluated and rejected, with the reason.
    Rejected(String),
    /// Evaluated at few speeds only, because the margin (%) of a key is too small.
    InsufficientMargin(&'static str, String),
    /// Evaluated at few speeds only.
    NotEvaluated,
}

/// Searches from the numbers of a design file with this text, with at most `designs` designs.
///
/// # Errors
/// [`Error::NoDesign`], [`Error::NotATable`], and the errors of the model.
pub fn search(inputs: &Inputs, text: &str, designs: usize, progress: &Progress) -> Result<Tuned, Error> {
    let search = Search {
        inputs,
        model: Model::new(&inputs.axis(), &inputs.design)?,
        knobs: Knob::all(&inputs.design),
        keys: required(&inputs.design),
        shown: Mutex::new((0, f64::INFINITY)),
        progress,
    };
    let what = format!("searching, with at most {designs} designs");
    let (SearchRecord { tried, ended, reason }, _) = progress.timed("tune", &what, || search.run(designs));
    let known: Vec<&Candidate> = tried.iter().filter(|t| t.cost < FAILED_COST).collect();
    if known.is_empty() {
        return Err(Error::NoDesign { tried: tried.len(), reason: reason.unwrap_or_default() });
    }
    let front = front(&known);
    let (judged, chosen) = finals(inputs, text, &search.knobs, known, progress)?;
    let front = front.into_iter().map(|t| (t.clone(), search.status(&t, &judged))).collect();
    let (text, finished) = chosen;
    let design = inputs.design.parse_again(&text)?;
    let limits = authority::findings(&inputs.vehicle.actuators, &design, &finished.model);
    Ok(Tuned { text, finished, tried: tried.len(), ended, front, limits })
}

struct Search<'a> {
    inputs: &'a Inputs,
    model: Model,
    knobs: Vec<Knob>,
    keys: Vec<&'static str>,
    /// Number of designs so far and the best merit reported, for the progress lines.
    shown: Mutex<(usize, f64)>,
    progress: &'a Progress<'a>,
}

impl Search<'_> {
    /// Tries slower designs, then rounds of searches until one improves too little or no designs are left.
    fn run(&self, designs: usize) -> SearchRecord {
        let mut all = SearchRecord::default();
        let mut left = designs;
        self.slow_down(&mut all, &mut left);
        let mut starts: Vec<Candidate> = all.tried.clone();
        starts.sort_by(|a, b| merit(a).total_cmp(&merit(b)));
        starts.truncate(SEARCHES);
        let mut first = FIRST_STEP;
        while first > LAST_STEP && left > 0 && starts.len() == SEARCHES {
            let before = all.best().map_or(f64::INFINITY, merit);
            let designs: Vec<usize> = (0..SEARCHES).map(|i| (left + SEARCHES - 1 - i) / SEARCHES).collect();
            let found: Vec<Vec<Attempt>> =
                (0..SEARCHES).into_par_iter().map(|i| self.round(i, &starts[i], first, designs[i])).collect();
            left -= found.iter().map(Vec::len).sum::<usize>();
            found.into_iter().for_each(|found| all.add(found));
            let best = all.best().cloned();
            if before - best.as_ref().map_or(f64::INFINITY, merit) < GAIN && left > 0 {
                all.ended = true;
                return all;
            }
            first *= 0.5;
            starts = best.into_iter().cycle().take(SEARCHES).collect();
        }
        all.ended = left > 0;
        all
    }

    /// Tries slower models; if none meets the requirements, also with less weight on slow references.
    fn slow_down(&self, all: &mut SearchRecord, left: &mut usize) {
        for follow in [1.0, LESS_FOLLOW] {
            let slowed = |frequency: &f64| -> Vec<f64> {
                let factor = |knob: &Knob| match knob {
                    Knob::Frequency(_) | Knob::Bandwidth(_) => *frequency,
                    Knob::Follow(_) => follow,
                    _ => 1.0,
                };
                self.knobs.iter().map(|knob| factor(knob).ln()).collect()
            };
            let factors = &FREQUENCY_FACTORS[..FREQUENCY_FACTORS.len().min(*left)];
            let found: Vec<Attempt> =
                factors.par_iter().map(|factor| self.attempt(&slowed(factor))).collect();
            *left -= found.len();
            all.add(found);
            let weights_unmet = all.best().is_some_and(|best| best.gamma > 1.0);
            if all.tried.iter().any(Candidate::meets_all) || !weights_unmet {
                return;
            }
        }
    }

    /// Runs one search of a round: over groups of keys and over single keys, each from the best so far.
    fn round(&self, index: usize, start: &Candidate, first: f64, designs: usize) -> Vec<Attempt> {
        let each: Vec<Direction> = (0..self.knobs.len())
            .filter(|i| !matches!(self.knobs[*i], Knob::Follow(_)))
            .map(|i| Direction(vec![i]))
            .collect();
        let groups = Direction::grouped(&self.knobs);
        let order = if index == 0 { [&groups, &each] } else { [&each, &groups] };
        let (mut best, mut found) = (start.clone(), vec![]);
        for directions in order {
            let attempt = |x: &[f64]| self.attempt(x);
            best = descend(&best, directions, first, designs - found.len(), &attempt, &mut found);
        }
        found
    }

    /// Tries one design.
    fn attempt(&self, x: &[f64]) -> Attempt {
        let turned: Vec<(Knob, f64)> = self.knobs.iter().copied().zip(x.iter().map(|x| x.exp())).collect();
        let found = attempt_until_missed(self.inputs, &self.model, &turned);
        let tried = found
            .as_ref()
            .map_or_else(|_| Candidate::failed(x, self.keys.len()), |verdict| self.evaluated(x, verdict));
        self.show_progress(&tried);
        Attempt { tried, failed: found.err().map(|why| why.to_string()) }
    }

    /// Reports progress if a candidate is the best so far.
    fn show_progress(&self, tried: &Candidate) {
        let mut shown = self.shown.lock().unwrap_or_else(PoisonError::into_inner);
        shown.0 += 1;
        if merit(tried) < shown.1 && tried.cost < FAILED_COST {
            shown.1 = merit(tried);
            let text = format!(
                "design {}: rise {:.2} s, disk margin {:.1} deg, {}",
                shown.0,
                tried.rise,
                tried.disk,
                self.missed(tried)
            );
            self.progress.done("tune", &text);
        }
    }

    /// Returns the status of a candidate of the front.
    fn status(&self, tried: &Candidate, judged: &[Finalist]) -> CandidateStatus {
        if let Some(found) = judged.iter().find(|f| f.x == tried.x) {
            return found.rejected.clone().map_or(CandidateStatus::Written, CandidateStatus::Rejected);
        }
        let worst = self.keys.iter().zip(&tried.margins).min_by(|a, b| a.1.total_cmp(b.1));
        match worst {
            Some((key, margin)) if (0.0..REQUIRED_MARGIN).contains(margin) => {
                CandidateStatus::InsufficientMargin(key, format!("{:.1}", 100.0 * margin))
            }
            _ => CandidateStatus::NotEvaluated,
        }
    }

    /// Returns the worst violation of a candidate as text.
    fn missed(&self, tried: &Candidate) -> String {
        let worst = self.keys.iter().zip(&tried.margins).min_by(|a, b| a.1.total_cmp(b.1));
        match worst {
            Some((key, margin)) if *margin < 0.0 => format!("misses {key} by {:.0} %", -100.0 * margin),
            _ => "all met".into(),
        }
    }

    /// Returns the candidate of a design with a verdict.
    fn evaluated(&self, x: &[f64], verdict: &Verdict) -> Candidate {
        let rows = |key: &'static str| verdict.rows.iter().filter(move |row| row.key == key);
        let rises: Vec<f64> = verdict
            .rows
            .iter()
            .filter(|row| row.key.ends_with("_rise"))
            .map(|row| row.achieved.value)
            .collect();
        let mean = rises.iter().map(|rise| rise.ln()).sum::<f64>() / rises.len().max(1) as f64;
        let noise = rows("noise").map(|row| row.achieved.value).fold(f64::NAN, f64::max);
        let delay = rows("delay_margin").map(|row| row.achieved.value).fold(f64::NAN, f64::min);
        let cost = mean + TRADE * (noise.ln() - delay.ln());
        Candidate {
            x: x.to_vec(),
            cost: if cost.is_finite() { cost.min(FAILED_COST) } else { FAILED_COST },
            gamma: rows("gamma").next().map_or(f64::NAN, |row| row.achieved.value),
            margins: margins(&self.keys, verdict),
            rise: rises.first().copied().unwrap_or(f64::NAN),
            disk: rows("disk_margin").next().map_or(f64::NAN, |row| row.achieved.value),
        }
    }
}
