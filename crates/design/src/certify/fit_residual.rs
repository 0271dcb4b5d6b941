//! Residual of the fit against the true linearisations and the slope of the trim over the range of speed. The ball of
//! models ([`squid_proof::ball`]) contains it.

use crate::augment::{LinearModel, model_position};
use crate::axis::VehicleModel;
use crate::error::Error;
use crate::fit::Model;
use crate::inputs::design_file::DesignFile;
use squid_lpv::matrix::Mat;
use squid_lpv::tracking::ModelPosition;
use squid_proof::ball::ModelResidual;

/// Number of speeds at which the residual is computed.
pub const SAMPLES: usize = 1001;

/// Computes the residual of the fit. The subtracted LFTs are those used for the design, so the residual includes their
/// truncation error.
///
/// # Errors
/// The errors of the linearisation.
pub fn fit_residual(
    vehicle: &dyn VehicleModel,
    file: &DesignFile,
    model: &Model,
) -> Result<ModelResidual, Error> {
    let ModelPosition { left, right } = model_position(vehicle.actuators(), file)?;
    // The trim of an input without lag or delay drives no state.
    let rows: Vec<usize> = (0..left.ncols()).filter(|j| left.column(*j).amax() > 0.0).collect();
    let fit = model.linear();
    let at = |v: f64| -> Result<Mat, Error> {
        let truth = LinearModel::at(&vehicle.linearise(v)?, file);
        let residual = truth.matrix(0.0)? - fit.matrix(file.rho(v))?;
        Ok(residual.select_rows(&rows).columns(0, right.nrows()).into_owned())
    };
    let residuals = file.spread(SAMPLES).into_iter().map(at).collect::<Result<_, Error>>()?;
    let scales = vehicle.actuators().iter().map(|actuator| actuator.reach()).collect();
    Ok(ModelResidual {
        left: left.select_columns(&rows),
        right,
        residuals,
        states: file.states.len(),
        scales,
    })
}

/// Returns `true` if the range of speed has 0 in its interior and the residual has its sharpest bend there.
///
/// # Errors
/// The errors of the linearisation.
pub fn bends_at_rest(vehicle: &dyn VehicleModel, file: &DesignFile, model: &Model) -> Result<bool, Error> {
    if file.speed_min >= 0.0 || file.speed_max <= 0.0 {
        return Ok(false);
    }
    let bend = fit_residual(vehicle, file, model)?.largest_bend();
    let speeds = file.spread(SAMPLES);
    Ok(bend.is_some_and(|i| speeds[i] <= 0.0 && 0.0 <= speeds[i + 2]))
}
