//! DUNE of LSTS, Porto: `control.ini` of an AUV.
//!
//! `src/Control/AUV/Attitude/Task.cpp` and `DUNE/Control/DiscretePID.cpp` have the laws: a PID of pitch or of roll, and
//! a [`cascade`](crate::autopilots::cascade) of heading. `src/Control/AUV/Allocator` has the fins,
//! `DUNE/Parsers/Config.cpp` the format. The integral holds ki, which at constant gains is the same.

use crate::allocation::Drive;
use crate::angle::Angle;
use crate::autopilots::cascade::{cascade_of, law, pid_of};
use crate::autopilots::form::{
    Export, Import, LeftOut, Plain, Unread, left_out, no_weight, not_written, stay, unread,
};
use crate::autopilots::source::{Numbers, Source, converted, rounded};
use crate::file::Pid;
use crate::gain::{Role, of_pitch};
use squid_auv::toml_file::FileError;

/// Three gains each, and the moments of a fin, N m/rad.
const PITCH: &str = "[Control.AUV.Attitude] Pitch PID Gains";
const DEPTH: &str = "[Control.AUV.Attitude] Depth PID Gains";
const ROLL: &str = "[Control.AUV.Attitude] Roll PID Gains";
const HEADING: &str = "[Control.AUV.Attitude] Heading PID Gains";
const HEADING_RATE: &str = "[Control.AUV.Attitude] Heading Rate PID Gains";
const EFFECT_K: &str = "[Control.AUV.Allocator] Fin effect K";
const EFFECT_M: &str = "[Control.AUV.Allocator] Fin effect M";
const EFFECT_N: &str = "[Control.AUV.Allocator] Fin effect N";
const GAINS: [&str; 8] = [PITCH, DEPTH, ROLL, HEADING, HEADING_RATE, EFFECT_K, EFFECT_M, EFFECT_N];

/// What DUNE has for an angle.
struct Loop {
    angle: Angle,
    /// kp, ki and kd of the PID, or kp of the loop around that of the rate.
    gains: &'static str,
    /// kp and ki of the loop of the rate, if there is one.
    rate: Option<&'static str>,
    /// The moment in the allocator's source.
    moment: &'static str,
    /// The key of the moment of a fin, its default in the allocator's source, N m/rad, and how many fins share a moment.
    effect: (&'static str, f64, f64),
    /// Flags with which another law flies.
    flags: &'static [Flag],
    /// What has no counterpart.
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
            "false: the rate is otherwise not controlled",
        )],
        left_out: &[
            (
                "[Control.AUV.Attitude] Maximum Heading Rate",
                |_| true,
                "a limit of the wanted rate in deg/s; the autopilot of squid limits its reference by 'slope'",
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
                "true: the gains are otherwise not flown",
            ),
            (
                "[Control.AUV.Attitude] Roll Compensation -- Use Speed",
                |v| v == "false",
                "false: kp otherwise depends on the speed in a way of its own",
            ),
        ],
        left_out: &[
            ("[Control.AUV.Attitude] Roll Integral Limit", |v| v > 0.0, "a limit of the integral term, deg"),
            (
                "[Control.AUV.Attitude] Roll Compensation -- Offset Angle",
                |v| v != 0.0,
                "a reference of roll other than 0, deg",
            ),
        ],
    },
];

/// A flag: its key, whether a value of it, in small letters, leaves the law as it is, and what is allowed.
type Flag = (&'static str, fn(&str) -> bool, &'static str);

/// Flags with which another law flies, or may, whatever the angle.
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

/// What has no counterpart: the values that are worth a word, and the reason.
const LEFT_OUT_OF_PITCH: [Unread; 7] = [
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

const NO_ACCELERATION: &str =
    "kd of the rate acts on the acceleration: what these gains prove is the loop without it";

/// The numbers of a file.
struct Read {
    /// kp, ki and kd of the angle.
    turn: Numbers,
    /// Those of its rate, if it has a loop of its own.
    rate: Option<Numbers>,
    /// Those of the depth, beside pitch.
    depth: Option<Numbers>,
    /// The angle of the fins per moment of the law.
    fins: f64,
    /// That in words.
    effect: String,
}

impl Loop {
    fn of(angle: Angle) -> &'static Self {
        LOOPS.iter().find(|own| own.angle == angle).unwrap_or(&LOOPS[0])
    }

    /// Returns the law in words.
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

/// Returns the option of a key.
fn option(key: &str) -> &str {
    key.split_once("] ").map_or(key, |(_, option)| option)
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
                if let Some(plain) = GAINS.iter().find(|one| key.trim_end_matches(['+', '-']) == **one)
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
fn read(own: &Loop, source: &Source<'_>, others: bool) -> Result<Read, FileError> {
    let included =
        if others { "; files that this one includes are not read: name the one that has it" } else { "" };
    let meaning = |of: &str| format!("kp, ki and kd of {of}, as in etc/auv/control.ini of DUNE{included}");
    let turn = source.required(own.gains, 3, &meaning(own.angle.name()))?;
    source.above_zero(&turn, 0)?;
    let rate = own.rate.map(|key| source.required(key, 3, &meaning("its rate"))).transpose()?;
    if let Some(rate) = &rate {
        source.above_zero(rate, 0)?;
        if turn.values[1] > 0.0 || turn.values[2] > 0.0 {
            let found = format!("with ki = {} and kd = {}", turn.values[1], turn.values[2]);
            let allowed = "with ki = 0 and kd = 0, around the loop of the rate: the law is otherwise no PID";
            return source.refuse(turn.line, own.gains, found, allowed);
        }
    }
    for (key, is_good, allowed) in FLAGS.iter().chain(own.flags) {
        if let Some((line, value)) = source.value(key)?
            && !is_good(&value.to_lowercase())
        {
            return source.refuse(line, key, value, *allowed);
        }
    }
    let (key, default, count) = own.effect;
    let given = source.optional(key, 1)?;
    let (effect, said) = match &given {
        Some(numbers) => {
            source.above_zero(numbers, 0)?;
            (numbers.values[0], format!("line {}", numbers.line))
        }
        None if others => {
            let found = "not in this file, which includes others";
            let allowed = format!(
                "written in it, because the fins' angle is {}/({count} {}); in DUNE it is {default} unless a file sets \
                 another",
                own.moment,
                option(key)
            );
            return source.refuse(1, key, found, allowed);
        }
        None => (default, "the default of DUNE".into()),
    };
    let (share, moment) = (1.0 / (count * effect), own.moment);
    let effect = format!("fins = {moment}/({count} {}) ({}, {said})", squid_auv::number(effect), option(key));
    let depth = if own.angle == Angle::Pitch { source.optional(DEPTH, 3)? } else { None };
    Ok(Read { turn, rate, depth, fins: share, effect })
}

/// Reads the gains of an angle.
pub(crate) fn import(angle: Angle, text: &str, file: &str) -> Result<Import, FileError> {
    let (own, (source, others)) = (Loop::of(angle), source(text, file)?);
    let Read { turn, rate, depth, fins, effect } = read(own, &source, others)?;
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
                found.gain(("depth", key), *value, &of_pitch(role), from);
            }
            found.notes.push(
                "[controller.depth] is for a design that tracks depth; remove it for one of pitch.".into(),
            );
        }
    }
    found.left_out.extend(unread(&source, own.left_out)?);
    if angle == Angle::Pitch
        && let Some((line, value)) = source.value("[Control.AUV.Attitude] Altitude Control -- Enabled")?
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

/// Returns kd of the loop of a rate, which has no counterpart, unless it is 0.
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
    let (own, (source, others)) = (Loop::of(pid.turn.angle), source(text, file)?);
    let Read { turn, rate, depth, fins, .. } = read(own, &source, others)?;
    let mut notes = not_written(pid, false);
    let mut new = match &rate {
        Some(rate) => {
            let [ka, kp, ki] = cascade_of(pid, &plain, "DUNE")?;
            let [kp, ki] = [kp, ki].map(|gain| converted(gain, 1.0 / fins));
            notes.extend(stay(no_acceleration(rate).as_slice()));
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
        (Some(depth), None) => {
            notes.push(format!("'Depth PID Gains' (line {}) stay as they are.", depth.line))
        }
        (None, None) => {}
    }
    let (text, changes) = source.replaced(&new);
    Ok(Export { text, changes, notes })
}
