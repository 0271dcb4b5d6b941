//! Table of variables.
//!
//! Outputs change at ticks only, and a tick is part of the step that starts at its time. So no output depends on an
//! input at a communication point, and a master has no algebraic loop.

use squid_fmi2::model_description::Enumeration;
use squid_scheduled::{Actuator, ControllerDesign, Health, Level, Port};

use crate::Axis;
use crate::tangents::Quantity;

type Variable = squid_fmi2::Variable<Axis>;
type Role<T> = squid_fmi2::Role<Axis, T>;

/// A numeric input of an axis: measured value or reference of a signal, or applied command of an actuator.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Input {
    Measured(usize),
    Reference(usize),
    Applied(usize),
}

impl Input {
    pub(crate) fn of(self, axis: &Axis) -> f64 {
        match self {
            Self::Measured(signal) => axis.inputs.measured[signal],
            Self::Reference(signal) => axis.inputs.references[signal],
            Self::Applied(actuator) => axis.applied.commands[actuator],
        }
    }

    pub(crate) fn set(self, axis: &mut Axis, value: f64) {
        match self {
            Self::Measured(signal) => axis.inputs.measured[signal] = value,
            Self::Reference(signal) => axis.inputs.references[signal] = value,
            Self::Applied(actuator) => axis.applied.commands[actuator] = value,
        }
    }

    /// Returns the row of this input in the table.
    pub(crate) fn variable(self, design: &ControllerDesign) -> Variable {
        let set = Role::input(move |m: &mut Axis, v| self.set(m, v));
        let of = |name: &str, what: &str| Variable::real(name, what, move |m| self.of(m), set);
        let one = match self {
            Self::Measured(index) => {
                let signal = &design.signals[index];
                within_range(of(&signal.name, &signal.measured), signal, design, true)
            }
            Self::Reference(index) => {
                let (signal, (name, description)) = (&design.signals[index], reference(design, index));
                within_range(of(name, description), signal, design, false)
            }
            Self::Applied(index) => {
                let actuator = &design.actuators[index];
                let what = format!(
                    "command actually applied to {}; used while the controller is not engaged, or if applied_given \
                        is true",
                    actuator.name
                );
                of(&applied(actuator), &what).unit(actuator.input_unit()).nominal(size(actuator))
            }
        };
        one.quantity(self.quantity().number(design))
    }

    pub(crate) fn quantity(self) -> Quantity {
        match self {
            Self::Measured(signal) => Quantity::Measured(signal),
            Self::Reference(signal) => Quantity::Reference(signal),
            Self::Applied(actuator) => Quantity::Applied(actuator),
        }
    }
}

/// Returns name and description of the reference of a signal.
fn reference(design: &ControllerDesign, signal: usize) -> (&str, &str) {
    let reference = design.signals[signal].reference.as_ref();
    reference.map_or(("", ""), |reference| (&reference.name, &reference.description))
}

/// Returns the name of the input for the applied command of an actuator.
fn applied(actuator: &Actuator) -> String {
    format!("{}_applied", actuator.name)
}

/// Returns the nominal value of an actuator's command.
fn size(actuator: &Actuator) -> f64 {
    let ends = [actuator.minimum, actuator.maximum].map(|end| actuator.input_for(end).0.abs());
    if actuator.curve.is_some() { ends[0].max(ends[1]) } else { actuator.scale }
}

/// Returns name and unit of each numeric input: the signals that the design measures, the references that it follows,
/// and the applied commands.
pub(crate) fn inputs(design: &ControllerDesign) -> impl Iterator<Item = (String, &str, Input)> {
    let of = |signal: usize| design.signals[signal].unit.as_str();
    let measured = (0..design.signals.len()).filter(|i| design.measures(*i));
    let measured = measured.map(move |i| (design.signals[i].name.clone(), of(i), Input::Measured(i)));
    let references = (0..design.references().count()).filter(|i| design.follows(*i));
    let references = references.map(move |i| (reference(design, i).0.to_owned(), of(i), Input::Reference(i)));
    let actuators = design.actuators.iter().enumerate();
    let actuators = actuators.map(|(i, one)| (applied(one), one.input_unit(), Input::Applied(i)));
    measured.chain(references).chain(actuators)
}

/// Returns the inputs for the origin of the actuator commands, shared by all axes.
pub(crate) fn engagement() -> [Variable; 2] {
    [
        Variable::boolean(
            "engaged",
            "true if the actuators receive the commands of this controller; while false it follows NAME_applied",
            |m| m.applied.engaged,
            Role::input(|m, v| m.applied.engaged = v),
        ),
        Variable::boolean(
            "applied_given",
            "true if NAME_applied is valid also while the controller is engaged: it starts with these commands, and \
             its anti-windup accounts for further limits",
            |m| m.applied.given,
            Role::input(|m, v| m.applied.given = v),
        ),
    ]
}

/// Returns the input for the validity of a measurement, for a design with a failsafe.
pub(crate) fn validity(input: Input, design: &ControllerDesign) -> Option<Variable> {
    let Input::Measured(index) = input else { return None };
    design.failsafe.as_ref()?;
    let set = Role::input(move |m: &mut Axis, v| m.valid[index] = v);
    let what = format!("true if the measured value of {} is valid", design.signals[index].name);
    Some(Variable::boolean(valid(&design.signals[index]), what, move |m| m.valid[index], set))
}

/// Returns the name of the input for the validity of a measurement.
fn valid(signal: &Port) -> String {
    format!("{}_valid", signal.name)
}

/// Returns the parameter for the time after which a constant measurement is lost; it is shared by all axes.
pub(crate) fn stale_after() -> Variable {
    let what = "time after which a constant measurement that should have changed counts as lost; 0 for never";
    Variable::real("stale_after", what, |m| m.stale_after, Role::tunable(|m, v| m.stale_after = v))
        .unit("s")
        .at_least(0.0)
        .nominal(0.5)
}

/// Returns the type of the output `status`.
pub fn healths() -> Enumeration {
    let items = [
        ("ok", "all sensors are trusted, and nothing is limited"),
        ("limited", "a command or a reference is limited"),
        ("speed_lost", "the filtered speed reference replaces the measured speed: the speed loop is open"),
        ("reckoned", "depth, pitch or heading is estimated from measurements of its rate"),
        ("failed", "a sensor without a substitute is lost: the commands ramp to the safe ones"),
    ];
    Enumeration::new("Status", "state of the sensors, and whether anything is limited", &items)
}

fn number_of(health: Health) -> i32 {
    match health {
        Health::Ok => 1,
        Health::Limited => 2,
        Health::SpeedLost => 3,
        Health::Reckoned => 4,
        Health::Failed => 5,
    }
}

/// Returns commands, monitors and constants of a design; the names of monitors and constants begin with `prefix`.
pub fn outputs(design: &ControllerDesign, prefix: &str) -> Vec<Variable> {
    let inputs = all_inputs(design);
    let inputs: Vec<&str> = inputs.iter().map(String::as_str).collect();
    let commands = design.actuators.iter().enumerate();
    let commands = commands.map(|(index, actuator)| {
        command(index, actuator, &inputs).quantity(Quantity::Command(index).number(design))
    });
    commands.chain(monitors(design, prefix)).chain(constants(prefix)).collect()
}

/// Returns the names of all inputs.
fn all_inputs(design: &ControllerDesign) -> Vec<String> {
    let others = ["engaged", "applied_given"].map(str::to_owned);
    inputs(design).map(|(name, ..)| name).chain(others).collect()
}

/// Adds unit, nominal value and range of a signal; the range of a measured speed is wider than that of its reference.
fn within_range(one: Variable, signal: &Port, design: &ControllerDesign, measured: bool) -> Variable {
    let speeds = &design.trim.forward_speed;
    let (slowest, fastest) = (speeds[0], speeds[speeds.len() - 1]);
    let one = one.unit(&signal.unit).nominal(signal.nominal);
    if let Some([least, most]) = design.widest(signal).filter(|_| !measured) {
        return one.range(least, most);
    }
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
    let inverse = if actuator.curve.is_some() { ", through the inverse of its curve" } else { "" };
    let sign = actuator.effect_of_sign().map_or(String::new(), |sign| format!("; {sign}"));
    let description =
        format!("command to {}: trim feedforward plus K(rho), limited{inverse}{sign}", actuator.name);
    let (least, most) = (actuator.input_for(actuator.minimum).0, actuator.input_for(actuator.maximum).0);
    Variable::real(&actuator.name, description, move |m| m.command(index), Role::output())
        .unit(actuator.input_unit())
        .range(least, most)
        .nominal(size(actuator))
        .discrete()
        .depends_on(&[])
        .initially_depends_on(inputs)
}

fn monitors(design: &ControllerDesign, prefix: &str) -> Vec<Variable> {
    let scheduled = design.scheduled().map(|index| &design.signals[index]);
    let measured = scheduled.map_or("", |signal| &signal.name);
    let reference =
        scheduled.and_then(|signal| signal.reference.as_ref()).map(|reference| reference.name.as_str());
    let (speed, which) = match reference.filter(|_| !design.speed_given) {
        Some(reference) => (reference, "reference"),
        None => (measured, "imposed"),
    };
    // A limit may depend on the speed, and a reference may start at the measurement.
    let inputs = all_inputs(design);
    let inputs: Vec<&str> = inputs.iter().map(String::as_str).collect();
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
            "true if the speed is outside the scheduled range and rho is held at its end",
            |m| m.autopilot.outputs().out_of_range,
            Role::output(),
        )
        .depends_on(&[])
        .initially_depends_on(&[measured]),
        Variable::boolean(
            format!("{prefix}reference_limited"),
            "true if a reference differs from its input: it is limited to the envelope, moves to the measured value \
             because an actuator stays at its limit, or returns afterwards or after the controller was engaged",
            |m| m.autopilot.outputs().reference_limited,
            Role::output(),
        )
        .depends_on(&[])
        .initially_depends_on(&inputs),
    ];
    let status = Variable::enumeration(
        format!("{prefix}status"),
        "state of the sensors, and whether anything is limited",
        &healths(),
        |m| number_of(m.health()),
        Role::output(),
    );
    let saturated = design.actuators.iter().enumerate().map(|(index, actuator)| {
        Variable::boolean(
            format!("{}_saturated", actuator.name),
            format!(
                "true if the command to {} is clamped to its limit, or to zero so that it does not oppose the speed \
                 reference",
                actuator.name
            ),
            move |m| m.health() != Health::Failed && m.autopilot.saturation()[index].now,
            Role::output(),
        )
        .depends_on(&[])
        .initially_depends_on(&inputs)
    });
    let status = status.depends_on(&[]).initially_depends_on(&inputs);
    let scheduling = scheduling.into_iter().chain([status]).chain(saturated);
    let used = design.references().enumerate().filter(|(index, _)| design.follows(*index));
    let used = used.map(|(index, (signal, reference))| {
        let one = Variable::real(
            used_name(prefix, signal.level, &reference.name),
            format!("{} as used by the controller, within the envelope", reference.description),
            move |m| m.autopilot.references()[index],
            Role::output(),
        );
        let one = one.quantity(Quantity::Used(index).number(design));
        within_range(one, signal, design, false).discrete().depends_on(&[]).initially_depends_on(&inputs)
    });
    let trims = design.trimmed().enumerate().map(|(index, signal)| {
        let signal = &design.signals[signal];
        let one = Variable::real(
            format!("{prefix}trim_{}", signal.name),
            format!("{} in level trim at the {which} speed", signal.measured),
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
    scheduling.chain(used).chain(trims).collect()
}

/// Returns the name of a reference as used; the name of the speed, which all axes use, always has the prefix.
pub fn used_name(prefix: &str, level: Level, reference: &str) -> String {
    let prefix = if level != Level::Scheduled && reference.starts_with(prefix) { "" } else { prefix };
    format!("{prefix}{reference}_used")
}

fn constants(prefix: &str) -> Vec<Variable> {
    vec![
        Variable::real(
            format!("{prefix}sample_time"),
            "time between ticks",
            |m| m.design.sample_time,
            Role::constant(),
        )
        .unit("s")
        .at_least(0.0)
        .nominal(0.02),
        Variable::real(
            format!("{prefix}gamma"),
            "bound of the L2 gain of the closed loop",
            |m| m.design.gamma.bound,
            Role::constant(),
        )
        .unit("1")
        .at_least(0.0)
        .nominal(1.0),
        Variable::boolean(
            format!("{prefix}gamma_certified"),
            "true if the bound was proved in exact arithmetic",
            |m| m.design.gamma.certified,
            Role::constant(),
        ),
    ]
}
