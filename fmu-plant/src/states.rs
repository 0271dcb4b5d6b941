//! The part of the table of variables that model exchange needs.

use squid_auv::{Actuator, place};

use crate::variables::{GIVEN_SPEED, external, knowns_of_trim, of_current};
use crate::{PlantModel, Quantity, WAVES};

type Variable = squid_fmi2::Variable<PlantModel>;
type Role<T> = squid_fmi2::Role<PlantModel, T>;

/// For model exchange: the velocities over ground, which are no outputs, and the rates of all states in the order of
/// the states.
pub fn states(model: &PlantModel) -> Vec<Variable> {
    let waves: &[&str] = if model.can_meet_waves() { &WAVES } else { &[] };
    let heading: &[&str] = if model.turns() { &["initial_heading"] } else { &[] };
    let knowns = [&knowns_of_trim(model)[..], heading, of_current(model), waves].concat();
    let directions = [
        (place::SURGE, "along the body axis, forward"),
        (place::SWAY, "across the body axis, to starboard"),
        (place::HEAVE, "across the body axis, down"),
    ];
    let over_ground = directions.into_iter().filter(|(place, _)| model.places().contains(place));
    let over_ground = over_ground.map(|(place, direction)| {
        let description = format!("velocity over ground {direction}");
        Variable::real(model.state_name(place), description, move |m| m.instant().state[place], Role::local())
            .unit("m/s")
            .nominal(1.0)
            .initially_depends_on(&knowns)
            .quantity(Quantity::State(place).number())
    });
    let mut table: Vec<Variable> = over_ground.collect();
    table.extend(model.places().iter().map(|place| motion_rate(model, *place)));
    table.extend(model.lagging().map(|index| output_rate(index, &model.vehicle().actuators[index])));
    table
}

impl PlantModel {
    /// The places of the states that the vehicle has.
    pub(crate) fn places(&self) -> &'static [usize] {
        static ALL: [usize; place::STATES] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11];
        static PLANE: [usize; 6] =
            [place::SURGE, place::HEAVE, place::Q, place::PITCH, place::NORTH, place::DEPTH];
        if self.turns() { &ALL } else { &PLANE }
    }

    /// The name of a state.
    fn state_name(&self, place: usize) -> &'static str {
        const NAMES: [&str; place::STATES] = [
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
        match place {
            place::Q if !self.turns() => "pitch_rate",
            place::NORTH if !self.turns() => "distance",
            _ => NAMES[place],
        }
    }
}

/// The rate of a state of the motion.
fn motion_rate(model: &PlantModel, place: usize) -> Variable {
    let (unit, places): (_, &[usize]) = match place {
        place::ROLL => ("rad/s", &[place::P, place::Q, place::R, place::ROLL, place::PITCH]),
        place::PITCH if model.turns() => ("rad/s", &[place::Q, place::R, place::ROLL]),
        place::PITCH => ("rad/s", &[place::Q]),
        place::HEADING => ("rad/s", &[place::Q, place::R, place::ROLL, place::PITCH]),
        place::DEPTH => ("m/s", &[place::SURGE, place::SWAY, place::HEAVE, place::ROLL, place::PITCH]),
        place::NORTH | place::EAST => {
            ("m/s", &[place::SURGE, place::SWAY, place::HEAVE, place::ROLL, place::PITCH, place::HEADING])
        }
        place::SURGE | place::SWAY | place::HEAVE => ("m/s2", &[]),
        _ => ("rad/s2", &[]),
    };
    let linear = !model.turns() && place == place::PITCH;
    let of_dynamics = places.is_empty() || (linear && !model.lpv().turns_with_pitch_rate_alone());
    let mut knowns: Vec<String> =
        if of_dynamics { knowns_of_dynamics(model) } else { names(model, places).collect() };
    if linear && !of_dynamics {
        knowns.push("operating_speed".into());
    }
    let knowns: Vec<&str> = knowns.iter().map(String::as_str).collect();
    rate(model.state_name(place), unit, move |m| m.rates()[place])
        .depends_on(&knowns)
        .quantity(Quantity::Rate(place).number())
}

/// The names of those states that the vehicle has.
fn names<'a>(model: &'a PlantModel, places: &'a [usize]) -> impl Iterator<Item = String> {
    let own = places.iter().filter(|place| model.places().contains(place));
    own.map(|place| model.state_name(*place).to_owned())
}

/// On what the accelerations depend.
fn knowns_of_dynamics(model: &PlantModel) -> Vec<String> {
    let place_matters = |place: &usize| match *place {
        place::NORTH | place::EAST => model.can_meet_waves(),
        _ => true,
    };
    let states: Vec<usize> = model.places().iter().copied().filter(place_matters).collect();
    let operating_speed = (!model.turns()).then_some("operating_speed");
    let given = model.takes_a_speed().then_some(GIVEN_SPEED);
    let external = external(model).map(|(_, name, ..)| name);
    let inputs = of_current(model).iter().copied().chain(operating_speed).chain(given).chain(external);
    let forces = model.vehicle().actuators.iter().map(force_of);
    names(model, &states).chain(inputs.map(str::to_owned)).chain(forces).collect()
}

/// The variable that determines the force of an actuator: its output if that is a state, its command without lag.
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
