//! Another anti-windup gain, for a design that misses a requirement on references beyond the envelope.
//!
//! The first gain is chosen for its size and the step that is proved with it ([`crate::certify::limits`]), not for
//! these flights. Where they miss a requirement, the other gains that can be proved are flown as well.

use crate::axis::VehicleModel;
use crate::certify::claims::{self, unproved_step};
use crate::certify::limits::{Tried, with_limits};
use crate::error::Error;
use crate::inputs::Inputs;
use crate::synthesise::anti_windup::anti_windup;
use crate::verdict::Verdict;
use crate::verdict::beyond::Beyond;
use crate::verdict::found::Effort;
use certificate::Theorem;
use lpv::controller::Controller;
use lpv::matrix::to_rows;
use lpv::plant::GeneralisedPlant;
use proof::claim::Proof;
use scheduled::{ControllerDesign, Rows};

/// A design with its verdict.
#[derive(Debug, Clone, Copy)]
pub struct Judged<'a> {
    /// The generalised plant.
    pub plant: &'a GeneralisedPlant,
    /// The controller.
    pub controller: &'a Controller,
    /// What is proved of it.
    pub proof: &'a Proof,
    /// The frozen controller, with its gain.
    pub frozen: &'a ControllerDesign,
    /// The verdict with that gain.
    pub verdict: &'a Verdict,
}

/// The design with another gain.
#[derive(Debug, Clone)]
pub struct OtherGain {
    /// The frozen controller.
    pub frozen: ControllerDesign,
    /// The proof, with the claim for that gain.
    pub proof: Proof,
    /// The verdict with that gain.
    pub verdict: Verdict,
}

impl OtherGain {
    /// Of the gains with which a claim is proved, the one whose flights beyond the envelope are farthest within their
    /// requirements; `None` if they meet these with the gain that the design has, if that is given, or if no other is
    /// better. It proves the step of the default flight if the gain of the design does, and misses no requirement that
    /// is met with that.
    ///
    /// # Errors
    /// Those of trim, linearisation and flights.
    pub fn of(inputs: &Inputs, judged: Judged<'_>) -> Result<Option<Self>, Error> {
        let (vehicle, file, first) = (&inputs.axis(), &inputs.design, judged.frozen);
        let mut least = Beyond::of_required(inputs, &judged.verdict.found.beyond);
        if least <= 1.0 || first.anti_windup.is_none() || file.controller.is_some() {
            return Ok(None);
        }
        let given: Vec<Rows> = match anti_windup(vehicle, file, judged.controller) {
            Err(Error::Synthesis(_)) => vec![],
            found => found?.iter().map(to_rows).collect(),
        };
        let alone = given.chunks(1).map(|given| Tried { given, computed: false });
        let is_enough = |theorem: &Theorem| unproved_step(first, theorem, &file.manoeuvre).is_none();
        let mut best = None;
        for tried in alone.chain([Tried { given: &[], computed: true }]) {
            let claim = (first, tried);
            let found =
                with_limits(judged.proof, judged.plant, judged.controller, claim, vehicle.actuators(), file);
            // Without a claim, a gain is not a candidate.
            let Ok(Some(proof)) = found else { continue };
            let anti_windup = proof.certificate.limits().map(|limits| limits.e.clone());
            if anti_windup == first.anti_windup
                || (is_enough(&judged.proof.theorem) && !is_enough(&proof.theorem))
            {
                continue;
            }
            let frozen = ControllerDesign { anti_windup, ..first.clone() };
            let flown = Beyond::of_required(inputs, &Beyond::of(inputs, &frozen, Effort::FULL.flown)?);
            if flown < least {
                least = flown;
                best = Some((frozen, proof));
            }
        }
        let Some((frozen, proof)) = best else { return Ok(None) };
        let verdict = Verdict::of(inputs, &frozen, Effort::FULL)?;
        Ok(verdict.meets_all_of(judged.verdict).then_some(Self { frozen, proof, verdict }))
    }

    /// What is flown and proved instead.
    pub fn words(&self) -> String {
        let claim = claims::limits(&self.frozen, &self.proof.theorem);
        let claim = claim.map_or_else(String::new, |claim| format!(":\n{claim}"));
        format!(
            "replaced by another gain, with which references beyond the envelope lose less; PROVED{claim}"
        )
    }
}
