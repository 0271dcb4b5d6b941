//! Table of variables of the loop, including the visible variables of plant and controller.
//!
//! References act at ticks only; the current has direct feedthrough to the velocities through the water only.

use squid_auv::longitudinal::{DEPTH, SIGNALS, SPEED};
use squid_fmu_controller::{prefix, used_name};
use squid_fmu_plant::{WAVES, of_current};
use squid_signals::{Level, Reference, Signal};
use std::f64::consts::PI;

use crate::ClosedLoop;
use crate::closed_loop::signal;
use crate::tangents::Own;

type Variable = squid_fmi2::Variable<ClosedLoop>;
type Role<T> = squid_fmi2::Role<ClosedLoop, T>;

/// Parameters on which the initial speed depends.
const SPEED_PROFILE: [&str; 4] = ["speed_from", "speed_to", "ramp_start", "ramp_duration"];

/// Parameters of the steps: name of the signal, name of the parameter, description and nominal value.
const STEPS: [(&str, &str, &str, f64); 4] = [
    ("pitch", "pitch_step", "height of the pitch step above the trim pitch, strictly within the limits", 0.1),
    ("depth", "depth_step", "height of the depth step from the initial depth, positive downwards", 1.0),
    (
        "heading",
        "heading_step",
        "turn from the initial heading, positive to starboard, strictly within the limits",
        0.1,
    ),
    ("roll", "roll_step", "height of the roll step, strictly within the limits", 0.1),
];

/// Returns the table of a loop.
pub(crate) fn table(model: &ClosedLoop) -> Vec<Variable> {
    let mut table = manoeuvre(model);
    table.extend(plant_parameters(model));
    table.extend(overrides(model));
    table.extend(disturbances(model));
    table.extend(motion(model));
    table.extend(of_controller(model));
    table.extend(references(model));
    table.extend(states(model));
    table
}

/// A parameter with the name of a field of the manoeuvre.
macro_rules! parameter {
    ($field:ident, $unit:literal, $description:expr) => {
        Variable::real(
            stringify!($field),
            $description,
            |m| m.manoeuvre.$field,
            Role::parameter(|m, v| m.manoeuvre.$field = v),
        )
        .unit($unit)
    };
}

fn manoeuvre(model: &ClosedLoop) -> Vec<Variable> {
    let ahead = model.plant.only_ahead();
    let sign = if ahead { "above zero" } else { "negative astern" };
    let speed = |one: Variable| if ahead { one.at_least(0.0) } else { one };
    let from = format!(
        "reference of the speed along the path through the water before the ramp, {sign}; the simulation starts in \
            trim at this speed"
    );
    let to = format!("reference of the speed along the path through the water after the ramp, {sign}");
    let signals = model.followed().into_iter().filter(|index| *index != SPEED).filter_map(signal);
    let signals = signals.map(|signal| signal.name).collect::<Vec<_>>().join(" and ");
    let (comes, ends) =
        if model.has_six_dof() { ("steps start", "steps end") } else { ("step starts", "step ends") };
    let steps = steps(model).map(|(signal, key, what, nominal)| {
        let Signal { name, unit, range, circular, .. } = *signal;
        let range = range.or(circular.then_some([-PI, PI]));
        let set = move |m: &mut ClosedLoop, v| {
            if let Some(step) = m.manoeuvre.steps.get_mut(name) {
                *step = v;
            }
        };
        let get = move |m: &ClosedLoop| m.manoeuvre.step(name);
        let one = Variable::real(key, what, get, Role::parameter(set)).unit(unit).nominal(nominal);
        match range {
            Some([least, most]) => one.range(least, most),
            None => one,
        }
    });
    let others = [
        parameter!(step_time, "s", format!("time at which the {signals} {comes}")).nominal(10.0),
        parameter!(step_end, "s", format!("time at which the {signals} {ends}")).nominal(10.0),
        speed(parameter!(speed_from, "m/s", from)).nominal(1.0),
        speed(parameter!(speed_to, "m/s", to)).nominal(1.0),
        parameter!(ramp_start, "s", "time at which the speed ramp starts").nominal(10.0),
        parameter!(ramp_duration, "s", "duration of the speed ramp, above zero").at_least(0.0).nominal(10.0),
    ];
    steps.chain(others).collect()
}

/// Returns the parameters of the steps of those signals for which the loop has a reference.
fn steps(
    model: &ClosedLoop,
) -> impl Iterator<Item = (&'static Signal, &'static str, &'static str, f64)> + use<> {
    let followed: Vec<&Signal> = model.followed().into_iter().filter_map(signal).collect();
    STEPS.into_iter().filter_map(move |(name, key, what, nominal)| {
        let signal = followed.iter().find(|signal| signal.name == name)?;
        Some((*signal, key, what, nominal))
    })
}

/// Returns the parameters of the plant except the initial speed, which is that of the manoeuvre.
fn plant_parameters(model: &ClosedLoop) -> impl Iterator<Item = Variable> {
    let own = |one: &squid_fmi2::Variable<_>| one.name() != "initial_speed";
    squid_fmu_plant::parameters(&model.plant).into_iter().filter(own).map(of_plant)
}

fn of_plant(one: squid_fmi2::Variable<squid_fmu_plant::PlantModel>) -> Variable {
    one.embedded(|m: &ClosedLoop| &m.plant, |m| &mut m.plant)
}

fn overrides(model: &ClosedLoop) -> impl Iterator<Item = Variable> {
    let speeds = &model.axes[0].design().trim.forward_speed;
    let (slowest, fastest) = (speeds[0], speeds[speeds.len() - 1]);
    let actuators = actuators(model);
    let own = move |quantity: Own| quantity.number(actuators);
    let widest = |index: usize| {
        let (axis, own) = model.owner(index)?;
        let design = model.axes[axis].design();
        design.widest(&design.signals[own])
    };
    let start = model.outside.references;
    let names: Vec<&str> = followed(model).map(|(_, _, reference)| reference.name).collect();
    let manual = Variable::boolean(
        "manual",
        format!("true to follow the inputs {} instead of the manoeuvre", names.join(" and ")),
        |m| m.outside.manual,
        Role::input(|m, v| m.outside.manual = v),
    );
    let references = followed(model).map(move |(index, signal, reference)| {
        let one = Variable::real(
            reference.name,
            format!(
                "{}, used while manual is true; initially that of the default start",
                reference.description
            ),
            move |m| m.outside.references[index],
            Role::input(move |m, v| m.outside.references[index] = v),
        )
        .unit(signal.unit)
        .nominal(signal.nominal)
        .quantity(own(Own::Reference(index)))
        .slope(move |m, v| m.outside.slopes[index] = v);
        match (signal.level, widest(index).or(signal.range)) {
            // The start value may lie outside the range: it is that of the default simulation.
            (_, Some([least, most])) => one.range(least.min(start[index]), most.max(start[index])),
            (Level::Scheduled, None) => one.range(slowest.min(start[index]), fastest.max(start[index])),
            _ => one,
        }
    });
    std::iter::once(manual).chain(references)
}

/// Returns the signals for which the loop has a reference, with the indices of the references.
fn followed(model: &ClosedLoop) -> impl Iterator<Item = (usize, &'static Signal, Reference)> + use<> {
    let of = |index| signal(index).and_then(|signal| Some((index, signal, signal.reference?)));
    model.followed().into_iter().filter_map(of)
}

/// Returns the inputs of the plant that the loop does not set: current and external load.
fn disturbances(model: &ClosedLoop) -> impl Iterator<Item = Variable> {
    let known = known_of(model);
    let open = move |one: &squid_fmi2::Variable<_>| known(one.name());
    squid_fmu_plant::inputs(&model.plant).into_iter().filter(open).map(of_plant)
}

/// Returns the outputs of the plant except its initial trim; `trim_pitch` is that of the controller here.
fn motion(model: &ClosedLoop) -> impl Iterator<Item = Variable> {
    let actuators = model.plant.vehicle().actuators.iter().map(|actuator| format!("trim_{}", actuator.name));
    let trim: Vec<_> = actuators.chain(["trim_pitch".to_owned()]).collect();
    let open = move |one: &squid_fmi2::Variable<_>| !trim.iter().any(|name| name == one.name());
    let known = known_of(model);
    let here = move |one: Variable| one.depends_only_where(&known);
    let actuators = model.plant.vehicle().actuators.iter().filter(|actuator| actuator.lag <= 0.0);
    let at_once: Vec<_> = actuators.map(|actuator| format!("{}_output", actuator.name)).collect();
    squid_fmu_plant::outputs(&model.plant).into_iter().filter(open).map(of_plant).map(here).map(move |one| {
        match one.name() {
            // The initial values depend on the same variables as in the plant.
            "depth" | "altitude" | "distance" | "pitch_rate" | "north" | "east" | "heading"
            | "heading_rate" | "roll" | "sway" | "roll_rate" | "angular_velocity_x"
            | "angular_velocity_y" | "angular_velocity_z" => one,
            name if at_once.iter().any(|output| output == name) => {
                one.initially_depends_on(&knowns_of_first_tick(model))
            }
            _ => one.initially_depends_on(&knowns_of_start(model)),
        }
    })
}

/// Returns derivatives and states for model exchange.
fn states(model: &ClosedLoop) -> impl Iterator<Item = Variable> {
    let known = known_of(model);
    let of_plant = squid_fmu_plant::states(&model.plant).into_iter().map(of_plant);
    of_plant.map(move |one| one.depends_only_where(&known)).map(|one| match one.name() {
        "surge_over_ground" | "sway_over_ground" | "heave_over_ground" => {
            let waves: &[&str] = if model.plant.supports_waves() { &WAVES } else { &[] };
            let heading: &[&str] = if model.has_six_dof() { &["initial_heading"] } else { &[] };
            let knowns = [&knowns_of_start(model)[..], heading, of_current(&model.plant), waves];
            one.initially_depends_on(&knowns.concat())
        }
        _ => one,
    })
}

/// Returns a predicate that is `true` for the names of variables that the loop does not set.
fn known_of(model: &ClosedLoop) -> impl Fn(&str) -> bool + use<> {
    let actuators = model.axes.iter().flat_map(|axis| &axis.design().actuators).map(|one| one.name.clone());
    let set: Vec<String> =
        actuators.chain(["operating_speed", squid_fmu_plant::GIVEN_SPEED].map(str::to_owned)).collect();
    move |name| !set.iter().any(|known| known == name)
}

fn actuators(model: &ClosedLoop) -> usize {
    model.plant.vehicle().actuators.len()
}

fn knowns_of_start(model: &ClosedLoop) -> Vec<&'static str> {
    let coefficients = model.plant.vehicle().coefficients.acting().map(|spec| spec.key);
    SPEED_PROFILE.into_iter().chain(["initial_depth"]).chain(coefficients).collect()
}

/// Returns commands, monitors and constants of the designs except the references, of which the loop has its own.
fn of_controller(model: &ClosedLoop) -> impl Iterator<Item = Variable> {
    let each = model.axes.iter().enumerate().map(|(index, axis)| {
        let prefix = if index == 0 { String::new() } else { prefix(axis.design()) };
        of_axis(model, index, &prefix)
    });
    each.collect::<Vec<_>>().into_iter().flatten()
}

fn of_axis(model: &ClosedLoop, index: usize, prefix: &str) -> Vec<Variable> {
    let constants = ["sample_time", "gamma", "gamma_certified"].map(|name| format!("{prefix}{name}"));
    let names: Vec<String> =
        model.plant.vehicle().actuators.iter().map(|actuator| actuator.name.clone()).collect();
    let of_loop: Vec<String> = followed(model)
        .map(|(_, signal, reference)| used_name(prefix, signal.level, reference.name))
        .collect();
    let own = |one: &squid_fmi2::Variable<_>| !of_loop.iter().any(|name| name == one.name());
    let all = squid_fmu_controller::outputs(model.axes[index].design(), prefix).into_iter().filter(own).map(
        |one| {
            let constant = constants.iter().any(|name| name == one.name());
            let one = one.embedded(move |m: &ClosedLoop| &m.axes[index], move |m| &mut m.axes[index]);
            let one = if constant { one } else { one.initially_depends_on(&knowns_of_first_tick(model)) };
            match quantity_of(one.name().strip_prefix(prefix).unwrap_or(one.name()), &names) {
                Some(own) => one.quantity(own.number(names.len())),
                None => one,
            }
        },
    );
    all.collect()
}

/// Returns the quantity of an output of the controller.
fn quantity_of(name: &str, actuators: &[String]) -> Option<Own> {
    match name {
        "scheduling_parameter" => Some(Own::SchedulingParameter),
        "trim_pitch" => Some(Own::TrimPitch),
        _ => actuators.iter().position(|actuator| actuator == name).map(Own::Command),
    }
}

fn knowns_of_first_tick(model: &ClosedLoop) -> Vec<&'static str> {
    let mut knowns: Vec<&str> =
        steps(model).map(|(_, name, ..)| name).chain(["step_time", "step_end", "manual"]).collect();
    if model.has_six_dof() {
        knowns.push("initial_heading");
    }
    knowns.extend(followed(model).map(|(_, _, reference)| reference.name));
    knowns.extend(knowns_of_start(model));
    knowns
}

fn references(model: &ClosedLoop) -> impl Iterator<Item = Variable> {
    let actuators = actuators(model);
    let own = move |quantity: Own| quantity.number(actuators);
    let knowns = knowns_of_first_tick(model);
    let tracked = model.tracked();
    let Signal { name, unit, nominal, .. } = SIGNALS[tracked];
    let measured = |m: &ClosedLoop, index| {
        if index == DEPTH { m.plant.state().depth } else { m.plant.state().motion.theta }
    };
    let error = Variable::real(
        "tracking_error",
        format!("{name}_reference_used minus {name}"),
        move |m| m.axes[0].autopilot().references()[tracked] - measured(m, tracked),
        Role::output(),
    )
    .unit(unit)
    .depends_on(&[name])
    .initially_depends_on(&knowns)
    .nominal(nominal)
    .quantity(own(Own::TrackingError));
    let used = followed(model).map(move |(index, signal, reference)| {
        Variable::real(
            format!("{}_used", reference.name),
            format!(
                "{} at the last tick, from the manoeuvre or the input, within the envelope",
                reference.description
            ),
            move |m: &ClosedLoop| m.reference_used(index),
            Role::output(),
        )
        .unit(signal.unit)
        .depends_on(&[])
        .initially_depends_on(&knowns)
        .discrete()
        .nominal(signal.nominal)
        .quantity(own(Own::ReferenceUsed(index)))
    });
    used.chain([error])
}
