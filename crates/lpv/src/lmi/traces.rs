//! The traces that one column of a Schur complement is made of.
//!
//! For the G of a pair (a, b) of columns of W, and the F of a pair (c, d), `tr(G M F N)` is the entry (c, d) of a
//! symmetric matrix of rank four:
//!
//! ```text
//! T = M_a N_b' + M_b N_a' + N_a M_b' + N_b M_a',   with the columns of W'MW and W'NW
//! ```
//!
//! A matrix unknown V of a term `L V R` needs the rectangle of T of the columns of L and R, which is computed as a
//! whole, a product of matrices over all pairs of an unknown. For a V with few entries, single traces are computed.

use crate::matrix::Mat;
use nalgebra::{DMatrixView, DMatrixViewMut, Dyn};
use std::ops::Range;

/// A rectangle of which at least one in so many traces is needed, and that is not too small, is computed as a whole.
const NEEDED: usize = 4;
const LEAST_AREA: usize = 16;

/// Which traces are needed, and where each is put.
#[derive(Debug, Clone, Default)]
pub(crate) struct Traces {
    rectangles: Vec<Rectangle>,
    singles: Vec<Single>,
    /// For each pair of each unknown.
    places: Vec<u32>,
    size: usize,
}

/// Traces of c in `rows` and d in `columns`, column by column.
#[derive(Debug, Clone)]
struct Rectangle {
    rows: Range<u32>,
    columns: Range<u32>,
    /// Where it begins among all traces.
    start: usize,
    /// For each unknown the first row and the first column that it or a later one needs.
    first: Vec<(u32, u32)>,
}

/// One trace.
#[derive(Debug, Clone)]
struct Single {
    of: (u32, u32),
    place: usize,
    /// The last unknown that needs it.
    last: u32,
}

/// A pair of columns of W with its columns of W'MW and W'NW, and what its traces are multiplied by.
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

    /// The other factor of T at row d: column k of the one meets row k of the other.
    fn right(&self, d: usize) -> [f64; 4] {
        [self.n[1], self.n[0], self.m[1], self.m[0]].map(|column| self.by * column[d])
    }

    /// The entries of the four columns, row by row.
    fn by_row(&self) -> Vec<[f64; 4]> {
        let ([ma, mb], [na, nb]) = (self.m, self.n);
        let of_n = na.iter().zip(nb);
        ma.iter().zip(mb).zip(of_n).map(|((ma, mb), (na, nb))| [*ma, *mb, *na, *nb]).collect()
    }

    /// The trace with the pair (c, d).
    pub(crate) fn trace(&self, (c, d): (u32, u32)) -> f64 {
        let of = |at: u32| [self.m[0], self.m[1], self.n[0], self.n[1]].map(|column| column[at as usize]);
        self.by * trace(&of(c), &of(d))
    }
}

/// An entry of T, from the rows of the four columns.
fn trace(c: &[f64; 4], d: &[f64; 4]) -> f64 {
    c[0] * d[3] + c[1] * d[2] + c[2] * d[1] + c[3] * d[0]
}

/// The traces of one column of a Schur complement, and the memory to form them in.
#[derive(Debug, Default)]
pub(crate) struct Scratch {
    pub(crate) traces: Vec<f64>,
    left: Vec<f64>,
    right: Vec<f64>,
}

impl Traces {
    /// Those of pairs `(unknown, a, b)`, in the order of the unknowns; `terms` are the columns of W of each L and R.
    pub(crate) fn new(terms: Vec<[Range<u32>; 2]>, pairs: &[(u32, u32, u32)]) -> Self {
        let unknowns = pairs.last().map_or(0, |p| p.0 as usize + 1);
        let mut out = Self::default();
        let mut left: Vec<usize> = (0..pairs.len()).collect();
        out.places = vec![0; pairs.len()];
        for [one, other] in terms {
            // As pairs are: the lesser number first.
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
                out.places[i] = (start + at(i)) as u32;
            }
            for place in (1..unknowns).rev() {
                let later = first[place];
                let known = &mut first[place - 1];
                *known = (known.0.min(later.0), known.1.min(later.1));
            }
            out.size += needed.len();
            out.rectangles.push(Rectangle { rows, columns, start, first });
            left = others;
        }
        let mut known = std::collections::BTreeMap::new();
        for i in left {
            let (unknown, a, b) = pairs[i];
            let next = Single { of: (a, b), place: out.size + known.len(), last: unknown };
            let single: &mut Single = known.entry((a, b)).or_insert(next);
            single.last = single.last.max(unknown);
            out.places[i] = single.place as u32;
        }
        out.size += known.len();
        out.singles = known.into_values().collect();
        out.singles.sort_by_key(|single| single.last);
        out
    }

    /// The traces of the pairs of the unknown at a place that it and the later ones need; others have any value.
    pub(crate) fn fill(&self, place: usize, factors: &[Factor<'_>], scratch: &mut Scratch) {
        let Scratch { traces, left, right } = scratch;
        traces.clear();
        traces.resize(self.size, 0.0);
        for r in &self.rectangles {
            let (row, column) = r.first[place];
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
        let begin = self.singles.partition_point(|single| (single.last as usize) < place);
        if begin == self.singles.len() {
            return;
        }
        for factor in factors {
            let rows = factor.by_row();
            for single in &self.singles[begin..] {
                let (c, d) = single.of;
                traces[single.place] += factor.by * trace(&rows[c as usize], &rows[d as usize]);
            }
        }
    }

    /// Where the traces are that some of the pairs need.
    pub(crate) fn places(&self, pairs: Range<usize>) -> &[u32] {
        &self.places[pairs]
    }
}
