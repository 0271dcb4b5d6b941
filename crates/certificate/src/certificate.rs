//! The certificate as in its file: a closed loop, and what is claimed of it.

use crate::claim::{Claim, Constant, Energy, Gain, Limits, Rate};
use crate::error::Failure;
use crate::strict::from_json;
use crate::theorem::Theorem;
use serde::{Deserialize, Serialize};

/// A matrix as a list of rows; one with rows but no columns is a list of empty rows.
pub type Rows = Vec<Vec<f64>>;

/// The format of a file.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Format {
    /// The only one.
    #[default]
    #[serde(rename = "lpv-certificate/1")]
    One,
}

/// A plant, a controller and model errors, and claims about their closed loop with the matrices that prove them.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Certificate {
    /// The format of the file.
    pub format: Format,
    /// Whether plant and controller are in discrete time: `x+`, the state at the next tick, in place of `x'`. Without
    /// the key the loop is in continuous time.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
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
    /// Model errors, to which some claims extend; none if the file says nothing.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub errors: Vec<ModelError>,
    /// At least one.
    pub claims: Vec<Claim>,
}

/// The generalised plant.
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
    /// The direct path from u to y; an empty list, or no such key in the file, means 0.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub d22: Rows,
}

/// The controller.
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

/// A model error: `[A B1 B2]` of the plant becomes `[A B1 B2] + E Delta(t) [F Fw Fu]`, for every measurable Delta(t)
/// with a largest singular value of at most 1.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "PascalCase", deny_unknown_fields)]
pub struct ModelError {
    /// n x ne.
    pub e: Rows,
    /// nf x n.
    pub f: Rows,
    /// nf x w; an empty list, or no such key in the file, means 0.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub fw: Rows,
    /// nf x u.
    pub fu: Rows,
}

impl Plant {
    /// D22; `None` if it is 0.
    pub fn direct_path(&self) -> Option<&Rows> {
        Some(&self.d22).filter(|rows| rows.iter().flatten().any(|entry| *entry != 0.0))
    }
}

/// Finds the claim of a kind.
macro_rules! find {
    ($($(#[$doc:meta])* $name:ident: $kind:ident $(if $lambda:ident)?;)*) => {
        $($(#[$doc])*
        pub fn $name(&self) -> Option<&$kind> {
            self.claims.iter().find_map(|claim| match claim {
                Claim::$kind(found) $(if found.lambda.$lambda())? => Some(found),
                _ => None,
            })
        })*
    };
}

impl Certificate {
    find! {
        /// The claim about the gain for parameters that vary arbitrarily fast.
        gain: Gain if is_none;
        /// The same with the model error.
        robust_gain: Gain if is_some;
        /// The claim about the gain for a parameter with a bounded rate.
        rate: Rate if is_none;
        /// The same with the model error.
        robust_rate: Rate if is_some;
        /// The claim about a step with saturated commands.
        limits: Limits;
        /// The claim about w of bounded energy with saturated commands.
        energy: Energy;
        /// The claim for parameters some of which are constant.
        constant: Constant;
    }

    /// The model error that the claims cover, if they cover one.
    pub fn model_error(&self) -> Option<&ModelError> {
        match self.errors.as_slice() {
            [error] if self.robust_gain().is_some() => Some(error),
            _ => None,
        }
    }

    /// Reads a certificate.
    ///
    /// # Errors
    /// [`Failure::Malformed`], the first problem of the text.
    pub fn from_json(text: &str) -> Result<Self, Failure> {
        let certificate: Self = from_json(text)?;
        certificate.check()?;
        Ok(certificate)
    }

    /// Returns the certificate as JSON; every number reads back to the same f64.
    ///
    /// # Errors
    /// [`Failure::Malformed`] if sizes do not agree or a number is not finite.
    pub fn to_json(&self) -> Result<String, Failure> {
        self.check()?;
        serde_json::to_string(self).map_err(|error| Failure::malformed("", error))
    }

    /// Proves every claim of the certificate in exact arithmetic.
    ///
    /// # Errors
    /// [`Failure`], the first condition that is violated. The claim may still be true, with other matrices.
    pub fn prove(&self) -> Result<Theorem, Failure> {
        self.check()?;
        self.claims.iter().try_for_each(|claim| claim.parts().1.prove(self))?;
        Ok(Theorem::of(self))
    }
}
