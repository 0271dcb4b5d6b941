//! Traces that form one column of a Schur complement.
//!
//! For the G of a pair (a, b) of columns of W, and the F of a pair (c, d), `tr(G M F N)` is the entry (c, d) of a
//! symmetric matrix of rank four:
//!
//! ```text
//! T = M_a N_b' + M_b N_a' + N_a M_b' + N_b M_a',   with the columns of W'MW and W'NW
//! ```
//!
//! A matrix unknown V of a term `L V R` needs the rectangle of T of the columns of L and R, which is computed as one
//! product of matrices over all pairs of an unknown. For a V with few entries, single traces are computed.

use crate::matrix::Mat;
use nalgebra::{DMatrixView, DMatrixViewMut, Dyn};
use std::ops::Range;

/// A rectangle, unless it is small, is computed as one product if at least one in this number of its traces is needed.
const NEEDED: usize = 4;
const LEAST_AREA: usize = 16;

/// The required traces, and the index of each.
#[derive(Debug, Clone, Default)]
pub(crate) struct Traces {
    rectangles: Vec<Rectangle>,
    singles: Vec<Single>,
    /// Index of the trace of each pair of each unknown.
    positions: Vec<u32>,
    size: usize,
}

/// A rectangle of traces, of c in `rows` and d in `columns`, column by column.
#[derive(Debug, Clone)]
struct Rectangle {
    rows: Range<u32>,
    columns: Range<u32>,
    /// Index of its first trace.
    start: usize,
    /// First row and first column that each unknown or a later one needs.
    first: Vec<(u32, u32)>,
}

/// A single trace.
#[derive(Debug, Clone)]
struct Single {
    of: (u32, u32),
    position: usize,
    /// The last unknown that needs it.
    last: u32,
}

/// A pair of columns of W with its columns of W'MW and W'NW, and the factor of its traces.
pub(crate) struct Factor<'a> {
    by: f64,
    m: [&'a [f64]; 2],
    n: [&'a [f64]; 2],
}

impl<'a> Factor<'a> {
    pub(crate) fn new(by: f64, m: &'a Mat, n: &'a Mat, (a, b): (u32, u32)) -> Self {
        fn column(of: &Mat, at: u32) -> &[f64] {
            let rows = of.nrows();
            &of.as_slice()[at as usize * rows..][..rows]
        }
        Self { by, m: [column(m, a), column(m, b)], n: [column(n, a), column(n, b)] }
    }

    /// Appends the rows c of the four columns, column by column.
    fn push_left(&self, rows: &Range<usize>, to: &mut Vec<f64>) {
        for column in [self.m[0], self.m[1], self.n[0], self.n[1]] {
            to.extend_from_slice(&column[rows.clone()]);
        }
    }

    /// Returns the other factor of T at row d: its row k is multiplied by column k of the first.
    fn right(&self, d: usize) -> [f64; 4] {
        [self.n[1], self.n[0], self.m[1], self.m[0]].map(|column| self.by * column[d])
    }

    /// Returns the entries of the four columns, row by row.
    fn by_row(&self) -> Vec<[f64; 4]> {
        let ([ma, mb], [na, nb]) = (self.m, self.n);
        let of_n = na.iter().zip(nb);
        ma.iter().zip(mb).zip(of_n).map(|((ma, mb), (na, nb))| [*ma, *mb, *na, *nb]).collect()
    }

    /// Returns the trace with the pair (c, d).
    pub(crate) fn trace(&self, (c, d): (u32, u32)) -> f64 {
        let of = |at: u32| [self.m[0], self.m[1], self.n[0], self.n[1]].map(|column| column[at as usize]);
        self.by * trace(&of(c), &of(d))
    }
}

/// Returns an entry of T, from the rows of the four columns.
fn trace(c: &[f64; 4], d: &[f64; 4]) -> f64 {
    c[0] * d[3] + c[1] * d[2] + c[2] * d[1] + c[3] * d[0]
}

/// The traces of one column of a Schur complement, and the work space for them.
#[derive(Debug, Default)]
pub(crate) struct Scratch {
    pub(crate) traces: Vec<f64>,
    left: Vec<f64>,
    right: Vec<f64>,
}

impl Traces {
    /// Returns the traces of pairs `(unknown, a, b)` in the order of unknowns; `terms` are the columns of W of each L
    /// and R.
    pub(crate) fn new(terms: Vec<[Range<u32>; 2]>, pairs: &[(u32, u32, u32)]) -> Self {
        let unknowns = pairs.last().map_or(0, |p| p.0 as usize + 1);
        let mut out = Self::default();
        let mut left: Vec<usize> = (0..pairs.len()).collect();
        out.positions = vec![0; pairs.len()];
        for [one, other] in terms {
            // The smaller index first, as in a pair.
            let (rows, columns) = if one.start <= other.start { (one, other) } else { (other, one) };
            let (height, start) = (rows.len(), out.size);
            let within = |i: &usize| rows.contains(&pairs[*i].1) && columns.contains(&pairs[*i].2);
            let (here, others): (Vec<usize>, Vec<usize>) = left.iter().partition(|i| within(i));
            let at = |i: usize| {
                (pairs[i].1 - rows.start) as usize + height * (pairs[i].2 - columns.start) as usize
            };
            let mut needed = vec![false; height * columns.len()];
            here.iter().for_each(|i| needed[at(*i)] = true);
            let count = needed.iter().filter(|needed| **needed).count();
            if needed.len() < LEAST_AREA || NEEDED * count < needed.len() {
                continue;
            }
            let mut first = vec![(rows.end, columns.end); unknowns];
            for i in here {
                let (unknown, a, b) = pairs[i];
                let known = &mut first[unknown as usize];
                *known = (known.0.min(a), known.1.min(b));
                out.positions[i] = (start + at(i)) as u32;
            }
            for position in (1..unknowns).rev() {
                let later = first[position];
                let known = &mut first[position - 1];
                *known = (known.0.min(later.0), known.1.min(later.1));
            }
            out.size += needed.len();
            out.rectangles.push(Rectangle { rows, columns, start, first });
            left = others;
        }
        let mut known = std::collections::BTreeMap::new();
        for i in left {
            let (unknown, a, b) = pairs[i];
            let next = Single { of: (a, b), position: out.size + known.len(), last: unknown };
            let single: &mut Single = known.entry((a, b)).or_insert(next);
            single.last = single.last.max(unknown);
            out.positions[i] = single.position as u32;
        }
        out.size += known.len();
        out.singles = known.into_values().collect();
        out.singles.sort_by_key(|single| single.last);
        out
    }

    /// Computes the traces that the unknown at index `position` and later ones need; the others are undefined.
    pub(crate) fn fill(&self, position: usize, factors: &[Factor<'_>], scratch: &mut Scratch) {
        let Scratch { traces, left, right } = scratch;
        traces.clear();
        traces.resize(self.size, 0.0);
        for r in &self.rectangles {
            let (row, column) = r.first[position];
            let (rows, columns) =
                (row as usize..r.rows.end as usize, column as usize..r.columns.end as usize);
            if rows.is_empty() || columns.is_empty() {
                continue;
            }
            left.clear();
            right.clear();
            factors.iter().for_each(|factor| factor.push_left(&rows, left));
            for d in columns.clone() {
                factors.iter().for_each(|factor| right.extend_from_slice(&factor.right(d)));
            }
            let (rank, height) = (4 * factors.len(), r.rows.len());
            let left = DMatrixView::from_slice(left, rows.len(), rank);
            let right = DMatrixView::from_slice(right, rank, columns.len());
            let from = r.start + (columns.start - r.columns.start as usize) * height + rows.start
                - r.rows.start as usize;
            let shape = (Dyn(rows.len()), Dyn(columns.len()));
            DMatrixViewMut::from_slice_with_strides_generic(
                &mut traces[from..],
                shape.0,
                shape.1,
                Dyn(1),
                Dyn(height),
            )
            .gemm(1.0, &left, &right, 0.0);
        }
        let begin = self.singles.partition_point(|single| (single.last as usize) < position);
        if begin == self.singles.len() {
            return;
        }
        for factor in factors {
            let rows = factor.by_row();
            for single in &self.singles[begin..] {
                let (c, d) = single.of;
                traces[single.position] += factor.by * trace(&rows[c as usize], &rows[d as usize]);
            }
        }
    }

    /// Returns the indices of the traces that some of the pairs need.
    pub(crate) fn positions(&self, pairs: Range<usize>) -> &[u32] {
        &self.positions[pairs]
    }
}
