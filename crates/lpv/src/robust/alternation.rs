//! The plant whose parameters are part known, part unknown: a controller is scheduled on Theta and has to tolerate
//! Delta.
//!
//! ```text
//! (wt, wd) = blkdiag(Theta, Delta) (zt, size zd),   |theta_i(t)| <= 1 measured,   |delta_i(t)| <= 1 unknown
//! ```
//!
//! In the analysis of a finished loop Delta is one more parameter: the scaled bounded-real inequality of
//! [`crate::analysis::bounded_gain()`] with S and T for both proves the gain for every trajectory of Theta and Delta.
//! In the synthesis S and T of Delta would enter with their inverses. So they are held, as the analysis left them, and
//! with
//!
//! ```text
//! zd'S zd + 2 wd'T zd - wd'S wd = |S^1/2 zd + S^-1/2 T' wd|^2 - |R^1/2 wd|^2,   R = S + T S^-1 T'
//! ```
//!
//! Delta's channels become performance channels of a plant that is scheduled on Theta alone:
//! [`UncertainPlant::weighed`]. Synthesis and analysis take turns: J. C. Doyle, "Structured uncertainty in control
//! system design", 24th CDC, 1985, for D and K. A plant that depends on measured and on unknown parameters: J.
//! Veenman, C. W. Scherer, "A synthesis framework for robust gain-scheduling controllers", Automatica 50(11), 2014.

use crate::analysis::gain_bound::GainBound;
use crate::error::SynthesisError;
use crate::robust::bound::{RobustBound, RobustLoop, WHOLE};
use crate::robust::uncertain_plant::UncertainPlant;
use crate::synthesis::reduce::without_fast_modes;
use crate::synthesis::{Design, Options, synthesise_once};
use crate::system::controller::Controller;
use crate::system::parameter_grid::parameter_grid;
use crate::system::plant::GeneralisedPlant;
use thiserror::Error;

/// What a robust synthesis is asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RobustOptions {
    /// The gain that must not be exceeded.
    pub gamma: f64,
    /// How far above the least gain each controller is built; see [`Options::back_off`].
    pub back_off: f64,
    /// Rounds of synthesis and analysis, at most.
    pub rounds: usize,
    /// A round that makes the size grow by less than this, relatively, is the last.
    pub pays: f64,
    /// No mode of a frozen controller may be faster than this, rad/s: those that are, are taken out where the gain
    /// allows it; see [`without_fast_modes`].
    pub fastest_mode: Option<f64>,
}

/// How close to the least the gain of a round is sought.
const ACCURACY: f64 = 1e-2;

/// What came of one round.
#[derive(Debug, Clone, PartialEq)]
pub struct Round {
    /// The largest size at which the gain with the controller of the round stays below the one asked for.
    pub size: f64,
    /// The least gain of the weighed plant, 1 being what the controller before had: below 1 there is something to win.
    pub least_gain: f64,
}

/// Why the rounds came to an end.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum StopReason {
    /// The last round won too little.
    #[error("another round no longer pays")]
    NoLongerPays,
    /// There is nothing left to win.
    #[error("all of the declared uncertainty is tolerated")]
    Whole,
    /// As many rounds as allowed.
    #[error("no further round was allowed")]
    Rounds,
    /// No controller was found.
    #[error("no better controller was found: {0}")]
    Synthesis(SynthesisError),
    /// The controller found has no bound at the gain asked for.
    #[error("the last controller has no bound at that gain")]
    NoBound,
}

/// A controller that tolerates more, or the one given where none does.
#[derive(Debug, Clone, PartialEq)]
pub struct RobustDesign {
    /// The controller.
    pub controller: Controller,
    /// The largest size at which its gain stays below the one asked for, and the bound there.
    pub largest: RobustBound,
    /// The same of the controller given.
    pub given_largest: RobustBound,
    /// The rounds that were kept.
    pub rounds: Vec<Round>,
    /// Why there are no more.
    pub stop: StopReason,
}

/// The given controller has no bound at the gain asked for.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error(
    "with the controller given no size of the uncertainty was found at which the gain is sure to stay below {gamma:.4}"
)]
pub struct NoSize {
    /// The gain.
    pub gamma: f64,
}

/// Raises the size of Delta that is tolerated at a gain: synthesis and analysis in turn, beginning with a controller
/// and a bound of its loop at Delta = 0. `on_round` is called after each round.
///
/// # Errors
/// [`NoSize`].
pub fn more_robust(
    uncertain: &UncertainPlant,
    controller: &Controller,
    shown: &GainBound,
    options: RobustOptions,
    on_round: &mut dyn FnMut(&Round),
) -> Result<RobustDesign, NoSize> {
    let given = RobustLoop::new(uncertain, controller);
    let first = given.begun(shown, options.gamma);
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
        if design.largest.size >= WHOLE {
            design.stop = StopReason::Whole;
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
                if won < options.pays {
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
    let weighed = uncertain.weighed(*size, bound.gamma, &s, &t);
    let asked = Options { back_off: options.back_off, accuracy: ACCURACY, ..Options::default() };
    let found = synthesise_once(&weighed, asked);
    let found =
        found.and_then(|found| slow_enough(&weighed, found, options)).map_err(StopReason::Synthesis)?;
    let closed = RobustLoop::new(uncertain, &found.controller);
    let shown = closed.from_weighed(&found.certified, *size, bound.gamma, (&s, &t));
    let largest = closed.largest_size(&shown, options.gamma).ok_or(StopReason::NoBound)?;
    let round = Round { size: largest.size, least_gain: found.gamma_optimum };
    Ok((round, found.controller, largest))
}

/// How far the gain of the weighted plant may rise without the fast modes: the next round begins from it.
const RISE_WITHOUT_FAST_MODES: f64 = 0.2;

/// The design, without the modes of its controller that are too fast.
fn slow_enough(
    weighed: &GeneralisedPlant,
    found: Design,
    options: RobustOptions,
) -> Result<Design, SynthesisError> {
    let Some(limit) = options.fastest_mode else { return Ok(found) };
    let ratio = found.controller.fastest_mode(&parameter_grid(weighed.blocks.len())) / limit;
    if ratio <= 1.0 {
        return Ok(found);
    }
    without_fast_modes(weighed, &found, limit, RISE_WITHOUT_FAST_MODES)
        .ok_or(SynthesisError::TooFast { ratio })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robust::uncertain_plant::tests::plant;
    use crate::synthesis::synthesise;

    /// The robust controller tolerates more at the same gain, and every frozen loop within the size confirms both
    /// bounds.
    #[test]
    fn rounds_raise_what_is_tolerated() {
        let uncertain = plant();
        let nominal = synthesise(&uncertain.nominal(), Options::default()).unwrap();
        let gamma = 1.2 * nominal.certified.gamma;
        let options = RobustOptions { gamma, back_off: 0.02, rounds: 3, pays: 0.01, fastest_mode: None };
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

    /// A bound made clear for a proof holds more clearly, at hardly more gain.
    #[test]
    fn a_bound_is_cleared() {
        let uncertain = plant();
        let nominal = synthesise(&uncertain.nominal(), Options::default()).unwrap();
        let closed = RobustLoop::new(&uncertain, &nominal.controller);
        let bound = closed.begun(&nominal.certified, 1.2 * nominal.certified.gamma).unwrap();
        let clear = closed.with_raised_gamma(&bound).unwrap();
        assert!(clear.bound.gamma <= 1.0101 * bound.bound.gamma);
        assert!(clear.bound.largest_eigenvalue < -1e-6, "{}", clear.bound.largest_eigenvalue);
    }
}
