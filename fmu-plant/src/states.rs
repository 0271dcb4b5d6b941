//! Rows of the table of variables that model exchange needs.

use squid_auv::{Actuator, index};

use crate::variables::{GIVEN_SPEED, external, knowns_of_trim, of_current};
use crate::{PlantModel, Quantity, WAVES};

type Variable = squid_fmi2::Variable<PlantModel>;
type Role<T> = squid_fmi2::Role<PlantModel, T>;

/// Returns the variables for model exchange: the velocities over ground, which are not outputs, and the derivatives of
/// all states in the order of the states.
pub fn states(model: &PlantModel) -> Vec<Variable> {
    let waves: &[&str] = if model.supports_waves() { &WAVES } else { &[] };
    let heading: &[&str] = if model.has_six_dof() { &["initial_heading"] } else { &[] };
    let knowns = [&knowns_of_trim(model)[..], heading, of_current(model), waves].concat();
    let directions = [
        (index::SURGE, "along the body axis, forward"),
        (index::SWAY, "along the body y axis, to starboard"),
        (index::HEAVE, "along the body z axis, downwards"),
    ];
    let over_ground = directions.into_iter().filter(|(state_index, _)| model.indices().contains(state_index));
    let over_ground = over_ground.map(|(state_index, direction)| {
        let description = format!("velocity over ground {direction}");
        Variable::real(
            model.state_name(state_index),
            description,
            move |m| m.instant().state[state_index],
            Role::local(),
        )
        .unit("m/s")
        .nominal(1.0)
        .initially_depends_on(&knowns)
        .quantity(Quantity::State(state_index).number())
    });
    let mut table: Vec<Variable> = over_ground.collect();
    table.extend(model.indices().iter().map(|state_index| motion_rate(model, *state_index)));
    table.extend(model.lagging().map(|index| output_rate(index, &model.vehicle().actuators[index])));
    table
}

impl PlantModel {
    /// Returns the indices of the states of this vehicle.
    pub(crate) fn indices(&self) -> &'static [usize] {
        static ALL: [usize; index::STATES] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11];
        static PLANE: [usize; 6] =
            [index::SURGE, index::HEAVE, index::Q, index::PITCH, index::NORTH, index::DEPTH];
        if self.has_six_dof() { &ALL } else { &PLANE }
    }

    /// Returns the name of a state.
    fn state_name(&self, index: usize) -> &'static str {
        const NAMES: [&str; index::STATES] = [
            "surge_over_ground",
            "sway_over_ground",
            "heave_over_ground",
            "angular_velocity_x",
            "angular_velocity_y",
            "angular_velocity_z",
            "roll",
            "pitch",
            "heading",
            "north",
            "east",
            "depth",
        ];
        match index {
            index::Q if !self.has_six_dof() => "pitch_rate",
            index::NORTH if !self.has_six_dof() => "distance",
            _ => NAMES[index],
        }
    }
}

/// Returns the variable for the derivative of a state of the motion.
fn motion_rate(model: &PlantModel, index: usize) -> Variable {
    let (unit, indices): (_, &[usize]) = match index {
        index::ROLL => ("rad/s", &[index::P, index::Q, index::R, index::ROLL, index::PITCH]),
        index::PITCH if model.has_six_dof() => ("rad/s", &[index::Q, index::R, index::ROLL]),
        index::PITCH => ("rad/s", &[index::Q]),
        index::HEADING => ("rad/s", &[index::Q, index::R, index::ROLL, index::PITCH]),
        index::DEPTH => ("m/s", &[index::SURGE, index::SWAY, index::HEAVE, index::ROLL, index::PITCH]),
        index::NORTH | index::EAST => {
            ("m/s", &[index::SURGE, index::SWAY, index::HEAVE, index::ROLL, index::PITCH, index::HEADING])
        }
        index::SURGE | index::SWAY | index::HEAVE => ("m/s2", &[]),
        _ => ("rad/s2", &[]),
    };
    let linear = !model.has_six_dof() && index == index::PITCH;
    let of_dynamics = indices.is_empty() || (linear && !model.lpv().turns_with_pitch_rate_alone());
    let mut knowns: Vec<String> =
        if of_dynamics { knowns_of_dynamics(model) } else { names(model, indices).collect() };
    if linear && !of_dynamics {
        knowns.push("operating_speed".into());
    }
    let knowns: Vec<&str> = knowns.iter().map(String::as_str).collect();
    rate(model.state_name(index), unit, move |m| m.rates()[index])
        .depends_on(&knowns)
        .quantity(Quantity::Rate(index).number())
}

/// Returns the names of those states that this vehicle has.
fn names<'a>(model: &'a PlantModel, indices: &'a [usize]) -> impl Iterator<Item = String> {
    let own = indices.iter().filter(|index| model.indices().contains(index));
    own.map(|index| model.state_name(*index).to_owned())
}

/// Returns the names of the variables on which the accelerations depend.
fn knowns_of_dynamics(model: &PlantModel) -> Vec<String> {
    let has_effect = |index: &usize| match *index {
        index::NORTH | index::EAST => model.supports_waves(),
        _ => true,
    };
    let states: Vec<usize> = model.indices().iter().copied().filter(has_effect).collect();
    let operating_speed = (!model.has_six_dof()).then_some("operating_speed");
    let given = model.has_given_speed().then_some(GIVEN_SPEED);
    let external = external(model).map(|(_, name, ..)| name);
    let inputs = of_current(model).iter().copied().chain(operating_speed).chain(given).chain(external);
    let forces = model.vehicle().actuators.iter().map(force_of);
    names(model, &states).chain(inputs.map(str::to_owned)).chain(forces).collect()
}

/// Returns the variable that determines the force of an actuator: its output if that is a state, else its command.
fn force_of(actuator: &Actuator) -> String {
    if actuator.lag > 0.0 { format!("{}_output", actuator.name) } else { actuator.name.clone() }
}

fn output_rate(index: usize, actuator: &Actuator) -> Variable {
    let (own, unit) = (format!("{}_output", actuator.name), format!("{}/s", actuator.unit()));
    let one = rate(&own, &unit, move |m| m.output_rate(index)).quantity(Quantity::output_rate(index));
    match actuator.rate {
        None => one.depends_on(&[&actuator.name]).depends_linearly_on(&own),
        Some(_) => one.depends_on(&[&actuator.name, &own]),
    }
}

fn rate(state: &str, unit: &str, get: impl Fn(&PlantModel) -> f64 + Send + Sync + 'static) -> Variable {
    let description = format!("time derivative of {state}");
    Variable::real(format!("der({state})"), description, get, Role::local()).unit(unit).derivative_of(state)
}
