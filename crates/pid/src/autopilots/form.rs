//! Gains of an autopilot in the form of `[controller]` with their origin, and the gains of a `[controller]` as numbers
//! in SI.

use crate::allocation::Drive;
use crate::angle::Angle;
use crate::autopilots::source::{Change, Source, decimal};
use crate::file::Pid;
use crate::gain::{Given, Law, Role, Unit, force_units, pitch_units};
use crate::refusal::not_allowed;
use squid_auv::toml_file::FileError;

/// Data that an autopilot's file does not contain.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Missing {
    /// ArduSub: moment about the axis of the angle at output 1, N m.
    pub full_output: Option<f64>,
    /// Hint at that moment for the error if it is not given.
    pub hint: Option<String>,
    /// mvp: `Deflection` or `Moment`, the kind of the angle's command.
    pub drive: Option<Drive>,
    /// mvp: name of the control mode.
    pub mode: Option<String>,
}

/// An imported gain of `[controller]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Imported {
    /// Table of the gain: the angle, `depth` or `speed`.
    pub table: &'static str,
    /// Key in that table.
    pub key: &'static str,
    /// Value in `unit`.
    pub value: f64,
    /// Unit; `None` for a weight.
    pub unit: Option<&'static str>,
    /// Origin of the value: line, key and conversion.
    pub source: String,
}

/// A value of a file that has no counterpart in `[controller]`.
#[derive(Debug, Clone, PartialEq)]
pub struct LeftOut {
    /// Line in the file.
    pub line: usize,
    /// Key in the file.
    pub key: String,
    /// Text of the value.
    pub value: String,
    /// Reason why it is left out.
    pub why: &'static str,
}

/// Gains and notes read from the file of an autopilot.
#[derive(Debug, Clone, PartialEq)]
pub struct Import {
    /// The angle.
    pub angle: Angle,
    /// Law of the autopilot with the order of its loops, one line each.
    pub law: Vec<String>,
    /// The gains.
    pub gains: Vec<Imported>,
    /// Values without counterpart in `[controller]`.
    pub left_out: Vec<LeftOut>,
    /// Further notes.
    pub further: Vec<String>,
}

/// A file of an autopilot with new gains.
#[derive(Debug, Clone, PartialEq)]
pub struct Export {
    /// New text of the file.
    pub text: String,
    /// Replaced numbers.
    pub changes: Vec<Change>,
    /// Values that stay in the file, and parts of `[controller]` that were not written.
    pub notes: Vec<String>,
}

/// Note on a missing `[controller.speed]`.
const NO_SPEED: &str = "The file has no gains from speed to thrust: a design that tracks the speed also needs \
                        [controller.speed].";

/// Note on the trim, which squid adds to the law.
const TRIM: &str = "Squid adds the trim of the actuators at each speed. The autopilot does not: its integrator must \
                    provide the trim, and without an integrator a steady error remains.";

impl Import {
    /// Starts an import with the law alone.
    pub(crate) fn new(angle: Angle, law: Vec<String>) -> Self {
        Self { angle, law, gains: vec![], left_out: vec![], further: vec![] }
    }

    /// Adds a gain in the first of the allowed units, unless it is 0: a zero gain is absent.
    pub(crate) fn gain(
        &mut self,
        (table, key): (&'static str, &'static str),
        value: f64,
        units: &[Unit],
        source: String,
    ) {
        if value != 0.0 {
            self.gains.push(Imported { table, key, value, unit: units.first().map(|unit| unit.0), source });
        }
    }

    /// Returns everything worth reporting besides the gains, one sentence each.
    pub fn notes(&self) -> Vec<String> {
        let left = |LeftOut { line, key, value, why }: &LeftOut| {
            format!("Omitted: {key} = {value} (line {line}): {why}.")
        };
        let speed = self.gains.iter().any(|gain| gain.table == "speed");
        let pitches = self.angle == Angle::Pitch;
        let speed = (pitches && !speed).then(|| NO_SPEED.to_owned());
        let all = self.left_out.iter().map(left).chain(self.further.iter().cloned());
        all.chain(speed).chain(pitches.then(|| TRIM.to_owned())).collect()
    }

    /// Returns the gains as a file for `squid prove --controller`.
    pub fn toml(&self, file: &str) -> String {
        let mut lines = vec![format!("# Gains of {file}, read by `squid gains import`."), "#".into()];
        lines.extend(self.law.iter().map(|line| format!("#   {line}").trim_end().to_owned()));
        for note in self.notes() {
            lines.push("#".into());
            lines.extend(comment(&note));
        }
        lines.extend([String::new(), "[controller]".into(), "kind = \"pid\"".into()]);
        let mut table = "";
        for Imported { table: own, key, value, unit, source } in &self.gains {
            if *own != table {
                lines.extend([String::new(), format!("[controller.{own}]")]);
                table = own;
            }
            lines.extend(comment(source));
            let value = decimal(*value);
            lines.push(match unit {
                Some(unit) => format!("{key} = {{ value = {value}, unit = \"{unit}\" }}"),
                None => format!("{key} = {value}"),
            });
        }
        if self.angle == Angle::Pitch && !self.gains.iter().any(|gain| gain.table == "speed") {
            lines.push(String::new());
            lines.extend(SPEED.map(|line| format!("# {line}")));
        }
        lines.join("\n") + "\n"
    }
}

/// A key without counterpart: the key, a test that its value is worth reporting, and the reason.
pub(crate) type Unread<K = &'static str> = (K, fn(f64) -> bool, &'static str);

/// Returns the values of a file that have no counterpart.
pub(crate) fn unread<K: AsRef<str>>(
    source: &Source<'_>,
    keys: &[Unread<K>],
) -> Result<Vec<LeftOut>, FileError> {
    let found = keys.iter().map(|(key, keep, why)| left_out(source, key.as_ref(), *keep, why));
    Ok(found.collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect())
}

/// Returns the value of a key without counterpart, if it is present and worth reporting.
pub(crate) fn left_out(
    source: &Source<'_>,
    key: &str,
    keep: fn(f64) -> bool,
    why: &'static str,
) -> Result<Option<LeftOut>, FileError> {
    let found = source.value(key)?.filter(|(_, value)| value.parse().map_or(true, keep));
    Ok(found.map(|(line, value)| LeftOut { line, key: key.to_owned(), value, why }))
}

/// Returns notes that these values stay unchanged in the exported file.
pub(crate) fn unchanged_notes(all: &[LeftOut]) -> Vec<String> {
    all.iter()
        .map(|LeftOut { line, key, value, why }| {
            format!("{key} = {value} (line {line}) is unchanged: {why}.")
        })
        .collect()
}

/// Template of the table that the user has to fill in.
const SPEED: [&str; 3] =
    ["[controller.speed]", "kp = { value = , unit = \"N.s/m\" }", "ki = { value = , unit = \"N/m\" }"];

/// Line width of a comment.
const COLUMNS: usize = 100;

/// Wraps text to comment lines.
fn comment(text: &str) -> Vec<String> {
    let mut lines = vec![String::from("#")];
    for word in text.split_whitespace() {
        let last = lines.len() - 1;
        if lines[last].len() + word.len() + 1 > COLUMNS && lines[last] != "#" {
            lines.push(format!("#   {word}"));
        } else {
            lines[last] += " ";
            lines[last] += word;
        }
    }
    lines
}

/// Gains of a `[controller]` as numbers in SI; 0 if left out.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Plain {
    /// Kind of the angle's command.
    pub(crate) drive: Drive,
    /// kp, ki and kd of the angle.
    pub(crate) turn: [f64; 3],
    /// kp and ki of depth.
    pub(crate) depth: Option<[f64; 2]>,
    /// kp and ki of speed.
    pub(crate) speed: Option<[f64; 2]>,
}

impl Plain {
    /// Converts the gains if an autopilot can represent them: constant, and without model, filter or feedforward.
    pub(crate) fn of(pid: &Pid) -> Result<Self, FileError> {
        let angle_loop = &pid.turn;
        let refuse = |key: &str| {
            let key = format!("controller.{}.{key}", angle_loop.angle);
            let allowed = "omitted, because the autopilot has no such parameter";
            Err(not_allowed(&pid.file, angle_loop.line, &key, "given", allowed))
        };
        if angle_loop.model.is_some() {
            return refuse("model");
        }
        if angle_loop.rolloff > 0.0 {
            return refuse("rolloff");
        }
        let drives = [Drive::Deflection, Drive::Moment];
        let has =
            |drive: &&Drive| drive.units(Role::Proportional).iter().any(|unit| unit.0 == angle_loop.kp.unit);
        let drive = *drives.iter().find(has).unwrap_or(&Drive::Deflection);
        let of = |given: Option<&Given>, units: Vec<Unit>| number(pid, given, &units);
        let turn = [
            of(Some(&angle_loop.kp), drive.units(Role::Proportional))?,
            of(angle_loop.ki.as_ref(), drive.units(Role::Integral))?,
            of(angle_loop.kd.as_ref(), drive.units(Role::Derivative))?,
        ];
        let pair = |kp: &Given, ki: Option<&Given>, units: fn(Role) -> Vec<Unit>| {
            Ok::<_, FileError>([of(Some(kp), units(Role::Proportional))?, of(ki, units(Role::Integral))?])
        };
        let depth = pid.depth.as_ref().map(|own| pair(&own.kp, own.ki.as_ref(), pitch_units)).transpose()?;
        let speed = pid.speed.as_ref().map(|own| pair(&own.kp, own.ki.as_ref(), force_units)).transpose()?;
        Ok(Self { drive, turn, depth, speed })
    }

    /// Refuses gains to another kind of command than the autopilot's.
    pub(crate) fn require(&self, pid: &Pid, drive: Drive, what: &str) -> Result<(), FileError> {
        if self.drive == drive {
            return Ok(());
        }
        let given = &pid.turn.kp;
        let found = format!("in \"{}\"", given.unit);
        let allowed = format!("in {}, because {what}", drive.units(Role::Proportional)[0].0);
        Err(not_allowed(&pid.file, given.line, &given.key, found, allowed))
    }
}

/// Refuses a reference weight, which most autopilots do not have.
pub(crate) fn no_weight(pid: &Pid) -> Result<(), FileError> {
    let weight = pid.turn.reference_weight;
    if weight == 1.0 {
        return Ok(());
    }
    let key = format!("controller.{}.reference_weight", pid.turn.angle);
    let allowed = "1 or omitted, because kp of this autopilot acts on the error itself";
    Err(not_allowed(&pid.file, pid.turn.line, &key, squid_auv::number(weight), allowed))
}

/// Refuses a depth loop.
pub(crate) fn no_depth(pid: &Pid, why: &str) -> Result<(), FileError> {
    let refused = |line: usize| {
        not_allowed(&pid.file, line, "controller.depth", "given", format!("omitted, because {why}"))
    };
    pid.depth.as_ref().map_or(Ok(()), |depth| Err(refused(depth.line)))
}

/// Returns notes on parts of a `[controller]` that no autopilot has.
pub(crate) fn not_written(pid: &Pid, speed: bool) -> Vec<String> {
    let candidates = [
        (!speed && pid.speed.is_some(), "[controller.speed]: the file has no gains from speed to thrust"),
        (pid.tracking_time.is_some(), "tracking_time: the autopilot limits its integral differently"),
        (
            pid.turn_shares.is_some() || pid.speed_shares.is_some(),
            "[controller.allocation]: the autopilot has its own allocation allocation",
        ),
    ];
    candidates.iter().filter(|(given, _)| *given).map(|(_, note)| format!("Not written: {note}.")).collect()
}

/// Returns a gain in SI that does not depend on speed; 0 if left out.
fn number(pid: &Pid, given: Option<&Given>, units: &[Unit]) -> Result<f64, FileError> {
    let Some(given) = given else { return Ok(0.0) };
    let refuse =
        |found: String, allowed: &str| Err(not_allowed(&pid.file, given.line, &given.key, found, allowed));
    // Only a table needs the range of speed, so any range does here.
    if matches!(given.law, Law::Table { .. }) {
        return refuse("a function of speed".into(), CONSTANT);
    }
    let (coefficients, _) = given.coefficients(&pid.file, units, (0.0, 1.0))?;
    match coefficients[..] {
        [value] if value > 0.0 => Ok(value),
        [value] => refuse(
            squid_auv::number(value),
            "above 0 or omitted, because gains of this autopilot are positive",
        ),
        _ => refuse("a function of speed".into(), CONSTANT),
    }
}

const CONSTANT: &str = "one number, because the autopilot has one gain for all speeds";
