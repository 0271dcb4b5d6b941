//! The part of the table of variables that model exchange needs.

use auv::Actuator;

use crate::variables::{GIVEN_SPEED, external, knowns_of_trim};
use crate::{PlantModel, Quantity, WAVES};

type Variable = fmi2::Variable<PlantModel>;
type Role<T> = fmi2::Role<PlantModel, T>;

/// For model exchange: the two states that are not outputs, and the rates of all states in the order of the states.
pub fn states(model: &PlantModel) -> Vec<Variable> {
    let waves: &[&str] = if model.can_meet_waves() { &WAVES } else { &[] };
    let knowns = [&knowns_of_trim(model)[..], &["current_horizontal", "current_vertical"], waves].concat();
    let over_ground = |name: &str, description: &str, quantity: Quantity, get: fn(&PlantModel) -> f64| {
        Variable::real(name, description, get, Role::local())
            .unit("m/s")
            .nominal(1.0)
            .initially_depends_on(&knowns)
            .quantity(quantity.number())
    };
    let mut table = vec![
        over_ground(
            "surge_over_ground",
            "velocity over ground along the body axis, forward",
            Quantity::SurgeOverGround,
            |m| m.instant().surge,
        ),
        over_ground(
            "heave_over_ground",
            "velocity over ground across the body axis, down",
            Quantity::HeaveOverGround,
            |m| m.instant().heave,
        ),
    ];
    table.extend(rates(model));
    table.extend(model.lagging().map(|index| output_rate(index, &model.vehicle().actuators[index])));
    table
}

/// The name of a rate, the state and unit, how to read it, and its quantity.
type Rate = (&'static str, &'static str, fn(&PlantModel) -> f64, Quantity);

fn rates(model: &PlantModel) -> Vec<Variable> {
    const DYNAMIC: [Rate; 3] = [
        ("surge_over_ground", "m/s2", |m| m.rates().surge, Quantity::SurgeAcceleration),
        ("heave_over_ground", "m/s2", |m| m.rates().heave, Quantity::HeaveAcceleration),
        ("pitch_rate", "rad/s2", |m| m.rates().pitch_rate, Quantity::PitchAcceleration),
    ];
    const TURNING: Rate = ("pitch", "rad/s", |m| m.rates().pitch, Quantity::RateOfPitch);
    const KINEMATIC: [Rate; 2] = [
        ("distance", "m/s", |m| m.rates().distance, Quantity::RateOfDistance),
        ("depth", "m/s", |m| m.rates().depth, Quantity::RateOfDepth),
    ];
    let motion = ["surge_over_ground", "heave_over_ground", "pitch_rate", "pitch", "depth"];
    let inputs = ["current_horizontal", "current_vertical", "operating_speed"];
    let forces: Vec<String> = model.vehicle().actuators.iter().map(force_of).collect();
    let forces = forces.iter().map(String::as_str);
    let given = model.takes_a_speed().then_some(GIVEN_SPEED);
    let external = external(model).map(|(_, name, ..)| name);
    let waves = model.can_meet_waves().then_some("distance");
    let of_dynamics: Vec<&str> =
        motion.into_iter().chain(waves).chain(inputs).chain(given).chain(external).chain(forces).collect();
    let of_kinematics = ["surge_over_ground", "heave_over_ground", "pitch"];
    let of_turning = if model.lpv().turns_with_pitch_rate_alone() {
        &["pitch_rate", "operating_speed"][..]
    } else {
        &of_dynamics
    };
    let all = DYNAMIC.iter().map(|rate| (rate, &of_dynamics[..])).chain([(&TURNING, of_turning)]);
    let all = all.chain(KINEMATIC.iter().map(|rate| (rate, &of_kinematics[..])));
    all.map(|(&(state, unit, get, quantity), knowns)| {
        rate(state, unit, get).depends_on(knowns).quantity(quantity.number())
    })
    .collect()
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
