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

use crate::check::frozen_controller;
use crate::error::Error;
use crate::inputs::Inputs;
use crate::problem::augment;
use crate::uncertain::UncertainModel;
use crate::uncertain_errors::Remainder;
use lpv::controller::Controller;
use lpv::matrix::{Mat, block, diagonal_blocks};
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
/// With a `remainder`, see [`crate::uncertain_errors::remainder`], its full block is the last of Delta.
///
/// # Errors
/// [`Error::Lft`] where the controller is not well posed at rho.
pub fn uncertain_loop(
    inputs: &Inputs,
    model: &UncertainModel,
    controller: &Controller,
    rho: f64,
    remainder: Option<&Remainder>,
) -> Result<UncertainLoop, Error> {
    let mut lft = model.lft();
    if let Some(Remainder { left, right }) = remainder {
        let size = left.ncols();
        lft.channels.extend(std::iter::repeat_n(model.repetitions().len(), size));
        lft.left = block(&[&[&lft.left, left]]);
        lft.inner = diagonal_blocks(&[&lft.inner, &Mat::zeros(size, size)]);
        lft.right = block(&[&[&lft.right], &[right]]);
    }
    let closed = augment(inputs, lft)?.close(&frozen_controller(controller, rho)?);
    Ok(UncertainLoop {
        blocks: model.blocks.iter().map(|b| (b.name.clone(), b.repetitions)).collect(),
        remainder: remainder.map_or(0, |r| r.left.ncols()),
        inputs: closed.b1.ncols(),
        outputs: closed.c1.nrows(),
        system: StateSpace {
            a: closed.a,
            b: block(&[&[&closed.bt, &closed.b1]]),
            c: block(&[&[&closed.ct], &[&closed.c1]]),
            d: block(&[&[&closed.dtt, &closed.dt1], &[&closed.d1t, &closed.d11]]),
        },
    })
}

/// What the perturbation sees, from wd to zd, of the loop as it flies: each actuator with its lag, and sampling and holding as a lag of half a sample, which is
/// what they delay.
///
/// # Errors
/// As [`uncertain_loop`].
pub fn flying_stability(
    inputs: &Inputs,
    model: &UncertainModel,
    controller: &Controller,
    rho: f64,
) -> Result<StateSpace, Error> {
    let plant = with_actuators(inputs, &augment(inputs, model.lft())?);
    let closed = plant.close(&frozen_controller(controller, rho)?);
    Ok(StateSpace { a: closed.a, b: closed.bt, c: closed.ct, d: closed.dtt })
}

/// A plant with lags in front of its controls; its z still weighs the commands.
fn with_actuators(inputs: &Inputs, plant: &GeneralisedPlant) -> GeneralisedPlant {
    let actuators = &inputs.vehicle.actuators;
    let lags =
        |a: &auv::Actuator| [a.lag, 0.5 * inputs.design.sample_time].into_iter().filter(|lag| *lag > 0.0);
    let count = actuators.iter().flat_map(lags).count();
    let (n, m) = (plant.a.nrows(), actuators.len());
    let (mut a, mut b, mut c) = (Mat::zeros(count, count), Mat::zeros(count, m), Mat::zeros(m, count));
    let mut state = 0;
    for (j, actuator) in actuators.iter().enumerate() {
        for (k, lag) in lags(actuator).enumerate() {
            a[(state, state)] = -1.0 / lag;
            if k == 0 {
                b[(state, j)] = 1.0 / lag
            } else {
                a[(state, state - 1)] = 1.0 / lag
            }
            state += 1;
        }
        c[(j, state - 1)] = 1.0;
    }
    let below = |m: &Mat| block(&[&[m], &[&Mat::zeros(count, m.ncols())]]);
    let beside = |m: &Mat| block(&[&[m, &Mat::zeros(m.nrows(), count)]]);
    GeneralisedPlant {
        a: block(&[&[&plant.a, &(&plant.b2 * &c)], &[&Mat::zeros(count, n), &a]]),
        bt: below(&plant.bt),
        b1: below(&plant.b1),
        b2: block(&[&[&Mat::zeros(n, m)], &[&b]]),
        ct: block(&[&[&plant.ct, &(&plant.dt2 * &c)]]),
        dt2: Mat::zeros(plant.dt2.nrows(), m),
        c1: beside(&plant.c1),
        c2: beside(&plant.c2),
        ..plant.clone()
    }
}
