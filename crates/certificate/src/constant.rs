//! The certificate for parameters some of which are constant: the file, and its reader. `constant/prove.rs` says what
//! it claims, and why its conditions suffice.

mod inequality;
mod prove;
mod theorem;

pub use theorem::ConstantTheorem;

use crate::certificate::{AnyRate, Certificate, Controller, File, Plant, Residual, Rows};
use crate::error::ReadError;
use crate::json::Json;
use crate::read::{Read, check_format, lists, objects};
use crate::shape::{check_matrix, check_number, columns};
use serde::Serialize;

/// Value of the key `format`.
pub const CONSTANT_FORMAT: &str = "lpv-constant-certificate/1";

/// The claim `gain from w to z < gamma` for every trajectory of some parameters and every constant value of the others,
/// with the matrices that prove it.
///
/// With n states of plant and controller, r channels of both, and k channels of the parameters with a filter, X is
/// (n + 2k) x (n + 2k). S and T are (r + k + v) x (r + k + v), with v channels of the parameters that may change.
/// States: plant's, controller's, those of the filters of zt, then of wt; channels: plant's, controller's, the filtered
/// ones in the order of `filters`, and the rates of those that have one.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ConstantCertificate {
    /// Repetitions `[r_1, r_2, ...]` of the parameters in the plant's channels.
    pub blocks: Vec<usize>,
    /// The same in the controller's channels.
    pub controller_blocks: Vec<usize>,
    /// The plant, without a direct path from u to y.
    pub plant: Plant,
    /// The controller.
    pub controller: Controller,
    /// The bound.
    pub gamma: f64,
    /// The matrix of the inequality, symmetric.
    #[serde(rename = "X")]
    pub x: Rows,
    /// The symmetric multiplier.
    #[serde(rename = "S")]
    pub s: Rows,
    /// The skew multiplier.
    #[serde(rename = "T")]
    pub t: Rows,
    /// A Lyapunov matrix of the loop where all parameters are 0; n x n.
    #[serde(rename = "L")]
    pub lyapunov: Rows,
    /// The filters, one or more, of each parameter that is constant or changes slowly, in the order of the parameters;
    /// all others may take any trajectory.
    pub filters: Vec<Filter>,
    /// Model errors: `[A B2]` of the plant becomes `[A B2]` plus the sum of all `E Delta(t) [F Fu]`.
    pub errors: Vec<ErrorBall>,
}

/// A filter `1/(s + pole)` on the channels of a parameter that is constant or changes slowly.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Filter {
    /// The parameter, from 0.
    pub parameter: usize,
    /// Above 0.
    pub pole: f64,
    /// Bound on the rate of the parameter, 1/s; 0, or no such key in the file, where it is constant.
    #[serde(skip_serializing_if = "is_zero")]
    pub rate: f64,
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_zero(rate: &f64) -> bool {
    *rate == 0.0
}

/// A model error `E Delta(t) [F Fu]` with any measurable Delta(t) whose largest singular value is at most 1.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ErrorBall {
    /// n x ne for n states of the plant.
    #[serde(rename = "E")]
    pub e: Rows,
    /// nf x n.
    #[serde(rename = "F")]
    pub f: Rows,
    /// nf x u.
    #[serde(rename = "Fu")]
    pub fu: Rows,
    /// The multiplier of Delta.
    pub lambda: f64,
}

objects! {
    Filter: parameter "parameter", pole "pole"; rate "rate";
    ErrorBall: e "E", f "F", fu "Fu", lambda "lambda";;
    ConstantCertificate + "format": blocks "blocks", controller_blocks "controller_blocks", plant "plant",
        controller "controller", gamma "gamma", x "X", s "S", t "T", lyapunov "L", filters "filters",
        errors "errors";;
}
lists!(Filter: "a list of objects", ErrorBall: "a list of objects");

impl ConstantCertificate {
    /// Whether a text says that it is of this format; nothing else of it is checked.
    pub fn is_format_of(text: &str) -> bool {
        let Ok(Json::Object(entries)) = serde_json::from_str(text) else { return false };
        let named = |(key, value): &(String, Json)| {
            key == "format" && matches!(value, Json::Text(found) if found == CONSTANT_FORMAT)
        };
        entries.iter().any(named)
    }

    /// Returns the certificate as JSON; every number reads back to the same f64.
    ///
    /// # Errors
    /// [`ReadError`] if sizes do not agree or a number is not finite.
    pub fn to_json(&self) -> Result<String, ReadError> {
        self.check()?;
        Ok(serde_json::to_string(&File { format: CONSTANT_FORMAT, certificate: self })?)
    }

    /// Reads a certificate of format [`CONSTANT_FORMAT`].
    ///
    /// # Errors
    /// [`ReadError`], the first problem of the text.
    pub fn from_json(text: &str) -> Result<Self, ReadError> {
        let json = serde_json::from_str(text)?;
        check_format(&json, CONSTANT_FORMAT)?;
        let certificate = Self::read("", &json)?;
        certificate.check()?;
        Ok(certificate)
    }

    /// Checks that all numbers are finite and all sizes agree.
    ///
    /// # Errors
    /// The first field that does not fit.
    pub fn check(&self) -> Result<(), ReadError> {
        if self.plant.direct_path().is_some() {
            let found = "a direct path from u to y".into();
            return Err(ReadError::kind("plant.D22", found, "none in this format"));
        }
        let states = (self.plant.a.len(), "plant's states");
        let controls = (columns(&self.plant.d12), "controls u");
        for (i, ball) in self.errors.iter().enumerate() {
            let (ne, nf) = (columns(&ball.e), ball.f.len());
            check_matrix(&format!("errors[{i}].E"), &ball.e, states, (ne, "rows of Delta"))?;
            check_matrix(&format!("errors[{i}].F"), &ball.f, (nf, "columns of Delta"), states)?;
            check_matrix(&format!("errors[{i}].Fu"), &ball.fu, (nf, "columns of Delta"), controls)?;
            check_number(&format!("errors[{i}].lambda"), ball.lambda)?;
        }
        let all = (states.0.saturating_add(self.controller.a.len()), "states of plant and controller");
        check_matrix("L", &self.lyapunov, all, all)?;
        self.frame().check()?;
        let mut before: Option<&Filter> = None;
        for (i, filter) in self.filters.iter().enumerate() {
            let k = self.channels_of(filter.parameter);
            if k == 0 || before.is_some_and(|before| filter.parameter < before.parameter) {
                let (field, found) = (format!("filters[{i}].parameter"), filter.parameter.to_string());
                let allowed =
                    "the number of a parameter that has channels, not smaller than that of the filter before";
                return Err(ReadError::kind(&field, found, allowed));
            }
            check_number(&format!("filters[{i}].pole"), filter.pole)?;
            check_number(&format!("filters[{i}].rate"), filter.rate)?;
            if filter.rate < 0.0 {
                let (field, found) = (format!("filters[{i}].rate"), filter.rate.to_string());
                return Err(ReadError::kind(&field, found, "a number that is at least 0"));
            }
            let same = before.filter(|before| before.parameter == filter.parameter);
            if same.is_some_and(|before| before.rate != filter.rate) {
                let (field, found) = (format!("filters[{i}].rate"), filter.rate.to_string());
                return Err(ReadError::kind(
                    &field,
                    found,
                    "the rate of the other filters of that parameter",
                ));
            }
            before = Some(filter);
        }
        let (n, k) = (self.lyapunov.len(), self.filtered());
        let states = (n + 2 * k, "states of plant, controller and filters");
        let channels = self.blocks.iter().chain(&self.controller_blocks).sum::<usize>() + k + self.moving();
        let channels = (channels, "channels of plant and controller, the filtered ones, and those of rates");
        check_matrix("X", &self.x, states, states)?;
        check_matrix("S", &self.s, channels, channels)?;
        check_matrix("T", &self.t, channels, channels)
    }

    /// The loop and its model errors, one Delta beside the other, in the form of the other certificate: without proof.
    fn frame(&self) -> Certificate {
        let r =
            self.blocks.iter().chain(&self.controller_blocks).fold(0_usize, |sum, n| sum.saturating_add(*n));
        let none = vec![vec![0.0; r.min(self.s.len())]; r.min(self.s.len())];
        let mut all = Residual {
            e: vec![vec![]; self.plant.a.len()],
            lambda: 1.0,
            gamma: self.gamma,
            x: self.lyapunov.clone(),
            s: none.clone(),
            t: none.clone(),
            ..Residual::default()
        };
        for ball in &self.errors {
            all.e.iter_mut().zip(&ball.e).for_each(|(row, more)| row.extend(more));
            all.f.extend(ball.f.iter().cloned());
            all.fu.extend(ball.fu.iter().cloned());
        }
        Certificate {
            blocks: self.blocks.clone(),
            controller_blocks: self.controller_blocks.clone(),
            plant: self.plant.clone(),
            controller: self.controller.clone(),
            any_rate: Some(AnyRate {
                gamma: self.gamma,
                x: self.lyapunov.clone(),
                s: none.clone(),
                t: none,
                ..AnyRate::default()
            }),
            residual: (!self.errors.is_empty()).then_some(all),
            ..Certificate::default()
        }
    }

    /// The number of parameters of plant and controller.
    fn parameters(&self) -> usize {
        self.blocks.len().max(self.controller_blocks.len())
    }

    /// Channels of a parameter in plant and controller.
    fn channels_of(&self, parameter: usize) -> usize {
        let of = |blocks: &[usize]| blocks.get(parameter).copied().unwrap_or(0);
        of(&self.blocks).saturating_add(of(&self.controller_blocks))
    }

    /// Filtered channels, of all filters.
    fn filtered(&self) -> usize {
        self.filters.iter().map(|f| self.channels_of(f.parameter)).sum()
    }

    /// Those among them whose parameter may change.
    fn moving(&self) -> usize {
        self.filters.iter().filter(|f| f.rate > 0.0).map(|f| self.channels_of(f.parameter)).sum()
    }
}
