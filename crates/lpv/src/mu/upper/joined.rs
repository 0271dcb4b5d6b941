//! Scalings of a system, combined from those of its components.

use super::scaling::DgScalings;
use crate::mu::CMat;
use crate::mu::components::Component;
use crate::mu::structure::Structure;
use nalgebra::Complex;

/// Returns the scalings of all components, each with a weight that makes the paths to it a small share of Phi at the
/// bound `beta`.
pub(super) fn weighted(
    all: &[CMat],
    structure: &Structure,
    parts: &[Component],
    each: &[DgScalings],
    share: f64,
    beta: f64,
) -> DgScalings {
    let zero = |rows: usize, cols: usize| CMat::zeros(rows, cols);
    let (rows, cols) = (structure.rows(), structure.cols());
    let mut out = DgScalings { dw: zero(rows, rows), dz: zero(cols, cols), g: zero(rows, cols) };
    let mut done: Vec<usize> = vec![];
    for (part, scalings) in parts.iter().zip(each) {
        let before = out.dw.select_rows(&done).select_columns(&done);
        let mut weight = 1.0f64;
        for m in all {
            let paths = m.select_rows(&part.z).select_columns(&done);
            if let Some((direct, mixed)) = couplings(&paths, &part.part(m), scalings, before.clone()) {
                let least = |size: f64, aim: f64| if size > 0.0 { (share * aim / size).powi(2) } else { 1.0 };
                weight = weight.min(least(direct, beta)).min(least(mixed, beta * beta));
            }
        }
        out.set(&part.z, &part.w, scalings, weight);
        done.extend(&part.w);
    }
    out
}

/// Returns the sizes of `D_z^1/2 L D^-1/2` and `D_w^-1/2 (M* D_z + j G) L D^-1/2`, where L leads from components with
/// the scalings D to one with the scalings D_w, D_z and G.
fn couplings(paths: &CMat, m: &CMat, scalings: &DgScalings, before: CMat) -> Option<(f64, f64)> {
    let (dw, dz) = (scalings.dw.clone().cholesky()?, scalings.dz.clone().cholesky()?);
    let before = before.cholesky()?;
    let whitened = |x: CMat| Some(before.l().solve_lower_triangular(&x.adjoint())?.norm());
    let mixed = (m.adjoint() * &scalings.dz + &scalings.g * Complex::new(0.0, 1.0)) * paths;
    Some((whitened(dz.l().adjoint() * paths)?, whitened(dw.l().solve_lower_triangular(&mixed)?)?))
}
