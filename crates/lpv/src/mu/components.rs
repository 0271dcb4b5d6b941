//! The strongly connected components of a perturbed system.
//!
//! `det(I - M Delta)` is the product of the determinants of the strongly connected components of the pattern of M, in
//! which a channel leads to another if its entry is not zero: mu is the largest over the components, each with its part
//! of the blocks. The channels of a full block are in one component, those of a repeated scalar need not be.
//! Components: R. Tarjan, SIAM J. Computing 1(2), 1972.

use super::CMat;
use super::structure::{Block, Structure};
use crate::system::StateSpace;
use nalgebra::{Complex, DMatrix};
use std::ops::Range;

/// A component, by its entries of z and of w.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Component {
    pub(super) structure: Structure,
    pub(super) z: Vec<usize>,
    pub(super) w: Vec<usize>,
    /// The index of each block in the complete structure.
    blocks: Vec<usize>,
}

impl Component {
    /// Returns the part of a matrix in the component.
    pub(super) fn part(&self, m: &CMat) -> CMat {
        m.select_rows(&self.z).select_columns(&self.w)
    }

    /// Returns the part of a system in the component.
    pub(super) fn system(&self, s: &StateSpace) -> StateSpace {
        StateSpace {
            a: s.a.clone(),
            b: s.b.select_columns(&self.w),
            c: s.c.select_rows(&self.z),
            d: s.d.select_rows(&self.z).select_columns(&self.w),
        }
        .without_idle_states()
    }

    /// Returns the perturbation of the complete system with `delta` for this component and zero elsewhere.
    pub(super) fn embedded(&self, delta: &CMat, structure: &Structure) -> CMat {
        let mut out = CMat::zeros(structure.rows(), structure.cols());
        let places = structure.places();
        for ((_, rows, cols), block) in self.structure.places().into_iter().zip(&self.blocks) {
            let (kind, w, z) = &places[*block];
            let given = delta.view((rows.start, cols.start), (rows.len(), cols.len()));
            let mut part = out.view_mut((w.start, z.start), (w.len(), z.len()));
            match kind {
                Block::Full { .. } => part.copy_from(&given),
                Block::Real(_) | Block::Complex(_) => part.fill_diagonal(given[(0, 0)]),
            }
        }
        out
    }
}

/// Returns the components of matrices, in topological order.
pub(super) fn of_matrices(all: &[CMat], structure: &Structure) -> Vec<Component> {
    let pattern = DMatrix::from_fn(structure.cols(), structure.rows(), |i, j| {
        all.iter().any(|m| m[(i, j)] != Complex::ZERO)
    });
    components(&pattern, structure)
}

/// Returns the components of a transfer matrix: entries that its states do not connect are zero at every frequency.
pub(super) fn of_system(s: &StateSpace, structure: &Structure) -> Vec<Component> {
    let (n, cols) = (s.a.nrows(), s.b.ncols());
    let mut reached = DMatrix::from_fn(n, n, |i, j| i == j || s.a[(i, j)] != 0.0);
    close(&mut reached);
    let driven = DMatrix::from_fn(n, cols, |i, j| (0..n).any(|k| reached[(i, k)] && s.b[(k, j)] != 0.0));
    let pattern = DMatrix::from_fn(s.c.nrows(), cols, |i, j| {
        s.d[(i, j)] != 0.0 || (0..n).any(|k| s.c[(i, k)] != 0.0 && driven[(k, j)])
    });
    components(&pattern, structure)
}

/// Forms the transitive closure: S. Warshall, J. ACM 9(1), 1962.
fn close(reached: &mut DMatrix<bool>) {
    let n = reached.nrows();
    for k in 0..n {
        for i in (0..n).filter(|i| *i != k) {
            if reached[(i, k)] {
                for j in 0..n {
                    reached[(i, j)] |= reached[(k, j)];
                }
            }
        }
    }
}

/// A channel of a scalar, or a full block, with the index of its block.
struct Node {
    block: usize,
    w: Range<usize>,
    z: Range<usize>,
}

fn nodes(structure: &Structure) -> Vec<Node> {
    let mut out = vec![];
    for (block, (kind, w, z)) in structure.places().into_iter().enumerate() {
        match kind {
            Block::Full { .. } => out.push(Node { block, w, z }),
            Block::Real(r) | Block::Complex(r) => out.extend((0..r).map(|k| {
                let (w, z) = (w.start + k, z.start + k);
                Node { block, w: w..w + 1, z: z..z + 1 }
            })),
        }
    }
    out
}

fn components(pattern: &DMatrix<bool>, structure: &Structure) -> Vec<Component> {
    let nodes = nodes(structure);
    let n = nodes.len();
    let meets = |to: &Node, from: &Node| to.z.clone().any(|i| from.w.clone().any(|j| pattern[(i, j)]));
    let mut reached = DMatrix::from_fn(n, n, |i, j| i == j || meets(&nodes[i], &nodes[j]));
    close(&mut reached);
    let mut open: Vec<usize> = (0..n).collect();
    // A node that leads to others is reachable from fewer nodes.
    open.sort_by_key(|i| reached.row(*i).iter().filter(|r| **r).count());
    let mut out = vec![];
    while let Some(&first) = open.first() {
        let (mut members, rest): (Vec<usize>, Vec<usize>) =
            open.iter().partition(|i| reached[(first, **i)] && reached[(**i, first)]);
        members.sort_unstable();
        out.push(component(&members.iter().map(|i| &nodes[*i]).collect::<Vec<_>>(), structure));
        open = rest;
    }
    out
}

fn component(nodes: &[&Node], structure: &Structure) -> Component {
    let mut blocks: Vec<usize> = nodes.iter().map(|node| node.block).collect();
    blocks.dedup();
    let left = |block: &usize| {
        let count = nodes.iter().filter(|node| node.block == *block).count();
        match structure.blocks()[*block] {
            Block::Real(_) => Block::Real(count),
            Block::Complex(_) => Block::Complex(count),
            full @ Block::Full { .. } => full,
        }
    };
    Component {
        structure: Structure::of(blocks.iter().map(left).collect()),
        z: nodes.iter().flat_map(|node| node.z.clone()).collect(),
        w: nodes.iter().flat_map(|node| node.w.clone()).collect(),
        blocks,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::matrix::Mat;
    use nalgebra::dmatrix;

    fn of(m: &Mat, blocks: Vec<Block>) -> Vec<(Vec<usize>, Vec<usize>)> {
        let m = m.map(Complex::from);
        let found = of_matrices(&[m], &Structure::new(blocks).unwrap());
        found.into_iter().map(|c| (c.z, c.w)).collect()
    }

    /// The first channel leads to the others, which form a loop; a full block connects its channels.
    #[test]
    fn loops_are_found_in_topological_order() {
        let m = dmatrix![0.5, 0.0, 0.0; 1.0, 0.0, 2.0; 0.0, 1.0, 0.0];
        let scalars = of(&m, vec![Block::Real(2), Block::Real(1)]);
        assert_eq!(scalars, [(vec![0], vec![0]), (vec![1, 2], vec![1, 2])]);
        let tied = of(&m, vec![Block::Full { rows: 2, cols: 2 }, Block::Real(1)]);
        assert_eq!(tied, [(vec![0, 1, 2], vec![0, 1, 2])]);
    }

    /// Two channels whose loops pass through unconnected states.
    #[test]
    fn states_connect_channels() {
        let structure = Structure::new(vec![Block::Real(2)]).unwrap();
        let apart = StateSpace {
            a: dmatrix![-1.0, 0.0; 3.0, -2.0],
            b: dmatrix![1.0, 0.0; 0.0, 1.0],
            c: dmatrix![1.0, 0.0; 0.0, 1.0],
            d: Mat::zeros(2, 2),
        };
        let found = of_system(&apart, &structure);
        assert_eq!(found.iter().map(|c| c.z.clone()).collect::<Vec<_>>(), [vec![0], vec![1]]);
        assert_eq!(found[0].system(&apart).a, dmatrix![-1.0]);
        let mut joined = apart;
        joined.d[(0, 1)] = 0.1;
        assert_eq!(of_system(&joined, &structure).len(), 1);
    }
}
