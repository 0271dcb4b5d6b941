//! Numbers formatted for people.

pub use squid_auv::readable;
pub use squid_base::numbers::{above, decimals, rounded_down, rounded_up};
