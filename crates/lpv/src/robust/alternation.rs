//! A plant with measured and unknown parameters: the controller is scheduled on Theta and must tolerate Delta.
//!
//! ```text
//! (wt, wd) = blkdiag(Theta, Delta) (zt, size zd),   |theta_i(t)| <= 1 measured,   |delta_i(t)| <= 1 unknown
//! ```
//!
//! Delta is an additional parameter in the analysis of a closed loop: the scaled bounded-real inequality of
//! [`crate::analysis::bounded_gain()`] with S and T for both proves the gain for every trajectory of Theta and Delta.
//! In the synthesis S and T of Delta would enter with their inverses. They are therefore fixed to the values of the
//! analysis, and with
//!
//! ```text
//! zd'S zd + 2 wd'T zd - wd'S wd = |S^1/2 zd + S^-1/2 T' wd|^2 - |R^1/2 wd|^2,   R = S + T S^-1 T'
//! ```
//!
//! Delta's channels become performance channels of a plant scheduled on Theta only: [`UncertainPlant::weighted`].
//! Synthesis and analysis alternate: J. C. Doyle, "Structured uncertainty in control system design", 24th CDC, 1985,
//! for D and K. For measured and unknown parameters: J. Veenman, C. W. Scherer, "A synthesis framework for robust
//! gain-scheduling controllers", Automatica 50(11), 2014.

use crate::analysis::gain_bound::GainBound;
use crate::error::SynthesisError;
use crate::robust::bound::{FULL_SIZE, RobustBound, RobustLoop};
use crate::robust::uncertain_plant::UncertainPlant;
use crate::synthesis::reduce::without_fast_modes;
use crate::synthesis::{Design, Options, synthesise_once};
use crate::system::{Controller, GeneralisedPlant, parameter_grid};
use thiserror::Error;

/// Options of a robust synthesis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RobustOptions {
    /// The allowed gain.
    pub gamma: f64,
    /// The back-off of each controller; see [`Options::back_off`].
    pub back_off: f64,
    /// The largest number of rounds of synthesis and analysis.
    pub rounds: usize,
    /// The relative growth of the size below which a round is the last.
    pub least_growth: f64,
    /// The limit on the modes of a frozen controller, rad/s; faster ones are removed if the gain allows it; see
    /// [`without_fast_modes`].
    pub fastest_mode: Option<f64>,
}

/// The relative accuracy of the gain in a round.
const ACCURACY: f64 = 1e-2;

/// The result of one round.
#[derive(Debug, Clone, PartialEq)]
pub struct Round {
    /// The largest size at which the gain with the controller of the round stays below the allowed one.
    pub size: f64,
    /// The least gain of the weighted plant, relative to that of the previous controller: the size can grow if it is
    /// below 1.
    pub least_gain: f64,
}

/// Reason for the end of the rounds.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum StopReason {
    /// Insufficient growth of the size in the last round.
    #[error("the last round gave too little improvement")]
    NoLongerPays,
    /// Tolerance of all of the uncertainty.
    #[error("all of the declared uncertainty is tolerated")]
    FullSize,
    /// The largest number of rounds.
    #[error("the largest number of rounds was reached")]
    Rounds,
    /// Failure to find a controller.
    #[error("no better controller was found: {0}")]
    Synthesis(SynthesisError),
    /// No bound of the new controller at the allowed gain.
    #[error("no bound was found for the last controller at this gain")]
    NoBound,
}

/// A controller that tolerates a larger Delta, or the given one if none does.
#[derive(Debug, Clone, PartialEq)]
pub struct RobustDesign {
    /// The robust controller.
    pub controller: Controller,
    /// The largest size at which its gain stays below the allowed one, and the bound there.
    pub largest: RobustBound,
    /// The largest size with the given controller, and the bound there.
    pub given_largest: RobustBound,
    /// The successful rounds.
    pub rounds: Vec<Round>,
    /// Reason for the end of the rounds.
    pub stop: StopReason,
}

/// Error of a given controller without a bound at the allowed gain.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error(
    "no size of the uncertainty was found for which the gain with the given controller is proved to be below \
     {gamma:.4}"
)]
pub struct NoSize {
    /// The allowed gain.
    pub gamma: f64,
}

/// Raises the size of Delta tolerated at a gain by alternating synthesis and analysis, starting from a controller and a
/// bound of its loop at Delta = 0. `on_round` is called after each round.
///
/// Returns [`NoSize`] if the given controller has no bound at the allowed gain.
/// [`NoSize`].
pub fn more_robust(
    uncertain: &UncertainPlant,
    controller: &Controller,
    shown: &GainBound,
    options: RobustOptions,
    on_round: &mut dyn FnMut(&Round),
) -> Result<RobustDesign, NoSize> {
    let given = RobustLoop::new(uncertain, controller);
    let first = given.at_small_size(shown, options.gamma);
    let largest = first.and_then(|first| given.largest_size(&first, options.gamma));
    let largest = largest.ok_or(NoSize { gamma: options.gamma })?;
    let mut design = RobustDesign {
        controller: controller.clone(),
        given_largest: largest.clone(),
        largest,
        rounds: vec![],
        stop: StopReason::Rounds,
    };
    for _ in 0..options.rounds {
        if design.largest.size >= FULL_SIZE {
            design.stop = StopReason::FullSize;
            break;
        }
        match round(uncertain, &design, options) {
            Ok((round, controller, largest)) => {
                let won = largest.size / design.largest.size - 1.0;
                if won > 0.0 {
                    on_round(&round);
                    design.rounds.push(round);
                    (design.controller, design.largest) = (controller, largest);
                }
                if won < options.least_growth {
                    design.stop = StopReason::NoLongerPays;
                    break;
                }
            }
            Err(stop) => {
                design.stop = stop;
                break;
            }
        }
    }
    Ok(design)
}

fn round(
    uncertain: &UncertainPlant,
    before: &RobustDesign,
    options: RobustOptions,
) -> Result<(Round, Controller, RobustBound), StopReason> {
    let RobustBound { size, bound } = &before.largest;
    let (s, t) = RobustLoop::new(uncertain, &before.controller).multipliers_of_delta(bound);
    let weighted = uncertain.weighted(*size, bound.gamma, &s, &t);
    let synthesis = Options { back_off: options.back_off, accuracy: ACCURACY, ..Options::default() };
    let found = synthesise_once(&weighted, synthesis);
    let found =
        found.and_then(|found| slow_enough(&weighted, found, options)).map_err(StopReason::Synthesis)?;
    let closed = RobustLoop::new(uncertain, &found.controller);
    let shown = closed.from_weighted(&found.certified, *size, bound.gamma, &s, &t);
    let largest = closed.largest_size(&shown, options.gamma).ok_or(StopReason::NoBound)?;
    let round = Round { size: largest.size, least_gain: found.gamma_optimum };
    Ok((round, found.controller, largest))
}

/// The allowed relative increase of the gain of the weighted plant without the fast modes, from which the next round
/// starts.
const RISE_WITHOUT_FAST_MODES: f64 = 0.2;

/// Returns the design without the modes of its controller that are too fast.
fn slow_enough(
    weighted: &GeneralisedPlant,
    found: Design,
    options: RobustOptions,
) -> Result<Design, SynthesisError> {
    let Some(limit) = options.fastest_mode else { return Ok(found) };
    let ratio = found.controller.fastest_mode(&parameter_grid(weighted.blocks.len())) / limit;
    if ratio <= 1.0 {
        return Ok(found);
    }
    without_fast_modes(weighted, &found, limit, RISE_WITHOUT_FAST_MODES)
        .ok_or(SynthesisError::TooFast { ratio })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robust::uncertain_plant::tests::plant;
    use crate::synthesis::synthesise;

    /// The robust controller tolerates a larger size at the same gain, and frozen loops within it confirm both bounds.
    #[test]
    fn rounds_increase_the_tolerated_size() {
        let uncertain = plant();
        let nominal = synthesise(&uncertain.nominal(), Options::default()).unwrap();
        let gamma = 1.2 * nominal.certified.gamma;
        let options =
            RobustOptions { gamma, back_off: 0.02, rounds: 3, least_growth: 0.01, fastest_mode: None };
        let mut reported = 0;
        let found =
            more_robust(&uncertain, &nominal.controller, &nominal.certified, options, &mut |_| reported += 1)
                .unwrap();
        assert_eq!(reported, found.rounds.len());
        assert!(found.largest.size >= found.given_largest.size && found.largest.bound.gamma <= gamma);
        assert!(found.largest.size > 1.02 * found.given_largest.size, "{:?}", found.rounds);
        for (controller, largest) in
            [(&nominal.controller, &found.given_largest), (&found.controller, &found.largest)]
        {
            let closed = uncertain.sized(largest.size).close(controller);
            for theta in [-1.0, 0.0, 1.0] {
                for delta in [-1.0, -0.4, 1.0] {
                    let gain = closed.frozen(&[theta, delta]).unwrap().hinf_norm().value;
                    assert!(gain < largest.bound.gamma, "{gain} {}", largest.bound.gamma);
                }
            }
        }
    }

    /// A bound raised for a proof holds with a larger margin, at little more gain.
    #[test]
    fn a_raised_bound_has_a_larger_margin() {
        let uncertain = plant();
        let nominal = synthesise(&uncertain.nominal(), Options::default()).unwrap();
        let closed = RobustLoop::new(&uncertain, &nominal.controller);
        let bound = closed.at_small_size(&nominal.certified, 1.2 * nominal.certified.gamma).unwrap();
        let clear = closed.with_raised_gamma(&bound).unwrap();
        assert!(clear.bound.gamma <= 1.0101 * bound.bound.gamma);
        assert!(clear.bound.largest_eigenvalue < -1e-6, "{}", clear.bound.largest_eigenvalue);
    }
}
