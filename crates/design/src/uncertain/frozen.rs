//! Uncertain model at one speed.

use crate::axis::Linearisation;
use crate::error::Error;
use crate::inputs::Inputs;
use crate::linearise::stacked;
use crate::uncertain::gradients::{Gradients, coarsen};
use crate::uncertain::model::{Block, UncertainModel};
use crate::uncertain::pencil::{DETAIL, Pencil};
use crate::uncertain::reduce::minimal;
use crate::uncertain::trim::{TrimRange, blocks, trim_range};
use squid_auv::Actuator;

/// Uncertain model at one speed, and the data from which it was computed.
#[derive(Debug, Clone)]
pub struct FrozenUncertain {
    /// Speed along the path, m/s.
    pub speed: f64,
    /// Nominal linearisation and its trim.
    pub nominal: squid_auv::Linearisation,
    /// Range of the trim over the box of coefficients.
    pub trim_range: TrimRange,
    /// All uncertain parameters, including those without a channel in the model.
    pub parameters: Vec<Block>,
    /// Uncertain model.
    pub model: UncertainModel,
}

impl FrozenUncertain {
    /// Returns the nominal linearisation in the form of the design.
    pub fn linear(&self, actuators: &[Actuator]) -> Linearisation {
        Linearisation::of(&self.nominal, actuators)
    }
}

/// Computes the uncertain model at the depth of a design and a speed \[m/s\].
///
/// # Errors
/// [`ModelError::Trim`](crate::error::ModelError::Trim), [`Error::Uncertain`].
pub fn at_speed(inputs: &Inputs, speed: f64) -> Result<FrozenUncertain, Error> {
    let vehicle = &inputs.vehicle;
    let nominal = inputs.axis().at(speed)?;
    let trim_range = trim_range(inputs, &nominal)?;
    let parameters = blocks(inputs, &nominal.trim, &trim_range.deviations)?;
    let mut gradients = [Gradients::at(vehicle, &nominal, &parameters)?];
    coarsen(vehicle, &parameters, DETAIL, &mut gradients);
    let pencil = Pencil::frozen(&gradients[0], &stacked(&nominal.a, &nominal.b));
    let model = UncertainModel::from_lft(minimal(&pencil.lft()), &parameters);
    Ok(FrozenUncertain { speed, nominal, trim_range, parameters, model })
}
