//! What was proved, in words.

use crate::certificate::Certificate;
use crate::claim::{ConstantTheorem, LimitTheorem, RateTheorem};
use std::fmt;

/// A proved claim; it is displayed as a sentence.
///
/// The gammas are printed with the fewest digits that read back to the same f64, as in the file: the decimal denotes
/// that f64.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Theorem {
    /// Whether it is of a loop in discrete time.
    pub discrete: bool,
    /// The L2 gain from w to z is below this for parameters that vary arbitrarily fast, if the file claims it.
    pub gamma: Option<f64>,
    /// Parameters in `[-1, 1]`, all of which occur in plant or controller.
    pub parameters: usize,
    /// Parameters on which the controller depends.
    pub scheduled: usize,
    /// Whether the plant is a finished loop: it has neither controls nor measurements.
    pub finished: bool,
    /// States of the closed loop.
    pub states: usize,
    /// Channels of the parameters in plant and controller.
    pub channels: usize,
    /// Components of w.
    pub inputs: usize,
    /// Components of z.
    pub outputs: usize,
    /// The L2 gain from w to z is below this with the model error, if the file claims it.
    pub gamma_with_model_error: Option<f64>,
    /// What holds for a parameter with a bounded rate, if the file claims it.
    pub bounded_rate: Option<RateTheorem>,
    /// What holds with saturated commands, if the file claims it.
    pub limits: Option<LimitTheorem>,
    /// What holds for parameters some of which are constant, if the file claims it.
    pub constant: Option<ConstantTheorem>,
}

impl Theorem {
    /// The claims of a certificate that have been proved.
    pub(crate) fn of(certificate: &Certificate) -> Self {
        let (of, s) = (certificate.system(), certificate.system().sizes());
        Self {
            discrete: certificate.discrete,
            gamma: certificate.gain().map(|claim| claim.gamma),
            parameters: of.parameters(),
            scheduled: certificate.controller_blocks.iter().filter(|repetitions| **repetitions > 0).count(),
            finished: s.u == 0 && s.y == 0,
            states: s.x + s.xk,
            channels: s.t + s.tk,
            inputs: s.w,
            outputs: s.z,
            gamma_with_model_error: certificate.robust_gain().map(|claim| claim.gamma),
            bounded_rate: certificate.rate().map(|claim| RateTheorem::of(claim, certificate.robust_rate())),
            limits: certificate.limits().map(LimitTheorem::of),
            constant: certificate.constant().map(|claim| ConstantTheorem::of(claim, of)),
        }
    }

    /// The smallest bound that holds where the parameter moves at a bounded rate: one for parameters that vary
    /// arbitrarily fast holds there, too. `None` where the file claims nothing of a bounded rate.
    pub fn gamma_at_rate(&self) -> Option<f64> {
        let slow = self.bounded_rate?.gamma;
        Some(self.gamma.map_or(slow, |any_rate| any_rate.min(slow)))
    }

    /// The claim, a sentence each: gain and stability, model error, bounded rate, limits, constant parameters.
    pub fn sentences(&self) -> Vec<String> {
        let mut all = match (self.gamma, self.bounded_rate) {
            (Some(gamma), _) => vec![self.gain(gamma, None), self.model_error()],
            (None, Some(RateTheorem { rate, gamma, .. })) => vec![
                self.gain(gamma, Some(rate)),
                "Nothing is proved of a parameter that moves faster.".into(),
                self.model_error(),
            ],
            (None, None) => vec![],
        };
        all.extend(self.bounded_rate.filter(|_| self.gamma.is_some()).map(|slow| slow.to_string()));
        all.extend(self.limits.map(|limits| limits.to_string()));
        all.extend(self.constant.as_ref().map(ToString::to_string));
        all
    }

    /// The sentence about gain and stability, for parameters that vary arbitrarily fast, or one with a bounded rate.
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
            some => format!(", {some} of which the controller depends on,"),
        };
        let course = match (self.discrete, rate) {
            (true, _) => "sequence",
            (false, None) => "measurable trajectory",
            (false, Some(_)) => "Lipschitz continuous trajectory",
        };
        let motion =
            rate.map_or_else(String::new, |rate| format!(" that moves by at most {rate} in a unit of time"));
        match self.parameters {
            0 => format!("T{}.", &loop_[1..]),
            1 => format!("For every {course} of the parameter in [-1, 1]{motion}{known} {loop_}."),
            n => format!("For every {course} of the {n} parameters in [-1, 1]{known} {loop_}."),
        }
    }

    fn model_error(&self) -> String {
        match self.gamma_with_model_error {
            Some(gamma) => format!(
                "It stays exponentially stable, and the gain below {gamma}, when [A B1 B2] of the plant is replaced by \
                 [A B1 B2] + E Delta [F Fw Fu] for any measurable Delta(t) with a largest singular value of at most 1."
            ),
            None => {
                "Nothing is proved of a plant that differs from the one in the certificate: it covers no \
                     model error."
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
