//! Validation of a design.

use squid_signals::{Curve, Level};
use std::collections::BTreeSet;
use std::fmt;

use crate::design::{CONTROLLER_FORMAT, MAX_DELAY_TICKS};
use crate::lft::checked;
use crate::lft::numbers::{finite, not_negative, positive, range};
use crate::{ControllerDesign, DesignError, Lft, Matrix, OverSpeed, Sensor, Source};

/// Shortest accepted sample time \[s\]; with a shorter one a step would need too many ticks.
const SHORTEST_SAMPLE_TIME: f64 = 1e-5;

impl ControllerDesign {
    /// Checks shapes, ranges, names and units.
    ///
    /// # Errors
    /// [`DesignError`] with the key at fault.
    #[inline]
    pub fn validate(&self) -> Result<(), DesignError> {
        if self.format != CONTROLLER_FORMAT {
            return Err(DesignError::WrongFormat { found: self.format.clone() });
        }
        if !(SHORTEST_SAMPLE_TIME..f64::INFINITY).contains(&self.sample_time) {
            let (key, value) = ("sample_time".to_owned(), self.sample_time);
            return Err(DesignError::BadNumber { key, value, allowed: "finite and at least 1e-5" });
        }
        if self.delay_ticks > MAX_DELAY_TICKS {
            let (key, value) = ("delay_ticks".to_owned(), self.delay_ticks as f64);
            return Err(DesignError::BadNumber { key, value, allowed: "at most 10" });
        }
        self.validate_signals()?;
        self.validate_scheduling()?;
        self.validate_controller_inputs()?;
        self.validate_circular()?;
        self.validate_actuators()?;
        if self.lft.blocks.len() > 1 {
            return Err(DesignError::SeveralParameters { found: self.lft.blocks.len() });
        }
        Lft::from_rows(&self.lft, self.controller_inputs.len(), self.actuators.len())?;
        self.anti_windup_gain()?;
        self.follow_gains()?;
        self.validate_trim()?;
        self.validate_envelope()?;
        self.validate_failsafe()?;
        for (key, value) in [("gamma.optimum", self.gamma.optimum), ("gamma.bound", self.gamma.bound)] {
            positive(format_args!("{key}"), value)?;
        }
        not_negative(format_args!("gamma.back_off"), self.gamma.back_off)
    }

    /// Returns the matrix [`anti_windup`](Self::anti_windup), n x m.
    ///
    /// # Errors
    /// [`DesignError::WrongLength`], [`DesignError::BadNumber`].
    #[inline]
    pub(crate) fn anti_windup_gain(&self) -> Result<Option<Matrix>, DesignError> {
        let (states, actuators) = (self.lft.a.len(), self.actuators.len());
        let gain = self.anti_windup.as_ref();
        gain.map(|rows| checked("anti_windup", rows, states, actuators)).transpose()
    }

    /// Returns the matrices of [`follow`](Self::follow), n x m.
    ///
    /// # Errors
    /// [`DesignError::WrongLength`], [`DesignError::BadNumber`].
    #[inline]
    pub(crate) fn follow_gains(&self) -> Result<Vec<Matrix>, DesignError> {
        let (states, actuators) = (self.lft.a.len(), self.actuators.len());
        self.follow.iter().map(|rows| checked("follow", rows, states, actuators)).collect()
    }

    /// Checks the signals: names valid for variables, those with a reference first, exactly one scheduling signal.
    #[inline]
    fn validate_signals(&self) -> Result<(), DesignError> {
        if self.signals.is_empty() {
            return Err(DesignError::Empty { key: "signals" });
        }
        let mut taken = BTreeSet::new();
        for (index, signal) in self.signals.iter().enumerate() {
            let key = |last: &str| format!("signals[{index}].{last}");
            let reference = signal.reference.iter().map(|reference| ("reference.name", &reference.name));
            for (last, name) in std::iter::once(("name", &signal.name)).chain(reference) {
                self::name(key(last), name)?;
                if !taken.insert(name) {
                    return Err(DesignError::NameTaken { key: key(last), name: name.clone() });
                }
            }
            if signal.reference.is_some() && index > 0 && self.signals[index - 1].reference.is_none() {
                let (found, allowed) =
                    (signal.name.clone(), "before all signals without a reference".to_owned());
                return Err(DesignError::BadText { key: key("name"), found, allowed });
            }
            if signal.level == Level::Scheduled && self.scheduled() != Some(index) {
                let allowed = "the level of a single signal".to_owned();
                return Err(DesignError::BadText {
                    key: key("level"),
                    found: "scheduled".to_owned(),
                    allowed,
                });
            }
            finite(format_args!("signals[{index}].start"), signal.start)?;
            positive(format_args!("signals[{index}].nominal"), signal.nominal)?;
            if let Some([minimum, maximum]) = signal.range {
                range(format_args!("signals[{index}].range"), minimum, maximum)?;
            }
        }
        Ok(())
    }

    #[inline]
    fn validate_scheduling(&self) -> Result<(), DesignError> {
        let scheduling = &self.scheduling;
        let scheduled = self.signals.iter().find(|signal| signal.level == Level::Scheduled);
        if scheduled.is_none_or(|signal| signal.name != scheduling.quantity) {
            let (key, found) = ("scheduling.quantity".to_owned(), scheduling.quantity.clone());
            let allowed = "the signal with level 'scheduled'".to_owned();
            return Err(DesignError::BadText { key, found, allowed });
        }
        positive(format_args!("scheduling.half_range"), scheduling.half_range)?;
        let (minimum, maximum) = (scheduling.minimum, scheduling.maximum);
        range(format_args!("scheduling"), minimum, maximum)?;
        for (end, expected) in [(minimum, -1.0), (maximum, 1.0)] {
            let rho = (end - scheduling.centre) / scheduling.half_range;
            // NaN is rejected too.
            if rho.is_nan() || (rho - expected).abs() > 1e-9 {
                return Err(DesignError::SchedulingMismatch { end, rho, expected });
            }
        }
        Ok(())
    }

    #[inline]
    fn validate_controller_inputs(&self) -> Result<(), DesignError> {
        if self.controller_inputs.is_empty() {
            return Err(DesignError::Empty { key: "controller_inputs" });
        }
        let mut taken = BTreeSet::new();
        for (index, input) in self.controller_inputs.iter().enumerate() {
            let key = |last: &str| format!("controller_inputs[{index}].{last}");
            let bad = |last, found: &str, allowed: String| {
                Err(DesignError::BadText { key: key(last), found: found.to_owned(), allowed })
            };
            let allowed =
                self.signals.iter().filter(|signal| !input.is_reference() || signal.reference.is_some());
            match allowed.clone().find(|signal| signal.name == input.signal) {
                None => {
                    return bad("signal", &input.signal, one_of(allowed.map(|signal| signal.name.as_str())));
                }
                Some(signal) if signal.unit != input.unit => {
                    return bad("unit", &input.unit, signal.unit.clone());
                }
                Some(_) => {}
            }
            positive(format_args!("controller_inputs[{index}].scale"), input.scale)?;
            if !taken.insert((&input.signal, input.kind)) {
                return Err(DesignError::NameTaken { key: key("signal"), name: input.signal.clone() });
            }
        }
        let follows_speed = self.scheduled().is_some_and(|speed| self.follows(speed));
        if self.speed_given && (self.reference_filter.is_some() || follows_speed) {
            let (key, found) = ("speed_given".to_owned(), "true".to_owned());
            let allowed = "false if the speed has a reference".to_owned();
            return Err(DesignError::BadText { key, found, allowed });
        }
        self.reference_filter.map_or(Ok(()), |w| positive(format_args!("reference_filter"), w))
    }

    /// Checks that a circular angle is both tracked and measured, or neither: its measured value is unwrapped to be the
    /// one nearest to its reference.
    #[inline]
    fn validate_circular(&self) -> Result<(), DesignError> {
        let blind =
            |index: &usize| self.signals[*index].circular && self.follows(*index) != self.measures(*index);
        match (0..self.signals.len()).find(blind) {
            None => Ok(()),
            Some(index) => Err(DesignError::BadText {
                key: format!("signals.{index}.circular"),
                found: "true".to_owned(),
                allowed: "omitted for a signal that is not both tracked and measured".to_owned(),
            }),
        }
    }

    fn validate_actuators(&self) -> Result<(), DesignError> {
        if self.actuators.is_empty() {
            return Err(DesignError::Empty { key: "actuators" });
        }
        let mut names: BTreeSet<&str> = BTreeSet::new();
        for (index, actuator) in self.actuators.iter().enumerate() {
            let key = |last: &str| format!("actuators[{index}].{last}");
            name(key("name"), &actuator.name)?;
            if !names.insert(&actuator.name) {
                return Err(DesignError::NameTaken { key: key("name"), name: actuator.name.clone() });
            }
            positive(format_args!("actuators[{index}].scale"), actuator.scale)?;
            let steered = || {
                let others =
                    self.references().enumerate().filter(|(place, _)| Some(*place) != self.scheduled());
                others.map(|(_, (signal, _))| signal.name.as_str())
            };
            if let Some(other) = actuator.steers.iter().find(|one| !steered().any(|name| name == **one)) {
                let (found, allowed) = (other.clone(), one_of(steered()));
                return Err(DesignError::BadText { key: key("steers"), found, allowed });
            }
            range(format_args!("actuators[{index}]"), actuator.minimum, actuator.maximum)?;
            let [least, most] =
                actuator.curve.as_ref().map_or([f64::NEG_INFINITY, f64::INFINITY], Curve::ends);
            for (last, value) in [("minimum", actuator.minimum), ("maximum", actuator.maximum)] {
                if !(least..=most).contains(&value) {
                    let allowed = "a thrust within its curve";
                    return Err(DesignError::BadNumber { key: key(last), value, allowed });
                }
            }
        }
        Ok(())
    }

    #[inline]
    fn validate_trim(&self) -> Result<(), DesignError> {
        let trim = &self.trim;
        let rows = trim.speed.len();
        if rows < 2 {
            return Err(DesignError::WrongLength { key: "trim.speed".to_owned(), found: rows, expected: 2 });
        }
        increasing("trim.speed", &trim.speed)?;
        length(format_args!("trim.forward_speed"), trim.forward_speed.len(), rows)?;
        increasing("trim.forward_speed", &trim.forward_speed)?;
        let trimmed = self.signals.iter().filter(|signal| signal.level == Level::Trim);
        for name in trimmed.clone().map(|signal| &signal.name) {
            let column = trim.signals.get(name).map_or(&[][..], Vec::as_slice);
            length(format_args!("trim.signals.{name}"), column.len(), rows)?;
            for (row, &value) in column.iter().enumerate() {
                finite(format_args!("trim.signals.{name}[{row}]"), value)?;
            }
        }
        if let Some(other) =
            trim.signals.keys().find(|key| !trimmed.clone().any(|signal| signal.name == **key))
        {
            let allowed = one_of(trimmed.map(|signal| signal.name.as_str()));
            return Err(DesignError::BadText {
                key: "trim.signals".to_owned(),
                found: other.clone(),
                allowed,
            });
        }
        length(format_args!("trim.actuators"), trim.actuators.len(), rows)?;
        for (row, commands) in trim.actuators.iter().enumerate() {
            length(format_args!("trim.actuators[{row}]"), commands.len(), self.actuators.len())?;
            for (column, (&value, actuator)) in commands.iter().zip(&self.actuators).enumerate() {
                finite(format_args!("trim.actuators[{row}][{column}]"), value)?;
                let (minimum, maximum) = (actuator.minimum, actuator.maximum);
                if value < minimum || value > maximum {
                    let key = format!("trim.actuators[{row}][{column}]");
                    return Err(DesignError::TrimBeyondLimits { key, value, minimum, maximum });
                }
            }
        }
        self.validate_coverage(trim.speed[0], trim.speed[rows - 1])
    }

    #[inline]
    fn validate_envelope(&self) -> Result<(), DesignError> {
        let rows = self.trim.speed.len();
        for (signal, limits) in &self.envelope {
            if !self.references().any(|(port, _)| port.name == *signal) {
                let allowed = one_of(self.references().map(|(port, _)| port.name.as_str()));
                let (key, found) = ("envelope".to_owned(), signal.clone());
                return Err(DesignError::BadText { key, found, allowed });
            }
            for (name, ends) in [("range", &limits.range), ("rate", &limits.rate)] {
                let Some([least, most]) = ends else { continue };
                for end in [least, most] {
                    let OverSpeed::Table(column) = end else { continue };
                    let key = format!("envelope.{signal}.{name}");
                    if *signal == self.scheduling.quantity {
                        let (found, allowed) = ("a table".to_owned(), "a number".to_owned());
                        return Err(DesignError::BadText { key, found, allowed });
                    }
                    length(format_args!("{key}"), column.len(), rows)?;
                }
                for row in 0..rows {
                    let values = [least.at(row), most.at(row)];
                    let key = |end: usize| match [least, most][end] {
                        OverSpeed::Constant(_) => format!("envelope.{signal}.{name}[{end}]"),
                        OverSpeed::Table(_) => format!("envelope.{signal}.{name}[{end}][{row}]"),
                    };
                    for (end, value) in values.into_iter().enumerate() {
                        finite(format_args!("{}", key(end)), value)?;
                    }
                    let [least, most] = values;
                    if least > most {
                        let allowed = "at most the upper end";
                        return Err(DesignError::BadNumber { key: key(0), value: least, allowed });
                    }
                    if name == "rate" && !(least..=most).contains(&0.0) {
                        let (end, value) = if least > 0.0 { (0, least) } else { (1, most) };
                        let allowed = "such that the range contains 0";
                        return Err(DesignError::BadNumber { key: key(end), value, allowed });
                    }
                }
            }
        }
        Ok(())
    }

    #[inline]
    fn validate_failsafe(&self) -> Result<(), DesignError> {
        let Some(failsafe) = &self.failsafe else { return Ok(()) };
        not_negative(format_args!("failsafe.stale_after"), failsafe.stale_after)?;
        length(format_args!("failsafe.safe"), failsafe.safe.len(), self.actuators.len())?;
        for (index, (value, one)) in failsafe.safe.iter().zip(&self.actuators).enumerate() {
            if !(one.minimum..=one.maximum).contains(value) {
                let key = format!("failsafe.safe[{index}]");
                return Err(DesignError::BadNumber {
                    key,
                    value: *value,
                    allowed: "within the limits of the actuator",
                });
            }
        }
        let measured = || (0..self.signals.len()).filter(|signal| self.measures(*signal));
        let names = || measured().map(|signal| self.signals[signal].name.as_str());
        if let Some(other) = failsafe.sensors.keys().find(|key| !names().any(|name| name == *key)) {
            let (key, found) = ("failsafe.sensors".to_owned(), other.clone());
            return Err(DesignError::BadText { key, found, allowed: one_of(names()) });
        }
        length(format_args!("failsafe.sensors"), failsafe.sensors.len(), measured().count())?;
        for (name, sensor) in &failsafe.sensors {
            let key = |last: &str| format!("failsafe.sensors.{name}.{last}");
            let Sensor { error, rate, drift, resolution, period, from } = sensor;
            let numbers = [
                ("error", error),
                ("rate", rate),
                ("drift", drift),
                ("resolution", resolution),
                ("period", period),
            ];
            for (last, value) in numbers {
                not_negative(format_args!("{}", key(last)), *value)?;
            }
            let trimmed: Vec<usize> = self.trimmed().collect();
            let sources = (0..self.signals.len())
                .filter(|place| !matches!(from, Some(Source::Path(_))) || trimmed.contains(place))
                .map(|place| self.signals[place].name.as_str());
            let named = from.as_ref().and_then(Source::signal);
            if let Some(found) = named.filter(|found| !sources.clone().any(|one| one == *found)) {
                let (found, allowed) = (found.to_owned(), one_of(sources));
                return Err(DesignError::BadText { key: key("from"), found, allowed });
            }
            if let Some(Source::Commands { gains, time }) = from {
                length(format_args!("{}", key("from.commands.gains")), gains.len(), self.actuators.len())?;
                for (index, gain) in gains.iter().enumerate() {
                    finite(format_args!("{}[{index}]", key("from.commands.gains")), *gain)?;
                }
                positive(format_args!("{}", key("from.commands.time")), *time)?;
            }
        }
        Ok(())
    }

    #[inline]
    fn validate_coverage(&self, first: f64, last: f64) -> Result<(), DesignError> {
        let (minimum, maximum) = (self.scheduling.minimum, self.scheduling.maximum);
        let rounding = 1e-9 * minimum.abs().max(maximum.abs());
        if first > minimum + rounding || last < maximum - rounding {
            return Err(DesignError::TrimTooShort { first, last, minimum, maximum });
        }
        Ok(())
    }
}

/// Checks that a name is valid for a variable.
#[inline]
fn name(key: String, name: &str) -> Result<(), DesignError> {
    let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
    if name.starts_with(|c: char| c.is_ascii_alphabetic()) && name.chars().all(is_part) {
        return Ok(());
    }
    let allowed = "letters, digits and underscores, starting with a letter".to_owned();
    Err(DesignError::BadText { key, found: name.to_owned(), allowed })
}

/// Joins names for a message: 'a', 'b' or 'c'.
fn one_of<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let names: Vec<String> = names.map(|name| format!("'{name}'")).collect();
    match names.split_last() {
        Some((last, others)) if !others.is_empty() => format!("{} or {last}", others.join(", ")),
        _ => names.concat(),
    }
}

#[inline]
fn length(key: fmt::Arguments<'_>, found: usize, expected: usize) -> Result<(), DesignError> {
    if found == expected {
        return Ok(());
    }
    Err(DesignError::WrongLength { key: key.to_string(), found, expected })
}

#[inline]
fn increasing(key: &'static str, column: &[f64]) -> Result<(), DesignError> {
    for (row, &value) in column.iter().enumerate() {
        finite(format_args!("{key}[{row}]"), value)?;
    }
    for pair in column.windows(2) {
        if pair[1] <= pair[0] {
            return Err(DesignError::NotIncreasing { key, previous: pair[0], next: pair[1] });
        }
    }
    Ok(())
}
