//! The frozen design: what the FMUs carry in their resources.

use crate::certify::controller_rows;
use crate::error::Error;
use crate::fit::Model;
use crate::inputs::Inputs;
use crate::linearise::linearise_at;
use auv::{LpvModel, Status, Trim};
use lpv::controller::Controller;
use lpv::synthesis::Design;
use scheduled::{
    Actuator, ControllerDesign, FORMAT, Gamma, InputHashes, LftMatrices, Scheduling, Tracked, TrimTable,
    VehicleName,
};

/// Rows of the trim table, evenly spread over the range of speed.
const TRIM_ROWS: usize = 101;

/// The two frozen files.
#[derive(Debug, Clone)]
pub struct Frozen {
    /// `controller.json`.
    pub controller: ControllerDesign,
    /// `plant.json`.
    pub plant: LpvModel,
}

/// Returns the contents of the frozen files of a design, `controller.json` and `plant.json`.
///
/// # Errors
/// [`StoreError::LpvModel`](crate::error::StoreError::LpvModel), [`ModelError::Trim`](crate::error::ModelError::Trim).
pub fn freeze(inputs: &Inputs, model: &Model, design: &Design, certified: bool) -> Result<Frozen, Error> {
    let gamma = Gamma {
        optimum: design.gamma_optimum,
        bound: design.certified.gamma,
        back_off: crate::synthesise::back_off(design),
        certified,
    };
    frozen(inputs, model, matrices(&design.controller), gamma)
}

/// As [`freeze`], from the matrices and the gamma of a controller; all else follows from vehicle and design file.
///
/// # Errors
/// [`StoreError::LpvModel`](crate::error::StoreError::LpvModel), [`ModelError::Trim`](crate::error::ModelError::Trim).
pub fn frozen(inputs: &Inputs, model: &Model, lft: LftMatrices, gamma: Gamma) -> Result<Frozen, Error> {
    let trims: Vec<Trim> = inputs
        .design
        .spread(TRIM_ROWS)
        .into_iter()
        .map(|v| Ok(linearise_at(&inputs.vehicle, inputs.design.depth, v)?.trim))
        .collect::<Result<_, Error>>()?;
    let (a, b) = model.coefficients();
    let plant =
        LpvModel::new(&inputs.vehicle.name, inputs.design.depth, inputs.design.scheduling(), &a, &b, &trims)?;
    Ok(Frozen { controller: controller(inputs, lft, gamma, &trims), plant })
}

fn controller(inputs: &Inputs, lft: LftMatrices, gamma: Gamma, trims: &[Trim]) -> ControllerDesign {
    let file = &inputs.design;
    let (centre, half_range) = file.scheduling();
    let column = |of: fn(&Trim) -> f64| trims.iter().map(of).collect();
    ControllerDesign {
        format: FORMAT.into(),
        vehicle: VehicleName { name: inputs.vehicle.name.clone(), status: status(inputs.vehicle.status) },
        design: file.name.clone(),
        sample_time: file.sample_time,
        scheduling: Scheduling {
            quantity: "speed".into(),
            minimum: file.speed_min,
            maximum: file.speed_max,
            centre,
            half_range,
        },
        tracked: file
            .tracked
            .iter()
            .map(|t| Tracked { name: t.signal().name.into(), unit: t.signal().unit.into(), scale: t.scale })
            .collect(),
        actuators: inputs
            .vehicle
            .actuators
            .iter()
            .map(|a| Actuator {
                name: a.name.clone(),
                unit: a.unit().into(),
                scale: a.reach(),
                minimum: a.min,
                maximum: a.max,
            })
            .collect(),
        lft,
        trim: TrimTable {
            speed: column(|t| t.speed),
            forward_speed: column(|t| t.forward_speed),
            pitch: column(|t| t.pitch),
            actuators: trims.iter().map(|t| t.actuators.clone()).collect(),
        },
        gamma,
        inputs: InputHashes {
            vehicle_sha256: inputs.vehicle_sha256.clone(),
            design_sha256: inputs.design_sha256.clone(),
        },
    }
}

fn matrices(k: &Controller) -> LftMatrices {
    let certificate::Controller { a, by, bt, cu, duy, dut, ct, dty, dtt } = controller_rows(k);
    LftMatrices { blocks: k.blocks.clone(), a, by, bt, cu, duy, dut, ct, dty, dtt }
}

fn status(status: Status) -> scheduled::Status {
    match status {
        Status::Surrogate => scheduled::Status::Surrogate,
        Status::Published => scheduled::Status::Published,
        Status::Measured => scheduled::Status::Measured,
    }
}
