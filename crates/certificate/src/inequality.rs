//! Exact matrix of the linear matrix inequality.

use crate::closed_loop::ClosedLoop;
use crate::exact::dyadic::Dyadic;
use crate::exact::matrix::Matrix;

/// Symmetric matrix with named blocks of rows.
pub(crate) struct Blocked {
    pub(crate) matrix: Matrix,
    /// Name and size of each block of rows.
    pub(crate) blocks: Vec<(&'static str, usize)>,
    /// Factor by which the matrix is multiplied.
    pub(crate) scale: Dyadic,
}

/// Matrices and multipliers of a proof.
pub(crate) struct Scalings {
    pub(crate) gamma: Dyadic,
    /// Multiplier of Delta; unused without a model error.
    pub(crate) lambda: Dyadic,
    pub(crate) x: Matrix,
    pub(crate) s: Matrix,
    pub(crate) t: Matrix,
}

/// Returns the matrix that must be negative definite, `G + G'` with
///
/// ```text
///              x     wt    w_D         w           zt     z_D         z
/// x        [ X A   X Bt    X E       X B1                                      ]
/// wt       [ T Ct  T Dtt -S/2        T Dt1                                     ]
/// w_D      [              -lambda/2                                            ]
/// w        [                       -gamma/2                                    ]
/// zt       [ S Ct  S Dtt            S Dt1         -S/2                         ]
/// z_D      [ lambda (F_x  F_t  0  F_w)                   -lambda/2             ]
/// z        [ C1    D1t              D11                             -gamma/2   ]
/// ```
///
/// The blocks w_D and z_D occur only with a model error. In discrete time the rows of X form a block x+, after w, with
/// `-X/2` on the diagonal there and in the block x. The matrix is multiplied by the `scale` of [`ClosedLoop`], which is
/// positive.
pub(crate) fn inequality(closed: &ClosedLoop, proof: &Scalings) -> Blocked {
    let (n, r, w, z) = (closed.states, closed.channels, closed.inputs, closed.output.rows);
    let (d, f) = closed.delta.as_ref().map_or((0, 0), |(error, e)| (e.cols, error.rows));
    let next = if closed.discrete { n } else { 0 };
    let blocks = vec![
        ("x", n),
        ("wt", r),
        ("w_Delta", d),
        ("w", w),
        ("x+", next),
        ("zt", r),
        ("z_Delta", f),
        ("z", z),
    ];
    let (starts, all) = starts(&blocks);
    let mut half = Matrix::zeros(all, all);
    let mut row = |at: usize, m: &Matrix| {
        half.place(at, 0, &m.column_range(0, n + r));
        half.place(at, starts[3], &m.column_range(n + r, n + r + w));
    };
    let state = if closed.discrete { starts[4] } else { 0 };
    row(state, &proof.x.times(&closed.state));
    row(starts[1], &proof.t.times(&closed.channel));
    row(starts[5], &proof.s.times(&closed.channel));
    row(starts[7], &closed.output);
    if let Some((error, e)) = &closed.delta {
        row(starts[6], &Matrix::scalar(f, &proof.lambda).times(error));
        half.place(state, starts[2], &proof.x.times(e));
    }
    let mut diagonal = Matrix::zeros(all, all);
    let constant = |value: &Dyadic| -&(value * &closed.scale);
    let (gamma, lambda) = (constant(&proof.gamma), constant(&proof.lambda));
    let s = proof.s.scaled(&closed.scale).negated();
    diagonal.place(starts[1], starts[1], &s);
    diagonal.place(starts[2], starts[2], &Matrix::scalar(d, &lambda));
    diagonal.place(starts[3], starts[3], &Matrix::scalar(w, &gamma));
    diagonal.place(starts[5], starts[5], &s);
    diagonal.place(starts[6], starts[6], &Matrix::scalar(f, &lambda));
    diagonal.place(starts[7], starts[7], &Matrix::scalar(z, &gamma));
    if closed.discrete {
        let x = proof.x.scaled(&closed.scale).negated();
        diagonal.place(0, 0, &x);
        diagonal.place(state, state, &x);
    }
    let matrix = half.plus(&half.transpose()).plus(&diagonal);
    Blocked { matrix, blocks, scale: closed.scale.clone() }
}

/// Returns the first row of each block, and the number of rows.
pub(crate) fn starts(blocks: &[(&'static str, usize)]) -> (Vec<usize>, usize) {
    let (mut starts, mut all) = (vec![], 0);
    for (_, size) in blocks {
        starts.push(all);
        all += size;
    }
    (starts, all)
}

impl Blocked {
    /// Returns the block of a row, and the row within it.
    pub(crate) fn locate(&self, row: usize) -> (&'static str, usize) {
        let mut start = 0;
        for &(name, size) in &self.blocks {
            if row < start + size {
                return (name, row - start);
            }
            start += size;
        }
        ("", row)
    }
}
