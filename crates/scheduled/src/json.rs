//! Reads and writes a design as JSON, in one of three formats.
//!
//! | format | inputs of the controller |
//! |---|---|
//! | `squid-controller/1` | `tracked`: a list of `name`, `unit`, `scale`; each is an error, and there is no filter |
//! | `squid-controller/2` | `controller_inputs`: a list of `signal`, `kind`, `unit`, `scale`; `reference_filter` |
//! | `squid-controller/3` | the same, and `anti_windup`, rows of a matrix |
//!
//! A design is written in the first that can say it. All else is the same in each; `delay_ticks` is left out where it
//! is 0, `depth` likewise, `speed_given` where it is false, the `curve` of an actuator where there is none. Earlier
//! versions did not write the `force` of an actuator.

use crate::design::{Actuator, Gamma, InputHashes, LftMatrices, Rows, Scheduling, TrimTable, VehicleName};
use crate::{ControllerDesign, ControllerInput, DesignError, Kind};
use serde::{Deserialize, Serialize, Serializer};

const FIRST: &str = "squid-controller/1";
const SECOND: &str = "squid-controller/2";
const THIRD: &str = "squid-controller/3";

/// The file.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    format: String,
    vehicle: VehicleName,
    design: String,
    sample_time: f64,
    #[serde(default, skip_serializing_if = "is_default")]
    delay_ticks: usize,
    scheduling: Scheduling,
    #[serde(skip_serializing_if = "Option::is_none")]
    tracked: Option<Vec<Input>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    controller_inputs: Option<Vec<Input>>,
    /// The inner one is null without filter.
    #[serde(skip_serializing_if = "Option::is_none")]
    reference_filter: Option<Option<f64>>,
    #[serde(default, skip_serializing_if = "is_default")]
    speed_given: bool,
    actuators: Vec<Actuator>,
    lft: LftMatrices,
    #[serde(skip_serializing_if = "Option::is_none")]
    anti_windup: Option<Rows>,
    trim: TrimTable,
    #[serde(default, skip_serializing_if = "is_default")]
    depth: f64,
    gamma: Gamma,
    inputs: InputHashes,
}

/// Whether a key is left out.
pub(crate) fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// One input: `name` is that of an error in the first format, `signal` and `kind` are of the second.
/// One struct reads both, which keeps the binaries small.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Input {
    #[serde(skip_serializing_if = "Option::is_none")]
    name: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    signal: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    kind: Option<Kind>,
    unit: String,
    scale: f64,
}

impl ControllerDesign {
    /// Reads and checks a design.
    ///
    /// # Errors
    /// [`DesignError`] with the key at fault.
    #[inline]
    pub fn from_json(text: &str) -> Result<Self, DesignError> {
        let design = serde_json::from_str::<File>(text)?.design()?;
        design.validate()?;
        Ok(design)
    }

    /// The design as JSON, one matrix row per line; numbers read back to the same `f64`.
    ///
    /// # Errors
    /// [`DesignError`] if the design is not valid and could not be read back.
    pub fn to_json(&self) -> Result<String, DesignError> {
        self.validate()?;
        let mut text = join_rows(&serde_json::to_string_pretty(self)?);
        text.push('\n');
        Ok(text)
    }

    /// Whether the first format can say it.
    #[inline]
    fn is_first(&self) -> bool {
        self.reference_filter.is_none()
            && self.anti_windup.is_none()
            && self.controller_inputs.iter().all(|one| one.kind == Kind::Error)
    }

    /// The keys of the list of inputs, and of the signal of each.
    #[inline]
    pub(crate) fn keys_of_inputs(&self) -> (&'static str, &'static str) {
        if self.is_first() { ("tracked", "name") } else { ("controller_inputs", "signal") }
    }

    fn file(&self) -> File {
        let first = self.is_first();
        let Self { controller_inputs, reference_filter, .. } = self;
        let input = |ControllerInput { signal, kind, unit, scale }| {
            let (name, signal) = if first { (Some(signal), None) } else { (None, Some(signal)) };
            Input { name, signal, kind: (!first).then_some(kind), unit, scale }
        };
        let listed = |here: bool| here.then(|| controller_inputs.iter().cloned().map(input).collect());
        let Self { vehicle, design, sample_time, delay_ticks, scheduling, .. } = self.clone();
        let Self { actuators, lft, anti_windup, trim, depth, gamma, inputs, .. } = self.clone();
        let format = match (first, &anti_windup) {
            (true, _) => FIRST,
            (false, None) => SECOND,
            (false, Some(_)) => THIRD,
        };
        File {
            format: format.to_owned(),
            vehicle,
            design,
            sample_time,
            delay_ticks,
            scheduling,
            tracked: listed(first),
            controller_inputs: listed(!first),
            reference_filter: (!first).then_some(*reference_filter),
            speed_given: self.speed_given,
            actuators,
            lft,
            anti_windup,
            trim,
            depth,
            gamma,
            inputs,
        }
    }
}

impl Serialize for ControllerDesign {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.file().serialize(serializer)
    }
}

impl File {
    #[inline]
    fn design(self) -> Result<ControllerDesign, DesignError> {
        let filter = self.reference_filter.flatten();
        let gain = self.anti_windup.is_some();
        let other = |format, allowed| Err(DesignError::OtherFormat { format, allowed });
        let (format, read) = match (self.format.as_str(), self.tracked, self.controller_inputs) {
            (FIRST, Some(tracked), None) if filter.is_none() && !gain => (FIRST, tracked),
            (SECOND, None, Some(inputs)) if !gain => (SECOND, inputs),
            (THIRD, None, Some(inputs)) if gain => (THIRD, inputs),
            (FIRST, ..) => return other(FIRST, "`tracked` alone"),
            (SECOND, ..) => {
                return other(SECOND, "`controller_inputs`, and neither `tracked` nor `anti_windup`");
            }
            (THIRD, ..) => return other(THIRD, "`controller_inputs` and `anti_windup`, and not `tracked`"),
            _ => {
                return Err(DesignError::WrongFormat { found: self.format, allowed: [FIRST, SECOND, THIRD] });
            }
        };
        let input = |Input { name, signal, kind, unit, scale }| match (format, name, signal, kind) {
            (FIRST, Some(signal), None, None) => {
                Ok(ControllerInput { signal, kind: Kind::Error, unit, scale })
            }
            (SECOND | THIRD, None, Some(signal), Some(kind)) => {
                Ok(ControllerInput { signal, kind, unit, scale })
            }
            (FIRST, ..) => {
                let allowed = "`tracked`, each with `name`, `unit` and `scale` alone";
                Err(DesignError::OtherFormat { format, allowed })
            }
            _ => {
                let allowed = "`controller_inputs`, each with `signal`, `kind`, `unit` and `scale` alone";
                Err(DesignError::OtherFormat { format, allowed })
            }
        };
        let controller_inputs = read.into_iter().map(input).collect::<Result<_, _>>()?;
        let Self { vehicle, design, sample_time, delay_ticks, scheduling, speed_given, .. } = self;
        let Self { actuators, lft, anti_windup, trim, depth, gamma, inputs, .. } = self;
        Ok(ControllerDesign {
            vehicle,
            design,
            sample_time,
            delay_ticks,
            scheduling,
            controller_inputs,
            reference_filter: filter,
            speed_given,
            actuators,
            lft,
            anti_windup,
            trim,
            depth,
            gamma,
            inputs,
        })
    }
}

/// Puts each innermost list on one line.
fn join_rows(pretty: &str) -> String {
    let mut joined = String::with_capacity(pretty.len());
    let mut rest = pretty;
    // A list opens with a line break behind its bracket; strings contain no line breaks.
    while let Some(open) = rest.find("[\n") {
        let (before, list) = rest.split_at(open);
        joined.push_str(before);
        let end = list.find(']').map_or(list.len(), |close| close + 1);
        if list[1..end].contains(['[', '{', '"']) {
            joined.push('[');
            rest = &list[1..];
        } else {
            let numbers = list[1..end - 1].split_whitespace().collect::<Vec<_>>().join(" ");
            joined.extend(["[", &numbers, "]"]);
            rest = &list[end..];
        }
    }
    joined.push_str(rest);
    joined
}
