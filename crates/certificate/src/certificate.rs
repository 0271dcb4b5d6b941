//! The certificate as in its file.

use crate::error::ReadError;
use serde::Serialize;

/// Value of the key `format`.
pub const FORMAT: &str = "lpv-certificate/1";

/// A matrix as a list of rows; one with rows but no columns is a list of empty rows.
pub type Rows = Vec<Vec<f64>>;

/// Claims about the gain from w to z of a plant and a controller, with the matrices that prove them: `any_rate` or
/// `bounded_rate`, or both, and what is built on the first.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Certificate {
    /// Whether plant and controller are in discrete time: `x+`, the state at the next tick, in place of `x'`. Without
    /// the key the loop is in continuous time.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub discrete: bool,
    /// Repetitions `[r_1, r_2, ...]` of the parameters in the plant's channels; 0 for a parameter that occurs in the
    /// controller alone.
    pub blocks: Vec<usize>,
    /// The repetitions in the controller's channels, of the same parameters in the same order.
    pub controller_blocks: Vec<usize>,
    /// The plant.
    pub plant: Plant,
    /// The controller.
    pub controller: Controller,
    /// The claim for parameters that move however fast: the keys `gamma`, `X`, `S` and `T` of the file, or none of
    /// them.
    #[serde(flatten)]
    pub any_rate: Option<AnyRate>,
    /// A second claim, with model error.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub residual: Option<Residual>,
    /// A bound for a parameter that moves at a bounded rate.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bounded_rate: Option<BoundedRate>,
    /// What holds with commands that are cut off at limits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limits: Option<Limits>,
    /// Bounds of the gain with commands that are cut off at limits, for w of bounded energy.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub energy: Option<Energy>,
}

/// The claim `gain from w to z < gamma` for parameters that move however fast, with the matrices that prove it.
///
/// With n states, r parameter channels, signals w, z, y, u of the plant, and nk states and rk channels of the
/// controller, X is (n + nk) x (n + nk), S and T are (r + rk) x (r + rk); the plant's part is first.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct AnyRate {
    /// The bound.
    pub gamma: f64,
    /// The Lyapunov matrix; an empty list, or no such key in the file, where V is given.
    #[serde(rename = "X", skip_serializing_if = "Vec::is_empty")]
    pub x: Rows,
    /// V with `X = V'V`, formed without rounding: V shows with 16 digits what X rounded to them may not. An empty
    /// list, or no such key in the file, where X is given.
    #[serde(rename = "V", skip_serializing_if = "Vec::is_empty")]
    pub v: Rows,
    /// The symmetric scaling.
    #[serde(rename = "S")]
    pub s: Rows,
    /// The skew scaling.
    #[serde(rename = "T")]
    pub t: Rows,
}

/// The generalised plant.
///
/// ```text
/// x' = A x + Bt wt + B1 w + B2 u
/// zt = Ct x + Dtt wt + Dt1 w + Dt2 u      wt = Theta zt,  Theta = blkdiag(theta_i I_ri)
/// z  = C1 x + D1t wt + D11 w + D12 u
/// y  = C2 x + D2t wt + D21 w + D22 u
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
#[serde(rename_all = "PascalCase")]
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
    /// The direct path from u to y; an empty list, or no such key in the file, means 0.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub d22: Rows,
}

/// The controller.
///
/// ```text
/// xk' = A xk + By y + Bt wk
/// u   = Cu xk + Duy y + Dut wk
/// zk  = Ct xk + Dty y + Dtt wk            wk = Theta zk
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
#[serde(rename_all = "PascalCase")]
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
            /// The matrices that every file contains, row by row of the equations, with their keys.
            pub fn named(&self) -> [(&'static str, &Rows); $count] {
                [$(($key, &self.$field)),*]
            }

            /// The same, to be changed.
            pub fn named_mut(&mut self) -> [(&'static str, &mut Rows); $count] {
                [$(($key, &mut self.$field)),*]
            }
        }
    };
}

named!(Plant, 15: a "A", bt "Bt", b1 "B1", b2 "B2", ct "Ct", dtt "Dtt", dt1 "Dt1", dt2 "Dt2",
    c1 "C1", d1t "D1t", d11 "D11", d12 "D12", c2 "C2", d2t "D2t", d21 "D21");
named!(Controller, 9: a "A", by "By", bt "Bt", cu "Cu", duy "Duy", dut "Dut", ct "Ct", dty "Dty", dtt "Dtt");

/// The claim for the plant with `[A B1 B2] + E Delta(t) [F Fw Fu]` in place of `[A B1 B2]`, for every measurable
/// Delta(t) with a largest singular value of at most 1, and every Theta(t).
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Residual {
    /// n x ne.
    #[serde(rename = "E")]
    pub e: Rows,
    /// nf x n.
    #[serde(rename = "F")]
    pub f: Rows,
    /// nf x w; an empty list, or no such key in the file, means 0.
    #[serde(rename = "Fw", skip_serializing_if = "Vec::is_empty")]
    pub fw: Rows,
    /// nf x u.
    #[serde(rename = "Fu")]
    pub fu: Rows,
    /// The multiplier of Delta.
    pub lambda: f64,
    /// The bound.
    pub gamma: f64,
    /// The Lyapunov matrix.
    #[serde(rename = "X")]
    pub x: Rows,
    /// The symmetric scaling.
    #[serde(rename = "S")]
    pub s: Rows,
    /// The skew scaling.
    #[serde(rename = "T")]
    pub t: Rows,
}

/// The claim for the only parameter theta, Lipschitz continuous with `|theta'(t)| <= rate` almost everywhere.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BoundedRate {
    /// In units of theta per unit of time, at least 0.
    pub rate: f64,
    /// The bound, with its matrices.
    #[serde(flatten)]
    pub slow: Slow,
    /// The bound for the plant with the model error of the section `residual`, with its own matrices.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub residual: Option<SlowResidual>,
}

/// A bound at a bounded rate with the matrices that prove it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Slow {
    /// The bound.
    pub gamma: f64,
    /// Whether the Lyapunov matrix is the inverse of X(theta); the inequality is then that of the transposed loop.
    pub inverse: bool,
    /// The Lyapunov matrix, or its inverse, `X(theta) = X[0] + theta X[1] + ...`.
    #[serde(rename = "X")]
    pub x: Vec<Rows>,
    /// Ascending from -1 to 1.
    pub breakpoints: Vec<f64>,
    /// For each interval between two breakpoints the multiplier of `wt - theta zt`, (r + rk) x (states, channels,
    /// rows of Delta, inputs), of the transposed loop (states, channels, columns of Delta, outputs).
    #[serde(rename = "N")]
    pub n: Vec<Rows>,
}

/// A bound at a bounded rate with model error.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SlowResidual {
    /// The multiplier of Delta.
    pub lambda: f64,
    /// The bound, with its matrices.
    #[serde(flatten)]
    pub slow: Slow,
}

/// The claim for commands cut off at limits, with the plant and the model error of the section `residual`.
///
/// The plant gets `u - phi`, and the controller's states move by `E phi` faster, with `phi = u - sat(u)`. Likewise the
/// rates of some of the plant's states are cut off. n counts the states of that loop, those of the plant that the loop
/// consists of and then the controller's: see the crate's documentation.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Limits {
    /// The input of the steps: a component of w, from 0.
    pub input: usize,
    /// The largest step.
    pub size: f64,
    /// How far each command can go at least, either way; then how fast each state of `rates`.
    pub limits: Vec<f64>,
    /// The states of the plant whose rates are cut off; none if the file says nothing. Each has an entry of `limits`,
    /// `u_held`, `U` and `H`, after those of the commands.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub rates: Vec<usize>,
    /// nk x u.
    #[serde(rename = "E")]
    pub e: Rows,
    /// The rate at which x'Xx decreases once the step is taken back.
    pub decay: f64,
    /// x'Xx stays below beta while the step is held, x taken from `x_held` times the step.
    pub beta: f64,
    /// The state from which x is taken while a step of 1 is held, n numbers.
    pub x_held: Vec<f64>,
    /// The commands from which H x is taken while a step of 1 is held.
    pub u_held: Vec<f64>,
    /// How many rows of Delta, the first ones, may differ from 0 in this claim; all if the file says nothing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub delta_rows: Option<usize>,
    /// The multiplier of Delta.
    pub lambda: f64,
    /// The Lyapunov matrix, n x n.
    #[serde(rename = "X")]
    pub x: Rows,
    /// The symmetric scaling.
    #[serde(rename = "S")]
    pub s: Rows,
    /// The skew scaling.
    #[serde(rename = "T")]
    pub t: Rows,
    /// The multiplier of each limit.
    #[serde(rename = "U")]
    pub u: Vec<f64>,
    /// Below which part of u a limit is out of reach, u x n.
    #[serde(rename = "H")]
    pub h: Rows,
}

/// The claims for commands cut off at limits and w of bounded energy, with the plant without model error.
///
/// The plant gets `u - phi`, and the controller's states move by `E phi` faster, with `phi = u - sat(u)`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Energy {
    /// How far each command can go at least, either way.
    pub limits: Vec<f64>,
    /// nk x u.
    #[serde(rename = "E")]
    pub e: Rows,
    /// At least one.
    pub claims: Vec<EnergyClaim>,
}

/// The gain from w to z is below gamma for every w whose energy is at most beta, from rest; with `H = 0` for every w.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EnergyClaim {
    /// The bound.
    pub gamma: f64,
    /// The largest energy, the integral of w'w over time; without a meaning where H is 0.
    pub beta: f64,
    /// The Lyapunov matrix: x'Xx stays below gamma beta.
    #[serde(rename = "X")]
    pub x: Rows,
    /// The symmetric scaling.
    #[serde(rename = "S")]
    pub s: Rows,
    /// The skew scaling.
    #[serde(rename = "T")]
    pub t: Rows,
    /// The multiplier of each limit.
    #[serde(rename = "U")]
    pub u: Vec<f64>,
    /// Below which part of u a limit is out of reach, u x (n + nk).
    #[serde(rename = "H")]
    pub h: Rows,
}

impl Plant {
    /// D22; `None` if it is 0.
    pub fn direct_path(&self) -> Option<&Rows> {
        Some(&self.d22).filter(|rows| rows.iter().flatten().any(|entry| *entry != 0.0))
    }
}

/// A certificate with its format, as in the file.
#[derive(Serialize)]
pub(crate) struct File<'a, T> {
    pub(crate) format: &'static str,
    #[serde(flatten)]
    pub(crate) certificate: &'a T,
}

impl Certificate {
    /// The bound for parameters that move however fast, if there is one.
    pub fn gamma(&self) -> Option<f64> {
        self.any_rate.as_ref().map(|claim| claim.gamma)
    }

    /// Returns the certificate as JSON; every number reads back to the same f64.
    ///
    /// # Errors
    /// [`ReadError`] if sizes do not agree or a number is not finite.
    pub fn to_json(&self) -> Result<String, ReadError> {
        self.check()?;
        Ok(serde_json::to_string(&File { format: FORMAT, certificate: self })?)
    }
}
