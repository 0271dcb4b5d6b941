//! Numbers formatted for people.

pub use auv::readable;
pub use base::numbers::{above, decimals, rounded_down, rounded_up};
