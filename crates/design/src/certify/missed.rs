//! What the fit misses of the true linearisations and of the slope of the trim, over the range of speed: the ball of
//! models ([`proof::ball`]) contains it.

use crate::augment::{LinearModel, place};
use crate::error::Error;
use crate::fit::Model;
use crate::inputs::design_file::DesignFile;
use crate::linearise::linearise_at;
use auv::Vehicle;
use lpv::matrix::Mat;
use lpv::tracking::ModelPlace;
use proof::ball::Missed;

/// Speeds at which the fit's residual is taken.
pub const SAMPLES: usize = 1001;

/// What the fit misses. The LFTs that were designed on are subtracted, so that what was dropped there counts, too.
///
/// # Errors
/// Those of the linearisation.
pub fn missed(vehicle: &Vehicle, file: &DesignFile, model: &Model) -> Result<Missed, Error> {
    let ModelPlace { left, right } = place(&vehicle.actuators, file)?;
    // The trim of an input without a lag or a delay moves no state.
    let rows: Vec<usize> = (0..left.ncols()).filter(|j| left.column(*j).amax() > 0.0).collect();
    let fit = model.linear();
    let at = |v: f64| -> Result<Mat, Error> {
        let truth = LinearModel::at(&linearise_at(vehicle, file, v)?, &vehicle.actuators, file);
        let missed = truth.whole(0.0)? - fit.whole(file.rho(v))?;
        Ok(missed.select_rows(&rows).columns(0, right.nrows()).into_owned())
    };
    let residuals = file.spread(SAMPLES).into_iter().map(at).collect::<Result<_, Error>>()?;
    let scales = vehicle.actuators.iter().map(|actuator| actuator.reach()).collect();
    Ok(Missed { left: left.select_columns(&rows), right, residuals, states: file.states.len(), scales })
}

/// Whether the range of speed holds 0 inside, and the linearisation bends more there than anywhere else.
///
/// # Errors
/// Those of the linearisation.
pub fn bends_at_rest(vehicle: &Vehicle, file: &DesignFile, model: &Model) -> Result<bool, Error> {
    if file.speed_min >= 0.0 || file.speed_max <= 0.0 {
        return Ok(false);
    }
    let most = missed(vehicle, file, model)?.most_bent();
    let speeds = file.spread(SAMPLES);
    Ok(most.is_some_and(|i| speeds[i] <= 0.0 && 0.0 <= speeds[i + 2]))
}
