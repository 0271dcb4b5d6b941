//! The table of variables, and what an importer asks of it.

mod derivatives;
mod embed;
pub(crate) mod role;
pub(crate) mod table;
pub(crate) mod values;
pub(crate) mod variable;
