//! Exact arithmetic: numbers, matrices, and tests of definiteness.

pub(crate) mod definite;
pub(crate) mod dyadic;
pub(crate) mod matrix;
pub(crate) mod whole;
pub(crate) mod witness;
