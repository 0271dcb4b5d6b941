//! Smallest LFT obtainable by exact projection: uncontrollable and unobservable channels are removed.
//!
//! A channel direction without effect, because no input reaches it directly or through other channels, or because no
//! output depends on it, is removed. Each parameter has its own subspace, so the structure `blkdiag(delta_i I)` is
//! preserved. The result is minimal if the parameters are not assumed to commute.
//!
//! Source: C. L. Beck, J. Doyle, K. Glover, "Model reduction of multidimensional and uncertain systems", IEEE Trans.
//! Automatic Control 41(10), 1996; C. L. Beck, R. D'Andrea, Automatica 40, 2004 (the subspaces).

use squid_lpv::lft::Lft;
use squid_lpv::matrix::{Mat, block, svd};

/// Size, relative to the largest of their parameter, below which directions are rounding.
const ROUNDING: f64 = 1e-10;

/// Removes uncontrollable and unobservable channels of an LFT; the others are sorted by parameter and balanced.
pub fn minimal(lft: &Lft) -> Lft {
    let sorted = lft.in_order();
    let controllable = project(&sorted, &sizes(&sorted));
    let observable = transpose(&project(&transpose(&controllable), &sizes(&transpose(&sorted))));
    balanced(&observable)
}

/// Transposed LFT.
fn transpose(lft: &Lft) -> Lft {
    Lft {
        constant: lft.constant.transpose(),
        left: lft.right.transpose(),
        inner: lft.inner.transpose(),
        right: lft.left.transpose(),
        channels: lft.channels.clone(),
    }
}

/// Returns each parameter of a sorted LFT, with its first channel and its number of channels.
pub fn runs(channels: &[usize]) -> Vec<(usize, usize, usize)> {
    let mut out: Vec<(usize, usize, usize)> = Vec::new();
    for (index, &parameter) in channels.iter().enumerate() {
        match out.last_mut() {
            Some((last, _, count)) if *last == parameter => *count += 1,
            _ => out.push((parameter, index, 1)),
        }
    }
    out
}

/// Norm of the channel inputs of each parameter of a sorted LFT, as a scale for rounding.
fn sizes(lft: &Lft) -> Vec<(usize, f64)> {
    let size = |first, n| lft.right.rows(first, n).norm().max(lft.inner.rows(first, n).norm());
    runs(&lft.channels).into_iter().map(|(parameter, first, n)| (parameter, size(first, n))).collect()
}

/// Restricts the channels of a sorted LFT to their controllable subspace; `sizes` are the scales of the parameters.
fn project(lft: &Lft, sizes: &[(usize, f64)]) -> Lft {
    let runs = runs(&lft.channels);
    let size = |parameter: usize| sizes.iter().find(|(p, _)| *p == parameter).map_or(0.0, |(_, size)| *size);
    let mut bases: Vec<Mat> = runs
        .iter()
        .map(|&(parameter, first, n)| range_basis(&lft.right.rows(first, n).into_owned(), size(parameter)))
        .collect();
    loop {
        let next: Vec<Mat> = runs
            .iter()
            .map(|&(parameter, first, n)| {
                let mut images = lft.right.rows(first, n).into_owned();
                for (basis, &(_, from, m)) in bases.iter().zip(&runs) {
                    let moved = lft.inner.view((first, from), (n, m)) * basis;
                    images = block(&[&[&images, &moved]]);
                }
                range_basis(&images, size(parameter))
            })
            .collect();
        let converged = next.iter().zip(&bases).all(|(new, old)| new.ncols() == old.ncols());
        bases = next;
        if converged {
            break;
        }
    }
    let basis = squid_lpv::matrix::diagonal_blocks(&bases.iter().collect::<Vec<_>>());
    let retained = runs.iter().zip(&bases);
    let channels = retained.flat_map(|(&(p, _, _), own)| std::iter::repeat_n(p, own.ncols())).collect();
    lft.transformed(&basis.transpose(), &basis, channels)
}

/// Returns an orthonormal basis of the range of a matrix; singular values that are rounding relative to `size` are
/// zero.
pub fn range_basis(a: &Mat, size: f64) -> Mat {
    let decomposition = svd(a);
    let largest = decomposition.s.first().copied().unwrap_or(0.0).max(size);
    let rank = decomposition.s.iter().filter(|s| **s > ROUNDING * largest).count();
    decomposition.u.columns(0, rank).into_owned()
}

/// Scales the channels of each parameter to inputs and outputs of equal norm.
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

    /// One channel each is sufficient for `a + b` with `a = 1 + theta_0`, written with three copies of `a`.
    #[test]
    fn keeps_one_channel_of_repeated_parameter() {
        let (a, b) = (Lft::parameter(0, 1.0, 1.0), Lft::parameter(1, 2.0, 0.5));
        let minus = Lft::constant(dmatrix![-1.0]);
        let redundant = a.add(&b).add(&a).add(&minus.multiply(&a));
        assert_eq!(redundant.size(), 4);
        let small = minimal(&redundant);
        assert_eq!(small.channels, vec![0, 1]);
        for theta in [[0.3, -0.8], [-1.0, 1.0]] {
            let (found, expected) = (small.evaluate(&theta).unwrap(), redundant.evaluate(&theta).unwrap());
            assert!((found - expected).amax() < 1e-14);
        }
    }

    /// Unobservable channels and parameters that cancel are removed.
    #[test]
    fn removes_cancelling_parameters() {
        let (a, b) = (Lft::parameter(0, 1.0, 1.0), Lft::parameter(1, 2.0, 0.5));
        let minus = Lft::constant(dmatrix![-1.0]);
        let nothing = a.multiply(&b).add(&minus.multiply(&a.multiply(&b)));
        assert_eq!(minimal(&nothing).size(), 0);
        let product = minimal(&a.multiply(&b));
        assert_eq!(product.channels, vec![0, 1]);
        // theta_0 theta_0 needs two channels.
        assert_eq!(minimal(&a.multiply(&a)).channels, vec![0, 0]);
    }
}
