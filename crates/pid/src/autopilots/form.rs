//! Gains of an autopilot in the form of `[controller]`, with where they come from; and the gains of a `[controller]` as
//! numbers in SI.

use crate::allocation::Drive;
use crate::angle::Angle;
use crate::autopilots::source::{Change, Source, decimal};
use crate::file::Pid;
use crate::gain::{Given, Law, Role, Unit, of_force, of_pitch};
use crate::refusal::not_allowed;
use squid_auv::toml_file::FileError;

/// What a file of an autopilot does not say.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Missing {
    /// ArduSub: the moment about the axis of the angle at output 1, N m.
    pub full_output: Option<f64>,
    /// What is known of that moment, for the refusal without it.
    pub hint: Option<String>,
    /// mvp: whether the command of the angle is a deflection or a moment.
    pub drive: Option<Drive>,
    /// mvp: the mode.
    pub mode: Option<String>,
}

/// A gain of `[controller]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Imported {
    /// Its table: that of the angle, `depth` or `speed`.
    pub table: &'static str,
    /// Its key in that table.
    pub key: &'static str,
    /// Its value.
    pub value: f64,
    /// Its unit; none for a weight.
    pub unit: Option<&'static str>,
    /// Where it comes from.
    pub source: String,
}

/// A value of a file that has no counterpart in `[controller]`.
#[derive(Debug, Clone, PartialEq)]
pub struct LeftOut {
    /// Its line.
    pub line: usize,
    /// Its key.
    pub key: String,
    /// Its text.
    pub value: String,
    /// The reason.
    pub why: &'static str,
}

/// What was read of the file of an autopilot.
#[derive(Debug, Clone, PartialEq)]
pub struct Import {
    /// The angle.
    pub angle: Angle,
    /// The law of the autopilot, with the order of its loops, a line each.
    pub law: Vec<String>,
    /// The gains.
    pub gains: Vec<Imported>,
    /// What has no counterpart.
    pub left_out: Vec<LeftOut>,
    /// What else there is to know.
    pub notes: Vec<String>,
}

/// A file of an autopilot with other gains.
#[derive(Debug, Clone, PartialEq)]
pub struct Export {
    /// The text.
    pub text: String,
    /// The numbers that changed.
    pub changes: Vec<Change>,
    /// What stays in the file, and what of `[controller]` was not written.
    pub notes: Vec<String>,
}

/// That `[controller.speed]` is missing.
const NO_SPEED: &str = "The file has no gains from speed to thrust: a design that tracks the speed needs \
                        [controller.speed] beside these.";

/// What the law of squid has besides.
const TRIM: &str = "Squid adds the trim of the actuators at each speed. The autopilot does not: its integral must hold \
                    that, and without one an error stays.";

impl Import {
    /// What was read so far: the law.
    pub(crate) fn new(angle: Angle, law: Vec<String>) -> Self {
        Self { angle, law, gains: vec![], left_out: vec![], notes: vec![] }
    }

    /// Adds a gain in the first of its units, unless it is 0, which means that there is none.
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

    /// All there is to know besides the gains, a sentence each.
    pub fn remarks(&self) -> Vec<String> {
        let left = |LeftOut { line, key, value, why }: &LeftOut| {
            format!("Left out: {key} = {value} (line {line}): {why}.")
        };
        let speed = self.gains.iter().any(|gain| gain.table == "speed");
        let pitches = self.angle == Angle::Pitch;
        let speed = (pitches && !speed).then(|| NO_SPEED.to_owned());
        let all = self.left_out.iter().map(left).chain(self.notes.iter().cloned());
        all.chain(speed).chain(pitches.then(|| TRIM.to_owned())).collect()
    }

    /// The gains as a file for `squid prove --controller`.
    pub fn toml(&self, file: &str) -> String {
        let mut lines = vec![format!("# Gains of {file}, read by `squid gains import`."), "#".into()];
        lines.extend(self.law.iter().map(|line| format!("#   {line}").trim_end().to_owned()));
        for remark in self.remarks() {
            lines.push("#".into());
            lines.extend(comment(&remark));
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

/// A key without counterpart: of which values it is worth a word, and the reason.
pub(crate) type Unread<K = &'static str> = (K, fn(f64) -> bool, &'static str);

/// Returns what a file has without counterpart.
pub(crate) fn unread<K: AsRef<str>>(
    source: &Source<'_>,
    keys: &[Unread<K>],
) -> Result<Vec<LeftOut>, FileError> {
    let found = keys.iter().map(|(key, keep, why)| left_out(source, key.as_ref(), *keep, why));
    Ok(found.collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect())
}

/// Returns the value of a key without counterpart, if the file has one that is worth a word.
pub(crate) fn left_out(
    source: &Source<'_>,
    key: &str,
    keep: fn(f64) -> bool,
    why: &'static str,
) -> Result<Option<LeftOut>, FileError> {
    let found = source.value(key)?.filter(|(_, value)| value.parse().map_or(true, keep));
    Ok(found.map(|(line, value)| LeftOut { line, key: key.to_owned(), value, why }))
}

/// That these stay in a file with other gains.
pub(crate) fn stay(all: &[LeftOut]) -> Vec<String> {
    all.iter()
        .map(|LeftOut { line, key, value, why }| format!("{key} = {value} (line {line}) stays: {why}."))
        .collect()
}

/// The table that the user has to fill in.
const SPEED: [&str; 3] =
    ["[controller.speed]", "kp = { value = , unit = \"N.s/m\" }", "ki = { value = , unit = \"N/m\" }"];

/// The columns of a comment.
const COLUMNS: usize = 100;

/// Words as comment lines.
fn comment(words: &str) -> Vec<String> {
    let mut lines = vec![String::from("#")];
    for word in words.split_whitespace() {
        let begun = lines.len() - 1;
        if lines[begun].len() + word.len() + 1 > COLUMNS && lines[begun] != "#" {
            lines.push(format!("#   {word}"));
        } else {
            lines[begun] += " ";
            lines[begun] += word;
        }
    }
    lines
}

/// The gains of a `[controller]` as numbers in SI; 0 for one that is left out.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Plain {
    /// What the command of the angle is.
    pub(crate) drive: Drive,
    /// kp, ki and kd of the angle.
    pub(crate) turn: [f64; 3],
    /// kp and ki of depth.
    pub(crate) depth: Option<[f64; 2]>,
    /// kp and ki of speed.
    pub(crate) speed: Option<[f64; 2]>,
}

impl Plain {
    /// The gains, if they are of a form that autopilots have: numbers, and no model, filter or feedforward.
    pub(crate) fn of(pid: &Pid) -> Result<Self, FileError> {
        let asked = &pid.turn;
        let refuse = |key: &str| {
            let key = format!("controller.{}.{key}", asked.angle);
            let allowed = "left out: the autopilot has nothing to write it to";
            Err(not_allowed(&pid.file, asked.line, &key, "given", allowed))
        };
        if asked.model.is_some() {
            return refuse("model");
        }
        if asked.rolloff > 0.0 {
            return refuse("rolloff");
        }
        let drives = [Drive::Deflection, Drive::Moment];
        let has = |drive: &&Drive| drive.units(Role::Proportional).iter().any(|unit| unit.0 == asked.kp.unit);
        let drive = *drives.iter().find(has).unwrap_or(&Drive::Deflection);
        let of = |given: Option<&Given>, units: Vec<Unit>| number(pid, given, &units);
        let turn = [
            of(Some(&asked.kp), drive.units(Role::Proportional))?,
            of(asked.ki.as_ref(), drive.units(Role::Integral))?,
            of(asked.kd.as_ref(), drive.units(Role::Derivative))?,
        ];
        let pair = |kp: &Given, ki: Option<&Given>, units: fn(Role) -> Vec<Unit>| {
            Ok::<_, FileError>([of(Some(kp), units(Role::Proportional))?, of(ki, units(Role::Integral))?])
        };
        let depth = pid.depth.as_ref().map(|own| pair(&own.kp, own.ki.as_ref(), of_pitch)).transpose()?;
        let speed = pid.speed.as_ref().map(|own| pair(&own.kp, own.ki.as_ref(), of_force)).transpose()?;
        Ok(Self { drive, turn, depth, speed })
    }

    /// Refuses gains whose command is not that of the autopilot.
    pub(crate) fn require(&self, pid: &Pid, drive: Drive, what: &str) -> Result<(), FileError> {
        if self.drive == drive {
            return Ok(());
        }
        let given = &pid.turn.kp;
        let found = format!("in \"{}\"", given.unit);
        let allowed = format!("in {}: {what}", drive.units(Role::Proportional)[0].0);
        Err(not_allowed(&pid.file, given.line, &given.key, found, allowed))
    }
}

/// Refuses a weight of the reference, which most autopilots do not have.
pub(crate) fn no_weight(pid: &Pid) -> Result<(), FileError> {
    let weight = pid.turn.reference_weight;
    if weight == 1.0 {
        return Ok(());
    }
    let key = format!("controller.{}.reference_weight", pid.turn.angle);
    let allowed = "1, or left out: kp of this autopilot acts on the error itself";
    Err(not_allowed(&pid.file, pid.turn.line, &key, squid_auv::number(weight), allowed))
}

/// Refuses a depth loop.
pub(crate) fn no_depth(pid: &Pid, why: &str) -> Result<(), FileError> {
    let refused =
        |line: usize| not_allowed(&pid.file, line, "controller.depth", "given", format!("left out: {why}"));
    pid.depth.as_ref().map_or(Ok(()), |depth| Err(refused(depth.line)))
}

/// What of a `[controller]` no autopilot has.
pub(crate) fn not_written(pid: &Pid, speed: bool) -> Vec<String> {
    let said = [
        (!speed && pid.speed.is_some(), "[controller.speed]: the file has no gains from speed to thrust"),
        (pid.tracking_time.is_some(), "tracking_time: the autopilot limits its integral in its own way"),
        (
            pid.turn_shares.is_some() || pid.speed_shares.is_some(),
            "[controller.allocation]: the autopilot has its own",
        ),
    ];
    said.iter().filter(|(given, _)| *given).map(|(_, words)| format!("Not written: {words}.")).collect()
}

/// A gain in SI that does not depend on the speed.
fn number(pid: &Pid, given: Option<&Given>, units: &[Unit]) -> Result<f64, FileError> {
    let Some(given) = given else { return Ok(0.0) };
    let refuse =
        |found: String, allowed: &str| Err(not_allowed(&pid.file, given.line, &given.key, found, allowed));
    // A range of speed is needed for a table alone.
    if matches!(given.law, Law::Table { .. }) {
        return refuse("a function of speed".into(), CONSTANT);
    }
    let (coefficients, _) = given.coefficients(&pid.file, units, (0.0, 1.0))?;
    match coefficients[..] {
        [value] if value > 0.0 => Ok(value),
        [value] => {
            refuse(squid_auv::number(value), "above 0, or left out: gains of this autopilot are positive")
        }
        _ => refuse("a function of speed".into(), CONSTANT),
    }
}

const CONSTANT: &str = "one number: the autopilot has one gain for all speeds";
