//! The table of variables, and its access by importers.

mod derivatives;
mod embed;
pub(crate) mod role;
pub(crate) mod table;
pub(crate) mod values;
pub(crate) mod variable;
