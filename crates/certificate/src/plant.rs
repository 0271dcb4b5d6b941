//! Plant, controller and model error, as in the file.

use serde::{Deserialize, Serialize};

/// Matrix as a list of rows; a matrix with rows but no columns is a list of empty rows.
pub type Rows = Vec<Vec<f64>>;

/// Generalised plant.
///
/// ```text
/// x' = A x + Bt wt + B1 w + B2 u
/// zt = Ct x + Dtt wt + Dt1 w + Dt2 u      wt = Theta zt,  Theta = blkdiag(theta_i I_ri)
/// z  = C1 x + D1t wt + D11 w + D12 u
/// y  = C2 x + D2t wt + D21 w + D22 u
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "PascalCase", deny_unknown_fields)]
#[allow(missing_docs)] // The names are the equations above.
pub struct Plant {
    pub a: Rows,
    pub bt: Rows,
    pub b1: Rows,
    pub b2: Rows,
    pub ct: Rows,
    pub c1: Rows,
    pub c2: Rows,
    pub dtt: Rows,
    pub dt1: Rows,
    pub dt2: Rows,
    pub d1t: Rows,
    pub d11: Rows,
    pub d12: Rows,
    pub d2t: Rows,
    pub d21: Rows,
    /// Direct path from u to y; an empty list, or no such key in the file, means 0.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub d22: Rows,
}

/// LPV controller.
///
/// ```text
/// xk' = A xk + By y + Bt wk
/// u   = Cu xk + Duy y + Dut wk
/// zk  = Ct xk + Dty y + Dtt wk            wk = Theta zk
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "PascalCase", deny_unknown_fields)]
#[allow(missing_docs)] // The names are the equations above.
pub struct Controller {
    pub a: Rows,
    pub by: Rows,
    pub bt: Rows,
    pub cu: Rows,
    pub duy: Rows,
    pub dut: Rows,
    pub ct: Rows,
    pub dty: Rows,
    pub dtt: Rows,
}

macro_rules! named {
    ($of:ty, $count:literal: $($field:ident $key:literal),*) => {
        impl $of {
            /// Returns the matrices that every file contains, row by row of the equations, with their keys.
            pub fn named(&self) -> [(&'static str, &Rows); $count] {
                [$(($key, &self.$field)),*]
            }

            /// Returns the same matrices, mutable.
            pub fn named_mut(&mut self) -> [(&'static str, &mut Rows); $count] {
                [$(($key, &mut self.$field)),*]
            }
        }
    };
}

named!(Plant, 15: a "A", bt "Bt", b1 "B1", b2 "B2", ct "Ct", dtt "Dtt", dt1 "Dt1", dt2 "Dt2",
    c1 "C1", d1t "D1t", d11 "D11", d12 "D12", c2 "C2", d2t "D2t", d21 "D21");
named!(Controller, 9: a "A", by "By", bt "Bt", cu "Cu", duy "Duy", dut "Dut", ct "Ct", dty "Dty", dtt "Dtt");

/// Model error: `[A B1 B2]` of the plant becomes `[A B1 B2] + E Delta(t) [F Fw Fu]`, for every measurable Delta(t) with
/// a largest singular value of at most 1.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "PascalCase", deny_unknown_fields)]
pub struct ModelError {
    /// Input matrix of Delta, n x ne.
    pub e: Rows,
    /// Output matrix of Delta for x, nf x n.
    pub f: Rows,
    /// Output matrix of Delta for w, nf x w; an empty list, or no such key in the file, means 0.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub fw: Rows,
    /// Output matrix of Delta for u, nf x u.
    pub fu: Rows,
}

impl Plant {
    /// Returns D22; `None` if it is 0.
    pub fn direct_path(&self) -> Option<&Rows> {
        Some(&self.d22).filter(|rows| rows.iter().flatten().any(|entry| *entry != 0.0))
    }
}
