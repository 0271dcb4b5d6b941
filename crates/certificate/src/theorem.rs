//! What was proved, in words.

use crate::certificate::{Certificate, EnergyClaim, Rows};
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
    /// The L2 gain from w to z is below this for parameters that move however fast, if the file claims it; otherwise
    /// there is a `bounded_rate`.
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
    /// What holds where the parameter moves at a bounded rate, if the file claims it.
    pub bounded_rate: Option<SlowTheorem>,
    /// What holds with commands cut off at limits, if the file claims it.
    pub limits: Option<LimitTheorem>,
    /// What holds with commands cut off at limits for w of bounded energy, if the file claims it.
    pub energy: Vec<EnergyTheorem>,
}

/// A proved bound of the gain of a loop whose commands are cut off at limits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EnergyTheorem {
    /// The L2 gain from w to z is below this.
    pub gamma: f64,
    /// The largest energy of w; `None` where it may have any, and H is 0.
    pub beta: Option<f64>,
}

/// A proved claim about a loop whose commands are cut off at limits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LimitTheorem {
    /// The component of w that steps, from 0.
    pub input: usize,
    /// The largest step, counted where it arrives: the jump of one y.
    pub size: f64,
    /// The rate of decay once the step is taken back.
    pub decay: f64,
    /// How many rows of Delta may differ from 0, if not all.
    pub delta_rows: Option<usize>,
    /// Of how many states of the plant the rates are cut off, too.
    pub rates: usize,
    /// Whether H is 0: a claim about every state.
    pub everywhere: bool,
}

/// A proved claim about a parameter that moves at a bounded rate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlowTheorem {
    /// `|theta'|` is at most this almost everywhere.
    pub rate: f64,
    /// The L2 gain from w to z is below this.
    pub gamma: f64,
    /// The same with the model error, if the file claims it.
    pub gamma_with_model_error: Option<f64>,
}

impl Theorem {
    /// The claim of a certificate that has been proved.
    pub(crate) fn of(certificate: &Certificate) -> Self {
        let s = certificate.sizes();
        Self {
            discrete: certificate.discrete,
            gamma: certificate.gamma(),
            parameters: certificate.blocks.len().max(certificate.controller_blocks.len()),
            scheduled: certificate.controller_blocks.iter().filter(|repetitions| **repetitions > 0).count(),
            finished: s.u == 0 && s.y == 0,
            states: s.x + s.xk,
            channels: s.t + s.tk,
            inputs: s.w,
            outputs: s.z,
            gamma_with_model_error: certificate.residual.as_ref().map(|r| r.gamma),
            bounded_rate: certificate.bounded_rate.as_ref().map(|b| SlowTheorem {
                rate: b.rate,
                gamma: b.slow.gamma,
                gamma_with_model_error: b.residual.as_ref().map(|r| r.slow.gamma),
            }),
            limits: certificate.limits.as_ref().map(|l| LimitTheorem {
                input: l.input,
                size: l.size,
                decay: l.decay,
                delta_rows: l.delta_rows,
                rates: l.rates.len(),
                everywhere: is_zero(&l.h),
            }),
            energy: certificate
                .energy
                .iter()
                .flat_map(|energy| &energy.claims)
                .map(EnergyTheorem::of)
                .collect(),
        }
    }

    /// The smallest bound that holds where the parameter moves at a bounded rate: one for parameters that move however
    /// fast holds there, too. `None` where the file claims nothing of a bounded rate.
    pub fn gamma_at_rate(&self) -> Option<f64> {
        let slow = self.bounded_rate?.gamma;
        Some(self.gamma.map_or(slow, |any_rate| any_rate.min(slow)))
    }

    /// The claim, a sentence each: gain and stability, model error, bounded rate, limits, bounded energy.
    pub fn sentences(&self) -> Vec<String> {
        let mut all = match (self.gamma, self.bounded_rate) {
            (Some(gamma), _) => vec![self.gain(gamma, None), self.model_error()],
            (None, Some(SlowTheorem { rate, gamma, .. })) => vec![
                self.gain(gamma, Some(rate)),
                "Nothing is proved of a parameter that moves faster.".into(),
                self.model_error(),
            ],
            (None, None) => vec![],
        };
        all.extend(self.bounded_rate.filter(|_| self.gamma.is_some()).map(|slow| slow.to_string()));
        all.extend(self.limits.map(|limits| limits.to_string()));
        if !self.energy.is_empty() {
            let bounds: Vec<String> = self.energy.iter().map(|bound| format!("below {bound}")).collect();
            all.push(format!(
                "With commands saturated at the limits in the file, and the part that is cut off fed back by E, the \
                 gain from rest is {}, and with w = 0 the state then returns to rest exponentially.",
                bounds.join(", ")
            ));
        }
        all
    }

    /// The sentence about gain and stability, for parameters that move however fast, or one at a bounded rate.
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
            None => "Nothing is proved of a plant that differs from the one in the certificate: it has no section \
                     `residual`."
                .into(),
        }
    }
}

impl fmt::Display for Theorem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.sentences().join(" "))
    }
}

fn is_zero(m: &Rows) -> bool {
    m.iter().flatten().all(|entry| *entry == 0.0)
}

impl EnergyTheorem {
    fn of(claim: &EnergyClaim) -> Self {
        Self { gamma: claim.gamma, beta: Some(claim.beta).filter(|_| !is_zero(&claim.h)) }
    }
}

impl fmt::Display for EnergyTheorem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.beta {
            Some(beta) => write!(f, "{} for every w of an energy of at most {beta}", self.gamma),
            None => write!(f, "{} for every w", self.gamma),
        }
    }
}

impl fmt::Display for LimitTheorem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { input, size, decay, delta_rows, rates, everywhere } = self;
        let moved = match rates {
            0 => String::new(),
            1 => " and the rate of 1 state of the plant limited".to_owned(),
            n => format!(" and the rates of {n} states of the plant limited"),
        };
        let rows =
            delta_rows.map_or_else(String::new, |rows| format!(" with rows of 0 after the first {rows}"));
        let where_ = if *everywhere { "from every state" } else { "within its region" };
        write!(
            f,
            "With commands saturated at the limits in the file{moved}, the part that is cut off fed back by E, and \
             that Delta{rows}: a step of at most {size} from rest at input {input}, behind the filters of the plant \
             that the loop does not drive, a jump by as much of one measurement, held for any time and removed, leaves \
             the state in the region in the file. The loop then returns to rest exponentially, \
             {where_}: x'Xx decays with the rate {decay}."
        )
    }
}

impl fmt::Display for SlowTheorem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "Where the parameter moves by at most {} in a unit of time, the gain is below {}",
            self.rate, self.gamma
        )?;
        match self.gamma_with_model_error {
            Some(gamma) => write!(f, ", and with that Delta below {gamma}."),
            None => f.write_str("; of another plant nothing is proved."),
        }
    }
}
