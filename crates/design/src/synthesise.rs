//! Synthesis: from the generalised plant of the design to a scheduled controller.

pub mod anti_windup;
pub mod follow;
pub mod given;
pub mod ladder;
pub mod robust;

use crate::check::fastest_sampled;
use crate::error::Error;
use crate::findings::{bounded_rate, control_weights};
use crate::inputs::design_file::DesignFile;
use squid_auv::Actuator;
use squid_base::numbers::above;
use squid_base::progress::Progress;
use squid_finding::Finding;
use squid_lpv::bounded_rate::SlowOptions;
use squid_lpv::error::SynthesisError;
use squid_lpv::parameter_grid::parameter_grid;
use squid_lpv::plant::GeneralisedPlant;
use squid_lpv::reduce::without_fast_modes;
use squid_lpv::regularity::irregularities;
use squid_lpv::synthesis::{Design, Options, ScalingClass, least_gamma};

/// Synthesises the scheduled controller for the generalised plant of [`crate::augment`] by
/// [`squid_lpv::synthesis::synthesise`], with a bound of the closed loop's L2 gain from w to z; or bounds that of a
/// [given](given::given) controller.
///
/// # Errors
/// [`Error::NoController`]; those of [`given::given`].
pub fn synthesise(
    actuators: &[Actuator],
    file: &DesignFile,
    plant: &GeneralisedPlant,
    progress: &Progress,
) -> Result<Design, Error> {
    if let Some(pid) = &file.controller {
        return given::given(actuators, file, plant, pid, progress);
    }
    let (outcome, seconds) = progress.timed("synthesise", "solving the matrix inequalities", || {
        let design = controller_for(file, plant, options(file));
        let design = design.map_err(|reason| no_controller(actuators, file, plant, reason))?;
        Ok::<_, Error>(with_slow_modes_only(file, plant, design))
    });
    let (design, slowed) = outcome?;
    progress.done("synthesise", &(synthesis_line(&design, file.back_off, seconds) + &slowed));
    progress.done(
        "bound",
        &format!(
            "gain of the finished loop below {} for any trajectory of speed in the range\n(by eigenvalues in \
             floating point, the closest to zero at {:.1e})",
            above(design.certified.gamma),
            design.certified.largest_eigenvalue
        ),
    );
    Ok(design)
}

/// Does the same as [`synthesise`] for one of many candidate designs: stops early if the search makes no progress.
///
/// # Errors
/// [`Error::NoController`], without causes.
pub fn synthesise_quickly(file: &DesignFile, plant: &GeneralisedPlant) -> Result<Design, Error> {
    let design = controller_for(file, plant, Options { quick: true, ..options(file) });
    let design = design.map_err(|reason| Error::NoController { reason, causes: vec![] })?;
    Ok(with_slow_modes_only(file, plant, design).0)
}

/// A controller for arbitrary rates of the speed, or for the design's bound on the rate.
fn controller_for(
    file: &DesignFile,
    plant: &GeneralisedPlant,
    options: Options,
) -> Result<Design, SynthesisError> {
    match file.rate {
        Some(rate) => at_bounded_rate(file, plant, rate),
        None => squid_lpv::synthesis::synthesise(plant, options),
    }
}

/// The allowed relative increase of the bound for the removal of modes that are too fast for the sample time, because
/// these are not realised as designed. With a small limit, a slight change of a weight could decide whether they stay.
const RISE_WITHOUT_FAST_MODES: f64 = 1.0;

/// The design, without the modes of its controller that are too fast for the sample time if the bound allows that; and
/// a message about them.
fn with_slow_modes_only(file: &DesignFile, plant: &GeneralisedPlant, design: Design) -> (Design, String) {
    let limit = fastest_sampled(file.sample_time);
    let thetas = parameter_grid(plant.blocks.len());
    let most = design.controller.fastest_mode(&thetas);
    // A bound at a bounded rate is for the controller with all its modes.
    if most <= limit || design.slow.is_some() {
        return (design, String::new());
    }
    let Some(slower) = without_fast_modes(plant, &design, limit, RISE_WITHOUT_FAST_MODES) else {
        return (design, String::new());
    };
    let removed = design.controller.a().nrows() - slower.controller.a().nrows();
    let (modes, are, their) = if removed == 1 { ("mode", "is", "its") } else { ("modes", "are", "their") };
    let text = format!(
        "\n{removed} {modes} of the controller, the fastest of {most:.0} rad/s, {are} too fast for the sample time: \
         replaced by {their} DC gain"
    );
    (slower, text)
}

/// A controller for a bounded rate of the speed, m/s^2. Its loop must also have a bound for arbitrary rates.
fn at_bounded_rate(file: &DesignFile, plant: &GeneralisedPlant, rate: f64) -> Result<Design, SynthesisError> {
    let (_, half_range) = file.scheduling();
    let options = SlowOptions { back_off: file.back_off, ..SlowOptions::at(rate / half_range) };
    let found = squid_lpv::bounded_rate::synthesise(plant, options)?;
    let certified = found.fast.ok_or_else(|| SynthesisError::Numerical {
        stage: "synthesis at a bounded rate",
        diagnosis: "no bound of the loop was found for a speed that changes faster than 'synthesis.rate'; raise this \
                    rate, or 'synthesis.back_off'"
            .into(),
    })?;
    let design = Design::new(found.controller, found.least.gamma, found.gamma_design, certified);
    Ok(Design { slow: Some(found.bound), ..design })
}

/// The options of the synthesis.
pub fn options(file: &DesignFile) -> Options {
    Options { back_off: file.back_off, accuracy: ACCURACY * file.back_off, ..Options::default() }
}

/// The accuracy of the least gamma, relative to the back-off from it.
const ACCURACY: f64 = 0.1;

/// The gammas, their distance, and the regularisation of the plant.
fn synthesis_line(design: &Design, requested: f64, seconds: f64) -> String {
    let (how, remark) = match &design.regularisation {
        Some(added) => (", of the plant with weight and noise added", format!("\nremark: {added}")),
        None if back_off(design) > 1.01 * requested => {
            (", more than requested, because no controller could be built closer", String::new())
        }
        None => ("", String::new()),
    };
    format!(
        "least gamma {:.4}, built at {:.4} ({:.1} % back-off{how}), {seconds:.1} s{remark}",
        design.gamma_optimum,
        design.gamma_design,
        100.0 * back_off(design)
    )
}

/// Returns the error of a failed synthesis, with findings on possible causes unless it is proved that there is no
/// controller.
fn no_controller(
    actuators: &[Actuator],
    file: &DesignFile,
    plant: &GeneralisedPlant,
    reason: SynthesisError,
) -> Error {
    let mut causes: Vec<Finding> = vec![];
    if matches!(reason, SynthesisError::Numerical { .. } | SynthesisError::TooFast { .. }) {
        causes.extend(irregularities(plant).iter().map(Finding::from));
        if !causes.is_empty() {
            causes.push(control_weights(actuators, file));
        }
        causes.extend(file.rate.map(|rate| {
            let least = least_gamma(plant, ScalingClass::SymmetricAndSkew);
            bounded_rate(rate, least.ok().map(|(_, least)| least.gamma))
        }));
    }
    Error::NoController { reason, causes }
}

/// The relative back-off `gamma_design/gamma_optimum - 1` at which the controller was built.
pub fn back_off(design: &Design) -> f64 {
    design.gamma_design / design.gamma_optimum - 1.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::augment::augment;
    use crate::fit::Model;
    use crate::inputs::Inputs;
    use crate::inputs::tests::shipped;
    use crate::masked::masked;
    use squid_lpv::partition::Group;
    use squid_lpv::regularise::Regularisation;

    /// The paper's design, whose controller is computed quickly.
    fn squid() -> (Inputs, GeneralisedPlant) {
        let inputs = shipped("squid", "paper");
        let plant = augment(
            &inputs.vehicle.actuators,
            &inputs.design,
            Model::new(&inputs.axis(), &inputs.design).unwrap().linear(),
        )
        .unwrap();
        (inputs, plant)
    }

    #[test]
    fn what_was_added_for_the_design_is_reported() {
        let (_, plant) = squid();
        let mut design = squid_lpv::synthesis::synthesise(&plant, Options::default()).unwrap();
        let line = |design: &Design| synthesis_line(design, Options::default().back_off, 1.0);
        let regular = line(&design);
        design.regularisation = Some(Regularisation { weights: vec![vec![1e-3, 0.0]], noises: vec![] });
        insta::assert_snapshot!(masked(&format!("{regular}\n\n{}", line(&design))));
    }

    /// A small change of a key must not decide whether fast modes stay: the loop would change abruptly.
    #[test]
    fn designs_near_the_default_have_no_fast_modes_either() {
        let mut inputs = shipped("squid", "design");
        let model = Model::new(&inputs.axis(), &inputs.design).unwrap();
        let (given, limit) = (inputs.design.clone(), fastest_sampled(inputs.design.sample_time));
        let changes: [fn(&mut DesignFile); 3] = [
            |file| file.tracked[0].weight.bandwidth *= 1.04,
            |file| file.tracked[0].references.follow *= 1.04,
            |file| file.back_off *= 1.2,
        ];
        for change in changes {
            inputs.design = given.clone();
            change(&mut inputs.design);
            let plant = augment(&inputs.vehicle.actuators, &inputs.design, model.linear()).unwrap();
            let controller = synthesise_quickly(&inputs.design, &plant).unwrap().controller;
            assert!(controller.fastest_mode(&parameter_grid(plant.blocks.len())) <= limit);
        }
    }

    /// The plant of Squid without its control weight: a failure without a proof has causes, a proved one has none.
    #[test]
    fn a_failure_that_proves_nothing_has_possible_causes() {
        let (inputs, mut plant) = squid();
        let failed = || SynthesisError::Numerical { stage: "test", diagnosis: "made up".into() };
        let causes = |file: &DesignFile, plant: &GeneralisedPlant, reason: SynthesisError| {
            let error = no_controller(&inputs.vehicle.actuators, file, plant, reason.clone());
            let Error::NoController { reason: found, causes } = &error else { panic!("{error}") };
            assert_eq!(found.to_string(), reason.to_string());
            (causes.len(), error.to_string())
        };
        assert_eq!(causes(&inputs.design, &plant, failed()).0, 0);
        let slow = DesignFile { rate: Some(0.1), ..inputs.design.clone() };
        let (count, fast_only) = causes(&slow, &plant, failed());
        assert_eq!(count, 1, "{fast_only}");

        plant.parts.block_mut(Group::Z, Group::U).fill(0.0);
        plant.parts.block_mut(Group::T, Group::U).fill(0.0);
        let (count, unweighted) = causes(&inputs.design, &plant, failed());
        assert_eq!(count, inputs.vehicle.actuators.len() + 1, "{unweighted}");
        insta::assert_snapshot!(format!("{}\n\n{unweighted}", masked(&fast_only)));
        assert_eq!(causes(&inputs.design, &plant, SynthesisError::TooFast { ratio: 2.0 }).0, count);
        assert_eq!(causes(&inputs.design, &plant, SynthesisError::NotQuadraticallyStabilisable).0, 0);
    }
}
