//! External load.

use crate::scalar::Scalar;

/// Force and moment \[X Y Z K M N\] in body axes and about the origin \[N, N m\]: forward, to starboard, down;
/// starboard down, bow up, bow to starboard. Only X, Z and M act on a vehicle in the vertical plane.
pub type Load<D = f64> = [D; 6];

/// Returns X, Z and M.
pub(crate) fn in_plane<D: Scalar>([x, _, z, _, m, _]: Load<D>) -> [D; 3] {
    [x, z, m]
}

/// Returns Y, K and N.
pub(crate) fn out_of_plane<D: Scalar>([_, y, _, k, _, n]: Load<D>) -> [D; 3] {
    [y, k, n]
}

/// Returns the sum of two loads.
pub(crate) fn sum<D: Scalar>(one: Load<D>, other: Load<D>) -> Load<D> {
    std::array::from_fn(|i| one[i] + other[i])
}
