//! Exact closed loop with saturated commands.
//!
//! The plant gets `u - phi`, and `E phi` is added to xk'. The excess phi is a share of `e = u - H x - step u_held`:
//! `phi = (e + s)/2` with `s = delta e`, delta a diagonal matrix of further parameters within \[-1, 1\], a channel
//! each. The filters of w upstream of the loop are omitted: the step is measured where it enters the loop, as a jump of
//! one y ([`Certificate::jumping_measurement`]). While it is held, x is the deviation from `step x_held`. `decay/2` is
//! added to A, so that the inequality of such a loop proves a decay rate. The limited rate of a state of the plant is a
//! further u, whose phi acts on that state alone, with the opposite sign.

use super::limits::Limits;

use crate::closed_loop::ClosedLoop;
use crate::error::Failure;
use crate::exact::dyadic::Dyadic;
use crate::exact::matrix::Matrix;
use crate::plant::{Controller, ModelError, Plant, Rows};
use crate::system::Loop;

impl Loop<'_> {
    /// Returns the states of the plant that belong to the loop: those driven by controls or Delta, also through
    /// channels and other states, that in turn act on measurements, channels or Delta. The others are filters of w,
    /// which the steps replace, or of z.
    pub(crate) fn moving_states(self) -> Vec<usize> {
        let (p, n) = (self.plant, self.plant.a.len());
        let any = |row: &[f64]| row.iter().any(|entry| *entry != 0.0);
        let in_row = |m: &Rows, i: usize| m.get(i).is_some_and(|row| any(row));
        let in_column =
            |m: &Rows, j: usize| m.iter().any(|row| row.get(j).is_some_and(|entry| *entry != 0.0));
        let by_delta = |i: usize| self.errors.iter().any(|error| in_row(&error.e, i));
        let in_delta = |j: usize| self.errors.iter().any(|error| in_column(&error.f, j));
        let mut driven: Vec<bool> = (0..n).map(|i| in_row(&p.b2, i) || by_delta(i)).collect();
        let mut observed: Vec<bool> =
            (0..n).map(|j| in_column(&p.c2, j) || in_column(&p.ct, j) || in_delta(j)).collect();
        let mut driven_channels: Vec<bool> = (0..p.ct.len()).map(|k| in_row(&p.dt2, k)).collect();
        let by = |row: &[f64], driven: &[bool]| row.iter().zip(driven).any(|(entry, m)| *entry != 0.0 && *m);
        for _ in 0..n + driven_channels.len() {
            for k in 0..driven_channels.len() {
                driven_channels[k] =
                    driven_channels[k] || by(&p.ct[k], &driven) || by(&p.dtt[k], &driven_channels);
            }
            for i in 0..n {
                driven[i] = driven[i] || by(&p.a[i], &driven) || by(&p.bt[i], &driven_channels);
                if observed[i] {
                    p.a[i].iter().zip(&mut observed).for_each(|(entry, observed)| *observed |= *entry != 0.0);
                }
            }
        }
        (0..n).filter(|&i| driven[i] && observed[i]).collect()
    }

    /// Returns the measurement y that jumps by exactly the step of an input w, if the step acts on the loop of
    /// [`Self::moving_states`] in no other way: not directly on its states, channels and other y, and through filters
    /// at most on the same y. Otherwise returns `None`: the omitted states would carry a part of the step, or all of
    /// it.
    pub(crate) fn jumping_measurement(self, input: usize) -> Option<usize> {
        let (p, retained) = (self.plant, self.moving_states());
        let is_at =
            |m: &Rows, i: usize, j: usize| m.get(i).and_then(|row| row.get(j)).is_some_and(|x| *x != 0.0);
        let jumps: Vec<f64> = p.d21.iter().map(|row| row[input]).collect();
        let jumping = jumps.iter().position(|jump| *jump != 0.0)?;
        let one = jumps.iter().enumerate().all(|(k, jump)| *jump == f64::from(u8::from(k == jumping)));
        // States and channels reached by the step.
        let (n, t) = (p.a.len(), p.ct.len());
        let mut states: Vec<bool> = (0..n).map(|i| is_at(&p.b1, i, input)).collect();
        let mut channels: Vec<bool> = (0..t).map(|k| is_at(&p.dt1, k, input)).collect();
        for _ in 0..n + t {
            let into = |of_states: &Rows, of_channels: &Rows, row: usize| {
                (0..n).any(|j| states[j] && is_at(of_states, row, j))
                    || (0..t).any(|k| channels[k] && is_at(of_channels, row, k))
            };
            let next: Vec<bool> = (0..n).map(|i| states[i] || into(&p.a, &p.bt, i)).collect();
            channels = (0..t).map(|k| channels[k] || into(&p.ct, &p.dtt, k)).collect();
            states = next;
        }
        let to_delta =
            |row: &Vec<f64>| row.iter().zip(&states).any(|(entry, reached)| *reached && *entry != 0.0);
        let to_other = |k: usize| {
            k != jumping
                && ((0..n).any(|j| states[j] && is_at(&p.c2, k, j))
                    || (0..t).any(|c| channels[c] && is_at(&p.d2t, k, c)))
        };
        let other_path = retained.iter().any(|&i| states[i])
            || (0..p.c2.len()).any(to_other)
            || self.errors.iter().any(|error| error.f.iter().any(to_delta));
        (one && !other_path).then_some(jumping)
    }
}

impl ClosedLoop {
    /// Creates the loop of a checked certificate with one input, a step in units of `size`.
    ///
    /// # Errors
    /// Same as [`ClosedLoop::new`].
    pub(super) fn limited(c: Loop<'_>, limits: &Limits, error: &ModelError) -> Result<Self, Failure> {
        let (retained, m) = (c.moving_states(), limits.limits.len());
        let commands = m - limits.rates.len();
        let first = |row: Vec<f64>| row.into_iter().take(limits.delta_rows.unwrap_or(usize::MAX)).collect();
        let step = |row: &Vec<f64>| (0..=m).map(|j| if j == 0 { row[limits.input] } else { 0.0 }).collect();
        let error = ModelError {
            e: rows_of(&error.e, &retained).into_iter().map(first).collect(),
            f: columns_of(&error.f, &retained),
            fw: error.fw.iter().map(step).collect(),
            fu: error.fu.clone(),
        };
        let (plant, controller) =
            &with_saturation_inputs(c, &limits.e, &retained, &[limits.input], &limits.rates);
        let mut closed = Self::new(Loop { plant, controller, ..c }, std::slice::from_ref(&error))?;
        let (n, at) = (closed.states, closed.states + closed.channels);
        if let Some((rows, _)) = &mut closed.delta {
            rows.add(0, at + 1, &Matrix::from_rows(&error.fu, commands).negated());
        }
        let size = Dyadic::from_f64(limits.size);
        let [held, out] = [&limits.x_held, &limits.u_held]
            .map(|column| Matrix::from_rows(&column.iter().map(|x| vec![*x]).collect(), 1));
        let measure_from_held = |rows: &mut Matrix| {
            let step = rows.column_range(at, at + 1).plus(&rows.column_range(0, n).times(&held));
            rows.place(0, at, &step);
        };
        [&mut closed.state, &mut closed.channel, &mut closed.output].into_iter().for_each(measure_from_held);
        closed.delta.iter_mut().for_each(|(rows, _)| measure_from_held(rows));
        let z = closed.output.rows - m;
        closed.output.add(z, at, &out.negated());
        let mut saturated = closed.saturated(&limits.h);
        let scale_step = |rows: &mut Matrix| {
            let at = rows.cols - 1;
            rows.place(0, at, &rows.column_range(at, at + 1).scaled(&size));
        };
        [&mut saturated.state, &mut saturated.channel].into_iter().for_each(scale_step);
        saturated.delta.iter_mut().for_each(|(rows, _)| scale_step(rows));
        saturated.output = Matrix::zeros(0, saturated.state.cols);
        saturated.state.add(0, 0, &Matrix::scalar(n, &Dyadic::from_f64(limits.decay).shifted(-1)));
        Ok(saturated)
    }

    /// Returns the loop of [`with_saturation_inputs`] with a channel for each u in place of phi.
    ///
    /// In `u = k (x, wt, w) + through phi` at given wt, only the rates depend on phi, on that of the commands, because
    /// D22 is 0. So through^2 = 0, and `phi = (e + s)/2` is `share (beyond + s)`, with `e = beyond + through phi`.
    fn saturated(self, h: &Rows) -> Self {
        let (n, r, m) = (self.states, self.channels, h.len());
        let (w, z) = (self.inputs - m, self.output.rows - m);
        let u = self.output.row_range(z, z + m);
        let through = u.column_range(n + r + w, n + r + w + m);
        let half = Dyadic::from_f64(0.5);
        let share = Matrix::scalar(m, &half).plus(&through.scaled(&half.shifted(-1)));
        // Columns are x, wt, s, w.
        let mut beyond = Matrix::zeros(m, n + r + m + w);
        beyond.place(0, 0, &u.column_range(0, n + r));
        beyond.add(0, 0, &Matrix::from_rows(h, n).negated());
        beyond.place(0, n + r + m, &u.column_range(n + r, n + r + w));
        let eliminate_phi = |rows: &Matrix| {
            let of_phi = rows.column_range(n + r + w, n + r + w + m).times(&share);
            let mut all = of_phi.times(&beyond);
            all.add(0, 0, &rows.column_range(0, n + r));
            all.add(0, n + r, &of_phi);
            all.add(0, n + r + m, &rows.column_range(n + r, n + r + w));
            all
        };
        let phi_in_u = through.times(&share);
        let mut e = beyond.plus(&phi_in_u.times(&beyond));
        e.add(0, n + r, &phi_in_u);
        let first = self.parameters.iter().max().map_or(0, |last| last + 1);
        Self {
            channels: r + m,
            inputs: w,
            state: eliminate_phi(&self.state),
            channel: eliminate_phi(&self.channel).above(e),
            output: eliminate_phi(&self.output.row_range(0, z)),
            delta: self.delta.as_ref().map(|(rows, e)| (eliminate_phi(rows), e.clone())),
            parameters: self.parameters.iter().copied().chain(first..first + m).collect(),
            ..self
        }
    }
}

/// Returns the loop with the `retained` states of the plant; with the inputs `inputs` of w, and phi, of which E feeds
/// back that of the commands; and with u below z: the commands, and the limited rates of the states `rates`.
fn with_saturation_inputs(
    c: Loop<'_>,
    e: &Rows,
    retained: &[usize],
    inputs: &[usize],
    rates: &[usize],
) -> (Plant, Controller) {
    let (p, k, m) = (c.plant, c.controller, c.sizes().u);
    let n = retained.len();
    let zeros = |rows: usize, columns: usize| vec![vec![0.0; columns]; rows];
    let unit: Rows = (0..m).map(|i| (0..m).map(|j| f64::from(u8::from(i == j))).collect()).collect();
    let below = |top: Rows, bottom: Rows| -> Rows { top.into_iter().chain(bottom).collect() };
    let beside = |left: &Rows, right: &Rows| -> Rows {
        left.iter().zip(right).map(|(a, b)| a.iter().chain(b).copied().collect()).collect()
    };
    let with_phi = |b1: &Rows, b2: &Rows| {
        let negated = |row: &Vec<f64>| {
            row.iter().map(|entry| -entry).chain(std::iter::repeat_n(0.0, rates.len())).collect()
        };
        beside(&columns_of(b1, inputs), &b2.iter().map(negated).collect())
    };
    let (t, y) = (p.ct.len(), p.c2.len());
    let limited = |commands: Rows, all: &Rows| below(commands, rows_of(all, rates));
    let direct = with_phi(&p.b1, &p.b2);
    let mut b1 = direct.clone();
    rates.iter().enumerate().for_each(|(j, &state)| b1[state][inputs.len() + m + j] = -1.0);
    let plant = Plant {
        a: columns_of(&rows_of(&p.a, retained), retained),
        bt: rows_of(&p.bt, retained),
        b1: rows_of(&b1, retained),
        b2: rows_of(&p.b2, retained),
        ct: columns_of(&p.ct, retained),
        c1: limited(below(columns_of(&p.c1, retained), zeros(m, n)), &columns_of(&p.a, retained)),
        c2: below(columns_of(&p.c2, retained), zeros(m, n)),
        dtt: p.dtt.clone(),
        dt1: with_phi(&p.dt1, &p.dt2),
        dt2: p.dt2.clone(),
        d1t: limited(below(p.d1t.clone(), zeros(m, t)), &p.bt),
        d11: limited(below(with_phi(&p.d11, &p.d12), zeros(m, inputs.len() + m + rates.len())), &direct),
        d12: limited(below(p.d12.clone(), unit.clone()), &p.b2),
        d2t: below(p.d2t.clone(), zeros(m, t)),
        d21: below(
            with_phi(&p.d21, &zeros(y, m)),
            beside(&beside(&zeros(m, inputs.len()), &unit), &zeros(m, rates.len())),
        ),
        d22: vec![],
    };
    let controller = Controller {
        by: beside(&k.by, e),
        duy: beside(&k.duy, &zeros(k.duy.len(), m)),
        dty: beside(&k.dty, &zeros(k.dty.len(), m)),
        ..k.clone()
    };
    (plant, controller)
}

fn rows_of(m: &Rows, retained: &[usize]) -> Rows {
    retained.iter().map(|&i| m[i].clone()).collect()
}

fn columns_of(m: &Rows, retained: &[usize]) -> Rows {
    m.iter().map(|row| retained.iter().map(|&j| row[j]).collect()).collect()
}
