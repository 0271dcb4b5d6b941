//! The ladder of gammas on published plants with one parameter.

use crate::common;

use squid_lpv::error::SystemError;
use squid_lpv::ladder::{Ladder, LadderOptions, ladder};
use squid_lpv::partition::Group;
use squid_lpv::plant::GeneralisedPlant;
use squid_lpv::synthesis::{Options, synthesise};

fn climb(plant: &GeneralisedPlant) -> Ladder {
    let design = synthesise(plant, Options::default()).unwrap();
    let options = LadderOptions { rates: vec![10.0, 0.1, 1.0], ..LadderOptions::default() };
    let found = ladder(plant, &design.controller, design.certified.gamma, &options).unwrap();
    for (theta, gamma) in &found.frozen_optimum {
        println!("best at theta = {theta}: {:.5}", gamma.as_ref().unwrap());
    }
    let (scheduled, symmetric) =
        (found.scheduled.as_ref().unwrap(), found.scheduled_symmetric.as_ref().unwrap());
    println!("scheduled {scheduled:.5}, S alone {symmetric:.5}");
    println!("frozen gain {:.5} at theta = {}", found.frozen_gain.gamma, found.frozen_gain.theta);
    for (rate, bound) in &found.bounded_rate {
        println!("rate {rate}: {:.5}", bound.as_ref().unwrap().gamma);
    }
    println!("arbitrarily fast {:.5}", found.arbitrarily_fast.as_ref().unwrap().gamma);
    println!("certified {:.5}", found.certified);
    assert_eq!(found.disorders(), vec![]);
    // The gains of the closed loop are the same from the Lyapunov matrix of the certificate.
    let options = LadderOptions { lyapunov: Some(design.certified.x.clone()), ..options };
    let again = ladder(plant, &design.controller, design.certified.gamma, &options).unwrap();
    let gains = |of: &Ladder| {
        let slow = of.bounded_rate.iter().map(|(_, bound)| bound.as_ref().unwrap().gamma);
        slow.chain([of.arbitrarily_fast.as_ref().unwrap().gamma]).collect::<Vec<f64>>()
    };
    for (one, other) in gains(&found).into_iter().zip(gains(&again)) {
        assert!((one / other - 1.0).abs() < 2e-3, "{one} {other}");
    }
    assert!(found.bounded_rate.windows(2).all(|pair| pair[0].0 < pair[1].0), "rates ascend");
    found
}

#[test]
fn the_lpvtools_tutorial_has_its_published_gains() {
    let case = common::case("lpv01_lpvtools_lft_tutorial");
    let (expected, found) = (&case["expected"], climb(&common::plant(&case)));
    let largest = found.frozen_optimum.iter().map(|(_, g)| *g.as_ref().unwrap()).fold(0.0, f64::max);
    // The published frozen optimum is given to five digits.
    assert!((largest / expected["frozen_max"].as_f64().unwrap() - 1.0).abs() < 1e-3, "{largest}");
    let optimum = expected["gamma_opt"].as_f64().unwrap();
    assert!((found.scheduled.unwrap() / optimum - 1.0).abs() < expected["rtol"].as_f64().unwrap());
    // Scheduling and fast parameters have a cost here.
    assert!(largest < 0.9 * optimum);
    assert!(found.frozen_gain.gamma < found.arbitrarily_fast.unwrap().gamma);
}

#[test]
fn a_plant_with_one_repeated_parameter_has_a_ladder() {
    let case = common::case("lpv05_one_param_lossless");
    let expected = &case["expected"];
    let rtol = expected["rtol"].as_f64().unwrap();
    let list = |key: &str| -> Vec<f64> { serde_json::from_value(expected[key].clone()).unwrap() };
    let mut plant = common::plant(&case);
    plant.parts.block_mut(Group::X, Group::T).scale_mut(2.0);
    let found = climb(&plant);
    assert!((found.scheduled.unwrap() / list("gamma_S_T")[2] - 1.0).abs() < rtol);
    assert!((found.scheduled_symmetric.unwrap() / list("gamma_S_only")[2] - 1.0).abs() < rtol);
}

#[test]
fn plants_without_a_ladder_are_rejected() {
    let plant = common::plant(&common::case("lpv05_one_param_lossless"));
    let design = synthesise(&plant, Options::default()).unwrap();
    let usual = LadderOptions { thetas: vec![], rates: vec![], ..LadderOptions::default() };
    let refused = |plant: &GeneralisedPlant, options: &LadderOptions| {
        ladder(plant, &design.controller, design.certified.gamma, options).unwrap_err()
    };
    let two = GeneralisedPlant { blocks: vec![1, 1], ..plant.clone() };
    assert_eq!(refused(&two, &usual), SystemError::NotOneParameter { found: 2 });
    let outside = LadderOptions { thetas: vec![1.5], ..usual.clone() };
    assert_eq!(refused(&plant, &outside), SystemError::OutsideTheBox { theta: 1.5 });
    let few = LadderOptions { samples: 1, ..usual };
    assert_eq!(refused(&plant, &few), SystemError::TooFewPoints { found: 1 });
}
