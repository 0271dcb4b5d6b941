//! A loop together with the filters of its constant parameters.

use crate::matrix::{Mat, block, diagonal, diagonal_blocks};
use crate::robust::constant::constant_loop::ConstantLoop;
use crate::system::lyapunov::middle_of_gramians;
use crate::system::model_error::LoopError;
use crate::system::state_space::StateSpace;

/// The loop with its filters, as maps from `(x, f | wt, w_D, w)`: f are the states of the filters, and `x~ = back x`.
pub(super) struct Filtered {
    /// To x' and f'.
    pub(super) dynamics: Mat,
    /// To the channels zt and wt with what is filtered of them.
    pub(super) into: Mat,
    pub(super) from: Mat,
    /// To z_D and w_D of each model error.
    pub(super) errors: Vec<(Mat, Mat)>,
    /// To z.
    pub(super) output: Mat,
    /// Sizes of (x, f) and w.
    pub(super) states: usize,
    pub(super) inputs: usize,
    /// The number of the loop's own states, without the filters.
    pub(super) own: usize,
    /// The parameter of each channel, the filtered ones last.
    pub(super) channels: Vec<usize>,
    /// The scaling of the channels, diagonal, and the inverse of that of the states.
    pub(super) scale: Mat,
    pub(super) back: Mat,
}

impl Filtered {
    /// With `zt = scale zt~`, `wt = scale wt~`, and w and z in units in which a gain of `unit` is 1.
    pub(super) fn new(of: &ConstantLoop, unit: f64, scale: &Mat) -> Self {
        let inverse = scale.map(|s| if s > 0.0 { 1.0 / s } else { 0.0 });
        let n = of.closed.a().nrows();
        let identity = Mat::identity(n, n);
        let l = of.closed.in_coordinates((&identity, &identity), (scale, &inverse)).in_units_of(unit);
        let errors: Vec<LoopError> = of
            .errors
            .iter()
            .map(|e| e.in_coordinates((&identity, &identity), scale).in_units_of(unit))
            .collect();
        let (r, w) = (l.channels.len(), l.b1().ncols());
        let own: Vec<usize> = of.dynamic().flat_map(|(own, _)| own).collect();
        let rates = of.dynamic().flat_map(|(own, pole)| vec![pole; own.len()]);
        let k = own.len();
        let deltas: usize = errors.iter().map(|e| e.e.ncols()).sum();
        let zeros = Mat::zeros;
        let place = |rows: usize, at: usize| {
            Mat::from_fn(rows, n + 2 * k + r + deltas + w, |i, j| f64::from(j == at + i))
        };
        let (filters, wt) = (n, n + 2 * k);
        let zt = block(&[&[&l.ct(), &zeros(r, 2 * k), &l.dtt(), &zeros(r, deltas), &l.dt1()]]);
        let all_e = errors.iter().fold(zeros(n, 0), |all, e| block(&[&[&all, &e.e]]));
        let moved = block(&[&[&l.a(), &zeros(n, 2 * k), &l.bt(), &all_e, &l.b1()]]);
        let decay = diagonal(rates);
        let filter_z = zt.select_rows(&own) - &decay * place(k, filters);
        let filter_w = place(r, wt).select_rows(&own) - &decay * place(k, filters + k);
        let mut at = wt + r;
        let errors = errors.iter().map(|e| {
            let rows = e.fx.nrows();
            let into = block(&[&[&e.fx, &zeros(rows, 2 * k), &e.ft, &zeros(rows, deltas), &e.fw]]);
            let from = place(e.e.ncols(), at);
            at += e.e.ncols();
            (into, from)
        });
        let both = scale.select_rows(&own).select_columns(&own);
        let filter_units = inverse.select_rows(&own).select_columns(&own);
        Self {
            dynamics: block(&[&[&moved], &[&filter_z], &[&filter_w]]),
            into: block(&[&[&zt], &[&place(k, filters)]]),
            from: block(&[&[&place(r, wt)], &[&place(k, filters + k)]]),
            errors: errors.collect(),
            output: block(&[&[
                &l.c1(),
                &zeros(l.c1().nrows(), 2 * k),
                &l.d1t(),
                &zeros(l.c1().nrows(), deltas),
                &l.d11(),
            ]]),
            states: n + 2 * k,
            inputs: w,
            own: n,
            channels: l.channels.iter().copied().chain(own.iter().map(|c| l.channels[*c])).collect(),
            scale: diagonal_blocks(&[scale, &both]),
            back: diagonal_blocks(&[&identity, &filter_units, &filter_units]),
        }
    }

    /// In coordinates of the loop's own states in which its gramians are equal and diagonal: the first `own` states.
    pub(super) fn balanced(mut self) -> Option<Self> {
        let own = self.own;
        let (n, m) = (self.states, self.dynamics.ncols() - self.states);
        let all = block(&[&[&self.into], &[&self.output]]);
        let whole = StateSpace {
            a: self.dynamics.view((0, 0), (own, own)).into_owned(),
            b: self.dynamics.view((0, n), (own, m)).into_owned(),
            c: all.columns(0, own).into_owned(),
            d: all.columns(n, m).into_owned(),
        };
        let (x, _) = middle_of_gramians(&[&whole])?;
        let back = diagonal_blocks(&[&x.cholesky()?.l().transpose(), &Mat::identity(n - own, n - own)]);
        let to = diagonal_blocks(&[&back.clone().try_inverse()?, &Mat::identity(m, m)]);
        self.dynamics = &back * self.dynamics * &to;
        for map in [&mut self.into, &mut self.from, &mut self.output] {
            *map = &*map * &to;
        }
        self.errors = self.errors.iter().map(|(into, from)| (into * &to, from * &to)).collect();
        self.back = back * self.back;
        Some(self)
    }
}
