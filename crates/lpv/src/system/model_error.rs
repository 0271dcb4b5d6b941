//! Model error: a norm-bounded difference between the plant and the system that it models.
//!
//! The plant's `[A B1 B2]` is replaced by `[A B1 B2] + E Delta(t) [F Fw Fu]` with any measurable Delta(t) whose largest
//! singular value is at most 1: S. Boyd, L. El Ghaoui, E. Feron, V. Balakrishnan, Linear Matrix Inequalities in
//! System and Control Theory, 1994, section 4.3.

use crate::matrix::{Mat, block};
use crate::system::{ClosedLoop, Controller, GeneralisedPlant};

/// `E Delta [F Fw Fu]` in a plant's coordinates.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelError {
    /// Input matrix E, n x ne.
    pub e: Mat,
    /// Output matrix F of the states, nf x n.
    pub f: Mat,
    /// Output matrix Fw of the exogenous inputs, nf x w.
    pub fw: Mat,
    /// Output matrix Fu of the controls, nf x u.
    pub fu: Mat,
}

/// The model error in a closed loop: `w_D = Delta z_D`, `z_D = Fx x + Ft wt + Fw w`, and `E w_D` enters x'.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs)] // The names are the equations above.
pub struct LoopError {
    pub e: Mat,
    pub fx: Mat,
    pub ft: Mat,
    pub fw: Mat,
}

impl ModelError {
    /// Returns the error in the loop that a controller closes.
    ///
    /// ```text
    /// Fx = [F + Fu Duy C2, Fu Cu],   Ft = [Fu Duy D2t, Fu Dut],   Fw = Fw + Fu Duy D21
    /// ```
    pub fn close(&self, plant: &GeneralisedPlant, k: &Controller) -> LoopError {
        let s = plant.sizes();
        let nk = k.a().nrows();
        let columns = (self.f.ncols(), self.fw.ncols(), self.fu.ncols());
        debug_assert_eq!((self.e.nrows(), columns), (s.x, (s.x, s.w, s.u)));
        LoopError {
            e: block(&[&[&self.e], &[&Mat::zeros(nk, self.e.ncols())]]),
            fx: block(&[&[&(&self.f + &self.fu * &k.duy() * &plant.c2()), &(&self.fu * &k.cu())]]),
            ft: block(&[&[&(&self.fu * &k.duy() * &plant.d2t()), &(&self.fu * &k.dut())]]),
            fw: &self.fw + &self.fu * &k.duy() * &plant.d21(),
        }
    }
}

impl LoopError {
    /// Returns the absence of model error: no rows, no columns.
    pub fn none(closed: &ClosedLoop) -> Self {
        let (n, r, w) = (closed.a().nrows(), closed.channels.len(), closed.b1().ncols());
        Self { e: Mat::zeros(n, 0), fx: Mat::zeros(0, n), ft: Mat::zeros(0, r), fw: Mat::zeros(0, w) }
    }

    /// Returns `true` if there is no model error.
    pub fn is_none(&self) -> bool {
        self.e.ncols() == 0
    }

    /// Returns the error with w and z in units in which a gain of `gamma` is 1.
    pub(crate) fn in_units_of(&self, gamma: f64) -> Self {
        Self { fw: &self.fw / gamma.sqrt(), ..self.clone() }
    }

    /// Returns the error in the coordinates `x = T x~`, `zt = tau zt~`, `wt = tau wt~`.
    pub fn in_coordinates(&self, (t, t_inverse): (&Mat, &Mat), tau: &Mat) -> Self {
        Self { e: t_inverse * &self.e, fx: &self.fx * t, ft: &self.ft * tau, fw: self.fw.clone() }
    }
}
