//! ArduSub: a parameter file of Mission Planner, MAVProxy or QGroundControl.
//!
//! Source of the law: `libraries/AC_AttitudeControl` and `AC_PID` of ArduPilot, a
//! [`cascade`](crate::autopilots::cascade) for each angle, whose output is a fraction of full output.

use crate::allocation::Drive;
use crate::angle::Angle;
use crate::autopilots::cascade::{cascade_of, law, pid_of};
use crate::autopilots::form::{
    Export, Import, Missing, Plain, Unread, no_depth, not_written, unchanged_notes, unread,
};
use crate::autopilots::source::{Numbers, Source, rounded};
use crate::file::Pid;
use crate::gain::Role;
use squid_auv::toml_file::FileError;

/// Parameter names of an angle.
struct Names {
    /// Gain on the angle error.
    angle: String,
    /// Gain on the rate error.
    rate: String,
    /// Gain on the integral of the rate error.
    integral: String,
    /// Common prefix of the parameters of the rate loop.
    stem: String,
}

impl Names {
    fn of(angle: Angle) -> Self {
        let short = match angle {
            Angle::Pitch => "PIT",
            Angle::Heading => "YAW",
            Angle::Roll => "RLL",
        };
        let stem = format!("ATC_RAT_{short}");
        Self {
            angle: format!("ATC_ANG_{short}_P"),
            rate: format!("{stem}_P"),
            integral: format!("{stem}_I"),
            stem,
        }
    }

    /// Returns the name of the integral limit.
    fn integral_limit(&self) -> String {
        format!("{}_IMAX", self.stem)
    }

    /// Returns the parameters without counterpart in `[controller]`.
    fn left_out(&self) -> Vec<Unread<String>> {
        LEFT_OUT.iter().map(|(end, why)| (format!("{}_{end}", self.stem), SET, *why)).collect()
    }
}

const SET: fn(f64) -> bool = |value| value != 0.0;

/// Suffixes of parameters that must be 0, with the reason: other values make another law.
const ZERO: [(&str, &str); 2] = [
    ("FF", "squid has no feedforward of the rate reference"),
    ("D_FF", "squid has no feedforward of the acceleration reference"),
];

/// Suffixes of parameters without counterpart, with the reason.
const LEFT_OUT: [(&str, &str); 9] = [
    ("D", "it acts on the angular acceleration; the proof is for the loop without it"),
    ("FLTD", "Hz, the filter of the angular acceleration"),
    ("FLTT", "Hz, a filter of the rate reference w, and thus of the angle error"),
    ("FLTE", "Hz, a filter of the rate error, a lag of 1/(2 pi f) in the loop"),
    ("IMAX", "a limit of the integral term, as a fraction of the full output"),
    ("SMAX", "a rate limit of the output"),
    ("PDMX", "a limit of the proportional and derivative terms"),
    ("NTF", "a notch filter of the rate reference"),
    ("NEF", "a notch filter of the rate error"),
];

const OUTSIDE: &str =
    "Not included: square root law for large errors, shaping of the reference (ATC_INPUT_TC).";

/// Numbers read from a file.
struct Read {
    angle: Numbers,
    rate: Numbers,
    integral: Numbers,
    /// Moment at full output, N m.
    full: f64,
}

/// Reads `NAME VALUE`, `NAME,VALUE` and the lines of QGroundControl, `SYSTEM COMPONENT NAME VALUE TYPE`.
fn source<'a>(text: &'a str, file: &'a str) -> Source<'a> {
    let mut source = Source::new(text, file);
    for (line, begin, whole) in source.lines() {
        let code = whole.split('#').next().unwrap_or(whole);
        let tokens: Vec<&str> = code.split([' ', '\t', ',', '=']).filter(|word| !word.is_empty()).collect();
        let at = if tokens.len() > 3 && tokens[0].parse::<u32>().is_ok() { 2 } else { 0 };
        if let [name, value, ..] = tokens[at.min(tokens.len())..] {
            source.push(name.to_owned(), line, begin, whole, value);
        }
    }
    source
}

/// Reads the parameters that import and export need.
fn read(source: &Source<'_>, angle: Angle, names: &Names, missing: &Missing) -> Result<Read, FileError> {
    let gain = |key: &str, what: &str| source.required(key, 1, &format!("{what}, a parameter of ArduSub"));
    let outer = gain(&names.angle, &format!("the gain from the {angle} error to the rate reference"))?;
    let rate = gain(&names.rate, "the gain from the rate error to the output")?;
    let integral = gain(&names.integral, "the gain on the integral of the rate error")?;
    source.require_positive(&outer, 0)?;
    source.require_positive(&rate, 0)?;
    for (end, why) in ZERO {
        let key = format!("{}_{end}", names.stem);
        if let Some(Numbers { line, values, .. }) = source.optional(&key, 1)?
            && values[0] != 0.0
        {
            return source.refuse(line, &key, squid_auv::number(values[0]), format!("0, because {why}"));
        }
    }
    let Some(full) = missing.full_output else {
        let hint = missing.hint.as_ref().map_or_else(String::new, |hint| format!(" ({hint})"));
        let found = "a fraction of the full output per rad/s, and the file does not contain the moment at full output";
        let allowed =
            format!("accompanied by --full-output MOMENT, the moment in {angle} at output 1 in N.m{hint}");
        return source.refuse(rate.line, &names.rate, found, allowed);
    };
    Ok(Read { angle: outer, rate, integral, full })
}

/// Refuses an integral gain if the integral limit is 0.
fn check_integral_limit(source: &Source<'_>, names: &Names, ki: f64) -> Result<(), FileError> {
    let limit = names.integral_limit();
    match source.optional(&limit, 1)? {
        Some(Numbers { line, values, .. }) if values[0] == 0.0 && ki > 0.0 => {
            let allowed = format!(
                "above 0, or {} must be 0, because a limit of 0 disables the integral",
                names.integral
            );
            source.refuse(line, &limit, "0", allowed)
        }
        _ => Ok(()),
    }
}

/// Reads the gains of an angle.
pub(crate) fn import(of: Angle, text: &str, file: &str, missing: &Missing) -> Result<Import, FileError> {
    let (source, names) = (source(text, file), Names::of(of));
    let Read { angle, rate, integral, full } = read(&source, of, &names, missing)?;
    let gains = [&angle, &rate, &integral].map(|numbers| numbers.values[0]);
    check_integral_limit(&source, &names, gains[2])?;
    let mut law = law(of, [&names.angle, &names.rate, &names.integral], "output (1 is full output)");
    law.push(OUTSIDE.into());
    let mut found = Import::new(of, law);
    let one = |numbers: &Numbers| {
        format!("{} = {} (line {})", numbers.key, squid_auv::number(numbers.values[0]), numbers.line)
    };
    let from = |what: &str, all: &[&Numbers]| {
        let each: Vec<String> = all.iter().map(|numbers| one(numbers)).collect();
        format!("{} N.m times {what}: {}", squid_auv::number(full), each.join(", "))
    };
    let (pid, weight) = pid_of(gains);
    let keys = [
        ("kp", Role::Proportional, from("(kp ka + ki)", &[&angle, &rate, &integral])),
        ("ki", Role::Integral, from("ki ka", &[&angle, &integral])),
        ("kd", Role::Derivative, from("kp", &[&rate])),
    ];
    for ((key, role, from), value) in keys.into_iter().zip(pid) {
        found.gain((of.name(), key), rounded(full * value), &Drive::Moment.units(role), from);
    }
    if gains[2] > 0.0 {
        let from = "b = kp ka/(kp ka + ki)".into();
        found.gain((of.name(), "reference_weight"), rounded(weight), &[], from);
    }
    found.left_out = unread(&source, &names.left_out())?;
    Ok(found)
}

/// Writes the gains.
pub(crate) fn export(pid: &Pid, text: &str, file: &str, missing: &Missing) -> Result<Export, FileError> {
    let plain = Plain::of(pid)?;
    plain.require(pid, Drive::Moment, "the output of ArduSub is a fraction of a moment")?;
    no_depth(pid, "the depth parameters of ArduSub belong to another control law")?;
    let (source, names) = (source(text, file), Names::of(pid.turn.angle));
    let Read { angle, rate, integral, full } = read(&source, pid.turn.angle, &names, missing)?;
    check_integral_limit(&source, &names, plain.turn[1])?;
    let [ka, kp, ki] = cascade_of(pid, &plain, "ArduSub")?;
    let new = [
        (&angle, vec![rounded(ka)]),
        (&rate, vec![rounded(kp / full)]),
        (&integral, vec![rounded(ki / full)]),
    ];
    let mut notes = not_written(pid, false);
    notes.extend(unchanged_notes(&unread(&source, &names.left_out())?));
    let (text, changes) = source.replaced(&new);
    Ok(Export { text, changes, notes })
}
