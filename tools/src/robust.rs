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
use crate::output::{read, remove, write, write_json};
use crate::stages::Stages;
use crate::uncertain::{at_speed, over_range};
use crate::uncertain_loop::{uncertain_loop, uncertain_plant};
use crate::uncertain_truncate::{Truncated, truncated};
use certificate::Certificate;
use lpv::analysis::{GainBound, bounded_gain};
use lpv::controller::Controller;
use lpv::model_error::LoopError;
use lpv::mu::sweep::bound_over_frequency;
use lpv::mu::worst_case::{Perturbable, worst_case_gain};
use lpv::mu::{Block, Structure};
use lpv::plant::GeneralisedPlant;
use lpv::robust::{RobustDesign, RobustOptions, Round, UncertainPlant, more_robust};
use lpv::robust_bound::{RobustBound, RobustLoop};
use lpv::synthesis::Design;
use serde::{Deserialize, Serialize};
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

/// The part of the declared uncertainty, held constant, for which the worst-case gain is shown.
const CONSTANT_SIZE: f64 = 0.25;

/// Speeds at which mu and worst-case gains are shown.
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

/// The two controllers side by side, as `robust.json` holds them; sizes are fractions of the declared uncertainty.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RobustFigures {
    /// The gain that neither may exceed.
    pub gamma: f64,
    /// The size that the nominal controller bears at this gain.
    pub nominal_bears: f64,
    /// The size that the robust controller bears.
    pub robust_bears: f64,
    /// Sizes, and at each the bound of the nominal and of the robust controller where there is one.
    pub ladder: Vec<(f64, Option<f64>, Option<f64>)>,
    /// The size of [`Frozen::worst`].
    pub constant_size: f64,
    /// Both controllers frozen at several speeds, with constant uncertainty.
    pub frozen: Vec<Frozen>,
    /// Uncertain parameters, their channels, and the channels of rho.
    pub sizes: (usize, usize, usize),
    /// How far the model may be off for its missing channels, relative.
    pub model_error: f64,
    /// Parameters that were left out.
    pub left_out: Vec<String>,
    /// Why there were no more rounds.
    pub stop: String,
}

/// What constant uncertainty does at one speed, to the nominal and the robust controller.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Frozen {
    /// Speed along the path, m/s.
    pub speed: f64,
    /// mu for robust stability is below this at every frequency; none where no bound closes.
    pub mu: [Option<f64>; 2],
    /// The worst-case gain at a size: below the first, and at least the second; none where the loop is not shown to stay stable.
    pub worst: [Option<(f64, f64)>; 2],
}

/// What came of the search.
#[derive(Debug, Clone)]
pub struct Robust {
    /// The robust controller with its bound at Delta = 0, for the plant of the nominal design.
    pub design: Design,
    /// The numbers side by side.
    pub figures: RobustFigures,
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
    let certificate = proved(&uncertain, &found)?;
    let figures = RobustFigures {
        gamma: options.gamma,
        nominal_bears: found.given_bears.size,
        robust_bears: found.bears.size,
        ladder: ladder(&uncertain, nominal, &design, &found),
        constant_size: CONSTANT_SIZE,
        frozen: frozen(inputs, [&nominal.controller, &found.controller])?,
        sizes: (truncated.model.blocks.len(), uncertain.unknown_channels(), uncertain.scheduled_channels()),
        model_error: truncated.error,
        left_out: truncated.gone,
        stop: found.stop.to_string(),
    };
    drop(running);
    Ok(Robust { design, figures, certificate })
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

/// mu for robust stability and the worst-case gain of the loops frozen at several speeds.
fn frozen(inputs: &Inputs, controllers: [&Controller; 2]) -> Result<Vec<Frozen>, Error> {
    let (centre, half_range) = inputs.design.scheduling();
    let at = |speed: f64| {
        let model = at_speed(inputs, speed)?.model;
        let structure = Structure::new(model.blocks.iter().map(|b| Block::Real(b.repetitions)).collect());
        let structure = structure.map_err(|reason| Error::MuAtSpeed { speed, reason: reason.into() })?;
        let mut found = Frozen { speed, mu: [None; 2], worst: [None; 2] };
        for (i, k) in controllers.into_iter().enumerate() {
            let system = uncertain_loop(inputs, &model, k, (speed - centre) / half_range, None)?.system;
            let whole = Perturbable { system, structure: structure.clone(), size: CONSTANT_SIZE };
            let mu = bound_over_frequency(&whole.stability(), &structure, None);
            found.mu[i] = mu.ok().map(|bound| bound.upper);
            found.worst[i] = worst_case_gain(&whole).ok().map(|worst| (worst.upper, worst.worst.gain));
        }
        Ok(found)
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
    /// Writes the certificate and the figures.
    ///
    /// # Errors
    /// [`Error::Certificate`], [`Error::Unwritable`].
    pub fn save(&self, directory: &Path) -> Result<(), Error> {
        let path = directory.join(CERTIFICATE);
        let text = self.certificate.to_json();
        let text = text.map_err(|reason| Error::Certificate { file: path.display().to_string(), reason })?;
        write(&path, text.as_bytes())?;
        write_json(&directory.join(FIGURES), &self.figures)
    }
}

/// Takes away what an earlier robust design left: it is of another controller.
///
/// # Errors
/// [`Error::Unwritable`].
pub fn forget(directory: &Path) -> Result<(), Error> {
    remove(&directory.join(CERTIFICATE))?;
    remove(&directory.join(FIGURES))
}

/// The figures of the robust design in a directory, if it holds one.
///
/// # Errors
/// [`Error::Unreadable`], [`Error::Json`].
pub fn stored(directory: &Path) -> Result<Option<RobustFigures>, Error> {
    let path = directory.join(FIGURES);
    if !path.is_file() {
        return Ok(None);
    }
    let wrong = |reason| Error::Json { path: path.display().to_string(), reason };
    serde_json::from_str(&read(&path)?).map(Some).map_err(wrong)
}

impl RobustFigures {
    /// For people.
    pub fn words(&self) -> String {
        let number = |g: Option<f64>| g.map_or_else(|| "none".into(), |g| format!("{g:.3}"));
        let mut out = format!(
            "At a gain of {:.4}, {PRICE} times that of the nominal controller, is borne of the declared uncertainty, changing arbitrarily fast:\n\
             \x20 nominal controller {:.1} %, robust controller {:.1} %: {:.2} times as much\n\
             Gain bound at a part of the declared uncertainty\n        part     nominal      robust\n",
            self.gamma,
            100.0 * self.nominal_bears,
            100.0 * self.robust_bears,
            self.robust_bears / self.nominal_bears
        );
        for (size, nominal, robust) in &self.ladder {
            out += &format!("  {:>8.1} %  {:>10}  {:>10}\n", 100.0 * size, number(*nominal), number(*robust));
        }
        out += &format!(
            "Constant uncertainty: mu for robust stability, and the worst-case gain (found, guaranteed) at {:.0} % of what is declared\n\
             \x20        m/s  mu nominal      robust   gain nominal         robust\n",
            100.0 * self.constant_size
        );
        for f in &self.frozen {
            let gain = |g: Option<(f64, f64)>| {
                g.map_or_else(|| "no bound".into(), |(upper, lower)| format!("{lower:.3}..{upper:.3}"))
            };
            out += &format!(
                "  {:>10.2}  {:>10}  {:>10}  {:>13}  {:>13}\n",
                f.speed,
                number(f.mu[0]),
                number(f.mu[1]),
                gain(f.worst[0]),
                gain(f.worst[1])
            );
        }
        out + &format!("No more rounds: {}\n", self.stop)
    }
}

/// The file of the figures.
pub const FIGURES: &str = "robust.json";

/// The file of the certificate with uncertainty.
pub const CERTIFICATE: &str = "robust_certificate.json";
