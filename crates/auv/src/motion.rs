//! Equations of motion: forces, trims, linear models.

mod balance;
pub(crate) mod branch;
pub(crate) mod descriptor;
pub(crate) mod dynamics;
mod forces;
pub(crate) mod lateral;
pub(crate) mod level;
pub(crate) mod linearise;
pub(crate) mod parameter;
pub(crate) mod trim;
pub(crate) mod trim_error;
pub(crate) mod turn;
