//! The closed loop whose commands are cut off at limits, formed exactly.
//!
//! The plant gets `u - phi`, and xk' gets `E phi`. What is cut off is a share of `e = u - H x - step u_held`: `phi =
//! (e + s)/2` with `s = delta e`, delta a diagonal matrix of further parameters within \[-1, 1\], a channel each.
//! While a step is held, x is taken from `step x_held`. `decay/2` is added to A, so that the inequality of such a
//! loop is that of a decay.

use crate::certificate::{Certificate, Controller, Limits, Plant, Residual, Rows};
use crate::closed_loop::{ClosedLoop, above};
use crate::error::Failure;
use crate::exact::dyadic::Dyadic;
use crate::exact::matrix::Matrix;

impl Certificate {
    /// The states of the plant that the loop consists of: those that controls or Delta move, also through channels and
    /// other states, and that in turn move measurements, channels or Delta. The others are filters of w, in whose place
    /// the steps act, or of z.
    pub fn moving_states(&self) -> Vec<usize> {
        let (p, n) = (&self.plant, self.plant.a.len());
        let any = |row: &[f64]| row.iter().any(|entry| *entry != 0.0);
        let in_row = |m: &Rows, i: usize| m.get(i).is_some_and(|row| any(row));
        let in_column =
            |m: &Rows, j: usize| m.iter().any(|row| row.get(j).is_some_and(|entry| *entry != 0.0));
        let none = Rows::new();
        let (e, f) = self.residual.as_ref().map_or((&none, &none), |r| (&r.e, &r.f));
        let mut moved: Vec<bool> = (0..n).map(|i| in_row(&p.b2, i) || in_row(e, i)).collect();
        let mut seen: Vec<bool> =
            (0..n).map(|j| in_column(&p.c2, j) || in_column(&p.ct, j) || in_column(f, j)).collect();
        let mut carries: Vec<bool> = (0..p.ct.len()).map(|k| in_row(&p.dt2, k)).collect();
        let by = |row: &[f64], moved: &[bool]| row.iter().zip(moved).any(|(entry, m)| *entry != 0.0 && *m);
        for _ in 0..n + carries.len() {
            for k in 0..carries.len() {
                carries[k] = carries[k] || by(&p.ct[k], &moved) || by(&p.dtt[k], &carries);
            }
            for i in 0..n {
                moved[i] = moved[i] || by(&p.a[i], &moved) || by(&p.bt[i], &carries);
                if seen[i] {
                    p.a[i].iter().zip(&mut seen).for_each(|(entry, seen)| *seen |= *entry != 0.0);
                }
            }
        }
        (0..n).filter(|&i| moved[i] && seen[i]).collect()
    }
}

impl ClosedLoop {
    /// The loop of a checked certificate, with one input, a step of at most `size` in units of that.
    ///
    /// # Errors
    /// As [`ClosedLoop::new`].
    pub(crate) fn limited(c: &Certificate, limits: &Limits, error: &Residual) -> Result<Self, Failure> {
        let kept = c.moving_states();
        let m = limits.limits.len();
        let first = |row: Vec<f64>| row.into_iter().take(limits.delta_rows.unwrap_or(usize::MAX)).collect();
        let step = |row: &Vec<f64>| (0..=m).map(|j| if j == 0 { row[limits.input] } else { 0.0 }).collect();
        let error = Residual {
            e: rows_of(&error.e, &kept).into_iter().map(first).collect(),
            f: columns_of(&error.f, &kept),
            fw: error.fw.iter().map(step).collect(),
            ..error.clone()
        };
        let mut whole = Self::new(&opened(c, limits, &kept), Some(&error))?;
        let (n, r) = (whole.states, whole.channels);
        let cut = Matrix::from_rows(&error.fu, m).negated();
        if let Some((rows, _)) = &mut whole.delta {
            rows.add(0, n + r + 1, &cut);
        }
        let [held, out] = [&limits.x_held, &limits.u_held]
            .map(|column| Matrix::from_rows(&column.iter().map(|x| vec![*x]).collect(), 1));
        let size = Dyadic::from_f64(limits.size);
        // Columns x, t, step; and phi.
        let parts = |rows: &Matrix| {
            let t = rows.transpose();
            let part = |from: usize, to: usize| t.row_range(from, to).transpose();
            let x = part(0, n);
            let step = part(n + r, n + r + 1).plus(&x.times(&held));
            ([x, part(n, n + r), step], part(n + r + 1, n + r + 1 + m))
        };
        let ([kx, kt, kw], _) = parts(&whole.output);
        let beyond = [kx.plus(&Matrix::from_rows(&limits.h, n).negated()), kt, kw.plus(&out.negated())];
        let placed = |rows: usize, [x, t, step]: [Matrix; 3], s: &Matrix| {
            let mut all = Matrix::zeros(rows, n + r + m + 1);
            all.place(0, 0, &x);
            all.place(0, n, &t);
            all.place(0, n + r, s);
            all.place(0, n + r + m, &step.scaled(&size));
            all
        };
        let mixed = |rows: &Matrix| {
            let (direct, phi) = parts(rows);
            let half = phi.scaled(&Dyadic::from_f64(0.5));
            let [x, t, step] = [0, 1, 2].map(|k| direct[k].plus(&half.times(&beyond[k])));
            placed(rows.rows, [x, t, step], &half)
        };
        let mut state = mixed(&whole.state);
        state.add(0, 0, &Matrix::scalar(n, &Dyadic::from_f64(limits.decay).shifted(-1)));
        let first = whole.parameters.iter().max().map_or(0, |last| last + 1);
        let channel = above(&mixed(&whole.channel), &placed(m, beyond.clone(), &Matrix::zeros(m, m)));
        Ok(Self {
            channels: r + m,
            inputs: 1,
            state,
            channel,
            output: Matrix::zeros(0, n + r + m + 1),
            delta: whole.delta.as_ref().map(|(rows, e)| (mixed(rows), e.clone())),
            parameters: whole.parameters.iter().copied().chain(first..first + m).collect(),
            ..whole
        })
    }
}

/// The loop with the inputs step and phi, and u as its output.
fn opened(c: &Certificate, limits: &Limits, kept: &[usize]) -> Certificate {
    let (p, k, m) = (&c.plant, &c.controller, limits.limits.len());
    let n = kept.len();
    let zeros = |rows: usize, columns: usize| vec![vec![0.0; columns]; rows];
    let unit: Rows = (0..m).map(|i| (0..m).map(|j| f64::from(u8::from(i == j))).collect()).collect();
    let inputs = |b1: &Rows, b2: &Rows| -> Rows {
        let row = |(one, two): (&Vec<f64>, &Vec<f64>)| {
            std::iter::once(one[limits.input]).chain(two.iter().map(|entry| -entry)).collect()
        };
        b1.iter().zip(b2).map(row).collect()
    };
    let below = |top: Rows, bottom: Rows| -> Rows { top.into_iter().chain(bottom).collect() };
    let beside = |left: &Rows, right: &Rows| -> Rows {
        left.iter().zip(right).map(|(a, b)| a.iter().chain(b).copied().collect()).collect()
    };
    let (t, y) = (p.ct.len(), p.c2.len());
    let plant = Plant {
        a: columns_of(&rows_of(&p.a, kept), kept),
        bt: rows_of(&p.bt, kept),
        b1: rows_of(&inputs(&p.b1, &p.b2), kept),
        b2: rows_of(&p.b2, kept),
        ct: columns_of(&p.ct, kept),
        c1: zeros(m, n),
        c2: below(columns_of(&p.c2, kept), zeros(m, n)),
        dtt: p.dtt.clone(),
        dt1: inputs(&p.dt1, &p.dt2),
        dt2: p.dt2.clone(),
        d1t: zeros(m, t),
        d11: zeros(m, 1 + m),
        d12: unit.clone(),
        d2t: below(p.d2t.clone(), zeros(m, t)),
        d21: below(inputs(&p.d21, &zeros(y, m)), beside(&zeros(m, 1), &unit)),
        d22: vec![],
    };
    let controller = Controller {
        by: beside(&k.by, &limits.e),
        duy: beside(&k.duy, &zeros(k.duy.len(), m)),
        dty: beside(&k.dty, &zeros(k.dty.len(), m)),
        ..k.clone()
    };
    Certificate { plant, controller, residual: None, bounded_rate: None, limits: None, ..c.clone() }
}

fn rows_of(m: &Rows, kept: &[usize]) -> Rows {
    kept.iter().map(|&i| m[i].clone()).collect()
}

fn columns_of(m: &Rows, kept: &[usize]) -> Rows {
    m.iter().map(|row| kept.iter().map(|&j| row[j]).collect()).collect()
}
