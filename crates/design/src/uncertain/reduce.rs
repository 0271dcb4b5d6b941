//! The smallest LFT among those that an exact projection reaches: unreachable and unobservable channels go.
//!
//! A channel direction that no input reaches, through other channels or not, or that no output sees, carries nothing.
//! Each parameter keeps its own subspace, so the structure `blkdiag(delta_i I)` stays. The result is minimal when the
//! parameters are not assumed to commute.
//!
//! Source: C. L. Beck, J. Doyle, K. Glover, "Model reduction of multidimensional and uncertain systems", IEEE Trans.
//! Automatic Control 41(10), 1996; C. L. Beck, R. D'Andrea, Automatica 40, 2004 (the subspaces).

use lpv::lft::Lft;
use lpv::matrix::{Mat, block, svd};

/// Directions smaller than this, relative to the largest of their parameter, are rounding.
const ROUNDING: f64 = 1e-10;

/// The same LFT without unreachable and unobservable channels, its channels sorted by parameter and balanced.
pub fn minimal(lft: &Lft) -> Lft {
    let whole = lft.in_order();
    let reached = project(&whole, &sizes(&whole));
    let seen = transpose(&project(&transpose(&reached), &sizes(&transpose(&whole))));
    balanced(&seen)
}

/// The transposed LFT.
fn transpose(lft: &Lft) -> Lft {
    Lft {
        constant: lft.constant.transpose(),
        left: lft.right.transpose(),
        inner: lft.inner.transpose(),
        right: lft.left.transpose(),
        channels: lft.channels.clone(),
    }
}

/// Each parameter of a sorted LFT, its first channel and the number of its channels.
pub fn runs(channels: &[usize]) -> Vec<(usize, usize, usize)> {
    let mut out: Vec<(usize, usize, usize)> = Vec::new();
    for (place, &parameter) in channels.iter().enumerate() {
        match out.last_mut() {
            Some((last, _, count)) if *last == parameter => *count += 1,
            _ => out.push((parameter, place, 1)),
        }
    }
    out
}

/// The size of what goes into the channels of each parameter of a sorted LFT: what is rounding beside it is nothing.
fn sizes(lft: &Lft) -> Vec<(usize, f64)> {
    let size = |first, n| lft.right.rows(first, n).norm().max(lft.inner.rows(first, n).norm());
    runs(&lft.channels).into_iter().map(|(parameter, first, n)| (parameter, size(first, n))).collect()
}

/// Restricts the channels of a sorted LFT to what its inputs reach, beside the sizes of its parameters.
fn project(lft: &Lft, sizes: &[(usize, f64)]) -> Lft {
    let runs = runs(&lft.channels);
    let size = |parameter: usize| sizes.iter().find(|(p, _)| *p == parameter).map_or(0.0, |(_, size)| *size);
    let mut bases: Vec<Mat> = runs
        .iter()
        .map(|&(parameter, first, n)| range_beside(&lft.right.rows(first, n).into_owned(), size(parameter)))
        .collect();
    loop {
        let next: Vec<Mat> = runs
            .iter()
            .map(|&(parameter, first, n)| {
                let mut reached = lft.right.rows(first, n).into_owned();
                for (basis, &(_, from, m)) in bases.iter().zip(&runs) {
                    let moved = lft.inner.view((first, from), (n, m)) * basis;
                    reached = block(&[&[&reached, &moved]]);
                }
                range_beside(&reached, size(parameter))
            })
            .collect();
        let settled = next.iter().zip(&bases).all(|(new, old)| new.ncols() == old.ncols());
        bases = next;
        if settled {
            break;
        }
    }
    let whole = lpv::matrix::diagonal_blocks(&bases.iter().collect::<Vec<_>>());
    let kept = runs.iter().zip(&bases);
    let channels = kept.flat_map(|(&(p, _, _), basis)| std::iter::repeat_n(p, basis.ncols())).collect();
    lft.transformed(&whole.transpose(), &whole, channels)
}

/// An orthonormal basis of the range of a matrix, where what is rounding beside `size` is nothing.
pub fn range_beside(a: &Mat, size: f64) -> Mat {
    let decomposition = svd(a);
    let largest = decomposition.s.first().copied().unwrap_or(0.0).max(size);
    let rank = decomposition.s.iter().filter(|s| **s > ROUNDING * largest).count();
    decomposition.u.columns(0, rank).into_owned()
}

/// Scales the channels of each parameter so that what goes in and what comes out is of one size.
fn balanced(lft: &Lft) -> Lft {
    let mut scale = vec![1.0; lft.size()];
    for (_, first, n) in runs(&lft.channels) {
        let (into, out) = (lft.right.rows(first, n).norm(), lft.left.columns(first, n).norm());
        if into > 0.0 && out > 0.0 {
            scale[first..first + n].fill((into / out).sqrt());
        }
    }
    let up = Mat::from_diagonal(&nalgebra::DVector::from_vec(scale.clone()));
    let down =
        Mat::from_diagonal(&nalgebra::DVector::from_iterator(scale.len(), scale.iter().map(|s| 1.0 / s)));
    lft.transformed(&down, &up, lft.channels.clone())
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dmatrix;

    /// `a + b` with `a = 1 + theta_0`, written so that `a` stands three times: one channel each is enough.
    #[test]
    fn a_parameter_written_three_times_is_kept_once() {
        let (a, b) = (Lft::parameter(0, 1.0, 1.0), Lft::parameter(1, 2.0, 0.5));
        let minus = Lft::constant(dmatrix![-1.0]);
        let clumsy = a.add(&b).add(&a).add(&minus.multiply(&a));
        assert_eq!(clumsy.size(), 4);
        let small = minimal(&clumsy);
        assert_eq!(small.channels, vec![0, 1]);
        for theta in [[0.3, -0.8], [-1.0, 1.0]] {
            let (found, wanted) = (small.evaluate(&theta).unwrap(), clumsy.evaluate(&theta).unwrap());
            assert!((found - wanted).amax() < 1e-14);
        }
    }

    /// What no output sees goes, too, and a parameter that cancels goes altogether.
    #[test]
    fn what_cancels_is_gone() {
        let (a, b) = (Lft::parameter(0, 1.0, 1.0), Lft::parameter(1, 2.0, 0.5));
        let minus = Lft::constant(dmatrix![-1.0]);
        let nothing = a.multiply(&b).add(&minus.multiply(&a.multiply(&b)));
        assert_eq!(minimal(&nothing).size(), 0);
        let product = minimal(&a.multiply(&b));
        assert_eq!(product.channels, vec![0, 1]);
        // theta_0 theta_0 needs it twice.
        assert_eq!(minimal(&a.multiply(&a)).channels, vec![0, 0]);
    }
}
