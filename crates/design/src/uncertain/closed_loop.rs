//! The closed loop of the uncertain model with a controller, as mu analysis wants it.
//!
//! ```text
//!   +--[ Delta ]<--+        Delta = blkdiag(delta_i I_ri), |delta_i| <= 1, real; a full block for the remainder last
//!   |              |
//!   wd            zd
//!   +-->[      ]---+        robustly stable while det(I - N11(j omega) Delta) != 0
//!       [ N(s) ]
//!   w-->[      ]--> z       w = [r; d], z = [W_e e; W_u u], as in `lpv::tracking`
//! ```

use crate::augment::{LinearModel, augment};
use crate::check::frozen_controller;
use crate::error::Error;
use crate::inputs::design_file::DesignFile;
use crate::uncertain::errors::Remainder;
use crate::uncertain::frozen::FrozenUncertain;
use crate::uncertain::model::UncertainModel;
use auv::Actuator;
use lpv::controller::Controller;
use lpv::matrix::{Mat, block, diagonal_blocks};
use lpv::partition::Group::{T, W, Z};
use lpv::plant::GeneralisedPlant;
use lpv::state_space::StateSpace;

/// N(s), from (wd, w) to (zd, z).
#[derive(Debug, Clone, PartialEq)]
pub struct UncertainLoop {
    /// The system.
    pub system: StateSpace,
    /// Name and repetitions of each real repeated parameter, in the order of the channels wd and zd.
    pub blocks: Vec<(String, usize)>,
    /// Size of the full complex block that follows the real ones, for what the model leaves out; 0 for none.
    pub remainder: usize,
    /// The number of performance inputs w, which follow wd.
    pub inputs: usize,
    /// The number of performance outputs z, which follow zd.
    pub outputs: usize,
}

impl UncertainLoop {
    /// The number of channels wd, and of zd.
    pub fn channels(&self) -> usize {
        self.blocks.iter().map(|(_, repetitions)| repetitions).sum::<usize>() + self.remainder
    }

    /// `N11`, from wd to zd: what robust stability asks about. The states of weights, noise and references, which have
    /// no part in it, are left out.
    pub fn stability(&self) -> StateSpace {
        let k = self.channels();
        let whole = StateSpace {
            a: self.system.a.clone(),
            b: self.system.b.columns(0, k).into_owned(),
            c: self.system.c.rows(0, k).into_owned(),
            d: self.system.d.view((0, 0), (k, k)).into_owned(),
        };
        whole.without_idle_states()
    }
}

/// The generalised plant of the design, with even references, for the uncertain model; its blocks are the model's
/// repetitions, rho first.
///
/// # Errors
/// [`ModelError::Augment`](crate::error::ModelError::Augment), which would be a defect of this program.
pub fn uncertain_plant(
    actuators: &[Actuator],
    file: &DesignFile,
    model: &UncertainModel,
    nominal: LinearModel,
) -> Result<GeneralisedPlant, Error> {
    let linear = LinearModel { ab: model.lft(), ..nominal };
    let plant = augment(actuators, &file.with_even_references(), linear)?;
    // A parameter without a channel counts as well.
    let mut blocks = model.repetitions();
    blocks[0] += plant.sizes().t - model.channels();
    Ok(GeneralisedPlant { blocks, ..plant })
}

/// N(s) of the uncertain model at one speed with the controller frozen at that speed's rho.
///
/// With a `remainder`, see [`crate::uncertain::errors::remainder`], its full block is the last of Delta.
///
/// # Errors
/// [`ModelError::Lft`](crate::error::ModelError::Lft) where the controller is not well posed at rho.
pub fn uncertain_loop(
    actuators: &[Actuator],
    file: &DesignFile,
    frozen: &FrozenUncertain,
    controller: &Controller,
    rho: f64,
    remainder: Option<&Remainder>,
) -> Result<UncertainLoop, Error> {
    let model = &frozen.model;
    let mut lft = model.lft();
    if let Some(Remainder { left, right }) = remainder {
        let size = left.ncols();
        lft.channels.extend(std::iter::repeat_n(model.repetitions().len(), size));
        lft.left = block(&[&[&lft.left, left]]);
        lft.inner = diagonal_blocks(&[&lft.inner, &Mat::zeros(size, size)]);
        lft.right = block(&[&[&lft.right], &[right]]);
    }
    let linear = LinearModel { ab: lft, ..LinearModel::at(&frozen.nominal, actuators, file) };
    let plant = augment(actuators, &file.with_even_references(), linear)?;
    let closed = plant.close(&frozen_controller(controller, rho)?);
    Ok(UncertainLoop {
        blocks: model.blocks.iter().map(|b| (b.name.clone(), b.repetitions)).collect(),
        remainder: remainder.map_or(0, |r| r.left.ncols()),
        inputs: closed.parts.sizes().w,
        outputs: closed.parts.sizes().z,
        system: closed.parts.state_space(&[T, Z], &[T, W]),
    })
}
