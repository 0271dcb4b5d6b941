//! Comparison of the plant of a certificate with the recomputed one.
//!
//! Both are LFTs in rho. The basis of an LFT's channels is not unique, so they are compared as rational functions of
//! rho. If their poles are outside the range (see [`check`]), two such functions that agree at thousands of points
//! agree between them.

use crate::claim::blocks_of;
use crate::error::ProofError;
use squid_certificate::Plant;
use squid_lpv::matrix::{Mat, eigenvalues, from_rows, largest};
use squid_lpv::partition::{Group, PLANT, names};
use squid_lpv::plant::GeneralisedPlant;
use squid_lpv::robust::UncertainPlant;

/// Relative tolerance between the plant of a certificate and the recomputed one, for rounding on another processor.
const SAME_PLANT: f64 = 1e-8;

/// Relative tolerance by which the box of a certificate may exceed the declared one, for rounding on another processor.
const SAME_BOX: f64 = 1e-6;

/// Number of values of rho at which the plants are compared.
const POINTS: u32 = 4001;

/// Number of points in a box of several parameters at which the plants are compared.
const BOX_POINTS: u32 = 101;

/// Smallest modulus of a pole of the plant in rho, whose range is -1 to 1; it rules out peaks between the values at
/// which the plants are compared: see [`check`].
pub const NEAREST_POLE: f64 = 1.1;

/// Modulus up to which eigenvalues of Dtt are always allowed; their reciprocals are the poles in rho. A polynomial in
/// rho has a nilpotent Dtt, and the fit of the slope of the trim has no pole nearer than this. The reduction of
/// channels perturbs the eigenvalues of a polynomial to 0.01 for a low order, and up to 0.6 for the highest. If the
/// recomputed plant has larger eigenvalues, they set the limit.
const LARGEST_MODULUS: f64 = 1.0 / NEAREST_POLE;

/// Compares the plant of a certificate with `expected`, at 4001 values of rho in \[-1, 1\].
///
/// A function with all poles beyond 1.1 is, within 1e-10 of its size, a polynomial in rho of degree d = 52 (Bernstein's
/// ellipse; L. N. Trefethen, Approximation Theory and Approximation Practice, 2013, theorem 8.2). Between points h =
/// 0.0005 apart a polynomial rises by a factor of at most `1/(1 - d^2 h/2)` (the Markov brothers' inequality), that is
/// 3.1.
///
/// # Errors
/// [`ProofError::WrongPlant`] with the first part that differs or is not finite; [`ProofError::System`].
pub fn check(plant: &Plant, blocks: &[usize], expected: &GeneralisedPlant) -> Result<(), ProofError> {
    let certified = plant_with(plant, blocks, &expected.blocks)?;
    let modulus = |plant: &GeneralisedPlant| largest(0.0, eigenvalues(&plant.dtt()).iter().map(|v| v.norm()));
    let (modulus_found, modulus_expected) = (modulus(&certified), modulus(expected));
    if modulus_found.is_nan() || modulus_found > LARGEST_MODULUS.max(1.01 * modulus_expected) {
        let what = format!(
            "Dtt (with an eigenvalue of modulus {modulus_found:.2e} instead of {modulus_expected:.2e})"
        );
        return Err(wrong_plant(what));
    }
    let points = (0..POINTS).map(|k| vec![2.0 * f64::from(k) / f64::from(POINTS - 1) - 1.0]);
    compare(&certified, expected, points)
}

/// Compares the plant of a certificate that depends on several parameters with `expected`, at values spread over the
/// box. This detects a plant of another vehicle or uncertainty, but not a difference deliberately hidden between the
/// values.
///
/// # Errors
/// Same as [`check`].
pub fn check_in_box(plant: &Plant, blocks: &[usize], expected: &GeneralisedPlant) -> Result<(), ProofError> {
    let certified = plant_with(plant, blocks, &expected.blocks)?;
    compare(&certified, expected, in_box(expected.blocks.len()))
}

/// Returns the fraction of the declared uncertainty for which a plant is the recomputed one; `all` is the plant for the
/// full uncertainty. The rows of zt of the uncertain parameters are proportional to that fraction.
///
/// # Errors
/// [`ProofError::WrongPlant`] if there is no such fraction, and those of [`check_in_box`].
pub fn fraction_of(plant: &Plant, blocks: &[usize], all: &UncertainPlant) -> Result<f64, ProofError> {
    let found = plant_with(plant, blocks, &all.plant.blocks)?;
    let size =
        |plant: &GeneralisedPlant| plant.ct().rows(all.scheduled_channels(), all.unknown_channels()).norm();
    let fraction = size(&found) / size(&all.plant);
    if !(0.0..=1.0 + SAME_BOX).contains(&fraction) {
        return Err(wrong_plant("the size of the uncertainty".to_owned()));
    }
    check_in_box(plant, blocks, &all.sized(fraction))?;
    Ok(fraction)
}

/// Compares the direct path from u to y of a certificate, or 0 if it has none, with `expected`.
///
/// # Errors
/// [`ProofError::WrongPlant`].
pub fn check_direct_path(plant: &Plant, expected: &Mat) -> Result<(), ProofError> {
    let (rows, columns) = expected.shape();
    let found = match plant.direct_path() {
        Some(given) => from_rows(given, columns),
        None => Some(Mat::zeros(rows, columns)),
    };
    if found.is_some_and(|found| alike(expected, &found)) {
        Ok(())
    } else {
        Err(wrong_plant("D22".to_owned()))
    }
}

/// Returns points spread evenly over the box: multiples of the square roots of primes, modulo 1 (H. Weyl, Math. Annalen
/// 77, 1916).
fn in_box(parameters: usize) -> impl Iterator<Item = Vec<f64>> {
    let is_prime = |n: &u32| (2..*n).take_while(|d| d * d <= *n).all(|d| !n.is_multiple_of(d));
    let primes: Vec<f64> = (2..).filter(is_prime).take(parameters).map(f64::from).collect();
    (1..=BOX_POINTS)
        .map(move |k| primes.iter().map(|p| 2.0 * (f64::from(k) * p.sqrt()).fract() - 1.0).collect())
}

fn compare(
    found: &GeneralisedPlant,
    expected: &GeneralisedPlant,
    points: impl Iterator<Item = Vec<f64>>,
) -> Result<(), ProofError> {
    for theta in points {
        let (a, b) = (expected.frozen(&theta)?, found.frozen(&theta)?);
        let differs = |(_, row, column): &(&str, Group, Group)| {
            !alike(&a.parts.block(*row, *column), &b.parts.block(*row, *column))
        };
        if let Some((name, _, _)) = names(PLANT).find(differs) {
            return Err(wrong_plant(format!("matrix {name} at rho = {:.3}", theta[0])));
        }
    }
    Ok(())
}

fn wrong_plant(what: String) -> ProofError {
    ProofError::WrongPlant { what }
}

/// Returns `true` if all entries agree to rounding, `false` if any is not finite.
fn alike(expected: &Mat, found: &Mat) -> bool {
    expected.shape() == found.shape()
        && found.iter().all(|v| v.is_finite())
        && (expected - found).amax() <= SAME_PLANT * expected.amax().max(1.0)
}

/// Returns the plant of a certificate, after a check that it has the `expected` channels.
///
/// # Errors
/// [`ProofError::WrongPlant`] if its shapes do not fit or it has other channels; [`ProofError::System`].
pub fn plant_with(
    plant: &Plant,
    blocks: &[usize],
    expected: &[usize],
) -> Result<GeneralisedPlant, ProofError> {
    if plant.direct_path().is_some() {
        return Err(wrong_plant("D22 (which is zero for a vehicle)".into()));
    }
    let parts =
        blocks_of(PLANT, &plant.named()).ok_or_else(|| wrong_plant("the shape of a matrix".into()))?;
    let certified = GeneralisedPlant::new(blocks.to_vec(), &parts)?;
    if certified.blocks == expected {
        Ok(certified)
    } else {
        Err(wrong_plant("the number of channels".into()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_fill_box() {
        let points: Vec<Vec<f64>> = in_box(3).collect();
        assert_eq!(points.len(), BOX_POINTS as usize);
        for corner in 0..8 {
            let inside = |p: &&Vec<f64>| (0..3).all(|i| (p[i] > 0.0) == (corner >> i & 1 == 1));
            assert!((5..25).contains(&points.iter().filter(inside).count()), "octant {corner}");
        }
    }
}
