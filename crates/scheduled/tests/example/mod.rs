//! Small design with two states, two channels, two errors as inputs and three actuators.

#![allow(dead_code, reason = "not every test needs everything")]

use squid_scheduled::*;
use std::f64::consts::FRAC_PI_2;

/// Indices of the signals.
pub const PITCH: usize = 0;
pub const SPEED: usize = 1;
pub const DEPTH: usize = 2;
pub const RATE: usize = 3;
pub const HEAVE: usize = 4;

/// Numbers of signals, and of signals that can be tracked.
pub const SIGNALS: usize = 5;
pub const TRACKED: usize = 3;

/// Name, unit and level of each signal.
const TABLE: [(&str, &str, Level); SIGNALS] = [
    ("pitch", "rad", Level::Trim),
    ("speed", "m/s", Level::Scheduled),
    ("depth", "m", Level::Start),
    ("pitch_rate", "rad/s", Level::Zero),
    ("heave", "m/s", Level::Trim),
];

pub fn ports() -> Vec<Port> {
    let port = |(index, (name, unit, level)): (usize, (&str, &str, Level))| Port {
        name: name.to_owned(),
        unit: unit.to_owned(),
        measured: format!("the {name}"),
        reference: (index < TRACKED).then(|| Reference {
            name: format!("{name}_reference"),
            description: format!("wanted {name}"),
            lag: 0.0,
        }),
        level,
        start: 0.0,
        range: (index == PITCH).then_some([-FRAC_PI_2, FRAC_PI_2]),
        circular: false,
        nominal: 1.0,
    };
    TABLE.into_iter().enumerate().map(port).collect()
}

pub fn input(signal: &str, kind: Kind, scale: f64) -> ControllerInput {
    let (_, unit, _) = TABLE.into_iter().find(|(name, ..)| *name == signal).unwrap();
    ControllerInput { signal: signal.to_owned(), kind, unit: unit.to_owned(), scale }
}

/// Returns the signals in trim at a forward speed, with a depth.
pub fn level(trim: &Trim, speed: f64, depth: f64) -> Inputs {
    let measured: Vec<f64> = (0..SIGNALS).map(|signal| trim.signal(speed, signal, depth)).collect();
    Inputs { references: measured[..TRACKED].to_vec(), measured }
}

pub fn design() -> ControllerDesign {
    let thruster = |name: &str| Actuator {
        name: name.to_owned(),
        unit: "N".to_owned(),
        scale: 100.0,
        minimum: -60.0,
        maximum: 100.0,
        curve: None,
        steers: vec![],
        force: Some([1.0, 0.0, 0.2]),
        lateral_force: None,
    };
    ControllerDesign {
        format: CONTROLLER_FORMAT.to_owned(),
        vehicle: VehicleName { name: "Example".to_owned(), status: Status::Surrogate },
        design: "default".to_owned(),
        sample_time: 0.02,
        signals: ports(),
        scheduling: Scheduling {
            quantity: "speed".to_owned(),
            minimum: 0.5,
            maximum: 3.0,
            centre: 1.75,
            half_range: 1.25,
        },
        controller_inputs: vec![input("pitch", Kind::Error, 0.17), input("speed", Kind::Error, 0.3)],
        delay_ticks: 0,
        reference_filter: None,
        speed_given: false,
        actuators: vec![thruster("thruster_1"), thruster("thruster_2"), thruster("thruster_3")],
        lft: LftMatrices {
            blocks: vec![2],
            a: vec![vec![-0.5, 1.0], vec![-1.0, -2.0]],
            by: vec![vec![0.3, 0.0], vec![0.1, 0.2]],
            bt: vec![vec![0.2, 0.0], vec![0.1, -0.3]],
            cu: vec![vec![0.1, 0.05], vec![-0.1, 0.02], vec![0.0, 0.04]],
            duy: vec![vec![0.1, 0.05], vec![-0.05, 0.05], vec![-0.05, 0.05]],
            dut: vec![vec![0.02, 0.0], vec![0.0, 0.01], vec![0.01, 0.01]],
            ct: vec![vec![0.4, 0.0], vec![0.0, 0.5]],
            dty: vec![vec![0.1, 0.2], vec![0.0, 0.3]],
            dtt: vec![vec![0.1, 0.2], vec![-0.2, 0.0]],
        },
        gains: vec![],
        anti_windup: None,
        follow: vec![],
        failsafe: None,
        trim: TrimTable {
            speed: vec![0.5, 1.75, 3.0],
            forward_speed: vec![0.49, 1.749, 3.0],
            signals: [
                ("pitch".to_owned(), vec![-0.11, -0.01, -0.003]),
                ("heave".to_owned(), vec![-0.054, -0.0175, -0.009]),
            ]
            .into(),
            actuators: vec![vec![1.5, 1.0, 1.0], vec![9.0, 8.0, 8.0], vec![24.0, 23.0, 23.0]],
        },
        envelope: Default::default(),
        gamma: Gamma { optimum: 0.79, bound: 0.85, back_off: 1.1, certified: false },
        inputs: InputHashes { vehicle_sha256: "00".repeat(32), design_sha256: "11".repeat(32) },
    }
}

/// Returns the same controller, K (r - y), with references and measurements as separate inputs.
pub fn two_degrees() -> ControllerDesign {
    let mut design = design();
    let errors = std::mem::take(&mut design.controller_inputs);
    let kinds = [Kind::Reference, Kind::Measurement];
    design.controller_inputs =
        errors.iter().flat_map(|one| kinds.map(|kind| input(&one.signal, kind, one.scale))).collect();
    for rows in [&mut design.lft.by, &mut design.lft.duy, &mut design.lft.dty] {
        for row in rows {
            *row = row.iter().flat_map(|&gain| [gain, -gain]).collect();
        }
    }
    design
}
