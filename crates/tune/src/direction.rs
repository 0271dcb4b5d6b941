//! Directions of a search.

use crate::knob::Knob;
use std::collections::BTreeMap;

/// Keys that are turned by the same factor, by their places.
pub(crate) struct Direction(pub Vec<usize>);

impl Direction {
    /// Frequency and bandwidth of each track, all noises, and what is left by itself.
    ///
    /// How much slow references count stays as it began: each direction costs a design before the first step.
    pub(crate) fn together(knobs: &[Knob]) -> Vec<Self> {
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
