//! Plants of certificates against those of vehicles.

use crate::designs::read;
use squid_design::augment::augment;
use squid_design::fit::Model;
use squid_lpv::partition::Group::{T, X};
use squid_lpv::plant::GeneralisedPlant;
use squid_proof::claim::plant_rows;
use squid_proof::error::ProofError;
use squid_proof::same_plant::check;

/// The plant of Squid with a polynomial of this order.
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

fn check_of(found: &GeneralisedPlant, wanted: &GeneralisedPlant) -> Result<(), ProofError> {
    check(&plant_rows(found), &found.blocks, wanted)
}

fn refusal(found: &GeneralisedPlant, wanted: &GeneralisedPlant) -> String {
    check_of(found, wanted).unwrap_err().to_string()
}

#[test]
fn plants_of_every_order_are_like_themselves() {
    for order in 1..=5 {
        let plant = squid(order);
        check_of(&plant, &plant).unwrap();
    }
}

#[test]
fn another_plant_is_detected() {
    let wanted = squid(2);
    let mut near = wanted.clone();
    near.parts.block_mut(X, X)[(1, 2)] += 1e-12;
    check_of(&near, &wanted).unwrap();
    near.parts.block_mut(X, X)[(1, 2)] += 1e-6;
    assert!(refusal(&near, &wanted).contains("matrix A at rho = -1.000"));
    assert!(refusal(&squid(1), &wanted).contains("the number of channels"));
    let mut turned = wanted.clone();
    turned.parts.rows_mut(T).neg_mut();
    turned.parts.columns_mut(T).neg_mut();
    check_of(&turned, &wanted).expect("the same plant in other channels");
}

#[test]
fn a_direct_path_is_not_of_a_vehicle() {
    let wanted = squid(2);
    let (mut plant, sizes) = (plant_rows(&wanted), wanted.sizes());
    plant.d22 = vec![vec![0.0; sizes.u]; sizes.y];
    check(&plant, &wanted.blocks, &wanted).unwrap();
    plant.d22[1][0] = 1e-300;
    assert!(check(&plant, &wanted.blocks, &wanted).unwrap_err().to_string().contains("D22"));
}

/// NaN differs from everything.
#[test]
fn overflow_is_no_agreement() {
    let wanted = squid(2);
    let mut found = wanted.clone();
    let mut dtt = found.parts.block_mut(T, T);
    dtt.fill(0.0);
    (dtt[(0, 1)], dtt[(1, 2)]) = (1e200, 1e200);
    found.parts.block_mut(X, T)[(0, 0)] = 1e300;
    let message = refusal(&found, &wanted);
    assert!(message.contains("matrix A") || message.contains("well posed"), "{message}");
}

/// A pole between two points could hide a difference there.
#[test]
fn a_pole_nearby_is_refused() {
    let wanted = squid(2);
    let mut found = wanted.clone();
    found.parts.block_mut(T, T)[(0, 0)] += 0.95;
    assert!(refusal(&found, &wanted).contains("an eigenvalue of modulus"));
}
