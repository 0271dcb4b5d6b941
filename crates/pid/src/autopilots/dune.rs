//! DUNE of LSTS, Porto: `control.ini` of an AUV.
//!
//! Source of the laws: `src/Control/AUV/Attitude/Task.cpp` and `DUNE/Control/DiscretePID.cpp`, a PID of pitch or of
//! roll, and a [`cascade`](crate::autopilots::cascade) of heading. Source of the fins: `src/Control/AUV/Allocator`; of
//! the file format: `DUNE/Parsers/Config.cpp`. DUNE integrates ki times the error, which for constant gains equals ki
//! times the integral.

use crate::allocation::Drive;
use crate::angle::Angle;
use crate::autopilots::cascade::{cascade_of, law, pid_of};
use crate::autopilots::form::{
    Export, Import, LeftOut, Plain, Unread, left_out, no_weight, not_written, unchanged_notes, unread,
};
use crate::autopilots::source::{Numbers, Source, converted, rounded};
use crate::file::Pid;
use crate::gain::{Role, pitch_units};
use squid_auv::toml_file::FileError;

/// Keys of three gains each, and of the moment of a fin, N m/rad.
const PITCH: &str = "[Control.AUV.Attitude] Pitch PID Gains";
const DEPTH: &str = "[Control.AUV.Attitude] Depth PID Gains";
const ROLL: &str = "[Control.AUV.Attitude] Roll PID Gains";
const HEADING: &str = "[Control.AUV.Attitude] Heading PID Gains";
const HEADING_RATE: &str = "[Control.AUV.Attitude] Heading Rate PID Gains";
const EFFECT_K: &str = "[Control.AUV.Allocator] Fin effect K";
const EFFECT_M: &str = "[Control.AUV.Allocator] Fin effect M";
const EFFECT_N: &str = "[Control.AUV.Allocator] Fin effect N";
const GAINS: [&str; 8] = [PITCH, DEPTH, ROLL, HEADING, HEADING_RATE, EFFECT_K, EFFECT_M, EFFECT_N];

/// Keys and law of DUNE for an angle.
struct Loop {
    angle: Angle,
    /// Key of kp, ki and kd of the PID, or of kp of the outer loop of a cascade.
    gains: &'static str,
    /// Key of kp and ki of the rate loop, if there is one.
    rate: Option<&'static str>,
    /// Symbol of the moment in the allocator's source.
    moment: &'static str,
    /// Key of the moment of a fin, its default in the allocator's source, N m/rad, and the number of fins that share
    /// the moment.
    effect: (&'static str, f64, f64),
    /// Flags that would change the law.
    flags: &'static [Flag],
    /// Keys without counterpart in `[controller]`.
    left_out: &'static [Unread],
}

const LOOPS: [Loop; 3] = [
    Loop {
        angle: Angle::Pitch,
        gains: PITCH,
        rate: None,
        moment: "m",
        effect: (EFFECT_M, 0.5, 2.0),
        flags: &[],
        left_out: &LEFT_OUT_OF_PITCH,
    },
    Loop {
        angle: Angle::Heading,
        gains: HEADING,
        rate: Some(HEADING_RATE),
        moment: "n",
        effect: (EFFECT_N, 0.5, 2.0),
        flags: &[(
            "[Control.AUV.Attitude] Heading Rate Open Loop",
            |v| v == "false",
            "false, because otherwise the rate is not controlled",
        )],
        left_out: &[
            (
                "[Control.AUV.Attitude] Maximum Heading Rate",
                |_| true,
                "a limit of the rate reference in deg/s; the autopilot of squid limits its reference by 'slope'",
            ),
            (
                "[Control.AUV.Attitude] Heading Rate Integral Limit",
                |v| v > 0.0,
                "a limit of the integral term",
            ),
        ],
    },
    Loop {
        angle: Angle::Roll,
        gains: ROLL,
        rate: None,
        moment: "k",
        effect: (EFFECT_K, 0.25, 4.0),
        flags: &[
            (
                "[Control.AUV.Attitude] Enable roll controller",
                |v| v == "true",
                "true, because otherwise the gains are not used",
            ),
            (
                "[Control.AUV.Attitude] Roll Compensation -- Use Speed",
                |v| v == "false",
                "false, because otherwise kp depends on the speed",
            ),
        ],
        left_out: &[
            ("[Control.AUV.Attitude] Roll Integral Limit", |v| v > 0.0, "a limit of the integral term, deg"),
            (
                "[Control.AUV.Attitude] Roll Compensation -- Offset Angle",
                |v| v != 0.0,
                "a nonzero roll reference, deg",
            ),
        ],
    },
];

/// A flag: its key, a test that its value, in lower case, leaves the law unchanged, and the allowed value.
type Flag = (&'static str, fn(&str) -> bool, &'static str);

/// Flags that change, or may change, the law of every angle.
const FLAGS: [Flag; 4] = [
    (
        "[Control.AUV.Attitude] Enabled",
        |v| v != "never",
        "anything but Never, because otherwise the gains are not \
        used",
    ),
    (
        "[Control.AUV.Attitude] Error Attitude Compensation",
        |v| v == "false",
        "false, because otherwise the attitude error is the command",
    ),
    (
        "[Control.AUV.Allocator] Fin effect Velocity dependent",
        |v| v == "false",
        "false, because otherwise the gain to the fins depends on the speed",
    ),
    (
        "[Control.AUV.LMI] Enabled",
        |v| v == "never",
        "Never, because otherwise that task may command the fins",
    ),
];

/// Keys without counterpart: a test that the value is worth reporting, and the reason.
const LEFT_OUT_OF_PITCH: [Unread; 7] = [
    (
        "[Control.AUV.Attitude] Maximum Pitch Actuation",
        |_| true,
        "a limit of m in deg; squid uses the limits of the vehicle",
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
        "the depth loop runs at a lower rate than the pitch loop",
    ),
    ("[Control.AUV.Attitude] Altitude PID Gains", |_| true, "squid has no altitude loop"),
    (
        "[Control.AUV.Speed] MPS PID Gains",
        |_| true,
        "they command revolutions, and the file does not contain the resulting thrust in N",
    ),
    (
        "[Control.AUV.Speed] RPMs PID Gains",
        |_| true,
        "they command a fraction of the thrust, and the file does not contain the thrust in N",
    ),
];

const NO_DEPTH: &str = "squid's depth loop has no kd on the vertical speed, so the depth loop is omitted; prove \
                        pitch alone, or set this kd to 0";

const NO_ACCELERATION: &str = "kd of the rate acts on the acceleration; the proof is for the loop without it";

/// Numbers read from a file.
struct Read {
    /// kp, ki and kd of the angle.
    turn: Numbers,
    /// Gains of the rate loop, if there is one.
    rate: Option<Numbers>,
    /// Gains of the depth loop, for pitch only.
    depth: Option<Numbers>,
    /// Fin angle per unit of the law's moment.
    fins: f64,
    /// The same conversion as text.
    effect: String,
}

impl Loop {
    fn of(angle: Angle) -> &'static Self {
        LOOPS.iter().find(|own| own.angle == angle).unwrap_or(&LOOPS[0])
    }

    /// Returns the law as text.
    fn law(&self) -> Vec<String> {
        let (Self { angle, moment, effect: (effect, _, fins), .. }, [x, rate]) = (self, self.angle.symbols());
        let share = format!("fins = {moment}/({fins} {}), {fins} of them", option(effect));
        if let Some(key) = self.rate {
            let [outer, inner] = [self.gains, key].map(option);
            let keys = [format!("kp of {outer}"), format!("kp of {inner}"), "ki of these".to_owned()];
            let mut lines = law(
                *angle,
                [&keys[0], &keys[1], &keys[2]],
                &format!("output {moment} -> fins; angles in rad"),
            );
            lines.push(share);
            return lines;
        }
        let mut lines = match angle {
            Angle::Pitch => vec![
                "Loop order: depth error -> pitch reference r -> pitch error -> m -> fins; angles in rad."
                    .into(),
                "m = kp (r - theta) + ki int (r - theta) dt - kd (q cos phi - r sin phi)".into(),
                "r = -(kp (z_r - z) + ki int (z_r - z) dt - kd z'), of Depth PID Gains".into(),
            ],
            _ => vec![
                format!("Loop order: {angle} error -> {moment} -> fins; angles in rad."),
                format!("{moment} = kp (r - {x}) + ki int (r - {x}) dt - kd {rate}"),
            ],
        };
        lines.insert(2, share);
        lines
    }
}

/// Returns the option of a key, without its section.
fn option(key: &str) -> &str {
    key.split_once("] ").map_or(key, |(_, option)| option)
}

/// Reads sections and options, including values continued on the next line; the flag is `true` if the file includes
/// other files.
fn source<'a>(text: &'a str, file: &'a str) -> Result<(Source<'a>, bool), FileError> {
    let (mut source, mut section, mut has_includes, mut open) = (Source::new(text, file), None, false, false);
    for (line, begin, whole) in source.lines() {
        let trimmed = whole.trim();
        if trimmed.is_empty() || trimmed.starts_with([';', '#']) {
            continue;
        }
        if let Some(name) = trimmed.strip_prefix('[').and_then(|rest| rest.split(']').next()) {
            has_includes |= ["Include ", "Require "].iter().any(|kind| name.starts_with(kind));
            (section, open) = (Some(name.trim()), false);
            continue;
        }
        let code = whole.split([';', '|', '#']).next().unwrap_or(whole);
        match (whole.split_once('='), section) {
            (Some((option, _)), Some(section)) => {
                let option = option.split('{').next().unwrap_or(option).trim();
                let value = code.split_once('=').map_or("", |(_, value)| value).trim();
                let key = format!("[{section}] {option}");
                if let Some(plain) = GAINS.iter().find(|one| key.trim_end_matches(['+', '-']) == **one)
                    && key != **plain
                {
                    return source.refuse(
                        line,
                        plain,
                        format!("modified by '{option}'"),
                        "set completely by '='",
                    );
                }
                source.push(key, line, begin, whole, value);
                open = true;
            }
            (None, Some(_)) if open => source.extend(begin, whole, code.trim()),
            _ => {}
        }
    }
    Ok((source, has_includes))
}

/// Reads the numbers that import and export need.
fn read(own: &Loop, source: &Source<'_>, has_includes: bool) -> Result<Read, FileError> {
    let included =
        if has_includes { "; included files are not read: give the file that contains it" } else { "" };
    let meaning = |of: &str| format!("kp, ki and kd of {of}, as in etc/auv/control.ini of DUNE{included}");
    let turn = source.required(own.gains, 3, &meaning(own.angle.name()))?;
    source.require_positive(&turn, 0)?;
    let rate = own.rate.map(|key| source.required(key, 3, &meaning("its rate"))).transpose()?;
    if let Some(rate) = &rate {
        source.require_positive(rate, 0)?;
        if turn.values[1] > 0.0 || turn.values[2] > 0.0 {
            let found = format!("with ki = {} and kd = {}", turn.values[1], turn.values[2]);
            let allowed = "combined with ki = 0 and kd = 0 around the rate loop, because otherwise the law is not a \
                PID";
            return source.refuse(turn.line, own.gains, found, allowed);
        }
    }
    for (key, is_allowed, allowed) in FLAGS.iter().chain(own.flags) {
        if let Some((line, value)) = source.value(key)?
            && !is_allowed(&value.to_lowercase())
        {
            return source.refuse(line, key, value, *allowed);
        }
    }
    let (key, default, count) = own.effect;
    let given = source.optional(key, 1)?;
    let (effect, origin) = match &given {
        Some(numbers) => {
            source.require_positive(numbers, 0)?;
            (numbers.values[0], format!("line {}", numbers.line))
        }
        None if has_includes => {
            let found = "missing in this file, which includes others";
            let allowed = format!(
                "given in it, because the angle of the fins is {}/({count} {}); the default of DUNE is {default}",
                own.moment,
                option(key)
            );
            return source.refuse(1, key, found, allowed);
        }
        None => (default, "the default of DUNE".into()),
    };
    let (share, moment) = (1.0 / (count * effect), own.moment);
    let effect =
        format!("fins = {moment}/({count} {}) ({}, {origin})", squid_auv::number(effect), option(key));
    let depth = if own.angle == Angle::Pitch { source.optional(DEPTH, 3)? } else { None };
    Ok(Read { turn, rate, depth, fins: share, effect })
}

/// Reads the gains of an angle.
pub(crate) fn import(angle: Angle, text: &str, file: &str) -> Result<Import, FileError> {
    let (own, (source, has_includes)) = (Loop::of(angle), source(text, file)?);
    let Read { turn, rate, depth, fins, effect } = read(own, &source, has_includes)?;
    let mut found = Import::new(angle, own.law());
    let units = |role| Drive::Deflection.units(role);
    let roles = [("kp", Role::Proportional), ("ki", Role::Integral), ("kd", Role::Derivative)];
    let one = |numbers: &Numbers, key: &str, value: f64| {
        format!("line {}, '{}': {key} = {}", numbers.line, option(&numbers.key), squid_auv::number(value))
    };
    if let Some(rate) = &rate {
        let gains = [turn.values[0], rate.values[0], rate.values[1]];
        let all = [one(&turn, "ka", gains[0]), one(rate, "kp", gains[1]), one(rate, "ki", gains[2])];
        let from = format!("{}; {effect}", all.join(", "));
        let (pid, weight) = pid_of(gains);
        for ((key, role), value) in roles.into_iter().zip(pid) {
            found.gain((angle.name(), key), rounded(value * fins), &units(role), from.clone());
        }
        if gains[2] > 0.0 {
            found.gain(
                (angle.name(), "reference_weight"),
                rounded(weight),
                &[],
                "b = kp ka/(kp ka + ki)".into(),
            );
        }
        found.left_out.extend(no_acceleration(rate));
    } else {
        for ((key, role), value) in roles.into_iter().zip(&turn.values) {
            let from = format!("{}; {effect}", one(&turn, key, *value));
            found.gain((angle.name(), key), converted(*value, fins), &units(role), from);
        }
    }
    if let Some(depth) = depth.filter(|depth| depth.values[0] > 0.0) {
        if depth.values[2] > 0.0 {
            found.left_out.extend(left_out(&source, DEPTH, |_| true, NO_DEPTH)?);
        } else {
            for ((key, role), value) in roles.into_iter().zip(&depth.values) {
                let from = format!("line {}, 'Depth PID Gains': {key}, rad/m", depth.line);
                found.gain(("depth", key), *value, &pitch_units(role), from);
            }
            found.further.push(
                "[controller.depth] is for a design that tracks depth; remove it for one that tracks pitch."
                    .into(),
            );
        }
    }
    found.left_out.extend(unread(&source, own.left_out)?);
    if angle == Angle::Pitch
        && let Some((line, value)) = source.value("[Control.AUV.Attitude] Altitude Control -- Enabled")?
        && value.eq_ignore_ascii_case("true")
    {
        found.further.push(format!(
            "'Altitude Control -- Enabled' (line {line}): kd acts on the rate of the error, in squid on the pitch \
             rate: the loop is the same, the response to a reference step differs."
        ));
    }
    if has_includes {
        found.further.push("Included files are not read, and their settings are not considered.".into());
    }
    Ok(found)
}

/// Reports kd of the rate loop, which has no counterpart, unless it is 0.
fn no_acceleration(rate: &Numbers) -> Option<LeftOut> {
    let value = rate.values.iter().copied().map(squid_auv::number).collect::<Vec<_>>().join(", ");
    (rate.values[2] > 0.0).then(|| LeftOut {
        line: rate.line,
        key: rate.key.clone(),
        value,
        why: NO_ACCELERATION,
    })
}

/// Writes the gains.
pub(crate) fn export(pid: &Pid, text: &str, file: &str) -> Result<Export, FileError> {
    let plain = Plain::of(pid)?;
    plain.require(pid, Drive::Deflection, "DUNE commands fins")?;
    let (own, (source, has_includes)) = (Loop::of(pid.turn.angle), source(text, file)?);
    let Read { turn, rate, depth, fins, .. } = read(own, &source, has_includes)?;
    let mut notes = not_written(pid, false);
    let mut new = match &rate {
        Some(rate) => {
            let [ka, kp, ki] = cascade_of(pid, &plain, "DUNE")?;
            let [kp, ki] = [kp, ki].map(|gain| converted(gain, 1.0 / fins));
            notes.extend(unchanged_notes(no_acceleration(rate).as_slice()));
            vec![(&turn, vec![rounded(ka), 0.0, 0.0]), (rate, vec![kp, ki, rate.values[2]])]
        }
        None => {
            no_weight(pid)?;
            vec![(&turn, plain.turn.map(|gain| converted(gain, 1.0 / fins)).to_vec())]
        }
    };
    match (&depth, plain.depth) {
        (Some(depth), Some([kp, ki])) if depth.values[2] == 0.0 => new.push((depth, vec![kp, ki, 0.0])),
        (Some(depth), Some(_)) => {
            let found = format!("with kd = {}", squid_auv::number(depth.values[2]));
            return source.refuse(depth.line, DEPTH, found, format!("with kd = 0 here: {NO_DEPTH}"));
        }
        (None, Some(_)) => {
            source.required(DEPTH, 3, "[controller.depth] must be written to it")?;
        }
        (Some(depth), None) => notes.push(format!("'Depth PID Gains' (line {}) are unchanged.", depth.line)),
        (None, None) => {}
    }
    let (text, changes) = source.replaced(&new);
    Ok(Export { text, changes, notes })
}
