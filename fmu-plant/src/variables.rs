//! The table of variables, in three parts.
//!
//! Inputs act during a step only, so at a communication point no output depends on an input, and a master meets no
//! algebraic loop. First values of outputs follow from parameters alone.

use auv::{Actuator, Allowed, COEFFICIENTS, CoefficientSpec, Fidelity};
use fmi2::model_description::Enumeration;

use crate::PlantModel;

type Variable = fmi2::Variable<PlantModel>;
type Role<T> = fmi2::Role<PlantModel, T>;

/// The type of the parameter `fidelity`.
pub fn fidelities() -> Enumeration {
    let items = [
        ("nonlinear", "the nonlinear equations of motion"),
        (
            "lpv",
            "the LPV model about the trim at operating_speed, made with the coefficients of the vehicle file",
        ),
    ];
    Enumeration::new("Fidelity", "which equations of motion are integrated", &items)
}

/// Commands, current, and the operating speed of the LPV model.
pub fn inputs(model: &PlantModel) -> Vec<Variable> {
    let mut table: Vec<_> =
        model.vehicle().actuators.iter().enumerate().map(|(i, actuator)| command(i, actuator)).collect();
    table.extend([
        Variable::real(
            "current_horizontal",
            "horizontal velocity of the current, positive the way of distance",
            |m| m.inputs.current.horizontal,
            Role::input(|m, v| m.inputs.current.horizontal = v),
        )
        .unit("m/s")
        .nominal(1.0),
        Variable::real(
            "current_vertical",
            "vertical velocity of the current, positive down",
            |m| m.inputs.current.vertical,
            Role::input(|m, v| m.inputs.current.vertical = v),
        )
        .unit("m/s")
        .nominal(1.0),
        Variable::real(
            "operating_speed",
            "speed about which the LPV model stands; fidelity nonlinear does not use it",
            |m| m.inputs.operating_speed,
            Role::input(|m, v| m.inputs.operating_speed = v),
        )
        .unit("m/s")
        .at_least(0.0)
        .nominal(1.0),
    ]);
    table
}

fn command(index: usize, actuator: &Actuator) -> Variable {
    let description = format!("command to {}; beyond its limits it goes to the limit", actuator.name);
    let get = move |m: &PlantModel| m.inputs.commands[index];
    let set = move |m: &mut PlantModel, v| m.inputs.commands[index] = v;
    Variable::real(&actuator.name, description, get, Role::input(set))
        .unit(actuator.unit())
        .range(actuator.min, actuator.max)
        .nominal(actuator.reach())
}

/// Motion, position, what the actuators do, and the trim at the start.
pub fn outputs(model: &PlantModel) -> Vec<Variable> {
    let mut table = motion();
    table.extend(position());
    for (index, actuator) in model.vehicle().actuators.iter().enumerate() {
        table.push(actuator_output(index, actuator));
    }
    for (index, actuator) in model.vehicle().actuators.iter().enumerate() {
        table.push(trim_output(index, actuator));
    }
    table.push(
        output("trim_pitch", "pitch angle of level trim at initial_speed and initial_depth", "rad", |m| {
            m.trim.pitch
        })
        .discrete()
        .nominal(0.1)
        .initially_depends_on(&knowns_of_trim()),
    );
    table
}

fn output(
    name: &str,
    description: &str,
    unit: &str,
    get: impl Fn(&PlantModel) -> f64 + Send + Sync + 'static,
) -> Variable {
    Variable::real(name, description, get, Role::output()).unit(unit).depends_on(&[])
}

/// Motion through the water.
fn motion() -> Vec<Variable> {
    let trim = knowns_of_trim();
    vec![
        output("pitch", "pitch angle, positive bow up", "rad", |m| m.state().motion.theta)
            .nominal(0.1)
            .initially_depends_on(&trim),
        output("speed", "forward speed through the water, along the body axis (u)", "m/s", |m| {
            m.state().motion.u
        })
        .nominal(1.0)
        .initially_depends_on(&trim),
        output("pitch_rate", "rate of pitch (q)", "rad/s", |m| m.state().motion.q)
            .nominal(0.1)
            .initially_depends_on(&[]),
        output("heave", "heave velocity through the water, positive down in the body (w)", "m/s", |m| {
            m.state().motion.w
        })
        .nominal(0.1)
        .initially_depends_on(&trim),
        output("path_speed", "speed along the path through the water, V = sqrt(u^2 + w^2)", "m/s", |m| {
            m.path_speed()
        })
        .at_least(0.0)
        .nominal(1.0)
        .initially_depends_on(&trim),
    ]
}

fn position() -> [Variable; 2] {
    [
        output("depth", "depth of the origin of the body", "m", |m| m.state().depth)
            .nominal(10.0)
            .initially_depends_on(&["initial_depth"]),
        output("distance", "horizontal way made over ground", "m", |m| m.state().x)
            .nominal(10.0)
            .initially_depends_on(&[]),
    ]
}

fn actuator_output(index: usize, actuator: &Actuator) -> Variable {
    let Actuator { name, min, max, .. } = actuator;
    output(
        &format!("{name}_output"),
        &format!("output of {name}, after limits and lag"),
        actuator.unit(),
        move |m| m.actuator_outputs()[index],
    )
    .range(*min, *max)
    .nominal(actuator.reach())
    .initially_depends_on(&knowns_of_trim())
}

fn trim_output(index: usize, actuator: &Actuator) -> Variable {
    let Actuator { name, min, max, .. } = actuator;
    output(
        &format!("trim_{name}"),
        &format!("output of {name} in level trim at initial_speed and initial_depth"),
        actuator.unit(),
        move |m| m.trim.actuators[index],
    )
    .discrete()
    .range(*min, *max)
    .nominal(actuator.reach())
    .initially_depends_on(&knowns_of_trim())
}

fn knowns_of_trim() -> Vec<&'static str> {
    let coefficients = COEFFICIENTS.iter().map(|spec| spec.key);
    ["initial_speed", "initial_depth"].into_iter().chain(coefficients).collect()
}

/// The start, the fidelity, and every coefficient of the vehicle.
pub fn parameters(model: &PlantModel) -> Vec<Variable> {
    let mut table = vec![
        Variable::real(
            "initial_speed",
            "speed along the path through the water at the start, in level trim",
            |m| m.settings.initial_speed,
            Role::parameter(|m, v| m.settings.initial_speed = v),
        )
        .unit("m/s")
        .at_least(0.0)
        .nominal(1.0),
        Variable::real(
            "initial_depth",
            "depth at the start",
            |m| m.settings.initial_depth,
            Role::parameter(|m, v| m.settings.initial_depth = v),
        )
        .unit("m")
        .at_least(0.0)
        .nominal(10.0),
        Variable::enumeration(
            "fidelity",
            "which equations of motion are integrated",
            &fidelities(),
            |m| number_of(m.settings.fidelity),
            Role::parameter(|m, v| m.settings.fidelity = fidelity_of(v)),
        ),
    ];
    table.extend(COEFFICIENTS.iter().map(|spec| coefficient(spec, model)));
    table
}

fn number_of(fidelity: Fidelity) -> i32 {
    match fidelity {
        Fidelity::Nonlinear => 1,
        Fidelity::Lpv => 2,
    }
}

/// The number comes checked against the items of [`fidelities`].
fn fidelity_of(number: i32) -> Fidelity {
    if number == 2 { Fidelity::Lpv } else { Fidelity::Nonlinear }
}

fn coefficient(spec: &'static CoefficientSpec, model: &PlantModel) -> Variable {
    let source = model.vehicle().sources.get(spec.key).map_or("the default", String::as_str);
    let description = format!("{}; source: {source}", spec.meaning);
    let get = |m: &PlantModel| (spec.get)(&m.settings.coefficients);
    let set = |m: &mut PlantModel, v| (spec.set)(&mut m.settings.coefficients, v);
    let size = get(model).abs();
    let variable = Variable::real(spec.key, description, get, Role::parameter(set)).unit(spec.unit);
    let variable = if size > 0.0 { variable.nominal(size) } else { variable };
    match spec.allowed {
        Allowed::Any => variable,
        Allowed::Positive | Allowed::NonNegative => variable.at_least(0.0),
        Allowed::NonPositive => variable.at_most(0.0),
    }
}
