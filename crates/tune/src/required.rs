//! PID gains that meet the requirements, from the gains of smallest loop gain.
//!
//! ```text
//! min over x   ln(largest gain of the weighted loop over frozen speeds)
//! subject to   margin_k(x) >= REQUIRED_MARGIN for every key of [require] with a limit
//! ```
//!
//! x contains the logarithms of the factors on the constant coefficients, and the increments of the other coefficients,
//! relative to the constant one, and of the reference weights. Two descents ([`descend`]) run in parallel, one from the
//! given gains and one from slower ones, and again from the best with half the step, until a round improves too little.
//! Mu, the slowest figure, is evaluated once the others are met. Some of the sets near the best are proved, and sorted
//! by the proved gain. The result does not depend on the clock or the number of processors.

use crate::attempt::judged_until_missed;
use crate::candidate::{Attempt, Candidate, FAILED_COST, merit};
use crate::descent::{descend, margins, required};
use crate::direction::Direction;
use crate::error::Error;
use crate::gain::{TunedGain, WEIGHTS, with_gains};
use rayon::prelude::*;
use squid_base::progress::Progress;
use squid_design::error::{Error as DesignError, InputError};
use squid_design::inputs::Inputs;
use squid_design::store::freeze::controller;
use squid_design::synthesise::given::matrices;
use squid_design::verdict::Verdict;
use squid_design::verdict::found::{Effort, Found};
use squid_scheduled::Gamma;

/// First and last step of x.
const STEPS: [f64; 2] = [0.3, 0.05];
/// Largest number of attempts of a descent.
const ATTEMPTS: usize = 80;
/// Smallest relative reduction of the gain in a round that continues the search.
const LOWERED: f64 = 0.01;
/// Numbers of speeds of the frozen loops, and of flights and mu.
const FROZEN: usize = 9;
const FLOWN: usize = 3;
/// Factor on the gains of the second start.
const SLOWER: f64 = 0.5;

/// Searches for sets of gains that meet the requirements of a design file at a few speeds. Returns them with the best
/// first, or the one that misses least; none if the given gains already meet them. `bound` proves a gain for any
/// trajectory of speed.
///
/// # Errors
/// Errors of the verdict on the given gains.
pub(crate) fn meeting(
    inputs: &Inputs,
    text: &str,
    gains: &[TunedGain],
    bound: &(dyn Fn(&Inputs) -> Option<f64> + Sync),
    progress: &Progress,
) -> Result<Vec<Vec<TunedGain>>, Error> {
    let mut search = Search { inputs, text, gains, keys: required(&inputs.design), mu: true };
    let coefficients = search.coefficients();
    let first = search.candidate(&vec![0.0; coefficients.len()])?;
    if first.meets_all() {
        return Ok(vec![]);
    }
    let slower: Vec<f64> = coefficients
        .iter()
        .map(|coefficient| if search.is_factor(*coefficient) { SLOWER.ln() } else { 0.0 })
        .collect();
    let mut tried = vec![first.clone(), search.attempt(&slower).tried];
    search.mu = false;
    let (mut starts, mut best, mut step) = (tried.clone(), first, STEPS[0]);
    while step >= STEPS[1] {
        let before = merit(&best);
        let found: Vec<Vec<Attempt>> =
            starts.par_iter().enumerate().map(|(order, start)| search.round(order, start, step)).collect();
        tried.extend(found.into_iter().flatten().map(|attempt| attempt.tried));
        best = least(&tried, merit).unwrap_or(best);
        progress.done("tune", &format!("{} sets of gains: {}", tried.len(), search.text(&best)));
        if !search.mu && !search.with_mu(&best).meets_all() && best.meets_all() {
            // Mu takes longer than all other figures, so it is evaluated last.
            search.mu = true;
            tried = vec![search.with_mu(&best)];
            best = tried[0].clone();
        } else if best.meets_all() && before - merit(&best) < LOWERED {
            break;
        }
        starts = vec![best.clone(); starts.len()];
        step *= 0.5;
    }
    let best = search.provable(&best, &tried, bound);
    Ok(best.iter().map(|tried| search.moved(&tried.x)).collect())
}

/// Returns the candidate of least value, the first of several.
fn least(all: &[Candidate], value: impl Fn(&Candidate) -> f64) -> Option<Candidate> {
    all.iter().min_by(|a, b| value(a).total_cmp(&value(b))).cloned()
}

/// Largest excess of a candidate's frozen gain over that of the best, as a logarithm, for which it is proved.
const NEAR: f64 = 0.5;
/// Number of candidates that are proved.
const PROVED: usize = 8;

/// Coefficient: the index of its gain, and the power of rho.
type Coefficient = (usize, usize);

struct Search<'a> {
    inputs: &'a Inputs,
    text: &'a str,
    gains: &'a [TunedGain],
    keys: Vec<&'static str>,
    /// `true` if candidates are evaluated with mu.
    mu: bool,
}

impl Search<'_> {
    fn coefficients(&self) -> Vec<Coefficient> {
        let of = |(i, gain): (usize, &TunedGain)| {
            (0..gain.coefficients.len()).map(move |power| (i, power)).collect::<Vec<_>>()
        };
        self.gains.iter().enumerate().flat_map(of).collect()
    }

    /// Returns `true` for a coefficient that is multiplied by a factor.
    fn is_factor(&self, (gain, power): Coefficient) -> bool {
        power == 0 && !self.gains[gain].is_weight()
    }

    /// Returns the gains at a point.
    fn moved(&self, x: &[f64]) -> Vec<TunedGain> {
        let mut all = self.gains.to_vec();
        for ((gain, power), x) in self.coefficients().into_iter().zip(x) {
            let constant = self.gains[gain].coefficients[0];
            let number = &mut all[gain].coefficients[power];
            if self.gains[gain].is_weight() {
                *number = (*number + x).clamp(WEIGHTS[0], WEIGHTS[1]);
            } else if power == 0 {
                *number *= x.exp();
            } else {
                // The slopes keep their ratio to a constant coefficient that is multiplied.
                let factor = all[gain].coefficients[0] / constant;
                all[gain].coefficients[power] =
                    (self.gains[gain].coefficients[power] + x * constant) * factor;
            }
        }
        all
    }

    /// Runs one descent over the coefficients one by one, in reverse order if `order` is above 0.
    fn round(&self, order: usize, start: &Candidate, step: f64) -> Vec<Attempt> {
        let mut directions: Vec<Direction> = (0..start.x.len()).map(|i| Direction(vec![i])).collect();
        if order > 0 {
            directions.reverse();
        }
        let mut found = vec![];
        descend(start, &directions, step, ATTEMPTS, &|x| self.attempt(x), &mut found);
        found
    }

    /// Returns a candidate evaluated with mu.
    fn with_mu(&self, of: &Candidate) -> Candidate {
        let Self { inputs, text, gains, ref keys, .. } = *self;
        Self { inputs, text, gains, keys: keys.clone(), mu: true }.attempt(&of.x).tried
    }

    /// Returns those of the candidates near the best that are proved, sorted by the gain for any trajectory of speed:
    /// candidates with similar gains at frozen speeds may differ there by a factor of two. Returns the best if none is
    /// proved.
    fn provable(
        &self,
        best: &Candidate,
        tried: &[Candidate],
        bound: &(dyn Fn(&Inputs) -> Option<f64> + Sync),
    ) -> Vec<Candidate> {
        let mut near: Vec<&Candidate> =
            tried.iter().filter(|t| merit(t) < merit(best) + NEAR && merit(t) < FAILED_COST).collect();
        near.sort_by(|a, b| merit(a).total_cmp(&merit(b)));
        near.dedup_by(|a, b| a.x == b.x);
        let every = near.len().div_ceil(PROVED).max(1);
        let proved = |tried: &&Candidate| {
            let (_, inputs) = with_gains(self.inputs, self.text, &self.moved(&tried.x)).ok()?;
            Some(((*tried).clone(), bound(&inputs)?))
        };
        let some: Vec<&Candidate> = near.into_iter().step_by(every).collect();
        let mut all: Vec<(Candidate, f64)> = some.par_iter().filter_map(proved).collect();
        all.sort_by(|a, b| a.1.total_cmp(&b.1));
        let with_mu = all.into_par_iter().map(|(tried, _)| self.with_mu(&tried));
        let met: Vec<Candidate> = with_mu.filter(|tried| merit(tried) < FAILED_COST).collect();
        if met.is_empty() { vec![best.clone()] } else { met }
    }

    fn attempt(&self, x: &[f64]) -> Attempt {
        match self.candidate(x) {
            Ok(tried) => Attempt { tried, failed: None },
            Err(why) => {
                let tried = Candidate::failed(x, self.keys.len());
                Attempt { tried, failed: Some(why.to_string()) }
            }
        }
    }

    fn candidate(&self, x: &[f64]) -> Result<Candidate, Error> {
        let (_, inputs) = with_gains(self.inputs, self.text, &self.moved(x))?;
        let verdict = verdict(&inputs, self.mu)?;
        let gamma = largest_gain(&verdict.found);
        let cost = gamma.ln();
        let of = |key: &str| verdict.rows.iter().find(|row| row.key == key).map(|row| row.achieved.value);
        Ok(Candidate {
            x: x.to_vec(),
            cost: if cost.is_finite() { cost.min(FAILED_COST) } else { FAILED_COST },
            gamma,
            margins: margins(&self.keys, &verdict),
            rise: of("pitch_rise").unwrap_or(f64::NAN),
            disk: of("disk_margin").unwrap_or(f64::NAN),
        })
    }

    fn text(&self, best: &Candidate) -> String {
        let worst = self.keys.iter().zip(&best.margins).min_by(|a, b| a.1.total_cmp(b.1));
        let met = match worst {
            Some((key, margin)) if *margin < 0.0 => format!("misses {key} by {:.0} %", -100.0 * margin),
            _ => "all met".into(),
        };
        format!("{met}, gain {:.3} at frozen speeds", best.gamma)
    }
}

/// Returns the verdict at few speeds on the given controller of a design, with its largest gain over frozen speeds as
/// gamma: the gain for any trajectory of speed is no smaller.
fn verdict(inputs: &Inputs, mu: bool) -> Result<Verdict, DesignError> {
    let (actuators, design) = (&inputs.vehicle.actuators, &inputs.design);
    let missing = || InputError::NoController { file: design.file.clone() };
    let lft = matrices(actuators, design)?.ok_or_else(missing)?;
    let not_yet = Gamma { optimum: 1.0, bound: 1.0, back_off: 0.0, certified: false };
    let frozen = controller(&inputs.axis(), design, &inputs.hashes, lft, not_yet)?;
    let sampled = design.require.limit("sampled_gain").is_some();
    let effort = Effort { frozen: FROZEN, sampled, flown: FLOWN, mu: if mu { FLOWN } else { 0 } };
    let found = judged_until_missed(inputs, &frozen, effort)?.found;
    Ok(Verdict::judge(inputs, largest_gain(&found), found))
}

/// Returns the largest gain of the weighted loop over the frozen speeds.
fn largest_gain(found: &Found) -> f64 {
    found.frozen.iter().map(|at| at.gain.value).fold(f64::NAN, f64::max)
}
