//! A Squid with a manually tuned controller, and any model simulated without the C interface.

#![allow(dead_code, reason = "not every test needs everything")]

#[path = "../../../fmu-plant/tests/common/mod.rs"]
mod plant;
#[path = "../../../crates/scheduled/tests/example/mod.rs"]
mod small;

use std::sync::LazyLock;

use squid_auv::{Speed, Vehicle, trim};
use squid_fmi2::Resources;
use squid_scheduled::*;

pub use plant::{DEPTH, Flight};
pub use small::input;

/// Returns a manoeuvre: ten degrees at 2 s, and a ramp from 0.8 to 2.4 m/s between 3 s and 13 s.
pub fn manoeuvre() -> Manoeuvre {
    Manoeuvre {
        format: MANOEUVRE_FORMAT.to_owned(),
        steps: [("pitch".to_owned(), 10f64.to_radians())].into(),
        step_time: 2.0,
        step_end: 1e9,
        speed_from: 0.8,
        speed_to: 2.4,
        ramp_start: 3.0,
        ramp_duration: 10.0,
        duration: 30.0,
    }
}

/// Returns all four files.
pub fn resources() -> Resources {
    with(&design(), &manoeuvre())
}

/// Returns the files of a vehicle with an actuator without lag.
pub fn without_lag() -> Resources {
    together(plant::squid_without_lag(), &design(), &manoeuvre())
}

/// Returns the files of a vehicle whose thrusters have curves, and of a design with these curves.
pub fn with_curves() -> Resources {
    let files = plant::squid_with_curves();
    let vehicle =
        Vehicle::from_json(files.text(squid_fmu_plant::VEHICLE_RESOURCE).unwrap(), "vehicle").unwrap();
    let mut design = two_degrees();
    for (actuator, one) in design.actuators.iter_mut().zip(vehicle.actuators) {
        actuator.curve = one.curve;
    }
    together(files, &design, &manoeuvre())
}

/// Returns the files of a vehicle with prescribed speed, and of a design for its planes without a speed reference.
pub fn with_given_speed() -> Resources {
    let files = plant::squid_with_given_speed();
    let vehicle =
        Vehicle::from_json(files.text(squid_fmu_plant::VEHICLE_RESOURCE).unwrap(), "vehicle").unwrap();
    let mut design = two_degrees();
    design.controller_inputs.retain(|one| one.signal != "speed");
    for row in [&mut design.lft.by, &mut design.lft.duy, &mut design.lft.dty].into_iter().flatten() {
        row.drain(2..4);
    }
    for (actuator, one) in design.actuators.iter_mut().zip(&vehicle.actuators) {
        (actuator.unit, actuator.scale) = (one.unit().to_owned(), one.max);
        (actuator.minimum, actuator.maximum) = (one.min, one.max);
    }
    (design.speed_given, design.reference_filter, design.trim) = (true, None, trim_table(&vehicle));
    together(files, &design, &manoeuvre())
}

/// Oblique bow waves with a period of 6 s.
pub const SEA: [(&str, f64); 3] = [("wave_height", 1.0), ("wave_period", 6.0), ("wave_heading", 2.5)];

/// Returns the files of a vehicle in six degrees of freedom, with a heading design besides [`two_degrees`], and a
/// manoeuvre with a turn of 20 degrees.
pub fn turning() -> Resources {
    let files = plant::turning(&plant::squid_with_rudder(), [0.5, 1.75, 3.0]);
    let mut manoeuvre = manoeuvre();
    manoeuvre.steps.insert("heading".to_owned(), 20f64.to_radians());
    let mut resources = together(files, &two_degrees(), &manoeuvre);
    resources.insert(
        &squid_fmu_controller::of_axis(squid_fmu_controller::RESOURCE, 1),
        serde_json::to_string(&of_heading()).unwrap(),
    );
    resources
}

/// Returns a PID on heading with the rudder, damped by the rate of heading, with scheduled proportional gain.
fn of_heading() -> ControllerDesign {
    let port = |signal: &squid_signals::Signal| Port {
        name: signal.name.to_owned(),
        unit: signal.unit.to_owned(),
        measured: signal.measured.to_owned(),
        reference: signal.reference.map(|one| Reference {
            name: one.name.to_owned(),
            description: one.description.to_owned(),
            lag: 0.0,
        }),
        level: signal.level,
        start: 0.0,
        range: signal.range,
        circular: signal.circular,
        nominal: signal.nominal,
    };
    let input = |signal: &str, kind, unit: &str| ControllerInput {
        signal: signal.to_owned(),
        kind,
        unit: unit.to_owned(),
        scale: 0.17,
    };
    let vehicle = plant::squid_with_rudder();
    let rudder = vehicle.actuators.last().unwrap();
    let design = design();
    let (kp, ki, kd) = (-1.2, -0.1, -1.0);
    ControllerDesign {
        design: "heading".to_owned(),
        signals: squid_auv::lateral::SIGNALS.iter().map(port).collect(),
        controller_inputs: vec![
            input("heading", Kind::Reference, "rad"),
            input("heading", Kind::Measurement, "rad"),
            input("heading_rate", Kind::Measurement, "rad/s"),
        ],
        actuators: vec![Actuator {
            name: rudder.name.clone(),
            unit: rudder.unit().to_owned(),
            scale: 0.2,
            minimum: rudder.min,
            maximum: rudder.max,
            curve: None,
            steers: vec![],
            force: Some(rudder.force_per_output()),
            lateral_force: None,
        }],
        lft: LftMatrices {
            blocks: vec![1],
            a: vec![vec![0.0]],
            by: vec![vec![1.0, -1.0, 0.0]],
            bt: vec![vec![0.0]],
            cu: vec![vec![ki]],
            duy: vec![vec![kp, -kp, -kd]],
            dut: vec![vec![-0.5 * kp]],
            ct: vec![vec![0.0]],
            dty: vec![vec![1.0, -1.0, 0.0]],
            dtt: vec![vec![0.1]],
        },
        trim: TrimTable {
            signals: Default::default(),
            actuators: vec![vec![0.0]; design.trim.speed.len()],
            ..design.trim.clone()
        },
        reference_filter: Some(0.5),
        ..design
    }
}

/// Returns the files with the design [`two_degrees`].
pub fn with_two_degrees() -> Resources {
    with(&two_degrees(), &manoeuvre())
}

pub fn with(design: &ControllerDesign, manoeuvre: &Manoeuvre) -> Resources {
    together(plant::squid(), design, manoeuvre)
}

fn together(mut resources: Resources, design: &ControllerDesign, manoeuvre: &Manoeuvre) -> Resources {
    resources.insert(squid_fmu_controller::RESOURCE, serde_json::to_string(design).unwrap());
    resources.insert(MANOEUVRE_RESOURCE, manoeuvre.to_json().unwrap());
    resources
}

/// Returns a design: PID on pitch by differential thrust with scheduled proportional gain, and PI on speed by total
/// thrust.
///
/// The states are the integral of the pitch error, the low-pass filtered pitch error, and the integral of the speed
/// error. Speeds, inputs and sample time are those of the example of `scheduled`. The trims are computed once.
pub fn design() -> ControllerDesign {
    static MADE: LazyLock<ControllerDesign> = LazyLock::new(by_hand);
    MADE.clone()
}

fn by_hand() -> ControllerDesign {
    const LAG: f64 = 0.2;
    // Pitch gain in N m/rad with a lever arm of 0.3 m, speed gain in N s/m on three thrusters; errors are scaled by
    // 0.17 rad and 0.3 m/s, thrusts by 100 N.
    let (of_pitch, of_speed) = (0.17 / 0.3 / 100.0, 0.3 / 3.0 / 100.0);
    let [kp, ki, kd] = [20.0, 10.0, 30.0].map(|gain: f64| gain * of_pitch);
    let [kv, kvi] = [60.0, 12.0].map(|gain: f64| gain * of_speed);
    let rows = |row: fn(f64, [f64; 5]) -> Vec<f64>| {
        [1.0, -0.5, -0.5].map(|side| row(side, [kp, ki, kd, kv, kvi])).to_vec()
    };
    let vehicle = plant::vehicle("squid");
    let actuator = |one: &squid_auv::Actuator| Actuator {
        name: one.name.clone(),
        unit: one.unit().to_owned(),
        scale: 100.0,
        minimum: one.min,
        maximum: one.max,
        curve: one.curve.clone(),
        steers: vec![],
        force: Some(one.force_per_output()),
        lateral_force: None,
    };
    ControllerDesign {
        vehicle: VehicleName { name: vehicle.name.clone(), status: Status::Surrogate },
        design: "by hand".to_owned(),
        actuators: vehicle.actuators.iter().map(actuator).collect(),
        lft: LftMatrices {
            blocks: vec![1],
            a: vec![vec![0.0; 3], vec![0.0, -1.0 / LAG, 0.0], vec![0.0; 3]],
            by: vec![vec![1.0, 0.0], vec![1.0 / LAG, 0.0], vec![0.0, 1.0]],
            bt: vec![vec![0.0]; 3],
            cu: rows(|side, [_, ki, kd, _, kvi]| vec![side * ki, -side * kd / LAG, kvi]),
            duy: rows(|side, [kp, _, kd, kv, _]| vec![side * (kp + kd / LAG), kv]),
            dut: rows(|side, [kp, ..]| vec![0.3 * side * kp]),
            ct: vec![vec![0.0; 3]],
            dty: vec![vec![1.0, 0.0]],
            dtt: vec![vec![0.1]],
        },
        trim: trim_table(&vehicle),
        ..small::design()
    }
}

/// Returns a design with references and measurements as separate inputs, damped by the pitch rate, with a filtered
/// speed reference.
pub fn two_degrees() -> ControllerDesign {
    let mut design = design();
    let (pitch, speed) = (0.17, 0.3);
    design.controller_inputs = vec![
        input("pitch", Kind::Reference, pitch),
        input("pitch", Kind::Measurement, pitch),
        input("speed", Kind::Reference, speed),
        input("speed", Kind::Measurement, speed),
        input("pitch_rate", Kind::Measurement, 0.1),
    ];
    design.reference_filter = Some(0.5);
    let damping = [-0.05, 0.025, 0.025];
    for (rows, rate) in [
        (&mut design.lft.by, [0.0; 3].as_slice()),
        (&mut design.lft.duy, &damping),
        (&mut design.lft.dty, &[0.0]),
    ] {
        for (row, rate) in rows.iter_mut().zip(rate) {
            *row = row.iter().flat_map(|&gain| [gain, -gain]).chain([*rate]).collect();
        }
    }
    design
}

fn trim_table(vehicle: &Vehicle) -> TrimTable {
    let speeds: Vec<f64> = (0..=25).map(|k| 0.5 + 0.1 * f64::from(k)).collect();
    let trims: Vec<_> = speeds.iter().map(|&v| trim(vehicle, Speed::Path(v), DEPTH).unwrap()).collect();
    TrimTable {
        speed: speeds,
        forward_speed: trims.iter().map(|one| one.forward_speed).collect(),
        signals: [
            ("pitch".to_owned(), trims.iter().map(|one| one.pitch).collect()),
            ("heave".to_owned(), trims.iter().map(|one| one.heave).collect()),
        ]
        .into(),
        actuators: trims.into_iter().map(|one| one.actuators).collect(),
    }
}

/// Returns the loop of these files, ready to step.
pub fn started(resources: &Resources) -> Flight<squid_fmu_loop::ClosedLoop> {
    Flight::started(squid_fmu_loop::describe(resources).unwrap())
}
