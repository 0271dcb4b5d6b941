//! The inputs of the autopilot: measurements and references, and their indices in the tables.

use squid_scheduled::{ControllerDesign, Kind, Level, Port};

/// A member of the inputs.
pub(crate) struct Input {
    pub(crate) name: String,
    /// Index of the signal.
    pub(crate) signal: usize,
    pub(crate) measured: bool,
    /// Unit, range and meaning.
    pub(crate) comment: String,
}

/// Returns the measurements of the design, then the references that it follows: the inputs of the FMU, with ranges.
pub(crate) fn inputs(design: &ControllerDesign) -> Vec<Input> {
    let speeds = &design.trim.forward_speed;
    let (slowest, fastest) = (speeds[0], speeds[speeds.len() - 1]);
    let comment = |signal: &Port, measured: bool, what: &str| {
        let range = match (signal.level, design.widest(signal).filter(|_| !measured).or(signal.range)) {
            (_, Some([least, most])) => format!(", {least:.4} to {most:.4}"),
            (Level::Scheduled, None) if measured => format!(", scheduled on {slowest:.4} to {fastest:.4}"),
            (Level::Scheduled, None) => format!(", {slowest:.4} to {fastest:.4}"),
            _ => String::new(),
        };
        format!("{}{range}: {what}", signal.unit)
    };
    let input = |index: usize, measured: bool| {
        let signal = &design.signals[index];
        let reference = signal.reference.as_ref().filter(|_| !measured);
        let (name, what) =
            reference.map_or((&signal.name, &signal.measured), |one| (&one.name, &one.description));
        Input { name: name.clone(), signal: index, measured, comment: comment(signal, measured, what) }
    };
    let measured = measurements(design).into_iter().map(|index| input(index, true));
    measured.chain(references(design).into_iter().map(|index| input(index, false))).collect()
}

/// Returns the signals that the design measures.
pub(crate) fn measurements(design: &ControllerDesign) -> Vec<usize> {
    (0..design.signals.len()).filter(|index| design.measures(*index)).collect()
}

/// Returns the signals whose references the design follows.
pub(crate) fn references(design: &ControllerDesign) -> Vec<usize> {
    (0..design.references().count()).filter(|index| design.follows(*index)).collect()
}

/// Returns the name of the reference of a signal.
pub(crate) fn reference(signal: &Port) -> &str {
    signal.reference.as_ref().map_or("", |reference| &reference.name)
}

/// Returns the signals that are deviations from the value measured at the reset, which the state stores.
pub(crate) fn origins(design: &ControllerDesign) -> Vec<usize> {
    let is_measured = |name: &str| {
        let inputs = design.controller_inputs.iter().filter(|input| input.kind == Kind::Measurement);
        inputs.into_iter().any(|input| input.signal == *name)
    };
    let is_origin = |signal: &Port| signal.level == Level::Start && is_measured(&signal.name);
    (0..design.signals.len()).filter(|index| is_origin(&design.signals[*index])).collect()
}

/// Returns the signals whose trim is needed: those output, and those from whose trim an input is a deviation.
pub(crate) fn trims(design: &ControllerDesign) -> Vec<usize> {
    let is_input = |name: &str| {
        let inputs = design.controller_inputs.iter().filter(|input| input.kind != Kind::Error);
        inputs.into_iter().any(|input| input.signal == *name)
    };
    let is_needed = |index: &usize| {
        let signal = &design.signals[*index];
        signal.level == Level::Trim && (design.trimmed().any(|one| one == *index) || is_input(&signal.name))
    };
    (0..design.signals.len()).filter(is_needed).collect()
}

/// Returns the actuators at whose limits the reference of a signal yields, one bit each.
pub(crate) fn steered_by(design: &ControllerDesign, index: usize) -> u32 {
    let name = &design.signals[index].name;
    let all = design.actuators.iter().enumerate().filter(|(_, one)| one.steers.contains(name));
    if design.measures(index) { all.map(|(index, _)| 1 << index).sum() } else { 0 }
}
