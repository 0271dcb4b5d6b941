//! The generalised plant with its parameter channels, and what a parameter value or a controller makes of it.

use crate::controller::Controller;
use crate::error::{LftError, ShapeError};
use crate::matrix::{Mat, block, solve};
use crate::state_space::StateSpace;
use nalgebra::DVector;

/// The parameter of each channel of `Theta = blkdiag(theta_i I_ri)` for repetitions `[r_1, r_2, ...]`.
pub fn channels(blocks: &[usize]) -> Vec<usize> {
    blocks.iter().enumerate().flat_map(|(i, &r)| std::iter::repeat_n(i, r)).collect()
}

/// `Theta (I - Dtt Theta)^-1`, what closing the parameter channels puts between zt and wt.
///
/// # Errors
/// [`LftError::NotWellPosed`] when `I - Dtt Theta` is singular.
pub fn closing(channels: &[usize], dtt: &Mat, theta: &[f64]) -> Result<Mat, LftError> {
    let delta =
        Mat::from_diagonal(&DVector::from_iterator(channels.len(), channels.iter().map(|&c| theta[c])));
    let r = channels.len();
    solve(&(Mat::identity(r, r) - &delta * dtt), &delta)
        .ok_or_else(|| LftError::NotWellPosed { theta: theta.to_vec() })
}

/// The generalised plant.
///
/// ```text
/// x' = A x + Bt wt + B1 w + B2 u
/// zt = Ct x + Dtt wt + Dt1 w + Dt2 u      wt = Theta zt,  Theta = blkdiag(theta_i I_ri),  |theta_i| <= 1
/// z  = C1 x + D1t wt + D11 w + D12 u
/// y  = C2 x + D2t wt + D21 w
/// ```
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs)] // The names are the equations above.
pub struct GeneralisedPlant {
    pub a: Mat,
    pub bt: Mat,
    pub b1: Mat,
    pub b2: Mat,
    pub ct: Mat,
    pub dtt: Mat,
    pub dt1: Mat,
    pub dt2: Mat,
    pub c1: Mat,
    pub d1t: Mat,
    pub d11: Mat,
    pub d12: Mat,
    pub c2: Mat,
    pub d2t: Mat,
    pub d21: Mat,
    /// The repetitions `[r_1, r_2, ...]` of the parameters.
    pub blocks: Vec<usize>,
}

/// The sizes of the partition.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sizes {
    /// States.
    pub x: usize,
    /// Parameter channels.
    pub t: usize,
    /// Exogenous inputs w.
    pub w: usize,
    /// Control inputs u.
    pub u: usize,
    /// Controlled outputs z.
    pub z: usize,
    /// Measurements y.
    pub y: usize,
}

impl GeneralisedPlant {
    /// The sizes that the plant's matrices have.
    pub fn sizes(&self) -> Sizes {
        Sizes {
            x: self.a.nrows(),
            t: self.bt.ncols(),
            w: self.b1.ncols(),
            u: self.b2.ncols(),
            z: self.c1.nrows(),
            y: self.c2.nrows(),
        }
    }

    /// Checks that all matrices and the blocks fit together.
    ///
    /// # Errors
    /// The first matrix that does not, with the shape found and the one demanded.
    pub fn check(&self) -> Result<(), ShapeError> {
        let s = self.sizes();
        let wanted: [(&'static str, &Mat, usize, usize); 15] = [
            ("A", &self.a, s.x, s.x),
            ("Bt", &self.bt, s.x, s.t),
            ("B1", &self.b1, s.x, s.w),
            ("B2", &self.b2, s.x, s.u),
            ("Ct", &self.ct, s.t, s.x),
            ("Dtt", &self.dtt, s.t, s.t),
            ("Dt1", &self.dt1, s.t, s.w),
            ("Dt2", &self.dt2, s.t, s.u),
            ("C1", &self.c1, s.z, s.x),
            ("D1t", &self.d1t, s.z, s.t),
            ("D11", &self.d11, s.z, s.w),
            ("D12", &self.d12, s.z, s.u),
            ("C2", &self.c2, s.y, s.x),
            ("D2t", &self.d2t, s.y, s.t),
            ("D21", &self.d21, s.y, s.w),
        ];
        for (name, matrix, rows, cols) in wanted {
            if matrix.shape() != (rows, cols) {
                return Err(ShapeError { name, found: matrix.shape(), expected: (rows, cols) });
            }
        }
        let total: usize = self.blocks.iter().sum();
        if total != s.t {
            return Err(ShapeError {
                name: "Theta (the sum of the blocks)",
                found: (total, total),
                expected: (s.t, s.t),
            });
        }
        Ok(())
    }

    /// The plant at a frozen parameter value: the same partition with no parameter channel.
    ///
    /// # Errors
    /// [`LftError::NotWellPosed`] when `I - Dtt Theta` is singular.
    pub fn frozen(&self, theta: &[f64]) -> Result<GeneralisedPlant, LftError> {
        let s = self.sizes();
        let closing = closing(&channels(&self.blocks), &self.dtt, theta)?;
        // X + X_t Theta (I - Dtt Theta)^-1 Y_t for each pair of a row and a column of the partition.
        let close = |m: &Mat, left: &Mat, right: &Mat| m + left * &closing * right;
        Ok(Self {
            a: close(&self.a, &self.bt, &self.ct),
            b1: close(&self.b1, &self.bt, &self.dt1),
            b2: close(&self.b2, &self.bt, &self.dt2),
            c1: close(&self.c1, &self.d1t, &self.ct),
            d11: close(&self.d11, &self.d1t, &self.dt1),
            d12: close(&self.d12, &self.d1t, &self.dt2),
            c2: close(&self.c2, &self.d2t, &self.ct),
            d21: close(&self.d21, &self.d2t, &self.dt1),
            bt: Mat::zeros(s.x, 0),
            ct: Mat::zeros(0, s.x),
            dtt: Mat::zeros(0, 0),
            dt1: Mat::zeros(0, s.w),
            dt2: Mat::zeros(0, s.u),
            d1t: Mat::zeros(s.z, 0),
            d2t: Mat::zeros(s.y, 0),
            blocks: vec![],
        })
    }

    /// The transposed plant, of which the dual inequality is the primal one.
    pub fn dual(&self) -> GeneralisedPlant {
        let t = Mat::transpose;
        Self {
            a: t(&self.a),
            bt: t(&self.ct),
            b1: t(&self.c1),
            b2: t(&self.c2),
            ct: t(&self.bt),
            dtt: t(&self.dtt),
            dt1: t(&self.d1t),
            dt2: t(&self.d2t),
            c1: t(&self.b1),
            d1t: t(&self.dt1),
            d11: t(&self.d11),
            d12: t(&self.d21),
            c2: t(&self.b2),
            d2t: t(&self.dt2),
            d21: t(&self.d12),
            blocks: self.blocks.clone(),
        }
    }

    /// The plant with w and z in units in which a gain of `gamma` is 1. The inequalities have the same X, Y and scalings.
    pub(crate) fn in_units_of(&self, gamma: f64) -> GeneralisedPlant {
        let root = gamma.sqrt();
        Self {
            b1: &self.b1 / root,
            dt1: &self.dt1 / root,
            d21: &self.d21 / root,
            c1: &self.c1 / root,
            d1t: &self.d1t / root,
            d12: &self.d12 / root,
            d11: &self.d11 / gamma,
            ..self.clone()
        }
    }

    /// The plant without its control, as a loop: what is left when u = 0.
    pub fn open(&self) -> ClosedLoop {
        ClosedLoop {
            a: self.a.clone(),
            bt: self.bt.clone(),
            b1: self.b1.clone(),
            ct: self.ct.clone(),
            dtt: self.dtt.clone(),
            dt1: self.dt1.clone(),
            c1: self.c1.clone(),
            d1t: self.d1t.clone(),
            d11: self.d11.clone(),
            channels: channels(&self.blocks),
        }
    }

    /// The closed loop with a controller, its channels ordered plant's, then controller's.
    ///
    /// The direct path from u to y is zero, so the loop is always well posed at Theta = 0.
    pub fn close(&self, k: &Controller) -> ClosedLoop {
        let s = self.sizes();
        let (nk, rk) = (k.a.nrows(), k.bt.ncols());
        let rows = |top: &Mat, zero: usize, cols: usize| block(&[&[top], &[&Mat::zeros(zero, cols)]]);
        // u = [Duy C2, Cu | Duy D2t, Dut | Duy D21] (x, xk | wt, wk | w), y likewise.
        let y_x = block(&[&[&self.c2, &Mat::zeros(s.y, nk)]]);
        let y_t = block(&[&[&self.d2t, &Mat::zeros(s.y, rk)]]);
        let u_x = block(&[&[&(&k.duy * &self.c2), &k.cu]]);
        let u_t = block(&[&[&(&k.duy * &self.d2t), &k.dut]]);
        let u_w = &k.duy * &self.d21;
        let xk = |m: &Mat| block(&[&[&Mat::zeros(m.nrows(), s.x), m]]);
        let tk = |m: &Mat| block(&[&[&Mat::zeros(m.nrows(), s.t), m]]);
        let wide_x = |m: &Mat| block(&[&[m, &Mat::zeros(m.nrows(), nk)]]);
        let wide_t = |m: &Mat| block(&[&[m, &Mat::zeros(m.nrows(), rk)]]);
        let stack = |top: Mat, bottom: Mat| block(&[&[&top], &[&bottom]]);
        ClosedLoop {
            a: stack(wide_x(&self.a) + &self.b2 * &u_x, &k.by * &y_x + xk(&k.a)),
            bt: stack(wide_t(&self.bt) + &self.b2 * &u_t, &k.by * &y_t + tk(&k.bt)),
            b1: rows(&self.b1, nk, s.w) + stack(&self.b2 * &u_w, &k.by * &self.d21),
            ct: stack(wide_x(&self.ct) + &self.dt2 * &u_x, &k.dty * &y_x + xk(&k.ct)),
            dtt: stack(wide_t(&self.dtt) + &self.dt2 * &u_t, &k.dty * &y_t + tk(&k.dtt)),
            dt1: rows(&self.dt1, rk, s.w) + stack(&self.dt2 * &u_w, &k.dty * &self.d21),
            c1: wide_x(&self.c1) + &self.d12 * &u_x,
            d1t: wide_t(&self.d1t) + &self.d12 * &u_t,
            d11: &self.d11 + &self.d12 * &u_w,
            channels: channels(&self.blocks).into_iter().chain(channels(&k.blocks)).collect(),
        }
    }
}

/// A closed loop `x' = A x + Bt wt + B1 w, zt = Ct x + Dtt wt + Dt1 w, z = C1 x + D1t wt + D11 w, wt = Theta zt`.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs)] // The names are the equations above.
pub struct ClosedLoop {
    pub a: Mat,
    pub bt: Mat,
    pub b1: Mat,
    pub ct: Mat,
    pub dtt: Mat,
    pub dt1: Mat,
    pub c1: Mat,
    pub d1t: Mat,
    pub d11: Mat,
    /// The parameter of each channel.
    pub channels: Vec<usize>,
}

impl ClosedLoop {
    /// The loop in the coordinates `x = T x~`, `zt = tau zt~`, `wt = tau wt~`, each given with its inverse.
    pub fn in_coordinates(&self, (t, t_inverse): (&Mat, &Mat), (tau, tau_inverse): (&Mat, &Mat)) -> Self {
        Self {
            a: t_inverse * &self.a * t,
            bt: t_inverse * &self.bt * tau,
            b1: t_inverse * &self.b1,
            ct: tau_inverse * &self.ct * t,
            dtt: tau_inverse * &self.dtt * tau,
            dt1: tau_inverse * &self.dt1,
            c1: &self.c1 * t,
            d1t: &self.d1t * tau,
            d11: self.d11.clone(),
            channels: self.channels.clone(),
        }
    }

    /// The loop with w and z in units in which a gain of `gamma` is 1. The inequalities have the same X and scalings.
    pub(crate) fn in_units_of(&self, gamma: f64) -> Self {
        let root = gamma.sqrt();
        Self {
            b1: &self.b1 / root,
            dt1: &self.dt1 / root,
            c1: &self.c1 / root,
            d1t: &self.d1t / root,
            d11: &self.d11 / gamma,
            ..self.clone()
        }
    }

    /// The loop at a frozen parameter value.
    ///
    /// # Errors
    /// [`LftError::NotWellPosed`] when `I - Dtt Theta` is singular.
    pub fn frozen(&self, theta: &[f64]) -> Result<StateSpace, LftError> {
        let closing = closing(&self.channels, &self.dtt, theta)?;
        Ok(StateSpace {
            a: &self.a + &self.bt * &closing * &self.ct,
            b: &self.b1 + &self.bt * &closing * &self.dt1,
            c: &self.c1 + &self.d1t * &closing * &self.ct,
            d: &self.d11 + &self.d1t * &closing * &self.dt1,
        })
    }
}
