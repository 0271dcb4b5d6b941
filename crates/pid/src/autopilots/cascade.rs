//! P loop of an angle x around a PI loop of its rate, which equals a PID with a reference weight.
//!
//! The angle follows a reference r, and is the integral of its rate x':
//!
//! ```text
//! w = ka (r - x)
//! out = kp (w - x') + ki int (w - x') dt
//!     = (kp ka + ki) (b r - x) + ki ka int (r - x) dt - kp x',    b = kp ka/(kp ka + ki)
//! ```

use crate::angle::Angle;
use crate::autopilots::form::Plain;
use crate::file::Pid;
use crate::gain::Role;
use crate::refusal::not_allowed;
use squid_auv::toml_file::FileError;

/// Tolerance between a given reference weight and that of a cascade, for weights written with four decimals.
const WEIGHT_TOLERANCE: f64 = 1e-4;

/// Returns the law as text; `keys` name ka, kp and ki, `output` names the command.
pub(crate) fn law(angle: Angle, keys: [&str; 3], output: &str) -> Vec<String> {
    let ([ka, kp, ki], [x, rate]) = (keys, angle.symbols());
    vec![
        format!("Loop order: {angle} error -> rate reference w -> rate error -> {output}."),
        format!("w = ka (r - {x}), ka = {ka} in 1/s"),
        format!("output = kp (w - {rate}) + ki int (w - {rate}) dt"),
        format!("       = (kp ka + ki) (b r - {x}) + ki ka int (r - {x}) dt - kp {rate}"),
        format!("kp = {kp}, ki = {ki}, b = kp ka/(kp ka + ki)"),
    ]
}

/// Returns kp, ki and kd of the PID that equals a cascade with ka, kp and ki, and its reference weight b.
pub(crate) fn pid_of([ka, kp, ki]: [f64; 3]) -> ([f64; 3], f64) {
    ([kp * ka + ki, ki * ka, kp], kp * ka / (kp * ka + ki))
}

/// Returns ka, kp and ki of the cascade that equals a PID with gains K, Ki and Kd: `kp = Kd`, and ka solves
/// `Kd ka^2 - K ka + Ki = 0`, `b = Kd ka/K`. The reference weight b selects one of the two solutions.
///
/// # Errors
/// [`FileError`] of the PID if no cascade has its gains or its weight.
pub(crate) fn cascade_of(pid: &Pid, plain: &Plain, autopilot: &str) -> Result<[f64; 3], FileError> {
    let ([k, ki, kd], angle, line) = (plain.turn, pid.turn.angle, pid.turn.line);
    let refuse = |key: &str, line: usize, found: String, allowed: String| {
        Err(not_allowed(&pid.file, line, &format!("controller.{angle}.{key}"), found, allowed))
    };
    if kd == 0.0 {
        let allowed = format!("given, because the rate loop of {autopilot} has the gain kp = kd");
        return refuse("kd", line, "missing".into(), allowed);
    }
    let ratio = 4.0 * kd * ki / (k * k);
    if ratio > 1.0 + 1e-9 {
        let (found, most) = (squid_auv::rounded(ki), squid_auv::rounded(k * k / (4.0 * kd)));
        let allowed = format!(
            "at most kp^2/(4 kd) = {most} {}, the largest integral gain of a P loop around a PI rate loop",
            plain.drive.units(Role::Integral)[0].0
        );
        return refuse("ki", pid.turn.ki.as_ref().map_or(line, |ki| ki.line), found, allowed);
    }
    // Take the smaller solution from the product of both: a difference would lose digits.
    let large = 0.5 * (1.0 + (1.0 - ratio).max(0.0).sqrt());
    let weights = [large, 0.25 * ratio / large];
    let given = pid.turn.reference_weight;
    let possible = &weights[..if ki > 0.0 { 2 } else { 1 }];
    let Some(weight) = possible.iter().find(|weight| (*weight - given).abs() <= WEIGHT_TOLERANCE) else {
        let allowed: Vec<String> = possible.iter().map(|weight| format!("{weight:.6}")).collect();
        let allowed = format!(
            "{}, the reference weight of {autopilot}'s cascade with these kp, ki and kd",
            allowed.join(" or ")
        );
        return refuse("reference_weight", line, squid_auv::number(given), allowed);
    };
    let ka = weight * k / kd;
    Ok([ka, kd, ki / ka])
}
