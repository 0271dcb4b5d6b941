//! The frozen design: the contents of the FMUs' resources.

use crate::certify::lft_matrices;
use crate::error::Error;
use crate::fit::Model;
use crate::inputs::design_file::DesignFile;
use crate::linearise::trim_table;
use auv::{LpvModel, Trim, Vehicle};
use lpv::synthesis::Design;
use scheduled::{
    Actuator, CONTROLLER_FORMAT, ControllerDesign, ControllerInput, Gamma, InputHashes, Kind, LftMatrices,
    Scheduling, TrimTable, VehicleName,
};
use signals::Signal;

/// The two frozen files.
#[derive(Debug, Clone)]
pub struct Frozen {
    /// `controller.json`.
    pub controller: ControllerDesign,
    /// `plant.json`.
    pub plant: LpvModel,
}

/// Returns the contents of the frozen files of a design, without anti-windup.
///
/// # Errors
/// [`StoreError::LpvModel`](crate::error::StoreError::LpvModel), [`ModelError::Trim`](crate::error::ModelError::Trim).
pub fn freeze(
    vehicle: &Vehicle,
    file: &DesignFile,
    hashes: &InputHashes,
    model: &Model,
    design: &Design,
    certified: bool,
) -> Result<Frozen, Error> {
    let gamma = Gamma {
        optimum: design.gamma_optimum,
        bound: design.certified.gamma,
        back_off: crate::synthesise::back_off(design),
        certified,
    };
    let k = &design.controller;
    frozen(vehicle, file, hashes, model, lft_matrices(k), gamma)
}

/// As [`freeze`], from the matrices and the gamma of a controller; the rest follows from vehicle and design file.
///
/// # Errors
/// [`StoreError::LpvModel`](crate::error::StoreError::LpvModel), [`ModelError::Trim`](crate::error::ModelError::Trim).
pub fn frozen(
    vehicle: &Vehicle,
    file: &DesignFile,
    hashes: &InputHashes,
    model: &Model,
    lft: LftMatrices,
    gamma: Gamma,
) -> Result<Frozen, Error> {
    let trims = trim_table(vehicle, file)?;
    // The depth follows from the other states, so the plant computes it itself.
    let others = vehicle.coefficients.surge.states(false).len();
    let (mut a, mut b) = model.coefficients();
    a.iter_mut().for_each(|a| *a = a.view((0, 0), (others, others)).into_owned());
    b.iter_mut().for_each(|b| *b = b.rows(0, others).into_owned());
    let plant = LpvModel::new(&vehicle.name, file.depth, file.scheduling(), &a, &b, &trims)?;
    Ok(Frozen { controller: controller(vehicle, file, hashes, lft, gamma, &trims), plant })
}

fn controller(
    vehicle: &Vehicle,
    file: &DesignFile,
    hashes: &InputHashes,
    lft: LftMatrices,
    gamma: Gamma,
    trims: &[Trim],
) -> ControllerDesign {
    let (centre, half_range) = file.scheduling();
    let column = |of: fn(&Trim) -> f64| trims.iter().map(of).collect();
    ControllerDesign {
        format: CONTROLLER_FORMAT.into(),
        vehicle: VehicleName { name: vehicle.name.clone(), status: vehicle.status },
        design: file.name.clone(),
        sample_time: file.sample_time,
        delay_ticks: file.delay_ticks(),
        scheduling: Scheduling {
            quantity: "speed".into(),
            minimum: file.speed_min,
            maximum: file.speed_max,
            centre,
            half_range,
        },
        controller_inputs: controller_inputs(file),
        reference_filter: file.reference_filter(),
        speed_given: vehicle.coefficients.surge.is_given(),
        actuators: vehicle
            .actuators
            .iter()
            .map(|a| Actuator {
                name: a.name.clone(),
                unit: a.unit().into(),
                scale: a.reach(),
                minimum: a.min,
                maximum: a.max,
                curve: a.curve.clone(),
                force: Some(a.force_per_output()),
            })
            .collect(),
        lft,
        anti_windup: None,
        trim: TrimTable {
            speed: column(|t| t.speed),
            forward_speed: column(|t| t.forward_speed),
            pitch: column(|t| t.pitch),
            actuators: trims.iter().map(|t| t.actuators.clone()).collect(),
        },
        depth: if file.has_depth() { file.depth } else { 0.0 },
        gamma,
        inputs: hashes.clone(),
    }
}

/// The inputs of the controller, in the order of y: the errors, or the references and then the measurements.
fn controller_inputs(file: &DesignFile) -> Vec<ControllerInput> {
    let input = |signal: &Signal, kind: Kind, scale: f64| ControllerInput {
        signal: signal.name.into(),
        kind,
        unit: signal.unit.into(),
        scale,
    };
    let kind = if file.measured.is_empty() { Kind::Error } else { Kind::Reference };
    let tracked = file.tracked.iter().map(|t| input(t.signal(), kind, t.scale));
    let measured = file.measured.iter().map(|m| input(m.signal(), Kind::Measurement, m.scale));
    tracked.chain(measured).collect()
}
