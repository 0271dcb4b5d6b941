//! Choice among the controllers of a generalised plant: the smallest that is no worse than the full one.

use crate::check::fastest_sampled;
use crate::error::Error;
use crate::fit::Model;
use crate::inputs::Inputs;
use crate::inputs::design_file::DesignFile;
use crate::linearise::{envelope, sensors};
use crate::run::prove::{FinishedAxis, Synthesised, proved};
use crate::store::freeze::gamma;
use crate::verdict::Verdict;
use crate::verdict::found::{Effort, Found};
use squid_base::numbers::above;
use squid_base::progress::{Progress, Results};
use squid_lpv::plant::GeneralisedPlant;
use squid_lpv::reduce::Reductions;
use squid_lpv::synthesis::Design;

/// Proved axis with its verdict.
pub(super) struct Judged {
    pub(super) axis: FinishedAxis,
    pub(super) verdict: Verdict,
}

impl Judged {
    fn has_limits(&self) -> bool {
        self.axis.proof.as_ref().is_ok_and(|proof| proof.certificate.limits().is_some())
    }

    /// Returns `true` if it claims all that the full design claims, and meets every requirement that the full one
    /// meets.
    fn is_no_worse_than(&self, full: &Self) -> bool {
        (self.has_limits() || !full.has_limits()) && self.verdict.meets_all_of(&full.verdict)
    }

    /// Returns `true` if no other controller of the design file can claim more or meet more requirements.
    fn is_complete(&self, file: &DesignFile) -> bool {
        (self.has_limits() || !file.anti_windup) && self.verdict.missed().next().is_none()
    }
}

/// Inputs, model and plant for which controllers are assessed.
#[derive(Clone, Copy)]
pub(super) struct Judge<'a> {
    pub(super) inputs: &'a Inputs,
    pub(super) model: &'a Model,
    pub(super) plant: &'a GeneralisedPlant,
}

impl Judge<'_> {
    /// Proves a design and assesses it.
    pub(super) fn assess(self, design: Design, progress: &Progress) -> Result<Judged, Error> {
        let Self { inputs, model, plant } = self;
        let (vehicle, file) = (&inputs.axis(), &inputs.design);
        let synthesised = Synthesised { model: model.clone(), plant: plant.clone(), design };
        let axis = proved(vehicle, file, &inputs.hashes, synthesised, progress)?;
        progress.done("envelope", &envelope::summary(&axis.controller));
        sensors::summary(&axis.controller).iter().for_each(|text| progress.done("failsafe", text));
        envelope::too_narrow(&axis.controller, &file.manoeuvre).iter().for_each(|found| progress.warn(found));
        let judge = || Verdict::of(inputs, &axis.controller, Effort::FULL);
        let verdict = progress.timed("verdict", "simulations, sampled loops and mu", judge).0?;
        progress.done("verdict", &verdict.to_string());
        Ok(Judged { axis, verdict })
    }

    /// Verdict on the frozen loops alone, without proof; `None` if it cannot be computed.
    fn frozen(self, design: &Design) -> Option<Verdict> {
        let found = Found::of_frozen(self.inputs, &design.controller).ok()?;
        Some(Verdict::judge(self.inputs, gamma(design, true).bound, found))
    }

    /// Returns the smallest controller found, in states and channels, whose bound rises by at most the fraction that
    /// the design file allows, whose loop is proved in continuous time, sampled and, if that of the full one is, with
    /// saturated commands, and whose verdict meets every requirement that the full one meets; the full one if none is
    /// found. The full one is assessed only if a smaller one misses something.
    pub(super) fn smallest(self, full: Design, progress: &Progress) -> Result<Judged, Error> {
        let Self { inputs, plant, .. } = self;
        let file = &inputs.design;
        let is_fixed = full.slow.is_some() || file.controller.is_some();
        let Some(share) = file.reduce.filter(|_| !is_fixed) else { return self.assess(full, progress) };
        let mut judged_full = None;
        let search = || {
            let fastest = fastest_sampled(file.sample_time);
            let mut frozen_full = None;
            Reductions::of(plant, &full, share, Some(fastest)).find_map(|smaller| {
                let frozen = self.frozen(&smaller)?;
                if frozen.missed().next().is_some() {
                    let full = frozen_full.get_or_insert_with(|| self.frozen(&full));
                    if !full.as_ref().is_some_and(|full| frozen.meets_all_of(full)) {
                        return None;
                    }
                }
                let (judged, results) = Results::collect(|quiet| self.assess(smaller.clone(), quiet));
                let judged = judged.ok().filter(|one| one.axis.proof.is_ok() && one.axis.sampled.is_ok())?;
                if !judged.is_complete(file) {
                    let full = judged_full
                        .get_or_insert_with(|| Results::collect(|quiet| self.assess(full.clone(), quiet)));
                    if !full.0.as_ref().is_ok_and(|full| judged.is_no_worse_than(full)) {
                        return None;
                    }
                }
                Some((smaller, judged, results))
            })
        };
        let (found, seconds) = progress.timed("reduce", "unnecessary states and channels", search);
        let line = match &found {
            Some((smaller, ..)) => format!(
                "reduced to {} from {}: gain below {} instead of {}, the same requirements are met ({seconds:.1} s)",
                sizes(smaller),
                sizes(&full),
                above(smaller.certified.gamma),
                above(full.certified.gamma)
            ),
            None => format!(
                "{} kept: no smaller controller was found that is proved and meets the same requirements \
                 ({seconds:.1} s)",
                sizes(&full)
            ),
        };
        progress.done("reduce", &line);
        match (found, judged_full) {
            (Some((_, judged, results)), _) => {
                results.report(progress);
                Ok(judged)
            }
            (None, Some((judged, results))) => {
                results.report(progress);
                judged
            }
            (None, None) => self.assess(full, progress),
        }
    }
}

fn sizes(design: &Design) -> String {
    let sizes = design.controller.parts.sizes();
    format!("{} states and {} {} of rho", sizes.x, sizes.t, if sizes.t == 1 { "channel" } else { "channels" })
}
