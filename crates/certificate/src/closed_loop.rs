//! Exact closed loop of plant and controller.

use crate::error::Failure;
use crate::exact::dyadic::Dyadic;
use crate::exact::matrix::Matrix;
use crate::exact::whole::fraction_free_inverse;
use crate::plant::{ModelError, Rows};
use crate::shape::{Sizes, columns};
use crate::system::Loop;

/// Closed loop with the states (x, xk), the channels (zt, zk), (wt, wk), and, with a model error, the output w_Delta
/// and the input z_Delta of Delta:
///
/// ```text
/// (x, xk)'  = state   (x, xk | wt, wk | w)  + e w_Delta
/// (zt, zk)  = channel (x, xk | wt, wk | w)
/// z_Delta   = error   (x, xk | wt, wk | w)
/// z         = output  (x, xk | wt, wk | w)
/// ```
///
/// with `(x, xk)+` in place of `(x, xk)'` in discrete time.
///
/// All matrices are multiplied by `scale`, `|det(I - Duy D22)|` times a power of two, so that no entry is a fraction.
pub(crate) struct ClosedLoop {
    pub(crate) discrete: bool,
    pub(crate) states: usize,
    pub(crate) channels: usize,
    pub(crate) inputs: usize,
    pub(crate) scale: Dyadic,
    pub(crate) state: Matrix,
    pub(crate) channel: Matrix,
    pub(crate) output: Matrix,
    /// `error` and `e`; several model errors are stacked in rows and columns, respectively.
    pub(crate) delta: Option<(Matrix, Matrix)>,
    /// Parameter of each channel: plant's, controller's, then one for each limit.
    pub(crate) parameters: Vec<usize>,
}

/// First columns of the parts of (x, xk | wt, wk | w).
struct Columns {
    x: usize,
    xk: usize,
    t: usize,
    tk: usize,
    w: usize,
    all: usize,
}

impl ClosedLoop {
    /// Closes the loop of a checked certificate.
    ///
    /// With `y0 = [C2 0 | D2t 0 | D21]` and `u0 = [0 Cu | 0 Dut | 0]` in terms of `(x, xk | wt, wk | w)`, `y = y0 +
    /// D22 u` and `u = u0 + Duy y`, so that `(I - Duy D22) u = u0 + Duy y0`. The closed loop follows by
    /// substitution of u and y into the plant's and the controller's rows.
    ///
    /// # Errors
    /// [`Failure::NotWellPosed`] if `I - Duy D22` is singular.
    pub(crate) fn new(system: Loop<'_>, errors: &[ModelError]) -> Result<Self, Failure> {
        let (p, k, s) = (system.plant, system.controller, system.sizes());
        let c = Columns::new(s);
        let place = |parts: &[(&Rows, usize, usize)]| {
            let mut m = Matrix::zeros(parts[0].0.len(), c.all);
            parts.iter().for_each(|&(rows, at, cols)| m.place(0, at, &Matrix::from_rows(rows, cols)));
            m
        };
        let mut y = place(&[(&p.c2, c.x, s.x), (&p.d2t, c.t, s.t), (&p.d21, c.w, s.w)]);
        let direct = Matrix::from_rows(&k.duy, s.y);
        let mut u = place(&[(&k.cu, c.xk, s.xk), (&k.dut, c.tk, s.tk)]);
        u = u.plus(&direct.times(&y));
        let mut scale = Dyadic::from_f64(1.0);
        if let Some(d22) = p.direct_path() {
            let d22 = Matrix::from_rows(d22, s.u);
            let difference = Matrix::scalar(s.u, &scale).plus(&direct.times(&d22).negated());
            let inverse;
            (inverse, scale) = fraction_free_inverse(&difference).ok_or(Failure::NotWellPosed)?;
            u = inverse.times(&u);
            y = y.scaled(&scale).plus(&d22.times(&u));
        }
        let from_u = |open: Matrix, b: &Rows| open.scaled(&scale).plus(&Matrix::from_rows(b, s.u).times(&u));
        let from_y = |open: Matrix, b: &Rows| open.scaled(&scale).plus(&Matrix::from_rows(b, s.y).times(&y));
        let x = from_u(place(&[(&p.a, c.x, s.x), (&p.bt, c.t, s.t), (&p.b1, c.w, s.w)]), &p.b2);
        let xk = from_y(place(&[(&k.a, c.xk, s.xk), (&k.bt, c.tk, s.tk)]), &k.by);
        let zt = from_u(place(&[(&p.ct, c.x, s.x), (&p.dtt, c.t, s.t), (&p.dt1, c.w, s.w)]), &p.dt2);
        let zk = from_y(place(&[(&k.ct, c.xk, s.xk), (&k.dtt, c.tk, s.tk)]), &k.dty);
        let z = from_u(place(&[(&p.c1, c.x, s.x), (&p.d1t, c.t, s.t), (&p.d11, c.w, s.w)]), &p.d12);
        let mut delta = None;
        for error in errors {
            let mut open = place(&[(&error.f, c.x, s.x)]);
            if !error.fw.is_empty() {
                open.place(0, c.w, &Matrix::from_rows(&error.fw, s.w));
            }
            let (rows, columns) = (from_u(open, &error.fu), columns(&error.e));
            let (above, before) = delta.unwrap_or((Matrix::zeros(0, c.all), Matrix::zeros(s.x + s.xk, 0)));
            let mut e = Matrix::zeros(s.x + s.xk, before.cols + columns);
            e.place(0, 0, &before);
            e.place(0, before.cols, &Matrix::from_rows(&error.e, columns).scaled(&scale));
            delta = Some((above.above(rows), e));
        }
        Ok(Self {
            discrete: system.discrete,
            states: s.x + s.xk,
            channels: s.t + s.tk,
            inputs: s.w,
            state: x.above(xk),
            channel: zt.above(zk),
            output: z,
            delta,
            parameters: parameters(system.blocks).chain(parameters(system.controller_blocks)).collect(),
            scale,
        })
    }
}

impl Columns {
    fn new(s: Sizes) -> Self {
        let (xk, t) = (s.x, s.x + s.xk);
        let (tk, w) = (t + s.t, t + s.t + s.tk);
        Self { x: 0, xk, t, tk, w, all: w + s.w }
    }
}

/// Returns the parameter of each channel of `blkdiag(theta_i I_ri)`.
fn parameters(blocks: &[usize]) -> impl Iterator<Item = usize> {
    blocks.iter().enumerate().flat_map(|(i, &r)| std::iter::repeat_n(i, r))
}
