//! mvp_control of the University of Rhode Island: a YAML file with `control_modes`.
//!
//! Source of the law: `src/mvp_control/mimo_pid.cpp`, `u = p e + clip(int i e dt) + d e'`, all terms on the error.

use crate::allocation::Drive;
use crate::angle::Angle;
use crate::autopilots::form::{
    Export, Import, Missing, Plain, left_out, no_depth, no_weight, not_written, unchanged_notes,
};
use crate::autopilots::source::{Entry, Numbers, Source};
use crate::file::Pid;
use crate::gain::{Role, force_units};
use crate::refusal::{not_allowed, refused};
use saphyr_parser::{Event, Parser};
use squid_auv::toml_file::{FileError, FileProblem};

/// Gains of a degree of freedom: key in the file, key of `[controller]`, and role.
const KEYS: [(&str, &str, Role); 3] =
    [("p", "kp", Role::Proportional), ("i", "ki", Role::Integral), ("d", "kd", Role::Derivative)];
const LIMITS: [&str; 2] = ["i_max", "i_min"];
const SURGE: &str = "surge";

/// Returns the degree of freedom of an angle.
const fn freedom(angle: Angle) -> &'static str {
    match angle {
        Angle::Pitch => "pitch",
        Angle::Heading => "yaw",
        Angle::Roll => "roll",
    }
}

/// Returns the law as text.
fn law(angle: Angle) -> Vec<String> {
    let surge = if angle == Angle::Pitch { " speed error -> force along the hull;" } else { "" };
    vec![
        format!("Loop order: {angle} error -> {angle} command;{surge} angles in rad."),
        format!("u = p e + int i e dt + d e', e = r - {}", angle.symbols()[0]),
        format!("In squid kd acts on the rate of {angle}: same loop, another response to a reference step."),
    ]
}

const LIMIT: &str = "a limit of the integral term";
const NO_SPEED: &str = "the speed loop of squid requires p";
const NO_RATE: &str = "the speed loop of squid has no derivative; the proof is for the loop without it";

/// An open mapping or sequence of YAML.
enum Open {
    /// A mapping with the key whose value comes next.
    Mapping(Option<String>),
    /// A sequence, whose contents are ignored.
    Sequence,
}

/// Reads every value of a mapping; its key is the path of keys, joined by dots.
fn source<'a>(text: &'a str, file: &'a str) -> Result<Source<'a>, FileError> {
    let mut source = Source::new(text, file);
    let starts: Vec<usize> = text.char_indices().map(|(at, _)| at).collect();
    let mut open: Vec<Open> = vec![];
    for event in Parser::new_from_str(text) {
        let (event, span) = event.map_err(|error| {
            let found = format!("invalid YAML: {}", error.info());
            not_allowed(file, error.marker().line(), "control_modes", found, "a YAML mapping")
        })?;
        let (is_key, path) = match open.last() {
            Some(Open::Mapping(None)) => (true, None),
            Some(Open::Mapping(Some(_))) => (false, path(&open)),
            _ => (false, None),
        };
        match event {
            Event::Scalar(value, ..) if is_key => {
                if let Some(Open::Mapping(key)) = open.last_mut() {
                    *key = Some(value.into_owned());
                }
                continue;
            }
            Event::Scalar(value, ..) => {
                let begin = starts.get(span.start.index()).copied().unwrap_or(text.len());
                // A quoted or multi-line scalar is not a number; only messages show it.
                let size = if text[begin..].starts_with(&*value) { value.len() } else { 0 };
                if let Some(key) = path {
                    let rest = &text[begin..];
                    source.push(key, span.start.line(), begin, rest, &rest[..size]);
                }
            }
            Event::MappingStart(..) => {
                open.push(Open::Mapping(None));
                continue;
            }
            Event::SequenceStart(..) => {
                open.push(Open::Sequence);
                continue;
            }
            Event::MappingEnd | Event::SequenceEnd => {
                open.pop();
            }
            Event::Alias(_) => {}
            _ => continue,
        }
        // End of a value.
        if let Some(Open::Mapping(key)) = open.last_mut() {
            *key = None;
        }
    }
    Ok(source)
}

/// Returns the path of keys of the open mappings; `None` inside a sequence.
fn path(open: &[Open]) -> Option<String> {
    let keys = open.iter().map(|one| match one {
        Open::Mapping(key) => key.clone(),
        Open::Sequence => None,
    });
    Some(keys.collect::<Option<Vec<_>>>()?.join("."))
}

/// Numbers read from a control mode.
struct Read {
    /// Path of the mode.
    mode: String,
    turn: [Option<Numbers>; 3],
    /// Surge gains, for pitch only; all three are `None` for another angle.
    surge: [Option<Numbers>; 3],
    drive: Drive,
}

/// Returns the modes that have gains of a degree of freedom: path and name.
fn modes(source: &Source<'_>, freedom: &str) -> Vec<(String, String)> {
    let mut all: Vec<(String, String)> = vec![];
    for Entry { key, .. } in &source.entries {
        let Some((before, rest)) = key.split_once("control_modes.") else { continue };
        if let [mode, own, _] = rest.split('.').collect::<Vec<_>>()[..]
            && own == freedom
        {
            let one = (format!("{before}control_modes.{mode}"), mode.to_owned());
            if !all.contains(&one) {
                all.push(one);
            }
        }
    }
    all
}

/// Reads the numbers that import and export need.
fn read(source: &Source<'_>, angle: Angle, missing: &Missing) -> Result<Read, FileError> {
    let own = freedom(angle);
    let all = modes(source, own);
    let is_selected = |(_, name): &&(String, String)| missing.mode.as_ref().is_none_or(|mode| mode == name);
    let chosen: Vec<&(String, String)> = all.iter().filter(is_selected).collect();
    let names: Vec<&str> = all.iter().map(|(_, name)| name.as_str()).collect();
    let mode = match (&chosen[..], &missing.mode) {
        ([(key, _)], _) => key.clone(),
        ([], Some(mode)) if !all.is_empty() => {
            let found = format!("without {own} in the mode '{mode}'");
            return source.refuse(1, "control_modes", found, format!("--mode of {}", names.join(", ")));
        }
        ([], _) => {
            let key = format!("control_modes.MODE.{own}");
            let meaning = format!("p, i and d of {own} in a mode of mvp");
            return Err(refused(source.file, 1, FileProblem::MissingKey { key, meaning }));
        }
        _ => {
            let found = format!("of {} modes with {own}", chosen.len());
            return source.refuse(
                1,
                "control_modes",
                found,
                format!("chosen by --mode: {}", names.join(", ")),
            );
        }
    };
    let kp = format!("{mode}.{own}.{}", KEYS[0].0);
    source.require_positive(&source.required(&kp, 1, &format!("the gain on the {angle} error"))?, 0)?;
    let gains = |freedom: &str| {
        let mut found = [None, None, None];
        for (one, (key, ..)) in found.iter_mut().zip(KEYS) {
            *one = source.optional(&format!("{mode}.{freedom}.{key}"), 1)?;
        }
        Ok::<_, FileError>(found)
    };
    let turn = gains(own)?;
    let surge = if angle == Angle::Pitch { gains(SURGE)? } else { [None, None, None] };
    let Some(drive) = missing.drive else {
        let found = format!("in the unit of the {angle} command, which the file does not contain");
        let line = turn[0].as_ref().map_or(1, |kp| kp.line);
        let allowed = "accompanied by --unit N.m for thrusters, or --unit rad for control surfaces";
        return source.refuse(line, &kp, found, allowed);
    };
    Ok(Read { mode, turn, surge, drive })
}

/// Refuses an integral gain whose limits hold the integral at 0; an absent limit is 0.
fn check_integral_limits(source: &Source<'_>, mode: &str, freedom: &str, ki: f64) -> Result<(), FileError> {
    let key = format!("{mode}.{freedom}.{}", KEYS[1].0);
    let mut limits = [0.0; 2];
    for (limit, name) in limits.iter_mut().zip(LIMITS) {
        let given = source.value(&format!("{mode}.{freedom}.{name}"))?;
        *limit = given.and_then(|(_, value)| value.parse().ok()).unwrap_or(0.0);
    }
    let [high, low] = limits;
    if ki == 0.0 || (high > 0.0 && low < 0.0) {
        return Ok(());
    }
    let line = source.value(&key)?.map_or(1, |(line, _)| line);
    let found = format!("{} with i_max {high} and i_min {low}", squid_auv::number(ki));
    source.refuse(
        line,
        &key,
        found,
        "0 (the default), or i_max must be above and i_min below 0, because mvp clamps the integral to these",
    )
}

/// Returns `true` if a value is worth reporting.
const SET: fn(f64) -> bool = |value| value != 0.0;

/// Reads the gains.
pub(crate) fn import(angle: Angle, text: &str, file: &str, missing: &Missing) -> Result<Import, FileError> {
    let source = source(text, file)?;
    let Read { mode, turn, surge, drive } = read(&source, angle, missing)?;
    let own = freedom(angle);
    for (freedom, gains) in [(own, &turn), (SURGE, &surge)] {
        check_integral_limits(&source, &mode, freedom, gains[1].as_ref().map_or(0.0, |ki| ki.values[0]))?;
    }
    let mut found = Import::new(angle, law(angle));
    for (numbers, (_, key, role)) in turn.iter().zip(KEYS) {
        if let Some(Numbers { key: own, line, values, .. }) = numbers {
            found.gain(
                (angle.name(), key),
                values[0],
                &drive.units(role),
                format!("line {line}, '{own}', not converted"),
            );
        }
    }
    let has_speed = surge[0].as_ref().is_some_and(|kp| kp.values[0] > 0.0);
    for (numbers, (_, key, role)) in surge.iter().zip(KEYS).take(2).filter(|_| has_speed) {
        if let Some(Numbers { key: own, line, values, .. }) = numbers {
            let from = format!("line {line}, '{own}', not converted: N of all thrusters along the hull");
            found.gain(("speed", key), values[0], &force_units(role), from);
        }
    }
    for limit in LIMITS {
        found.left_out.extend(left_out(&source, &format!("{mode}.{own}.{limit}"), SET, LIMIT)?);
    }
    if angle != Angle::Pitch {
        return Ok(found);
    }
    if !has_speed {
        found.left_out.extend(left_out(&source, &format!("{mode}.{SURGE}.i"), SET, NO_SPEED)?);
    }
    for limit in LIMITS {
        found.left_out.extend(left_out(&source, &format!("{mode}.{SURGE}.{limit}"), SET, LIMIT)?);
    }
    found.left_out.extend(left_out(&source, &format!("{mode}.{SURGE}.d"), SET, NO_RATE)?);
    Ok(found)
}

/// Writes the gains.
pub(crate) fn export(pid: &Pid, text: &str, file: &str, missing: &Missing) -> Result<Export, FileError> {
    let plain = Plain::of(pid)?;
    no_weight(pid)?;
    no_depth(pid, "the depth loop of mvp is separate, from depth to a force")?;
    let source = source(text, file)?;
    let Read { mode, turn, surge, drive } = read(&source, pid.turn.angle, missing)?;
    plain.require(pid, drive, "this is the --unit given for the file")?;
    let mut new = vec![];
    let mut write = |numbers: &'_ [Option<Numbers>; 3], freedom: &str, gains: &[f64]| {
        check_integral_limits(&source, &mode, freedom, gains[1])?;
        for ((numbers, (key, ..)), gain) in numbers.iter().zip(KEYS).zip(gains) {
            match numbers {
                Some(numbers) => new.push((numbers.clone(), vec![*gain])),
                None if *gain > 0.0 => {
                    source.required(&format!("{mode}.{freedom}.{key}"), 1, "a gain must be written to it")?;
                }
                None => {}
            }
        }
        Ok::<_, FileError>(())
    };
    write(&turn, freedom(pid.turn.angle), &plain.turn)?;
    let writes_speed = plain.speed.is_some() && surge[0].is_some();
    if let (Some(gains), Some(speed), true) = (plain.speed, &pid.speed, writes_speed) {
        if speed.reference_weight != 0.0 || speed.rolloff > 0.0 {
            let allowed = "without reference_weight and rolloff, because mvp has no such parameters";
            return Err(not_allowed(&pid.file, speed.line, "controller.speed", "given", allowed));
        }
        write(&surge, SURGE, &gains)?;
    }
    let mut notes = not_written(pid, writes_speed);
    if pid.turn.angle == Angle::Pitch {
        notes.extend(unchanged_notes(
            left_out(&source, &format!("{mode}.{SURGE}.d"), SET, NO_RATE)?.as_slice(),
        ));
    }
    let new: Vec<(&Numbers, Vec<f64>)> =
        new.iter().map(|(numbers, gains)| (numbers, gains.clone())).collect();
    let (text, changes) = source.replaced(&new);
    Ok(Export { text, changes, notes })
}
