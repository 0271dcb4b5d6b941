//! The table of variables.
//!
//! Outputs change at ticks only, and a tick runs inside the step that begins with it; so at a communication point no
//! output depends on an input, and a master has no algebraic loop.

use scheduled::{Actuator, ControllerDesign, Inputs, Level, Port};

use crate::Axis;
use crate::tangents::Quantity;

type Variable = fmi2::Variable<Axis>;
type Role<T> = fmi2::Role<Axis, T>;

/// An input of an axis: the measured value or the reference of a signal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Input {
    Measured(usize),
    Reference(usize),
}

impl Input {
    pub(crate) fn of(self, inputs: &Inputs) -> f64 {
        match self {
            Self::Measured(signal) => inputs.measured[signal],
            Self::Reference(signal) => inputs.references[signal],
        }
    }

    pub(crate) fn set(self, inputs: &mut Inputs, value: f64) {
        match self {
            Self::Measured(signal) => inputs.measured[signal] = value,
            Self::Reference(signal) => inputs.references[signal] = value,
        }
    }

    /// Its row of the table.
    pub(crate) fn variable(self, design: &ControllerDesign) -> Variable {
        let (Self::Measured(place) | Self::Reference(place)) = self;
        let signal = &design.signals[place];
        let wanted = signal.reference.as_ref().filter(|_| matches!(self, Self::Reference(_)));
        let (name, what) =
            wanted.map_or((&signal.name, &signal.measured), |reference| (&reference.name, &reference.wanted));
        let set = Role::input(move |m: &mut Axis, v| self.set(&mut m.inputs, v));
        let one = Variable::real(name, what, move |m| self.of(&m.inputs), set);
        within_range(one, signal, design, wanted.is_none()).quantity(self.quantity().number(design))
    }

    pub(crate) fn quantity(self) -> Quantity {
        match self {
            Self::Measured(signal) => Quantity::Measured(signal),
            Self::Reference(signal) => Quantity::Reference(signal),
        }
    }
}

/// Name and unit of each input: what the design measures, then the references that it follows.
pub(crate) fn inputs(design: &ControllerDesign) -> impl Iterator<Item = (&str, &str, Input)> {
    let measured = design.signals.iter().enumerate().filter(|(i, _)| design.measures(*i));
    let measured =
        measured.map(|(i, signal)| (signal.name.as_str(), signal.unit.as_str(), Input::Measured(i)));
    let references = design.references().enumerate().filter(|(i, _)| design.follows(*i));
    let references = references
        .map(|(i, (signal, wanted))| (wanted.name.as_str(), signal.unit.as_str(), Input::Reference(i)));
    measured.chain(references)
}

/// Commands, monitors and constants of a design; the names of monitors and constants begin with `prefix`.
pub fn outputs(design: &ControllerDesign, prefix: &str) -> Vec<Variable> {
    let inputs: Vec<&str> = inputs(design).map(|(name, ..)| name).collect();
    let commands = design.actuators.iter().enumerate();
    let commands = commands.map(|(index, actuator)| {
        command(index, actuator, &inputs).quantity(Quantity::Command(index).number(design))
    });
    commands.chain(monitors(design, prefix)).chain(constants(prefix)).collect()
}

/// Adds unit, size and range of a signal: that of a measured speed is wider than that of its reference.
fn within_range(one: Variable, signal: &Port, design: &ControllerDesign, measured: bool) -> Variable {
    let speeds = &design.trim.forward_speed;
    let (slowest, fastest) = (speeds[0], speeds[speeds.len() - 1]);
    let one = one.unit(&signal.unit).nominal(signal.nominal);
    match (signal.level, signal.range) {
        (_, Some([least, most])) => one.range(least, most),
        (Level::Scheduled, None) if measured => {
            let far = 2.0 * slowest.abs().max(fastest.abs());
            one.range(-far, far)
        }
        (Level::Scheduled, None) => one.range(slowest, fastest),
        _ => one,
    }
}

fn command(index: usize, actuator: &Actuator, inputs: &[&str]) -> Variable {
    let inverse = if actuator.curve.is_some() { ", by the inverse of its curve" } else { "" };
    let sign = actuator.sign_in_words().map_or(String::new(), |words| format!("; {words}"));
    let description =
        format!("command to {}: trim feedforward and K(rho), limited{inverse}{sign}", actuator.name);
    let (least, most) = (actuator.taken(actuator.minimum).0, actuator.taken(actuator.maximum).0);
    let nominal = if actuator.curve.is_some() { least.abs().max(most.abs()) } else { actuator.scale };
    Variable::real(&actuator.name, description, move |m| m.command(index), Role::output())
        .unit(actuator.taken_unit())
        .range(least, most)
        .nominal(nominal)
        .discrete()
        .depends_on(&[])
        .initially_depends_on(inputs)
}

fn monitors(design: &ControllerDesign, prefix: &str) -> Vec<Variable> {
    let scheduled = design.scheduled().map(|place| &design.signals[place]);
    let measured = scheduled.map_or("", |signal| &signal.name);
    let reference =
        scheduled.and_then(|signal| signal.reference.as_ref()).map(|reference| reference.name.as_str());
    let (speed, which) = match reference.filter(|_| !design.speed_given) {
        Some(reference) => (reference, "wanted"),
        None => (measured, "given"),
    };
    // A limit may depend on the speed, and a reference begin at what is measured.
    let wanted: Vec<&str> = inputs(design).map(|(name, ..)| name).collect();
    let scheduling = vec![
        Variable::real(
            format!("{prefix}scheduling_parameter"),
            "scheduling parameter rho: -1 at the slowest, 1 at the fastest scheduled speed",
            |m| m.autopilot.outputs().scheduling_parameter,
            Role::output(),
        )
        .unit("1")
        .range(-1.0, 1.0)
        .quantity(Quantity::SchedulingParameter.number(design))
        .nominal(1.0)
        .discrete()
        .depends_on(&[])
        .initially_depends_on(&[measured]),
        Variable::boolean(
            format!("{prefix}speed_out_of_range"),
            "the speed lies outside the scheduled range, and rho is held at its end",
            |m| m.autopilot.outputs().out_of_range,
            Role::output(),
        )
        .depends_on(&[])
        .initially_depends_on(&[measured]),
        Variable::boolean(
            format!("{prefix}reference_limited"),
            "a reference asks more than the vehicle can hold, and is limited",
            |m| m.autopilot.outputs().reference_limited,
            Role::output(),
        )
        .depends_on(&[])
        .initially_depends_on(&wanted),
    ];
    let used = design.references().enumerate().filter(|(place, _)| design.follows(*place));
    let used = used.map(|(place, (signal, reference))| {
        let one = Variable::real(
            format!("{prefix}{}_used", reference.name),
            format!("{} as the controller uses it, within what the vehicle can hold", reference.wanted),
            move |m| m.autopilot.references()[place],
            Role::output(),
        );
        let one = one.quantity(Quantity::Used(place).number(design));
        within_range(one, signal, design, false).discrete().depends_on(&[]).initially_depends_on(&wanted)
    });
    let trims = design.trimmed().enumerate().map(|(index, place)| {
        let signal = &design.signals[place];
        let one = Variable::real(
            format!("{prefix}trim_{}", signal.name),
            format!("{} of level trim at the {which} speed", signal.measured),
            move |m| m.autopilot.outputs().trim[index],
            Role::output(),
        );
        let one =
            one.unit(&signal.unit).nominal(signal.nominal).quantity(Quantity::Trim(index).number(design));
        let one = match signal.range {
            Some([least, most]) => one.range(least, most),
            None => one,
        };
        one.discrete().depends_on(&[]).initially_depends_on(&[speed])
    });
    scheduling.into_iter().chain(used).chain(trims).collect()
}

fn constants(prefix: &str) -> Vec<Variable> {
    vec![
        Variable::real(
            format!("{prefix}sample_time"),
            "time between two ticks",
            |m| m.design.sample_time,
            Role::constant(),
        )
        .unit("s")
        .at_least(0.0)
        .nominal(0.02),
        Variable::real(
            format!("{prefix}gamma"),
            "bound of the closed loop's L2 gain",
            |m| m.design.gamma.bound,
            Role::constant(),
        )
        .unit("1")
        .at_least(0.0)
        .nominal(1.0),
        Variable::boolean(
            format!("{prefix}gamma_certified"),
            "the bound was proved in exact arithmetic",
            |m| m.design.gamma.certified,
            Role::constant(),
        ),
    ]
}
