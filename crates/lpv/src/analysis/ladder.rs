//! The cost of each assumption about the parameter: a comparison of gains from frozen to arbitrarily fast.
//!
//! The gains of a plant with one parameter are ordered by theory:
//!
//! ```text
//! synthesis   best for each frozen theta  <=  scheduled, S and T  <=  scheduled, S alone
//! analysis    largest frozen gain  <=  |theta'| <= nu, rising with nu  <=  arbitrarily fast  <=  certified
//! ```
//!
//! The first line is the best controller under each assumption, the second the gain of a given closed loop. The gains
//! for a bounded rate and for an arbitrarily fast parameter are those of a grid ([`crate::analysis::rate`]); the
//! certified gain is that of the LFT ([`crate::analysis::bounded_gain()`]), without a grid. [`Ladder::disorders`] lists
//! violations of the order, which are numerical errors.

use crate::analysis::rate::{RateBound, RateError, RateOptions, rate_bounded_gain_from};
use crate::error::{SynthesisError, SystemError};
use crate::matrix::Mat;
use crate::synthesis::least_gamma::least_gamma_at;
use crate::synthesis::{Options, ScalingClass};
use crate::system::{Controller, GeneralisedPlant, StateSpace};
use rayon::prelude::*;

/// The assumptions to be compared.
#[derive(Debug, Clone, PartialEq)]
pub struct LadderOptions {
    /// Parameter values in [-1, 1], for each of which the best controller is computed.
    pub thetas: Vec<f64>,
    /// Bounds on `|theta'|`, for each of which the closed loop is analysed. A parameter V with `theta = (V -
    /// centre)/half_range` and `|V'| <= a` has the bound `a/half_range`.
    pub rates: Vec<f64>,
    /// The number of parameter values, evenly spaced over [-1, 1], at which the closed loop is analysed.
    pub samples: usize,
    /// The Lyapunov functions for a bounded rate.
    pub rate: RateOptions,
    /// The relative accuracy of the gammas of the best controllers.
    pub accuracy: f64,
    /// The Lyapunov matrix that proves the certified gain of the closed loop, if known: a start for the other gains.
    pub lyapunov: Option<Mat>,
}

impl Default for LadderOptions {
    fn default() -> Self {
        let thetas = vec![-1.0, -0.5, 0.0, 0.5, 1.0];
        Self {
            thetas,
            rates: vec![0.01, 0.1, 1.0],
            samples: 33,
            rate: RateOptions::default(),
            accuracy: 1e-5,
            lyapunov: None,
        }
    }
}

/// The gains, each under its assumption. One that could not be computed has an error and leaves the others valid.
#[derive(Debug, Clone, PartialEq)]
pub struct Ladder {
    /// Least gamma, for each theta, of a controller for this frozen parameter only.
    pub frozen_optimum: Vec<(f64, Result<f64, SynthesisError>)>,
    /// The least gamma of a scheduled controller, with symmetric and skew scalings.
    pub scheduled: Result<f64, SynthesisError>,
    /// The least gamma of a scheduled controller with symmetric scalings only.
    pub scheduled_symmetric: Result<f64, SynthesisError>,
    /// The largest gain of the closed loop at a frozen parameter, over all samples.
    pub frozen_gain: FrozenGain,
    /// The gain of the closed loop for each rate, ascending.
    pub bounded_rate: Vec<(f64, Result<RateBound, RateError>)>,
    /// The gain of the closed loop by one constant Lyapunov matrix at all samples.
    pub arbitrarily_fast: Result<RateBound, RateError>,
    /// The gain bound of the closed loop as an LFT, from the design.
    pub certified: f64,
}

/// The largest gain at a frozen parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrozenGain {
    /// The H-infinity norm; infinite if the loop is unstable there.
    pub gamma: f64,
    /// The parameter value of the largest gain.
    pub theta: f64,
    /// The frequency of the peak, rad/s.
    pub frequency: f64,
}

/// One of the gains.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LadderGain {
    /// [`Ladder::frozen_optimum`] at this theta.
    FrozenOptimum(f64),
    /// [`Ladder::scheduled`].
    Scheduled,
    /// [`Ladder::scheduled_symmetric`].
    ScheduledSymmetric,
    /// [`Ladder::frozen_gain`].
    FrozenGain,
    /// [`Ladder::bounded_rate`] at this rate.
    BoundedRate(f64),
    /// [`Ladder::arbitrarily_fast`].
    ArbitrarilyFast,
    /// [`Ladder::certified`].
    Certified,
}

/// Two gains that violate the order of theory: one has a numerical error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Disorder {
    /// The gain that should be lower, and its value.
    pub lower: (LadderGain, f64),
    /// The gain that should be larger, and its value.
    pub upper: (LadderGain, f64),
}

/// The allowed relative violation: gammas are reported up to 0.1 % above the least.
pub const TOLERANCE: f64 = 2e-3;

/// Computes all gains for a plant with one parameter and a controller with a certified gain bound.
///
/// # Errors
/// Returns [`SystemError`] for invalid input; failures of single gains are in the ladder.
pub fn ladder(
    plant: &GeneralisedPlant,
    controller: &Controller,
    certified: f64,
    options: &LadderOptions,
) -> Result<Ladder, SystemError> {
    plant.check()?;
    if plant.blocks.len() != 1 {
        return Err(SystemError::NotOneParameter { found: plant.blocks.len() });
    }
    let gamma = |plant: &GeneralisedPlant, scalings| {
        let options = Options { scalings, accuracy: options.accuracy, ..Options::default() };
        least_gamma_at(plant, options, None).map(|(_, found)| found.gamma)
    };
    let mut frozen_optimum = Vec::with_capacity(options.thetas.len());
    for &theta in &options.thetas {
        if !(-1.0..=1.0).contains(&theta) {
            return Err(SystemError::OutsideTheBox { theta });
        }
        let frozen = plant.frozen(&[theta])?;
        frozen_optimum.push((theta, gamma(&frozen, ScalingClass::SymmetricAndSkew)));
    }
    if options.samples < 2 {
        return Err(SystemError::TooFewPoints { found: options.samples });
    }
    let samples = plant.close(controller).sampled(options.samples)?;
    let mut rates = options.rates.clone();
    rates.sort_by(f64::total_cmp);
    let known = options.lyapunov.as_ref().map(|x| (x, certified));
    let bounded = |rate: f64| rate_bounded_gain_from(&samples, rate, options.rate, known);
    // The gains are independent, so all processors are used.
    let best = || {
        rayon::join(|| gamma(plant, ScalingClass::SymmetricAndSkew), || gamma(plant, ScalingClass::Symmetric))
    };
    let finished = || {
        rayon::join(
            || rates.into_par_iter().map(|rate| (rate, bounded(rate))).collect(),
            || bounded(f64::INFINITY),
        )
    };
    let ((scheduled, scheduled_symmetric), (bounded_rate, arbitrarily_fast)) = rayon::join(best, finished);
    let frozen_gain = largest_frozen_gain(&samples);
    Ok(Ladder {
        frozen_optimum,
        scheduled,
        scheduled_symmetric,
        frozen_gain,
        bounded_rate,
        arbitrarily_fast,
        certified,
    })
}

fn largest_frozen_gain(samples: &[(f64, StateSpace)]) -> FrozenGain {
    let none = FrozenGain { gamma: 0.0, theta: 0.0, frequency: 0.0 };
    samples.iter().fold(none, |largest, (theta, system)| {
        let norm = system.hinf_norm();
        if norm.value > largest.gamma {
            FrozenGain { gamma: norm.value, theta: *theta, frequency: norm.frequency }
        } else {
            largest
        }
    })
}

impl Ladder {
    /// Returns neighbouring gains that violate the order by more than [`TOLERANCE`]; failed ones are skipped.
    pub fn disorders(&self) -> Vec<Disorder> {
        let mut pairs = Vec::new();
        let scheduled = self.scheduled.as_ref().ok().map(|g| (LadderGain::Scheduled, *g));
        let symmetric = self.scheduled_symmetric.as_ref().ok().map(|g| (LadderGain::ScheduledSymmetric, *g));
        let above_frozen = scheduled.or(symmetric);
        for (theta, gamma) in &self.frozen_optimum {
            if let (Ok(gamma), Some(upper)) = (gamma, above_frozen) {
                pairs.push(((LadderGain::FrozenOptimum(*theta), *gamma), upper));
            }
        }
        pairs.extend(scheduled.zip(symmetric));
        let chain = self.analysis();
        pairs.extend(chain.iter().copied().zip(chain.iter().copied().skip(1)));
        pairs
            .into_iter()
            .filter(|(lower, upper)| lower.1 > upper.1 * (1.0 + TOLERANCE))
            .map(|(lower, upper)| Disorder { lower, upper })
            .collect()
    }

    /// Returns the computed gains of the closed loop, in the order of theory.
    fn analysis(&self) -> Vec<(LadderGain, f64)> {
        let mut chain = vec![(LadderGain::FrozenGain, self.frozen_gain.gamma)];
        for (rate, bound) in &self.bounded_rate {
            chain.extend(bound.as_ref().ok().map(|b| (LadderGain::BoundedRate(*rate), b.gamma)));
        }
        chain.extend(self.arbitrarily_fast.as_ref().ok().map(|b| (LadderGain::ArbitrarilyFast, b.gamma)));
        chain.push((LadderGain::Certified, self.certified));
        chain
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn violations_of_the_order_are_listed() {
        let failed = || SynthesisError::Infeasible { stage: "test" };
        let mut ladder = Ladder {
            frozen_optimum: vec![(-1.0, Ok(0.5)), (0.0, Err(failed())), (1.0, Ok(0.8))],
            scheduled: Ok(0.9),
            scheduled_symmetric: Ok(1.0),
            frozen_gain: FrozenGain { gamma: 0.95, theta: 1.0, frequency: 2.0 },
            bounded_rate: vec![(0.1, Err(failed().into()))],
            arbitrarily_fast: Err(failed().into()),
            certified: 1.1,
        };
        assert_eq!(ladder.disorders(), vec![]);
        ladder.certified = 0.94;
        ladder.scheduled = Ok(0.7);
        let expected = [
            Disorder { lower: (LadderGain::FrozenOptimum(1.0), 0.8), upper: (LadderGain::Scheduled, 0.7) },
            Disorder { lower: (LadderGain::FrozenGain, 0.95), upper: (LadderGain::Certified, 0.94) },
        ];
        assert_eq!(ladder.disorders(), expected);
        ladder.scheduled = Err(failed());
        ladder.scheduled_symmetric = Ok(0.6);
        assert_eq!(ladder.disorders()[0].upper, (LadderGain::ScheduledSymmetric, 0.6));
    }
}
