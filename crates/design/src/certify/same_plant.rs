//! Whether the plant of a certificate is the one that vehicle and design file make.
//!
//! Both are LFTs in rho, and the basis of an LFT's channels is not unique, so that they are compared as what they
//! are: rational functions of rho. With their poles far outside the range (see [`check`]) two such functions that
//! agree at thousands of points agree between them.

use crate::error::{Error, ProofError};
use certificate::Certificate;
use lpv::matrix::{Mat, eigenvalues, from_rows, largest};
use lpv::plant::GeneralisedPlant;

/// How far the plant of a certificate may be from the one computed anew: rounding on another processor.
const SAME_PLANT: f64 = 1e-8;

/// Values of rho at which the two are compared.
const POINTS: u32 = 4001;

/// Values of several parameters at which the two are compared.
const IN_BOX: u32 = 101;

/// The largest modulus of an eigenvalue of Dtt that is thought nothing of: poles in rho are their reciprocals, two or
/// more from the middle of the range. A polynomial in rho, which is what is fitted, has a nilpotent Dtt; what the
/// reduction of its channels leaves out gives it eigenvalues of 0.01 for a low order, and up to 0.6 for the highest,
/// which is then the limit.
const FARTHEST: f64 = 0.5;

/// Compares the plant of a certificate with `wanted`, at 4001 values of rho in \[-1, 1\].
///
/// A function with all poles beyond 2 is a polynomial of rho of degree d = 32 to within 1e-18 of its size
/// (Bernstein's ellipse; L. N. Trefethen, Approximation Theory and Approximation Practice, 2013, theorem 8.2), and
/// between points that are h = 0.0005 apart a polynomial rises by a factor of `1/(1 - d^2 h/2)` at most (the Markov
/// brothers' inequality), that is 1.4.
///
/// # Errors
/// [`ProofError::WrongPlant`] with the first part that differs or is not finite;
/// [`ModelError::Shape`](crate::error::ModelError::Shape), [`ModelError::Lft`].
pub fn check(certificate: &Certificate, wanted: &GeneralisedPlant) -> Result<(), Error> {
    let found = plant_with(certificate, &wanted.blocks)?;
    let modulus = |plant: &GeneralisedPlant| largest(0.0, eigenvalues(&plant.dtt).iter().map(|v| v.norm()));
    let (here, there) = (modulus(&found), modulus(wanted));
    if here.is_nan() || here > FARTHEST.max(1.01 * there) {
        let what = format!("Dtt, with an eigenvalue of modulus {here:.2e} in place of {there:.2e},");
        return Err(wrong(what).into());
    }
    let points = (0..POINTS).map(|k| vec![2.0 * f64::from(k) / f64::from(POINTS - 1) - 1.0]);
    compare(&found, wanted, points)
}

/// Compares the plant of a certificate that depends on several parameters with `wanted`: at values spread over the
/// box, of which there can never be enough. What was made for another vehicle or size is noticed; what somebody hides
/// between them is not.
///
/// # Errors
/// As [`check`].
pub fn check_in_box(certificate: &Certificate, wanted: &GeneralisedPlant) -> Result<(), Error> {
    let found = plant_with(certificate, &wanted.blocks)?;
    compare(&found, wanted, in_box(wanted.blocks.len()))
}

/// Points spread evenly over the box: multiples of the square roots of primes, modulo 1 (H. Weyl, Math. Annalen 77,
/// 1916).
fn in_box(parameters: usize) -> impl Iterator<Item = Vec<f64>> {
    let is_prime = |n: &u32| (2..*n).take_while(|d| d * d <= *n).all(|d| !n.is_multiple_of(d));
    let primes: Vec<f64> = (2..).filter(is_prime).take(parameters).map(f64::from).collect();
    (1..=IN_BOX).map(move |k| primes.iter().map(|p| 2.0 * (f64::from(k) * p.sqrt()).fract() - 1.0).collect())
}

fn compare(
    found: &GeneralisedPlant,
    wanted: &GeneralisedPlant,
    points: impl Iterator<Item = Vec<f64>>,
) -> Result<(), Error> {
    for theta in points {
        let (a, b) = (wanted.frozen(&theta)?, found.frozen(&theta)?);
        let pairs = [
            ("A", a.a, b.a),
            ("B1", a.b1, b.b1),
            ("B2", a.b2, b.b2),
            ("C1", a.c1, b.c1),
            ("D11", a.d11, b.d11),
            ("D12", a.d12, b.d12),
            ("C2", a.c2, b.c2),
            ("D21", a.d21, b.d21),
        ];
        if let Some((name, _, _)) = pairs.iter().find(|(_, p, q)| !alike(p, q)) {
            return Err(wrong(format!("matrix {name} at rho = {:.3}", theta[0])).into());
        }
    }
    Ok(())
}

fn wrong(what: String) -> ProofError {
    ProofError::WrongPlant { what }
}

/// Whether all entries are the same but for rounding; what is not finite is like nothing.
fn alike(wanted: &Mat, found: &Mat) -> bool {
    wanted.shape() == found.shape()
        && found.iter().all(|v| v.is_finite())
        && (wanted - found).amax() <= SAME_PLANT * wanted.amax().max(1.0)
}

/// The plant of a certificate, with the channels that it should have.
fn plant_with(certificate: &Certificate, blocks: &[usize]) -> Result<GeneralisedPlant, Error> {
    if certificate.plant.direct_path().is_some() {
        return Err(wrong("D22, which a vehicle does not have,".into()).into());
    }
    let found = plant_of(certificate).ok_or_else(|| wrong("the shape of a matrix".into()))?;
    found.check()?;
    if found.blocks == blocks { Ok(found) } else { Err(wrong("the number of channels".into()).into()) }
}

/// The plant of a certificate; `None` when its matrices are ragged.
fn plant_of(certificate: &Certificate) -> Option<GeneralisedPlant> {
    let p = &certificate.plant;
    let (n, w, u) = (p.a.len(), p.b1.first()?.len(), p.b2.first()?.len());
    let r = certificate.blocks.iter().sum();
    Some(GeneralisedPlant {
        a: from_rows(&p.a, n)?,
        bt: from_rows(&p.bt, r)?,
        b1: from_rows(&p.b1, w)?,
        b2: from_rows(&p.b2, u)?,
        ct: from_rows(&p.ct, n)?,
        dtt: from_rows(&p.dtt, r)?,
        dt1: from_rows(&p.dt1, w)?,
        dt2: from_rows(&p.dt2, u)?,
        c1: from_rows(&p.c1, n)?,
        d1t: from_rows(&p.d1t, r)?,
        d11: from_rows(&p.d11, w)?,
        d12: from_rows(&p.d12, u)?,
        c2: from_rows(&p.c2, n)?,
        d2t: from_rows(&p.d2t, r)?,
        d21: from_rows(&p.d21, w)?,
        blocks: certificate.blocks.clone(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::augment::augment;
    use crate::certify::plant_rows;
    use crate::fit::Model;
    use crate::inputs::Inputs;
    use std::path::Path;

    /// The plant of Squid with a polynomial of this order.
    fn squid(order: usize) -> GeneralisedPlant {
        let vehicle = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../vehicles/squid"));
        let mut inputs = Inputs::read(vehicle, "design").unwrap();
        inputs.design.order = order;
        augment(
            &inputs.vehicle.actuators,
            &inputs.design,
            Model::new(&inputs.vehicle, &inputs.design).unwrap().lft,
        )
        .unwrap()
    }

    /// A certificate with this plant: the rest is not looked at.
    fn of(plant: &GeneralisedPlant) -> Certificate {
        Certificate {
            blocks: plant.blocks.clone(),
            controller_blocks: vec![],
            plant: plant_rows(plant),
            controller: certificate::Controller::default(),
            gamma: 1.0,
            x: vec![],
            s: vec![],
            t: vec![],
            residual: None,
        }
    }

    fn refusal(found: &GeneralisedPlant, wanted: &GeneralisedPlant) -> String {
        check(&of(found), wanted).unwrap_err().to_string()
    }

    #[test]
    fn plants_of_every_order_are_like_themselves() {
        for order in 1..=5 {
            let plant = squid(order);
            check(&of(&plant), &plant).unwrap();
        }
    }

    #[test]
    fn another_plant_is_told() {
        let wanted = squid(2);
        let mut near = wanted.clone();
        near.a[(1, 2)] += 1e-12;
        check(&of(&near), &wanted).unwrap();
        near.a[(1, 2)] += 1e-6;
        assert!(refusal(&near, &wanted).contains("matrix A at rho = -1.000"));
        assert!(refusal(&squid(1), &wanted).contains("the number of channels"));
        let mut turned = wanted.clone();
        for m in [&mut turned.ct, &mut turned.dtt, &mut turned.dt1, &mut turned.dt2] {
            m.neg_mut();
        }
        for m in [&mut turned.bt, &mut turned.dtt, &mut turned.d1t, &mut turned.d2t] {
            m.neg_mut();
        }
        check(&of(&turned), &wanted).expect("the same plant in other channels");
    }

    #[test]
    fn a_direct_path_is_not_of_a_vehicle() {
        let wanted = squid(2);
        let mut certificate = of(&wanted);
        let sizes = wanted.sizes();
        certificate.plant.d22 = vec![vec![0.0; sizes.u]; sizes.y];
        check(&certificate, &wanted).unwrap();
        certificate.plant.d22[1][0] = 1e-300;
        assert!(check(&certificate, &wanted).unwrap_err().to_string().contains("D22"));
    }

    /// What is no number compares like nothing, and not like everything.
    #[test]
    fn overflow_is_no_agreement() {
        let wanted = squid(2);
        let mut found = wanted.clone();
        found.dtt.fill(0.0);
        (found.dtt[(0, 1)], found.dtt[(1, 2)], found.bt[(0, 0)]) = (1e200, 1e200, 1e300);
        let told = refusal(&found, &wanted);
        assert!(told.contains("matrix A") || told.contains("well posed"), "{told}");
    }

    /// A pole between two points could hide anything there.
    #[test]
    fn a_pole_nearby_is_refused() {
        let wanted = squid(2);
        let mut found = wanted.clone();
        found.dtt[(0, 0)] += 0.9;
        assert!(refusal(&found, &wanted).contains("an eigenvalue of modulus"));
    }

    #[test]
    fn points_fill_the_box() {
        let points: Vec<Vec<f64>> = in_box(3).collect();
        assert_eq!(points.len(), IN_BOX as usize);
        for corner in 0..8 {
            let inside = |p: &&Vec<f64>| (0..3).all(|i| (p[i] > 0.0) == (corner >> i & 1 == 1));
            assert!((5..25).contains(&points.iter().filter(inside).count()), "octant {corner}");
        }
    }
}
