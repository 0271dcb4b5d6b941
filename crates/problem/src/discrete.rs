//! A plant in discrete time: solved in continuous time, proved as it is given.
//!
//! The bilinear transform keeps gains, Lyapunov matrices and scalings, so that those of the loop in continuous time are
//! tried on the loop in discrete time. What the transforms round the proof sees, for it is of the matrices in discrete
//! time. Source: `lpv::bilinear`.

use lpv::bilinear::Bilinear;
use lpv::controller::Controller;
use lpv::matrix::{Mat, block};
use lpv::partition::Group::{T, U, W, Y, Z};
use lpv::partition::{PLANT, Partitioned};
use lpv::plant::GeneralisedPlant;
use lpv::state_space::StateSpace;

/// Why a plant has no form in continuous time.
pub const POLES_AT_BOTH_ENDS: &str =
    "has eigenvalues at z = 1 and at z = -1; the bilinear transform needs one of them free";

/// A plant as it is given, and the way to continuous time.
#[derive(Debug, Clone, PartialEq)]
pub struct Discrete {
    /// The plant without the direct path, with `x+` for `x'`.
    pub plant: GeneralisedPlant,
    /// The direct path from u to y.
    pub d22: Mat,
    transform: Bilinear,
}

impl Discrete {
    /// The plant at a sample time (s), and what it and its direct path are in continuous time; `None` where it has
    /// poles at z = 1 and at z = -1, but for rounding.
    pub fn new(plant: GeneralisedPlant, d22: Mat, sample_time: f64) -> Option<(Self, GeneralisedPlant, Mat)> {
        let transform = Bilinear::of(&plant.a(), sample_time)?;
        let mut whole = plant.parts.clone();
        whole.block_mut(Y, U).copy_from(&d22);
        let system = transform.continuous(&whole.state_space(&[T, Z, Y], &[T, W, U]))?;
        let mut parts = Partitioned::of(matrix(&system), PLANT, plant.sizes());
        let direct = parts.block(Y, U);
        parts.block_mut(Y, U).fill(0.0);
        let continuous = GeneralisedPlant { parts, blocks: plant.blocks.clone() };
        Some((Self { plant, d22, transform }, continuous, direct))
    }

    /// A controller in continuous time as one in discrete time; `None` where it has a pole at s = 2/T.
    pub fn controller(&self, k: &Controller) -> Option<Controller> {
        let system = self.transform.discrete(&k.parts.state_space(&[U, T], &[Y, T]))?;
        let sizes = k.parts.sizes();
        Some(Controller::from_matrix(&matrix(&system), sizes.x, sizes.y, sizes.u, k.blocks.clone()))
    }
}

fn matrix(system: &StateSpace) -> Mat {
    block(&[&[&system.a, &system.b], &[&system.c, &system.d]])
}
