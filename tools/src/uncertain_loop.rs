//! The closed loop of the uncertain model with a controller, as mu analysis wants it.
//!
//! ```text
//!   +--[ Delta ]<--+        Delta = blkdiag(delta_i I_ri), |delta_i| <= 1, real
//!   |              |
//!   wd            zd
//!   +-->[      ]---+        robustly stable while det(I - N11(j omega) Delta) != 0
//!       [ N(s) ]
//!   w-->[      ]--> z       w = [r; d], z = [W_e e; W_u u], as in `lpv::tracking`
//! ```

use crate::error::Error;
use crate::inputs::Inputs;
use crate::problem::augment;
use crate::uncertain::UncertainModel;
use lpv::controller::Controller;
use lpv::matrix::block;
use lpv::plant::GeneralisedPlant;
use lpv::state_space::StateSpace;

/// N(s), from (wd, w) to (zd, z).
#[derive(Debug, Clone, PartialEq)]
pub struct UncertainLoop {
    /// The system.
    pub system: StateSpace,
    /// Name and repetitions of each real repeated parameter, in the order of the channels wd and zd.
    pub blocks: Vec<(String, usize)>,
    /// The number of performance inputs w, which follow wd.
    pub inputs: usize,
    /// The number of performance outputs z, which follow zd.
    pub outputs: usize,
}

impl UncertainLoop {
    /// The number of channels wd, and of zd.
    pub fn channels(&self) -> usize {
        self.blocks.iter().map(|(_, repetitions)| repetitions).sum()
    }

    /// `N11`, from wd to zd: what robust stability asks about.
    pub fn stability(&self) -> StateSpace {
        let k = self.channels();
        StateSpace {
            a: self.system.a.clone(),
            b: self.system.b.columns(0, k).into_owned(),
            c: self.system.c.rows(0, k).into_owned(),
            d: self.system.d.view((0, 0), (k, k)).into_owned(),
        }
    }
}

/// The generalised plant of the design for the uncertain model; its blocks are the model's repetitions, rho first.
///
/// # Errors
/// [`Error::Augment`], which would be a defect of this program.
pub fn uncertain_plant(inputs: &Inputs, model: &UncertainModel) -> Result<GeneralisedPlant, Error> {
    Ok(GeneralisedPlant { blocks: model.repetitions(), ..augment(inputs, model.lft())? })
}

/// N(s) of the uncertain model at one speed with the controller frozen at that speed's rho.
///
/// # Errors
/// [`Error::Lft`] where the controller is not well posed at rho.
pub fn uncertain_loop(
    inputs: &Inputs,
    model: &UncertainModel,
    controller: &Controller,
    rho: f64,
) -> Result<UncertainLoop, Error> {
    let plant = uncertain_plant(inputs, model)?;
    let closed = plant.close(&crate::check::frozen_controller(controller, rho)?);
    let blocks = model.blocks.iter().map(|b| (b.name.clone(), b.repetitions)).collect();
    Ok(UncertainLoop {
        inputs: closed.b1.ncols(),
        outputs: closed.c1.nrows(),
        system: StateSpace {
            a: closed.a,
            b: block(&[&[&closed.bt, &closed.b1]]),
            c: block(&[&[&closed.ct], &[&closed.c1]]),
            d: block(&[&[&closed.dtt, &closed.dt1], &[&closed.d1t, &closed.d11]]),
        },
        blocks,
    })
}
