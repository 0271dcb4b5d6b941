//! Gaussian elimination with partial pivoting, in place.

/// Solves `M x = b`; `matrix` (row by row) is overwritten, `b` becomes `x`.
///
/// # Errors
/// The largest available pivot, if its magnitude is at most `n eps max|M|`: M is singular to working precision.
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
        let (above, below) = matrix.split_at_mut((column + 1) * n);
        let (diagonal, pivot_row) = above[column * n + column..].split_at_mut(1);
        // For the back substitution: one division per column instead of one per row.
        let reciprocal = 1.0 / pivot;
        diagonal[0] = reciprocal;
        let (solved, rest) = b.split_at_mut(column + 1);
        for (row, entry) in below.chunks_exact_mut(n).zip(rest) {
            let factor = row[column] * reciprocal;
            for (to, from) in row[column + 1..].iter_mut().zip(&*pivot_row) {
                *to -= factor * from;
            }
            *entry -= factor * solved[column];
        }
    }
    for row in (0..n).rev() {
        let (own, solved) = b.split_at_mut(row + 1);
        let entries = &matrix[row * n + row..(row + 1) * n];
        let known: f64 = entries[1..].iter().zip(solved).map(|(entry, x)| entry * *x).sum();
        own[row] = (own[row] - known) * entries[0];
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
