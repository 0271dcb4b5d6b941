//! `squid design --robust`: a controller that tolerates more of the declared uncertainty at a slightly larger gain.
//!
//! ```text
//! uncertain model over the range of speed -> channel reduction -> nominal controller's size at the gain
//!     -> alternating synthesis and analysis -> proof in exact arithmetic
//! ```
//!
//! Both controllers are assessed by the same inequality on the same model, in which the uncertain coefficients, like
//! the speed, may vary arbitrarily fast. See `docs/robust.md` for what that means.

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
use crate::uncertain::truncate::{Reduction, Truncated, reduced};
use crate::uncertain::vehicle::{gain, values, vehicle_at};
use crate::uncertain::{Fidelity, over_range};
use squid_base::progress::Progress;
use squid_certificate::Certificate;
use squid_lpv::analysis::GainBound;
use squid_lpv::analysis::bounded_gain::{GAMMA_SHARE, balanced_start};
use squid_lpv::controller::Controller;
use squid_lpv::matrix::Mat;
use squid_lpv::mu::sweep::{CLOSEST, bound_over_frequency};
use squid_lpv::mu::worst_case::{Perturbable, worst_case_gain};
use squid_lpv::plant::GeneralisedPlant;
use squid_lpv::robust::{RobustDesign, RobustOptions, Round, UncertainPlant, more_robust};
use squid_lpv::robust_bound::{RobustBound, RobustLoop};
use squid_lpv::synthesis::Design;
use squid_proof::claim::nominal as certificate_of;

/// The relative back-off from the least gain in each round.
const BACK_OFF: f64 = 0.05;

/// The maximum number of rounds of synthesis and analysis, and the relative increase in size below which they end.
const ROUNDS: usize = 2;
const LEAST_GAIN_IN_SIZE: f64 = 0.02;

/// Sizes relative to the largest found, tried in turn if the proof fails there.
const SMALLER_SIZES: [f64; 4] = [0.99, 0.97, 0.94, 0.9];

/// The fraction of the declared box in which channels are removed, and the relative change of `[A B]` allowed there.
/// The change over the full box is reported.
const REDUCTION: Reduction = Reduction { size: 0.5, tolerance: 0.01 };

/// The fraction of the declared uncertainty for which the worst-case gain with constant coefficients is shown.
const CONSTANT_SIZE: f64 = 0.25;

/// The number of speeds at which mu and worst-case gains are shown.
const SPEEDS: usize = 6;

/// The result of the search.
#[derive(Debug, Clone)]
pub struct Robust {
    /// The robust controller with its bound at Delta = 0, for the plant of the nominal design.
    pub design: Design,
    /// The figures of both controllers.
    pub figures: RobustFigures,
    /// The certificate of the robust controller at the size that it tolerates.
    pub certificate: Certificate,
}

/// The result of the search alone: the model on which both controllers are assessed, and the controller found.
pub struct Searched {
    full: UncertainModel,
    truncated: Truncated,
    uncertain: UncertainPlant,
    /// The nominal plant with reference weights of 1 at all frequencies.
    even: GeneralisedPlant,
    /// The bound of the nominal controller without uncertainty.
    nominal_bound: GainBound,
    /// The gain allowed for the robust controller.
    allowed: f64,
    outcome: RobustDesign,
    /// The controller with its bound at Delta = 0, for the plant of the nominal design.
    pub design: Design,
}

/// Searches for a controller that tolerates more uncertainty than a nominal design.
///
/// # Errors
/// [`Error::Uncertain`] if the design declares no uncertainty; [`Error::Robust`];
/// [`ProofError::Unproved`](squid_proof::error::ProofError::Unproved).
pub fn robust(
    inputs: &Inputs,
    model: &Model,
    plant: &GeneralisedPlant,
    nominal: &Design,
    progress: &Progress,
) -> Result<Robust, Error> {
    let running = progress.begin("robust", "alternating synthesis and analysis, about ten seconds per round");
    let found = search(inputs, model, plant, nominal, progress)?;
    let Searched { truncated, uncertain, nominal_bound, outcome, .. } = &found;
    let robust_bound = bound_in(&found.even, &outcome.controller, outcome.largest.bound.gamma, "robust")?;
    let (size, proved_gamma, certificate) = proved(uncertain, outcome)?;
    let figures = RobustFigures {
        gamma: found.allowed,
        proved: proved_gamma,
        nominal_tolerated_fraction: outcome.given_largest.size,
        robust_tolerated_fraction: size,
        ladder: ladder(
            uncertain,
            &WithoutUncertainty { controller: &nominal.controller, bound: nominal_bound },
            &WithoutUncertainty { controller: &outcome.controller, bound: &robust_bound },
            outcome,
            size,
            proved_gamma,
        ),
        constant_size: CONSTANT_SIZE,
        frozen: frozen(inputs, [&nominal.controller, &outcome.controller])?,
        sizes: (truncated.model.blocks.len(), uncertain.unknown_channels(), uncertain.scheduled_channels()),
        model_error: truncated.error,
        remainder: remainder(inputs, &found.full)?,
        left_out: truncated.removed.clone(),
        stop: outcome.stop.to_string(),
    };
    drop(running);
    Ok(Robust { design: found.design, figures, certificate })
}

/// The search of [`robust`] alone, without figures and proof.
///
/// # Errors
/// As [`robust`], except the errors of the proof.
pub fn search(
    inputs: &Inputs,
    model: &Model,
    plant: &GeneralisedPlant,
    nominal: &Design,
    progress: &Progress,
) -> Result<Searched, Error> {
    let full = over_range(inputs, model, Fidelity::COARSE)?;
    let (truncated, uncertain) = reduced(inputs, &full, model, REDUCTION)?;
    progress.done("uncertain", &model_line(&truncated));
    let even =
        augment(&inputs.vehicle.actuators, &inputs.design.with_unweighted_references(), model.linear())?;
    let nominal_bound = bound_in(&even, &nominal.controller, nominal.certified.gamma, "nominal")?;
    let allowed = gain_allowed(nominal_bound.gamma);
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
    let outcome = more_robust(&uncertain, &nominal.controller, &nominal_bound, options, &mut report_round)
        .map_err(RobustError::from)?;
    let design = at_zero(plant, nominal, &outcome)?;
    Ok(Searched { full, truncated, uncertain, even, nominal_bound, allowed, outcome, design })
}

/// The robust controller with its bound for the plant of the nominal design.
fn at_zero(plant: &GeneralisedPlant, nominal: &Design, found: &RobustDesign) -> Result<Design, Error> {
    if found.rounds.is_empty() {
        return Ok(nominal.clone());
    }
    // The bound is not tight, which leaves a margin for the residual of the fit.
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

/// The bound of a loop without uncertainty, searched from an initial guess.
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

/// A controller with the bound of its loop without uncertainty.
struct WithoutUncertainty<'a> {
    controller: &'a Controller,
    bound: &'a GainBound,
}

/// The bounds of both controllers without uncertainty and at the sizes that each tolerates. At the size of the robust
/// one, `size`, its bound is the proved one.
fn ladder(
    uncertain: &UncertainPlant,
    nominal: &WithoutUncertainty<'_>,
    robust: &WithoutUncertainty<'_>,
    found: &RobustDesign,
    size: f64,
    proved: f64,
) -> Vec<(f64, Option<f64>, Option<f64>)> {
    let (low, high) = (&found.given_largest, &found.largest);
    let at = |k: &Controller, known: &RobustBound, size: f64| {
        RobustLoop::new(uncertain, k).at_size(known, size).map(|bound| bound.bound.gamma)
    };
    let gamma = |bound: &GainBound| Some(bound.gamma);
    vec![
        (0.0, gamma(nominal.bound), gamma(robust.bound)),
        (low.size, gamma(&low.bound), at(robust.controller, high, low.size)),
        (size, at(nominal.controller, low, size), Some(proved)),
    ]
}

/// The tolerated size, the proved gain there and its certificate; at a slightly smaller size if rounding prevents a
/// proof.
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
    let (at_full_size, smaller) = (at(&1.0), SMALLER_SIZES.iter());
    at_full_size.or_else(|failed| smaller.map(at).find_map(Result::ok).ok_or(failed))
}

/// The relative error of the uncertain model against the vehicle trimmed again: the least and the largest over the
/// speeds.
fn remainder(inputs: &Inputs, model: &UncertainModel) -> Result<(f64, f64), Error> {
    let (mut least, mut largest) = (f64::INFINITY, 0.0_f64);
    for speed in inputs.design.spread(SPEEDS) {
        let error = errors(inputs, &at_speed(inputs, speed)?, model)?.remainder;
        (least, largest) = (least.min(error), largest.max(error));
    }
    Ok((least, largest))
}

/// mu for robust stability and the worst-case gain of the loops frozen at several speeds.
fn frozen(inputs: &Inputs, controllers: [&Controller; 2]) -> Result<Vec<Frozen>, Error> {
    let at = |speed: f64| {
        let uncertain = at_speed(inputs, speed)?;
        let mut found = Frozen { speed, mu: [None; 2], worst: [None; 2], vehicle: [None; 2] };
        for (i, k) in controllers.into_iter().enumerate() {
            let uncertain_loop =
                Perturbable { size: CONSTANT_SIZE, ..uncertain_loop(inputs, &uncertain, k)? };
            let mu = bound_over_frequency(&uncertain_loop.stability(), &uncertain_loop.structure, CLOSEST);
            found.mu[i] = mu.ok().map(|bound| bound.upper);
            let worst = worst_case_gain(&uncertain_loop).ok();
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
    let removed = match truncated.removed.as_slice() {
        [] => "all parameters kept".into(),
        names => format!("removed: {}", names.join(", ")),
    };
    format!(
        "{} parameters in {uncertain} channels, {} channels of rho; {removed};\nthe removed channels change [A B] by \
            at most {:.2} % over the whole range",
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
