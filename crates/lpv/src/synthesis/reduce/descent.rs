//! The descent over the sizes of a controller in balanced coordinates.

use crate::analysis::gain_bound::GainBound;
use crate::matrix::{Mat, diagonal_blocks};
use crate::synthesis::balance::equalise;
use crate::synthesis::design::Design;
use crate::synthesis::reduce::smaller::{
    Limits, Part, bounded, frozen_gain, gramians, residualised, truncated, with_channels,
};
use crate::system::controller::Controller;
use crate::system::parameter_grid::parameter_grid;
use crate::system::partition::Group::{T, X};
use crate::system::plant::GeneralisedPlant;
use std::collections::BTreeMap;

/// The smaller controllers of a design by the number of states, or of channels, that they keep.
#[derive(Debug)]
pub(super) struct Descent<'a> {
    plant: &'a GeneralisedPlant,
    design: Design,
    part: Part,
    limits: Limits,
    /// The bound of the design in balanced coordinates.
    bound: GainBound,
    /// The number of states, or channels, of the plant.
    of_plant: usize,
    /// The controllers within the limits at frozen parameters, the smallest first, with the number that each keeps.
    controllers: Vec<(usize, Controller)>,
    /// The bounds found so far by index among the controllers, and `None` if none was found.
    found: BTreeMap<usize, Option<GainBound>>,
}

impl<'a> Descent<'a> {
    /// Balances the design; `None` if nothing can be balanced.
    pub(super) fn of(
        plant: &'a GeneralisedPlant,
        design: &Design,
        part: Part,
        limits: Limits,
    ) -> Option<Self> {
        let k = &design.controller;
        if part == Part::Channels && k.blocks.len() != 1 {
            return None;
        }
        let [reach, see] = gramians(plant, k, part)?;
        let (transform, inverse) = equalise(&see, &reach)?;
        let group = if part == Part::States { X } else { T };
        let parts = k.parts.transformed(&[(group, &inverse)], &[(group, &transform)]);
        let balanced = Controller { parts, blocks: k.blocks.clone() };
        let of_plant = if part == Part::States { plant.a().nrows() } else { plant.dtt().nrows() };
        let lift = diagonal_blocks(&[&Mat::identity(of_plant, of_plant), &transform]);
        let thetas = parameter_grid(plant.blocks.len());
        let mut controllers = vec![];
        for kept in (0..transform.ncols()).rev() {
            let candidates = match part {
                Part::States => vec![truncated(&balanced, kept), residualised(&balanced, kept)],
                Part::Channels => vec![with_channels(&balanced, kept)],
            };
            let gains = candidates.into_iter().flatten().filter_map(|k| Some((frozen_gain(plant, &k)?, k)));
            let mut near: Vec<_> = gains.filter(|(gain, _)| *gain <= limits.gamma).collect();
            if near.is_empty() {
                break;
            }
            near.retain(|(_, k)| limits.fastest_mode.is_none_or(|most| k.fastest_mode(&thetas) <= most));
            let best = near.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
            controllers.extend(best.map(|(_, k)| (kept, k)));
        }
        controllers.reverse();
        let bound = in_coordinates(&design.certified, part, &lift);
        let found = BTreeMap::new();
        Some(Self { plant, design: design.clone(), part, limits, bound, of_plant, controllers, found })
    }

    /// Returns the number of controllers.
    pub(super) fn sizes(&self) -> usize {
        self.controllers.len()
    }

    /// Returns the design with the controller at an index, the smallest first, if a bound of it is found. The search
    /// starts from the matrices of the next larger one with a bound, restricted to the remaining rows; if nothing is
    /// found, from those of the others, and of the design.
    pub(super) fn at(&mut self, index: usize) -> Option<Design> {
        let (kept, controller) = &self.controllers[index];
        if !self.found.contains_key(&index) {
            let larger = self.found.range(index..).filter_map(|(_, bound)| bound.as_ref());
            let size = self.of_plant + kept;
            let bound = larger.chain([&self.bound]).find_map(|start| {
                let start = in_coordinates(start, self.part, &Mat::identity(self.size_of(start), size));
                bounded(self.plant, controller, &start, self.limits.gamma)
            });
            self.found.insert(index, bound);
        }
        let certified = self.found[&index].clone()?;
        Some(Design { controller: controller.clone(), certified, ..self.design.clone() })
    }

    /// Returns the descent with the index of the smallest controller for which a bound is found, by bisection.
    pub(super) fn smallest(mut self) -> Option<(Self, usize)> {
        let (mut low, mut high) = (0, self.sizes());
        let mut middle = 0;
        while low < high {
            if self.at(middle).is_some() {
                high = middle
            } else {
                low = middle + 1
            }
            middle = low.midpoint(high);
        }
        (high < self.sizes()).then_some((self, high))
    }

    fn size_of(&self, bound: &GainBound) -> usize {
        if self.part == Part::States { bound.x.nrows() } else { bound.s.nrows() }
    }
}

/// Returns a bound's matrices in coordinates `x = T x~`, or of the channels: a start for a search, not a bound.
fn in_coordinates(bound: &GainBound, part: Part, transform: &Mat) -> GainBound {
    let of = |m: &Mat| transform.transpose() * m * transform;
    match part {
        Part::States => GainBound { x: of(&bound.x), factor: None, ..bound.clone() },
        Part::Channels => GainBound { s: of(&bound.s), t: of(&bound.t), ..bound.clone() },
    }
}
