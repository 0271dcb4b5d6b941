//! Gaussian elimination with partial pivoting, in place.

/// Solves `M x = b`; `matrix` (row by row) is overwritten, `b` becomes `x`.
///
/// # Errors
/// The size of the largest pivot that could be found where it is below `n eps max|M|`: M is singular to working
/// precision.
///
/// Source: Golub and Van Loan, Matrix Computations, 4th ed., 2013, algorithm 3.4.1.
pub(crate) fn solve_in_place(matrix: &mut [f64], b: &mut [f64]) -> Result<(), f64> {
    let n = b.len();
    debug_assert_eq!(matrix.len(), n * n);
    let largest = matrix.iter().fold(0.0f64, |largest, entry| largest.max(entry.abs()));
    let threshold = n as f64 * f64::EPSILON * largest;
    for column in 0..n {
        let mut best = column;
        for row in column + 1..n {
            if matrix[row * n + column].abs() > matrix[best * n + column].abs() {
                best = row;
            }
        }
        let pivot = matrix[best * n + column];
        if pivot.is_nan() || pivot.abs() <= threshold {
            return Err(pivot);
        }
        if best != column {
            for k in column..n {
                matrix.swap(column * n + k, best * n + k);
            }
            b.swap(column, best);
        }
        for row in column + 1..n {
            let factor = matrix[row * n + column] / pivot;
            for k in column + 1..n {
                matrix[row * n + k] -= factor * matrix[column * n + k];
            }
            b[row] -= factor * b[column];
        }
    }
    for row in (0..n).rev() {
        let known: f64 = (row + 1..n).map(|k| matrix[row * n + k] * b[k]).sum();
        b[row] = (b[row] - known) / matrix[row * n + row];
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_with_a_zero_on_the_diagonal() {
        let mut b = [5.0, 3.0, 2.0];
        solve_in_place(&mut [0.0, 2.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 2.0], &mut b).unwrap();
        assert_eq!(b, [3.0, 2.0, 1.0]);
    }

    #[test]
    fn finds_singular_matrices() {
        assert!(solve_in_place(&mut [1.0, 2.0, 2.0, 4.0], &mut [1.0, 1.0]).is_err());
        assert!(solve_in_place(&mut [0.0], &mut [1.0]).is_err());
        assert!(solve_in_place(&mut [f64::NAN], &mut [1.0]).is_err());
        assert!(solve_in_place(&mut [], &mut []).is_ok());
    }
}
