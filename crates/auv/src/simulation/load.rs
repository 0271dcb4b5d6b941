//! A load from outside.

use crate::scalar::Scalar;

/// A force and a moment \[X Y Z K M N\] along the body and about its origin \[N, N m\]: forward, to starboard, down;
/// starboard down, bow up, bow to starboard. A vehicle in the vertical plane feels X, Z and M.
pub type Load<D = f64> = [D; 6];

/// X, Z and M.
pub(crate) fn in_plane<D: Scalar>([x, _, z, _, m, _]: Load<D>) -> [D; 3] {
    [x, z, m]
}

/// Y, K and N.
pub(crate) fn sideways<D: Scalar>([_, y, _, k, _, n]: Load<D>) -> [D; 3] {
    [y, k, n]
}

/// The sum of two loads.
pub(crate) fn sum<D: Scalar>(one: Load<D>, other: Load<D>) -> Load<D> {
    std::array::from_fn(|i| one[i] + other[i])
}
