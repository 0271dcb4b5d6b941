//! Gain for all constant values of the uncertain coefficients and any trajectory of speed: `squid design --constant`.
//!
//! ```text
//! uncertain model over the range of speed -> channel reduction -> balls around it -> multipliers -> proof
//! ```
//!
//! Speed may vary arbitrarily or at a bounded rate, and the trim parameters arbitrarily; coefficients and actuator
//! gains are constant. See `docs/constant.md` for the claim, and [`squid_lpv::robust::constant`] for the inequality.

pub mod balls;

use crate::certify::constant::balls::around;
use crate::error::{ConstantError, Error};
use crate::fit::Model;
use crate::inputs::Inputs;
use crate::uncertain::model::UncertainModel;
use crate::uncertain::truncate::{Reduction, Truncated, reduced};
use crate::uncertain::{Fidelity, over_range};
use squid_base::files::Files;
use squid_base::numbers::above;
use squid_base::progress::Progress;
use squid_certificate::{Certificate, Filter};
use squid_lpv::controller::Controller;
use squid_lpv::robust::UncertainPlant;
use squid_lpv::robust::constant::{ConstantLoop, Filters};
use squid_proof::claim::text;
use squid_proof::constant::{certificate as certificate_of, check_balls};
use squid_proof::error::ProofError;
use squid_proof::same_plant;
use std::path::Path;

/// File name of the certificate.
pub const CERTIFICATE: &str = "constant_certificate.json";

/// Reduction of the model: channels are removed over the full declared box if `[A B]` changes there by at most this
/// relative tolerance.
const REDUCTION: Reduction = Reduction { size: 1.0, tolerance: 0.002 };

/// Poles `a` of the filters `1/(s + a)` of constant parameters, rad/s: below and above typical crossover frequencies of
/// vehicles. A single pole of 1 rad/s gave a gain 2.7 % higher for Squid; three, of 0.2, 1 and 5 rad/s, hardly lowered
/// it.
const CONSTANT_POLES: [f64; 2] = [0.4, 2.0];

/// Pole `a` of the filter of rho if its rate is bounded: a single one, because rho has the most channels.
const SLOW_POLE: f64 = 1.0;

/// Relative tolerance of the least gamma.
const TOLERANCE: f64 = 0.01;

/// Gain allowed relative to the nominal bound if the full box cannot be proved.
pub const GAIN_FACTOR: f64 = 1.25;

/// Number of bisection steps for the fraction of the box.
const BISECTIONS: usize = 4;

/// Gain proved for constant coefficients.
#[derive(Debug, Clone)]
pub struct Constant {
    /// Fraction of the declared half ranges for which the gain is proved; 1 for all.
    pub share: f64,
    /// Certificate of the gain.
    pub certificate: Certificate,
    /// Proved gain.
    pub gamma: f64,
}

/// Proves a gain for all of the declared box, or else for a fraction of it at 1.25 times the bound `nominal`, for
/// speeds that change by at most `rate`, m/s^2, or arbitrarily if `rate` is `None`.
///
/// # Errors
/// [`Error::Uncertain`] if the design declares no uncertainty; [`Error::Constant`] if nothing was proved.
pub fn constant(
    inputs: &Inputs,
    model: &Model,
    controller: &Controller,
    nominal: f64,
    rate: Option<f64>,
    progress: &Progress,
) -> Result<Constant, Error> {
    let (truncated, uncertain) = uncertain(inputs, model, rate.is_some())?;
    progress.done("uncertain", &model_line(&truncated));
    let attempt = |share: f64, most: f64| -> Result<Option<Constant>, Error> {
        let percent = 100.0 * share;
        let what = format!("{percent:.0} % of the declared uncertainty (tens of seconds)");
        let (found, seconds) = progress.timed("constant", &what, || {
            let plant = uncertain.sized(share);
            let balls = around(inputs, &truncated.model, share, &plant)?;
            let errors = balls.iter().map(|ball| ball.close(&plant, controller)).collect();
            let filters = filters(inputs, &truncated.model, rate);
            let uncertain_loop = ConstantLoop { closed: plant.close(controller), filters, errors };
            let bound =
                uncertain_loop.bound(2.0 * nominal, TOLERANCE, most).map_err(ConstantError::NoBound)?;
            let certificate = certificate_of(&plant, controller, &uncertain_loop.filters, &bound, &balls);
            certificate.prove().map_err(ConstantError::NotProved)?;
            Ok(Constant { share, certificate, gamma: bound.gamma })
        });
        let gain = match &found {
            Ok(found) => format!("gain below {} ({seconds:.1} s)", above(found.gamma)),
            Err(Error::Constant(reason)) => reason.to_string(),
            Err(_) => String::new(),
        };
        progress.done("constant", &format!("{percent:.0} % of the declared uncertainty: {gain}"));
        match found {
            Ok(found) => Ok(Some(found).filter(|found| found.gamma <= most)),
            Err(Error::Constant(_)) => Ok(None),
            Err(other) => Err(other),
        }
    };
    if let Some(all) = attempt(1.0, f64::INFINITY)? {
        return Ok(all);
    }
    let (mut best, mut low, mut high) = (None, 0.0, 1.0);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        match attempt(middle, GAIN_FACTOR * nominal)? {
            Some(found) => (best, low) = (Some(found), middle),
            None => high = middle,
        }
    }
    best.ok_or(ConstantError::NoShare { least: high }.into())
}

/// Builds the uncertain model over the range of speed, and its plant with the full declared box. If the rate of rho is
/// bounded, each channel of rho appears three times in the inequality, and the coarse model is used: with one of
/// intermediate fidelity the search took three times as long for Squid at 0.125 m/s^2, and the bound was no lower.
fn uncertain(inputs: &Inputs, model: &Model, is_slow: bool) -> Result<(Truncated, UncertainPlant), Error> {
    let fidelity = if is_slow { Fidelity::COARSE } else { Fidelity::FINE };
    reduced(inputs, &over_range(inputs, model, fidelity)?, model, REDUCTION)
}

/// Filters of each parameter. Trim parameters, and rho without a bound on its rate, have none, because they may vary
/// arbitrarily.
fn filters(inputs: &Inputs, model: &UncertainModel, rate: Option<f64>) -> Vec<Option<Filters>> {
    let slow = rate.map(|rate| Filters { poles: vec![SLOW_POLE], rate: rate / inputs.design.scheduling().1 });
    let constant = || Filters { poles: CONSTANT_POLES.to_vec(), rate: 0.0 };
    let of_block = model.blocks.iter().map(|b| (!b.uncertain.is_of_trim()).then(constant));
    std::iter::once(slow).chain(of_block).collect()
}

/// Returns the bound on the rate of the speed in a certificate, m/s^2; `None` if the rate is not bounded.
pub fn rate_of(certificate: &Certificate, inputs: &Inputs) -> Option<f64> {
    let filter = certificate.constant()?.filters.iter().find(|f| f.parameter == 0)?;
    Some(filter.rate * inputs.design.scheduling().1)
}

/// Checks that plant and balls of a certificate are those of this vehicle and design file, recomputed for a fraction of
/// the declared box, and that only constant parameters are treated as constant and no trim parameter as slow; returns
/// that fraction.
///
/// # Errors
/// [`ProofError::WrongPlant`] with the first part that differs; the errors of the model.
pub fn check_inputs(certificate: &Certificate, inputs: &Inputs) -> Result<f64, Error> {
    let is_slow = rate_of(certificate, inputs).is_some();
    let (truncated, uncertain) = uncertain(inputs, &Model::new(&inputs.axis(), &inputs.design)?, is_slow)?;
    let share = same_plant::fraction_of(&certificate.plant, &certificate.blocks, &uncertain)?;
    let constant = filters(inputs, &truncated.model, None);
    let is_allowed = |f: &Filter| match f.parameter {
        0 => f.rate > 0.0,
        other => constant.get(other).is_some_and(Option::is_some),
    };
    if !certificate.constant().is_some_and(|claim| claim.filters.iter().all(is_allowed)) {
        return Err(ProofError::WrongPlant { what: "the set of constant parameters".to_owned() }.into());
    }
    let balls = around(inputs, &truncated.model, share, &uncertain.sized(share))?;
    check_balls(certificate, &balls)?;
    Ok(share)
}

impl Constant {
    /// Writes the certificate to the directory of its design.
    ///
    /// # Errors
    /// [`ProofError::Certificate`]; the errors of [`Files::save`].
    pub fn save(&self, directory: &Path) -> Result<(), Error> {
        let path = directory.join(CERTIFICATE);
        let mut files = Files::default();
        files.add(path.clone(), text(&self.certificate, &path)?);
        Ok(files.save(directory)?)
    }
}

fn model_line(reduced: &Truncated) -> String {
    let model = &reduced.model;
    let of_trim = model.blocks.iter().filter(|b| b.uncertain.is_of_trim()).count();
    let removed = match reduced.removed.as_slice() {
        [] => String::new(),
        names => format!(";\nwithout channels, covered by the balls only: {}", names.join(", ")),
    };
    format!(
        "{} constant parameters and {of_trim} of the trim in {} channels; {} channels of rho{removed}",
        model.blocks.len() - of_trim,
        model.channels() - model.scheduled,
        model.scheduled,
    )
}
