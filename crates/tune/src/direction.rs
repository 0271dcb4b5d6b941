//! Search directions.

use crate::knob::Knob;
use std::collections::BTreeMap;

/// Indices of keys that are multiplied by the same factor.
pub(crate) struct Direction(pub Vec<usize>);

impl Direction {
    /// Returns one direction for frequency and bandwidth of each track, one for all noises, and one for each other key.
    ///
    /// `follow` stays constant: each direction costs a design before the first step.
    pub(crate) fn grouped(knobs: &[Knob]) -> Vec<Self> {
        let group = |knob: &Knob| match knob {
            Knob::Frequency(i) | Knob::Bandwidth(i) => Some(*i),
            Knob::Follow(_) => None,
            Knob::Noise(_) => Some(usize::MAX - 2),
            Knob::Weight => Some(usize::MAX - 1),
            Knob::Disturbance => Some(usize::MAX),
        };
        let mut groups: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (i, knob) in knobs.iter().enumerate() {
            if let Some(group) = group(knob) {
                groups.entry(group).or_default().push(i);
            }
        }
        groups.into_values().map(Self).collect()
    }
}
