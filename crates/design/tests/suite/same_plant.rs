//! Plants of certificates against those of vehicles.

use crate::designs::read;
use squid_design::augment::augment;
use squid_design::fit::Model;
use squid_lpv::partition::Group::{T, X};
use squid_lpv::plant::GeneralisedPlant;
use squid_proof::claim::plant_rows;
use squid_proof::error::ProofError;
use squid_proof::same_plant::check;

/// Plant of Squid with a polynomial of this order.
fn squid(order: usize) -> GeneralisedPlant {
    let mut inputs = read("squid", "design");
    inputs.design.order = order;
    augment(
        &inputs.vehicle.actuators,
        &inputs.design,
        Model::new(&inputs.axis(), &inputs.design).unwrap().linear(),
    )
    .unwrap()
}

fn check_of(found: &GeneralisedPlant, expected: &GeneralisedPlant) -> Result<(), ProofError> {
    check(&plant_rows(found), &found.blocks, expected)
}

/// Returns what differs between the plants.
fn difference(found: &GeneralisedPlant, expected: &GeneralisedPlant) -> String {
    let error = check_of(found, expected).unwrap_err();
    let ProofError::WrongPlant { what } = error else { panic!("{error}") };
    what
}

#[test]
fn accepts_same_plant_of_every_order() {
    for order in 1..=5 {
        let plant = squid(order);
        check_of(&plant, &plant).unwrap();
    }
}

#[test]
fn detects_another_plant() {
    let expected = squid(2);
    let mut near = expected.clone();
    near.parts.block_mut(X, X)[(1, 2)] += 1e-12;
    check_of(&near, &expected).unwrap();
    near.parts.block_mut(X, X)[(1, 2)] += 1e-6;
    let differences = [difference(&near, &expected), difference(&squid(1), &expected)];
    insta::assert_snapshot!(differences.join("\n\n"));
    let mut turned = expected.clone();
    turned.parts.rows_mut(T).neg_mut();
    turned.parts.columns_mut(T).neg_mut();
    check_of(&turned, &expected).expect("the same plant in other channels");
}

#[test]
fn rejects_direct_path() {
    let expected = squid(2);
    let (mut plant, sizes) = (plant_rows(&expected), expected.sizes());
    plant.d22 = vec![vec![0.0; sizes.u]; sizes.y];
    check(&plant, &expected.blocks, &expected).unwrap();
    plant.d22[1][0] = 1e-300;
    assert!(check(&plant, &expected.blocks, &expected).unwrap_err().to_string().contains("D22"));
}

/// NaN differs from everything.
#[test]
fn rejects_overflow() {
    let expected = squid(2);
    let mut found = expected.clone();
    let mut dtt = found.parts.block_mut(T, T);
    dtt.fill(0.0);
    (dtt[(0, 1)], dtt[(1, 2)]) = (1e200, 1e200);
    found.parts.block_mut(X, T)[(0, 0)] = 1e300;
    assert!(check_of(&found, &expected).is_err());
}

/// A pole between two points could hide a difference there.
#[test]
fn rejects_pole_near_range() {
    let expected = squid(2);
    let mut found = expected.clone();
    found.parts.block_mut(T, T)[(0, 0)] += 0.95;
    assert!(difference(&found, &expected).starts_with("Dtt"));
}
