//! Discrete-time plant: solved in continuous time, proved in discrete time.
//!
//! The bilinear transform preserves gains, Lyapunov matrices and scalings, so those of the continuous-time loop apply
//! to the discrete-time loop. The proof uses the discrete-time matrices, and so covers rounding in the transform.
//! Source: `squid_lpv::bilinear`.

use squid_lpv::bilinear::Bilinear;
use squid_lpv::controller::Controller;
use squid_lpv::matrix::{Mat, block};
use squid_lpv::partition::Group::{T, U, W, Y, Z};
use squid_lpv::plant::GeneralisedPlant;
use squid_lpv::state_space::StateSpace;

/// Error message for a plant without a bilinear transform.
pub const POLES_AT_BOTH_ENDS: &str =
    "has eigenvalues at z = 1 and z = -1; the bilinear transform requires that one is no eigenvalue";

/// Discrete-time plant and its transform to continuous time.
#[derive(Debug, Clone, PartialEq)]
pub struct Discrete {
    /// The plant without the direct path, with `x+` for `x'`.
    pub plant: GeneralisedPlant,
    /// The direct path from u to y.
    pub d22: Mat,
    transform: Bilinear,
}

impl Discrete {
    /// Transforms a plant with a sample time \[s\]; also returns the plant and its direct path in continuous time.
    /// `None` if it has poles at both z = 1 and z = -1, to rounding.
    pub fn new(plant: GeneralisedPlant, d22: Mat, sample_time: f64) -> Option<(Self, GeneralisedPlant, Mat)> {
        let transform = Bilinear::of(&plant.a(), sample_time)?;
        let mut with_direct_path = plant.parts.clone();
        with_direct_path.block_mut(Y, U).copy_from(&d22);
        let system = transform.continuous(&with_direct_path.state_space(&[T, Z, Y], &[T, W, U]))?;
        let (continuous, direct) = GeneralisedPlant::of_system(&system, plant.sizes(), plant.blocks.clone());
        Some((Self { plant, d22, transform }, continuous, direct))
    }

    /// Transforms a continuous-time controller to discrete time; `None` if it has a pole at s = 2/T.
    pub fn controller(&self, k: &Controller) -> Option<Controller> {
        let system = self.transform.discrete(&k.parts.state_space(&[U, T], &[Y, T]))?;
        let sizes = k.parts.sizes();
        Some(Controller::from_matrix(&matrix(&system), sizes.x, sizes.y, sizes.u, k.blocks.clone()))
    }
}

fn matrix(system: &StateSpace) -> Mat {
    block(&[&[&system.a, &system.b], &[&system.c, &system.d]])
}
