//! The state of an instance: saving, restoring and serialisation.

pub(crate) mod bytes;
pub(crate) mod snapshot;
mod stored;
