//! Units of the coupling terms of each row, and matrices that bound others.

use nalgebra::{Complex, DMatrix};
use squid_lpv::matrix::{Mat, symmetric_function};

/// Frequency response at one frequency.
pub type Response = DMatrix<Complex<f64>>;

/// Number of times that the units are balanced, and the range of units.
const ROUNDS: usize = 3;
const RANGE: f64 = 1e3;

/// Returns units s of the rows of two axes that make the gains of the loop small: in and out of each row they are
/// equal.
///
/// `added[i][j]` are matrices from \[x; T\] of axis j to \[x'; y\] of axis i; `responses[j]` those of axis j from \[x';
/// y\] to \[x; T\] at some frequencies. No unit is below a thousandth of the largest. After E. E. Osborne, On
/// pre-conditioning of matrices, J. ACM 7(4), 1960.
pub fn units(added: [[&[Mat]; 2]; 2], responses: [&[Response]; 2], rows: [usize; 2]) -> [Vec<f64>; 2] {
    let mut units = rows.map(|rows| vec![1.0; rows]);
    for _ in 0..ROUNDS {
        for i in [0, 1] {
            let (mut received, mut emitted) = (vec![0.0_f64; rows[i]], vec![0.0_f64; rows[i]]);
            for j in [0, 1] {
                for response in responses[j] {
                    for matrix in added[i][j] {
                        let through = complex(matrix) * response;
                        for (row, most) in received.iter_mut().enumerate() {
                            let size = |k: usize| (through[(row, k)] * units[j][k]).norm_sqr();
                            *most = most.max((0..rows[j]).map(size).sum::<f64>().sqrt());
                        }
                    }
                }
                for response in responses[i] {
                    for matrix in added[j][i] {
                        let through = complex(matrix) * response;
                        for (column, most) in emitted.iter_mut().enumerate() {
                            let by = |k: usize| (through[(k, column)] / units[j][k]).norm_sqr();
                            *most = most.max((0..rows[j]).map(by).sum::<f64>().sqrt());
                        }
                    }
                }
            }
            let largest = emitted.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
            let balanced = |row: usize| (received[row] / emitted[row].max(largest / RANGE)).sqrt();
            let most = (0..rows[i]).map(balanced).fold(f64::MIN_POSITIVE, f64::max);
            units[i] = (0..rows[i]).map(|row| balanced(row).max(most / RANGE)).collect();
        }
    }
    units
}

/// Converts a real matrix to a complex one.
pub fn complex(m: &Mat) -> Response {
    m.map(|entry| Complex::new(entry, 0.0))
}

/// Relative rounding.
const ROUNDING: f64 = 1e-13;

/// Least effect of a column of F in any direction, relative to its length.
const FLOOR: f64 = 0.03;

/// Returns F with `|D v|^2 <= |F v|^2 - FLOOR^2 sum |d_j v_j|^2` for every v and each of some matrices D with `columns`
/// columns, d_j the length of column j of a cover without the sum: a direction in which the effects of the columns
/// cancel in each D is bounded by a fraction of the effect of each column alone.
pub fn cover(matrices: &[Mat], columns: usize) -> Mat {
    let mut square = Mat::zeros(columns, columns);
    for matrix in matrices {
        let rest = matrix.transpose() * matrix - &square;
        square += symmetric_function(&rest, |value| value.max(0.0));
    }
    square += Mat::from_diagonal(&square.diagonal()) * FLOOR.powi(2);
    let largest = square.diagonal().max();
    symmetric_function(&square, |value| value.max(ROUNDING * largest).sqrt() * (1.0 + ROUNDING))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn cover_is_no_shorter_than_covered_matrices(
            entries in prop::collection::vec(-1.0..1.0f64, 36),
            scale in prop::array::uniform4(-3..=3i32),
            v in prop::collection::vec(-1.0..1.0f64, 4),
        ) {
            let scale = scale.map(|power| 10f64.powi(power));
            let matrices: Vec<Mat> =
                entries.chunks(12).map(|part| Mat::from_fn(3, 4, |i, j| part[4 * i + j] * scale[j])).collect();
            let v = nalgebra::DVector::from_fn(4, |j, _| v[j] / scale[j]);
            let covered = (cover(&matrices, 4) * &v).norm();
            let longest = matrices.iter().map(|m| (m * &v).norm()).fold(0.0, f64::max);
            prop_assert!(covered >= longest * (1.0 - 1e-6), "{covered} {longest}");
        }
    }

    /// One matrix is covered by one of its own size, except for the floor of each column.
    #[test]
    fn cover_of_one_matrix_has_its_size() {
        let one = Mat::from_row_slice(2, 3, &[3.0, 0.0, 4.0, 0.0, 0.0, 1.0]);
        let found = cover(std::slice::from_ref(&one), 3);
        let square = one.transpose() * &one;
        let rest =
            found.transpose() * &found - &square - Mat::from_diagonal(&square.diagonal()) * FLOOR.powi(2);
        assert!(rest.amax() < 1e-10, "{found}");
    }

    /// Two loops of one state, 1/(s + 1), with D_12 = 100 and D_21 = 1/100: in balanced units both gains are 1.
    #[test]
    fn units_make_gains_equal() {
        let (large, small) = ([Mat::from_element(1, 1, 100.0)], [Mat::from_element(1, 1, 0.01)]);
        let response = [DMatrix::from_element(1, 1, Complex::new(1.0, 0.0))];
        let [one, other] = units([[&[], &large], [&small, &[]]], [&response, &response], [1, 1]);
        assert!((one[0] / other[0] / 100.0 - 1.0).abs() < 1e-12, "{one:?} {other:?}");
    }
}
