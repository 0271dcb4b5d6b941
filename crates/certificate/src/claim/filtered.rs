//! Exact matrices of the claim with constant parameters.

use crate::closed_loop::ClosedLoop;
use crate::exact::dyadic::Dyadic;
use crate::exact::matrix::Matrix;
use crate::plant::Rows;
use crate::shape::columns;
use crate::system::Loop;
use serde::{Deserialize, Serialize};

/// Filter `1/(s + pole)` on the channels of a parameter that is constant or changes slowly.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Filter {
    /// Index of the parameter, from 0.
    pub parameter: usize,
    /// Pole, above 0.
    pub pole: f64,
    /// Bound on the rate of the parameter, 1/s; 0, or no such key in the file, if it is constant.
    #[serde(default, skip_serializing_if = "is_constant")]
    pub rate: f64,
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_constant(rate: &f64) -> bool {
    *rate == 0.0
}

/// Loop with its filters, as maps from `(x, f | wt, v, w_D, w)` with the states f of the filters and the inputs v of
/// the rates.
pub(super) struct Filtered<'a> {
    system: Loop<'a>,
    closed: &'a ClosedLoop,
    /// Number of states of the loop.
    n: usize,
    /// Number of filtered channels.
    k: usize,
    /// Number of channels.
    r: usize,
    /// Number of columns of all Delta.
    d: usize,
    /// Number of inputs.
    w: usize,
    /// Filter of each filtered channel, and the index of the channel.
    filters: Vec<(&'a Filter, usize)>,
    /// Indices of the filters with a rate above 0.
    with_rate: Vec<usize>,
}

impl<'a> Filtered<'a> {
    pub(super) fn new(system: Loop<'a>, filters: &'a [Filter], closed: &'a ClosedLoop) -> Self {
        let channels = |parameter: usize| {
            let own = move |c: &usize| closed.parameters[*c] == parameter;
            (0..closed.channels).filter(own)
        };
        let filters = filters.iter().flat_map(|f| channels(f.parameter).map(move |c| (f, c)));
        let filters: Vec<_> = filters.collect();
        Self {
            system,
            closed,
            n: closed.states,
            k: filters.len(),
            r: closed.channels,
            d: closed.delta.as_ref().map_or(0, |(_, e)| e.cols),
            w: closed.inputs,
            with_rate: (0..filters.len()).filter(|i| filters[*i].0.rate > 0.0).collect(),
            filters,
        }
    }

    /// Returns the parameter of each channel, the filtered channels and those of the rates last; the rate of a
    /// parameter counts as a further parameter, numbered after all others.
    pub(super) fn parameters(&self) -> Vec<usize> {
        let filtered = self.filters.iter().map(|(_, c)| self.closed.parameters[*c]);
        let rates = self.with_rate.iter().map(|i| self.system.parameters() + self.filters[*i].0.parameter);
        self.closed.parameters.iter().copied().chain(filtered).chain(rates).collect()
    }

    /// Returns the first columns of wt, v, w_D and w, and the number of columns.
    fn columns(&self) -> [usize; 5] {
        let wt = self.n + 2 * self.k;
        let v = wt + self.r;
        let delta = v + self.with_rate.len();
        [wt, v, delta, delta + self.d, delta + self.d + self.w]
    }

    /// Extends a map of the loop from `(x | wt | w)` to all columns.
    fn extend(&self, m: &Matrix) -> Matrix {
        let [wt, _, _, w, all] = self.columns();
        let mut out = Matrix::zeros(m.rows, all);
        out.place(0, 0, &m.column_range(0, self.n));
        out.place(0, wt, &m.column_range(self.n, self.n + self.r));
        out.place(0, w, &m.column_range(self.n + self.r, m.cols));
        out
    }

    /// Returns `rows` unit rows that begin at column `at`.
    fn unit(&self, rows: usize, at: usize) -> Matrix {
        let mut out = Matrix::zeros(rows, self.columns()[4]);
        out.place(0, at, &Matrix::scalar(rows, &Dyadic::from_f64(1.0)));
        out
    }

    /// Returns the maps Z to (zt, f, rate f) and W to (wt, g, v).
    fn channels(&self) -> (Matrix, Matrix) {
        let [wt, v, ..] = self.columns();
        let (filtered, mut rates) = (self.unit(self.k, self.n), Matrix::zeros(0, self.columns()[4]));
        for i in &self.with_rate {
            let rate = Dyadic::from_f64(self.filters[*i].0.rate);
            rates = rates.above(filtered.row_range(*i, i + 1).scaled(&rate));
        }
        let zt = self.extend(&self.closed.channel).above(filtered).above(rates);
        let wt = self.unit(self.r, wt).above(self.unit(self.k, self.n + self.k));
        (zt, wt.above(self.unit(self.with_rate.len(), v)))
    }

    /// Returns the map to the derivatives of (x, f, g), with `f' = -a f + zt` and `g' = -a g + wt + v`.
    fn dynamics(&self, into: &Matrix, from: &Matrix) -> Matrix {
        let [_, v, delta, ..] = self.columns();
        let mut x = self.extend(&self.closed.state);
        if let Some((_, e)) = &self.closed.delta {
            x.place(0, delta, e);
        }
        let filter = |map: &Matrix, at: usize| {
            let mut out = Matrix::zeros(self.k, map.cols);
            for (i, (filter, channel)) in self.filters.iter().enumerate() {
                out.place(i, 0, &map.row_range(*channel, channel + 1));
                out[(i, at + i)] = &out[(i, at + i)] + &Dyadic::from_f64(-filter.pole);
            }
            out
        };
        let mut g_rows = filter(from, self.n + self.k);
        self.with_rate.iter().enumerate().for_each(|(j, i)| g_rows[(*i, v + j)] = Dyadic::from_f64(1.0));
        x.above(filter(into, self.n)).above(g_rows)
    }

    /// Returns the matrix that must be negative definite; rows (x, f | wt, v, w_D, w | z).
    pub(super) fn inequality(&self, (x, s, t): (&Rows, &Rows, &Rows), gamma: f64, lambdas: &[f64]) -> Matrix {
        let [_, _, w_delta, w, all] = self.columns();
        let (into, from) = self.channels();
        let mut half = Matrix::zeros(all, all);
        half.place(0, 0, &Matrix::square(x).times(&self.dynamics(&into, &from)));
        half = half.plus(&from.transpose().times(&Matrix::square(t).times(&into)));
        let s = Matrix::square(s);
        let square = |m: &Matrix| m.transpose().times(&s.times(m));
        let mut upper = half.plus(&half.transpose()).plus(&square(&into)).plus(&square(&from).negated());
        if let Some((error, _)) = &self.closed.delta {
            let (mut row, mut column) = (0, w_delta);
            for (model_error, lambda) in self.system.errors.iter().zip(lambdas) {
                let lambda = Dyadic::from_f64(*lambda);
                let (nf, ne) = (model_error.f.len(), columns(&model_error.e));
                let z = self.extend(&error.row_range(row, row + nf));
                upper = upper.plus(&z.transpose().times(&z).scaled(&lambda));
                subtract(&mut upper, column, ne, &lambda);
                (row, column) = (row + nf, column + ne);
            }
        }
        let gamma = Dyadic::from_f64(gamma);
        subtract(&mut upper, w, self.w, &gamma);
        let output = self.extend(&self.closed.output);
        let mut matrix = Matrix::zeros(all + output.rows, all + output.rows);
        matrix.place(0, 0, &upper);
        matrix.place(all, 0, &output);
        matrix.place(0, all, &output.transpose());
        subtract(&mut matrix, all, output.rows, &gamma);
        matrix
    }

    /// Returns `A'L + LA`.
    pub(super) fn lyapunov_form(&self, lyapunov: &Rows) -> Matrix {
        let a = self.closed.state.column_range(0, self.n);
        let product = Matrix::square(lyapunov).times(&a);
        product.plus(&product.transpose())
    }

    /// Returns S on the channels of a parameter, the filtered ones last, or of a rate.
    pub(super) fn multiplier(&self, s: &Rows, parameter: usize) -> Matrix {
        let parameters = self.parameters();
        let own: Vec<usize> = (0..parameters.len()).filter(|c| parameters[*c] == parameter).collect();
        Matrix::square(s).principal(&own)
    }
}

/// Subtracts `value I` of a size from the diagonal, beginning at `at`.
fn subtract(m: &mut Matrix, at: usize, size: usize, value: &Dyadic) {
    (at..at + size).for_each(|i| m[(i, i)] = &m[(i, i)] + &-value);
}
