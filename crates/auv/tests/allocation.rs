//! No step allocates, as counted by the allocator.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use allocation_counter::measure;
use squid_auv::{Current, Fidelity, Load, LpvModel, Plant, Pose, Speed, Water, WaterMotion, linearise, trim};
use std::sync::Arc;

#[derive(Debug)]
struct Swell;

impl Water for Swell {
    fn at(&self, time: f64, _: &Pose) -> WaterMotion {
        let velocity = Current { horizontal: 0.0, vertical: 0.1 * time.sin(), ..Current::default() };
        let by_time = Current { horizontal: 0.0, vertical: 0.1 * time.cos(), ..Current::default() };
        WaterMotion {
            velocity,
            by_time,
            load: [0.0, 1.0, 2.0 * time.cos(), 0.0, 0.0, 0.1],
            ..WaterMotion::default()
        }
    }

    fn load_slopes(&self, _: f64, _: &Pose) -> [Load; 7] {
        [[0.0; 6]; 7]
    }
}

#[test]
fn stepping_does_not_allocate() {
    assert_eq!(measure(|| drop(std::hint::black_box(vec![1]))).count_total, 1, "the allocator counts");

    let vehicle = common::squid();
    let trim = trim(&vehicle, Speed::Path(1.0), 50.0).unwrap();
    let linear = linearise(&vehicle, &trim).unwrap();
    let model =
        LpvModel::new("squid", 50.0, (1.75, 1.25), &[linear.a], &[linear.b], std::slice::from_ref(&trim))
            .unwrap();
    let mut plant = Plant::new(&vehicle).unwrap().with_lpv(model).unwrap().with_water(Arc::new(Swell));
    for fidelity in [Fidelity::Nonlinear, Fidelity::Lpv] {
        plant.set_fidelity(fidelity).unwrap();
        plant.start(0.0, &trim).unwrap();
        let flight = measure(|| {
            for i in 1..=1000 {
                let time = f64::from(i) * 0.01;
                plant.set_command(0, 5.0 + time).unwrap();
                plant.set_operating_speed(1.0 + 0.1 * time).unwrap();
                plant
                    .set_current(Current {
                        horizontal: 0.2 * time.sin(),
                        vertical: 0.0,
                        ..Current::default()
                    })
                    .unwrap();
                plant.advance(time).unwrap();
            }
        });
        assert_eq!(flight.count_total, 0, "{fidelity:?}");
        assert!((plant.state().motion.theta - trim.pitch).abs() > 0.01, "the vehicle must have moved");
    }
}
