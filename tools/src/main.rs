//! The command `squid`.
fn main() {}
