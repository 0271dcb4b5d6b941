//! Matrices in units of their blocks in which no block is much larger than those that it meets: from there the search
//! for scalings begins.

use crate::mu::CMat;
use crate::mu::structure::Structure;
use nalgebra::DMatrix;

/// The square of an entry below this part of the largest counts as so much.
const LEAST_SQUARE: f64 = 1e-24;

/// `T_z M T_w^-1` with a scalar for each block, so that blocks that meet are of one size.
///
/// E. E. Osborne, J. ACM 7(4), 1960; as a bound on mu M. G. Safonov, IEE Proc. D 129(6), 1982.
pub(in crate::mu) struct Balance {
    pub(in crate::mu) matrices: Vec<CMat>,
    pub(in crate::mu) tw: Vec<f64>,
    pub(in crate::mu) tz: Vec<f64>,
}

impl Balance {
    pub(in crate::mu) fn new(all: &[CMat], structure: &Structure) -> Self {
        let places = structure.places();
        let size = |i: usize, j: usize| {
            let (rows, cols) = (&places[i].2, &places[j].1);
            let part = |m: &CMat| m.view((rows.start, cols.start), (rows.len(), cols.len())).norm_squared();
            all.iter().map(part).sum::<f64>()
        };
        let n = places.len();
        let squares = DMatrix::from_fn(n, n, size);
        let nothing = LEAST_SQUARE * squares.max();
        let mut t = vec![1.0f64; n];
        for _ in 0..10 {
            for k in 0..n {
                let others = || (0..n).filter(|j| *j != k);
                let row: f64 = others().map(|j| squares[(k, j)] / (t[j] * t[j])).sum();
                let column: f64 = others().map(|i| squares[(i, k)] * t[i] * t[i]).sum();
                if row > 0.0 || column > 0.0 {
                    // A block that only sends or only receives makes what it sends or receives small, to an end.
                    t[k] = (column.max(nothing) / row.max(nothing)).powf(0.25).clamp(1e-8, 1e8);
                }
            }
        }
        let mut tw = vec![1.0; structure.rows()];
        let mut tz = vec![1.0; structure.cols()];
        for ((_, w, z), t) in places.iter().zip(&t) {
            tw[w.clone()].fill(*t);
            tz[z.clone()].fill(*t);
        }
        let own = |m: &CMat| CMat::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)] * (tz[i] / tw[j]));
        Self { matrices: all.iter().map(own).collect(), tw, tz }
    }
}
