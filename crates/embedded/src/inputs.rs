//! What the autopilot takes: measurements and references.

use squid_scheduled::{ControllerDesign, Kind, Level, Port};

/// A member of the inputs.
pub(crate) struct Input {
    pub(crate) name: String,
    /// The index of its signal.
    pub(crate) signal: usize,
    pub(crate) measured: bool,
    comment: String,
}

impl Input {
    pub(crate) fn member(&self) -> String {
        format!("    @prefix@_real {}; /* {} */\n", self.name, self.comment)
    }
}

/// What the design measures, then the references that it follows: the inputs of the FMU, with their ranges.
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
    let each = design.signals.iter().enumerate();
    let measured = each.filter(|(index, _)| design.measures(*index)).map(|(index, signal)| Input {
        name: signal.name.clone(),
        signal: index,
        measured: true,
        comment: comment(signal, true, &signal.measured),
    });
    let wanted = design.references().enumerate().filter(|(index, _)| design.follows(*index));
    let wanted = wanted.map(|(index, (signal, reference))| Input {
        name: reference.name.clone(),
        signal: index,
        measured: false,
        comment: comment(signal, false, &reference.wanted),
    });
    measured.chain(wanted).collect()
}

/// The signals whose references the design follows, with their indices.
pub(crate) fn references(design: &ControllerDesign) -> impl Iterator<Item = (usize, &Port)> {
    let followed = design.references().enumerate().filter(|(index, _)| design.follows(*index));
    followed.map(|(index, (signal, _))| (index, signal))
}

/// The name of the reference of a signal.
pub(crate) fn reference(signal: &Port) -> &str {
    signal.reference.as_ref().map_or("", |reference| &reference.name)
}

/// Whether the rate of the reference of a signal is limited.
pub(crate) fn has_rate(design: &ControllerDesign, signal: &Port) -> bool {
    design.envelope.get(&signal.name).is_some_and(|limits| limits.rate.is_some())
}

/// The signals that are deviations from the value measured at the reset, which the state keeps.
pub(crate) fn origins(design: &ControllerDesign) -> impl Iterator<Item = &Port> {
    let measured = |signal: &Port| {
        let inputs = design.controller_inputs.iter().filter(|input| input.kind == Kind::Measurement);
        inputs.into_iter().any(|input| input.signal == signal.name)
    };
    design.signals.iter().filter(move |signal| signal.level == Level::Start && measured(signal))
}

/// Whether the state keeps the commands that came out last.
pub(crate) fn keeps_commands(design: &ControllerDesign) -> bool {
    design.anti_windup.is_some() || design.failsafe.is_some()
}

/// A value of a signal near another: of an angle that comes back to itself the nearest.
pub(crate) fn near(signal: &Port, value: String, to: &str) -> String {
    if signal.circular { format!("nearest({value}, {to})") } else { value }
}
