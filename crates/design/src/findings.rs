//! Findings on the files of a design, its models and its loop: the sentences that people read, with their numbers.

use crate::inputs::design_file::DesignFile;
use squid_auv::readable;
use squid_auv::{Actuator, rounded};
use squid_base::numbers::{decimals, rounded_down};
use squid_finding::Finding;

/// Pitch error of a unit, deg, above the usual ones.
pub(crate) fn large_pitch_scale(file: &str, scale: f64, usual: f64) -> Finding {
    let why = format!(
        "the unit of the pitch error ('track.scale') is {} deg; more than {usual} deg is unusual: check its unit",
        rounded(scale)
    );
    Finding::new("large_pitch_scale", "track.scale", why).file(file).value(scale, "deg").limit(usual)
}

/// Depth of the trims, m, at which a hull of half its diameter above its axis is not submerged.
pub(crate) fn not_submerged(file: &str, depth: f64, submerged: f64) -> Finding {
    let why = format!(
        "'model.depth' is {} m, where the hull is not submerged, but the equations hold in deep water: give the depth \
         at which the vehicle works",
        squid_auv::number(depth)
    );
    Finding::new("not_submerged", "model.depth", why).file(file).value(depth, "m").limit(submerged)
}

/// Slowest speed, m/s, at which no output of the autopilot changes the depth.
pub(crate) fn depth_not_held(file: &str, speed_min: f64) -> Finding {
    let why = format!(
        "nothing holds the depth at {} m/s ('model.speed_min'), where pitch does not change it: also track \"depth\", \
         or let the range begin above 0 m/s",
        squid_auv::number(speed_min)
    );
    Finding::new("depth_not_held", "model.speed_min", why).file(file).value(speed_min, "m/s").limit(0.0)
}

/// Pitch step, rad, that takes `ratio` times the available output of an actuator at a speed, m/s; an infinite ratio if
/// no output holds it.
pub(crate) fn step_not_held(step: f64, speed: f64, ratio: f64) -> Finding {
    let (degrees, limit) = (step.to_degrees(), step.to_degrees() / ratio);
    let (at, shown) = (rounded(speed), rounded(degrees));
    let why = if ratio.is_finite() {
        format!(
            "at {at} m/s holding the pitch {shown} deg off its trim takes {} times the output available from an \
             actuator, by the linear model; lower manoeuvre.pitch_step to {} deg or less, or raise model.speed_min",
            rounded(ratio),
            rounded(limit)
        )
    } else {
        format!(
            "at {at} m/s no actuator holds the pitch off its trim, so a step of {shown} deg will not last; raise \
             model.speed_min, or add an actuator with a pitch moment"
        )
    };
    let found = Finding::new("step_not_held", "manoeuvre.pitch_step", why);
    found.value(degrees, "deg").limit(limit).speed(speed)
}

/// Step of depth, m, whose reference model of a frequency, rad/s, moves at `rate`, m/s: on a path steeper than `steep`,
/// rad, at a speed, m/s, by a `ratio`.
pub(crate) fn steep_path(
    step: f64,
    frequency: f64,
    rate: f64,
    steep: f64,
    (speed, ratio): (f64, f64),
) -> Finding {
    let why = format!(
        "for a step of {} m the reference model of the depth, {} rad/s, moves at {} m/s: at {} m/s a path steeper than \
         {} deg, far from the level flight of the linear models; lower its 'frequency' to {} rad/s or less, or \
         manoeuvre.depth_step",
        rounded(step),
        rounded(frequency),
        rounded(rate),
        rounded(speed),
        rounded(steep.to_degrees()),
        rounded_down(frequency / ratio)
    );
    let found = Finding::new("steep_path", "track.frequency", why);
    found.value(frequency, "rad/s").limit(frequency / ratio).speed(speed)
}

/// Reference model of a signal with a frequency, rad/s, above the `limit` that the actuators can follow, since a step
/// needs `ratio` times the available acceleration at a speed, m/s.
pub(crate) fn fast_reference(
    (signal, unit): (&str, &str),
    step: f64,
    (frequency, limit): (f64, f64),
    (speed, ratio): (f64, f64),
) -> Finding {
    let (factor, readable_unit) = readable(unit);
    let key = if unit == "rad" { format!("manoeuvre.{signal}_step") } else { "its 'scale'".to_owned() };
    let why = format!(
        "the reference model of the {signal}, {} rad/s, needs {} times the acceleration available from all actuators \
         at {} m/s, for a step of {} {readable_unit}; lower its 'frequency' to {} rad/s or less, or {key}",
        rounded(frequency),
        rounded(ratio),
        rounded(speed),
        rounded(step * factor),
        rounded_down(limit)
    );
    let found = Finding::new("fast_reference", "track.frequency", why);
    found.value(frequency, "rad/s").limit(limit).speed(speed)
}

/// Mode of the controller, rad/s, that is faster than the `limit` of a sample time, s; the advice quotes the weight of
/// the control, and a sample time that is short enough, if one is allowed.
pub(crate) fn fast_mode(
    mode: f64,
    limit: f64,
    sample_time: f64,
    weight: f64,
    short_enough: Option<f64>,
) -> Finding {
    let faster = short_enough
        .map_or_else(String::new, |time| format!(", or reduce the sample time to {} s", rounded_down(time)));
    let why = format!(
        "the fastest mode of the controller, {mode:.0} rad/s, is above a fifth of the sampling rate, {limit:.1} rad/s \
         (2 pi/{sample_time} s/5): the sampled controller differs from the one with the proved bound, though its loop \
         is stable at these speeds. Raise control.weight, now {}, for a slower controller{faster}",
        rounded(weight)
    );
    Finding::new("fast_mode", "control.weight", why).value(mode, "rad/s").limit(limit)
}

/// Polynomial of gains that differs from its table by a fraction of the largest gain at a speed, m/s.
pub(crate) fn gain_fit(key: &str, relative: f64, speed: f64) -> Finding {
    let why = format!(
        "the polynomial of '{key}' differs from its piecewise linear table by up to {:.1} % of the largest gain, at \
         {} m/s",
        100.0 * relative,
        rounded(speed)
    );
    Finding::new("gain_fit", key, why).value(100.0 * relative, "%").speed(speed)
}

/// Step of pitch, rad, beyond the pitch that can be held at a speed, m/s, relative to level flight.
pub(crate) fn step_limited(step: f64, held: f64, speed: f64) -> Finding {
    let (step, held) = (step.to_degrees(), held.to_degrees());
    let why = format!(
        "at {} m/s pitch can be held up to {} deg from level flight, less than the step of the default manoeuvre, {} \
         deg: the step is limited",
        decimals(speed, 2),
        decimals(held, 2),
        decimals(step, 2)
    );
    Finding::new("step_limited", "manoeuvre.pitch_step", why).value(step, "deg").limit(held).speed(speed)
}

/// Anti-windup that was not found.
pub(crate) fn no_anti_windup(reason: &str) -> Finding {
    Finding::new("no_anti_windup", "anti_windup", format!("there is no anti-windup: {reason}"))
}

/// Proof of a design that fails.
pub(crate) fn not_proved(design: &str, reason: &str) -> Finding {
    Finding::new("not_proved", design, format!("NOT PROVED: {reason}"))
}

/// Names of the controls of a plant, and the weights that the design file gives them.
pub(crate) fn control_weights(actuators: &[Actuator], file: &DesignFile) -> Finding {
    let names = actuators.iter().enumerate().map(|(j, a)| format!("u{} is {}", j + 1, a.name));
    let why = format!(
        "{}; their weight is 'control.weight' of {}, {}{}",
        names.collect::<Vec<_>>().join(", "),
        file.file,
        file.control_weight.low,
        if file.relative_weights.is_empty() { "" } else { ", times those of 'control.actuators'" }
    );
    Finding::new("control_weights", "control.weight", why).value(file.control_weight.low, "")
}

/// Bounded rate of the speed, m/s^2, that may be left out, with the gamma without it if it is known.
pub(crate) fn bounded_rate(rate: f64, gamma: Option<f64>) -> Finding {
    let gamma = gamma.map_or_else(String::new, |gamma| {
        format!(", without which gamma can be {gamma:.4} for any trajectory of the speed")
    });
    let why = format!("leave 'synthesis.rate' out{gamma}; or try a larger 'synthesis.back_off'");
    Finding::new("bounded_rate", "synthesis.rate", why).value(rate, "m/s^2")
}
