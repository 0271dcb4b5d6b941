//! MSS of Fossen, SIMremus100.m, and the Python Vehicle Simulator: numbers assigned to names in a script.
//!
//! `delta_s = -Kp_theta (theta - theta_d) - Kd_theta q - Ki_theta int (theta - theta_d) dt`

use crate::allocation::Drive;
use crate::angle::Angle;
use crate::autopilots::form::{
    Export, Import, Plain, Unread, no_depth, no_weight, not_written, unchanged_notes, unread,
};
use crate::autopilots::source::{Numbers, Source};
use crate::file::Pid;
use crate::gain::Role;
use crate::refusal::not_allowed;
use squid_auv::toml_file::FileError;

/// Gains: name in the script, key of `[controller.pitch]`, and role.
const KEYS: [(&str, &str, Role); 3] = [
    ("Kp_theta", "kp", Role::Proportional),
    ("Ki_theta", "ki", Role::Integral),
    ("Kd_theta", "kd", Role::Derivative),
];

const LAW: [&str; 3] = [
    "Loop order: pitch error -> stern planes; angles in rad.",
    "delta_s = Kp_theta (theta_d - theta) + Ki_theta int (theta_d - theta) dt - Kd_theta q",
    "The sign of the planes is that of the vehicle: in squid positive gains raise the bow.",
];

const DEPTH: &str = "MSS computes theta_d from depth by a gradient law, which squid does not have; for the PI of the \
                     Python Vehicle Simulator, [controller.depth] has kp = Kp_z in rad/m and ki = Kp_z/T_z in \
                     rad/(m.s)";
const LEFT_OUT: [Unread; 4] = [
    ("Kp_z", |_| true, DEPTH),
    ("T_z", |_| true, DEPTH),
    ("k_grad", |_| true, DEPTH),
    ("K_w", |value| value != 0.0, "a gain on the heave speed; the proof is for the loop without it"),
];

/// Reads assignments of MATLAB or Python outside comments; the prefix `self.` of a name is dropped.
fn source<'a>(text: &'a str, file: &'a str) -> Source<'a> {
    let (mut source, mut commented) = (Source::new(text, file), false);
    for (line, begin, whole) in source.lines() {
        let trimmed = whole.trim();
        let quotes = trimmed.matches("\"\"\"").count();
        if matches!(trimmed, "%{" | "%}") || quotes == 1 {
            commented = trimmed != "%}" && !commented;
        }
        if commented || quotes > 0 {
            continue;
        }
        let code = whole.split(['%', '#']).next().unwrap_or(whole);
        for (name, value) in code.split(';').filter_map(|statement| statement.split_once('=')) {
            let name = name.trim().trim_start_matches("self.");
            let is_name = name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
            if is_name && !name.is_empty() && !value.starts_with('=') {
                source.push(name.to_owned(), line, begin, whole, value.trim());
            }
        }
    }
    source
}

/// Reads kp, which is required, and ki and kd if present.
fn read(source: &Source<'_>) -> Result<[Option<Numbers>; 3], FileError> {
    let kp = source.required(KEYS[0].0, 1, "the gain from the pitch error to the stern planes, a number")?;
    source.require_positive(&kp, 0)?;
    Ok([Some(kp), source.optional(KEYS[1].0, 1)?, source.optional(KEYS[2].0, 1)?])
}

/// Reads the gains.
pub(crate) fn import(angle: Angle, text: &str, file: &str) -> Result<Import, FileError> {
    let source = source(text, file);
    if angle != Angle::Pitch {
        let allowed = "pitch for a script of MSS, because its heading laws are not PIDs with such gains";
        return source.refuse(1, "--axis", angle.name(), allowed);
    }
    let mut found = Import::new(angle, LAW.map(str::to_owned).to_vec());
    for ((name, key, role), numbers) in KEYS.into_iter().zip(read(&source)?) {
        if let Some(Numbers { line, values, .. }) = numbers {
            let from = format!("line {line}, '{name}', not converted");
            found.gain(("pitch", key), values[0], &Drive::Deflection.units(role), from);
        }
    }
    found.left_out = unread(&source, &LEFT_OUT)?;
    Ok(found)
}

/// Writes the gains.
pub(crate) fn export(pid: &Pid, text: &str, file: &str) -> Result<Export, FileError> {
    if pid.turn.angle != Angle::Pitch {
        let (key, allowed) =
            (format!("controller.{}", pid.turn.angle), "controller.pitch for a script of MSS");
        return Err(not_allowed(&pid.file, pid.turn.line, &key, "given", allowed));
    }
    let plain = Plain::of(pid)?;
    plain.require(pid, Drive::Deflection, "the script commands stern planes")?;
    no_weight(pid)?;
    no_depth(pid, "the depth loop of MSS has another control law")?;
    let source = source(text, file);
    let read = read(&source)?;
    let mut new = vec![];
    for (((name, key, _), numbers), gain) in KEYS.iter().zip(&read).zip(plain.turn) {
        match numbers {
            Some(numbers) => new.push((numbers, vec![gain])),
            None if gain > 0.0 => {
                source.required(name, 1, &format!("pitch.{key} must be written to it"))?;
            }
            None => {}
        }
    }
    let mut notes = not_written(pid, false);
    notes.extend(unchanged_notes(&unread(&source, &LEFT_OUT[3..])?));
    let (text, changes) = source.replaced(&new);
    Ok(Export { text, changes, notes })
}
