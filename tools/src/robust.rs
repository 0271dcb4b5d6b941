//! `squid design --robust`: a controller that bears more of the declared uncertainty at a gain that is a little larger.
//!
//! ```text
//! uncertain model over the range of speed -> fewer channels -> nominal controller's size at the gain -> synthesis and analysis in turn
//!                                                                                        -> proof in exact arithmetic
//! ```
//!
//! Both controllers are judged by the same inequality on the same model, in which the uncertain coefficients, like the speed, may change arbitrarily fast. See
//! `docs/robust.md` for what that means.

use crate::certify::nominal as certificate_of;
use crate::error::Error;
use crate::inputs::Inputs;
use crate::model::{Model, speeds};
use crate::output::write;
use crate::stages::Stages;
use crate::uncertain::{at_speed, over_range};
use crate::uncertain_loop::{uncertain_loop, uncertain_plant};
use crate::uncertain_truncate::{Truncated, truncated};
use certificate::Certificate;
use lpv::analysis::{GainBound, bounded_gain};
use lpv::controller::Controller;
use lpv::model_error::LoopError;
use lpv::mu::sweep::bound_over_frequency;
use lpv::mu::{Block, Structure};
use lpv::plant::GeneralisedPlant;
use lpv::robust::{RobustDesign, RobustOptions, Round, UncertainPlant, more_robust};
use lpv::robust_bound::{RobustBound, RobustLoop};
use lpv::synthesis::Design;
use std::path::Path;
use thiserror::Error as ThisError;

/// The gain that the robust controller may have, relative to the bound of the nominal one.
pub const PRICE: f64 = 1.25;

/// How far above the least gain each controller of the rounds is built. What is lost here is lost in every round.
const BACK_OFF: f64 = 0.05;

/// Rounds of synthesis and analysis, at most, and what the last of them must win.
const ROUNDS: usize = 4;
const PAYS: f64 = 0.02;

/// The box in which channels may be taken off the model, and by how much `[A B]` may move there, relative.
const BOX: f64 = 0.5;
const TOLERANCE: f64 = 0.01;

/// Speeds at which mu is shown.
const SPEEDS: usize = 6;

/// Why there is no robust controller.
#[derive(Debug, Clone, PartialEq, ThisError)]
pub enum RobustError {
    /// The nominal controller has a bound at some size.
    #[error("--robust: {0}")]
    NoSize(#[from] lpv::robust::NoSize),
    /// The bounds found hold clearly enough to be proved.
    #[error("--robust: the bound of the {which} controller does not hold clearly enough to be proved")]
    NotClear {
        /// Which controller.
        which: &'static str,
    },
}

/// The two controllers side by side.
#[derive(Debug, Clone)]
pub struct Robust {
    /// The robust controller with its bound at Delta = 0, for the plant of the nominal design.
    pub design: Design,
    /// What the rounds came to.
    pub found: RobustDesign,
    /// The model that they worked on.
    pub truncated: Truncated,
    /// Sizes of the uncertainty, as fractions of what is declared, and at each the bound of the nominal and of the robust controller where there is one.
    pub ladder: Vec<(f64, Option<f64>, Option<f64>)>,
    /// Speed (m/s) and the upper bound on mu, over all frequencies, of the nominal and of the robust controller.
    pub mu: Vec<(f64, f64, f64)>,
    /// The certificate of the robust controller at the size that it bears.
    pub certificate: Certificate,
}

/// Looks for a controller that bears more than that of a nominal design.
///
/// # Errors
/// [`Error::Uncertain`] where the design names nothing uncertain; [`Error::Robust`]; [`Error::Unproved`].
pub fn robust(
    inputs: &Inputs,
    model: &Model,
    plant: &GeneralisedPlant,
    nominal: &Design,
    stages: &Stages,
) -> Result<Robust, Error> {
    let truncated = truncated(inputs, &over_range(inputs, model)?, BOX, TOLERANCE)?;
    let uncertain = UncertainPlant { plant: uncertain_plant(inputs, &truncated.model)?, scheduled: 1 };
    stages.done("uncertain", &model_line(&truncated));
    let options = RobustOptions {
        gamma: PRICE * nominal.certified.gamma,
        back_off: BACK_OFF,
        rounds: ROUNDS,
        pays: PAYS,
    };
    let running = stages.begin("robust", "rounds of synthesis and analysis, up to half a minute each");
    let mut number = 0;
    let mut told = |round: &Round| {
        number += 1;
        stages.done("robust", &round_line(number, round));
    };
    let found = more_robust(&uncertain, &nominal.controller, &nominal.certified, options, &mut told)
        .map_err(RobustError::from)?;
    let design = at_zero(plant, nominal, &found)?;
    let ladder = ladder(&uncertain, nominal, &design, &found);
    let certificate = proved(&uncertain, &found)?;
    let mu = mu(inputs, [&nominal.controller, &found.controller])?;
    drop(running);
    Ok(Robust { design, found, truncated, ladder, mu, certificate })
}

/// The robust controller with its bound for the plant without uncertainty.
fn at_zero(plant: &GeneralisedPlant, nominal: &Design, found: &RobustDesign) -> Result<Design, Error> {
    if found.rounds.is_empty() {
        return Ok(nominal.clone());
    }
    let exact = UncertainPlant { plant: plant.clone(), scheduled: plant.blocks.len() };
    let closed = RobustLoop::new(&exact, &found.controller);
    let clear = closed.bound(1.0, &found.bears.bound).and_then(|bound| closed.cleared(&bound));
    let clear = clear.ok_or(RobustError::NotClear { which: "robust" })?.bound;
    let whole = plant.close(&found.controller);
    let certified = bounded_gain(&whole, &LoopError::none(&whole), &clear)?;
    let gamma_design = certified.gamma;
    Ok(Design { controller: found.controller.clone(), gamma_design, certified, ..nominal.clone() })
}

/// Both controllers' bounds at no uncertainty and at what either bears.
fn ladder(
    uncertain: &UncertainPlant,
    nominal: &Design,
    robust: &Design,
    found: &RobustDesign,
) -> Vec<(f64, Option<f64>, Option<f64>)> {
    let (low, high) = (&found.given_bears, &found.bears);
    let at = |k: &Controller, known: &RobustBound, size: f64| {
        RobustLoop::new(uncertain, k).at_size(known, size).map(|bound| bound.bound.gamma)
    };
    let gamma = |bound: &GainBound| Some(bound.gamma);
    vec![
        (0.0, gamma(&nominal.certified), gamma(&robust.certified)),
        (low.size, gamma(&low.bound), at(&found.controller, high, low.size)),
        (high.size, at(&nominal.controller, low, high.size), gamma(&high.bound)),
    ]
}

/// The certificate at the size borne, proved.
fn proved(uncertain: &UncertainPlant, found: &RobustDesign) -> Result<Certificate, Error> {
    let closed = RobustLoop::new(uncertain, &found.controller);
    let clear = closed.cleared(&found.bears).ok_or(RobustError::NotClear { which: "robust" })?;
    let certificate = certificate_of(&uncertain.sized(clear.size), &found.controller, &clear.bound);
    certificate.prove()?;
    Ok(certificate)
}

/// mu for robust stability of the loops frozen at several speeds; infinite where a loop is unstable or no bound closes.
fn mu(inputs: &Inputs, controllers: [&Controller; 2]) -> Result<Vec<(f64, f64, f64)>, Error> {
    let (centre, half_range) = inputs.design.scheduling();
    let at = |speed: f64| {
        let model = at_speed(inputs, speed)?.model;
        let structure = Structure::new(model.blocks.iter().map(|b| Block::Real(b.repetitions)).collect());
        let structure = structure.map_err(|reason| Error::MuAtSpeed { speed, reason: reason.into() })?;
        let bound = |k: &Controller| {
            let closed = uncertain_loop(inputs, &model, k, (speed - centre) / half_range, None)?;
            let found = bound_over_frequency(&closed.stability(), &structure, None);
            Ok::<f64, Error>(found.map_or(f64::INFINITY, |bound| bound.upper))
        };
        Ok((speed, bound(controllers[0])?, bound(controllers[1])?))
    };
    speeds(inputs, SPEEDS).into_iter().map(at).collect()
}

fn model_line(truncated: &Truncated) -> String {
    let model = &truncated.model;
    let uncertain = model.channels() - model.scheduled;
    let gone = match truncated.gone.as_slice() {
        [] => "all parameters kept".into(),
        names => format!("left out: {}", names.join(", ")),
    };
    format!(
        "{} parameters in {uncertain} channels, {} channels of rho; {gone};\nchannels taken off move [A B] by {:.2} % at most over half the box",
        model.blocks.len(),
        model.scheduled,
        100.0 * truncated.error
    )
}

fn round_line(number: usize, round: &Round) -> String {
    format!(
        "round {number}: bears {:.1} % of the declared uncertainty (least gain of the weighed plant {:.3})",
        100.0 * round.size,
        round.least_gain
    )
}

impl Robust {
    /// The numbers side by side, for people.
    pub fn words(&self) -> String {
        let (low, high) = (self.found.given_bears.size, self.found.bears.size);
        let number = |g: Option<f64>| g.map_or_else(|| "none found".into(), |g| format!("{g:.4}"));
        let mut out = format!(
            "At a gain of {:.4}, {PRICE} times that of the nominal controller, is borne of the declared uncertainty, changing arbitrarily fast:\n\
             \x20 nominal controller {:.1} %, robust controller {:.1} %: {:.2} times as much\n\
             Gain bound at a part of the declared uncertainty\n        part     nominal      robust\n",
            PRICE * self.ladder[0].1.unwrap_or(f64::NAN),
            100.0 * low,
            100.0 * high,
            high / low
        );
        for (size, nominal, robust) in &self.ladder {
            out += &format!("  {:>8.1} %  {:>10}  {:>10}\n", 100.0 * size, number(*nominal), number(*robust));
        }
        out += "mu for robust stability, constant uncertainty, below at every frequency\n         m/s     nominal      robust\n";
        for (speed, nominal, robust) in &self.mu {
            out += &format!("  {speed:>10.2}  {nominal:>10.3}  {robust:>10.3}\n");
        }
        out + &format!("No more rounds: {}\n", self.found.stop)
    }

    /// Writes the certificate.
    ///
    /// # Errors
    /// [`Error::Certificate`], [`Error::Unwritable`].
    pub fn save(&self, directory: &Path) -> Result<(), Error> {
        let path = directory.join(CERTIFICATE);
        let text = self.certificate.to_json();
        let text = text.map_err(|reason| Error::Certificate { file: path.display().to_string(), reason })?;
        write(&path, text.as_bytes())
    }
}

/// The file of the certificate with uncertainty.
pub const CERTIFICATE: &str = "robust_certificate.json";
