//! Generalised plant of the control problem: model and weights of the design.

use crate::axis::Linearisation;
use crate::error::ModelError;
use crate::inputs::design_file::{DesignFile, Measured, Tracked};
use crate::linearise::stacked;
use squid_auv::Actuator;
use squid_lpv::lft::Lft;
use squid_lpv::matrix::{Mat, block};
use squid_lpv::plant::GeneralisedPlant;
use squid_lpv::tracking::{ModelPosition, MovingTrim, TrackingProblem, TwoDegrees};

/// States of the wave filter.
const WAVE_STATES: usize = 2;

/// Linear model of the vehicle, scheduled or constant, with the slope of its trim.
#[derive(Debug, Clone, PartialEq)]
pub struct LinearModel {
    /// `[A B]`, n x (n + m).
    pub ab: Lft,
    /// `[x0'; u0']`, (n + m) x 1; see [`Linearisation::trim_slope`].
    pub trim_slope: Lft,
    /// `[G 0; A_w B_w]`, (n + 2) x 3, of the waves of the design; see
    /// [`WorkingSea::acting`](crate::inputs::design_file::WorkingSea::acting).
    pub waves: Option<Lft>,
}

impl LinearModel {
    /// Returns the model at one speed.
    pub fn at(l: &Linearisation, design: &DesignFile) -> Self {
        Self {
            ab: Lft::constant(stacked(&l.a, &l.b)),
            trim_slope: Lft::constant(l.trim_slope.clone()),
            waves: design.sea.as_ref().and_then(|sea| sea.acting(l)).map(Lft::constant),
        }
    }

    /// Evaluates `[A B G x0'; 0 0 0 u0']` at a value of rho, (n + m) x (n + m + 3), without G if there are no waves.
    ///
    /// # Errors
    /// [`ModelError::System`], an internal error.
    pub fn matrix(&self, rho: f64) -> Result<Mat, ModelError> {
        let (ab, slope) = (self.ab.evaluate(&[rho])?, self.trim_slope.evaluate(&[rho])?);
        let (n, both) = ab.shape();
        let [states, inputs] = [(0, n), (n, both - n)].map(|(at, rows)| slope.rows(at, rows).into_owned());
        let waves = self.waves.as_ref().map(|waves| waves.evaluate(&[rho])).transpose()?;
        let by_waves =
            waves.map_or(Mat::zeros(n, 0), |waves| waves.view((0, 0), (n, WAVE_STATES)).into_owned());
        let zeros = |columns| Mat::zeros(both - n, columns);
        let below = [zeros(both), zeros(by_waves.ncols())];
        Ok(block(&[&[&ab, &by_waves, &states], &[&below[0], &below[1], &inputs]]))
    }
}

/// Builds the generalised plant of the design for a model.
///
/// w contains the references and the disturbances at the actuators, z the tracking errors weighted by W_e and the
/// commands weighted by W_u, u the commands and y the tracking errors. References and outputs are in units of the
/// `scale` of each tracked output, commands in units of the actuators' reach. All channels of `model` belong to rho.
/// See [`squid_lpv::tracking`].
///
/// # Errors
/// [`ModelError::System`], an internal error.
pub fn augment(
    actuators: &[Actuator],
    design: &DesignFile,
    model: LinearModel,
) -> Result<GeneralisedPlant, ModelError> {
    Ok(problem(actuators, design, model).augment()?)
}

/// Returns the position of the model in the plant of [`augment`].
///
/// # Errors
/// The errors of [`augment`].
pub fn model_position(actuators: &[Actuator], design: &DesignFile) -> Result<ModelPosition, ModelError> {
    let (n, m) = (design.states.len(), actuators.len());
    let zeros = |rows, columns| Lft::constant(Mat::zeros(rows, columns));
    let waves = design.sea.as_ref().map(|_| zeros(n + WAVE_STATES, WAVE_STATES + 1));
    let model = LinearModel { ab: zeros(n, n + m), trim_slope: zeros(n + m, 1), waves };
    Ok(problem(actuators, design, model).model_position()?)
}

fn problem(actuators: &[Actuator], design: &DesignFile, model: LinearModel) -> TrackingProblem {
    TrackingProblem {
        outputs: Tracked::outputs(&design.tracked, design.states),
        output_scale: design.tracked.iter().map(|t| t.scale).collect(),
        references: design.tracked.iter().map(|t| t.references).collect(),
        input_scale: actuators.iter().map(Actuator::reach).collect(),
        lags: actuators.iter().map(|a| if design.lags { a.lag } else { 0.0 }).collect(),
        delay: design.delay,
        tracking: design.tracked.iter().map(|t| t.weight).collect(),
        control: actuators.iter().map(|one| design.weight_on(&one.name)).collect(),
        disturbance: design.disturbance,
        coloured: model.waves,
        two_degrees: (!design.measured.is_empty()).then(|| two_degrees(design, model.trim_slope)),
        model: model.ab,
    }
}

/// References and measurements as separate inputs; the trim follows the filtered speed reference.
fn two_degrees(design: &DesignFile, slope: Lft) -> TwoDegrees {
    let speed = design.tracked_speed();
    let models = design.tracked.iter().map(|t| t.model.filter(|_| !design.judged));
    TwoDegrees {
        measured: Measured::scaled_outputs(&design.measured, design.states),
        noise: design.measured.iter().map(|m| m.noise).collect(),
        models: models.collect(),
        trim: speed.zip(design.reference_filter()).map(|(output, frequency)| MovingTrim {
            output,
            frequency,
            slope,
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::Model;
    use crate::inputs::tests::shipped;

    /// The commands are normalised by the limits of the actuators, and W_u is the identity: Sutarto and Budiyono
    /// (2011).
    #[test]
    fn paper_weight_on_actuators_is_identity() {
        let inputs = shipped("squid", "paper");
        let model = Model::new(&inputs.axis(), &inputs.design).unwrap();
        let plant = augment(&inputs.vehicle.actuators, &inputs.design, model.linear()).unwrap();
        let (outputs, actuators) = (plant.d12().nrows(), inputs.vehicle.actuators.len());
        assert_eq!(outputs, inputs.design.tracked.len() + actuators);
        assert_eq!(plant.d12().rows(outputs - actuators, actuators), Mat::identity(actuators, actuators));
    }
}
