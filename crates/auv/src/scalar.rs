//! Numbers that carry derivatives.

use num_dual::DualNum;

/// Scalar that carries derivatives, or a plain `f64`.
pub trait Scalar: DualNum<Primitive = f64> + Copy {}
impl<D: DualNum<Primitive = f64> + Copy> Scalar for D {}
