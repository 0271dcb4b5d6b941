//! Matrices whose rows and columns belong to named groups: the data of plant, controller and closed loop.
//!
//! ```text
//! [x'; zt; z; y] = M [x; wt; w; u],   wt = Theta zt,   Theta = diag(theta_c) over the channels
//! ```
//!
//! A group names rows and columns, so it has one size: `X` is x' and x, `T` is zt and wt. Source of the idea:
//! `ExtendedStateSpace` of RobustAndOptimalControl.jl, a system and index vectors.

use crate::error::SystemError;
use crate::matrix::{Mat, block, diagonal, solve};
use crate::system::StateSpace;
use nalgebra::DMatrixViewMut;

/// A group of rows, of columns, or of both.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Group {
    /// States: x' as rows, x as columns.
    X,
    /// Parameter channels: zt as rows, wt as columns.
    T,
    /// Exogenous inputs w.
    W,
    /// Controls u.
    U,
    /// Controlled outputs z.
    Z,
    /// Measurements y.
    Y,
}

use Group::{T, U, W, X, Y, Z};

/// The groups of the rows and of the columns, in order.
pub type Names = (&'static [Group], &'static [Group]);

/// Rows and columns of a generalised plant.
pub const PLANT: Names = (&[X, T, Z, Y], &[X, T, W, U]);
/// Rows and columns of a closed loop.
pub const LOOP: Names = (&[X, T, Z], &[X, T, W]);
/// Rows and columns of a controller.
pub const CONTROLLER: Names = (&[X, U, T], &[X, Y, T]);

/// Returns the name of a block in equations and files.
fn name(row: Group, column: Group) -> &'static str {
    match (row, column) {
        (X, X) => "A",
        (X, T) => "Bt",
        (X, W) => "B1",
        (X, U) => "B2",
        (X, Y) => "By",
        (T, X) => "Ct",
        (T, T) => "Dtt",
        (T, W) => "Dt1",
        (T, U) => "Dt2",
        (T, Y) => "Dty",
        (Z, X) => "C1",
        (Z, T) => "D1t",
        (Z, W) => "D11",
        (Z, U) => "D12",
        (Y, X) => "C2",
        (Y, T) => "D2t",
        (Y, W) => "D21",
        (Y, U) => "D22",
        (U, X) => "Cu",
        (U, T) => "Dut",
        (U, Y) => "Duy",
        _ => "an undefined block",
    }
}

/// Returns name, row and column of each block, row by row.
pub fn names((rows, columns): Names) -> impl Iterator<Item = (&'static str, Group, Group)> {
    rows.iter().flat_map(move |row| columns.iter().map(move |column| (name(*row, *column), *row, *column)))
}

/// Returns `Theta (I - Dtt Theta)^-1` with the parameter of each channel: the map from zt to wt once the channels are
/// closed.
///
/// Shapes: Dtt is r x r for r channels.
///
/// # Errors
/// Returns [`SystemError::NotWellPosed`] if `I - Dtt Theta` is singular.
pub fn closing(channels: &[usize], dtt: &Mat, theta: &[f64]) -> Result<Mat, SystemError> {
    let delta = diagonal(channels.iter().map(|&c| theta[c]));
    let r = channels.len();
    solve(&(Mat::identity(r, r) - &delta * dtt), &delta)
        .ok_or_else(|| SystemError::NotWellPosed { theta: theta.to_vec() })
}

/// A matrix with named rows and columns.
#[derive(Debug, Clone, PartialEq)]
pub struct Partitioned {
    matrix: Mat,
    rows: &'static [Group],
    columns: &'static [Group],
    sizes: Sizes,
}

/// The sizes of the groups.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[allow(missing_docs)] // The names are those of `Group`.
pub struct Sizes {
    pub x: usize,
    pub t: usize,
    pub w: usize,
    pub u: usize,
    pub z: usize,
    pub y: usize,
}

impl Sizes {
    /// Returns the size of a group.
    pub fn of(mut self, group: Group) -> usize {
        *self.of_mut(group)
    }

    fn of_mut(&mut self, group: Group) -> &mut usize {
        match group {
            X => &mut self.x,
            T => &mut self.t,
            W => &mut self.w,
            U => &mut self.u,
            Z => &mut self.z,
            Y => &mut self.y,
        }
    }
}

/// A block with its row and its column.
pub type NamedBlock = (Group, Group, Mat);

impl Partitioned {
    /// Returns the zero matrix.
    pub fn zeros((rows, columns): Names, sizes: Sizes) -> Self {
        let total = |all: &[Group]| all.iter().map(|s| sizes.of(*s)).sum();
        Self { matrix: Mat::zeros(total(rows), total(columns)), rows, columns, sizes }
    }

    /// Returns a matrix partitioned by `sizes`; its shape must be the sums of the sizes.
    pub fn of(m: Mat, (rows, columns): Names, sizes: Sizes) -> Self {
        let zeros = Self::zeros((rows, columns), sizes);
        assert_eq!(m.shape(), zeros.matrix.shape(), "a matrix and the sizes of its groups");
        Self { matrix: m, ..zeros }
    }

    /// Builds the matrix with the given blocks and zeros elsewhere. The first block with a group gives its size.
    ///
    /// # Errors
    /// Returns [`SystemError::Shape`] for the first block of another shape, with the shape expected.
    pub fn new((rows, columns): Names, blocks: &[NamedBlock]) -> Result<Self, SystemError> {
        let shown = |group: Group| {
            let sizes = |(row, column, m): &NamedBlock| match (*row == group, *column == group) {
                (true, _) => Some(m.nrows()),
                (_, true) => Some(m.ncols()),
                _ => None,
            };
            blocks.iter().find_map(sizes).unwrap_or(0)
        };
        let sizes = Sizes { x: shown(X), t: shown(T), w: shown(W), u: shown(U), z: shown(Z), y: shown(Y) };
        let mut out = Self::zeros((rows, columns), sizes);
        for (row, column, m) in blocks {
            let expected = (sizes.of(*row), sizes.of(*column));
            if m.shape() != expected || !rows.contains(row) || !columns.contains(column) {
                return Err(SystemError::Shape { name: name(*row, *column), found: m.shape(), expected });
            }
            out.set(*row, *column, m);
        }
        Ok(out)
    }

    /// Returns the matrix with the number of channels given by the repetitions of the parameters, if no block has
    /// channels.
    pub(crate) fn with_channels(self, blocks: &[usize]) -> Result<Self, SystemError> {
        let out = if self.sizes.t == 0 { self.resized(T, blocks.iter().sum()) } else { self };
        out.check_channels(blocks).map(|()| out)
    }

    /// Checks that the repetitions of the parameters add up to the channels.
    pub(crate) fn check_channels(&self, blocks: &[usize]) -> Result<(), SystemError> {
        let (total, t) = (blocks.iter().sum(), self.sizes.t);
        let wrong = SystemError::Shape {
            name: "Theta (the sum of the blocks)",
            found: (total, total),
            expected: (t, t),
        };
        if total == t { Ok(()) } else { Err(wrong) }
    }

    /// Returns the matrix with a function applied to each entry.
    pub(crate) fn map(&self, f: impl FnMut(f64) -> f64) -> Self {
        Self { matrix: self.matrix.map(f), ..self.clone() }
    }

    /// Returns the sizes of all groups; 0 for absent ones.
    pub fn sizes(&self) -> Sizes {
        self.sizes
    }

    /// Returns the unpartitioned matrix.
    pub fn matrix(&self) -> &Mat {
        &self.matrix
    }

    fn names(&self) -> impl Iterator<Item = (&'static str, Group, Group)> + use<> {
        names((self.rows, self.columns))
    }

    /// Returns a copy of the block with the given name of equations and files; `None` if there is no such block.
    pub fn named(&self, name: &str) -> Option<Mat> {
        self.names().find(|(of, _, _)| *of == name).map(|(_, row, column)| self.block(row, column))
    }

    fn size(&self, group: Group) -> usize {
        self.sizes.of(group)
    }

    /// Returns the first index of a group; 0 for an absent one.
    fn start(&self, all: &[Group], group: Group) -> usize {
        let index = all.iter().position(|s| *s == group).unwrap_or(0);
        all[..index].iter().map(|s| self.size(*s)).sum()
    }

    /// Returns a copy of a block, size of the row x size of the column; zero for an absent one.
    pub fn block(&self, row: Group, column: Group) -> Mat {
        let shape = (self.size(row), self.size(column));
        if !self.rows.contains(&row) || !self.columns.contains(&column) {
            return Mat::zeros(shape.0, shape.1);
        }
        self.matrix.view((self.start(self.rows, row), self.start(self.columns, column)), shape).into_owned()
    }

    /// Returns a mutable view of a block, which must exist.
    pub fn block_mut(&mut self, row: Group, column: Group) -> DMatrixViewMut<'_, f64> {
        assert!(self.rows.contains(&row) && self.columns.contains(&column), "{}", name(row, column));
        let start = (self.start(self.rows, row), self.start(self.columns, column));
        self.matrix.view_mut(start, (self.size(row), self.size(column)))
    }

    /// Returns a mutable view of the rows of a group.
    pub fn rows_mut(&mut self, row: Group) -> DMatrixViewMut<'_, f64> {
        let (start, columns) = (self.start(self.rows, row), self.matrix.ncols());
        self.matrix.view_mut((start, 0), (self.size(row), columns))
    }

    /// Returns a mutable view of the columns of a group.
    pub fn columns_mut(&mut self, column: Group) -> DMatrixViewMut<'_, f64> {
        let (start, rows) = (self.start(self.columns, column), self.matrix.nrows());
        self.matrix.view_mut((0, start), (rows, self.size(column)))
    }

    fn set(&mut self, row: Group, column: Group, m: &Mat) {
        self.block_mut(row, column).copy_from(m);
    }

    /// Returns several block rows and columns as one matrix.
    pub fn join(&self, rows: &[Group], columns: &[Group]) -> Mat {
        let all: Vec<Vec<Mat>> =
            rows.iter().map(|row| columns.iter().map(|column| self.block(*row, *column)).collect()).collect();
        let lines: Vec<Vec<&Mat>> = all.iter().map(|line| line.iter().collect()).collect();
        block(&lines.iter().map(Vec::as_slice).collect::<Vec<_>>())
    }

    /// Returns the submatrix of some block rows and columns.
    pub fn cut(&self, (rows, columns): Names) -> Self {
        let mut sizes = self.sizes;
        for gone in [X, T, W, U, Z, Y].into_iter().filter(|s| !rows.contains(s) && !columns.contains(s)) {
            *sizes.of_mut(gone) = 0;
        }
        Self::of(self.join(rows, columns), (rows, columns), sizes)
    }

    /// Returns the matrix with another size of a group: the first rows and columns are kept, new ones are zero.
    pub fn resized(&self, group: Group, size: usize) -> Self {
        let mut sizes = self.sizes;
        *sizes.of_mut(group) = size;
        let mut out = Self::zeros((self.rows, self.columns), sizes);
        for (_, row, column) in self.names() {
            let m = self.block(row, column);
            let mut to = out.block_mut(row, column);
            let (rows, columns) = (m.nrows().min(to.nrows()), m.ncols().min(to.ncols()));
            to.view_mut((0, 0), (rows, columns)).copy_from(&m.view((0, 0), (rows, columns)));
        }
        out
    }

    /// Returns the same matrix, partitioned by other sizes.
    pub fn repartitioned(&self, sizes: Sizes) -> Self {
        Self::of(self.matrix.clone(), (self.rows, self.columns), sizes)
    }

    /// Returns the transposed matrix with w and z, and u and y, exchanged: the dual of a plant or a loop.
    pub fn dual(&self) -> Self {
        let other = |group| match group {
            W => Z,
            Z => W,
            U => Y,
            Y => U,
            same => same,
        };
        let s = self.sizes;
        let sizes = Sizes { w: s.z, z: s.w, u: s.y, y: s.u, ..s };
        let mut out = Self::zeros((self.rows, self.columns), sizes);
        for (_, row, column) in self.names() {
            out.set(row, column, &self.block(other(column), other(row)).transpose());
        }
        out
    }

    /// Returns the matrix with the rows of some groups multiplied from the left and the columns of some from the right:
    /// `L_row M R_column` for each block.
    pub fn transformed(&self, left: &[(Group, &Mat)], right: &[(Group, &Mat)]) -> Self {
        let of =
            |all: &[(Group, &Mat)], group| all.iter().find(|(s, _)| *s == group).map(|(_, m)| (*m).clone());
        let mut out = self.clone();
        for (_, row, column) in self.names() {
            let mut m = self.block(row, column);
            if let Some(left) = of(left, row) {
                m = left * m;
            }
            if let Some(right) = of(right, column) {
                m *= right;
            }
            out.set(row, column, &m);
        }
        out
    }

    /// Returns the matrix in the coordinates `x = T x~`, `zt = tau zt~`, `wt = tau wt~`, each given with its inverse.
    pub fn in_coordinates(&self, (t, t_inverse): (&Mat, &Mat), (tau, tau_inverse): (&Mat, &Mat)) -> Self {
        self.transformed(&[(X, t_inverse), (T, tau_inverse)], &[(X, t), (T, tau)])
    }

    /// Returns the matrix with w and z in units in which a gain of `gamma` is 1.
    pub fn in_units_of(&self, gamma: f64) -> Self {
        let root = gamma.sqrt();
        let mut out = self.clone();
        for (_, row, column) in self.names() {
            match (row == Z, column == W) {
                (true, true) => out.block_mut(row, column).unscale_mut(gamma),
                (true, false) | (false, true) => out.block_mut(row, column).unscale_mut(root),
                (false, false) => {}
            }
        }
        out
    }

    /// Returns the matrix with the parameter channels closed at a parameter value,
    /// `M + M_t Theta (I - Dtt Theta)^-1 M^t` for each block: rows and columns T are empty.
    ///
    /// # Errors
    /// Returns [`SystemError::NotWellPosed`] if `I - Dtt Theta` is singular.
    pub fn frozen(&self, channels: &[usize], theta: &[f64]) -> Result<Self, SystemError> {
        let closing = closing(channels, &self.block(T, T), theta)?;
        let mut out = self.resized(T, 0);
        for (_, row, column) in self.names().filter(|(_, row, column)| *row != T && *column != T) {
            let through = self.block(row, T) * &closing * self.block(T, column);
            out.set(row, column, &(self.block(row, column) + through));
        }
        Ok(out)
    }

    /// Returns the star product of a plant (rows x, t, z, y; columns x, t, w, u) and a controller with inputs y and
    /// outputs u. The plant's states and channels come first. The direct path from u to y is taken as zero.
    ///
    /// ```text
    /// u = [Duy C2, Cu | Duy D2t, Dut | Duy D21] (x, xk | wt, wk | w)
    /// ```
    pub fn closed_by(&self, k: &Self) -> Self {
        let (p, s, sk) = (self, self.sizes, k.sizes);
        let sizes = Sizes { x: s.x + sk.x, t: s.t + sk.t, w: s.w, z: s.z, u: 0, y: 0 };
        let mut out = Self::zeros(LOOP, sizes);
        let concatenated = |one: &Mat, other: &Mat| block(&[&[one, other]]);
        for column in [X, T, W] {
            let to_plant = |m: &Mat| concatenated(m, &Mat::zeros(m.nrows(), sk.of(column)));
            let to_controller = |m: &Mat| concatenated(&Mat::zeros(m.nrows(), s.of(column)), m);
            let y = p.block(Y, column);
            let u = concatenated(&(k.block(U, Y) * &y), &k.block(U, column));
            let y = to_plant(&y);
            for row in [X, T, Z] {
                let of_plant = to_plant(&p.block(row, column)) + p.block(row, U) * &u;
                let of_controller = k.block(row, Y) * &y + to_controller(&k.block(row, column));
                out.set(row, column, &block(&[&[&of_plant], &[&of_controller]]));
            }
        }
        out
    }

    /// Returns the system from some inputs to some outputs; the parameter channels stay open unless they are included.
    pub fn state_space(&self, outputs: &[Group], inputs: &[Group]) -> StateSpace {
        StateSpace {
            a: self.block(X, X),
            b: self.join(&[X], inputs),
            c: self.join(outputs, &[X]),
            d: self.join(outputs, inputs),
        }
    }
}

/// Implements for a type with the field `parts` a method for each block: name, row, column.
macro_rules! named_blocks {
    ($of:ty: $($block:ident $row:ident $column:ident),* $(,)?) => {
        impl $of {
            $(
                #[doc = concat!("A copy of the block from ", stringify!($column), " to ", stringify!($row), ".")]
                pub fn $block(&self) -> $crate::matrix::Mat {
                    use $crate::system::partition::Group;
                    self.parts.block(Group::$row, Group::$column)
                }
            )*
        }
    };
}
pub(crate) use named_blocks;

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dmatrix;

    /// Returns the matrix whose entry (i, j) is 10 i + j, both from 1.
    fn counted(sizes: Sizes) -> Partitioned {
        let zeros = Partitioned::zeros(PLANT, sizes);
        let (rows, columns) = zeros.matrix.shape();
        let counted = Mat::from_fn(rows, columns, |i, j| (10 * (i + 1) + j + 1) as f64);
        Partitioned::of(counted, PLANT, sizes)
    }

    const SIZES: Sizes = Sizes { x: 1, t: 2, w: 1, u: 1, z: 1, y: 1 };

    #[test]
    fn blocks_are_at_the_positions_of_their_names() {
        let p = counted(SIZES);
        assert_eq!(p.named("Dtt"), Some(dmatrix![22.0, 23.0; 32.0, 33.0]));
        assert_eq!(p.named("D12"), Some(dmatrix![45.0]));
        assert_eq!(p.named("Duy"), None);
        assert_eq!(p.join(&[Y, X], &[U, X]), dmatrix![55.0, 51.0; 15.0, 11.0]);
        assert_eq!(p.cut(LOOP).matrix(), &p.matrix().view((0, 0), (4, 4)).into_owned());
        let blocks: Vec<NamedBlock> =
            p.names().map(|(_, row, column)| (row, column, p.block(row, column))).collect();
        assert_eq!(Partitioned::new(PLANT, &blocks).unwrap(), p);
    }

    #[test]
    fn a_block_of_the_wrong_shape_is_reported() {
        let blocks = [(X, X, Mat::zeros(2, 2)), (X, W, Mat::zeros(2, 1)), (Z, W, Mat::zeros(1, 2))];
        let wrong = Partitioned::new(PLANT, &blocks).unwrap_err();
        assert_eq!(wrong, SystemError::Shape { name: "D11", found: (1, 2), expected: (1, 1) });
        let wrong = Partitioned::new(LOOP, &[(Y, W, Mat::zeros(1, 1))]).unwrap_err();
        assert!(matches!(wrong, SystemError::Shape { name: "D21", .. }));
    }

    #[test]
    fn resizing_keeps_the_blocks() {
        let p = counted(SIZES);
        let wide = p.resized(T, 3);
        assert_eq!(wide.block(T, X), dmatrix![21.0; 31.0; 0.0]);
        assert_eq!(wide.resized(T, 2), p);
        let other = p.repartitioned(Sizes { t: 1, w: 2, z: 2, ..SIZES });
        assert_eq!((other.block(Z, W), other.matrix()), (dmatrix![33.0, 34.0; 43.0, 44.0], p.matrix()));
    }

    #[test]
    fn the_dual_of_the_dual_is_the_primal() {
        let p = counted(Sizes { z: 3, y: 2, ..SIZES });
        assert_eq!(p.dual().dual(), p);
        assert_eq!(
            (p.dual().block(X, W), p.dual().block(Y, Z)),
            (p.block(Z, X).transpose(), Mat::zeros(1, 1))
        );
    }
}
