//! The figures of a robust design and of the nominal one: as a file, and as text.

use serde::{Deserialize, Serialize};
use squid_base::numbers::above;

/// The gain that corresponds to the weights of the design.
pub const UNIT_GAIN: f64 = 1.0;

/// The allowed gain relative to the bound of the nominal controller, if that is larger.
pub const ROBUST_GAIN_FACTOR: f64 = 1.25;

/// The gain at which both controllers are assessed, for a bound `nominal` of the nominal one.
pub fn gain_allowed(nominal: f64) -> f64 {
    (ROBUST_GAIN_FACTOR * nominal).max(UNIT_GAIN)
}

/// Description of [`gain_allowed`].
pub fn gain_text(gamma: f64) -> String {
    if gamma > UNIT_GAIN {
        format!("{ROBUST_GAIN_FACTOR} times the bound of the nominal controller")
    } else {
        "the gain that the weights specify".into()
    }
}

/// The figures of both controllers in `robust.json`; sizes are fractions of the declared uncertainty.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct RobustFigures {
    /// The gain allowed for both.
    pub gamma: f64,
    /// The proved bound on the gain of the robust controller at the size that it tolerates.
    pub proved: f64,
    /// The size that the nominal controller tolerates at this gain.
    pub nominal_tolerated_fraction: f64,
    /// The size that the robust controller tolerates at this gain.
    pub robust_tolerated_fraction: f64,
    /// Sizes, and at each the bounds of the nominal and of the robust controller, if any.
    pub ladder: Vec<(f64, Option<f64>, Option<f64>)>,
    /// The size of [`Frozen::worst`].
    pub constant_size: f64,
    /// Both controllers frozen at several speeds, with constant uncertainty.
    pub frozen: Vec<Frozen>,
    /// The numbers of uncertain parameters, of their channels, and of channels of rho.
    pub sizes: (usize, usize, usize),
    /// The relative error of the model by its removed channels, over the full declared box.
    pub model_error: f64,
    /// The relative error of the model with all its channels against the vehicle trimmed again, at corners of the full
    /// declared box: the least and the largest over the speeds.
    pub remainder: (f64, f64),
    /// Parameters without channels in the model.
    pub left_out: Vec<String>,
    /// Reason for which the rounds ended.
    pub stop: String,
}

/// The effect of constant uncertainty at one speed on the nominal and the robust controller.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Frozen {
    /// Speed along the path, m/s.
    pub speed: f64,
    /// An upper bound on mu for robust stability at every frequency; `None` if no bound was found.
    pub mu: [Option<f64>; 2],
    /// Upper and lower bound on the worst-case gain at a size; `None` if the loop is not shown to be stable.
    pub worst: [Option<(f64, f64)>; 2],
    /// The gain of the vehicle with the coefficients of the worst perturbation, trimmed again.
    #[serde(default)]
    pub vehicle: [Option<f64>; 2],
}

impl RobustFigures {
    /// The figures as text for a terminal.
    pub fn text(&self) -> String {
        let number = |g: Option<f64>| g.map_or_else(|| "none".into(), above);
        let mut out = format!(
            "At a gain of {:.4}, {}, the fraction of {} that is tolerated if it varies arbitrarily fast:\n\x20 nominal \
             controller {:.1} %, robust controller {:.1} %, which is {:.2} times as much (proved: gain below {})\n\
             Upper bound of the gain over the fraction of the declared uncertainty, varying arbitrarily fast\n    \
             fraction     nominal      robust\n",
            self.gamma,
            gain_text(self.gamma),
            self.declared(),
            100.0 * self.nominal_tolerated_fraction,
            100.0 * self.robust_tolerated_fraction,
            self.robust_tolerated_fraction / self.nominal_tolerated_fraction,
            above(self.proved)
        );
        for (size, nominal, robust) in &self.ladder {
            out += &format!("  {:>8.1} %  {:>10}  {:>10}\n", 100.0 * size, number(*nominal), number(*robust));
        }
        out += &format!(
            "Constant uncertainty at frozen speed: upper bound on mu for robust stability (1 is the full declared \
                uncertainty), and the\n\
                worst-case gain at {:.0} % of it: of the model, in which the incidence is an independent parameter \
                (lower..upper bound), and of a vehicle\n\
                with the coefficients of the perturbation, trimmed again\n\x20        m/s  mu nominal      robust     \
                gain nominal  vehicle           robust  vehicle\n",
            100.0 * self.constant_size
        );
        for f in &self.frozen {
            let gain = |g: Option<(f64, f64)>| {
                g.map_or_else(|| "no bound".into(), |(upper, lower)| format!("{lower:.4}..{}", above(upper)))
            };
            let vehicle = |g: Option<f64>| g.map_or_else(|| "none".into(), |g| format!("{g:.4}"));
            out += &format!(
                "  {:>10.2}  {:>10}  {:>10}  {:>15}  {:>7}  {:>15}  {:>7}\n",
                f.speed,
                number(f.mu[0]),
                number(f.mu[1]),
                gain(f.worst[0]),
                vehicle(f.vehicle[0]),
                gain(f.worst[1]),
                vehicle(f.vehicle[1])
            );
        }
        out + &format!("Stopped: {}\n{}\n", self.stop, self.not_proved())
    }

    /// The uncertainty that sizes refer to: the declared one without the parameters that the model leaves out.
    pub fn declared(&self) -> String {
        declared_without(&self.left_out)
    }

    /// Describes the error that the proof does not cover, with its size, in one or two sentences.
    pub fn not_proved(&self) -> String {
        let (least, most) = self.remainder;
        let held = match self.left_out.as_slice() {
            [] => String::new(),
            [one] => format!(" {one} has no channels left and is held at its nominal value."),
            names => {
                format!(" {} have no channels left and are held at their nominal values.", listed(names))
            }
        };
        format!(
            "The proof applies to the model. It does not cover the error of the model relative to the vehicle: {:.1} \
                to {:.1} % of [A B] over the six speeds, at corners of the full declared uncertainty, and up to \
                {:.2} % more for the removed channels.{held}",
            100.0 * least,
            100.0 * most,
            100.0 * self.model_error
        )
    }
}

/// The declared uncertainty without that of some parameters.
pub fn declared_without(left_out: &[String]) -> String {
    match left_out {
        [] => "the declared uncertainty".into(),
        names => format!("the declared uncertainty except that of {}", listed(names)),
    }
}

/// A list: A, B and C.
fn listed(names: &[String]) -> String {
    match names {
        [] => String::new(),
        [one] => one.clone(),
        [most @ .., last] => format!("{} and {last}", most.join(", ")),
    }
}
