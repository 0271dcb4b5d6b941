//! Scaling of matrices by blocks so that connected blocks are of similar size: the start of the search for scalings.

use crate::mu::CMat;
use crate::mu::structure::Structure;
use nalgebra::DMatrix;

/// The floor of the squared entries, relative to the largest.
const LEAST_SQUARE: f64 = 1e-24;

/// The matrix `T_z M T_w^-1` with a scalar for each block that equalises connected blocks.
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
        let floor = LEAST_SQUARE * squares.max();
        let mut t = vec![1.0f64; n];
        for _ in 0..10 {
            for k in 0..n {
                let others = || (0..n).filter(|j| *j != k);
                let row: f64 = others().map(|j| squares[(k, j)] / (t[j] * t[j])).sum();
                let column: f64 = others().map(|i| squares[(i, k)] * t[i] * t[i]).sum();
                if row > 0.0 || column > 0.0 {
                    // A block with no path in or no path out makes its paths small, up to a limit.
                    t[k] = (column.max(floor) / row.max(floor)).powf(0.25).clamp(1e-8, 1e8);
                }
            }
        }
        let mut tw = vec![1.0; structure.rows()];
        let mut tz = vec![1.0; structure.cols()];
        for ((_, w, z), t) in places.iter().zip(&t) {
            tw[w.clone()].fill(*t);
            tz[z.clone()].fill(*t);
        }
        let scaled = |m: &CMat| CMat::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)] * (tz[i] / tw[j]));
        Self { matrices: all.iter().map(scaled).collect(), tw, tz }
    }
}
