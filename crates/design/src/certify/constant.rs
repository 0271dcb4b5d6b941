//! `squid design --constant`: the gain for all constant values of the uncertain coefficients, any trajectory of speed.
//!
//! ```text
//! uncertain model over the range of speed -> fewer channels -> balls around it -> multipliers -> proof
//! ```
//!
//! Speed has any trajectory, or one of a bounded rate; what of the trim depends on it has any; coefficients and gains
//! of actuators are constant.
//! See `docs/constant.md` for the claim, and [`lpv::robust::constant`] for the inequality.

pub mod balls;

use crate::certify::constant::balls::around;
use crate::error::{ConstantError, Error};
use crate::fit::Model;
use crate::inputs::Inputs;
use crate::numbers::above;
use crate::uncertain::model::UncertainModel;
use crate::uncertain::truncate::{Truncated, thinned};
use crate::uncertain::{Fidelity, over_range};
use base::files::Files;
use base::progress::Progress;
use certificate::{ConstantCertificate, ConstantTheorem, Filter};
use lpv::controller::Controller;
use lpv::robust::UncertainPlant;
use lpv::robust::constant::{ConstantLoop, Filters};
use proof::constant::{certificate as certificate_of, check_balls};
use proof::error::ProofError;
use proof::same_plant;
use std::path::Path;

/// The file of the certificate.
pub const CERTIFICATE: &str = "constant_certificate.json";

/// The part of the declared box in which channels are removed, all of it, and the relative change of `[A B]` allowed
/// there.
const TRUNCATION: (f64, f64) = (1.0, 0.002);

/// The `a` of the filters `1/(s + a)` of constant parameters, rad/s: on both sides of where the loops of vehicles cross
/// over. One, of 1 rad/s, gave a gain 2.7 % higher for Squid; three, of 0.2, 1 and 5 rad/s, one hardly lower.
const CONSTANT_POLES: [f64; 2] = [0.4, 2.0];

/// That of rho where its rate is bounded: one, because rho has the most channels.
const SLOW_POLE: f64 = 1.0;

/// How close to the least gamma a bound is sought, relatively.
const TOLERANCE: f64 = 0.01;

/// The gain allowed relative to the nominal bound where the whole box is out of reach.
pub const PRICE: f64 = 1.25;

/// How often the share of the box is halved between what holds and what does not.
const DIVISIONS: usize = 4;

/// A gain proved for constant coefficients.
#[derive(Debug, Clone)]
pub struct Constant {
    /// The part of the declared half ranges for which it is proved; 1 is all.
    pub share: f64,
    /// The certificate.
    pub certificate: ConstantCertificate,
    /// What it proves.
    pub theorem: ConstantTheorem,
}

/// Proves a gain for all of the declared box, or else for a part of it at 1.25 times the bound `nominal`: for speeds
/// that change by at most `rate`, m/s^2, or in any way.
///
/// # Errors
/// [`Error::Uncertain`] where the design names nothing uncertain; [`Error::Constant`] when nothing was proved.
pub fn constant(
    inputs: &Inputs,
    model: &Model,
    controller: &Controller,
    nominal: f64,
    rate: Option<f64>,
    progress: &Progress,
) -> Result<Constant, Error> {
    let (fewer, uncertain) = uncertain(inputs, model, rate.is_some())?;
    progress.done("uncertain", &model_line(&fewer));
    let attempt = |share: f64, most: f64| -> Result<Option<Constant>, Error> {
        let percent = 100.0 * share;
        let what = format!("{percent:.0} % of the declared uncertainty, tens of seconds");
        let (found, seconds) = progress.timed("constant", &what, || {
            let plant = uncertain.sized(share);
            let balls = around(inputs, &fewer.model, share, &plant)?;
            let errors = balls.iter().map(|ball| ball.close(&plant, controller)).collect();
            let filters = filters(inputs, &fewer.model, rate);
            let whole = ConstantLoop { closed: plant.close(controller), filters, errors };
            let bound = whole.bound(2.0 * nominal, TOLERANCE, most).map_err(ConstantError::NoBound)?;
            let certificate = certificate_of(&plant, controller, &whole.filters, &bound, &balls);
            let theorem = certificate.prove().map_err(ConstantError::NotProved)?;
            Ok(Constant { share, certificate, theorem })
        });
        let gain = match &found {
            Ok(found) => format!("a gain below {} ({seconds:.1} s)", above(found.theorem.gamma)),
            Err(Error::Constant(reason)) => reason.to_string(),
            Err(_) => String::new(),
        };
        progress.done("constant", &format!("{percent:.0} % of the declared uncertainty: {gain}"));
        match found {
            Ok(found) => Ok(Some(found).filter(|found| found.theorem.gamma <= most)),
            Err(Error::Constant(_)) => Ok(None),
            Err(other) => Err(other),
        }
    };
    if let Some(all) = attempt(1.0, f64::INFINITY)? {
        return Ok(all);
    }
    let (mut best, mut low, mut high) = (None, 0.0, 1.0);
    for _ in 0..DIVISIONS {
        let middle = 0.5 * (low + high);
        match attempt(middle, PRICE * nominal)? {
            Some(found) => (best, low) = (Some(found), middle),
            None => high = middle,
        }
    }
    best.ok_or(ConstantError::NoShare { least: high }.into())
}

/// The uncertain model over the range of speed, and its plant with all of the declared box. Where the rate of rho is
/// bounded, each of its channels counts three times, and the model is the coarse one: with one between them the search
/// took three times as long for Squid at 0.125 m/s^2, and the bound was no lower.
fn uncertain(inputs: &Inputs, model: &Model, is_slow: bool) -> Result<(Truncated, UncertainPlant), Error> {
    let fidelity = if is_slow { Fidelity::COARSE } else { Fidelity::FINE };
    thinned(inputs, &over_range(inputs, model, fidelity)?, model, TRUNCATION)
}

/// The filters of each parameter: those of the trim, and rho without a bound on its rate, have none, because they may
/// take any trajectory.
fn filters(inputs: &Inputs, model: &UncertainModel, rate: Option<f64>) -> Vec<Option<Filters>> {
    let slow = rate.map(|rate| Filters { poles: vec![SLOW_POLE], rate: rate / inputs.design.scheduling().1 });
    let constant = || Filters { poles: CONSTANT_POLES.to_vec(), rate: 0.0 };
    let of_block = model.blocks.iter().map(|b| (!b.uncertain.is_of_trim()).then(constant));
    std::iter::once(slow).chain(of_block).collect()
}

/// The largest rate of the speed that a certificate allows, m/s^2; `None` for any rate.
pub fn rate_of(certificate: &ConstantCertificate, inputs: &Inputs) -> Option<f64> {
    let filter = certificate.filters.iter().find(|f| f.parameter == 0)?;
    Some(filter.rate * inputs.design.scheduling().1)
}

/// Checks that plant and balls of a certificate are those of this vehicle and design file, computed again for a share
/// of the declared box, that it takes for constant only what is, and nothing of the trim for slow; returns that share.
///
/// # Errors
/// [`ProofError::WrongPlant`] with the first part that differs; those of the model.
pub fn of_inputs(certificate: &ConstantCertificate, inputs: &Inputs) -> Result<f64, Error> {
    let is_slow = rate_of(certificate, inputs).is_some();
    let (fewer, uncertain) = uncertain(inputs, &Model::new(&inputs.vehicle, &inputs.design)?, is_slow)?;
    let share = same_plant::part_of(&certificate.plant, &certificate.blocks, &uncertain)?;
    let constant = filters(inputs, &fewer.model, None);
    let is_so = |f: &Filter| match f.parameter {
        0 => f.rate > 0.0,
        other => constant.get(other).is_some_and(Option::is_some),
    };
    if !certificate.filters.iter().all(is_so) {
        return Err(ProofError::WrongPlant { what: "which parameters are constant".to_owned() }.into());
    }
    let balls = around(inputs, &fewer.model, share, &uncertain.sized(share))?;
    check_balls(certificate, &balls)?;
    Ok(share)
}

impl Constant {
    /// Writes the certificate to the directory of its design.
    ///
    /// # Errors
    /// [`ProofError::Certificate`]; those of [`Files::save`].
    pub fn save(&self, directory: &Path) -> Result<(), Error> {
        let path = directory.join(CERTIFICATE);
        let wrong = |reason| ProofError::Certificate { file: path.display().to_string(), reason };
        let text = self.certificate.to_json().map_err(wrong)?;
        let mut files = Files::default();
        files.add(path, text);
        Ok(files.save(directory)?)
    }
}

fn model_line(fewer: &Truncated) -> String {
    let model = &fewer.model;
    let of_trim = model.blocks.iter().filter(|b| b.uncertain.is_of_trim()).count();
    let gone = match fewer.gone.as_slice() {
        [] => String::new(),
        names => format!(";\nwithout channels, and so in the balls alone: {}", names.join(", ")),
    };
    format!(
        "{} constant parameters and {of_trim} of the trim in {} channels, {} channels of rho{gone}",
        model.blocks.len() - of_trim,
        model.channels() - model.scheduled,
        model.scheduled,
    )
}
