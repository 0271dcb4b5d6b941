//! What each assumption about the parameter costs: gains from frozen to arbitrarily fast, side by side.
//!
//! Theory orders the gains of one plant with one parameter, whatever the numbers:
//!
//! ```text
//! synthesis   best for each frozen theta  <=  scheduled, S and T  <=  scheduled, S alone
//! analysis    largest frozen gain  <=  |theta'| <= nu, rising with nu  <=  arbitrarily fast  <=  certified
//! ```
//!
//! The first line asks for the best controller under each assumption; the second takes the finished controller. All
//! gains of bounded rate and the one called arbitrarily fast are of a grid ([`crate::analysis::rate`]); the certified
//! one is of the LFT ([`crate::analysis::bounded_gain()`]) and needs no grid. [`Ladder::disorders`] says where numbers
//! contradict theory.

use crate::analysis::rate::{RateBound, RateError, RateOptions, rate_bounded_gain_from};
use crate::error::{LftError, ShapeError, SynthesisError};
use crate::matrix::Mat;
use crate::synthesis::least_gamma::least_gamma_within;
use crate::synthesis::{Options, ScalingClass};
use crate::system::controller::Controller;
use crate::system::plant::GeneralisedPlant;
use crate::system::state_space::StateSpace;
use rayon::prelude::*;
use thiserror::Error;

/// Which rungs the ladder has.
#[derive(Debug, Clone, PartialEq)]
pub struct LadderOptions {
    /// Parameter values, in [-1, 1], for each of which the best controller is sought.
    pub thetas: Vec<f64>,
    /// Bounds on `|theta'|`, for each of which the finished loop is analysed. A parameter V with `theta = (V -
    /// centre)/half_range` and `|V'| <= a` has `a/half_range`.
    pub rates: Vec<f64>,
    /// The number of parameter values, evenly spread over [-1, 1], at which the finished loop is analysed.
    pub samples: usize,
    /// The Lyapunov functions of bounded rate.
    pub rate: RateOptions,
    /// How close to the least the gammas of the best controllers are, relative to themselves.
    pub accuracy: f64,
    /// The Lyapunov matrix that shows the certified gain of the finished loop, if it is known: its gains are then
    /// sought from there.
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

/// The gains, each under its assumption. A rung that could not be reached says why and leaves the others standing.
#[derive(Debug, Clone, PartialEq)]
pub struct Ladder {
    /// For each theta the least gamma of a controller that is made for this frozen parameter alone.
    pub frozen_optimum: Vec<(f64, Result<f64, SynthesisError>)>,
    /// The least gamma of a scheduled controller, with symmetric and skew scalings.
    pub scheduled: Result<f64, SynthesisError>,
    /// The same with symmetric scalings alone.
    pub scheduled_symmetric: Result<f64, SynthesisError>,
    /// The largest gain of the finished loop at a frozen parameter, over all samples.
    pub frozen_gain: FrozenGain,
    /// For each rate, ascending, the gain of the finished loop.
    pub bounded_rate: Vec<(f64, Result<RateBound, RateError>)>,
    /// The gain of the finished loop by one constant Lyapunov matrix at all samples.
    pub arbitrarily_fast: Result<RateBound, RateError>,
    /// The gain bound of the finished loop as an LFT, which comes with the design.
    pub certified: f64,
}

/// The largest gain at a frozen parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrozenGain {
    /// The H-infinity norm; infinite when the loop is unstable there.
    pub gamma: f64,
    /// The parameter value that has it.
    pub theta: f64,
    /// The frequency of the peak, rad/s.
    pub frequency: f64,
}

/// The name of a rung.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Rung {
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

/// Two rungs that theory orders the other way round: a numerical error of one of them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Disorder {
    /// The rung that should be the lower one, and its gain.
    pub lower: (Rung, f64),
    /// The rung that should be the upper one, and its gain.
    pub upper: (Rung, f64),
}

/// By how much, relatively, a lower rung may lie above an upper one: gammas are reported up to 0.1 % above the least.
pub const TOLERANCE: f64 = 2e-3;

/// What a ladder cannot be set up on.
#[derive(Debug, Clone, PartialEq, Error)]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum LadderError {
    /// Rates are those of one parameter.
    #[error("the plant depends on {found} parameters, the ladder of gammas is for one")]
    NotOneParameter { found: usize },
    /// The grid of the analysis has both ends.
    #[error("{found} samples of the closed loop are too few, at least 2 are needed")]
    TooFewSamples { found: usize },
    /// Parameters are normalised.
    #[error("theta = {theta} lies outside [-1, 1]")]
    OutsideTheBox { theta: f64 },
    /// The plant's matrices do not fit together.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// Plant or loop has no value at a parameter in the box.
    #[error(transparent)]
    NotWellPosed(#[from] LftError),
}

/// Climbs all rungs for a plant with one parameter and a controller for it, with its certified gain bound.
///
/// # Errors
/// [`LadderError`] when plant or options do not allow a ladder; failures of single rungs are in the ladder.
pub fn ladder(
    plant: &GeneralisedPlant,
    controller: &Controller,
    certified: f64,
    options: &LadderOptions,
) -> Result<Ladder, LadderError> {
    plant.check()?;
    if plant.blocks.len() != 1 {
        return Err(LadderError::NotOneParameter { found: plant.blocks.len() });
    }
    let gamma = |plant: &GeneralisedPlant, scalings| {
        let options = Options { scalings, accuracy: options.accuracy, ..Options::default() };
        least_gamma_within(plant, options).map(|(_, found)| found.gamma)
    };
    let mut frozen_optimum = Vec::with_capacity(options.thetas.len());
    for &theta in &options.thetas {
        if !(-1.0..=1.0).contains(&theta) {
            return Err(LadderError::OutsideTheBox { theta });
        }
        let frozen = plant.frozen(&[theta])?;
        frozen_optimum.push((theta, gamma(&frozen, ScalingClass::SymmetricAndSkew)));
    }
    if options.samples < 2 {
        return Err(LadderError::TooFewSamples { found: options.samples });
    }
    let samples = plant.close(controller).sampled(options.samples)?;
    let mut rates = options.rates.clone();
    rates.sort_by(f64::total_cmp);
    let known = options.lyapunov.as_ref().map(|x| (x, certified));
    let bounded = |rate: f64| rate_bounded_gain_from(&samples, rate, options.rate, known);
    // None needs another, so that each takes the time that the others leave a processor.
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
    /// The neighbouring rungs that lie against theory by more than [`TOLERANCE`]; rungs not reached are skipped.
    pub fn disorders(&self) -> Vec<Disorder> {
        let mut pairs = Vec::new();
        let scheduled = self.scheduled.as_ref().ok().map(|g| (Rung::Scheduled, *g));
        let symmetric = self.scheduled_symmetric.as_ref().ok().map(|g| (Rung::ScheduledSymmetric, *g));
        let above_frozen = scheduled.or(symmetric);
        for (theta, gamma) in &self.frozen_optimum {
            if let (Ok(gamma), Some(upper)) = (gamma, above_frozen) {
                pairs.push(((Rung::FrozenOptimum(*theta), *gamma), upper));
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

    /// The rungs of the finished loop that were reached, in the order that theory demands.
    fn analysis(&self) -> Vec<(Rung, f64)> {
        let mut chain = vec![(Rung::FrozenGain, self.frozen_gain.gamma)];
        for (rate, bound) in &self.bounded_rate {
            chain.extend(bound.as_ref().ok().map(|b| (Rung::BoundedRate(*rate), b.gamma)));
        }
        chain.extend(self.arbitrarily_fast.as_ref().ok().map(|b| (Rung::ArbitrarilyFast, b.gamma)));
        chain.push((Rung::Certified, self.certified));
        chain
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn disorders_are_listed() {
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
            Disorder { lower: (Rung::FrozenOptimum(1.0), 0.8), upper: (Rung::Scheduled, 0.7) },
            Disorder { lower: (Rung::FrozenGain, 0.95), upper: (Rung::Certified, 0.94) },
        ];
        assert_eq!(ladder.disorders(), expected);
        ladder.scheduled = Err(failed());
        ladder.scheduled_symmetric = Ok(0.6);
        assert_eq!(ladder.disorders()[0].upper, (Rung::ScheduledSymmetric, 0.6));
    }
}
