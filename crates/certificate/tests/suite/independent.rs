//! Independent check of the claims of a certificate in floating point: the loop frozen at many Theta and Delta, closed
//! after the parameters and not before; and the eigenvalues of the documented inequality, block by block.

use nalgebra::{Complex, DMatrix, Schur};
use squid_certificate::{Certificate, Gain, Rows};

type Mat = DMatrix<f64>;

/// Claim to be checked: X, S, T, gamma, and the model error if there is one.
pub struct ClaimData<'a> {
    pub gamma: f64,
    pub x: &'a Rows,
    pub s: &'a Rows,
    pub t: &'a Rows,
    pub delta: Option<(f64, [&'a Rows; 4])>,
}

pub fn claims(c: &Certificate) -> Vec<ClaimData<'_>> {
    let data = |gain: &'_ Gain| {
        gain.lambda.map(|lambda| (lambda, [&c.errors[0].e, &c.errors[0].f, &c.errors[0].fw, &c.errors[0].fu]))
    };
    [c.gain(), c.robust_gain()]
        .into_iter()
        .flatten()
        .map(|gain| ClaimData {
            gamma: gain.gamma,
            x: gain.x.as_ref().unwrap(),
            s: &gain.s,
            t: &gain.t,
            delta: data(gain),
        })
        .collect()
}

fn mat(rows: &Rows, cols: usize) -> Mat {
    Mat::from_fn(rows.len(), cols, |i, j| rows[i][j])
}

/// Returns a matrix that a file may omit.
fn mat_or_zero(rows: &Rows, count: usize, cols: usize) -> Mat {
    if rows.is_empty() { Mat::zeros(count, cols) } else { mat(rows, cols) }
}

fn blocks(rows: &[&[Mat]]) -> Mat {
    let height: usize = rows.iter().map(|r| r[0].nrows()).sum();
    let width: usize = rows[0].iter().map(DMatrix::ncols).sum();
    let mut all = Mat::zeros(height, width);
    let mut i = 0;
    for row in rows {
        let mut j = 0;
        for part in *row {
            all.view_mut((i, j), part.shape()).copy_from(part);
            j += part.ncols();
        }
        i += row[0].nrows();
    }
    all
}

/// Matrices of plant and controller `[A Bt B1 B2; Ct Dtt Dt1 Dt2; C1 D1t D11 D12; C2 D2t D21 D22]` and
/// `[A Bt By; Ct Dtt Dty; Cu Dut Duy]`, with their sizes.
pub struct Loop {
    plant: Mat,
    controller: Mat,
    n: [usize; 8],
    parameters: [Vec<usize>; 2],
}

impl Loop {
    pub fn new(c: &Certificate) -> Self {
        let (p, k) = (&c.plant, &c.controller);
        let (n, r, w, u) = (p.a.len(), p.ct.len(), p.d11[0].len(), p.d12[0].len());
        let (z, y, nk, rk) = (p.d11.len(), p.c2.len(), k.a.len(), k.ct.len());
        let d22 = if p.d22.is_empty() { Mat::zeros(y, u) } else { mat(&p.d22, u) };
        let plant = blocks(&[
            &[mat(&p.a, n), mat(&p.bt, r), mat(&p.b1, w), mat(&p.b2, u)],
            &[mat(&p.ct, n), mat(&p.dtt, r), mat(&p.dt1, w), mat(&p.dt2, u)],
            &[mat(&p.c1, n), mat(&p.d1t, r), mat(&p.d11, w), mat(&p.d12, u)],
            &[mat(&p.c2, n), mat(&p.d2t, r), mat(&p.d21, w), d22],
        ]);
        let controller = blocks(&[
            &[mat(&k.a, nk), mat(&k.bt, rk), mat(&k.by, y)],
            &[mat(&k.ct, nk), mat(&k.dtt, rk), mat(&k.dty, y)],
            &[mat(&k.cu, nk), mat(&k.dut, rk), mat(&k.duy, y)],
        ]);
        let each = |b: &[usize]| b.iter().enumerate().flat_map(|(i, &r)| vec![i; r]).collect();
        Self {
            plant,
            controller,
            n: [n, r, w, u, z, y, nk, rk],
            parameters: [each(&c.blocks), each(&c.controller_blocks)],
        }
    }

    /// Returns `[A B; C D]` of the loop frozen at Theta, with `error` added to the plant's rows x: the parameter loops
    /// of plant and controller are closed first, then the loop of both.
    pub fn frozen(&self, theta: &[f64], error: Option<&Mat>) -> Option<(usize, Mat)> {
        let [n, r, w, u, z, y, nk, rk] = self.n;
        let mut plant = self.plant.clone();
        if let Some(error) = error {
            for (at, from, count) in [(0, 0, n), (n + r, n, w + u)] {
                let mut part = plant.view_mut((0, at), (n, count));
                part += error.columns(from, count);
            }
        }
        let p = close_channels(&plant, n, r, &self.parameters[0], theta)?;
        let k = close_channels(&self.controller, nk, rk, &self.parameters[1], theta)?;
        let part = |m: &Mat, i, j, a, b| m.view((i, j), (a, b)).into_owned();
        let (bu, cy) = (part(&p, 0, n + w, n + z, u), part(&p, n + z, 0, y, n + w));
        let (ak, bk) = (part(&k, 0, 0, nk, nk), part(&k, 0, nk, nk, y));
        let direct = part(&p, n + z, n + w, y, u);
        let (ck, dk) = (part(&k, nk, 0, u, nk), part(&k, nk, nk, u, y));
        let solve = (Mat::identity(u, u) - &dk * &direct).lu();
        let (ck, dk) = (solve.solve(&ck)?, solve.solve(&dk)?);
        let open = part(&p, 0, 0, n + z, n + w) + &bu * &dk * &cy;
        let (bu_ck, bk_cy) = (&bu * &ck, &bk * (&cy + &direct * &dk * &cy));
        let ak = ak + &bk * &direct * &ck;
        Some((
            n + nk,
            blocks(&[
                &[part(&open, 0, 0, n, n), bu_ck.rows(0, n).into_owned(), part(&open, 0, n, n, w)],
                &[bk_cy.columns(0, n).into_owned(), ak, bk_cy.columns(n, w).into_owned()],
                &[part(&open, n, 0, z, n), bu_ck.rows(n, z).into_owned(), part(&open, n, n, z, w)],
            ]),
        ))
    }

    /// Returns a frozen loop that contradicts the claim, if any.
    pub fn contradiction(&self, data: &ClaimData<'_>) -> Option<String> {
        let count = self.parameters.iter().flatten().max().map_or(0, |m| m + 1);
        let steps: usize = if count > 1 { 5 } else { 9 };
        for index in 0..steps.pow(count as u32) {
            let at =
                |p: usize| -1.0 + 2.0 * ((index / steps.pow(p as u32)) % steps) as f64 / (steps - 1) as f64;
            let theta: Vec<f64> = (0..count).map(at).collect();
            for error in self.errors(data) {
                let Some((n, m)) = self.frozen(&theta, error.as_ref()) else {
                    return Some(format!("not well posed at {theta:?}"));
                };
                if let Some(wrong) = frozen_contradiction(&m, n, data.gamma) {
                    return Some(format!("{wrong} at {theta:?}"));
                }
            }
        }
        None
    }

    /// Returns `E Delta [F Fw Fu]` for some Delta of norm 1 and rank one, and none.
    fn errors(&self, data: &ClaimData<'_>) -> Vec<Option<Mat>> {
        let Some((_, [e, f, fw, fu])) = data.delta else { return vec![None] };
        let [n, _, w, u, ..] = self.n;
        let e = mat(e, e.first().map_or(0, Vec::len));
        let f = blocks(&[&[mat(f, n), mat_or_zero(fw, f.len(), w), mat(fu, u)]]);
        let pairs = (0..e.ncols().max(f.nrows())).map(|k| (k % e.ncols(), (k * 2 + 1) % f.nrows()));
        let one = |(i, j)| [1.0, -1.0].map(|sign| Some(e.column(i) * f.row(j) * sign));
        std::iter::once(None).chain(pairs.flat_map(one)).collect()
    }

    /// Returns the rows x', zt, z and u of the closed loop, each with the columns x, wt, w.
    fn closed(&self) -> [[Mat; 3]; 4] {
        let [n, r, w, u, z, y, nk, rk] = self.n;
        // The plant has rows x', zt, z, y and columns x, wt, w, u, next to those of the controller; u = K y is
        // substituted last.
        let p = &self.plant;
        let part = |m: &Mat, i, j, a, b| m.view((i, j), (a, b)).into_owned();
        let k = &self.controller;
        let zero = Mat::zeros;
        let at = [0, n, n + r, n + r + w];
        let row = [(0, n), (n, r), (n + r, z), (0, 0)];
        let cy = [
            blocks(&[&[part(p, n + r + z, 0, y, n), zero(y, nk)]]),
            blocks(&[&[part(p, n + r + z, at[1], y, r), zero(y, rk)]]),
            part(p, n + r + z, at[2], y, w),
        ];
        let (k_y, k_u) = (part(k, 0, nk + rk, nk + rk + u, y), nk + rk);
        let k_x = [
            blocks(&[&[zero(nk + rk + u, n), part(k, 0, 0, nk + rk + u, nk)]]),
            blocks(&[&[zero(nk + rk + u, r), part(k, 0, nk, nk + rk + u, rk)]]),
            zero(nk + rk + u, w),
        ];
        let widths = [(n, nk), (r, rk), (w, 0)];
        // u = Duy (y0 + D22 u) + ...
        let direct = part(p, n + r + z, at[3], y, u);
        let before = (Mat::identity(u, u) - k_y.rows(k_u, u) * &direct).try_inverse().unwrap();
        let closed = |kind: usize, col: usize| {
            let driven = &k_y * &cy[col] + &k_x[col];
            let u_row = &before * driven.rows(k_u, u);
            let driven = driven + &k_y * &direct * &u_row;
            let (i, height) = row[kind];
            let own = part(p, i, at[col], height, widths[col].0);
            let own = blocks(&[&[own, zero(height, widths[col].1)]]);
            let top = own + part(p, i, at[3], height, u) * &u_row;
            match kind {
                0 => blocks(&[&[top], &[driven.rows(0, nk).into_owned()]]),
                1 => blocks(&[&[top], &[driven.rows(nk, rk).into_owned()]]),
                2 => top,
                _ => u_row,
            }
        };
        [0, 1, 2, 3].map(|kind| [0, 1, 2].map(|col| closed(kind, col)))
    }

    /// Returns the largest eigenvalue of the documented inequality, scaled to a unit diagonal; infinity if a diagonal
    /// entry has the wrong sign.
    pub fn inequality(&self, data: &ClaimData<'_>) -> f64 {
        let [n, r, w, u, z, _, nk, rk] = self.n;
        let zero = Mat::zeros;
        let (x, s, t) = (mat(data.x, n + nk), mat(data.s, r + rk), mat(data.t, r + rk));
        let [[a, bt, b1], [ct, dtt, dt1], [c1, d1t, d11], [ux, ut, uw]] = self.closed();
        let (lambda, e, f, fw, fu) = match data.delta {
            None => (1.0, zero(n + nk, 0), zero(0, n), zero(0, w), zero(0, u)),
            Some((lambda, [e, f, fw, fu])) => {
                let (e, nf) = (mat(e, e[0].len()), f.len());
                (lambda, e.insert_rows(n, nk, 0.0), mat(f, n), mat_or_zero(fw, nf, w), mat(fu, u))
            }
        };
        let (ne, nf) = (e.ncols(), f.nrows());
        let [fx, ft, fw] = [blocks(&[&[f, zero(nf, nk)]]) + &fu * ux, &fu * ut, fw + &fu * uw];
        let eye = |m: usize, v: f64| Mat::identity(m, m) * v;
        let g = -data.gamma;
        let rt = r + rk;
        let upper = blocks(&[
            &[
                a.transpose() * &x + &x * &a,
                &x * &bt + ct.transpose() * t.transpose(),
                &x * &e,
                &x * &b1,
                ct.transpose() * &s,
                fx.transpose() * lambda,
                c1.transpose(),
            ],
            &[
                zero(rt, n + nk),
                -&s + &t * &dtt + dtt.transpose() * t.transpose(),
                zero(rt, ne),
                &t * &dt1,
                dtt.transpose() * &s,
                ft.transpose() * lambda,
                d1t.transpose(),
            ],
            &[
                zero(ne, n + nk),
                zero(ne, rt),
                eye(ne, -lambda),
                zero(ne, w),
                zero(ne, rt),
                zero(ne, nf),
                zero(ne, z),
            ],
            &[
                zero(w, n + nk),
                zero(w, rt),
                zero(w, ne),
                eye(w, g),
                dt1.transpose() * &s,
                fw.transpose() * lambda,
                d11.transpose(),
            ],
            &[zero(rt, n + nk), zero(rt, rt), zero(rt, ne), zero(rt, w), -&s, zero(rt, nf), zero(rt, z)],
            &[
                zero(nf, n + nk),
                zero(nf, rt),
                zero(nf, ne),
                zero(nf, w),
                zero(nf, rt),
                eye(nf, -lambda),
                zero(nf, z),
            ],
            &[zero(z, n + nk), zero(z, rt), zero(z, ne), zero(z, w), zero(z, rt), zero(z, nf), eye(z, g)],
        ]);
        [upper, -x, -s].iter().map(scaled_largest_eigenvalue).fold(f64::NEG_INFINITY, f64::max)
    }
}

/// Closes `wt = Theta zt` in rows x, zt, others and columns x, wt, others.
fn close_channels(m: &Mat, n: usize, r: usize, parameters: &[usize], theta: &[f64]) -> Option<Mat> {
    let delta = Mat::from_fn(r, r, |i, j| if i == j { theta[parameters[i]] } else { 0.0 });
    let inner = m.view((n, n), (r, r));
    let feedback = (Mat::identity(r, r) - &delta * inner).lu().solve(&delta)?;
    let (left, right) = (m.columns(n, r) * feedback, m.rows(n, r));
    Some((m + left * right).remove_rows(n, r).remove_columns(n, r))
}

fn frozen_contradiction(m: &Mat, n: usize, gamma: f64) -> Option<String> {
    let (a, b) = (m.view((0, 0), (n, n)).into_owned(), m.view((0, n), (n, m.ncols() - n)).into_owned());
    let (c, d) =
        (m.rows(n, m.nrows() - n).columns(0, n).into_owned(), m.view((n, n), (m.nrows() - n, m.ncols() - n)));
    if n > 0 {
        let Some(schur) = Schur::try_new(a.clone(), 1e-14, 10_000) else {
            return Some("no eigenvalues".into());
        };
        let slowest = schur.complex_eigenvalues().iter().map(|e| e.re).fold(f64::NEG_INFINITY, f64::max);
        if slowest >= 0.0 {
            return Some(format!("a mode with real part {slowest:e}"));
        }
    }
    let complex = |m: &Mat| m.map(|v| Complex::new(v, 0.0));
    let (ca, cb, cc, cd) = (complex(&a), complex(&b), complex(&c), complex(&d.into_owned()));
    let frequencies = std::iter::once(0.0).chain((-12..=20).map(|k| 10f64.powf(f64::from(k) / 4.0)));
    for omega in frequencies {
        let mut resolvent = -ca.clone();
        (0..n).for_each(|i| resolvent[(i, i)] += Complex::new(0.0, omega));
        let response = match resolvent.lu().solve(&cb) {
            Some(x) => &cc * x + &cd,
            None => return Some(format!("a pole at {omega} rad/s")),
        };
        let gain = response.singular_values().max();
        if gain >= gamma {
            return Some(format!("a gain of {gain} at {omega} rad/s against {gamma}"));
        }
    }
    None
}

fn scaled_largest_eigenvalue(upper: &Mat) -> f64 {
    let n = upper.nrows();
    if n == 0 {
        return f64::NEG_INFINITY;
    }
    let m = Mat::from_fn(n, n, |i, j| if i <= j { upper[(i, j)] } else { upper[(j, i)] });
    if m.iter().any(|v| !v.is_finite()) || m.diagonal().iter().any(|&d| d >= 0.0) {
        return f64::INFINITY;
    }
    let scale: Vec<f64> = m.diagonal().iter().map(|d| 1.0 / (-d).sqrt()).collect();
    Mat::from_fn(n, n, |i, j| m[(i, j)] * scale[i] * scale[j]).symmetric_eigenvalues().max()
}
