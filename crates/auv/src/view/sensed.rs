//! Signal of a view, and its value in a state.

use crate::simulation::plant::State;
use squid_signals::Signal;

/// Signal of a view, and its value in a state.
#[derive(Clone, Copy, Debug)]
pub struct Sensed {
    /// Names, unit and state of the signal.
    pub signal: Signal,
    /// Returns the value, SI; angles are not wrapped.
    pub value: fn(&State) -> f64,
    /// Adds an offset to the signal, SI, in a state in which the rate of pitch is 0.
    pub displace: fn(&mut State, f64),
}

/// Returns the signals of a table.
pub(crate) const fn signals_of<const N: usize>(table: &[Sensed; N]) -> [Signal; N] {
    let mut all = [table[0].signal; N];
    let mut index = 1;
    while index < N {
        all[index] = table[index].signal;
        index += 1;
    }
    all
}
