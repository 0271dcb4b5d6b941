//! ArduSub: a parameter file of Mission Planner, MAVProxy or QGroundControl.
//!
//! `libraries/AC_AttitudeControl` and `AC_PID` of ArduPilot have the law. With the pitch rate q, int q dt = theta:
//!
//! ```text
//! q_t = ka (r - theta)
//! out = kp (q_t - q) + ki int (q_t - q) dt
//!     = (kp ka + ki) (b r - theta) + ki ka int (r - theta) dt - kp q,    b = kp ka/(kp ka + ki)
//! ```

use crate::allocation::Drive;
use crate::autopilots::form::{Export, Import, Missing, Plain, Unread, no_depth, not_written, stay, unread};
use crate::autopilots::source::{Numbers, Source, rounded};
use crate::file::Pid;
use crate::gain::Role;
use crate::refusal::not_allowed;
use squid_auv::toml_file::FileError;

/// The gain of the angle, and of the rate on its error and on the integral of that.
const ANGLE: &str = "ATC_ANG_PIT_P";
const RATE: &str = "ATC_RAT_PIT_P";
const INTEGRAL: &str = "ATC_RAT_PIT_I";
const INTEGRAL_LIMIT: &str = "ATC_RAT_PIT_IMAX";

/// What would be another law unless it is 0.
const ZERO: [(&str, &str); 2] = [
    ("ATC_RAT_PIT_FF", "a feedforward of the wanted rate has no counterpart in squid"),
    ("ATC_RAT_PIT_D_FF", "a feedforward of the wanted acceleration has no counterpart in squid"),
];

const LAW: [&str; 6] = [
    "Loop order: pitch error -> wanted rate q_t -> rate error -> output, of which 1 is the full one.",
    "q_t = ka (r - theta), ka = ATC_ANG_PIT_P in 1/s",
    "output = kp (q_t - q) + ki int (q_t - q) dt, kp = ATC_RAT_PIT_P, ki = ATC_RAT_PIT_I",
    "       = (kp ka + ki) (b r - theta) + ki ka int (r - theta) dt - kp q",
    "b = kp ka/(kp ka + ki)",
    "Outside: the square root of a large error, and the reference's shaping (ATC_INPUT_TC).",
];

/// What has no counterpart, of other values than 0, and the reason.
const LEFT_OUT: [Unread; 9] = [
    (
        "ATC_RAT_PIT_D",
        SET,
        "it acts on the acceleration of pitch: what these gains prove is the loop without it",
    ),
    ("ATC_RAT_PIT_FLTD", SET, "Hz, the filter of that acceleration"),
    ("ATC_RAT_PIT_FLTT", SET, "Hz, a filter of the wanted rate q_t, and so of the pitch error"),
    ("ATC_RAT_PIT_FLTE", SET, "Hz, a filter of the rate error, a lag of 1/(2 pi f) in the loop"),
    (INTEGRAL_LIMIT, SET, "a limit of the integral term, a share of the full output"),
    ("ATC_RAT_PIT_SMAX", SET, "a limit of the rate of the output"),
    ("ATC_RAT_PIT_PDMX", SET, "a limit of the terms of kp and kd"),
    ("ATC_RAT_PIT_NTF", SET, "a notch filter of the wanted rate"),
    ("ATC_RAT_PIT_NEF", SET, "a notch filter of the rate error"),
];

const SET: fn(f64) -> bool = |value| value != 0.0;

/// The numbers of a file.
struct Read {
    angle: Numbers,
    rate: Numbers,
    integral: Numbers,
    /// The moment of the full output, N m.
    full: f64,
}

/// Reads `NAME VALUE`, `NAME,VALUE` and, of QGroundControl, `SYSTEM COMPONENT NAME VALUE TYPE`.
fn source<'a>(text: &'a str, file: &'a str) -> Source<'a> {
    let mut source = Source::new(text, file);
    for (line, begin, whole) in source.lines() {
        let code = whole.split('#').next().unwrap_or(whole);
        let words: Vec<&str> = code.split([' ', '\t', ',', '=']).filter(|word| !word.is_empty()).collect();
        let at = if words.len() > 3 && words[0].parse::<u32>().is_ok() { 2 } else { 0 };
        if let [name, value, ..] = words[at.min(words.len())..] {
            source.push(name.to_owned(), line, begin, whole, value);
        }
    }
    source
}

/// Reads what import and export need.
fn read(source: &Source<'_>, missing: &Missing) -> Result<Read, FileError> {
    let gain = |key: &str, what: &str| source.required(key, 1, &format!("{what}, a parameter of ArduSub"));
    let angle = gain(ANGLE, "the gain from the pitch error to the wanted rate")?;
    let rate = gain(RATE, "the gain from the rate error to the output")?;
    let integral = gain(INTEGRAL, "the gain on the integral of the rate error")?;
    source.above_zero(&angle, 0)?;
    source.above_zero(&rate, 0)?;
    for (key, why) in ZERO {
        if let Some(Numbers { line, values, .. }) = source.optional(key, 1)?
            && values[0] != 0.0
        {
            return source.refuse(line, key, squid_auv::number(values[0]), format!("0: {why}"));
        }
    }
    let Some(full) = missing.full_output else {
        let hint = missing.hint.as_ref().map_or_else(String::new, |hint| format!(" ({hint})"));
        let found =
            "a share of the full output per rad/s, and the moment of the full output is not in the file";
        let allowed =
            format!("given with --full-output MOMENT, the pitching moment at output 1 in N.m{hint}");
        return source.refuse(rate.line, RATE, found, allowed);
    };
    Ok(Read { angle, rate, integral, full })
}

/// Refuses an integral that its limit holds at 0.
fn acts(source: &Source<'_>, ki: f64) -> Result<(), FileError> {
    match source.optional(INTEGRAL_LIMIT, 1)? {
        Some(Numbers { line, values, .. }) if values[0] == 0.0 && ki > 0.0 => {
            let allowed = format!("above 0, or {INTEGRAL} must be 0: this limit holds the integral at 0");
            source.refuse(line, INTEGRAL_LIMIT, "0", allowed)
        }
        _ => Ok(()),
    }
}

/// Reads the gains.
pub(crate) fn import(text: &str, file: &str, missing: &Missing) -> Result<Import, FileError> {
    let source = source(text, file);
    let Read { angle, rate, integral, full } = read(&source, missing)?;
    let [ka, kp, ki] = [&angle, &rate, &integral].map(|numbers| numbers.values[0]);
    acts(&source, ki)?;
    let mut found = Import::new(&LAW);
    let words = [ka, kp, ki, full].map(squid_auv::number);
    let of = |what: &str, all: &[(&str, &str, usize)]| {
        let each: Vec<String> =
            all.iter().map(|(key, value, line)| format!("{key} = {value} (line {line})")).collect();
        format!("{} N.m times {what}: {}", words[3], each.join(", "))
    };
    let (one, two, three) = (
        (ANGLE, &*words[0], angle.line),
        (RATE, &*words[1], rate.line),
        (INTEGRAL, &*words[2], integral.line),
    );
    let gains = [
        ("kp", Role::Proportional, kp * ka + ki, of("(kp ka + ki)", &[one, two, three])),
        ("ki", Role::Integral, ki * ka, of("ki ka", &[one, three])),
        ("kd", Role::Derivative, kp, of("kp", &[two])),
    ];
    for (key, role, value, from) in gains {
        found.gain(("pitch", key), rounded(full * value), &Drive::Moment.units(role), from);
    }
    if ki > 0.0 {
        let weight = rounded(kp * ka / (kp * ka + ki));
        found.gain(("pitch", "reference_weight"), weight, &[], "b = kp ka/(kp ka + ki)".into());
    }
    found.left_out = unread(&source, &LEFT_OUT)?;
    Ok(found)
}

/// How far a reference weight may be from the one that the gains have, for a weight of four decimals.
const WEIGHT: f64 = 1e-4;

/// Writes the gains.
///
/// With kp, ki and kd of squid K, Ki and Kd: `kp = Kd`, and ka solves `Kd ka^2 - K ka + Ki = 0`, `b = Kd ka/K`. Of the
/// two solutions b says which.
pub(crate) fn export(pid: &Pid, text: &str, file: &str, missing: &Missing) -> Result<Export, FileError> {
    let plain = Plain::of(pid)?;
    plain.require(pid, Drive::Moment, "the output of ArduSub is a share of a moment")?;
    no_depth(pid, "the parameters of ArduSub for depth are of another law")?;
    let source = source(text, file);
    let Read { angle, rate, integral, full } = read(&source, missing)?;
    let [k, ki, kd] = plain.pitch;
    acts(&source, ki)?;
    let refuse = |key: &str, line: usize, found: String, allowed: String| {
        Err(not_allowed(&pid.file, line, &format!("controller.pitch.{key}"), found, allowed))
    };
    let line = pid.turn.line;
    if kd == 0.0 {
        return refuse(
            "kd",
            line,
            "left out".into(),
            "given: ArduSub reaches pitch through the rate, kp = kd".into(),
        );
    }
    let ratio = 4.0 * kd * ki / (k * k);
    if ratio > 1.0 + 1e-9 {
        let (found, most) = (squid_auv::rounded(ki), squid_auv::rounded(k * k / (4.0 * kd)));
        let allowed = format!(
            "at most kp^2/(4 kd) = {most} N.m/(rad.s): a P loop around a PI of the rate has no more integral than that"
        );
        return refuse("ki", pid.turn.ki.as_ref().map_or(line, |ki| ki.line), found, allowed);
    }
    // The smaller solution by the product of both: a difference would lose its digits.
    let large = 0.5 * (1.0 + (1.0 - ratio).max(0.0).sqrt());
    let weights = [large, 0.25 * ratio / large];
    let asked = pid.turn.reference_weight;
    let possible = &weights[..if ki > 0.0 { 2 } else { 1 }];
    let Some(weight) = possible.iter().find(|weight| (*weight - asked).abs() <= WEIGHT) else {
        let allowed: Vec<String> = possible.iter().map(|weight| format!("{weight:.6}")).collect();
        let allowed = format!("{}: with these kp, ki and kd that of ArduSub's cascade", allowed.join(" or "));
        return refuse("reference_weight", line, squid_auv::number(asked), allowed);
    };
    let ka = weight * k / kd;
    let new = [
        (&angle, vec![rounded(ka)]),
        (&rate, vec![rounded(kd / full)]),
        (&integral, vec![rounded(ki / ka / full)]),
    ];
    let mut notes = not_written(pid, false);
    notes.extend(stay(&unread(&source, &LEFT_OUT)?));
    let (text, changes) = source.replaced(&new);
    Ok(Export { text, changes, notes })
}
