//! Authority of the actuators for the reference models of the tracked outputs.
//!
//! A step r excites a reference model of frequency w with the initial pitch acceleration r w^2, or speed acceleration r
//! w. The linear model gives the acceleration with the actuators at their limits, and the commands that hold the pitch
//! at r. If these are insufficient, the actuators saturate, whatever the weights.

use crate::axis::Linearisation;
use crate::findings::{fast_reference, steep_path, step_not_held};
use crate::fit::Model;
use crate::inputs::design_file::{DesignFile, Tracked};
use squid_auv::longitudinal::{turn_rate, turning};
use squid_auv::{Actuator, Pitch};
use squid_finding::Finding;
use squid_lpv::matrix::Mat;
use squid_lpv::weights::ReferenceModel;

/// Fraction of the largest singular value below which singular values count as zero.
const RANK_TOLERANCE: f64 = 1e-9;

/// Relative tolerance of rounding.
const ROUNDING: f64 = 1e-6;

/// Largest ratio of required to available authority over the speeds, and its speed.
struct Shortage {
    speed: f64,
    ratio: f64,
}

/// Returns findings: the actuators cannot hold the pitch step of the manoeuvre; they cannot accelerate the pitch by
/// that step, or the speed by its scale, as the reference model requires; the reference model of the depth takes a path
/// steeper than 30 deg.
pub fn findings(actuators: &[Actuator], file: &DesignFile, model: &Model) -> Vec<Finding> {
    let of_output = |tracked: &Tracked| match tracked.signal.name {
        "depth" => [too_steep(file, tracked, model), None],
        "pitch" => [too_far(actuators, file, model), too_fast(actuators, file, tracked, model)],
        _ => [too_fast(actuators, file, tracked, model), None],
    };
    file.tracked.iter().flat_map(of_output).flatten().collect()
}

/// Largest ratio, if it is above 1.
fn worst(model: &Model, ratio: impl Fn(&Linearisation) -> f64) -> Option<Shortage> {
    let each = model.grid.iter().map(|(_, l)| Shortage { speed: l.trim.speed, ratio: ratio(l) });
    each.max_by(|a, b| a.ratio.total_cmp(&b.ratio)).filter(|shortage| shortage.ratio > 1.0)
}

fn too_far(actuators: &[Actuator], file: &DesignFile, model: &Model) -> Option<Finding> {
    let step = file.manoeuvre.step("pitch");
    let Shortage { speed, ratio } = worst(model, |l| holding_ratio(actuators, step, l))?;
    Some(step_not_held(step, speed, ratio))
}

/// Steepest path \[rad\] (30 deg) for which the linear models of level flight are accepted.
const STEEP: f64 = std::f64::consts::PI / 6.0;

/// Largest rate of the unit step response of a reference model \[1/s\]: `w exp(-zeta t)` at its inflection point `t =
/// acos(zeta)/sqrt(1 - zeta^2)`, in units of 1/w; w itself for a first-order model.
fn steepest(model: &ReferenceModel) -> f64 {
    let inflection = |zeta: f64| match 1.0 - zeta * zeta {
        rest if rest > ROUNDING => zeta.acos() / rest.sqrt(),
        rest if rest < -ROUNDING => zeta.acosh() / (-rest).sqrt(),
        _ => 1.0,
    };
    model.frequency * model.damping.map_or(1.0, |zeta| (-zeta * inflection(zeta)).exp())
}

/// Finding on too steep a path in a step of depth; none if pitch is held in trim, because thrusters then hold the
/// heave.
fn too_steep(file: &DesignFile, tracked: &Tracked, model: &Model) -> Option<Finding> {
    if matches!(file.pitch, Pitch::Held(_)) {
        return None;
    }
    let (step, reference) = (file.manoeuvre.step("depth"), tracked.model.as_ref()?);
    let rate = step.abs() * steepest(reference);
    let Shortage { speed, ratio } = worst(model, |l| rate / (l.trim.speed.abs() * STEEP.sin()))?;
    Some(steep_path(step, reference.frequency, rate, STEEP, (speed, ratio)))
}

fn too_fast(actuators: &[Actuator], file: &DesignFile, tracked: &Tracked, model: &Model) -> Option<Finding> {
    let frequency = tracked.model?.frequency;
    // The actuators drive the second derivative of an angle.
    let (name, is_angle) = (tracked.signal.name, tracked.signal.unit == "rad");
    let step = if is_angle { file.manoeuvre.step(name).abs() } else { tracked.scale };
    let required = if is_angle { step * frequency * frequency } else { step * frequency };
    let Shortage { speed, ratio } = worst(model, |l| required / available(actuators, tracked, l))?;
    let limit = frequency / if is_angle { ratio.sqrt() } else { ratio };
    Some(fast_reference((name, tracked.signal.unit), step, (frequency, limit), (speed, ratio)))
}

/// Largest acceleration of an output with every actuator at its reach \[SI/s2 or SI/s\]; for pitch, that of its rate.
fn available(actuators: &[Actuator], tracked: &Tracked, l: &Linearisation) -> f64 {
    let rate = turn_rate(l.states);
    let own = l.states.iter().position(|state| tracked.signal.output(state) == 1.0);
    let driven = if tracked.signal.unit == "rad" { rate } else { own.unwrap_or_default() };
    actuators.iter().enumerate().map(|(j, a)| (l.b[(driven, j)] * a.reach()).abs()).sum()
}

/// Returns the largest ratio, over the actuators, of the output that holds the pitch a step \[rad\] off the trim at the
/// same forward speed to the output available from the trim; infinite if the pitch cannot be held.
///
/// `A x + B u = 0` with x = \[0 w 0 step\] is solved for w and u with minimum norm, u in units of reach.
pub fn holding_ratio(actuators: &[Actuator], step: f64, l: &Linearisation) -> f64 {
    let [heave, _, theta] = turning(l.states);
    let coefficients = Mat::from_fn(theta, 1 + actuators.len(), |i, j| match j {
        0 => l.a[(i, heave)],
        j => l.b[(i, j - 1)] * actuators[j - 1].reach(),
    });
    let target = Mat::from_fn(theta, 1, |i, _| -l.a[(i, theta)] * step);
    let svd = coefficients.clone().svd(true, true);
    let largest = svd.singular_values.max();
    let Ok(found) = svd.solve(&target, RANK_TOLERANCE * largest) else { return f64::INFINITY };
    if (&coefficients * &found - &target).amax() > ROUNDING * target.amax() {
        return f64::INFINITY;
    }
    let used = |(j, a): (usize, &Actuator)| {
        let (needed, trim) = (found[(1 + j, 0)] * a.reach(), l.trim.actuators[j]);
        let available = if needed > 0.0 { a.max - trim } else { trim - a.min };
        if needed == 0.0 { 0.0 } else { needed.abs() / available }
    };
    actuators.iter().enumerate().map(used).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inputs::Inputs;
    use crate::inputs::tests::{shipped, shipped_axis};
    use crate::masked::masked;

    fn found(change: impl Fn(&mut Inputs)) -> Vec<Finding> {
        let mut inputs = shipped("squid", "design");
        change(&mut inputs);
        let model = Model::new(&inputs.axis(), &inputs.design).unwrap();
        findings(&inputs.vehicle.actuators, &inputs.design, &model)
    }

    /// The peak rate equals that of the numerically integrated unit step response of `w^2/(s^2 + 2 zeta w s + w^2)`.
    #[test]
    fn steepest_rate_is_that_of_step_response() {
        for damping in [0.3, 0.97, 1.0, 1.0 + 1e-9, 3.0] {
            let (frequency, tick) = (0.7, 1e-4);
            let (mut at, mut rate, mut most) = (0.0, 0.0, 0.0_f64);
            for _ in 0..200_000 {
                rate += tick * (frequency * frequency * (1.0 - at) - 2.0 * damping * frequency * rate);
                at += tick * rate;
                most = most.max(rate);
            }
            let found = steepest(&ReferenceModel { frequency, damping: Some(damping) });
            assert!((found - most).abs() < 1e-3 * most, "{damping}: {found} {most}");
        }
        assert_eq!(steepest(&ReferenceModel { frequency: 0.7, damping: None }), 0.7);
    }

    /// REMUS 100 in depth control sinks at 0.7 m/s on a path of 30 deg at 1.4 m/s.
    #[test]
    fn warns_of_too_steep_step_of_depth() {
        let mut inputs = shipped_axis("remus100", "design", Some("depth"));
        let model = Model::new(&inputs.axis(), &inputs.design).unwrap();
        let mut found_for_step = |step: f64| {
            inputs.design.manoeuvre = inputs.design.manoeuvre.with_step("depth", step);
            findings(&inputs.vehicle.actuators, &inputs.design, &model)
        };
        let most = 0.7 / (0.35 * (-1f64).exp());
        for step in [1.0, 0.99 * most, -0.99 * most] {
            assert_eq!(found_for_step(step), []);
        }
        let [steep] = &found_for_step(-1.05 * most)[..] else { panic!() };
        insta::assert_snapshot!(masked(&steep.to_string()));
        assert!((steep.limit.unwrap() - 0.35 / 1.05).abs() < 0.001 && steep.value == Some(0.35), "{steep:?}");
    }

    /// The advised value is sufficient, and a slightly larger one is not.
    #[test]
    fn following_advice_removes_finding() {
        assert_eq!(found(|_| ()), []);
        let frequency =
            |w: f64| move |i: &mut Inputs| i.design.tracked[0].model.as_mut().unwrap().frequency = w;
        let [fast] = &found(frequency(20.0))[..] else { panic!() };
        let advised = fast.limit.unwrap();
        assert!(advised > 1.7 && found(frequency((1.0 - 1e-9) * advised)).is_empty(), "{advised}");
        assert_eq!(found(frequency(1.01 * advised)).len(), 1);

        let step = |degrees: f64| {
            move |i: &mut Inputs| {
                i.vehicle.actuators.iter_mut().for_each(|a| (a.min, a.max) = (-26.0, 26.0));
                i.design.manoeuvre = i.design.manoeuvre.with_step("pitch", degrees.to_radians());
                i.design.tracked[0].model.as_mut().unwrap().frequency = 0.1;
            }
        };
        let [far] = &found(step(80.0))[..] else { panic!() };
        let advised = far.limit.unwrap();
        assert!(found(step((1.0 - 1e-9) * advised)).is_empty() && found(step(1.01 * advised)).len() == 1);
        insta::assert_snapshot!(masked(&format!("{fast}\n\n{far}")));
    }
}
