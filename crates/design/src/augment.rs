//! The control problem: model and weights of the design, as a generalised plant.

use crate::error::ModelError;
use crate::inputs::design_file::{DesignFile, Tracked};
use auv::Actuator;
use lpv::lft::Lft;
use lpv::plant::GeneralisedPlant;
use lpv::tracking::TrackingProblem;

/// The generalised plant of the design for a model `[A B]`, scheduled or constant.
///
/// w contains the references and the disturbances at the actuators, z the tracking errors weighted by W_e and the
/// commands weighted by W_u, u the commands and y the tracking errors; references and outputs are in units of the
/// `scale` of each tracked output, commands in units of the actuators' reach. All channels of `model` belong to rho.
/// See [`lpv::tracking`].
///
/// # Errors
/// [`ModelError::Augment`], which would be a defect of this program.
pub fn augment(
    actuators: &[Actuator],
    design: &DesignFile,
    model: Lft,
) -> Result<GeneralisedPlant, ModelError> {
    let blocks = if model.size() > 0 { vec![model.size()] } else { vec![] };
    let problem = TrackingProblem {
        blocks,
        outputs: Tracked::outputs(&design.tracked),
        output_scale: design.tracked.iter().map(|t| t.scale).collect(),
        input_scale: actuators.iter().map(Actuator::reach).collect(),
        tracking: design.tracked.iter().map(|t| t.weight).collect(),
        control: vec![design.control_weight; actuators.len()],
        disturbance: design.disturbance,
        model,
    };
    Ok(problem.augment()?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::Model;
    use crate::inputs::Inputs;
    use lpv::matrix::Mat;
    use std::path::Path;

    /// Sutarto and Budiyono (2011), on W_u: the actions are normalised, here by the limits of the actuators, and the
    /// weight is the identity.
    #[test]
    fn the_papers_weight_on_the_actuators_is_the_identity() {
        let vehicle = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../vehicles/squid"));
        let inputs = Inputs::read(vehicle, "paper").unwrap();
        let plant = augment(
            &inputs.vehicle.actuators,
            &inputs.design,
            Model::new(&inputs.vehicle, &inputs.design).unwrap().lft,
        )
        .unwrap();
        let (outputs, actuators) = (plant.d12().nrows(), inputs.vehicle.actuators.len());
        assert_eq!(outputs, inputs.design.tracked.len() + actuators);
        assert_eq!(plant.d12().rows(outputs - actuators, actuators), Mat::identity(actuators, actuators));
    }
}
