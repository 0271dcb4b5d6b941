//! Closed loop of the uncertain model with a controller, in the form for mu analysis.
//!
//! ```text
//!   +--[ Delta ]<--+        Delta = blkdiag(delta_i I_ri), |delta_i| <= 1, real
//!   |              |
//!   wd            zd
//!   +-->[      ]---+        robustly stable while det(I - N11(j omega) Delta) != 0
//!       [ N(s) ]
//!   w-->[      ]--> z       w = [r; d], z = [W_e e; W_u u], as in `squid_lpv::tracking`
//! ```

use crate::augment::{LinearModel, augment};
use crate::check::frozen_controller;
use crate::error::Error;
use crate::inputs::Inputs;
use crate::uncertain::frozen::FrozenUncertain;
use crate::uncertain::model::UncertainModel;
use squid_lpv::controller::Controller;
use squid_lpv::mu::worst_case::Perturbable;
use squid_lpv::mu::{Block, Structure};
use squid_lpv::partition::Group::{T, W, Z};
use squid_lpv::plant::GeneralisedPlant;

/// Builds the generalised plant of the design, with reference weights of 1, for the uncertain model; its blocks are the
/// model's repetitions, rho first.
///
/// # Errors
/// [`ModelError::System`](crate::error::ModelError::System), an internal error.
pub fn uncertain_plant(
    inputs: &Inputs,
    model: &UncertainModel,
    nominal: LinearModel,
) -> Result<GeneralisedPlant, Error> {
    let linear = LinearModel { ab: model.lft.clone(), ..nominal };
    let plant = augment(&inputs.vehicle.actuators, &inputs.design.with_unweighted_references(), linear)?;
    // A parameter without a channel has a block of size 0.
    let mut blocks = model.repetitions();
    blocks[0] += plant.sizes().t - model.channels();
    Ok(GeneralisedPlant { blocks, ..plant })
}

/// Returns N(s) of the uncertain model at one speed, from (wd, w) to (zd, z), with the controller frozen at that
/// speed's rho.
///
/// # Errors
/// [`ModelError::System`](crate::error::ModelError::System) if the controller is not well posed at rho;
/// [`Error::MuAtSpeed`] if no parameter has a channel.
pub fn uncertain_loop(
    inputs: &Inputs,
    frozen: &FrozenUncertain,
    controller: &Controller,
) -> Result<Perturbable, Error> {
    let (actuators, file, speed) = (&inputs.vehicle.actuators, &inputs.design, frozen.speed);
    let linear =
        LinearModel { ab: frozen.model.lft.clone(), ..LinearModel::at(&frozen.linear(actuators), file) };
    let plant = augment(actuators, &file.with_unweighted_references(), linear)?;
    let closed = plant.close(&frozen_controller(controller, file.rho(speed))?);
    let blocks = frozen.model.blocks.iter().map(|b| Block::Real(b.repetitions)).collect();
    let structure =
        Structure::new(blocks).map_err(|reason| Error::MuAtSpeed { speed, reason: reason.into() })?;
    Ok(Perturbable { system: closed.parts.state_space(&[T, Z], &[T, W]), structure, size: 1.0 })
}
