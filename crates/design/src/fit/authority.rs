//! Authority of the actuators for the reference models of the tracked outputs.
//!
//! A step r excites a reference model of frequency w with the initial pitch acceleration r w^2, or speed acceleration r
//! w. The linear model gives the acceleration with the actuators at their limits, and the commands that hold the pitch
//! at r. If these are insufficient, the actuators saturate, whatever the weights.

use crate::axis::Linearisation;
use crate::fit::Model;
use crate::inputs::design_file::{DesignFile, Tracked};
use crate::numbers::{readable, rounded_down};
use squid_auv::longitudinal::{turn_rate, turning};
use squid_auv::{Actuator, Pitch, rounded};
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

/// Returns warnings: the actuators cannot hold the pitch step of the manoeuvre; they cannot accelerate the pitch by
/// that step, or the speed by its scale, as the reference model requires; the reference model of the depth takes a path
/// steeper than 30 deg.
pub fn remarks(actuators: &[Actuator], file: &DesignFile, model: &Model) -> Vec<String> {
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

fn too_far(actuators: &[Actuator], file: &DesignFile, model: &Model) -> Option<String> {
    let step = file.manoeuvre.step("pitch");
    let Shortage { speed, ratio } = worst(model, |l| holding_ratio(actuators, step, l))?;
    let degrees = step.to_degrees();
    let (speed, shown) = (rounded(speed), rounded(degrees));
    Some(if ratio.is_finite() {
        format!(
            "WARNING: at {speed} m/s holding the pitch {shown} deg off its trim takes {} times the output available \
             from an actuator,\nby the linear model; lower manoeuvre.pitch_step to {} deg or less, or raise \
             model.speed_min",
            rounded(ratio),
            rounded(degrees / ratio)
        )
    } else {
        format!(
            "WARNING: at {speed} m/s no actuator holds the pitch off its trim: a step of {shown} deg will not last;\n\
             raise model.speed_min, or add an actuator with a turning moment"
        )
    })
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

/// Warning of too steep a path in a step of depth; none if pitch is held in trim, because thrusters then hold the
/// heave.
fn too_steep(file: &DesignFile, tracked: &Tracked, model: &Model) -> Option<String> {
    if matches!(file.pitch, Pitch::Held(_)) {
        return None;
    }
    let rate = file.manoeuvre.step("depth").abs() * steepest(tracked.model.as_ref()?);
    let Shortage { speed, ratio } = worst(model, |l| rate / (l.trim.speed.abs() * STEEP.sin()))?;
    Some(format!(
        "WARNING: for a step of {} m the reference model of the depth, {} rad/s, moves at {} m/s: at {} m/s a path \
         steeper than {} deg,\nfar from the level flight of the linear models; lower its 'frequency' to {} rad/s or \
         less, or manoeuvre.depth_step",
        rounded(file.manoeuvre.step("depth")),
        rounded(tracked.model?.frequency),
        rounded(rate),
        rounded(speed),
        rounded(STEEP.to_degrees()),
        rounded_down(tracked.model?.frequency / ratio)
    ))
}

fn too_fast(actuators: &[Actuator], file: &DesignFile, tracked: &Tracked, model: &Model) -> Option<String> {
    let frequency = tracked.model?.frequency;
    // The actuators drive the second derivative of an angle.
    let (name, is_angle) = (tracked.signal.name, tracked.signal.unit == "rad");
    let step = if is_angle { file.manoeuvre.step(name).abs() } else { tracked.scale };
    let required = if is_angle { step * frequency * frequency } else { step * frequency };
    let Shortage { speed, ratio } = worst(model, |l| required / available(actuators, tracked, l))?;
    let (factor, unit) = readable(tracked.signal.unit);
    let lower = if is_angle { ratio.sqrt() } else { ratio };
    let key = if is_angle { format!("manoeuvre.{name}_step") } else { "its 'scale'".to_owned() };
    Some(format!(
        "WARNING: the reference model of the {}, {} rad/s, needs {} times the acceleration available from all \
         actuators at {} m/s,\n\
         for a step of {} {unit}; lower its 'frequency' to {} rad/s or less, or {key}",
        tracked.signal.name,
        rounded(frequency),
        rounded(ratio),
        rounded(speed),
        rounded(step * factor),
        rounded_down(frequency / lower)
    ))
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
    use crate::inputs::tests::{masked, shipped, shipped_axis};

    fn warnings(change: impl Fn(&mut Inputs)) -> Vec<String> {
        let mut inputs = shipped("squid", "design");
        change(&mut inputs);
        let model = Model::new(&inputs.axis(), &inputs.design).unwrap();
        remarks(&inputs.vehicle.actuators, &inputs.design, &model)
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
        let mut warnings_of_step = |step: f64| {
            inputs.design.manoeuvre = inputs.design.manoeuvre.with_step("depth", step);
            remarks(&inputs.vehicle.actuators, &inputs.design, &model)
        };
        let most = 0.7 / (0.35 * (-1f64).exp());
        assert_eq!(
            (warnings_of_step(1.0), warnings_of_step(0.99 * most), warnings_of_step(-0.99 * most)),
            (vec![], vec![], vec![])
        );
        let [steep] = &warnings_of_step(-1.05 * most)[..] else { panic!() };
        insta::assert_snapshot!(masked(steep));
        assert!((number_before(steep, " rad/s or less") - 0.35 / 1.05).abs() < 0.01, "{steep}");
    }

    /// Last number before a unit.
    fn number_before(text: &str, unit: &str) -> f64 {
        text.split(unit).next().unwrap().split_whitespace().last().unwrap().parse().unwrap()
    }

    /// The advised value is sufficient, and a slightly larger one is not.
    #[test]
    fn following_advice_removes_warning() {
        assert_eq!(warnings(|_| ()), Vec::<String>::new());
        let frequency =
            |w: f64| move |i: &mut Inputs| i.design.tracked[0].model.as_mut().unwrap().frequency = w;
        let [fast] = &warnings(frequency(20.0))[..] else { panic!() };
        let advised = number_before(fast.split("'frequency' to ").nth(1).unwrap(), " rad/s");
        assert!(advised > 1.7 && warnings(frequency(advised)).is_empty(), "{advised}");
        assert_eq!(warnings(frequency(1.05 * advised)).len(), 1);

        let step = |degrees: f64| {
            move |i: &mut Inputs| {
                i.vehicle.actuators.iter_mut().for_each(|a| (a.min, a.max) = (-26.0, 26.0));
                i.design.manoeuvre = i.design.manoeuvre.with_step("pitch", degrees.to_radians());
                i.design.tracked[0].model.as_mut().unwrap().frequency = 0.1;
            }
        };
        let [far] = &warnings(step(80.0))[..] else { panic!() };
        let advised = number_before(far.split("pitch_step to ").nth(1).unwrap(), " deg");
        assert!(warnings(step(0.99 * advised)).is_empty() && warnings(step(1.01 * advised)).len() == 1);
        insta::assert_snapshot!(masked(&format!("{fast}\n\n{far}")));
    }
}
