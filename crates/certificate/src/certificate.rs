//! Certificate as in its file: a closed loop and the claims about it.

use crate::claim::{Claim, Constant, Gain, Limits, Rate};
use crate::error::Failure;
use crate::plant::{Controller, ModelError, Plant};
use crate::shape::at_least_one;
use crate::strict::from_json;
use crate::system::Loop;
use serde::{Deserialize, Serialize};

/// Format of a certificate file.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Format {
    /// Version 1.
    #[default]
    #[serde(rename = "lpv-certificate/1")]
    One,
}

/// Plant, controller and model errors, and claims about their closed loop with the matrices that prove them.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Certificate {
    /// Format of the file.
    pub format: Format,
    /// `true` if plant and controller are in discrete time, with `x+`, the state at the next tick, in place of `x'`.
    /// Without this key the loop is in continuous time.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub discrete: bool,
    /// Repetitions `[r_1, r_2, ...]` of the parameters in the plant's channels; 0 for a parameter that occurs in the
    /// controller alone.
    pub blocks: Vec<usize>,
    /// Repetitions in the controller's channels, of the same parameters in the same order.
    pub controller_blocks: Vec<usize>,
    /// Plant.
    pub plant: Plant,
    /// Controller.
    pub controller: Controller,
    /// Model errors covered by some of the claims; empty without this key.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub errors: Vec<ModelError>,
    /// Claims, at least one.
    pub claims: Vec<Claim>,
}

/// Format key of a file.
#[derive(Deserialize)]
struct FormatHeader {
    #[serde(rename = "format")]
    _format: Format,
}

/// Finds the claim of a kind.
macro_rules! find {
    ($($(#[$doc:meta])* $name:ident: $kind:ident $(if $lambda:ident)?;)*) => {
        $($(#[$doc])*
        pub fn $name(&self) -> Option<&$kind> {
            self.claims.iter().find_map(|claim| match claim {
                Claim::$kind(found) $(if found.lambda.$lambda())? => Some(found),
                _ => None,
            })
        })*
    };
}

impl Certificate {
    find! {
        /// Returns the claim about the gain for parameters that vary arbitrarily fast.
        gain: Gain if is_none;
        /// Returns the claim about this gain with the model error.
        robust_gain: Gain if is_some;
        /// Returns the claim about the gain for a parameter with a bounded rate.
        rate: Rate if is_none;
        /// Returns the claim about this gain with the model error.
        robust_rate: Rate if is_some;
        /// Returns the claim about a step with saturated commands.
        limits: Limits;
        /// Returns the claim about the gain with constant parameters.
        constant: Constant;
    }

    /// Returns the model error covered by the claims, if any.
    pub fn model_error(&self) -> Option<&ModelError> {
        match self.errors.as_slice() {
            [error] if self.robust_gain().is_some() => Some(error),
            _ => None,
        }
    }

    /// Reads a certificate.
    ///
    /// # Errors
    /// [`Failure::Json`] or [`Failure::Malformed`], the first error of the text.
    pub fn from_json(text: &str) -> Result<Self, Failure> {
        // The format comes first: other formats have other keys.
        from_json::<FormatHeader>(text)?;
        let certificate: Self = from_json(text)?;
        certificate.check()?;
        Ok(certificate)
    }

    /// Returns the certificate as JSON; every number reads back to the same f64.
    ///
    /// # Errors
    /// [`Failure::Malformed`] if sizes do not agree or a number is not finite.
    pub fn to_json(&self) -> Result<String, Failure> {
        self.check()?;
        serde_json::to_string(self).map_err(|error| Failure::malformed("the certificate", error))
    }

    /// Checks that all numbers are finite, all sizes agree, and each claim is accompanied by those on which it rests.
    ///
    /// # Errors
    /// [`Failure::Malformed`] with the first field that does not fit.
    pub fn check(&self) -> Result<(), Failure> {
        self.system().check()?;
        self.check_claims()
    }

    /// Checks that there is at least one claim, none twice, that each is about this loop, and that each model error is
    /// covered by a claim.
    fn check_claims(&self) -> Result<(), Failure> {
        at_least_one("claims", "entries", (self.claims.len(), "claims"))?;
        for (i, claim) in self.claims.iter().enumerate() {
            let (kind, proved) = claim.parts();
            let (path, name) = (format!("claims[{i}].{kind}"), proved.name());
            if self.claims[..i].iter().any(|other| other.parts().1.name() == name) {
                return Err(Failure::malformed(path, format_args!("{name} occurs twice")));
            }
            if self.discrete && !claim.holds_in_discrete_time() {
                let reason = "applies to continuous time only, but `discrete` is true";
                return Err(Failure::malformed(path, reason));
            }
            self.check_needs(claim, &path)?;
            proved.check(&path, self.system())?;
        }
        if !self.errors.is_empty() && self.robust_gain().is_none() && self.constant().is_none() {
            let reason = "no claim covers the model errors; omit them, or add a claim `gain` with `lambda`";
            return Err(Failure::malformed("errors", reason));
        }
        Ok(())
    }

    /// Checks that the certificate contains the claims on which `claim` rests.
    fn check_needs(&self, claim: &Claim, path: &str) -> Result<(), Failure> {
        let wrong = |reason: &str| Err(Failure::malformed(path, reason));
        let (with_error, rests_on_gain) = match claim {
            Claim::Gain(gain) => (gain.lambda.is_some(), gain.lambda.is_some()),
            Claim::Rate(rate) => (rate.lambda.is_some(), false),
            Claim::Limits(_) => (true, false),
            Claim::Constant(_) => (false, false),
        };
        if rests_on_gain && self.gain().is_none() {
            return wrong(
                "requires the claim `gain` without lambda, for parameters that vary arbitrarily fast",
            );
        }
        if with_error && self.model_error().is_none() {
            return wrong(
                "requires one model error in `errors`, and the claim `gain` with lambda that covers it",
            );
        }
        match claim {
            Claim::Rate(robust)
                if with_error && self.rate().is_none_or(|plain| plain.rate != robust.rate) =>
            {
                let allowed = "the rate of the claim `rate` without lambda";
                Err(Failure::found(format!("{path}.rate"), robust.rate, allowed))
            }
            Claim::Constant(_) if self.claims.len() > 1 => {
                wrong("must be the only claim, but `claims` has others")
            }
            _ => Ok(()),
        }
    }

    /// Returns the loop.
    pub(crate) fn system(&self) -> Loop<'_> {
        let Self { discrete, blocks, controller_blocks, plant, controller, errors, .. } = self;
        Loop { discrete: *discrete, blocks, controller_blocks, plant, controller, errors }
    }

    /// Returns the states of the plant that belong to the loop with limits: those driven by controls or Delta, also
    /// through channels and other states, that in turn act on measurements, channels or Delta. The others are filters
    /// of w, which the steps replace, or of z.
    pub fn moving_states(&self) -> Vec<usize> {
        self.system().moving_states()
    }

    /// Returns the measurement y that jumps by exactly the step of an input w, if the step acts on the loop of
    /// [`Self::moving_states`] in no other way; otherwise `None`, because the omitted states would carry a part of the
    /// step.
    pub fn jumping_measurement(&self, input: usize) -> Option<usize> {
        self.system().jumping_measurement(input)
    }
}
