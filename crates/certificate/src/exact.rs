//! Exact arithmetic: numbers, matrices, and whether they are definite.

pub(crate) mod definite;
pub(crate) mod dyadic;
pub(crate) mod matrix;
pub(crate) mod whole;
pub(crate) mod witness;
