//! DUNE of LSTS, Porto: `control.ini` of an AUV.
//!
//! `src/Control/AUV/Attitude/Task.cpp` and `DUNE/Control/DiscretePID.cpp` have the law, `src/Control/AUV/Allocator` the
//! fins, `DUNE/Parsers/Config.cpp` the format. The integral holds ki, which at constant gains is the same.

use crate::allocation::Drive;
use crate::autopilots::form::{
    Export, Import, Missing, Plain, Unread, left_out, no_weight, not_written, unread,
};
use crate::autopilots::source::{Numbers, Source, converted};
use crate::file::Pid;
use crate::gain::{Role, of_pitch};
use squid_auv::toml_file::FileError;

/// kp, ki and kd of pitch and of depth; the moment of a fin, N m/rad.
const PITCH: &str = "[Control.AUV.Attitude] Pitch PID Gains";
const DEPTH: &str = "[Control.AUV.Attitude] Depth PID Gains";
const EFFECT: &str = "[Control.AUV.Allocator] Fin effect M";
/// Of the allocator's source, and of etc/auv/control.ini.
const DEFAULT_EFFECT: f64 = 0.5;

/// A flag: its key, whether a value of it, in small letters, leaves the law as it is, and what is allowed.
type Flag = (&'static str, fn(&str) -> bool, &'static str);

/// Flags with which another law flies, or may.
const FLAGS: [Flag; 4] = [
    ("[Control.AUV.Attitude] Enabled", |v| v != "never", "not Never: the gains are otherwise not flown"),
    (
        "[Control.AUV.Attitude] Error Attitude Compensation",
        |v| v == "false",
        "false: the attitude error itself is otherwise the command",
    ),
    (
        "[Control.AUV.Allocator] Fin effect Velocity dependent",
        |v| v == "false",
        "false: the gain to the fins otherwise depends on the speed",
    ),
    ("[Control.AUV.LMI] Enabled", |v| v == "never", "Never: that task may otherwise command the fins"),
];

const LAW: [&str; 5] = [
    "Loop order: depth error -> pitch reference r -> pitch error -> m -> fins; angles in rad.",
    "m = kp (r - theta) + ki int (r - theta) dt - kd (q cos phi - r sin phi)",
    "fins = 0.5 m/(Fin effect M), two of them",
    "r = -(kp (z_r - z) + ki int (z_r - z) dt - kd z'), of Depth PID Gains",
    "Roll, heading and altitude have gains of their own and are not read.",
];

/// What has no counterpart: the values that are worth a word, and the reason.
const LEFT_OUT: [Unread; 7] = [
    (
        "[Control.AUV.Attitude] Maximum Pitch Actuation",
        |_| true,
        "a limit of m in deg; squid has those of the vehicle",
    ),
    ("[Control.AUV.Attitude] Pitch Integral Limit", |v| v > 0.0, "a limit of the integral term, deg"),
    (
        "[Control.AUV.Attitude] Maximum Pitch Reference",
        |_| true,
        "a limit of the pitch reference from depth, deg",
    ),
    (
        "[Control.AUV.Attitude] Depth-to-pitch PID sampling rate relation",
        |v| v != 1.0,
        "the depth loop takes fewer samples than that of pitch",
    ),
    (
        "[Control.AUV.Attitude] Altitude PID Gains",
        |_| true,
        "altitude above the bottom is no output of squid",
    ),
    (
        "[Control.AUV.Speed] MPS PID Gains",
        |_| true,
        "they give revolutions, and the file has no thrust of those in N",
    ),
    (
        "[Control.AUV.Speed] RPMs PID Gains",
        |_| true,
        "they give a share of the thrust, whose N are not in the file",
    ),
];

const NO_DEPTH: &str = "kd on the vertical speed has no counterpart in squid's depth loop, which is left out: prove \
                        pitch alone, or set that kd to 0";

/// The numbers of a file, and the fins' angle per m.
struct Read {
    pitch: Numbers,
    depth: Option<Numbers>,
    fins: f64,
    effect: String,
}

/// Reads sections, options and values that go on in the next line.
fn source<'a>(text: &'a str, file: &'a str) -> Result<(Source<'a>, bool), FileError> {
    let (mut source, mut section, mut others, mut open) = (Source::new(text, file), None, false, false);
    for (line, begin, whole) in source.lines() {
        let words = whole.trim();
        if words.is_empty() || words.starts_with([';', '#']) {
            continue;
        }
        if let Some(name) = words.strip_prefix('[').and_then(|rest| rest.split(']').next()) {
            others |= ["Include ", "Require "].iter().any(|kind| name.starts_with(kind));
            (section, open) = (Some(name.trim()), false);
            continue;
        }
        let code = whole.split([';', '|', '#']).next().unwrap_or(whole);
        match (whole.split_once('='), section) {
            (Some((option, _)), Some(section)) => {
                let option = option.split('{').next().unwrap_or(option).trim();
                let value = code.split_once('=').map_or("", |(_, value)| value).trim();
                let key = format!("[{section}] {option}");
                if let Some(plain) =
                    [PITCH, DEPTH, EFFECT].iter().find(|one| key.trim_end_matches(['+', '-']) == **one)
                    && key != **plain
                {
                    return source.refuse(
                        line,
                        plain,
                        format!("changed by '{option}'"),
                        "given as a whole by '='",
                    );
                }
                source.push(key, line, begin, whole, value);
                open = true;
            }
            (None, Some(_)) if open => source.extend(begin, whole, code.trim()),
            _ => {}
        }
    }
    Ok((source, others))
}

/// Reads what import and export need.
fn read(source: &Source<'_>, others: bool) -> Result<Read, FileError> {
    let included =
        if others { "; files that this one includes are not read: name the one that has it" } else { "" };
    let meaning = format!("kp, ki and kd of pitch, as in etc/auv/control.ini of DUNE{included}");
    let pitch = source.required(PITCH, 3, &meaning)?;
    source.above_zero(&pitch, 0)?;
    for (key, is_good, allowed) in FLAGS {
        if let Some((line, value)) = source.value(key)?
            && !is_good(&value.to_lowercase())
        {
            return source.refuse(line, key, value, allowed);
        }
    }
    let given = source.optional(EFFECT, 1)?;
    let (effect, said) = match &given {
        Some(numbers) => {
            source.above_zero(numbers, 0)?;
            (numbers.values[0], format!("line {}", numbers.line))
        }
        None if others => {
            let found = "not in this file, which includes others";
            let allowed = "written in it, because the fins' angle is 0.5 m/(Fin effect M); in DUNE it is 0.5 unless a \
                           file sets another";
            return source.refuse(1, EFFECT, found, allowed);
        }
        None => (DEFAULT_EFFECT, "the default of DUNE".into()),
    };
    let effect_words = format!("fins = 0.5 m/{} (Fin effect M, {said})", squid_auv::number(effect));
    Ok(Read { pitch, depth: source.optional(DEPTH, 3)?, fins: DEFAULT_EFFECT / effect, effect: effect_words })
}

/// Reads the gains.
pub(crate) fn import(text: &str, file: &str, _: &Missing) -> Result<Import, FileError> {
    let (source, others) = source(text, file)?;
    let Read { pitch, depth, fins, effect } = read(&source, others)?;
    let mut found = Import::new(&LAW);
    let units = |role| Drive::Deflection.units(role);
    let roles = [("kp", Role::Proportional), ("ki", Role::Integral), ("kd", Role::Derivative)];
    for ((key, role), value) in roles.into_iter().zip(&pitch.values) {
        let from = format!(
            "line {}, 'Pitch PID Gains': {key} = {}; {effect}",
            pitch.line,
            squid_auv::number(*value)
        );
        found.gain(("pitch", key), converted(*value, fins), &units(role), from);
    }
    if let Some(depth) = depth.filter(|depth| depth.values[0] > 0.0) {
        if depth.values[2] > 0.0 {
            found.left_out.extend(left_out(&source, DEPTH, |_| true, NO_DEPTH)?);
        } else {
            for ((key, role), value) in roles.into_iter().zip(&depth.values) {
                let from = format!("line {}, 'Depth PID Gains': {key}, rad/m", depth.line);
                found.gain(("depth", key), *value, &of_pitch(role), from);
            }
            found.notes.push(
                "[controller.depth] is for a design that tracks depth; remove it for one of pitch.".into(),
            );
        }
    }
    found.left_out.extend(unread(&source, &LEFT_OUT)?);
    if let Some((line, value)) = source.value("[Control.AUV.Attitude] Altitude Control -- Enabled")?
        && value.eq_ignore_ascii_case("true")
    {
        found.notes.push(format!(
            "'Altitude Control -- Enabled' (line {line}): kd acts on the rate of the error, in squid on that of \
             pitch: the loop is the same, a step of the reference is not."
        ));
    }
    if others {
        found.notes.push("Files that this one includes are not read: what they set stays unseen.".into());
    }
    Ok(found)
}

/// Writes the gains.
pub(crate) fn export(pid: &Pid, text: &str, file: &str, _: &Missing) -> Result<Export, FileError> {
    let plain = Plain::of(pid)?;
    plain.require(pid, Drive::Deflection, "DUNE commands fins")?;
    no_weight(pid)?;
    let (source, others) = source(text, file)?;
    let Read { pitch, depth, fins, .. } = read(&source, others)?;
    let mut notes = not_written(pid, false);
    let mut new = vec![(&pitch, plain.pitch.map(|gain| converted(gain, 1.0 / fins)).to_vec())];
    match (&depth, plain.depth) {
        (Some(depth), Some([kp, ki])) if depth.values[2] == 0.0 => new.push((depth, vec![kp, ki, 0.0])),
        (Some(depth), Some(_)) => {
            let found = format!("with kd = {}", squid_auv::number(depth.values[2]));
            return source.refuse(depth.line, DEPTH, found, format!("with kd = 0 here: {NO_DEPTH}"));
        }
        (None, Some(_)) => {
            source.required(DEPTH, 3, "[controller.depth] must be written to it")?;
        }
        (Some(depth), None) => {
            notes.push(format!("'Depth PID Gains' (line {}) stay as they are.", depth.line))
        }
        (None, None) => {}
    }
    let (text, changes) = source.replaced(&new);
    Ok(Export { text, changes, notes })
}
