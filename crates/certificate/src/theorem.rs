//! Proved statement of a certificate.

use crate::certificate::Certificate;
use crate::claim::{ConstantTheorem, LimitTheorem, RateTheorem};
use std::fmt;

/// Proved claims; displayed as sentences.
///
/// The gammas are printed with the fewest digits that read back to the same f64, as in the file: the decimal denotes
/// that f64.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Theorem {
    /// `true` if the loop is in discrete time.
    pub discrete: bool,
    /// Upper bound on the L2 gain from w to z for parameters that vary arbitrarily fast, if the file claims it.
    pub gamma: Option<f64>,
    /// Number of parameters in `[-1, 1]`, all of which occur in plant or controller.
    pub parameters: usize,
    /// Number of parameters on which the controller depends.
    pub scheduled: usize,
    /// `true` if the plant is a closed loop, with neither controls nor measurements.
    pub finished: bool,
    /// Number of states of the closed loop.
    pub states: usize,
    /// Number of parameter channels of plant and controller.
    pub channels: usize,
    /// Number of components of w.
    pub inputs: usize,
    /// Number of components of z.
    pub outputs: usize,
    /// Upper bound on the L2 gain from w to z with the model error, if the file claims it.
    pub gamma_with_model_error: Option<f64>,
    /// Theorem for a parameter with a bounded rate, if the file claims it.
    pub bounded_rate: Option<RateTheorem>,
    /// Theorem with saturated commands, if the file claims it.
    pub limits: Option<LimitTheorem>,
    /// Theorem with constant parameters, if the file claims it.
    pub constant: Option<ConstantTheorem>,
}

impl Theorem {
    /// Creates the theorem of a certificate whose claims have been proved.
    pub(crate) fn of(certificate: &Certificate) -> Self {
        let (system, s) = (certificate.system(), certificate.system().sizes());
        Self {
            discrete: certificate.discrete,
            gamma: certificate.gain().map(|claim| claim.gamma),
            parameters: system.parameters(),
            scheduled: certificate.controller_blocks.iter().filter(|repetitions| **repetitions > 0).count(),
            finished: s.u == 0 && s.y == 0,
            states: s.x + s.xk,
            channels: s.t + s.tk,
            inputs: s.w,
            outputs: s.z,
            gamma_with_model_error: certificate.robust_gain().map(|claim| claim.gamma),
            bounded_rate: certificate.rate().map(|claim| RateTheorem::of(claim, certificate.robust_rate())),
            limits: certificate.limits().map(LimitTheorem::of),
            constant: certificate.constant().map(|claim| ConstantTheorem::of(claim, system)),
        }
    }

    /// Returns the smallest bound for the parameter with a bounded rate; a bound for arbitrarily fast parameters also
    /// holds there. `None` without a claim about a bounded rate.
    pub fn gamma_at_rate(&self) -> Option<f64> {
        let slow = self.bounded_rate?.gamma;
        Some(self.gamma.map_or(slow, |any_rate| any_rate.min(slow)))
    }

    /// Returns one sentence per claim: gain and stability, model error, bounded rate, limits, constant parameters.
    pub fn sentences(&self) -> Vec<String> {
        let mut all = match (self.gamma, self.bounded_rate) {
            (Some(gamma), _) => vec![self.gain(gamma, None), self.model_error()],
            (None, Some(RateTheorem { rate, gamma, .. })) => vec![
                self.gain(gamma, Some(rate)),
                "Nothing is proved about a parameter that changes faster.".into(),
                self.model_error(),
            ],
            (None, None) => vec![],
        };
        all.extend(self.bounded_rate.filter(|_| self.gamma.is_some()).map(|slow| slow.to_string()));
        all.extend(self.limits.map(|limits| limits.to_string()));
        all.extend(self.constant.as_ref().map(ToString::to_string));
        all
    }

    /// Returns the sentence about gain and stability, for parameters that vary arbitrarily fast, or one with a bounded
    /// rate.
    fn gain(&self, gamma: f64, rate: Option<f64>) -> String {
        let loop_ = format!(
            "the closed loop of {} state{}{} is exponentially stable and its {} gain from w to z is below {}",
            self.states,
            if self.states == 1 { "" } else { "s" },
            if self.discrete { " in discrete time" } else { "" },
            if self.discrete { "l2" } else { "L2" },
            gamma
        );
        // Parameters on which the controller does not depend need not be measured.
        let known = match self.scheduled {
            _ if self.finished => String::new(),
            all if all == self.parameters => String::new(),
            some => format!(", of which the controller depends on {some},"),
        };
        let course = match (self.discrete, rate) {
            (true, _) => "sequence",
            (false, None) => "measurable trajectory",
            (false, Some(_)) => "Lipschitz continuous trajectory",
        };
        let motion =
            rate.map_or_else(String::new, |rate| format!(" that changes by at most {rate} per unit of time"));
        match self.parameters {
            0 => format!("T{}.", &loop_[1..]),
            1 => format!("For every {course} of the parameter in [-1, 1]{motion}{known} {loop_}."),
            n => format!("For every {course} of the {n} parameters in [-1, 1]{known} {loop_}."),
        }
    }

    fn model_error(&self) -> String {
        match self.gamma_with_model_error {
            Some(gamma) => format!(
                "It remains exponentially stable, and its gain remains below {gamma}, if [A B1 B2] of the plant is \
                 replaced by [A B1 B2] + E Delta [F Fw Fu] for any measurable Delta(t) with largest singular value \
                 at most 1."
            ),
            None => {
                "The certificate covers no model error: nothing is proved about a plant that differs from the one in \
                     it."
                    .into()
            }
        }
    }
}

impl fmt::Display for Theorem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.sentences().join(" "))
    }
}
