//! Vehicle with its uncertain coefficients: an LFT of the linear model at each speed, and one over the entire range.
//!
//! ```text
//! x' = A x + Bd wd + B u,   zd = Cd x + Ddd wd + Dd2 u,   wd = blkdiag(delta_i I_ri) zd,   |delta_i| <= 1
//! ```
//!
//! The motion about a trim is `M(c) x' = C(c) x + D(c) u` with M, C and D affine in each coefficient c, and the LFT of
//! `[A B] = M^-1 [C D]` is exact. A coefficient also changes the trim, on which the motion depends. That effect is
//! modelled to first order by further parameters, the incidence and the outputs of actuators at trim; see
//! [`crate::uncertain::trim`].
//!
//! Source of the descriptor form: K. Zhou, J. C. Doyle, K. Glover, Robust and Optimal Control, 1996, ch. 10.

pub mod closed_loop;
pub mod errors;
pub mod frozen;
pub mod gradients;
pub mod model;
pub mod pencil;
pub mod reduce;
pub mod trim;
pub mod truncate;
pub mod vehicle;

use crate::error::Error;
use crate::fit::Model;
use crate::inputs::Inputs;
use crate::uncertain::gradients::{Gradients, coarsen};
use crate::uncertain::model::UncertainModel;
use crate::uncertain::pencil::Pencil;
use crate::uncertain::reduce::minimal;
use crate::uncertain::trim::{TrimRange, blocks, trim_range};
use squid_auv::Linearisation;

/// Accuracy of the uncertain model over the range of speed; higher accuracy needs more channels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fidelity {
    /// Size, relative to `[C D]`, below which effects of the trim are left out; also the relative accuracy of the
    /// polynomials in rho for the uncertain parts.
    detail: f64,
    /// Allowed order of the polynomials above the design's.
    extra_order: usize,
}

impl Fidelity {
    /// Fidelity with few channels and, at delta = 0, the plant of the design: for inequalities with many unknowns per
    /// channel.
    pub const COARSE: Self = Self { detail: 3e-3, extra_order: 0 };

    /// Fidelity with a fifth to a seventh of the error and 40 % more channels (Squid, REMUS 100): for analyses that
    /// cover the error.
    pub const FINE: Self = Self { detail: 3e-4, extra_order: 1 };
}

/// Fits the uncertain model over the range of speed: polynomials for the linearisations of `model` at delta = 0, and
/// for the uncertain parts, of the orders that the fidelity allows.
///
/// # Errors
/// [`ModelError::Trim`](crate::error::ModelError::Trim), [`ModelError::System`](crate::error::ModelError::System),
/// [`Error::Uncertain`].
pub fn over_range(inputs: &Inputs, model: &Model, fidelity: Fidelity) -> Result<UncertainModel, Error> {
    let vehicle = &inputs.vehicle;
    let speeds = model.grid.iter().map(|(_, l)| l.trim.speed);
    let nominals: Vec<Linearisation> =
        speeds.map(|speed| inputs.axis().at(speed)).collect::<Result<_, _>>()?;
    let mut ranges = Vec::new();
    for nominal in &nominals {
        ranges.push(trim_range(inputs, nominal)?);
    }
    let moved = TrimRange::varying(&ranges);
    let (mut rhos, mut gradients, mut middle) = (Vec::new(), Vec::new(), Vec::new());
    for (i, (((rho, _), nominal), range)) in model.grid.iter().zip(&nominals).zip(&ranges).enumerate() {
        let all = blocks(inputs, &nominal.trim, &range.largest_changes(&moved))?;
        gradients.push(Gradients::at(vehicle, nominal, &all)?);
        rhos.push(*rho);
        if i == model.grid.len() / 2 {
            middle = all;
        }
    }
    coarsen(vehicle, &middle, fidelity.detail, &mut gradients);
    let samples: Vec<(f64, Gradients)> = rhos.into_iter().zip(gradients).collect();
    let order = (inputs.design.order + fidelity.extra_order).min(model.grid.len() - 1);
    let nominal = model.of_order(order, inputs.design.drop)?;
    let pencil = Pencil::scheduled(vehicle, &samples, &nominal, order, fidelity.detail)?;
    Ok(UncertainModel::from_lft(minimal(&pencil.lft()), &middle))
}
