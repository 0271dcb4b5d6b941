//! A loop augmented by the filters of its constant and slowly varying parameters.

use crate::matrix::{Mat, block, diagonal, diagonal_blocks};
use crate::robust::constant::constant_loop::{ConstantLoop, FilteredChannel};
use crate::system::{LoopError, StateSpace, middle_of_gramians};

/// The augmented loop, as maps from `(x, f | wt, v, w_D, w)`: f are the states of the filters of zt, then of wt; v is
/// the contribution of the parameters' rates to the filters of wt. `x~ = back x`.
pub(super) struct Filtered {
    /// Map to x' and f'.
    pub(super) dynamics: Mat,
    /// Map to the channels zt and wt and the filtered ones, then to the channels of the rates.
    pub(super) into: Mat,
    pub(super) from: Mat,
    /// Maps to z_D and w_D of each model error.
    pub(super) errors: Vec<(Mat, Mat)>,
    /// Map to z.
    pub(super) output: Mat,
    /// Sizes of (x, f) and w.
    pub(super) states: usize,
    pub(super) inputs: usize,
    /// The number of states of the loop without the filters.
    pub(super) loop_states: usize,
    /// The parameter of each channel; the rate of a parameter is a further one, after all parameters.
    pub(super) channels: Vec<usize>,
    /// The scaling of the channels, diagonal, and the inverse scaling of the states.
    pub(super) scale: Mat,
    pub(super) back: Mat,
}

impl Filtered {
    /// Builds the augmented loop with `zt = scale zt~`, `wt = scale wt~`, and w and z in units in which `unit` is 1.
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
        let filters: Vec<FilteredChannel> = of.filtered().collect();
        let filtered: Vec<usize> = filters.iter().map(|f| f.channel).collect();
        let moving: Vec<usize> = (0..filtered.len()).filter(|i| filters[*i].rate > 0.0).collect();
        let rates = diagonal(moving.iter().map(|i| filters[*i].rate));
        let (r, w, k, v) = (l.channels.len(), l.b1().ncols(), filtered.len(), moving.len());
        let deltas: usize = errors.iter().map(|e| e.e.ncols()).sum();
        let zeros = Mat::zeros;
        // Indices of the first columns of the filters' states, wt, v and w_D, and the end.
        let (of_zt, of_wt, wt) = (n, n + k, n + 2 * k);
        let (rate, delta) = (wt + r, wt + r + v);
        let select =
            |rows: usize, at: usize| Mat::from_fn(rows, delta + deltas + w, |i, j| f64::from(j == at + i));
        let row = |x: &Mat, t: &Mat, e: &Mat, w: &Mat| {
            let rows = x.nrows();
            block(&[&[x, &zeros(rows, 2 * k), t, &zeros(rows, v), e, w]])
        };
        let zt = row(&l.ct(), &l.dtt(), &zeros(r, deltas), &l.dt1());
        let all_e = errors.iter().fold(zeros(n, 0), |all, e| block(&[&[&all, &e.e]]));
        let decay = diagonal(filters.iter().map(|f| f.pole));
        let filter_z = zt.select_rows(&filtered) - &decay * select(k, of_zt);
        let mut filter_w = select(r, wt).select_rows(&filtered) - &decay * select(k, of_wt);
        moving.iter().enumerate().for_each(|(i, at)| filter_w[(*at, rate + i)] = 1.0);
        let mut at = delta;
        let errors = errors.iter().map(|e| {
            let into = row(&e.fx, &e.ft, &zeros(e.fx.nrows(), deltas), &e.fw);
            let from = select(e.e.ncols(), at);
            at += e.e.ncols();
            (into, from)
        });
        let (errors, output) =
            (errors.collect(), row(&l.c1(), &l.d1t(), &zeros(l.c1().nrows(), deltas), &l.d11()));
        let of_filters = |m: &Mat| diagonal(filtered.iter().map(|c| m[(*c, *c)]));
        let (both, filter_units) = (of_filters(scale), of_filters(&inverse));
        let of_rates = both.select_rows(&moving).select_columns(&moving);
        let parameters = || filtered.iter().map(|c| l.channels[*c]);
        let of_rate = moving.iter().map(|i| of.filters.len() + l.channels[filtered[*i]]);
        Self {
            dynamics: block(&[&[&row(&l.a(), &l.bt(), &all_e, &l.b1())], &[&filter_z], &[&filter_w]]),
            into: block(&[&[&zt], &[&select(k, of_zt)], &[&(rates * select(k, of_zt).select_rows(&moving))]]),
            from: block(&[&[&select(r, wt)], &[&select(k, of_wt)], &[&select(v, rate)]]),
            errors,
            output,
            states: n + 2 * k,
            inputs: w,
            loop_states: n,
            channels: l.channels.iter().copied().chain(parameters()).chain(of_rate).collect(),
            scale: diagonal_blocks(&[scale, &both, &of_rates]),
            back: diagonal_blocks(&[&identity, &filter_units, &filter_units]),
        }
    }

    /// Returns the loop in coordinates of its first `loop_states` states in which its gramians are equal and diagonal.
    pub(super) fn balanced(mut self) -> Option<Self> {
        let states = self.loop_states;
        let (n, m) = (self.states, self.dynamics.ncols() - self.states);
        let all = block(&[&[&self.into], &[&self.output]]);
        let system = StateSpace {
            a: self.dynamics.view((0, 0), (states, states)).into_owned(),
            b: self.dynamics.view((0, n), (states, m)).into_owned(),
            c: all.columns(0, states).into_owned(),
            d: all.columns(n, m).into_owned(),
        };
        let (x, _) = middle_of_gramians(&[&system])?;
        let back = diagonal_blocks(&[&x.cholesky()?.l().transpose(), &Mat::identity(n - states, n - states)]);
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
