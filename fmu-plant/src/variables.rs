//! Table of variables, in three parts; the fourth is in `states.rs`.
//!
//! Inputs act immediately, in co-simulation and model exchange: velocities through the water depend on the current,
//! and an actuator without lag follows its command. A master has an algebraic loop only if commands depend on such a
//! quantity. Initial values of the other outputs depend on parameters only.

use squid_auv::{Actuator, Allowed, COEFFICIENTS, CoefficientSpec, Fidelity, Surge, index};
use squid_fmi2::model_description::Enumeration;
use squid_sea::Spectrum;

use crate::{PlantModel, Quantity, WAVES};

type Variable = squid_fmi2::Variable<PlantModel>;
type Role<T> = squid_fmi2::Role<PlantModel, T>;

impl PlantModel {
    /// Returns the type of the parameter `fidelity`; empty for a vehicle in six degrees of freedom, which does not have
    /// it.
    pub fn fidelities(&self) -> Vec<Enumeration> {
        if self.has_six_dof() { vec![] } else { vec![fidelities()] }
    }
}

fn fidelities() -> Enumeration {
    let items = [
        ("nonlinear", "the nonlinear equations of motion"),
        ("lpv", "the LPV model about the trim at operating_speed, with the coefficients of the vehicle file"),
    ];
    Enumeration::new("Fidelity", "which equations of motion are integrated", &items)
}

/// An input with the name of its field and of the field of its rate.
macro_rules! input {
    ($name:expr, $description:expr, $quantity:expr, $($field:ident).+) => {
        Variable::real(
            $name,
            $description,
            |m| m.inputs.$($field).+,
            Role::input(|m: &mut PlantModel, v| m.inputs.$($field).+ = v),
        )
        .unit("m/s")
        .nominal(1.0)
        .quantity($quantity.number())
        .slope(|m, v| m.slopes.$($field).+ = v)
    };
}

/// A parameter with the name of its field.
macro_rules! parameter {
    ($name:expr, $unit:literal, $description:expr, $($field:ident).+) => {
        Variable::real(
            $name,
            $description,
            |m| m.settings.$($field).+,
            Role::parameter(|m, v| m.settings.$($field).+ = v),
        )
        .unit($unit)
    };
}

/// Returns the inputs: commands, current, operating speed of the LPV model, prescribed speed and external load.
pub fn inputs(model: &PlantModel) -> Vec<Variable> {
    let commands = model.vehicle().actuators.iter().enumerate().map(|(i, actuator)| command(i, actuator));
    let operating_speed = "speed along the path through the water, V, at whose trim the LPV model is evaluated; not \
                           used if fidelity is nonlinear";
    let operating_speed = (!model.has_six_dof()).then(|| {
        ahead(model, input!("operating_speed", operating_speed, Quantity::OperatingSpeed, operating_speed))
    });
    commands
        .chain(current(model))
        .chain(operating_speed)
        .chain(given_speed(model))
        .chain(external_load(model))
        .collect()
}

/// Returns the names of the current's inputs.
pub fn of_current(model: &PlantModel) -> &'static [&'static str] {
    if model.has_six_dof() {
        &["current_north", "current_east", "current_vertical"]
    } else {
        &["current_horizontal", "current_vertical"]
    }
}

fn current(model: &PlantModel) -> Vec<Variable> {
    let down = "vertical velocity of the current, positive downwards";
    let down = input!("current_vertical", down, Quantity::Current(2), current.vertical);
    if !model.has_six_dof() {
        let horizontal = "horizontal velocity of the current, positive in the direction of distance";
        return vec![
            input!("current_horizontal", horizontal, Quantity::Current(0), current.horizontal),
            down,
        ];
    }
    let (north, east) = ("velocity of the current, north", "velocity of the current, east");
    vec![
        input!("current_north", north, Quantity::Current(0), current.horizontal),
        input!("current_east", east, Quantity::Current(1), current.east),
        down,
    ]
}

/// External load: index in X Y Z K M N, name, unit and description.
type External = (usize, &'static str, &'static str, &'static str);

/// Returns the external loads that act; with a prescribed speed a force along the hull does not.
pub(crate) fn external(model: &PlantModel) -> impl Iterator<Item = External> {
    let ahead = "external force at the origin of the body, along the body axis, positive forward";
    let down = "external force at the origin of the body, along the body z axis, positive downwards";
    let bow_up = "external pitch moment about the origin of the body, positive bow up";
    let aside = "external force at the origin of the body, along the body y axis, positive to starboard";
    let rolling = "external roll moment about the origin of the body, positive starboard down";
    let yawing = "external yaw moment about the origin of the body, positive bow to starboard";
    let all = if model.has_six_dof() {
        vec![
            (0, "external_force_x", "N", ahead),
            (1, "external_force_y", "N", aside),
            (2, "external_force_z", "N", down),
            (3, "external_moment_x", "N.m", rolling),
            (4, "external_moment_y", "N.m", bow_up),
            (5, "external_moment_z", "N.m", yawing),
        ]
    } else {
        vec![
            (0, "external_force_x", "N", ahead),
            (2, "external_force_z", "N", down),
            (4, "external_moment", "N.m", bow_up),
        ]
    };
    let first = usize::from(model.has_given_speed());
    all.into_iter().skip(first)
}

fn external_load(model: &PlantModel) -> impl Iterator<Item = Variable> {
    external(model).map(|(axis, name, unit, meaning)| {
        let set = move |m: &mut PlantModel, v| m.inputs.load[axis] = v;
        Variable::real(name, meaning, move |m| m.inputs.load[axis], Role::input(set))
            .unit(unit)
            .nominal(10.0)
            .quantity(Quantity::External(axis).number())
            .slope(move |m, v| m.slopes.load[axis] = v)
    })
}

/// Sets a lower bound of zero on a speed if the vehicle has trims for ahead motion only.
fn ahead(model: &PlantModel, speed: Variable) -> Variable {
    if model.only_ahead() { speed.at_least(0.0) } else { speed }
}

/// Returns the input of the prescribed speed, for a vehicle without surge dynamics.
fn given_speed(model: &PlantModel) -> Option<Variable> {
    let Surge::Given { lag } = model.vehicle().coefficients.surge else { return None };
    let description =
        format!("imposed forward speed through the water; speed follows it with a lag of {lag} s");
    Some(input!(GIVEN_SPEED, description, Quantity::GivenSpeed, given_speed))
}

/// Name of the input of the prescribed speed.
pub const GIVEN_SPEED: &str = "given_speed";

fn command(index: usize, actuator: &Actuator) -> Variable {
    let through = if actuator.curve.is_some() { ", which its curve converts to a thrust" } else { "" };
    let sign = actuator.effect_of_sign().map_or(String::new(), |sign| format!("; {sign}"));
    let description = format!("command to {}{through}; clamped to its limits{sign}", actuator.name);
    let (least, most) = (actuator.input_for(actuator.min).0, actuator.input_for(actuator.max).0);
    let get = move |m: &PlantModel| m.inputs.commands[index];
    let set = move |m: &mut PlantModel, v| m.inputs.commands[index] = v;
    Variable::real(&actuator.name, description, get, Role::input(set))
        .unit(actuator.input_unit())
        .range(least, most)
        .nominal(least.abs().max(most.abs()))
        .quantity(Quantity::command(index))
        .slope(move |m, v| m.slopes.commands[index] = v)
}

/// Returns the outputs: motion, position, actuator outputs, and the initial trim.
pub fn outputs(model: &PlantModel) -> Vec<Variable> {
    let mut table = motion(model);
    if model.has_six_dof() {
        table.extend(out_of_plane(model));
    }
    table.extend(position(model));
    for (index, actuator) in model.vehicle().actuators.iter().enumerate() {
        table.push(actuator_output(model, index, actuator));
    }
    for (index, actuator) in model.vehicle().actuators.iter().enumerate() {
        table.push(trim_output(model, index, actuator));
    }
    table.push(
        output("trim_pitch", "pitch angle of level trim at initial_speed and initial_depth", "rad", |m| {
            m.trim.pitch
        })
        .discrete()
        .nominal(0.1)
        .initially_depends_on(&knowns_of_trim(model)),
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

/// Adds the dependencies of a velocity through the water: velocity over ground, angles, current, and position in waves.
fn through_water(model: &PlantModel, one: Variable, quantity: Quantity, own: &[&str]) -> Variable {
    let angles: &[&str] = if model.has_six_dof() { &["roll", "pitch", "heading"] } else { &["pitch"] };
    let position: &[&str] = match (model.supports_waves(), model.has_six_dof()) {
        (false, _) => &[],
        (true, false) => &["distance", "depth"],
        (true, true) => &["north", "east", "depth"],
    };
    let knowns = [own, angles, of_current(model), position].concat();
    one.depends_on(&knowns).initially_depends_on(&knowns_of_trim(model)).quantity(quantity.number())
}

/// Returns the motion through the water in the vertical plane.
fn motion(model: &PlantModel) -> Vec<Variable> {
    let trim = knowns_of_trim(model);
    let speed = output("speed", "forward speed through the water, along the body axis (u)", "m/s", |m| {
        m.state().motion.u
    });
    let heave =
        output("heave", "heave velocity through the water, positive down in the body (w)", "m/s", |m| {
            m.state().motion.w
        });
    let path = if model.has_six_dof() {
        "speed along the path through the water, V = sqrt(u^2 + v^2 + w^2)"
    } else {
        "speed along the path through the water, V = sqrt(u^2 + w^2)"
    };
    let path_speed = output("path_speed", path, "m/s", |m| m.path_speed());
    let pitch_rate = if model.has_six_dof() {
        output("pitch_rate", "pitch rate, theta'", "rad/s", |m| m.state().motion.turning()[1])
            .depends_on(&["roll", "angular_velocity_y", "angular_velocity_z"])
            .quantity(Quantity::PitchRate.number())
    } else {
        state("pitch_rate", "pitch rate (q)", "rad/s", index::Q, |m| m.state().motion.q)
    };
    let of_path: &[&str] = if model.has_six_dof() {
        &["surge_over_ground", "sway_over_ground", "heave_over_ground"]
    } else {
        &["surge_over_ground", "heave_over_ground"]
    };
    let through = |one: Variable, quantity: Quantity, own: &[&str]| through_water(model, one, quantity, own);
    vec![
        state("pitch", "pitch angle, positive bow up", "rad", index::PITCH, |m| m.state().motion.theta)
            .nominal(0.1)
            .initially_depends_on(&trim),
        through(speed.nominal(1.0), Quantity::Speed, &["surge_over_ground"]),
        pitch_rate.nominal(0.1).initially_depends_on(&[]),
        through(heave.nominal(0.1), Quantity::Heave, &["heave_over_ground"]),
        through(path_speed.at_least(0.0).nominal(1.0), Quantity::PathSpeed, of_path),
    ]
}

/// Returns the motion out of the vertical plane.
fn out_of_plane(model: &PlantModel) -> Vec<Variable> {
    let sway = output("sway", "sway velocity through the water, positive to starboard (v)", "m/s", |m| {
        m.state().motion.v
    });
    let heading_rate =
        output("heading_rate", "heading rate, psi'", "rad/s", |m| m.state().motion.turning()[2])
            .depends_on(&["roll", "pitch", "angular_velocity_y", "angular_velocity_z"])
            .quantity(Quantity::HeadingRate.number());
    let roll_rate = output("roll_rate", "roll rate, phi'", "rad/s", |m| m.state().motion.turning()[0])
        .depends_on(&["roll", "pitch", "angular_velocity_x", "angular_velocity_y", "angular_velocity_z"])
        .quantity(Quantity::RollRate.number());
    let sway = through_water(model, sway.nominal(0.1), Quantity::Sway, &["sway_over_ground"]);
    let of = |name, what, unit, index, get: fn(&PlantModel) -> f64| {
        state(name, what, unit, index, get).nominal(0.1).initially_depends_on(&[])
    };
    vec![
        state("heading", "heading, clockwise from north, not wrapped", "rad", index::HEADING, |m| {
            m.state().heading
        })
        .nominal(1.0)
        .initially_depends_on(&["initial_heading"]),
        heading_rate.nominal(0.1).initially_depends_on(&[]),
        of("roll", "roll angle, positive starboard down", "rad", index::ROLL, |m| m.state().motion.phi),
        roll_rate.nominal(0.1).initially_depends_on(&[]),
        sway.initially_depends_on(&[]),
        of("angular_velocity_x", "angular velocity about the body's x axis (p)", "rad/s", index::P, |m| {
            m.state().motion.p
        }),
        of("angular_velocity_y", "angular velocity about the body's y axis (q)", "rad/s", index::Q, |m| {
            m.state().motion.q
        }),
        of("angular_velocity_z", "angular velocity about the body's z axis (r)", "rad/s", index::R, |m| {
            m.state().motion.r
        }),
    ]
}

/// Returns an output that is also a state, with its index in [`squid_auv::index`].
fn state(
    name: &str,
    description: &str,
    unit: &str,
    index: usize,
    get: impl Fn(&PlantModel) -> f64 + Send + Sync + 'static,
) -> Variable {
    output(name, description, unit, get).depends_linearly_on(name).quantity(Quantity::State(index).number())
}

fn position(model: &PlantModel) -> Vec<Variable> {
    let depth = state("depth", "depth of the origin of the body", "m", index::DEPTH, |m| m.state().depth)
        .initially_depends_on(&["initial_depth"]);
    let made = |name, what, index, get: fn(&PlantModel) -> f64| {
        state(name, what, "m", index, get).initially_depends_on(&[])
    };
    let (over, knowns): (&[&str], &[&str]) = if model.has_six_dof() {
        (&["depth", "north", "east"], &["initial_depth", "bottom_depth"])
    } else {
        (&["depth", "distance"], &["initial_depth", "bottom_depth"])
    };
    let altitude = output("altitude", "height above the bottom", "m", |m| {
        let state = m.state();
        state.bottom - state.depth
    });
    let altitude =
        altitude.depends_on(over).initially_depends_on(knowns).quantity(Quantity::Altitude.number());
    let mut table = vec![depth, altitude];
    if model.has_six_dof() {
        table.push(made("north", "distance travelled north over ground", index::NORTH, |m| m.state().x));
        table.push(made("east", "distance travelled east over ground", index::EAST, |m| m.state().east));
    } else {
        table.push(made("distance", "horizontal distance travelled over ground", index::NORTH, |m| {
            m.state().x
        }));
    }
    table.into_iter().map(|one| one.nominal(10.0)).collect()
}

fn actuator_output(model: &PlantModel, index: usize, actuator: &Actuator) -> Variable {
    let Actuator { name, min, max, lag, rate, .. } = actuator;
    let own = format!("{name}_output");
    let unit = actuator.unit();
    let no_faster = rate.map_or(String::new(), |rate| format!(", rate limited to {rate} {unit}/s"));
    let description = format!("output of {name}, after limits and lag{no_faster}");
    let one = output(&own, &description, unit, move |m| m.actuator_outputs()[index])
        .range(*min, *max)
        .nominal(actuator.reach())
        .quantity(Quantity::output(index));
    if *lag > 0.0 {
        one.depends_linearly_on(&own).initially_depends_on(&knowns_of_trim(model))
    } else {
        one.depends_on(&[name]).initially_depends_on(&[name])
    }
}

fn trim_output(model: &PlantModel, index: usize, actuator: &Actuator) -> Variable {
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
    .initially_depends_on(&knowns_of_trim(model))
}

pub(crate) fn knowns_of_trim(model: &PlantModel) -> Vec<&'static str> {
    let coefficients = model.vehicle().coefficients.acting().map(|spec| spec.key);
    ["initial_speed", "initial_depth"].into_iter().chain(coefficients).collect()
}

/// Coefficients that can be changed in flight, for drop weights and buoyancy engines.
const TUNABLE: [&str; 4] = ["weight", "buoyancy", "x_G", "z_G"];

/// Returns the parameters: initial conditions, fidelity, seabed, waves, and every coefficient that acts on the vehicle.
pub fn parameters(model: &PlantModel) -> Vec<Variable> {
    let sign = if model.only_ahead() { "above zero" } else { "negative astern" };
    let speed = format!("initial speed along the path through the water, in level trim, {sign}");
    let mut table = vec![
        ahead(model, parameter!("initial_speed", "m/s", speed, initial_speed)).nominal(1.0),
        parameter!("initial_depth", "m", "initial depth", initial_depth).at_least(0.0).nominal(10.0),
    ];
    if model.has_six_dof() {
        let heading = "initial heading, clockwise from north";
        table.push(parameter!("initial_heading", "rad", heading, initial_heading).nominal(1.0));
    } else {
        table.push(Variable::enumeration(
            "fidelity",
            "which equations of motion are integrated",
            &fidelities(),
            |m| number_of(m.settings.fidelity),
            Role::parameter(|m, v| m.settings.fidelity = fidelity_of(v)),
        ));
    }
    table.extend(bottom(model));
    table.extend(waves(model));
    let lateral = COEFFICIENTS.iter().filter(|spec| model.has_six_dof() && spec.acts_out_of_plane());
    let all = model.vehicle().coefficients.acting().chain(lateral);
    table.extend(all.map(|spec| coefficient(spec, model)));
    table
}

/// Returns the parameters of the seabed.
fn bottom(model: &PlantModel) -> Vec<Variable> {
    let ahead = if model.has_six_dof() { "to the north" } else { "ahead" };
    let north = format!("increase of bottom depth per metre {ahead}");
    let mut table = vec![
        parameter!("bottom_depth", "m", "depth of the bottom at the initial position", bottom.depth)
            .nominal(100.0),
        parameter!("bottom_slope_north", "1", north, bottom.north).nominal(0.1),
    ];
    if model.has_six_dof() {
        let east = "increase of bottom depth per metre to the east";
        table.push(parameter!("bottom_slope_east", "1", east, bottom.east).nominal(0.1));
    }
    table
}

/// Returns the parameters of the waves; none if the dimensions of the vehicle are unknown.
fn waves(model: &PlantModel) -> Vec<Variable> {
    if !model.supports_waves() {
        return vec![];
    }
    let [height, period, gamma, heading, seed] = WAVES;
    let of_height = "significant height of the waves, a long-crested sea with JONSWAP spectrum; 0 for none; limited \
                     by breaking at the longest peak period";
    let of_period =
        "peak period of the waves, 0.5 to 30 s, and long enough for the height: steeper waves break";
    let of_gamma = "peak enhancement of the spectrum: 1 for a fully developed sea (Pierson and Moskowitz), 3.3 on \
                    average";
    let of_heading = if model.has_six_dof() {
        "propagation direction of the waves, clockwise from north"
    } else {
        "propagation direction of the waves relative to the heading: pi for a head sea, 0 for a following sea"
    };
    vec![
        parameter!(height, "m", of_height, waves.height).range(0.0, Spectrum::highest()).nominal(1.0),
        parameter!(period, "s", of_period, waves.period).range(0.5, 30.0).nominal(10.0),
        parameter!(gamma, "1", of_gamma, waves.gamma).range(1.0, 7.0).nominal(1.0),
        parameter!(heading, "rad", of_heading, waves.heading).nominal(1.0),
        Variable::integer(
            seed,
            "seed of the frequencies and phases of the waves, at least 0",
            |m| m.settings.waves.seed,
            Role::parameter(|m, v| m.settings.waves.seed = v),
        )
        .at_least(0.0),
    ]
}

fn number_of(fidelity: Fidelity) -> i32 {
    match fidelity {
        Fidelity::Nonlinear => 1,
        Fidelity::Lpv => 2,
    }
}

/// Returns the fidelity of a number that is valid for the items of [`fidelities`].
fn fidelity_of(number: i32) -> Fidelity {
    if number == 2 { Fidelity::Lpv } else { Fidelity::Nonlinear }
}

fn coefficient(spec: &'static CoefficientSpec, model: &PlantModel) -> Variable {
    let source = model.vehicle().sources.get(spec.key).map_or("default value", String::as_str);
    let above_zero = if spec.allowed == Allowed::Positive { ", above zero" } else { "" };
    let in_flight = match spec.key {
        "weight" => ", tunable; the mass changes with it",
        key if TUNABLE.contains(&key) => ", tunable",
        _ => "",
    };
    let description = format!("{}{above_zero}{in_flight}; source: {source}", spec.meaning);
    let get = |m: &PlantModel| (spec.get)(&m.settings.coefficients);
    let set = |m: &mut PlantModel, v| (spec.set)(&mut m.settings.coefficients, v);
    let size = get(model).abs();
    let role = if TUNABLE.contains(&spec.key) { Role::tunable(set) } else { Role::parameter(set) };
    let variable = Variable::real(spec.key, description, get, role).unit(spec.unit);
    let variable = if size > 0.0 { variable.nominal(size) } else { variable };
    match spec.allowed {
        Allowed::Any => variable,
        Allowed::Positive | Allowed::NonNegative => variable.at_least(0.0),
        Allowed::NonPositive => variable.at_most(0.0),
    }
}
