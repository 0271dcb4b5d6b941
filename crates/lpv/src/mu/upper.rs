//! An upper bound on mu of a matrix, with the D-G scalings that prove it.
//!
//! The least beta for which scalings exist is found by the method of centres, with a moving lambda = beta^2; the bound
//! is that of the scalings found, plus an allowance for rounding.

pub(super) mod balance;
pub(super) mod centre;
mod joined;
pub(super) mod product;
mod scaling;

pub use scaling::DgScalings;

use super::CMat;
use super::components::{Component, of_matrices};
use super::structure::{Structure, StructureError};
use crate::matrix::complex_singular_values;
use balance::Balance;
use centre::{Centre, ZERO_MU, least_lambda};
use joined::weighted;
use scaling::Family;

/// A bound with the scalings that prove it.
#[derive(Debug, Clone, PartialEq)]
pub struct UpperBound {
    /// Upper bound of mu.
    pub value: f64,
    /// Scalings with `M* D M + j (G M - M* G) <= value^2 D`, by eigenvalues.
    pub scalings: DgScalings,
    /// Scalings to start from for a similar matrix.
    pub start: DgScalings,
    /// An estimate of the relative excess of the bound over the least that D-G scalings allow; infinite if not
    /// computed.
    pub gap: f64,
}

/// The relative tolerance of the bound.
pub const BOUND_TOLERANCE: f64 = 2e-5;

/// Options of the bound.
#[derive(Debug, Clone, Copy)]
pub struct UpperBoundOptions<'a> {
    /// The level at which the search ends: if scalings prove it, those with the largest margin there are computed.
    pub level: f64,
    /// The relative tolerance of the bound.
    pub tight: f64,
    /// The `start` of the bound of a similar matrix.
    pub from: Option<&'a DgScalings>,
}

impl Default for UpperBoundOptions<'_> {
    fn default() -> Self {
        Self { level: 0.0, tight: BOUND_TOLERANCE, from: None }
    }
}

/// Bounds mu of M.
///
/// ```text
/// M* D M + j (G M - M* G) <= beta^2 D,   D > 0,   G = G*   of the structure:   mu(M) <= beta
/// ```
///
/// Source: M. K. H. Fan, A. L. Tits, J. C. Doyle, IEEE Trans. Automatic Control 36(1), 1991.
///
/// # Errors
/// Returns [`StructureError`] if M does not fit the structure.
pub fn upper_bound(m: &CMat, structure: &Structure) -> Result<UpperBound, StructureError> {
    upper_bound_with(m, structure, UpperBoundOptions::default())
}

/// Returns a bound without a search, for a matrix of that Frobenius norm.
fn unscaled(structure: &Structure, norm: f64) -> UpperBound {
    let family = Family::new(structure);
    let gap = if norm > 0.0 { f64::INFINITY } else { 0.0 };
    let scalings = family.values(&family.identity());
    UpperBound { value: norm, start: scalings.clone(), scalings, gap }
}

/// Bounds mu of M with options.
///
/// # Errors
/// Errors of [`common_bound`].
pub fn upper_bound_with(
    m: &CMat,
    structure: &Structure,
    options: UpperBoundOptions,
) -> Result<UpperBound, StructureError> {
    common_bound(std::slice::from_ref(m), structure, options)
}

/// Bounds mu of several matrices by the same scalings.
///
/// # Errors
/// Returns [`StructureError`] if a matrix does not fit the structure.
pub fn common_bound(
    all: &[CMat],
    structure: &Structure,
    options: UpperBoundOptions,
) -> Result<UpperBound, StructureError> {
    all.iter().try_for_each(|m| structure.check(m))?;
    let parts = of_matrices(all, structure);
    Ok(if parts.len() > 1 { joined(all, structure, &parts, options) } else { found(all, structure, options) })
}

/// Bounds matrices with several components: each is bounded separately, and the paths from one to another are made
/// small by the weights of their scalings.
fn joined(
    all: &[CMat],
    structure: &Structure,
    parts: &[Component],
    options: UpperBoundOptions,
) -> UpperBound {
    let each: Vec<UpperBound> = parts
        .iter()
        .map(|part| {
            let matrices: Vec<CMat> = all.iter().map(|m| part.part(m)).collect();
            let from = options.from.map(|known| known.cut(&part.z, &part.w));
            found(&matrices, &part.structure, UpperBoundOptions { from: from.as_ref(), ..options })
        })
        .collect();
    let entry = all.iter().map(|m| m.camax()).fold(0.0, f64::max);
    if entry == 0.0 {
        return unscaled(structure, 0.0);
    }
    // Entries of about one, as in `found`.
    let units: Vec<CMat> = all.iter().map(|m| m.unscale(entry)).collect();
    let one = vec![1.0; structure.rows().max(structure.cols())];
    let largest = each.iter().map(|bound| bound.value / entry).fold(0.0, f64::max);
    let gap = each.iter().map(|bound| bound.gap).fold(0.0, f64::max);
    let mut best = unscaled(structure, f64::INFINITY);
    for share in COUPLINGS {
        let scalings_of = |of: fn(&UpperBound) -> &DgScalings| {
            let scalings: Vec<_> = each.iter().map(|bound| of(bound).redone(&one, &one, entry)).collect();
            weighted(&units, structure, parts, &scalings, share, largest.max(ZERO_MU))
        };
        let scalings = scalings_of(|bound| &bound.scalings);
        let Some(lambda) = least_lambda(&units, &scalings) else { continue };
        let value = lambda.max(0.0).sqrt();
        if value < best.value {
            // The contribution of the paths between components is part of the gap.
            let gap = gap.max(1.0 - largest / value);
            best = UpperBound { value, scalings, start: scalings_of(|bound| &bound.start), gap };
        }
        if best.value <= largest * (1.0 + BOUND_TOLERANCE) {
            break;
        }
    }
    if best.value.is_infinite() {
        return found(all, structure, options);
    }
    let undone = |scalings: &DgScalings| scalings.undone(&one, &one, entry);
    let (value, gap) = (best.value * entry, best.gap);
    UpperBound { value, scalings: undone(&best.scalings), start: undone(&best.start), gap }
}

/// Trial fractions of the bound allowed for the paths between components.
const COUPLINGS: [f64; 5] = [1e-2, 1e-3, 1e-4, 1e-6, 1e-8];

fn found(
    all: &[CMat],
    structure: &Structure,
    UpperBoundOptions { level, tight, from }: UpperBoundOptions,
) -> UpperBound {
    let entry = all.iter().flatten().map(|v| v.re.abs().max(v.im.abs())).fold(0.0, f64::max);
    if entry == 0.0 {
        return unscaled(structure, 0.0);
    }
    // Entries of about one: their squares neither vanish nor overflow.
    let units: Vec<CMat> = all.iter().map(|m| m.unscale(entry)).collect();
    let balance = Balance::new(&units, structure);
    let norm = |m: &CMat| complex_singular_values(m).first().copied().unwrap_or(f64::NAN);
    let largest = balance.matrices.iter().map(norm).fold(0.0, |a, b| if b > a || b.is_nan() { b } else { a });
    let size = entry * largest;
    let from = from.map(|known| known.redone(&balance.tw, &balance.tz, size));
    let scaled = balance.matrices.iter().map(|m| m.unscale(largest)).collect();
    let mut centre = Centre::new(scaled, structure, from.as_ref());
    let (lambda, gap) = centre.least((level / size).powi(2), tight);
    if !lambda.is_finite() {
        return unscaled(structure, entry * units.iter().map(|m| m.norm()).fold(0.0, f64::max));
    }
    let value = size * lambda.max(ZERO_MU * ZERO_MU).sqrt();
    // lambda = beta^2: half of its relative gap is that of beta.
    let gap = if lambda > ZERO_MU * ZERO_MU { 0.5 * gap / lambda } else { 0.0 };
    let undone = |p: &[f64]| centre.family.values(p).undone(&balance.tw, &balance.tz, size);
    UpperBound { value, scalings: undone(&centre.p), start: undone(&centre.start), gap }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::matrix::{Mat, hermitian_eigenvalues};
    use crate::mu::Block;
    use crate::mu::structure::random::problem;
    use nalgebra::{Complex, dmatrix};
    use proptest::prelude::*;

    /// Returns the least eigenvalue of `value^2 D - left`, its diagonal scaled to one.
    fn margin(bound: &UpperBound, value: f64, m: &CMat) -> f64 {
        let s = &bound.scalings;
        let phi = &s.dw * Complex::new(value * value, 0.0) - s.left(m);
        let scale: Vec<f64> = phi.diagonal().iter().map(|d| 1.0 / d.re.abs().sqrt()).collect();
        hermitian_eigenvalues(&CMat::from_fn(phi.nrows(), phi.ncols(), |i, j| {
            phi[(i, j)] * scale[i] * scale[j]
        }))[0]
    }

    fn largest_modulus(m: &CMat) -> f64 {
        m.clone().schur().eigenvalues().unwrap().iter().map(|v| v.norm()).fold(0.0, f64::max)
    }

    /// Matrices with zeros for which mu is the largest of the diagonal blocks, however large the entries on one side.
    #[test]
    fn one_way_paths_have_no_effect() {
        let of = |rows: &[[f64; 3]; 3], blocks: Vec<Block>| {
            let m = CMat::from_fn(3, 3, |i, j| Complex::new(rows[i][j], 0.0));
            upper_bound(&m, &Structure::new(blocks).unwrap()).unwrap().value
        };
        let above = [[0.5, 3.0, 7.0], [0.0, 0.25, 2.0], [0.0, 0.0, 0.125]];
        let below = [[0.5, 0.0, 0.0], [1e8, 0.25, 0.0], [0.0, 1e8, 0.125]];
        let nilpotent = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]];
        for blocks in [vec![Block::Real(1); 3], vec![Block::Complex(1), Block::Real(1), Block::Complex(1)]] {
            for m in [&above, &below] {
                let found = of(m, blocks.clone());
                assert!((0.5..0.5001).contains(&found), "{blocks:?} {found}");
            }
        }
        let structures = [vec![Block::Complex(3)], vec![Block::Real(1); 3]];
        for blocks in structures {
            let found = of(&nilpotent, blocks.clone());
            assert!(found < 1e-5, "{blocks:?} {found}");
        }
    }

    /// Three channels of one scalar in the direct term of P. Polcz's model LPV4D, github.com/ppolcz/LPV_L2: mu is 0.6,
    /// because p1 = -2 at theta = -5/3.
    #[test]
    fn channels_of_a_repeated_scalar_are_bounded_separately() {
        let m = dmatrix![-0.6, 0.0, 0.0; 0.0, 0.0, -0.6; 0.0, 0.0, -0.6].map(Complex::from);
        let bound = upper_bound(&m, &Structure::new(vec![Block::Real(3)]).unwrap()).unwrap();
        assert!((0.6..0.6001).contains(&bound.value), "{}", bound.value);
        assert!(margin(&bound, bound.value * (1.0 + 1e-6), &m) > -1e-9);
    }

    /// The bound of a zero matrix is zero, and that of joined parts is correct for parts of any size.
    #[test]
    fn joined_parts_may_be_small() {
        let structure = Structure::new(vec![Block::Complex(1), Block::Real(1)]).unwrap();
        assert_eq!(upper_bound(&CMat::zeros(2, 2), &structure).unwrap().value, 0.0);
        for size in [1e-300, 1.0, 1e90] {
            let m = dmatrix![0.5, 0.0; 3.0, 0.25].map(|v| Complex::new(v * size, 0.0));
            let found = upper_bound(&m, &structure).unwrap().value / size;
            assert!((0.5..0.5001).contains(&found), "{size} {found}");
        }
    }

    proptest! {
        /// mu of parts joined in one direction is the largest of theirs, and the combined scalings prove it.
        #[test]
        fn joined_parts_have_the_largest_bound((one, m) in problem(), (other, k) in problem(), gain in 0.1..10.0f64) {
            let blocks = one.blocks().iter().chain(other.blocks()).copied().collect();
            let joint = Structure::new(blocks).unwrap();
            let mut all = CMat::zeros(joint.cols(), joint.rows());
            all.view_mut((0, 0), m.shape()).copy_from(&m);
            all.view_mut(m.shape(), k.shape()).copy_from(&k);
            all.view_mut((m.nrows(), 0), (k.nrows(), m.ncols())).fill(Complex::new(gain, -gain));
            let largest = [(&m, &one), (&k, &other)].map(|(m, s)| upper_bound(m, s).unwrap().value);
            let largest = largest[0].max(largest[1]);
            let bound = upper_bound(&all, &joint).unwrap();
            let size = complex_singular_values(&all)[0];
            let off = (bound.value - largest).abs();
            prop_assert!(bound.gap <= 1e-3 || bound.value <= 1e-5 * size, "{} {largest}", bound.value);
            prop_assert!(off <= bound.gap.max(1e-4) * bound.value + 1e-6 * size, "{} {largest}", bound.value);
            if bound.value > 1e-3 * size {
                let margin = margin(&bound, bound.value * (1.0 + 1e-6), &all);
                prop_assert!(margin > -1e-9, "{margin}");
            }
        }
    }

    /// One real scalar on a complex entry: 1 - m delta is never zero, and scalings prove it.
    #[test]
    fn a_real_scalar_on_a_complex_entry_has_zero_mu() {
        let structure = Structure::new(vec![Block::Real(1)]).unwrap();
        for (re, im) in [(0.0, 1.0), (2.894, 5.655), (-42.449, -65.026), (-1e3, 1.0), (1.0, -0.1)] {
            let m = CMat::from_element(1, 1, Complex::new(re, im));
            let found = upper_bound(&m, &structure).unwrap().value;
            assert!(found <= 1e-6 * m.norm(), "{re} {im} {found}");
        }
    }

    /// mu of one repeated real scalar and a real matrix is its largest real eigenvalue, here 1, with a larger complex
    /// pair. The scalings reach it only in the limit, where rounding might take the bound below it.
    #[test]
    fn a_bound_in_the_limit_is_not_below_mu() {
        for (re, im, coupling) in [(-1.9, 1.1, 0.3), (0.2, 3.0, 0.3), (-1.2, 0.1, 0.1), (-1.0, 0.7, 1.0)] {
            let t =
                Mat::from_fn(3, 3, |i, j| if i == j { 1.0 } else { coupling * (i as f64 - 2.0 * j as f64) });
            let middle = dmatrix![re, im, 0.0; -im, re, 0.0; 0.0, 0.0, 1.0];
            let m = (&t * middle * t.clone().try_inverse().unwrap()).map(|v| Complex::new(v, 0.0));
            let found = upper_bound(&m, &Structure::new(vec![Block::Real(3)]).unwrap()).unwrap().value;
            assert!((1.0 - 1e-12..1.001).contains(&found), "{re} {im} {coupling}: {found}");
        }
    }

    /// A matrix for which a weight of lambda that grew while D was far from D_0 led along the boundary: the search got
    /// stuck there, at 0.256.
    #[test]
    fn a_search_does_not_get_stuck_along_the_boundary() {
        let of = |(re, im): (f64, f64)| Complex::new(re, im);
        let rows = [
            [(0.0, 0.0), (-15.29, -9.17), (-0.09, 0.12), (0.03, -0.01), (-2.84, -6.84)],
            [(-0.01, -0.01), (0.4, 1.8), (0.28, -0.11), (0.16, -0.02), (0.58, -1.46)],
            [(0.0, 0.0), (-0.58, -0.7), (-0.15, 0.29), (-0.02, 0.04), (0.31, 0.18)],
            [(0.0, 0.0), (-0.86, -5.24), (-0.15, 0.09), (-0.56, 0.36), (-1.0, -3.06)],
            [(0.0, 0.0), (2.19, -2.39), (-0.06, 0.69), (-0.49, -0.6), (-0.83, 0.73)],
        ];
        let m = CMat::from_fn(5, 5, |i, j| of(rows[i][j]));
        let structure = Structure::new(vec![Block::Real(3), Block::Real(2)]).unwrap();
        let mut least = upper_bound(&m, &structure).unwrap();
        let found = least.value;
        for _ in 0..4 {
            let again = UpperBoundOptions { from: Some(&least.scalings), ..UpperBoundOptions::default() };
            least = upper_bound_with(&m, &structure, again).unwrap();
        }
        assert!(found < 1.002 * least.value && found < 0.214, "{found} {}", least.value);
    }

    proptest! {
        /// mu scales with the matrix, from the smallest numbers to the largest.
        #[test]
        fn a_bound_scales_with_its_matrix((structure, m) in problem(), power in -1000..300i32) {
            let value = upper_bound(&m, &structure).unwrap().value;
            let factor = 2f64.powi(power);
            let found = upper_bound(&m.scale(factor), &structure).unwrap().value / factor;
            prop_assert!((found - value).abs() <= 2e-4 * value, "{found} {value}");
        }

        /// The returned scalings prove the bound, and it is at most the largest singular value.
        #[test]
        fn the_scalings_prove_the_bound((structure, m) in problem()) {
            let bound = upper_bound(&m, &structure).unwrap();
            let size = complex_singular_values(&m)[0];
            prop_assert!(bound.value <= size * (1.0 + 1e-6));
            if bound.value > 1e-3 * size {
                let margin = margin(&bound, bound.value * (1.0 + 1e-6), &m);
                prop_assert!(margin > -1e-9, "{margin}");
            }
        }

        /// mu of one full block is the largest singular value, of one repeated complex scalar the spectral radius; the
        /// bounds are tight there.
        #[test]
        fn one_block_has_a_closed_form((structure, m) in problem()) {
            let n = m.nrows().min(m.ncols());
            let full = Structure::new(vec![Block::Full { rows: m.ncols(), cols: m.nrows() }]).unwrap();
            let largest = complex_singular_values(&m)[0];
            let found = upper_bound(&m, &full).unwrap().value;
            prop_assert!((found - largest).abs() < 1e-4 * largest, "{found} {largest}");
            let square = m.view((0, 0), (n, n)).into_owned();
            let repeated = Structure::new(vec![Block::Complex(n)]).unwrap();
            let radius = largest_modulus(&square);
            let found = upper_bound(&square, &repeated).unwrap().value;
            prop_assert!(found >= radius * (1.0 - 1e-9) && found <= radius + 1e-3 * largest, "{found} {radius}");
            drop(structure);
        }

        /// Common scalings of two matrices prove the bound for either, which is at least the bound of each.
        #[test]
        fn common_scalings_prove_both_bounds((structure, m) in problem(), part in 0.0..1.0f64) {
            let turn = |j: usize| Complex::from_polar(1.0 - part, part + j as f64);
            let other = CMat::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)] * turn(j));
            let both = [m, other];
            let bound = common_bound(&both, &structure, UpperBoundOptions::default()).unwrap();
            for m in &both {
                let single = upper_bound(m, &structure).unwrap().value;
                prop_assert!(bound.value >= single * (1.0 - 1e-4), "{} {single}", bound.value);
                if bound.value > 1e-3 * complex_singular_values(m)[0] {
                    let margin = margin(&bound, bound.value * (1.0 + 1e-6), m);
                    prop_assert!(margin > -1e-9, "{margin}");
                }
            }
        }

        /// Scalings are found that hold at a level above the bound.
        #[test]
        fn a_level_above_the_bound_is_proved((structure, m) in problem(), above in 1.01..3.0f64) {
            let tight = upper_bound(&m, &structure).unwrap().value.max(1e-3);
            let at_level = UpperBoundOptions { level: above * tight, ..UpperBoundOptions::default() };
            let bound = upper_bound_with(&m, &structure, at_level).unwrap();
            prop_assert!(bound.value <= above * tight);
            prop_assert!(margin(&bound, above * tight, &m) > 0.0);
        }
    }

    /// Three scalars with D scalings are tight (A. Packard, J. C. Doyle, Automatica 29(1), 1993): the bound is the
    /// spectral radius at the worst phases.
    #[test]
    fn three_complex_scalars_are_tight() {
        let m = CMat::from_fn(3, 3, |i, j| {
            Complex::new((1.3 * (i + 2 * j) as f64).sin(), (0.7 * (3 * i + j) as f64).cos())
        });
        let structure = Structure::new(vec![Block::Complex(1); 3]).unwrap();
        let bound = upper_bound(&m, &structure).unwrap().value;
        let mut worst = 0.0f64;
        for a in 0..400 {
            for b in 0..400 {
                let phase = |k: i32| Complex::from_polar(1.0, f64::from(k) * std::f64::consts::TAU / 400.0);
                let u = CMat::from_diagonal(&nalgebra::dvector![Complex::new(1.0, 0.0), phase(a), phase(b)]);
                worst = worst.max(largest_modulus(&(&m * u)));
            }
        }
        assert!(worst <= bound && bound < worst * (1.0 + 1e-3), "{worst} {bound}");
    }
}
