//! The state of an instance: taken, put back, as bytes.

pub(crate) mod bytes;
pub(crate) mod snapshot;
mod stored;
