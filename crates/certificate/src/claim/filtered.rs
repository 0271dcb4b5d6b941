//! The matrices that must be definite, formed exactly.

use crate::closed_loop::ClosedLoop;
use crate::exact::dyadic::Dyadic;
use crate::exact::matrix::Matrix;
use crate::plant::Rows;
use crate::shape::columns;
use crate::system::Loop;
use serde::{Deserialize, Serialize};

/// A filter `1/(s + pole)` on the channels of a parameter that is constant or changes slowly.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Filter {
    /// The parameter, from 0.
    pub parameter: usize,
    /// Above 0.
    pub pole: f64,
    /// Bound on the rate of the parameter, 1/s; 0, or no such key in the file, where it is constant.
    #[serde(default, skip_serializing_if = "is_constant")]
    pub rate: f64,
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_constant(rate: &f64) -> bool {
    *rate == 0.0
}

/// The loop with its filters, as maps from `(x, f | wt, v, w_D, w)` with the states f of the filters and v of rates.
pub(super) struct Filtered<'a> {
    of: Loop<'a>,
    closed: &'a ClosedLoop,
    /// The number of states of the loop, of filtered channels, of channels, of columns of all Delta, of inputs.
    n: usize,
    k: usize,
    r: usize,
    d: usize,
    w: usize,
    /// The filter of each filtered channel, and the channel.
    filters: Vec<(&'a Filter, usize)>,
    /// Which of these have a rate.
    moving: Vec<usize>,
}

impl<'a> Filtered<'a> {
    pub(super) fn new(of: Loop<'a>, filters: &'a [Filter], closed: &'a ClosedLoop) -> Self {
        let channels = |parameter: usize| {
            let own = move |c: &usize| closed.parameters[*c] == parameter;
            (0..closed.channels).filter(own)
        };
        let filters = filters.iter().flat_map(|f| channels(f.parameter).map(move |c| (f, c)));
        let filters: Vec<_> = filters.collect();
        Self {
            of,
            closed,
            n: closed.states,
            k: filters.len(),
            r: closed.channels,
            d: closed.delta.as_ref().map_or(0, |(_, e)| e.cols),
            w: closed.inputs,
            moving: (0..filters.len()).filter(|i| filters[*i].0.rate > 0.0).collect(),
            filters,
        }
    }

    /// The parameter of each channel, the filtered ones and those of the rates last; the rate of a parameter counts as
    /// one more, after all of them.
    pub(super) fn parameters(&self) -> Vec<usize> {
        let filtered = self.filters.iter().map(|(_, c)| self.closed.parameters[*c]);
        let rates = self.moving.iter().map(|i| self.of.parameters() + self.filters[*i].0.parameter);
        self.closed.parameters.iter().copied().chain(filtered).chain(rates).collect()
    }

    /// Where wt, v, w_D and w begin, and the end.
    fn columns(&self) -> [usize; 5] {
        let wt = self.n + 2 * self.k;
        let v = wt + self.r;
        let delta = v + self.moving.len();
        [wt, v, delta, delta + self.d, delta + self.d + self.w]
    }

    /// A map of the loop, of `(x | wt | w)`, as one of all columns.
    fn spread(&self, m: &Matrix) -> Matrix {
        let [wt, _, _, w, all] = self.columns();
        let mut out = Matrix::zeros(m.rows, all);
        out.place(0, 0, &m.column_range(0, self.n));
        out.place(0, wt, &m.column_range(self.n, self.n + self.r));
        out.place(0, w, &m.column_range(self.n + self.r, m.cols));
        out
    }

    /// `rows` unit rows that begin at column `at`.
    fn unit(&self, rows: usize, at: usize) -> Matrix {
        let mut out = Matrix::zeros(rows, self.columns()[4]);
        out.place(0, at, &Matrix::scalar(rows, &Dyadic::from_f64(1.0)));
        out
    }

    /// To zt, what is filtered of it and that times the rates, and to wt, what is filtered of it and v.
    fn channels(&self) -> (Matrix, Matrix) {
        let [wt, v, ..] = self.columns();
        let (filtered, mut slowed) = (self.unit(self.k, self.n), Matrix::zeros(0, self.columns()[4]));
        for i in &self.moving {
            let rate = Dyadic::from_f64(self.filters[*i].0.rate);
            slowed = slowed.above(filtered.row_range(*i, i + 1).scaled(&rate));
        }
        let zt = self.spread(&self.closed.channel).above(filtered).above(slowed);
        let wt = self.unit(self.r, wt).above(self.unit(self.k, self.n + self.k));
        (zt, wt.above(self.unit(self.moving.len(), v)))
    }

    /// To x' and f', where `f' = -a f + zt`, and `f' = -a f + wt + v` for wt.
    fn dynamics(&self, into: &Matrix, from: &Matrix) -> Matrix {
        let [_, v, delta, ..] = self.columns();
        let mut x = self.spread(&self.closed.state);
        if let Some((_, e)) = &self.closed.delta {
            x.place(0, delta, e);
        }
        let filter = |of: &Matrix, at: usize| {
            let mut out = Matrix::zeros(self.k, of.cols);
            for (i, (filter, channel)) in self.filters.iter().enumerate() {
                out.place(i, 0, &of.row_range(*channel, channel + 1));
                out[(i, at + i)] = &out[(i, at + i)] + &Dyadic::from_f64(-filter.pole);
            }
            out
        };
        let mut of_wt = filter(from, self.n + self.k);
        self.moving.iter().enumerate().for_each(|(j, i)| of_wt[(*i, v + j)] = Dyadic::from_f64(1.0));
        x.above(filter(into, self.n)).above(of_wt)
    }

    /// The matrix that must be negative definite; rows (x, f | wt, v, w_D, w | z).
    pub(super) fn main(&self, (x, s, t): (&Rows, &Rows, &Rows), gamma: f64, lambdas: &[f64]) -> Matrix {
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
            for (ball, lambda) in self.of.errors.iter().zip(lambdas) {
                let lambda = Dyadic::from_f64(*lambda);
                let (nf, ne) = (ball.f.len(), columns(&ball.e));
                let z = self.spread(&error.row_range(row, row + nf));
                upper = upper.plus(&z.transpose().times(&z).scaled(&lambda));
                subtract(&mut upper, column, ne, &lambda);
                (row, column) = (row + nf, column + ne);
            }
        }
        let gamma = Dyadic::from_f64(gamma);
        subtract(&mut upper, w, self.w, &gamma);
        let output = self.spread(&self.closed.output);
        let mut whole = Matrix::zeros(all + output.rows, all + output.rows);
        whole.place(0, 0, &upper);
        whole.place(all, 0, &output);
        whole.place(0, all, &output.transpose());
        subtract(&mut whole, all, output.rows, &gamma);
        whole
    }

    /// `A'L + LA`.
    pub(super) fn decay(&self, lyapunov: &Rows) -> Matrix {
        let a = self.closed.state.column_range(0, self.n);
        let product = Matrix::square(lyapunov).times(&a);
        product.plus(&product.transpose())
    }

    /// S on the channels of a parameter, the filtered ones last, or of a rate.
    pub(super) fn multiplier(&self, s: &Rows, parameter: usize) -> Matrix {
        let parameters = self.parameters();
        let own: Vec<usize> = (0..parameters.len()).filter(|c| parameters[*c] == parameter).collect();
        Matrix::square(s).principal(&own)
    }
}

/// Takes `value I` of a size off the diagonal from `at` on.
fn subtract(m: &mut Matrix, at: usize, size: usize, value: &Dyadic) {
    (at..at + size).for_each(|i| m[(i, i)] = &m[(i, i)] + &-value);
}
