//! Steps of the plant do not allocate, verified with a counting allocator.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use allocation_counter::measure;
use squid_auv::Fidelity;
use squid_fmi2::{Model, Silent};
use squid_fmu_plant::PlantModel;

#[test]
fn stepping_does_not_allocate() {
    assert_eq!(measure(|| drop(std::hint::black_box(vec![1]))).count_total, 1, "the allocator counts");

    for fidelity in [Fidelity::Nonlinear, Fidelity::Lpv] {
        let mut plant = PlantModel::load(&common::squid()).unwrap();
        plant.settings.fidelity = fidelity;
        plant.initialise(0.0, &mut Silent).unwrap();
        let flight = measure(|| {
            for k in 1..=1000 {
                let time = f64::from(k) * 0.01;
                plant.inputs.commands[0] = 15.0 + time;
                plant.inputs.operating_speed = 1.75 + 0.1 * time;
                plant.inputs.current.horizontal = 0.2 * time.sin();
                plant.step(time - 0.01, time, &mut Silent).unwrap();
            }
        });
        assert_eq!(flight.count_total, 0, "{fidelity:?}");
        assert!(
            (plant.state().motion.theta - plant.trim().pitch).abs() > 0.01,
            "the vehicle must have moved"
        );
    }
}
