//! `squid design --robust`: a controller that tolerates more of the declared uncertainty at a slightly larger gain.
//!
//! ```text
//! uncertain model over the range of speed -> fewer channels -> nominal controller's size at the gain
//!     -> synthesis and analysis in turn -> proof in exact arithmetic
//! ```
//!
//! Both controllers are judged by the same inequality on the same model, in which the uncertain coefficients, like
//! the speed, may change arbitrarily fast. See `docs/robust.md` for what that means.

pub mod figures;
pub mod stored;

use crate::augment::augment;
use crate::check::fastest_sampled;
use crate::error::Error;
use crate::error::RobustError;
use crate::fit::Model;
use crate::inputs::Inputs;
use crate::synthesise::robust::figures::{Frozen, RobustFigures, gain_allowed};
use crate::uncertain::closed_loop::uncertain_loop;
use crate::uncertain::errors::errors;
use crate::uncertain::frozen::at_speed;
use crate::uncertain::model::UncertainModel;
use crate::uncertain::truncate::{Truncated, thinned};
use crate::uncertain::vehicle::{gain, values, vehicle_at};
use crate::uncertain::{Fidelity, over_range};
use base::progress::Progress;
use certificate::Certificate;
use lpv::analysis::GainBound;
use lpv::analysis::bounded_gain::{GAMMA_SHARE, balanced_start};
use lpv::controller::Controller;
use lpv::matrix::Mat;
use lpv::mu::sweep::bound_over_frequency;
use lpv::mu::worst_case::{Perturbable, worst_case_gain};
use lpv::plant::GeneralisedPlant;
use lpv::robust::{RobustDesign, RobustOptions, Round, UncertainPlant, more_robust};
use lpv::robust_bound::{RobustBound, RobustLoop};
use lpv::synthesis::Design;
use proof::claim::nominal as certificate_of;

/// How far above the least gain each controller of the rounds is built, relative.
const BACK_OFF: f64 = 0.05;

/// Rounds of synthesis and analysis, at most, and the relative gain in size below which they end.
const ROUNDS: usize = 2;
const LEAST_GAIN_IN_SIZE: f64 = 0.02;

/// The sizes at which a proof is tried that fails at the largest size found, relative to that.
const SMALLER_SIZES: [f64; 4] = [0.99, 0.97, 0.94, 0.9];

/// The part of the declared box in which channels are removed, and the relative change of `[A B]` allowed there. The
/// change over the whole box is reported.
const TRUNCATION: (f64, f64) = (0.5, 0.01);

/// The part of the declared uncertainty, held constant, for which the worst-case gain is shown.
const CONSTANT_SIZE: f64 = 0.25;

/// Speeds at which mu and worst-case gains are shown.
const SPEEDS: usize = 6;

/// The result of the search.
#[derive(Debug, Clone)]
pub struct Robust {
    /// The robust controller with its bound at Delta = 0, for the plant of the nominal design.
    pub design: Design,
    /// The numbers side by side.
    pub figures: RobustFigures,
    /// The certificate of the robust controller at the size that it tolerates.
    pub certificate: Certificate,
}

/// The search alone: the model in which both controllers are judged, and the one that was found.
pub struct Searched {
    whole: UncertainModel,
    truncated: Truncated,
    uncertain: UncertainPlant,
    /// The nominal plant, its references unweighted over frequency.
    even: GeneralisedPlant,
    /// The bound of the nominal controller without uncertainty.
    known: GainBound,
    /// The gain that the robust controller may have.
    allowed: f64,
    outcome: RobustDesign,
    /// The controller with its bound at Delta = 0, for the plant of the nominal design.
    pub design: Design,
}

/// Looks for a controller that tolerates more uncertainty than that of a nominal design.
///
/// # Errors
/// [`Error::Uncertain`] where the design names nothing uncertain; [`Error::Robust`];
/// [`ProofError::Unproved`](proof::error::ProofError::Unproved).
pub fn robust(
    inputs: &Inputs,
    model: &Model,
    plant: &GeneralisedPlant,
    nominal: &Design,
    progress: &Progress,
) -> Result<Robust, Error> {
    let running = progress.begin("robust", "rounds of synthesis and analysis, some ten seconds each");
    let found = search(inputs, model, plant, nominal, progress)?;
    let Searched { truncated, uncertain, known, outcome, .. } = &found;
    let without = bound_in(&found.even, &outcome.controller, outcome.largest.bound.gamma, "robust")?;
    let (size, proved_gamma, certificate) = proved(uncertain, outcome)?;
    let figures = RobustFigures {
        gamma: found.allowed,
        proved: proved_gamma,
        nominal_bears: outcome.given_largest.size,
        robust_bears: size,
        ladder: ladder(
            uncertain,
            [(&nominal.controller, known), (&outcome.controller, &without)],
            outcome,
            (size, proved_gamma),
        ),
        constant_size: CONSTANT_SIZE,
        frozen: frozen(inputs, [&nominal.controller, &outcome.controller])?,
        sizes: (truncated.model.blocks.len(), uncertain.unknown_channels(), uncertain.scheduled_channels()),
        model_error: truncated.error,
        remainder: remainder(inputs, &found.whole)?,
        left_out: truncated.gone.clone(),
        stop: outcome.stop.to_string(),
    };
    drop(running);
    Ok(Robust { design: found.design, figures, certificate })
}

/// The search of [`robust`] alone, without figures and proof.
///
/// # Errors
/// As [`robust`], but for the proof.
pub fn search(
    inputs: &Inputs,
    model: &Model,
    plant: &GeneralisedPlant,
    nominal: &Design,
    progress: &Progress,
) -> Result<Searched, Error> {
    let whole = over_range(inputs, model, Fidelity::COARSE)?;
    let (truncated, uncertain) = thinned(inputs, &whole, model, TRUNCATION)?;
    progress.done("uncertain", &model_line(&truncated));
    let even = augment(&inputs.vehicle.actuators, &inputs.design.with_even_references(), model.linear())?;
    let known = bound_in(&even, &nominal.controller, nominal.certified.gamma, "nominal")?;
    let allowed = gain_allowed(known.gamma);
    let options = RobustOptions {
        // The proof raises gamma by GAMMA_SHARE: the proved gain is then the gain allowed.
        gamma: allowed / (1.0 + GAMMA_SHARE),
        back_off: BACK_OFF,
        rounds: ROUNDS,
        least_growth: LEAST_GAIN_IN_SIZE,
        fastest_mode: Some(fastest_sampled(inputs.design.sample_time)),
    };
    let mut number = 0;
    let mut report_round = |round: &Round| {
        number += 1;
        progress.done("robust", &round_line(number, round));
    };
    let outcome = more_robust(&uncertain, &nominal.controller, &known, options, &mut report_round)
        .map_err(RobustError::from)?;
    let design = at_zero(plant, nominal, &outcome)?;
    Ok(Searched { whole, truncated, uncertain, even, known, allowed, outcome, design })
}

/// The robust controller with its bound for the plant of the nominal design.
fn at_zero(plant: &GeneralisedPlant, nominal: &Design, found: &RobustDesign) -> Result<Design, Error> {
    if found.rounds.is_empty() {
        return Ok(nominal.clone());
    }
    // It leaves room for the residual of the fit.
    let certified = bound_in(plant, &found.controller, found.largest.bound.gamma, "robust")?;
    let gamma_design = certified.gamma;
    Ok(Design {
        controller: found.controller.clone(),
        gamma_design,
        certified,
        regularisation: None,
        slow: None,
        ..nominal.clone()
    })
}

/// The bound of a loop without uncertainty, near a guess.
fn bound_in(
    plant: &GeneralisedPlant,
    controller: &Controller,
    guess: f64,
    which: &'static str,
) -> Result<GainBound, Error> {
    let exact = UncertainPlant { plant: plant.clone(), scheduled: plant.blocks.len() };
    let closed = plant.close(controller);
    let channels = closed.channels.len();
    let unknown = GainBound {
        gamma: guess,
        x: Mat::zeros(0, 0),
        factor: None,
        s: Mat::identity(channels, channels),
        t: Mat::zeros(channels, channels),
        lambda: 0.0,
        largest_eigenvalue: f64::NAN,
    };
    let robust_loop = RobustLoop::new(&exact, controller);
    let bound = balanced_start(&closed, &unknown).and_then(|start| robust_loop.bound(&start));
    let bound = bound.ok_or(RobustError::NotClear { which })?;
    Ok(robust_loop.with_raised_gamma(&bound).unwrap_or(bound).bound)
}

/// Both controllers' bounds without uncertainty and at the sizes that each tolerates; for the robust one there the size
/// and bound that were proved.
fn ladder(
    uncertain: &UncertainPlant,
    [(nominal, alone), (robust, without)]: [(&Controller, &GainBound); 2],
    found: &RobustDesign,
    (size, proved): (f64, f64),
) -> Vec<(f64, Option<f64>, Option<f64>)> {
    let (low, high) = (&found.given_largest, &found.largest);
    let at = |k: &Controller, known: &RobustBound, size: f64| {
        RobustLoop::new(uncertain, k).at_size(known, size).map(|bound| bound.bound.gamma)
    };
    let gamma = |bound: &GainBound| Some(bound.gamma);
    vec![
        (0.0, gamma(alone), gamma(without)),
        (low.size, gamma(&low.bound), at(robust, high, low.size)),
        (size, at(nominal, low, size), Some(proved)),
    ]
}

/// The tolerated size, the gain there and its certificate, proved, or at a size a little smaller where rounding hides
/// that it holds.
fn proved(uncertain: &UncertainPlant, found: &RobustDesign) -> Result<(f64, f64, Certificate), Error> {
    let closed = RobustLoop::new(uncertain, &found.controller);
    let at = |part: &f64| -> Result<(f64, f64, Certificate), Error> {
        let size = part * found.largest.size;
        let clear = closed.with_raised_gamma(&closed.resized(&found.largest, size));
        let clear = clear.ok_or(RobustError::NotClear { which: "robust" })?;
        let certificate = certificate_of(&uncertain.sized(size), &found.controller, &clear.bound);
        certificate.prove()?;
        Ok((size, clear.bound.gamma, certificate))
    };
    let (whole, smaller) = (at(&1.0), SMALLER_SIZES.iter());
    whole.or_else(|failed| smaller.map(at).find_map(Result::ok).ok_or(failed))
}

/// The relative error of the uncertain model against the vehicle trimmed again: least and largest over the speeds.
fn remainder(inputs: &Inputs, model: &UncertainModel) -> Result<(f64, f64), Error> {
    let (mut least, mut largest) = (f64::INFINITY, 0.0_f64);
    for speed in inputs.design.spread(SPEEDS) {
        let off = errors(inputs, &at_speed(inputs, speed)?, model)?.remainder;
        (least, largest) = (least.min(off), largest.max(off));
    }
    Ok((least, largest))
}

/// mu for robust stability and the worst-case gain of the loops frozen at several speeds.
fn frozen(inputs: &Inputs, controllers: [&Controller; 2]) -> Result<Vec<Frozen>, Error> {
    let at = |speed: f64| {
        let uncertain = at_speed(inputs, speed)?;
        let mut found = Frozen { speed, mu: [None; 2], worst: [None; 2], vehicle: [None; 2] };
        for (i, k) in controllers.into_iter().enumerate() {
            let whole = Perturbable { size: CONSTANT_SIZE, ..uncertain_loop(inputs, &uncertain, k)? };
            let mu = bound_over_frequency(&whole.stability(), &whole.structure, None);
            found.mu[i] = mu.ok().map(|bound| bound.upper);
            let worst = worst_case_gain(&whole).ok();
            found.worst[i] = worst.as_ref().map(|worst| (worst.upper, worst.worst.gain));
            let delta = worst.map(|worst| values(&uncertain, &worst.worst.delta));
            let vehicle = delta.and_then(|delta| vehicle_at(&inputs.vehicle, &uncertain, &delta));
            found.vehicle[i] = vehicle.map(|l| gain(inputs, &l, k)).transpose()?;
        }
        Ok(found)
    };
    inputs.design.spread(SPEEDS).into_iter().map(at).collect()
}

fn model_line(truncated: &Truncated) -> String {
    let model = &truncated.model;
    let uncertain = model.channels() - model.scheduled;
    let gone = match truncated.gone.as_slice() {
        [] => "all parameters kept".into(),
        names => format!("left out: {}", names.join(", ")),
    };
    format!(
        "{} parameters in {uncertain} channels, {} channels of rho; {gone};\nthe removed channels change [A B] by \
            {:.2} % at most over all of the box",
        model.blocks.len(),
        model.scheduled,
        100.0 * truncated.error
    )
}

fn round_line(number: usize, round: &Round) -> String {
    format!(
        "round {number}: tolerates {:.1} % of the declared uncertainty (least gain of the weighted plant {:.3})",
        100.0 * round.size,
        round.least_gain
    )
}
